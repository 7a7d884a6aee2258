//! Recipes: how strips are computed for a measurement, in the flags of the command.

/// How strips are computed: flags of `tristrip strip`, and the number of node accesses after which a search is stopped.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Recipe {
    pub(crate) flags: String,
    pub(crate) steps: Option<u64>,
}

impl From<&str> for Recipe {
    fn from(flags: &str) -> Self {
        Self { flags: flags.into(), steps: None }
    }
}
