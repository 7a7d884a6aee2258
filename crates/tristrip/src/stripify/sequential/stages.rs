//! The stages for one policy: greedy stripping, local search at the ends of strips, and the choice
//! of diagonals.

use super::greedy::{GreedyStripper, GreedyStrips};
use super::local_search;
use super::mutable_triangulation::MutableTriangulation;
use super::policy::Policy;
use crate::cover::PathCover;

/// A covered triangulation.
pub(super) struct CoveredTriangulation<T> {
    pub(super) triangulation: T,
    pub(super) cover: PathCover,
    /// Cost in addition to one index per triangle, without swaps at the starts of strips.
    pub(super) cost: i64,
}

/// Covers a triangulation with one policy.
pub(super) fn strip<T: MutableTriangulation>(triangulation: T, policy: Policy) -> CoveredTriangulation<T> {
    let strips = GreedyStripper::new(triangulation, policy).run();
    let GreedyStrips { mut triangulation, mut cover, strip_of, cost } = strips;
    let saved = local_search::improve(triangulation.graph(), &mut cover, strip_of, 0);
    triangulation.optimize_diagonals(&mut cover);
    CoveredTriangulation { triangulation, cover, cost: cost.cast_signed() - saved.cast_signed() }
}
