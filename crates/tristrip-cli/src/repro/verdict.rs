//! Verdicts: a measured figure next to a published one.

use serde::{Serialize, Serializer};

use super::paper::{Better, Expects, Tolerance};

/// What a measured figure says of a published one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// Equal within the tolerance, or as the claim says.
    Matched,
    Better,
    Worse,
    /// Not equal, where neither is better, or not as the claim says.
    Differs,
    /// There is no such model in the folder.
    NotAvailable,
    /// Another model was measured, so that nothing follows.
    StandIn(String),
}

impl Verdict {
    /// Compares figures as they are written, with so many digits after the point.
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
        // Half a unit of a digit far behind what is written, so that 0.74 is within 0.03 of 0.71.
        if (measured - published).abs() <= allowed + 1e-9 {
            return Self::Matched;
        }
        match (better, measured < published) {
            (Better::Neither, _) => Self::Differs,
            (Better::Lower, true) | (Better::Higher, false) => Self::Better,
            _ => Self::Worse,
        }
    }

    /// Holds a figure to a claim.
    pub(crate) fn of_claim(
        published: f64,
        measured: f64,
        expects: Expects,
        (better, tolerance, digits): (Better, Tolerance, usize),
    ) -> Self {
        let holds = match expects {
            Expects::About => return Self::of(published, measured, better, tolerance, digits),
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
            Self::StandIn(name) => write!(f, "stand-in: {name}"),
        }
    }
}

impl Serialize for Verdict {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// Rounds to so many digits after the point.
pub(crate) fn rounded(figure: f64, digits: usize) -> f64 {
    format!("{figure:.digits$}").parse().unwrap_or(figure)
}

/// Sums the verdicts of a row's columns: the one that all share, else the columns of each that is not `matched`.
pub(crate) fn of_row(columns: &[(&str, &Verdict)]) -> String {
    let [(_, first), rest @ ..] = columns else { return "–".into() };
    if rest.iter().all(|(_, verdict)| verdict == first) {
        return first.to_string();
    }
    let mut words = Vec::new();
    for kind in [Verdict::Better, Verdict::Worse, Verdict::Differs] {
        let names: Vec<&str> = columns.iter().filter(|(_, v)| **v == kind).map(|(name, _)| *name).collect();
        if !names.is_empty() {
            words.push(format!("{kind}: {}", names.join(", ")));
        }
    }
    words.join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_match_within_the_tolerance_and_else_by_direction() {
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
    fn claims_are_numbers_or_ends_of_ranges() {
        let of = |measured, expects| {
            Verdict::of_claim(60.0, measured, expects, (Better::Higher, Tolerance::Absolute(2.0), 0))
        };
        assert_eq!(of(61.0, Expects::About), Verdict::Matched);
        assert_eq!(of(70.0, Expects::About), Verdict::Better);
        assert_eq!(of(70.0, Expects::AtLeast), Verdict::Matched);
        assert_eq!(of(59.9, Expects::AtLeast), Verdict::Differs);
        assert_eq!(of(59.9, Expects::AtMost), Verdict::Matched);
        assert_eq!(of(60.1, Expects::AtMost), Verdict::Differs);
    }

    #[test]
    fn a_row_says_what_does_not_match() {
        let (m, b, w) = (&Verdict::Matched, &Verdict::Better, &Verdict::Worse);
        assert_eq!(of_row(&[("a", m), ("b", m)]), "matched");
        assert_eq!(of_row(&[("a", b), ("b", b)]), "better");
        assert_eq!(of_row(&[("a", b), ("b", m), ("c", w), ("d", b)]), "better: a, d; worse: c");
        assert_eq!(of_row(&[("a", &Verdict::NotAvailable)]), "model not available");
        assert_eq!(of_row(&[("a", &Verdict::StandIn("al".into()))]), "stand-in: al");
        assert_eq!(of_row(&[]), "–");
    }
}
