//! STRIPE: strips that choose how polygons are cut, locally by adjacency and globally by patches of
//! quadrilaterals.
//!
//! It was the first published method that takes polygons, and gains from the freedom to choose
//! their diagonals.
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
//! *Local* (section 3.1): from a face with the fewest neighbours to a neighbour with the fewest
//! neighbours, and so on, in both directions; [`Ties`] chooses among several. Faces are cut
//! beforehand, or when a strip passes: see [`FaceTriangulation`].
//!
//! *Global* (section 3.2):
//! 1. The largest rectangular patches of quadrilaterals are found, down to a cutoff.
//! 2. Each row of a patch becomes a strip, or column, whichever is longer; or the whole patch
//!    becomes one strip ([`Patches`]).
//! 3. The local algorithm covers the rest.
//!
//! Where the paper is silent: of the faces with the fewest neighbours, strips start at the one that
//! has had so few for the longest time; the first face of a strip is cut for the second. Step 3
//! takes whole faces, with the ties of the method; step 2 takes all patches before the strips of
//! full patches grow.
//!
//! Our own global method, with fewer vertices, is [`quad_rows`].
//!
//! # References
//! Evans, Skiena, Varshney: *Efficiently Generating Triangle Strips for Fast Rendering* (the
//! journal report of *Optimizing Triangle Strips for Fast Rendering*, 1996); El-Sana, Evans,
//! Kalaiah, Varshney, Skiena, Azanli: *Efficiently Computing and Updating Triangle Strips for
//! Real-Time Rendering*, 2000.
//!
//! # Complexity
//! O(n) time, O(n log n) at worst with partial faces; patches take a few rounds of O(n). About 40
//! bytes per triangle beside the triangulation.

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

/// Checks that patches have a least size.
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

/// Covers triangles by least adjacency, ties by one level of look-ahead.
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
