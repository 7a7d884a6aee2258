//! The polygon triangulator: cuts the faces of a strip into triangles, with as few swaps in the
//! strip as possible.
//!
//! # Algorithm
//! 1. The minimum number of swaps is computed from the strip's first face to its last, for either
//!    last turn; see [`super::turn_sequence`]. The first face has no entry and the last face has no
//!    exit, so both can be chosen.
//! 2. The winding determines on which side the first turn of a strip is free, seen from either end.
//!    Step 1 is therefore run twice: for a free turn at the start, and for a free turn at the end.
//! 3. The turns in each face are chosen backward, starting at the better end. These turns determine
//!    the triangles of the face.
//!
//! With [`TurnDiagonals::Passing`], the turns of a face are chosen when the strip passes it, for
//! the fewest swaps from the first face on.
//!
//! # Complexity
//! O(n) time. 4 bytes per triangle for the links, which are set when the triangulation is complete.

use super::remaining_faces::RemainingFaces;
use super::turn_sequence::{
    A, B, LeastSwaps, TurnCounts, TurnDiagonals, alternate, alternating_counts, append_turns, least_swaps,
};
use crate::cover::PathCover;
use crate::dual::{DualGraph, TriangulationBuilder};
use crate::ids::HalfEdge;
use crate::mesh::Faces;
use crate::stripify::StripPlan;

/// A face on a strip: where the strip enters and leaves it, and how many triangles advance on each
/// chain in between.
#[derive(Debug, Clone, Copy)]
pub(super) struct StripFace {
    pub(super) face: u32,
    pub(super) entry: Option<u32>,
    pub(super) exit: Option<u32>,
    pub(super) counts: TurnCounts,
    /// On which sides a remainder of the face is kept, by the chain of the side.
    pub(super) rests: [bool; 2],
}

/// Receives strips.
pub(super) trait StripSink {
    /// Receives a strip. Its first and last face must still be whole.
    fn receive(&mut self, strip: &[StripFace], remaining: &RemainingFaces<'_>);
}

/// Receives strips of triangles and sets the links of the cover.
#[derive(Debug)]
pub(super) struct TriangleLinker<'a> {
    graph: &'a DualGraph,
    cover: PathCover,
}

impl<'a> TriangleLinker<'a> {
    pub(super) fn new(graph: &'a DualGraph) -> Self {
        Self { graph, cover: PathCover::isolated(graph.face_count()) }
    }

    /// Returns the cover.
    pub(super) fn finish(self) -> PathCover {
        self.cover
    }
}

impl StripSink for TriangleLinker<'_> {
    fn receive(&mut self, strip: &[StripFace], _: &RemainingFaces<'_>) {
        for entry in strip.iter().filter_map(|face| face.entry) {
            self.cover.link(self.graph, HalfEdge(entry));
        }
    }
}

/// Receives strips of polygons, triangulates them and builds a plan.
#[derive(Debug)]
pub(super) struct PolygonTriangulator<'a> {
    faces: &'a Faces,
    builder: TriangulationBuilder<'a>,
    diagonals: TurnDiagonals,
    /// Half-edges over which a triangle is linked to the previous one.
    linked: Vec<u32>,
    /// The minimum swaps at the exit of each face of the current strip except the last, and the
    /// last turns chosen there.
    swaps: Vec<LeastSwaps>,
    last_turns: Vec<usize>,
    /// The turns in the current face.
    turns: Vec<usize>,
}

impl StripSink for PolygonTriangulator<'_> {
    fn receive(&mut self, strip: &[StripFace], remaining: &RemainingFaces<'_>) {
        let [first, .., last] = strip else {
            if let [only] = strip {
                self.set_alternating_turns(alternating_counts(remaining.size(only.face) - 2, B), B);
                self.cut_from(remaining.corner(only.face), only, remaining, false);
            }
            return;
        };
        let last_size = remaining.size(last.face);
        self.choose_last_turns(strip, remaining.size(first.face), last_size);
        // The entry of the first face precedes its exit by the number of corners that advance on
        // chain A, plus one.
        let length = remaining.size(first.face) - 2;
        let first_turn = alternate(self.last_turns[0], length - 1);
        let counts = alternating_counts(length, first_turn);
        let entry = first.exit.map(|exit| (0..=counts[A]).fold(exit, |corner, _| remaining.previous(corner)));
        self.set_alternating_turns(counts, first_turn);
        if let Some(entry) = entry {
            self.cut_from(entry, first, remaining, false);
        }
        for (i, face) in strip.iter().enumerate().skip(1) {
            let before = self.last_turns[i - 1];
            if face.exit.is_some() {
                self.turns.clear();
                append_turns(face.counts, before, self.last_turns[i], &mut self.turns);
            } else {
                self.set_alternating_turns(alternating_counts(last_size - 2, 1 - before), 1 - before);
            }
            if let Some(entry) = face.entry {
                self.cut_from(entry, face, remaining, true);
            }
        }
    }
}

impl<'a> PolygonTriangulator<'a> {
    pub(super) fn new(faces: &'a Faces, graph: &'a DualGraph, diagonals: TurnDiagonals) -> Self {
        let builder = TriangulationBuilder::new(faces, graph);
        let (linked, swaps, last_turns, turns) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { faces, builder, diagonals, linked, swaps, last_turns, turns }
    }

    /// Sets the turns to an alternating order.
    fn set_alternating_turns(&mut self, counts: TurnCounts, first: usize) {
        self.turns.clear();
        self.turns.extend((0..counts[A] + counts[B]).map(|i| alternate(first, i)));
    }

    /// Chooses the last turn of every face except the last: steps 1 and 2.
    fn choose_last_turns(&mut self, strip: &[StripFace], first_size: u32, last_size: u32) {
        // A strip starts as if after a turn B. Seen from the end, its last turn is free if it is a
        // B.
        let free_turn = alternate(B, first_size - 3);
        let start_swaps = [A, B].map(|last| u32::from(last != free_turn));
        let end_swaps = [A, B].map(|last| u32::from(alternate(last, last_size - 3) != B));
        let last = if self.diagonals == TurnDiagonals::Together {
            let from_behind = self.accumulate_swaps(strip, LeastSwaps::FREE);
            let at_end = LeastSwaps([A, B].map(|last| from_behind.0[last] + end_swaps[last]));
            let from_front = self.accumulate_swaps(strip, LeastSwaps(start_swaps));
            if at_end.least() < from_front.least() {
                self.accumulate_swaps(strip, LeastSwaps::FREE);
                at_end.best_turn()
            } else {
                from_front.best_turn()
            }
        } else {
            self.accumulate_swaps(strip, LeastSwaps(start_swaps)).best_turn()
        };
        self.choose_backward(strip, last);
    }

    /// Chooses the last turns backward, starting with that of the second-last face: step 3.
    fn choose_backward(&mut self, strip: &[StripFace], mut last: usize) {
        let inner_count = strip.len() - 2;
        self.last_turns.clear();
        self.last_turns.push(last);
        for i in (0..inner_count).rev() {
            let counts = strip[i + 1].counts;
            let before = self.swaps[i];
            last = LeastSwaps([A, B].map(|x| before.0[x] + least_swaps(counts, x, last))).best_turn();
            self.last_turns.push(last);
        }
        self.last_turns.reverse();
    }

    /// Accumulates the swaps from the exit of the first face to the entry of the last.
    fn accumulate_swaps(&mut self, strip: &[StripFace], start: LeastSwaps) -> LeastSwaps {
        self.swaps.clear();
        self.swaps.push(start);
        let mut swaps = start;
        for face in &strip[1..strip.len() - 1] {
            swaps = swaps.passing(face.counts, self.diagonals);
            self.swaps.push(swaps);
        }
        swaps
    }

    /// Cuts triangles by the turns, starting at an entry. A strip leaves a part of a polygon
    /// through the exit's own corners.
    fn cut_from(
        &mut self,
        entry: u32,
        strip_face: &StripFace,
        remaining: &RemainingFaces<'_>,
        is_joined: bool,
    ) {
        let original = remaining.original_face(entry) as usize;
        let base = self.faces.range(original).start as u32;
        // A strip passes only over edges of original faces. Where it passes over none, the face is
        // whole.
        let next = if strip_face.entry.is_some() {
            remaining.next_in_original(entry)
        } else {
            remaining.next(entry)
        };
        let (mut b, mut a) = (entry, next);
        let mut is_joined = is_joined;
        for &turn in &self.turns {
            let apex = match (turn, strip_face.exit.filter(|_| strip_face.rests[turn])) {
                (A, None) => remaining.next(a),
                (A, Some(exit)) => exit,
                (_, None) => remaining.previous(b),
                (_, Some(exit)) => remaining.next_in_original(exit),
            };
            let triangle = self.builder.add(original, [b - base, a - base, apex - base]);
            if is_joined {
                self.linked.push(3 * triangle);
            }
            is_joined = true;
            *(if turn == A { &mut a } else { &mut b }) = apex;
        }
    }

    /// Returns the plan. Every face must be in a strip.
    pub(super) fn finish(self) -> StripPlan<'a> {
        let triangulation = self.builder.finish();
        let graph = triangulation.graph();
        let mut cover = PathCover::isolated(triangulation.triangle_count());
        self.linked.into_iter().for_each(|half_edge| {
            cover.link(graph, HalfEdge(half_edge));
        });
        StripPlan::new(triangulation, cover)
    }
}

/// Counts the swaps of a strip of whole faces by trying every order of turns and both ends.
#[cfg(test)]
pub(super) fn brute_force_swaps(strip: &[StripFace], remaining: &RemainingFaces<'_>) -> usize {
    // A state is the first turn, if there was one, the last turn, and the number of swaps.
    let mut states: Vec<(Option<usize>, usize, usize)> = vec![(None, A, 0)];
    let add_turn = |states: &[(Option<usize>, usize, usize)], turn: usize| -> Vec<_> {
        let next = |&(first, last, swaps): &(Option<usize>, usize, usize)| {
            let is_swap = first.is_some() && last == turn;
            (first.or(Some(turn)), turn, swaps + usize::from(is_swap))
        };
        let mut all: Vec<_> = states.iter().map(next).collect();
        all.sort_unstable();
        all.dedup_by_key(|&mut (first, last, _)| (first, last));
        all
    };
    for (i, face) in strip.iter().enumerate() {
        let ends = usize::from(i == 0) + usize::from(i + 1 == strip.len());
        if ends == 0 {
            let length = face.counts[A] + face.counts[B];
            let orders = (0..1_u32 << length).filter(|order| order.count_ones() == face.counts[B]);
            let all: Vec<_> = orders
                .flat_map(|order| {
                    (0..length).fold(states.clone(), |s, i| add_turn(&s, (order >> i & 1) as usize))
                })
                .collect();
            states = all;
        } else {
            for _ in 0..(remaining.size(face.face) as usize - 2).saturating_sub(ends) {
                states = [A, B].into_iter().flat_map(|turn| add_turn(&states, turn)).collect();
            }
        }
        states.sort_unstable();
        states.dedup_by_key(|&mut (first, last, _)| (first, last));
    }
    let total = |&(first, last, swaps): &(Option<usize>, usize, usize)| {
        swaps + usize::from(first == Some(B) && last == A)
    };
    states.iter().map(total).min().unwrap_or(0)
}
