//! Recipes: how strips are computed for a measurement, in the flags of the command.

use clap::Parser;
use tristrip::StripifyOptions;

use crate::failure::Failure;
use crate::method::MethodArgs;

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

#[derive(Debug, Parser)]
struct RecipeFlags {
    #[command(flatten)]
    method: MethodArgs,
}

/// Parses flags of `tristrip strip` into options.
pub(crate) fn parse_flags(flags: &str) -> Result<StripifyOptions, Failure> {
    let words = std::iter::once("tristrip").chain(flags.split_whitespace());
    let flags = RecipeFlags::try_parse_from(words).map_err(|error| Failure::Input(error.to_string()))?;
    flags.method.validate(false).map_err(Failure::Input)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_are_those_of_the_command() {
        assert!(parse_flags("--method eta --start input").is_ok());
        assert!(parse_flags("--method sgi --start input").is_err());
        assert!(parse_flags("--colour red").is_err());
    }
}
