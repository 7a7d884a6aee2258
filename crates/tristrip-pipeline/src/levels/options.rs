//! Options for building levels of detail.

use tristrip::StripifyOptions;
use tristrip::simplify::Price;

use crate::goal::Ratio;

/// Options for building levels of detail. By default the base mesh is as small as the surface
/// allows, and everything is verified.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Options {
    /// The method that builds the strips of the full mesh, with its options.
    pub stripify: StripifyOptions,
    /// The ratio of triangles that the base mesh keeps.
    pub base: Ratio,
    /// The cost function of collapses.
    pub price: Price,
    /// Whether strips and levels are verified.
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
        /// Sets the method that builds the strips of the full mesh.
        with_stripify(stripify: StripifyOptions);

        /// Sets the ratio of triangles that the base mesh keeps.
        with_base(base: Ratio);

        /// Sets the cost function of collapses.
        with_price(price: Price);

        /// Sets whether strips and levels are verified.
        with_verify(verify: bool);
    }
}
