//! How levels of detail are built.

use tristrip::StripifyOptions;
use tristrip::simplify::Price;

use crate::goal::Ratio;

/// How levels of detail are built. The base mesh of the default is what the surface allows; everything is proven.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Options {
    /// The method of the strips of the full mesh, and its options.
    pub stripify: StripifyOptions,
    /// The ratio of triangles that the base mesh keeps.
    pub base: Ratio,
    /// What a collapse costs.
    pub price: Price,
    /// Whether strips and levels are proven.
    pub verify: bool,
}

impl Default for Options {
    fn default() -> Self {
        let (stripify, price) = (StripifyOptions::default(), Price::default());
        Self { stripify, base: Ratio::ZERO, price, verify: true }
    }
}

impl Options {
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
