//! STRIPE: strips that choose how polygons are cut, locally by adjacency and globally by patches of quadrilaterals.
//!
//! It was the first published method that takes polygons, and gains from the freedom to choose their diagonals.
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
//! *Local* (section 3.1): from a face with the fewest neighbours to a neighbour with the fewest neighbours, and so on, in both
//! directions; [`Ties`] chooses among several. Faces are cut beforehand, or when a strip passes: see [`FaceTriangulation`].
//!
//! *Global* (section 3.2):
//! 1. The largest rectangular patches of quadrilaterals are found, down to a cutoff.
//! 2. Each row of a patch becomes a strip, or column, whichever is longer; or the whole patch becomes one strip ([`Patches`]).
//! 3. The local algorithm covers the rest.
//!
//! Departures from the paper, where the OpenGL cost showed that they pay:
//! - The diagonals of a strip's polygons are chosen together, for the fewest swaps.
//! - In the global algorithms a swap weighs as much as two neighbours in the choice of the exit, and further ties go to the
//!   exit whose face has neighbours of the most adjacency. The local ones choose strictly by adjacency first, as the paper says.
//! - Rows grow at both ends, too, not only full patches. Faces that a strip grew into are no longer part of a patch that
//!   comes later; sections of its rows that are shorter than three quadrilaterals are left to step 3.
//! - Step 3 takes partial faces where the paper takes whole ones, though it found partial ones better by themselves: 4537, 6728
//!   and 10084 vertices instead of 4635, 6634 and 10489 for the three models below.
//! - Partial triangulation leaves no rest of a polygon that has fewer than two neighbours.
//!
//! For skyscraper, triceratops and power lines, rows with cutoff 5 send 4537, 6728 and 10084 vertices; the paper has 4616, 6911
//! and, in the later report, 10417.
//!
//! # References
//! Evans, Skiena, Varshney: *Efficiently Generating Triangle Strips for Fast Rendering* (the journal report of *Optimizing
//! Triangle Strips for Fast Rendering*, 1996); El-Sana, Evans, Kalaiah, Varshney, Skiena, Azanli: *Efficiently Computing and
//! Updating Triangle Strips for Real-Time Rendering*, 2000.
//!
//! # Complexity
//! O(n) time, O(n log n) at worst with partial faces; patches take a few rounds of O(n). About 40 bytes per triangle beside
//! the triangulation.

mod local;
mod patch;
mod polygon_triangulator;
mod queue;
mod remaining_faces;
#[cfg(test)]
mod tests;
mod turn_sequence;

use super::{FaceTriangulation, Patches, StripPlan, Ties};
use crate::cover::PathCover;
use crate::dual::{DualGraph, Triangulation};
use crate::error::Error;
use crate::prepare::PreparedFaces;
use local::{ExitRule, LocalStripper};
use polygon_triangulator::{PolygonTriangulator, TriangleLinker};
use remaining_faces::RemainingFaces;

/// The shortest section of a row that becomes a strip. Over eight polygon models 2 sends 0.1 % more vertices, and 5 sends 0.25 %
/// fewer, but then a cutoff of 5 would have no effect on patches of short rows.
const MIN_ROW_LENGTH: usize = 3;

/// Plans strips by a local algorithm.
pub(super) fn plan_local<'a>(
    prepared: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    triangulation: FaceTriangulation,
    ties: Ties,
    seed: u64,
) -> StripPlan<'a> {
    let (faces, rule) = (prepared.faces(), ExitRule::Adjacency(ties));
    if triangulation == FaceTriangulation::Static || faces.as_triangles().is_some() {
        let triangulation = Triangulation::zigzag(prepared, graph);
        let cover = cover(triangulation.graph(), rule, seed);
        return StripPlan::new(triangulation, cover);
    }
    let mut triangulator = PolygonTriangulator::new(faces, graph);
    let remaining = RemainingFaces::new(graph, triangulation == FaceTriangulation::Partial);
    LocalStripper::new(remaining, rule, seed).strip_all(&mut triangulator);
    triangulator.finish()
}

/// Plans strips by a global algorithm.
pub(super) fn plan_global<'a>(
    prepared: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    patches: Patches,
    cutoff: u32,
    seed: u64,
) -> Result<StripPlan<'a>, Error> {
    if cutoff == 0 {
        return Err(Error::Parameter {
            name: "cutoff",
            found: cutoff.to_string(),
            expected: "at least 1 quadrilateral",
        });
    }
    let faces = prepared.faces();
    if faces.as_triangles().is_some() {
        let triangulation = Triangulation::zigzag(prepared, graph);
        let cover = cover(graph, ExitRule::FewSwaps, seed);
        return Ok(StripPlan::new(triangulation, cover));
    }
    let mut triangulator = PolygonTriangulator::new(faces, graph);
    let mut stripper = LocalStripper::new(RemainingFaces::new(graph, true), ExitRule::FewSwaps, seed);
    for rows in patch::PatchFinder::new(graph).find(cutoff) {
        let paths = match patches {
            Patches::Rows => rows,
            Patches::Full => vec![patch::serpentine(graph, &rows)],
        };
        stripper.strip_along(&paths, MIN_ROW_LENGTH, &mut triangulator);
    }
    stripper.strip_all(&mut triangulator);
    Ok(triangulator.finish())
}

/// Covers triangles by least adjacency, ties by one level of look-ahead.
pub(super) fn cover_by_look_ahead(graph: &DualGraph) -> PathCover {
    cover(graph, ExitRule::Adjacency(Ties::LookAhead), 0)
}

/// Covers triangles by the local algorithm.
fn cover(graph: &DualGraph, rule: ExitRule, seed: u64) -> PathCover {
    let mut linker = TriangleLinker::new(graph);
    LocalStripper::new(RemainingFaces::new(graph, false), rule, seed).strip_all(&mut linker);
    linker.finish()
}
