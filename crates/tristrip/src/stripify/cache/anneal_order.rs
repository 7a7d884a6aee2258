//! Order annealing: a search over strips in drawing order. Each move is priced exactly in indices
//! and in misses of a FIFO cache.
//!
//! # Algorithm
//! Simulated annealing. A move replaces the strips at one or two positions of the order by zero to
//! two others:
//! ```text
//!   transfer  A ━━t  ┄u━━ B        the end t of A takes u from B and what follows u on one side
//!   join      A ━━t  ┄ u━━B        a transfer after which nothing of B remains
//!   cut       A ━━━━┊━━━━          two strips, one after the other
//!   reverse   A from its other end
//!   reorder   A drawn before or after the strip of a neighbour, from either end
//! ```
//! Indices change only at these positions. Misses change until a strip starts with the same cache
//! contents as before. Everything after that strip remains the same. This usually takes a few
//! strips. The contents at the start of each strip are stored for this comparison. A move whose
//! effect lasts longer than [`WINDOW`] strips is rejected.
//!
//! # Complexity
//! O(entries + vertices of the strips in between) time per move. The effort counts the vertices
//! that moves simulate. 60 bytes per triangle, and 4 bytes per cache entry for each strip.

use super::policy::PolicyWeights;
use super::resettable_fifo::ResettableFifo;
use crate::cover::PathCover;
use crate::dual::{DualGraph, Triangulation};
use crate::ids::{FaceId, HalfEdge, OptionalId};
use crate::random::{Random, metropolis};
use crate::strip::{OPEN, Step, path_steps, send_path};

/// Number of strips after a move within which the cache must reach the same contents as before.
const WINDOW: usize = 48;
/// Effort of a proposal without its simulation, in vertices sent.
const PROPOSAL_EFFORT: u64 = 8;
/// Number of temperature steps.
const STAGES: u64 = 64;
/// Larger increases of the cost are never accepted.
const RISES: usize = 64;
/// Initial distance between the keys of consecutive strips.
const GAP: u64 = 1 << 20;

/// Strips in drawing order, with the vertices and misses of each and the cache contents before it.
pub(super) struct StripSequence<'a> {
    graph: &'a DualGraph,
    triangles: &'a [u32],
    entry_count: usize,
    weights: PolicyWeights,
    strips: Vec<SequencedStrip>,
    /// The cache contents before each strip.
    contents_before: Vec<u32>,
    /// The strip of each triangle.
    strip_of: Vec<u32>,
    /// Removed strips, for reuse.
    free: Vec<u32>,
    first: OptionalId,
    fifo: ResettableFifo,
    /// Number of vertices sent in simulations.
    sent: u64,
    /// The cost saved so far.
    saved: i64,
    /// The result of the last simulation: strips with their misses, and the cache contents before
    /// each.
    simulated: Vec<(StripPart, u32)>,
    simulated_before: Vec<u32>,
}

/// A strip in a doubly linked list. Keys increase along the list.
#[derive(Debug, Clone, Default)]
struct SequencedStrip {
    steps: Vec<Step>,
    vertices: Vec<u32>,
    misses: u32,
    next: OptionalId,
    previous: OptionalId,
    key: u64,
}

/// A strip after a move: the strip itself (part 0), or one of the parts that replace it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct StripPart {
    strip: u32,
    part: u32,
}

/// A strip and the parts that replace it.
#[derive(Debug, Clone)]
struct StripEdit {
    strip: u32,
    parts: Vec<Vec<Step>>,
    vertices: Vec<Vec<u32>>,
}

impl<'a> StripSequence<'a> {
    /// Creates the sequence of the paths of a cover. `order` has the first triangle of each path in
    /// drawing order.
    pub(super) fn new(
        triangulation: &'a Triangulation<'_>,
        cover: &PathCover,
        order: &[FaceId],
        entry_count: u32,
        weights: PolicyWeights,
    ) -> Self {
        let vertex_count = triangulation.triangles().iter().max().map_or(0, |&highest| highest as usize + 1);
        let (graph, triangles) = (triangulation.graph(), triangulation.triangles());
        let entry_count = entry_count as usize;
        let mut sequence = Self {
            graph,
            triangles,
            entry_count,
            weights,
            strips: Vec::with_capacity(order.len()),
            contents_before: Vec::with_capacity(order.len() * entry_count),
            strip_of: vec![0; graph.face_count()],
            free: Vec::new(),
            first: (!order.is_empty()).then_some(0).into(),
            fifo: ResettableFifo::new(entry_count, vertex_count),
            sent: 0,
            saved: 0,
            simulated: Vec::new(),
            simulated_before: Vec::new(),
        };
        for (i, &start) in order.iter().enumerate() {
            let steps: Vec<Step> = path_steps(graph, cover, start).collect();
            let vertices = sequence.vertices_of(&steps);
            sequence.contents_before.extend_from_slice(sequence.fifo.contents());
            let misses = sequence.fifo.access(&vertices);
            steps.iter().for_each(|step| sequence.strip_of[step.triangle as usize] = i as u32);
            sequence.strips.push(SequencedStrip {
                steps,
                vertices,
                misses,
                next: (i + 1 < order.len()).then_some(i as u32 + 1).into(),
                previous: (i as u32).checked_sub(1).into(),
                key: (i as u64 + 1) * GAP,
            });
        }
        sequence
    }

    /// Tries moves at temperatures from `hottest` to `coldest`, in indices, until simulations have
    /// sent `limit` vertices. The time of a move is proportional to the lengths of its strips.
    /// Before each of the [`STAGES`], `go_on` receives the vertices sent, the number of strips and
    /// the cost saved, and returns whether to continue.
    pub(super) fn anneal(
        &mut self,
        random: &mut Random,
        limit: u64,
        [hottest, coldest]: [f64; 2],
        mut go_on: impl FnMut(u64, usize, i64) -> bool,
    ) {
        self.sent = 0;
        for stage in 0..STAGES {
            if !go_on(self.sent, self.strips.len() - self.free.len(), self.saved) {
                return;
            }
            let cooled = stage as f64 / (STAGES - 1) as f64;
            let temperature = (hottest + (coldest - hottest) * cooled) * self.weights.index as f64;
            let odds = metropolis::<RISES>(temperature);
            while self.sent < limit * (stage + 1) / STAGES {
                let draw = (random.next_u64() >> 32) as u32;
                self.sent += PROPOSAL_EFFORT;
                let Some(edits) = self.propose(random) else { continue };
                let Some(rise) = self.price(&edits) else { continue };
                let is_accepted = match usize::try_from(rise) {
                    Ok(rise @ 1..) => odds.get(rise - 1).is_some_and(|&odds| draw < odds),
                    _ => true,
                };
                if is_accepted {
                    self.saved -= rise;
                    self.commit(edits);
                }
            }
        }
    }

    /// Returns the cover and the first triangle of each path in drawing order.
    pub(super) fn finish(&self) -> (PathCover, Vec<FaceId>) {
        let mut cover = PathCover::isolated(self.graph.face_count());
        let mut order = Vec::new();
        let mut at = self.first.get();
        while let Some(strip) = at.map(|at| &self.strips[at as usize]) {
            order.extend(strip.steps.first().map(|step| FaceId(step.triangle)));
            for step in strip.steps.iter().filter(|step| step.exit != OPEN) {
                cover.link(self.graph, HalfEdge(3 * step.triangle + step.exit));
            }
            at = strip.next.get();
        }
        (cover, order)
    }

    fn vertices_of(&self, steps: &[Step]) -> Vec<u32> {
        let mut vertices = Vec::with_capacity(steps.len() + steps.len() / 2 + 2);
        send_path(self.triangles, steps.iter().copied(), &mut vertices);
        vertices
    }

    fn edit(&self, strip: u32, parts: Vec<Vec<Step>>) -> StripEdit {
        let parts: Vec<Vec<Step>> = parts.into_iter().filter(|part| !part.is_empty()).collect();
        let vertices = parts.iter().map(|part| self.vertices_of(part)).collect();
        StripEdit { strip, parts, vertices }
    }

    /// Returns a random move, or `None` if the random choices do not give a valid one.
    fn propose(&self, random: &mut Random) -> Option<Vec<StripEdit>> {
        let a = *self.strip_of.get(random.below(self.strip_of.len()))?;
        let strip = &self.strips[a as usize].steps;
        let last = strip.len() - 1;
        match random.below(16) {
            0 if last > 0 => Some(vec![self.edit(a, vec![reversed(strip)])]),
            1 | 2 if last > 0 => {
                let at = 1 + random.below(last);
                let (mut left, mut right) = (strip[..at].to_vec(), strip[at..].to_vec());
                left[at - 1].exit = OPEN;
                right[0].entry = OPEN;
                if random.coin() {
                    std::mem::swap(&mut left, &mut right);
                }
                Some(vec![self.edit(a, vec![left, right])])
            }
            3 | 4 => {
                let triangle = strip[random.below(strip.len())].triangle;
                let twin = self.graph.twin(HalfEdge(3 * triangle + random.below(3) as u32))?;
                let b = self.strip_of[twin.0 as usize / 3];
                if a == b {
                    return None;
                }
                let other = self.strips[b as usize].steps.clone();
                let moved = if random.coin() { strip.clone() } else { reversed(strip) };
                let pair = if random.coin() { vec![moved, other] } else { vec![other, moved] };
                Some(self.ordered(self.edit(a, vec![]), self.edit(b, pair)))
            }
            _ => self.propose_transfer(a, random),
        }
    }

    /// Returns a random transfer of a neighbour to an end of a strip.
    fn propose_transfer(&self, a: u32, random: &mut Random) -> Option<Vec<StripEdit>> {
        let strip = &self.strips[a as usize].steps;
        let at_end = random.coin();
        let end = if at_end { strip.last() } else { strip.first() }?;
        let exit = random.below(3) as u32;
        let twin = self.graph.twin(HalfEdge(3 * end.triangle + exit))?;
        let (taken, entry) = (twin.0 / 3, twin.0 % 3);
        let b = self.strip_of[taken as usize];
        if a == b {
            return None;
        }
        let other = &self.strips[b as usize].steps;
        let at = other.iter().position(|step| step.triangle == taken)?;
        // The strip in the direction in which the growing end comes last.
        let mut grown = if at_end { strip.clone() } else { reversed(strip) };
        grown.last_mut()?.exit = exit;
        // The triangles on one side of the taken one are transferred too; the other side remains.
        let backward = random.coin();
        let (mut gained, mut remaining) = if backward {
            (reversed(&other[..=at]), other[at + 1..].to_vec())
        } else {
            (other[at..].to_vec(), other[..at].to_vec())
        };
        gained[0].entry = entry;
        if let Some(cut) = if backward { remaining.first_mut() } else { remaining.last_mut() } {
            *(if backward { &mut cut.entry } else { &mut cut.exit }) = OPEN;
        }
        grown.extend(gained);
        if !at_end {
            grown = reversed(&grown);
        }
        // A strip that takes all of another may be drawn at the other's position.
        let (here, there) = if remaining.is_empty() && random.coin() {
            (vec![], vec![grown])
        } else {
            (vec![grown], vec![remaining])
        };
        Some(self.ordered(self.edit(a, here), self.edit(b, there)))
    }

    fn ordered(&self, a: StripEdit, b: StripEdit) -> Vec<StripEdit> {
        let key = |edit: &StripEdit| self.strips[edit.strip as usize].key;
        if key(&a) < key(&b) { vec![a, b] } else { vec![b, a] }
    }

    /// Returns the increase of the cost by a move, or `None` if its effect on the cache lasts too
    /// long. The simulation is stored for [`StripSequence::commit`].
    fn price(&mut self, edits: &[StripEdit]) -> Option<i64> {
        self.simulated.clear();
        self.simulated_before.clear();
        let (mut indices, mut misses) = (0_i64, 0_i64);
        let mut pending = edits.iter().peekable();
        while let Some(first) = pending.peek() {
            let mut at = first.strip;
            let start = at as usize * self.entry_count;
            self.fifo.set(&self.contents_before[start..start + self.entry_count]);
            let mut unchanged = 0;
            loop {
                let strip = &self.strips[at as usize];
                let edit = pending.next_if(|edit| edit.strip == at);
                misses -= i64::from(strip.misses);
                let parts = edit.map_or(std::slice::from_ref(&strip.vertices), |edit| &edit.vertices);
                for (part, vertices) in parts.iter().enumerate() {
                    self.simulated_before.extend_from_slice(self.fifo.contents());
                    let missed = self.fifo.access(vertices);
                    self.sent += vertices.len() as u64;
                    self.simulated.push((StripPart { strip: at, part: part as u32 }, missed));
                    misses += i64::from(missed);
                }
                if edit.is_some() {
                    let sent = |v: &Vec<u32>| (v.len() + 1).cast_signed() as i64;
                    indices += parts.iter().map(sent).sum::<i64>() - sent(&strip.vertices);
                    unchanged = 0;
                } else {
                    unchanged += 1;
                }
                let Some(next) = strip.next.get() else { break };
                at = next;
                let start = at as usize * self.entry_count;
                if self.contents_before[start..start + self.entry_count] == *self.fifo.contents() {
                    break;
                }
                if unchanged == WINDOW {
                    return None;
                }
            }
        }
        Some(self.weights.index * indices + self.weights.miss * misses)
    }

    /// Applies the move that was priced last.
    fn commit(&mut self, edits: Vec<StripEdit>) {
        let mut added = [None; 2];
        for (edit, added) in edits.into_iter().zip(&mut added) {
            let strip = edit.strip;
            let mut contents = edit.parts.into_iter().zip(edit.vertices);
            let Some(content) = contents.next() else {
                self.remove(strip);
                continue;
            };
            self.fill(strip, content);
            if let Some(content) = contents.next() {
                let new = self.insert_after(strip);
                self.fill(new, content);
                *added = Some(new);
            }
        }
        let contents = self.simulated_before.chunks_exact(self.entry_count);
        for (&(simulated, misses), contents) in self.simulated.iter().zip(contents) {
            let next = self.strips[simulated.strip as usize].next.get();
            let strip = match next {
                Some(next) if simulated.part > 0 && added.contains(&Some(next)) => next,
                _ => simulated.strip,
            };
            self.strips[strip as usize].misses = misses;
            let start = strip as usize * self.entry_count;
            self.contents_before[start..start + self.entry_count].copy_from_slice(contents);
        }
    }

    fn fill(&mut self, strip: u32, (steps, vertices): (Vec<Step>, Vec<u32>)) {
        steps.iter().for_each(|step| self.strip_of[step.triangle as usize] = strip);
        let filled = &mut self.strips[strip as usize];
        (filled.steps, filled.vertices) = (steps, vertices);
    }

    fn remove(&mut self, strip: u32) {
        let SequencedStrip { next, previous, .. } = self.strips[strip as usize];
        match previous.get() {
            None => self.first = next,
            Some(previous) => self.strips[previous as usize].next = next,
        }
        if let Some(next) = next.get() {
            self.strips[next as usize].previous = previous;
        }
        self.free.push(strip);
    }

    fn insert_after(&mut self, strip: u32) -> u32 {
        let next = self.strips[strip as usize].next;
        let new = self.free.pop().unwrap_or_else(|| {
            self.strips.push(SequencedStrip::default());
            self.contents_before.resize(self.strips.len() * self.entry_count, 0);
            self.strips.len() as u32 - 1
        });
        let from = self.strips[strip as usize].key;
        let to = next.get().map_or(from + 2 * GAP, |next| self.strips[next as usize].key);
        let inserted = &mut self.strips[new as usize];
        (inserted.next, inserted.previous) = (next, OptionalId::some(strip));
        inserted.key = from + (to - from) / 2;
        self.strips[strip as usize].next = OptionalId::some(new);
        if let Some(next) = next.get() {
            self.strips[next as usize].previous = OptionalId::some(new);
        }
        if to - from < 2 {
            self.space_keys();
        }
        new
    }

    /// Spaces the keys evenly.
    fn space_keys(&mut self) {
        let (mut at, mut key) = (self.first.get(), 0);
        while let Some(strip) = at {
            key += GAP;
            let strip = &mut self.strips[strip as usize];
            strip.key = key;
            at = strip.next.get();
        }
    }
}

/// Returns a path in the opposite direction.
fn reversed(steps: &[Step]) -> Vec<Step> {
    steps.iter().rev().map(Step::reversed).collect()
}
