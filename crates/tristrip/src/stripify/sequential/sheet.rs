//! The sheet that strips are peeled off: triangles that are fixed, or polygons that are cut into triangles as a strip passes.
//!
//! ```text
//!   d ─── c      a strip that enters over a–b, its next free turn to the left or to the right, finds the diagonal
//!   │     │      that lets it cross to c–d without a swap: a–c or b–d
//!   a ─── b
//! ```
//! # Algorithm
//! *Entering*: a polygon of at most 64 corners of which no triangle is taken is cut by alternate turns from the edge where a run enters it, the
//! first turn the one that is free there.
//!
//! *Settling*: when the paths are known, each quadrilateral that a path crosses from one edge to the opposite one may still have
//! either diagonal. Along a path the best choice of all of them is found by dynamic programming over the last turn.
//!
//! # References
//! Evans, Skiena, Varshney: *Efficiently Generating Triangle Strips for Fast Rendering*, 1996, section 3.1 (dynamic
//! whole-face triangulation).
//!
//! # Complexity
//! O(corners) time; 28 bytes a triangle and 4 a corner.

use super::NONE;
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::dual::Triangulation;
use crate::ids::HalfEdge;
use crate::mesh::Faces;
use crate::strip::Step;

/// Polygons of more corners stay as they are cut at first: each trial that enters one would cut it again.
const RECUT_LIMIT: usize = 64;

/// What a peeler takes strips off.
pub(super) trait Sheet {
    /// Whether faces may be larger than triangles.
    const HAS_POLYGONS: bool;
    /// Sheets of at most so many triangles are stripped in every manner; polygon meshes are made by hand, and worth more time.
    const SMALL: usize = if Self::HAS_POLYGONS { 32_768 } else { 8192 };

    /// The dual graph of the triangles as they are now.
    fn graph(&self) -> &DualGraph;

    /// Cuts the polygon that a run enters over `exit` so that its first turn is free, if no triangle of it is touched.
    /// Returns the triangles that it then has.
    fn enter(
        &mut self,
        exit: u32,
        even: bool,
        is_touched: impl Fn(u32) -> bool,
    ) -> Option<std::ops::Range<u32>>;

    /// Chooses diagonals again, now that the paths are known. The paths stay, but their triangles may be renamed.
    fn settle(&mut self, cover: &mut PathCover);
}

/// Triangles, which stay as they are.
impl Sheet for &DualGraph {
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
    fn settle(&mut self, _: &mut PathCover) {}
}

/// Polygons and how they are cut now.
#[derive(Debug, Clone)]
pub(super) struct Polygons<'a> {
    faces: &'a Faces,
    face_graph: &'a DualGraph,
    graph: DualGraph,
    triangles: Vec<u32>,
    face_of: Vec<u32>,
    /// The half-edge of a triangle over each edge of a face, named by its corner.
    at_corner: Vec<u32>,
}

impl<'a> Polygons<'a> {
    /// Cuts every face from its first edge.
    pub(super) fn new(faces: &'a Faces, face_graph: &'a DualGraph) -> Self {
        let triangle_count = faces.triangle_count();
        let mut face_of = Vec::with_capacity(triangle_count);
        for (face, polygon) in faces.iter().enumerate() {
            face_of.resize(face_of.len() + polygon.len() - 2, face as u32);
        }
        let mut polygons = Self {
            faces,
            face_graph,
            graph: DualGraph::from_triangle_twins(vec![NONE; 3 * triangle_count]),
            triangles: vec![NONE; 3 * triangle_count],
            face_of,
            at_corner: vec![NONE; faces.corner_count()],
        };
        (0..faces.face_count()).for_each(|face| polygons.cut(face, 0, true));
        polygons
    }

    /// Gives up the triangles.
    pub(super) fn into_triangulation(self) -> Triangulation<'a> {
        Triangulation::from_parts(self.triangles, self.graph)
    }

    /// Cuts a face by alternate turns from the edge that begins at one of its corners; `even` tells which turn comes first.
    /// Its triangles are numbered in the order in which a strip from that edge meets them, and each is entered over its edge 0.
    fn cut(&mut self, face: usize, from: u32, even: bool) {
        let range = self.faces.range(face);
        let (start, size) = (range.start as u32, range.len() as u32);
        let at = |place: u32| start + place;
        let before = |place: u32| if place == 0 { size - 1 } else { place - 1 };
        let after = |place: u32| if place + 1 == size { 0 } else { place + 1 };
        let vertices = &self.faces.corners()[range];
        // The part that is left is entered over the edge p → q.
        let (mut p, mut q, mut even) = (from, after(from), even);
        let mut entry_corner = Some(from);
        let mut diagonal = NONE;
        let first = self.first_triangle(face);
        for triangle in first..first + size - 2 {
            let base = 3 * triangle;
            let r = if even { before(p) } else { after(q) };
            for (half_edge, place) in (base..).zip([p, q, r]) {
                self.triangles[half_edge as usize] = vertices[place as usize];
            }
            if diagonal != NONE {
                self.join(diagonal, base);
            }
            // Of the other two edges one lies on the face's boundary, both for the last triangle.
            let mut corners =
                [entry_corner.take(), (after(q) == r).then_some(q), (after(r) == p).then_some(r)];
            for (half_edge, corner) in (base..).zip(&mut corners) {
                if let Some(corner) = corner.take() {
                    self.at_corner[at(corner) as usize] = half_edge;
                    let outside = self.face_graph.twin(HalfEdge(at(corner)));
                    let twin = outside.map_or(NONE, |outside| self.at_corner[outside.0 as usize]);
                    self.join(half_edge, twin);
                }
            }
            diagonal = base + if even { 1 } else { 2 };
            if even {
                p = r
            } else {
                q = r
            }
            even = !even;
        }
    }

    /// Gives the first triangle of a face: each face before it has two triangles fewer than corners.
    fn first_triangle(&self, face: usize) -> u32 {
        (self.faces.range(face).start - 2 * face) as u32
    }

    /// Gives the place within its face of the edge that a half-edge runs over; `None` for a diagonal.
    fn place(&self, face: usize, half_edge: u32) -> Option<u32> {
        self.at_corner[self.faces.range(face)]
            .iter()
            .position(|&at| at == half_edge)
            .map(|place| place as u32)
    }

    fn join(&mut self, half_edge: u32, twin: u32) {
        let twins = self.graph.twins_mut();
        twins[half_edge as usize] = twin;
        if twin != NONE {
            twins[twin as usize] = half_edge;
        }
    }

    /// Tells the places of the edges within a quadrilateral over which a path crosses two neighbouring triangles of it from one
    /// side to the opposite one.
    fn crossing(&self, step: Step, then: Step) -> Option<Crossing> {
        let face = self.face_of[step.triangle as usize];
        let range = self.faces.range(face as usize);
        if range.len() != 4 || self.face_of[then.triangle as usize] != face {
            return None;
        }
        let entry = self.place(face as usize, 3 * step.triangle + step.entry)?;
        let exit = self.place(face as usize, 3 * then.triangle + then.exit)?;
        (entry ^ exit == 2).then_some(Crossing { face, entry, exit })
    }

    /// Gives a crossed quadrilateral the diagonal by which the path's turns are this one, then the other.
    fn turn(&mut self, cover: &mut PathCover, crossing: Crossing, first_turn: bool) {
        let first = self.first_triangle(crossing.face as usize);
        self.cut(crossing.face as usize, crossing.entry, first_turn);
        let exit_corner = self.faces.range(crossing.face as usize).start as u32 + crossing.exit;
        let exit = self.at_corner[exit_corner as usize];
        cover.set_edges(first, 0, if first_turn { 1 } else { 2 });
        cover.set_edges(first + 1, 0, exit % 3);
    }
}

/// A quadrilateral that a path crosses: the places of the two edges.
#[derive(Debug, Clone, Copy)]
struct Crossing {
    face: u32,
    entry: u32,
    exit: u32,
}

/// What a path passes: a triangle that turns one way, or a quadrilateral that may turn both ways.
#[derive(Debug, Clone, Copy)]
enum Passage {
    Fixed(bool),
    Free(Crossing),
}

impl Sheet for Polygons<'_> {
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
        let entry = self.graph.twins()[exit as usize];
        let face = self.face_of[entry as usize / 3] as usize;
        let size = self.faces.range(face).len();
        let first = self.first_triangle(face);
        let triangles = first..first + size as u32 - 2;
        if size == 3 || size > RECUT_LIMIT || triangles.clone().any(is_touched) {
            return None;
        }
        let place = self.place(face, entry)?;
        self.cut(face, place, even);
        Some(triangles)
    }

    fn settle(&mut self, cover: &mut PathCover) {
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
                    self.turn(cover, crossing, turn);
                }
            }
        }
    }
}

/// Chooses each passage's first turn so that a strip along the path takes the fewest swaps, from whichever end it is sent.
fn choose_turns(passages: &[Passage], chosen: &mut Vec<bool>) {
    let forward = cheapest_turns(passages, true);
    let backward = cheapest_turns(passages, false);
    let (_, turns) = if backward.0 < forward.0 { backward } else { forward };
    *chosen = turns;
}

/// Finds the cheapest turns by dynamic programming over the last one, sent from the path's start or from its end.
fn cheapest_turns(passages: &[Passage], from_start: bool) -> (u32, Vec<bool>) {
    // The turn that is free right after the first triangle of a strip, as seen along the path.
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

    /// Counts the swaps of a strip along a path's turns, the diagonals given, sent from the path's start or from its end.
    fn swaps(turns: &[bool], from_start: bool) -> usize {
        // Sent from the end, the turns come in opposite order, each to the other side.
        let sent: Vec<bool> =
            if from_start { turns.to_vec() } else { turns.iter().rev().map(|turn| !turn).collect() };
        // The first turn is free to the previous edge, and each after it to the side opposite the one before.
        let free = std::iter::once(false).chain(sent.iter().map(|turn| !turn));
        sent.iter().zip(free).filter(|&(&turn, free)| turn != free).count()
    }

    /// The turns of a path, its passages entered with these first turns.
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
        fn turns_are_chosen_as_by_trying_all(kinds in prop::collection::vec(0..3_u8, 0..10)) {
            let crossing = Crossing { face: 0, entry: 0, exit: 2 };
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
            // What is fixed stays.
            for (passage, first) in passages.iter().zip(cheapest_turns(&passages, true).1) {
                prop_assert!(!matches!(passage, Passage::Fixed(turn) if *turn != first));
            }
        }
    }
}
