//! How levels of detail are built.

use tristrip::StripifyOptions;
use tristrip::simplify::Price;

use crate::goal::Ratio;
use crate::method::parse_with_price;

/// How levels of detail are built. The base mesh of the default is what the surface allows; everything is proven.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct LevelsOptions {
    /// The method of the strips of the full mesh, and its options.
    pub stripify: StripifyOptions,
    /// The ratio of triangles that the base mesh keeps.
    pub base: Ratio,
    /// What a collapse costs.
    pub price: Price,
    /// Whether strips and levels are proven.
    pub verify: bool,
}

impl Default for LevelsOptions {
    fn default() -> Self {
        let (stripify, price) = (StripifyOptions::default(), Price::default());
        Self { stripify, base: Ratio::ZERO, price, verify: true }
    }
}

impl LevelsOptions {
    /// Sets the method of the strips of the full mesh.
    #[must_use]
    pub fn with_stripify(self, stripify: StripifyOptions) -> Self {
        Self { stripify, ..self }
    }

    /// Sets the ratio of triangles that the base mesh keeps.
    #[must_use]
    pub fn with_base(self, base: Ratio) -> Self {
        Self { base, ..self }
    }

    /// Sets what a collapse costs.
    #[must_use]
    pub fn with_price(self, price: Price) -> Self {
        Self { price, ..self }
    }

    /// Sets whether strips and levels are proven.
    #[must_use]
    pub fn with_verify(self, verify: bool) -> Self {
        Self { verify, ..self }
    }
}

/// Parses the flags of levels of detail: those of the method, and `--price` of their collapses.
///
/// # Errors
/// As of [`parse_method`](crate::parse_method), or the price is unknown.
///
/// ```
/// use tristrip::simplify::Price;
/// use tristrip_pipeline::parse_levels;
/// assert_eq!(parse_levels("--method stripe --price quadric")?.price, Price::Quadric);
/// assert!(parse_levels("--price low").is_err());
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn parse_levels(flags: &str) -> Result<LevelsOptions, tristrip::Error> {
    let (stripify, price) = parse_with_price(flags)?;
    Ok(LevelsOptions::default().with_stripify(stripify).with_price(price))
}
