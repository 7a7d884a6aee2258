//! `quad-rows`: strips along the rows of quadrilateral patches. Of the methods that start from
//! patches, this one sends the fewest vertices. It is original to this library.
//!
//! It starts like STRIPE's global algorithm, with the rows of the largest patches of
//! quadrilaterals. Here rows can grow, and swaps and short ends are weighted in every choice:
//!
//! ```text
//!   ┌───┬───┬───┬───┐ ╲        the rows of the patch, then their ends: each row grows into
//!   │───┼───┼───┼───┼──▶╲      the faces around it, and may take a part of a polygon
//!   ├───┼───┼───┼───┤───┤
//! ◀─┼───┼───┼───┼───┼───┼──▶
//!   └───┴───┴───┴───┘───┘
//! ```
//!
//! # Algorithm
//! 1. The largest patch is divided into rows. Faces that are already in a strip divide a row.
//!    Sections of fewer than three quadrilaterals are left to step 3.
//! 2. Each row grows at both ends by the rule of step 3. Then steps 1 and 2 continue with the next
//!    largest patch.
//! 3. The remaining faces are covered locally. A strip leaves over the edge with the lowest sum of
//!    neighbours and weighted swaps, and takes only the part of a polygon up to that edge. A
//!    remainder with fewer than two neighbours is taken as well.
//! 4. The diagonals of all polygons of a strip are chosen together for the fewest swaps.
//!
//! On skyscraper, triceratops and power lines, a cutoff of 5 sends 4537, 6737 and 10084 vertices.
//! For the published row method, the first paper reports 4616, 6911 and 10621 vertices, and the
//! later one 4849, 7248 and 10417.
//!
//! # References
//! Patches: section 3.2 of the paper by Evans, Skiena and Varshney; see [`super`]. All other steps
//! are original to this library.
//!
//! # Complexity
//! O(n log n) time in the worst case. Patches take a few rounds of O(n). About 40 bytes per
//! triangle in addition to the triangulation.

use super::local::{ExitRule, LocalStripper, PathEnds, StripRules};
use super::patch::PatchFinder;
use super::polygon_triangulator::PolygonTriangulator;
use super::queue::QueueOrder;
use super::remaining_faces::RemainingFaces;
use super::turn_sequence::TurnDiagonals;
use super::{check_cutoff, cover};
use crate::dual::{DualGraph, Triangulation};
use crate::error::Error;
use crate::prepare::PreparedFaces;
use crate::stripify::{LastTie, StripPlan};

/// Minimum length of a row section that becomes a strip. Over eight polygon models 2 sends 0.1 %
/// more vertices. 5 sends 0.25 % fewer, but a cutoff of 5 would then have no effect on patches of
/// short rows.
const MIN_ROW_LENGTH: usize = 3;

const RULES: StripRules = StripRules {
    exit: ExitRule::FewSwaps,
    last_tie: LastTie::Last,
    diagonals: TurnDiagonals::Together,
    starts: QueueOrder::LastChanged,
    absorbs_rests: true,
};

/// Plans strips along rows.
pub(in crate::stripify) fn plan<'a>(
    prepared: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    cutoff: u32,
    seed: u64,
) -> Result<StripPlan<'a>, Error> {
    check_cutoff(cutoff)?;
    let faces = prepared.faces();
    if faces.as_triangles().is_some() {
        let triangulation = Triangulation::zigzag(prepared, graph);
        let cover = cover(graph, RULES, seed);
        return Ok(StripPlan::new(triangulation, cover));
    }
    let mut triangulator = PolygonTriangulator::new(faces, graph, RULES.diagonals);
    let mut stripper = LocalStripper::new(RemainingFaces::new(graph, true, RULES.starts), RULES, seed);
    for rows in PatchFinder::new(graph).find(cutoff) {
        stripper.strip_along(&rows, MIN_ROW_LENGTH, PathEnds::Growing, &mut triangulator);
    }
    stripper.strip_all(&mut triangulator);
    Ok(triangulator.finish())
}
