//! Verdicts: the result of comparing a measured value with a published one.

use serde::{Serialize, Serializer};

use super::paper::{Better, Expects, Tolerance};

/// The result of comparing a measured value with a published one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// Equal within the tolerance, or within the bound of the claim.
    Matched,
    Better,
    Worse,
    /// Different, if neither direction is better, or outside the bound of the claim.
    Differs,
    /// The model is missing in the directory.
    NotAvailable,
    /// The project does not measure it.
    NotMeasured,
    /// A different model was measured, so the values are not comparable.
    StandIn(String),
}

impl Verdict {
    /// Compares values as they are printed, with a number of decimals.
    pub(crate) fn of(
        published: f64,
        measured: f64,
        better: Better,
        tolerance: Tolerance,
        digits: usize,
    ) -> Self {
        let measured = rounded(measured, digits);
        let allowed = match tolerance {
            Tolerance::Percent(percent) => percent / 100.0 * published.abs(),
            Tolerance::Absolute(units) => units,
        };
        // The margin is far below the last printed digit. With it, 0.74 is within 0.03 of 0.71.
        if (measured - published).abs() <= allowed + 1e-9 {
            return Self::Matched;
        }
        match (better, measured < published) {
            (Better::Neither, _) => Self::Differs,
            (Better::Lower, true) | (Better::Higher, false) => Self::Better,
            _ => Self::Worse,
        }
    }

    /// Compares a value with a claim: a number or a range.
    pub(crate) fn of_claim(
        (published, up_to): (f64, Option<f64>),
        measured: f64,
        expects: Expects,
        (better, tolerance, digits): (Better, Tolerance, usize),
    ) -> Self {
        let holds = match expects {
            Expects::About => {
                // The number of the range that is closest to the measured value, as printed.
                let nearest = match up_to {
                    Some(end) if measured > published => rounded(measured, digits).min(end),
                    _ => published,
                };
                return Self::of(nearest, measured, better, tolerance, digits);
            }
            Expects::AtLeast => measured >= published,
            Expects::AtMost => measured <= published,
        };
        if holds { Self::Matched } else { Self::Differs }
    }
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Matched => f.write_str("matched"),
            Self::Better => f.write_str("better"),
            Self::Worse => f.write_str("worse"),
            Self::Differs => f.write_str("differs"),
            Self::NotAvailable => f.write_str("model not available"),
            Self::NotMeasured => f.write_str("not measured"),
            Self::StandIn(name) => write!(f, "stand-in: {name}"),
        }
    }
}

impl Serialize for Verdict {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// Rounds to a number of decimals.
pub(crate) fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.digits$}").parse().unwrap_or(value)
}

/// Combines the verdicts of a row's columns: the common verdict, or the columns of each verdict
/// other than `matched`.
pub(crate) fn row_verdict(columns: &[(&str, &Verdict)]) -> String {
    let [(_, first), rest @ ..] = columns else { return "–".into() };
    if rest.iter().all(|(_, verdict)| verdict == first) {
        return first.to_string();
    }
    let mut phrases = Vec::new();
    for verdict in [Verdict::Better, Verdict::Worse, Verdict::Differs] {
        let names: Vec<&str> =
            columns.iter().filter(|(_, v)| **v == verdict).map(|(name, _)| *name).collect();
        if !names.is_empty() {
            phrases.push(format!("{verdict}: {}", names.join(", ")));
        }
    }
    phrases.join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_match_within_the_tolerance_or_differ_by_direction() {
        let of = |published, measured, better| {
            Verdict::of(published, measured, better, Tolerance::Absolute(0.03), 2).to_string()
        };
        assert_eq!(of(0.71, 0.744, Better::Lower), "matched");
        assert_eq!(of(0.71, 0.68, Better::Lower), "matched");
        assert_eq!(of(0.71, 0.75, Better::Lower), "worse");
        assert_eq!(of(0.71, 0.67, Better::Lower), "better");
        assert_eq!(of(0.71, 0.75, Better::Higher), "better");
        assert_eq!(of(0.71, 0.75, Better::Neither), "differs");
        let percent = |measured| Verdict::of(5000.0, measured, Better::Lower, Tolerance::Percent(2.0), 0);
        assert_eq!(
            [4899.0, 4900.0, 5100.0, 5101.0].map(percent),
            [Verdict::Better, Verdict::Matched, Verdict::Matched, Verdict::Worse]
        );
    }

    #[test]
    fn claims_are_values_or_bounds() {
        let of = |measured, expects| {
            Verdict::of_claim((60.0, None), measured, expects, (Better::Higher, Tolerance::Absolute(2.0), 0))
        };
        assert_eq!(of(61.0, Expects::About), Verdict::Matched);
        assert_eq!(of(70.0, Expects::About), Verdict::Better);
        assert_eq!(of(70.0, Expects::AtLeast), Verdict::Matched);
        assert_eq!(of(59.9, Expects::AtLeast), Verdict::Differs);
        assert_eq!(of(59.9, Expects::AtMost), Verdict::Matched);
        assert_eq!(of(60.1, Expects::AtMost), Verdict::Differs);
        let range = |measured| {
            let criteria = (Better::Lower, Tolerance::Absolute(0.0), 1);
            Verdict::of_claim((19.4, Some(22.4)), measured, Expects::About, criteria)
        };
        assert_eq!([19.36, 20.0, 22.44].map(range), [Verdict::Matched, Verdict::Matched, Verdict::Matched]);
        assert_eq!([19.34, 22.46].map(range), [Verdict::Better, Verdict::Worse]);
    }

    #[test]
    fn a_row_verdict_names_columns_that_do_not_match() {
        let (m, b, w) = (&Verdict::Matched, &Verdict::Better, &Verdict::Worse);
        assert_eq!(row_verdict(&[("a", m), ("b", m)]), "matched");
        assert_eq!(row_verdict(&[("a", b), ("b", b)]), "better");
        assert_eq!(row_verdict(&[("a", b), ("b", m), ("c", w), ("d", b)]), "better: a, d; worse: c");
        assert_eq!(row_verdict(&[("a", &Verdict::NotAvailable)]), "model not available");
        assert_eq!(row_verdict(&[("a", &Verdict::StandIn("al".into()))]), "stand-in: al");
        assert_eq!(row_verdict(&[]), "–");
    }
}
