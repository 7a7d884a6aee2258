//! A triangulation that changes while strips grow: triangles are fixed, and polygons are
//! triangulated when a strip enters them.
//!
//! ```text
//!   d ─── c      A strip enters over a–b; its next free turn is to the left or to the right.
//!   │     │      One of the diagonals a–c and b–d leads to c–d without a swap.
//!   a ─── b
//! ```
//! # Algorithm
//! *Entry*: a polygon of at most 64 corners without taken triangles is triangulated by alternate
//! turns, starting at the edge where a run enters it. The first turn is the one that needs no swap.
//!
//! *Choice of diagonals*: once the paths are known, each quadrilateral that a path crosses from one
//! edge to the opposite one may have either diagonal. Dynamic programming over the last turn finds
//! the best choice along a path.
//!
//! # References
//! Evans, Skiena, Varshney: *Efficiently Generating Triangle Strips for Fast Rendering*, 1996,
//! section 3.1 (dynamic whole-face triangulation).
//!
//! # Complexity
//! O(corners) time. 28 bytes per triangle and 4 per corner.

use crate::cover::PathCover;
use crate::dual::{DualGraph, Triangulation};
use crate::ids::{HalfEdge, OptionalId};
use crate::mesh::Faces;
use crate::strip::Step;

/// Polygons with more corners keep their first triangulation, because every tentative run that
/// enters one would triangulate it again.
const RETRIANGULATION_LIMIT: usize = 64;

/// The triangulation of a greedy stripper.
pub(super) trait MutableTriangulation {
    /// Whether faces may be larger than triangles.
    const HAS_POLYGONS: bool;
    /// Maximum number of triangles up to which every policy is run. Polygon meshes are usually
    /// modelled by hand and worth more time.
    const SMALL: usize = if Self::HAS_POLYGONS { 32_768 } else { 8192 };

    /// Returns the dual graph of the current triangles.
    fn graph(&self) -> &DualGraph;

    /// Triangulates the polygon that a run enters over `exit` so that the first turn is free,
    /// unless one of its triangles is touched. Returns its new triangles.
    fn enter(
        &mut self,
        exit: u32,
        even: bool,
        is_touched: impl Fn(u32) -> bool,
    ) -> Option<std::ops::Range<u32>>;

    /// Chooses the best diagonals for known paths. The paths stay the same, but their triangles may
    /// be renumbered.
    fn optimize_diagonals(&mut self, cover: &mut PathCover);
}

/// Fixed triangles.
impl MutableTriangulation for &DualGraph {
    const HAS_POLYGONS: bool = false;

    #[inline]
    fn graph(&self) -> &DualGraph {
        self
    }
    #[inline]
    fn enter(&mut self, _: u32, _: bool, _: impl Fn(u32) -> bool) -> Option<std::ops::Range<u32>> {
        None
    }
    #[inline]
    fn optimize_diagonals(&mut self, _: &mut PathCover) {}
}

/// Polygons and their current triangles.
#[derive(Debug, Clone)]
pub(super) struct PolygonTriangulation<'a> {
    faces: &'a Faces,
    face_graph: &'a DualGraph,
    graph: DualGraph,
    triangles: Vec<u32>,
    face_of: Vec<u32>,
    /// The half-edge of a triangle on each edge of a face, by the corner where the edge starts.
    at_corner: Vec<OptionalId>,
}

impl<'a> PolygonTriangulation<'a> {
    /// Triangulates every face, starting at its first edge.
    pub(super) fn new(faces: &'a Faces, face_graph: &'a DualGraph) -> Self {
        let triangle_count = faces.triangle_count();
        let mut face_of = Vec::with_capacity(triangle_count);
        for (face, polygon) in faces.iter().enumerate() {
            face_of.resize(face_of.len() + polygon.len() - 2, face as u32);
        }
        let mut polygons = Self {
            faces,
            face_graph,
            graph: DualGraph::of_triangle_twins(std::iter::repeat_n(None, 3 * triangle_count)),
            triangles: vec![0; 3 * triangle_count],
            face_of,
            at_corner: vec![OptionalId::NONE; faces.corner_count()],
        };
        (0..faces.face_count()).for_each(|face| polygons.triangulate(face, 0, true));
        polygons
    }

    /// Returns the triangulation.
    pub(super) fn into_triangulation(self) -> Triangulation<'a> {
        Triangulation::from_parts(self.triangles, self.graph)
    }

    /// Triangulates a face by alternate turns, starting at the edge of the corner `from`. `even`
    /// selects the first turn. The triangles are numbered in the order of a strip that enters each
    /// of them over its edge 0.
    fn triangulate(&mut self, face: usize, from: u32, even: bool) {
        let range = self.faces.range(face);
        let (start, size) = (range.start as u32, range.len() as u32);
        let before = |corner: u32| if corner == 0 { size - 1 } else { corner - 1 };
        let after = |corner: u32| if corner + 1 == size { 0 } else { corner + 1 };
        let first = self.first_triangle(face);
        // The entry and the side of the first triangle's other boundary edge identify a
        // triangulation.
        let (second, second_edge) = if even { (before(from), 2) } else { (after(from), 1) };
        let at = |corner: u32| self.at_corner[(start + corner) as usize];
        if [at(from), at(second)] == [3 * first, 3 * first + second_edge].map(OptionalId::some) {
            return;
        }
        let vertices = &self.faces.corners()[range];
        // The remaining part is entered over the edge p → q.
        let (mut p, mut q, mut even) = (from, after(from), even);
        let mut entry_corner = Some(from);
        let mut diagonal = None;
        for triangle in first..first + size - 2 {
            let base = 3 * triangle;
            let r = if even { before(p) } else { after(q) };
            for (half_edge, corner) in (base..).zip([p, q, r]) {
                self.triangles[half_edge as usize] = vertices[corner as usize];
            }
            if let Some(diagonal) = diagonal {
                self.pair(diagonal, Some(base));
            }
            // One of the other two edges is on the boundary of the face. For the last triangle both
            // are.
            let mut corners =
                [entry_corner.take(), (after(q) == r).then_some(q), (after(r) == p).then_some(r)];
            for (half_edge, corner) in (base..).zip(&mut corners) {
                if let Some(corner) = corner.take() {
                    self.at_corner[(start + corner) as usize] = OptionalId::some(half_edge);
                    let outside = self.face_graph.twin(HalfEdge(start + corner));
                    let twin = outside.and_then(|outside| self.at_corner[outside.0 as usize].get());
                    self.pair(half_edge, twin);
                }
            }
            diagonal = Some(base + if even { 1 } else { 2 });
            if even {
                p = r
            } else {
                q = r
            }
            even = !even;
        }
    }

    /// Returns the first triangle of a face. Each previous face has two triangles fewer than
    /// corners.
    fn first_triangle(&self, face: usize) -> u32 {
        (self.faces.range(face).start - 2 * face) as u32
    }

    /// Returns the edge of the face that contains a half-edge, counted within the face, or `None`
    /// for a diagonal.
    fn face_edge(&self, face: usize, half_edge: u32) -> Option<u32> {
        self.at_corner[self.faces.range(face)]
            .iter()
            .position(|&at| at == OptionalId::some(half_edge))
            .map(|edge| edge as u32)
    }

    /// Makes two half-edges twins, or one half-edge a boundary.
    fn pair(&mut self, half_edge: u32, twin: Option<u32>) {
        self.graph.set_twin(half_edge, twin);
        if let Some(twin) = twin {
            self.graph.set_twin(twin, Some(half_edge));
        }
    }

    /// Returns the edges of a quadrilateral over which a path enters and leaves its two triangles,
    /// or `None` unless these edges are opposite.
    fn crossing(&self, step: Step, then: Step) -> Option<QuadCrossing> {
        let face = self.face_of[step.triangle as usize];
        let range = self.faces.range(face as usize);
        if range.len() != 4 || self.face_of[then.triangle as usize] != face {
            return None;
        }
        let entry = self.face_edge(face as usize, 3 * step.triangle + step.entry)?;
        let exit = self.face_edge(face as usize, 3 * then.triangle + then.exit)?;
        (entry ^ exit == 2).then_some(QuadCrossing { face, entry, exit })
    }

    /// Sets the diagonal of a crossed quadrilateral so that the path turns in the given direction
    /// first, then in the other.
    fn set_diagonal(&mut self, cover: &mut PathCover, crossing: QuadCrossing, first_turn: bool) {
        let first = self.first_triangle(crossing.face as usize);
        self.triangulate(crossing.face as usize, crossing.entry, first_turn);
        let exit_corner = self.faces.range(crossing.face as usize).start as u32 + crossing.exit;
        cover.set_edges(first, 0, if first_turn { 1 } else { 2 });
        if let Some(exit) = self.at_corner[exit_corner as usize].get() {
            cover.set_edges(first + 1, 0, exit % 3);
        }
    }
}

/// A quadrilateral that a path crosses, and the edges of entry and exit, numbered within the
/// quadrilateral.
#[derive(Debug, Clone, Copy)]
struct QuadCrossing {
    face: u32,
    entry: u32,
    exit: u32,
}

/// A section of a path: a triangle with a fixed turn, or a quadrilateral with a free choice of the
/// first turn.
#[derive(Debug, Clone, Copy)]
enum Passage {
    Fixed(bool),
    Free(QuadCrossing),
}

impl MutableTriangulation for PolygonTriangulation<'_> {
    const HAS_POLYGONS: bool = true;

    fn graph(&self) -> &DualGraph {
        &self.graph
    }

    fn enter(
        &mut self,
        exit: u32,
        even: bool,
        is_touched: impl Fn(u32) -> bool,
    ) -> Option<std::ops::Range<u32>> {
        let entry = self.graph.twin_of(exit)?;
        let face = self.face_of[entry as usize / 3] as usize;
        let size = self.faces.range(face).len();
        let first = self.first_triangle(face);
        let triangles = first..first + size as u32 - 2;
        if size == 3 || size > RETRIANGULATION_LIMIT || triangles.clone().any(is_touched) {
            return None;
        }
        let edge = self.face_edge(face, entry)?;
        self.triangulate(face, edge, even);
        Some(triangles)
    }

    fn optimize_diagonals(&mut self, cover: &mut PathCover) {
        let starts: Vec<_> = cover.path_starts(&self.graph).collect();
        let (mut passages, mut chosen) = (Vec::new(), Vec::new());
        for start in starts {
            let steps: Vec<Step> = cover
                .walk(&self.graph, start)
                .filter_map(|(face, entry, exit)| {
                    Some(Step { triangle: face.0, entry: entry?.0 % 3, exit: exit?.0 % 3 })
                })
                .collect();
            passages.clear();
            let mut rest = &steps[..];
            while let [step, after @ ..] = rest {
                let crossing = after.first().and_then(|&then| self.crossing(*step, then));
                passages.push(crossing.map_or(Passage::Fixed(step.is_free_at_even()), Passage::Free));
                rest = if crossing.is_some() { &after[1..] } else { after };
            }
            choose_turns(&passages, &mut chosen);
            for (passage, &turn) in passages.iter().zip(&chosen) {
                if let Passage::Free(crossing) = *passage {
                    self.set_diagonal(cover, crossing, turn);
                }
            }
        }
    }
}

/// Chooses the first turn of each passage so that a strip along the path has the fewest swaps, in
/// the better direction.
fn choose_turns(passages: &[Passage], chosen: &mut Vec<bool>) {
    let forward = cheapest_turns(passages, true);
    let backward = cheapest_turns(passages, false);
    let (_, turns) = if backward.0 < forward.0 { backward } else { forward };
    *chosen = turns;
}

/// Finds the cheapest turns by dynamic programming over the last turn, for a strip from the start
/// or the end of the path.
fn cheapest_turns(passages: &[Passage], from_start: bool) -> (u32, Vec<bool>) {
    // The turn that is free after the first triangle of a strip, in the direction of the path.
    let free_first = !from_start;
    let mut cost = [0_u32; 2]; // by the last turn
    let mut came_from: Vec<[bool; 2]> = Vec::with_capacity(passages.len());
    for (i, passage) in passages.iter().enumerate() {
        let mut after = [u32::MAX; 2];
        let mut from = [false; 2];
        let firsts: &[bool] = match passage {
            Passage::Fixed(false) => &[false],
            Passage::Fixed(true) => &[true],
            Passage::Free(_) => &[false, true],
        };
        for &first in firsts {
            let last = first ^ matches!(passage, Passage::Free(_));
            for before in [false, true] {
                let swap = if i == 0 { from_start && first != free_first } else { before == first };
                let total = cost[usize::from(before)].saturating_add(u32::from(swap));
                if total < after[usize::from(last)] {
                    after[usize::from(last)] = total;
                    from[usize::from(last)] = before;
                }
            }
        }
        cost = after;
        came_from.push(from);
    }
    if !from_start && !passages.is_empty() {
        cost[usize::from(!free_first)] = cost[usize::from(!free_first)].saturating_add(1);
    }
    let mut last = cost[1] < cost[0];
    let least = cost[usize::from(last)];
    let mut turns = vec![false; passages.len()];
    for (i, passage) in passages.iter().enumerate().rev() {
        turns[i] = last ^ matches!(passage, Passage::Free(_));
        last = came_from[i][usize::from(last)];
    }
    (least, turns)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Counts the swaps of a strip along the turns of a path, from its start or its end.
    fn swaps(turns: &[bool], from_start: bool) -> usize {
        // From the end, the turns are in the opposite order, and each is to the other side.
        let sent: Vec<bool> =
            if from_start { turns.to_vec() } else { turns.iter().rev().map(|turn| !turn).collect() };
        // The first turn is free to the previous edge, each later one to the side opposite to the
        // turn before.
        let free = std::iter::once(false).chain(sent.iter().map(|turn| !turn));
        sent.iter().zip(free).filter(|&(&turn, free)| turn != free).count()
    }

    /// Returns the turns of a path whose passages have these first turns.
    fn turns(passages: &[Passage], firsts: &[bool]) -> Vec<bool> {
        let both = passages.iter().zip(firsts);
        both.flat_map(|(passage, &first)| match passage {
            Passage::Fixed(turn) => vec![*turn],
            Passage::Free(_) => vec![first, !first],
        })
        .collect()
    }

    proptest! {
        #[test]
        fn turns_are_as_cheap_as_by_exhaustive_search(kinds in prop::collection::vec(0..3_u8, 0..10)) {
            let crossing = QuadCrossing { face: 0, entry: 0, exit: 2 };
            let passage = |&kind| if kind == 2 { Passage::Free(crossing) } else { Passage::Fixed(kind == 1) };
            let passages: Vec<Passage> = kinds.iter().map(passage).collect();
            let all = (0..1_usize << passages.len())
                .map(|bits| turns(&passages, &(0..passages.len()).map(|i| bits >> i & 1 == 1).collect::<Vec<_>>()));
            let (mut forward, mut backward) = (usize::MAX, usize::MAX);
            for turns in all {
                forward = forward.min(swaps(&turns, true));
                backward = backward.min(swaps(&turns, false));
            }
            for (from_start, least) in [(true, forward), (false, backward)] {
                let (cost, firsts) = cheapest_turns(&passages, from_start);
                prop_assert_eq!(cost as usize, least);
                prop_assert_eq!(swaps(&turns(&passages, &firsts), from_start), least);
            }
            let mut chosen = Vec::new();
            choose_turns(&passages, &mut chosen);
            let chosen = turns(&passages, &chosen);
            prop_assert_eq!(swaps(&chosen, true).min(swaps(&chosen, false)), forward.min(backward));
            // Fixed turns do not change.
            for (passage, first) in passages.iter().zip(cheapest_turns(&passages, true).1) {
                prop_assert!(!matches!(passage, Passage::Fixed(turn) if *turn != first));
            }
        }
    }
}
