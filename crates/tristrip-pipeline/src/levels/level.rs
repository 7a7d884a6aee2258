//! Selects a level of detail: by its number, by a percentage of all levels, or by a goal.

use std::str::FromStr;

use tristrip::lod::View;

use crate::error::Error;
use crate::goal::Deviation;

/// A level of detail. Parsed from `120` or `40%`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Level {
    /// The number of undone collapses.
    Number(usize),
    /// A percentage of all collapses.
    Percent(f64),
}

impl Level {
    /// Returns the number of the level in a model with this many collapses.
    ///
    /// # Errors
    /// The level is greater than the number of collapses.
    ///
    /// ```
    /// use tristrip_pipeline::levels::Level;
    /// assert_eq!("40%".parse::<Level>()?.of(200).ok(), Some(80));
    /// # Ok::<(), String>(())
    /// ```
    #[allow(clippy::cast_sign_loss, reason = "a percentage is not negative")]
    pub fn of(self, collapses: usize) -> Result<usize, Error> {
        match self {
            Self::Percent(percent) => Ok((percent / 100.0 * collapses as f64).round() as usize),
            Self::Number(level) if level <= collapses => Ok(level),
            Self::Number(found) => Err(Error::Level { found, last: collapses }),
        }
    }
}

impl FromStr for Level {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = match text.strip_suffix('%') {
            Some(number) => number.parse().ok().filter(|p| (0.0..=100.0).contains(p)).map(Self::Percent),
            None => text.parse().ok().map(Self::Number),
        };
        parsed.ok_or_else(|| {
            format!("found `{text}`, expected a number such as 120, or a percentage such as 40%")
        })
    }
}

/// A criterion that selects a level of a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LevelGoal {
    /// An explicit level.
    Level(Level),
    /// The finest level with at most this number of triangles, or the base mesh if all levels have
    /// more.
    Triangles(usize),
    /// The coarsest level with at most this surface error.
    Error(Deviation),
    /// The coarsest level whose surface error covers at most this number of pixels of a view.
    Pixels(f32, View),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_parse_as_numbers_and_percentages() {
        let level = |text: &str| text.parse::<Level>().ok().and_then(|level| level.of(201).ok());
        assert_eq!(
            ["0", "201", "202", "0%", "50%", "100%", "101%", "-1", "half", "0.4"].map(level),
            [Some(0), Some(201), None, Some(0), Some(101), Some(201), None, None, None, None]
        );
    }
}
