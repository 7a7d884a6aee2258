//! Recipes: how strips are built for a measurement, as flags of the command.

use tristrip::Error;
use tristrip_pipeline::{levels, parse_method};

/// How strips are built: flags of `tristrip strip`, and the number of node accesses after which a
/// search is stopped.
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

/// Parses the flags of a recipe: `--method METHOD`, and `--price PRICE` for the collapses of
/// levels.
pub(crate) fn parse_flags(flags: &str) -> Result<levels::Options, Error> {
    let words: Vec<&str> = flags.split_whitespace().collect();
    let mut options = levels::Options::default();
    for pair in words.chunks(2) {
        options = match pair {
            ["--method", method] => options.with_stripify(parse_method(method)?),
            ["--price", price] => options.with_price(price.parse()?),
            _ => {
                let expected = "`--method METHOD` and `--price PRICE`";
                return Err(Error::Parameter { name: "flags", found: format!("`{flags}`"), expected });
            }
        };
    }
    Ok(options)
}
