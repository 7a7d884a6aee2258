//! The reasons why a simplification stopped above its target.

use crate::text::counted;
use std::fmt;

/// Why a simplification could not continue, as counts of remaining points per reason. A point is
/// counted under the first reason that applies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Stopped {
    /// The number of remaining triangles.
    pub triangle_count: usize,
    /// Points that the caller locked.
    pub locked: usize,
    /// Points whose triangles form neither a disk nor a half disk.
    pub non_manifold: usize,
    /// Points on attribute seams whose collapse would open the seam.
    pub seam: usize,
    /// Points whose collapse would close a hole, make the mesh non-manifold, or remove the last
    /// triangles of a component.
    pub topology: usize,
    /// Points whose collapse would flip a triangle.
    pub fold_over: usize,
    /// Points whose collapse would exceed the error limit.
    pub error: usize,
}

impl fmt::Display for Stopped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "stopped at {}", counted(self.triangle_count, "triangle"))?;
        let reasons = [
            (self.locked, "locked"),
            (self.non_manifold, "not manifold"),
            (self.seam, "on attribute seams"),
            (self.topology, "would change the topology"),
            (self.fold_over, "would flip a triangle"),
            (self.error, "would exceed the error limit"),
        ];
        let mut is_first = true;
        for (count, reason) in reasons.iter().filter(|(count, _)| *count > 0) {
            if is_first {
                write!(f, ": {} {reason}", counted(count, "vertex"))?;
            } else {
                write!(f, ", {count} {reason}")?;
            }
            is_first = false;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reasons_are_listed_with_their_counts() {
        let stopped = Stopped { triangle_count: 15, ..Stopped::default() };
        assert_eq!(stopped.to_string(), "stopped at 15 triangles");
        assert_eq!(Stopped { locked: 1, ..stopped }.to_string(), "stopped at 15 triangles: 1 vertex locked");
        assert_eq!(
            Stopped { seam: 891, fold_over: 850, ..stopped }.to_string(),
            "stopped at 15 triangles: 891 vertices on attribute seams, 850 would flip a triangle"
        );
    }
}
