//! STRIPE: builds strips and chooses the triangulation of polygons for them. The local algorithm
//! works by adjacency, the global algorithm by patches of quadrilaterals.
//!
//! STRIPE was the first published method for polygons. It reduces the cost by the choice of
//! diagonals.
//!
//! ```text
//!  static            whole face              partial face
//!   ┌────────┐        ┌────────┐              ┌────────┐
//!   │ ╲      │        │ ╲   ▲  │ exit chosen, │      ╱ │  only what lies between
//!   │   ╲    │        │   ╲ │  │ then the     │    ╱   │  entry and exit is taken;
//!   │     ╲  │        │    ╲│  │ diagonal     │  ╱     ├─▶ the rest is a smaller face
//!   └────────┘        └─────┴──┘              └───▲────┘
//! ```
//!
//! # Algorithm
//! *Local* (section 3.1): a strip starts at a face with the fewest neighbours and continues in both
//! directions, each time to a neighbour with the fewest neighbours. [`Ties`] breaks ties. Faces are
//! triangulated in advance, or when a strip passes through them: see [`FaceTriangulation`].
//!
//! *Global* (section 3.2):
//! 1. The largest rectangular patches of quadrilaterals are found, down to a cutoff.
//! 2. Either each row or column of a patch becomes a strip, whichever is longer, or the whole patch
//!    becomes one strip ([`Patches`]).
//! 3. The local algorithm covers the remaining faces.
//!
//! The paper leaves some choices open. Here, a strip starts at the face with the fewest neighbours.
//! If there are several such faces, it starts at the one whose number of neighbours has been the
//! same for the longest time. The first face of a strip is triangulated for the exit to the second
//! face. Step 3 takes whole faces and breaks ties by the rule of the method. Step 2 takes all
//! patches before the strips of full patches are extended.
//!
//! [`quad_rows`] is this library's own global method, which sends fewer vertices.
//!
//! # References
//! Evans, Skiena, Varshney: *Efficiently Generating Triangle Strips for Fast Rendering* (the
//! journal report of *Optimizing Triangle Strips for Fast Rendering*, 1996); El-Sana, Evans,
//! Kalaiah, Varshney, Skiena, Azanli: *Efficiently Computing and Updating Triangle Strips for
//! Real-Time Rendering*, 2000.
//!
//! # Complexity
//! O(n) time, or O(n log n) in the worst case with partial faces. Patches take a few rounds of
//! O(n). About 40 bytes per triangle in addition to the triangulation.

mod local;
mod patch;
mod polygon_triangulator;
pub(super) mod quad_rows;
mod queue;
mod remaining_faces;
#[cfg(test)]
mod tests;
mod turn_sequence;

use super::{FaceTriangulation, LastTie, Patches, StripPlan, Ties};
use crate::cover::PathCover;
use crate::dual::{DualGraph, Triangulation};
use crate::error::Error;
use crate::prepare::PreparedFaces;
use local::{LocalStripper, PathEnds, StripRules};
use polygon_triangulator::{PolygonTriangulator, TriangleLinker};
use queue::QueueOrder;
use remaining_faces::RemainingFaces;

/// Plans strips by a local algorithm.
pub(super) fn plan_local<'a>(
    prepared: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    triangulation: FaceTriangulation,
    ties: Ties,
    seed: u64,
) -> StripPlan<'a> {
    let faces = prepared.faces();
    let absorbs_rests = triangulation == FaceTriangulation::Absorbing;
    let rules = StripRules { absorbs_rests, ..StripRules::PUBLISHED.with_ties(ties) };
    if triangulation == FaceTriangulation::Static || faces.as_triangles().is_some() {
        let triangulation = Triangulation::zigzag(prepared, graph);
        let cover = cover(triangulation.graph(), rules, seed);
        return StripPlan::new(triangulation, cover);
    }
    let mut triangulator = PolygonTriangulator::new(faces, graph, rules.diagonals);
    let is_partial = absorbs_rests || triangulation == FaceTriangulation::Partial;
    let remaining = RemainingFaces::new(graph, is_partial, rules.starts);
    LocalStripper::new(remaining, rules, seed).strip_all(&mut triangulator);
    triangulator.finish()
}

/// Plans strips by a global algorithm.
pub(super) fn plan_global<'a>(
    prepared: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    (patches, cutoff, ties): (Patches, u32, Ties),
    seed: u64,
) -> Result<StripPlan<'a>, Error> {
    check_cutoff(cutoff)?;
    let (faces, rules) = (prepared.faces(), StripRules::PUBLISHED.with_ties(ties));
    if faces.as_triangles().is_some() {
        let triangulation = Triangulation::zigzag(prepared, graph);
        let cover = cover(graph, rules, seed);
        return Ok(StripPlan::new(triangulation, cover));
    }
    let mut triangulator = PolygonTriangulator::new(faces, graph, rules.diagonals);
    let mut stripper = LocalStripper::new(RemainingFaces::new(graph, false, rules.starts), rules, seed);
    let found = patch::PatchFinder::new(graph).find(cutoff);
    let (paths, ends): (Vec<_>, _) = match patches {
        Patches::Rows => (found.into_iter().flatten().collect(), PathEnds::Fixed),
        Patches::Full => {
            (found.iter().map(|rows| patch::serpentine(graph, rows)).collect(), PathEnds::Growing)
        }
    };
    stripper.strip_along(&paths, 1, ends, &mut triangulator);
    stripper.strip_all(&mut triangulator);
    Ok(triangulator.finish())
}

/// Checks that the minimum size of patches is not zero.
fn check_cutoff(cutoff: u32) -> Result<(), Error> {
    if cutoff == 0 {
        return Err(Error::Parameter {
            name: "cutoff",
            found: cutoff.to_string(),
            expected: "at least 1 quadrilateral",
        });
    }
    Ok(())
}

/// Covers triangles by the lowest adjacency. One level of look-ahead breaks ties.
pub(super) fn cover_by_look_ahead(graph: &DualGraph, last_tie: LastTie) -> PathCover {
    let rules = StripRules { last_tie, starts: QueueOrder::LastChanged, ..StripRules::PUBLISHED };
    cover(graph, rules.with_ties(Ties::LookAhead), 0)
}

/// Covers triangles by the local algorithm.
fn cover(graph: &DualGraph, rules: StripRules, seed: u64) -> PathCover {
    let mut linker = TriangleLinker::new(graph);
    LocalStripper::new(RemainingFaces::new(graph, false, rules.starts), rules, seed).strip_all(&mut linker);
    linker.finish()
}
