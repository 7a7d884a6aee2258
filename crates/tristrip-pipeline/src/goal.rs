//! Simplification goals, and their text syntax.

use std::fmt;
use std::str::FromStr;

use serde::Serialize;

/// A ratio of triangles or collapses, from 0 to 1. Parsed from `0.05` or `5%`.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Ratio(f64);

impl Ratio {
    /// The ratio 0.
    pub const ZERO: Self = Self(0.0);

    /// Returns a ratio from 0 to 1, or `None` if the number is out of range or NaN.
    ///
    /// ```
    /// use tristrip_pipeline::Ratio;
    /// assert_eq!(Ratio::new(0.05).map(|ratio| ratio.of(1000)), Some(50));
    /// assert!(Ratio::new(1.1).is_none());
    /// ```
    pub fn new(ratio: f64) -> Option<Self> {
        (0.0..=1.0).contains(&ratio).then_some(Self(ratio))
    }

    /// Returns the ratio as a number from 0 to 1.
    ///
    /// ```
    /// assert!(tristrip_pipeline::Ratio::ZERO.value() < f64::EPSILON);
    /// ```
    pub fn value(self) -> f64 {
        self.0
    }

    /// Multiplies a count, and rounds to the nearest integer.
    #[allow(clippy::cast_sign_loss, reason = "a ratio is not negative")]
    pub fn of(self, count: usize) -> usize {
        (self.0 * count as f64).round() as usize
    }
}

impl FromStr for Ratio {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (number, unit) = text.strip_suffix('%').map_or((text, 1.0), |number| (number, 100.0));
        let ratio = number.parse::<f64>().ok().map(|number| number / unit);
        ratio.and_then(Self::new).ok_or_else(|| {
            format!("found `{text}`, expected a ratio from 0 to 1 such as 0.05, or a percentage such as 5%")
        })
    }
}

/// A distance. Parsed from `0.01` (in mesh units) or `0.1%` (of the diagonal of the bounding box).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Deviation {
    /// A distance in mesh units.
    Units(f64),
    /// A distance in percent of the diagonal of the bounding box.
    Percent(f64),
}

impl Default for Deviation {
    /// Returns 1 % of the diagonal. In a view of the whole model, this change is hardly visible.
    fn default() -> Self {
        Self::Percent(1.0)
    }
}

impl fmt::Display for Deviation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Units(units) => write!(f, "{units}"),
            Self::Percent(percent) => write!(f, "{percent} % of the diagonal"),
        }
    }
}

impl Deviation {
    /// Returns the distance in mesh units, given the diagonal of the bounding box.
    pub fn units(self, diagonal: f64) -> f32 {
        (match self {
            Self::Units(units) => units,
            Self::Percent(percent) => percent / 100.0 * diagonal,
        }) as f32
    }
}

impl FromStr for Deviation {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = match text.strip_suffix('%') {
            Some(number) => number.parse().map(Self::Percent),
            None => text.parse().map(Self::Units),
        };
        let is_distance = |&(Self::Units(x) | Self::Percent(x)): &Self| x.is_finite() && x >= 0.0;
        parsed.ok().filter(is_distance).ok_or_else(|| {
            format!("found `{text}`, expected a distance such as 0.01, or a percentage such as 0.1%")
        })
    }
}

/// The number of triangles to keep of a whole model. The budget is distributed over the parts by
/// cost: each part keeps the triangles that its shape needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Amount {
    /// A ratio of all triangles.
    Ratio(Ratio),
    /// The number of triangles.
    Triangles(usize),
}

impl Amount {
    /// Returns the number of triangles to keep out of `triangles`.
    ///
    /// ```
    /// use tristrip_pipeline::Amount;
    /// assert_eq!([10, 1000].map(|wanted| Amount::Triangles(wanted).of(300)), [10, 300]);
    /// ```
    pub fn of(self, triangles: usize) -> usize {
        match self {
            Self::Ratio(ratio) => ratio.of(triangles),
            Self::Triangles(wanted) => wanted.min(triangles),
        }
    }
}

/// The goal of a simplification. Simplification stops at whichever limit is reached first. The
/// default is the minimum number of triangles within an error of 1 % of the diagonal.
///
/// ```
/// use tristrip_pipeline::{Amount, Deviation, Goal};
/// let goal = Goal { amount: Some(Amount::Triangles(500)), ..Goal::default() };
/// assert_eq!(goal.deviation, Deviation::Percent(1.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Goal {
    /// The number of triangles to keep.
    pub amount: Option<Amount>,
    /// The maximum error of a collapse. [`Deviation::Percent`] of 100 means no limit.
    pub deviation: Deviation,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_parse_as_fractions_and_percentages() {
        let read = |text: &str| text.parse::<Ratio>().map(|ratio| ratio.of(1000));
        assert_eq!(
            ["0.05", "5%", "0", "100%", "1"].map(|text| read(text).ok()),
            [50, 50, 0, 1000, 1000].map(Some)
        );
        for invalid in ["1.1", "-0.1", "101%", "", "%", "nan", "five", "5 %x"] {
            assert!(read(invalid).is_err(), "{invalid}");
        }
    }

    #[test]
    fn distances_parse_as_units_and_percentages() {
        let read = |text: &str| text.parse::<Deviation>().ok().map(|distance| distance.units(50.0));
        assert_eq!(["2", "2%", "0", "1e-3"].map(read), [2.0, 1.0, 0.0, 1e-3].map(Some));
        assert_eq!(["-1", "inf", "nan%", "x", ""].map(read), [None; 5]);
    }
}
