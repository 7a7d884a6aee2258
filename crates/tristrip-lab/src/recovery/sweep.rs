//! The levels of a sweep.

use std::fmt;
use std::str::FromStr;

use serde::{Serialize, Serializer};

/// The spacing of the levels that a sweep recovers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Sweep {
    /// Equal spacing.
    Linear,
    /// Spacing that grows by a constant factor from the full mesh to the base mesh, with a minimum
    /// of one level.
    Exponential,
}

impl Sweep {
    /// Both, in the order of reports.
    pub const ALL: [Self; 2] = [Self::Linear, Self::Exponential];

    /// Returns the name on the command line and in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Exponential => "exponential",
        }
    }

    /// Returns the levels that a sweep over a fraction of all levels, in percent, recovers after
    /// the full mesh. They are descending, and the last one is 0.
    ///
    /// ```
    /// use tristrip_lab::recovery::Sweep;
    /// assert_eq!(Sweep::Linear.levels(40, 10), [30, 20, 10, 0]);
    /// assert_eq!(Sweep::Exponential.levels(40, 10), [39, 35, 25, 0]);
    /// ```
    #[allow(clippy::cast_sign_loss, reason = "powers of a factor of at least 1")]
    pub fn levels(self, collapse_count: usize, share: usize) -> Vec<usize> {
        let count = (collapse_count * share / 100).max(1).min(collapse_count);
        let factor = match self {
            Self::Linear => 1.0,
            Self::Exponential => root(collapse_count as f64 + 1.0, count),
        };
        let mut power = 1.0;
        let mut level = |i: usize| {
            power *= factor;
            let distance = match self {
                Self::Linear => (i * collapse_count + count / 2) / count,
                Self::Exponential => ((power - 1.0) as usize).max(i),
            };
            if i == count { 0 } else { collapse_count - distance.min(collapse_count) }
        };
        (1..=count).map(&mut level).collect()
    }
}

/// Returns the n-th root of a number of at least 1, with a relative error of 1e-13. It uses only
/// products, so the result is the same on every machine.
fn root(number: f64, degree: usize) -> f64 {
    let power = |base: f64| {
        let (mut power, mut square, mut left) = (1.0, base, degree);
        while left > 0 {
            if left % 2 == 1 {
                power *= square;
            }
            square *= square;
            left /= 2;
        }
        power
    };
    let (mut low, mut high) = (1.0, number);
    for _ in 0..100 {
        let middle: f64 = f64::midpoint(low, high);
        if power(middle) < number { low = middle } else { high = middle }
    }
    low
}

impl fmt::Display for Sweep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Parses the name of a sweep.
///
/// ```
/// use tristrip_lab::recovery::Sweep;
/// assert!(Sweep::ALL.iter().all(|sweep| sweep.to_string().parse() == Ok(*sweep)));
/// assert!("square".parse::<Sweep>().is_err());
/// ```
impl FromStr for Sweep {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|sweep| sweep.name() == text);
        found.ok_or_else(|| format!("found `{text}`, expected linear or exponential"))
    }
}

/// Serializes as the name.
impl Serialize for Sweep {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sweeps_fall_to_the_base_mesh() {
        for sweep in Sweep::ALL {
            for (count, share) in
                [(0, 1), (1, 20), (7, 3), (40, 10), (34_818, 20), (34_818, 1), (437_000, 20)]
            {
                let levels = sweep.levels(count, share);
                assert_eq!(levels.len(), (count * share / 100).max(1).min(count));
                assert!(levels.is_sorted_by(|a, b| a > b), "{sweep} {count} {share}");
                assert!(levels.last().is_none_or(|&last| last == 0));
                assert!(levels.first().is_none_or(|&first| first < count));
            }
        }
    }

    #[test]
    fn exponential_distances_grow() {
        let levels = Sweep::Exponential.levels(10_000, 1);
        let distances: Vec<usize> = levels.windows(2).map(|pair| pair[0] - pair[1]).collect();
        assert!(distances.is_sorted(), "{distances:?}");
        assert!(distances[distances.len() - 1] > 500);
    }
}
