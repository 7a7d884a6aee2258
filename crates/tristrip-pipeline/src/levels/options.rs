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
    tristrip::setters! {
        /// Sets the method of the strips of the full mesh.
        with_stripify(stripify: StripifyOptions);

        /// Sets the ratio of triangles that the base mesh keeps.
        with_base(base: Ratio);

        /// Sets what a collapse costs.
        with_price(price: Price);

        /// Sets whether strips and levels are proven.
        with_verify(verify: bool);
    }
}
