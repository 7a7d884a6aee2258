//! Weaving: a strip's faces become triangles, cut so that the strip has as few swaps as they allow.
//!
//! # Algorithm
//! 1. The least number of swaps is followed from the strip's first face to its last, for either last letter; see
//!    [`super::letters`]. The first face has no entry and the last no exit, so that one may be chosen for them.
//! 2. The winding fixes on which side the first turn of a strip is free, read from either of its ends. So step 1 is done twice:
//!    with a good beginning, and with a good end.
//! 3. Backward from the better end, each face gets its letters and these its triangles.
//!
//! # Complexity
//! O(n); 4 bytes a triangle for the links, which wait until the triangulation is whole.

use super::letters::{A, B, Counts, Swaps, alternate, alternating, least, spell};
use super::pieces::Pieces;
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::dual::TriangulationBuilder;
use crate::ids::HalfEdge;
use crate::mesh::Faces;
use crate::stripify::StripPlan;

/// A piece on a strip: where the strip enters and leaves it, and how many triangles advance on either chain between.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    pub(super) piece: u32,
    pub(super) entry: Option<u32>,
    pub(super) exit: Option<u32>,
    pub(super) counts: Counts,
    /// On which sides a rest of the piece is left, by the letter of the side's chain.
    pub(super) rests: [bool; 2],
}

/// Takes strips, the pieces of the last of which must still be whole where it begins and ends.
pub(super) trait Sink {
    /// Takes a strip.
    fn take(&mut self, strip: &[Step], pieces: &Pieces<'_>);
}

/// Takes strips of triangles.
#[derive(Debug)]
pub(super) struct Linker<'a> {
    graph: &'a DualGraph,
    cover: PathCover,
}

impl<'a> Linker<'a> {
    pub(super) fn new(graph: &'a DualGraph) -> Self {
        Self { graph, cover: PathCover::isolated(graph.face_count()) }
    }

    pub(super) fn finish(self) -> PathCover {
        self.cover
    }
}

impl Sink for Linker<'_> {
    fn take(&mut self, strip: &[Step], _: &Pieces<'_>) {
        for entry in strip.iter().filter_map(|step| step.entry) {
            self.cover.link(self.graph, HalfEdge(entry));
        }
    }
}

/// Takes strips of polygons and makes a plan of them.
#[derive(Debug)]
pub(super) struct Weaver<'a> {
    faces: &'a Faces,
    graph: &'a DualGraph,
    builder: TriangulationBuilder<'a>,
    /// Half-edges over which a triangle is linked to the one before.
    linked: Vec<u32>,
    swaps: Vec<Swaps>,
    lasts: Vec<usize>,
    letters: Vec<usize>,
}

impl Sink for Weaver<'_> {
    fn take(&mut self, strip: &[Step], pieces: &Pieces<'_>) {
        let [first, .., last] = strip else {
            if let [only] = strip {
                self.spread(alternating(pieces.size(only.piece) - 2, B), B);
                self.cut_from(pieces.corner(only.piece), only, pieces, false);
            }
            return;
        };
        let last_size = pieces.size(last.piece);
        self.choose_letters(strip, pieces.size(first.piece), last_size);
        // The first face: back from its exit over as many corners as advance on chain A, and one.
        let length = pieces.size(first.piece) - 2;
        let end = self.lasts[0];
        let start = alternate(end, length - 1);
        let counts = alternating(length, start);
        let entry = first.exit.map(|exit| (0..=counts[A]).fold(exit, |corner, _| pieces.previous(corner)));
        self.spread(counts, start);
        if let Some(entry) = entry {
            self.cut_from(entry, first, pieces, false);
        }
        for (i, step) in strip.iter().enumerate().skip(1) {
            let before = self.lasts[i - 1];
            if step.exit.is_some() {
                self.letters.clear();
                spell(step.counts, before, self.lasts[i], &mut self.letters);
            } else {
                self.spread(alternating(last_size - 2, 1 - before), 1 - before);
            }
            if let Some(entry) = step.entry {
                self.cut_from(entry, step, pieces, true);
            }
        }
    }
}

impl<'a> Weaver<'a> {
    pub(super) fn new(faces: &'a Faces, graph: &'a DualGraph) -> Self {
        let builder = TriangulationBuilder::new(faces, graph);
        let (swaps, lasts, letters) = (Vec::new(), Vec::new(), Vec::new());
        Self { faces, graph, builder, linked: Vec::new(), swaps, lasts, letters }
    }

    /// Sets the letters to an alternating order.
    fn spread(&mut self, counts: Counts, first: usize) {
        self.letters.clear();
        self.letters.extend((0..counts[A] + counts[B]).map(|i| alternate(first, i)));
    }

    /// Chooses the last letter of every face but the last: steps 1 and 2.
    fn choose_letters(&mut self, strip: &[Step], first_size: u32, last_size: u32) {
        // Before the first turn a strip stands as after a B; the last turn is free from behind where it is a B.
        let natural = alternate(B, first_size - 3);
        let begin = [A, B].map(|last| u32::from(last != natural));
        let end = [A, B].map(|last| u32::from(alternate(last, last_size - 3) != B));
        let from_behind = self.follow(strip, Swaps::FREE);
        let at_end = [A, B].map(|last| from_behind.0[last] + end[last]);
        let from_front = self.follow(strip, Swaps(begin));
        let mut last = from_front.letter();
        if at_end[A].min(at_end[B]) < from_front.least() {
            self.follow(strip, Swaps::FREE);
            last = Swaps(at_end).letter();
        }
        let inner = strip.len() - 2;
        self.lasts.clear();
        self.lasts.push(last);
        for i in (0..inner).rev() {
            let counts = strip[i + 1].counts;
            let before = self.swaps[i];
            last = Swaps([A, B].map(|x| before.0[x] + least(counts, x, last))).letter();
            self.lasts.push(last);
        }
        self.lasts.reverse();
    }

    /// Follows the swaps from the exit of the first face to the entry of the last.
    fn follow(&mut self, strip: &[Step], begin: Swaps) -> Swaps {
        self.swaps.clear();
        self.swaps.push(begin);
        let mut swaps = begin;
        for step in &strip[1..strip.len() - 1] {
            swaps = swaps.through(step.counts);
            self.swaps.push(swaps);
        }
        swaps
    }

    /// Cuts triangles from an entry on, by the letters. A strip leaves a part of a polygon by its exit's own corners.
    fn cut_from(&mut self, entry: u32, step: &Step, pieces: &Pieces<'_>, joined: bool) {
        let face = self.graph.face_of(HalfEdge(entry)).0 as usize;
        let base = self.faces.range(face).start as u32;
        // Only a face's own edges are passed; where no edge is passed the piece is whole.
        let (mut b, mut a) =
            (entry, if step.entry.is_some() { pieces.after(entry) } else { pieces.next(entry) });
        let mut joined = joined;
        for &letter in &self.letters {
            let apex = match (letter, step.exit.filter(|_| step.rests[letter])) {
                (A, None) => pieces.next(a),
                (A, Some(exit)) => exit,
                (_, None) => pieces.previous(b),
                (_, Some(exit)) => pieces.after(exit),
            };
            let triangle = self.builder.add(face, [b - base, a - base, apex - base]);
            if joined {
                self.linked.push(3 * triangle);
            }
            joined = true;
            *(if letter == A { &mut a } else { &mut b }) = apex;
        }
    }

    /// Gives the plan. Every face must be in a strip.
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

/// Counts the swaps of a strip of whole pieces by trying every order of the letters, and both ends.
#[cfg(test)]
pub(super) fn fewest_swaps(strip: &[Step], pieces: &Pieces<'_>) -> usize {
    // The states are the first turn, if there was one, and the last letter.
    let mut states: Vec<(Option<usize>, usize, usize)> = vec![(None, A, 0)];
    let turn = |states: &[(Option<usize>, usize, usize)], letter: usize| -> Vec<_> {
        let next = |&(first, last, swaps): &(Option<usize>, usize, usize)| {
            let swap = first.is_some() && last == letter;
            (first.or(Some(letter)), letter, swaps + usize::from(swap))
        };
        let mut all: Vec<_> = states.iter().map(next).collect();
        all.sort_unstable();
        all.dedup_by_key(|&mut (first, last, _)| (first, last));
        all
    };
    for (i, step) in strip.iter().enumerate() {
        let ends = usize::from(i == 0) + usize::from(i + 1 == strip.len());
        if ends == 0 {
            let length = step.counts[A] + step.counts[B];
            let orders = (0..1_u32 << length).filter(|order| order.count_ones() == step.counts[B]);
            let all: Vec<_> = orders
                .flat_map(|order| {
                    (0..length).fold(states.clone(), |s, i| turn(&s, (order >> i & 1) as usize))
                })
                .collect();
            states = all;
        } else {
            for _ in 0..(pieces.size(step.piece) as usize - 2).saturating_sub(ends) {
                states = [A, B].into_iter().flat_map(|letter| turn(&states, letter)).collect();
            }
        }
        states.sort_unstable();
        states.dedup_by_key(|&mut (first, last, _)| (first, last));
    }
    let pay = |&(first, last, swaps): &(Option<usize>, usize, usize)| {
        swaps + usize::from(first == Some(B) && last == A)
    };
    states.iter().map(pay).min().unwrap_or(0)
}
