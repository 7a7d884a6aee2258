//! A search over strips in their order: exchanges at their ends, cuts, turns and moves in the order, each priced exactly in indices
//! and in misses of a FIFO buffer.
//!
//! # Algorithm
//! Annealing. A change replaces the strips at one or two places of the order by none, one or two others:
//! ```text
//!   graft     A ━━t  ┄u━━ B        an end t of A takes over u, and what follows on one side of it
//!   join      A ━━t  ┄ u━━B        the same where nothing of B is left
//!   cut       A ━━━━┊━━━━          two strips, one after the other
//!   turn      A from its other end
//!   move      A drawn before or after the strip of a neighbour, from either end
//! ```
//! Indices change at those places only. Misses change until the buffer holds what it held before at the beginning of a strip, since
//! all after that is as it was; each strip keeps what the buffer holds when it begins. This takes a few strips; a change that has not
//! settled after [`WINDOW`] strips is not made.
//!
//! # Complexity
//! O(places + vertices of the strips between) time a change, which is what the effort counts; 60 bytes a triangle, and 4 bytes a
//! strip and place.

use super::Weights;
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::dual::Triangulation;
use crate::ids::{FaceId, HalfEdge};
use crate::random::{Random, metropolis};
use crate::strip::{OPEN, Step, send_path};

/// No vertex, no strip, no triangle.
const NONE: u32 = u32::MAX;
/// Strips after a change within which the buffer must hold again what it held.
const WINDOW: usize = 48;
/// A change that is not even tried counts as so many vertices sent.
const LEAST_SENT: u64 = 8;
/// Steps in which a search cools.
const STAGES: u64 = 64;
/// Greater rises in cost are never accepted.
const RISES: usize = 64;
/// Keys of neighbours in the order lie so far apart at first.
const GAP: u64 = 1 << 20;

/// Strips in an order, what each sends and misses, and what the buffer holds before it.
pub(super) struct Sequence<'a> {
    graph: &'a DualGraph,
    triangles: &'a [u32],
    places: usize,
    weights: Weights,
    strips: Vec<Strip>,
    /// What the buffer holds before each strip, the youngest last, `NONE` where it is not full.
    before: Vec<u32>,
    /// The strip of each triangle.
    strip_of: Vec<u32>,
    /// Strips that are gone, to be used again.
    free: Vec<u32>,
    first: u32,
    buffer: Buffer,
    /// Vertices that were sent for trial.
    sent: u64,
    /// What was saved so far.
    saved: i64,
    /// What the last trial found: strips with their misses, and what the buffer held before each.
    found: Vec<(Place, u32)>,
    found_before: Vec<u32>,
}

#[derive(Debug, Clone, Default)]
struct Strip {
    steps: Vec<Step>,
    vertices: Vec<u32>,
    misses: u32,
    next: u32,
    previous: u32,
    key: u64,
}

/// A strip after a change: as it was, or one of those that replace it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Place {
    strip: u32,
    part: u32,
}

/// Strips that replace one.
#[derive(Debug, Clone)]
struct Edit {
    strip: u32,
    parts: Vec<Vec<Step>>,
    vertices: Vec<Vec<u32>>,
}

/// A FIFO buffer that is set to any state at once.
#[derive(Debug)]
struct Buffer {
    places: u64,
    /// The miss that brought each vertex in; the clock never goes back, so that nothing needs to be cleared.
    entered: Vec<u64>,
    clock: u64,
    /// What came in, the youngest last.
    log: Vec<u32>,
}

impl Buffer {
    fn set(&mut self, state: &[u32]) {
        self.clock += self.places;
        self.log.clear();
        for &vertex in state {
            self.clock += 1;
            self.log.push(vertex);
            if vertex != NONE {
                self.entered[vertex as usize] = self.clock;
            }
        }
    }

    fn send(&mut self, vertices: &[u32]) -> u32 {
        let before = self.clock;
        for &vertex in vertices {
            let entered = &mut self.entered[vertex as usize];
            if self.clock - *entered >= self.places {
                self.clock += 1;
                *entered = self.clock;
                self.log.push(vertex);
            }
        }
        (self.clock - before) as u32
    }

    fn state(&self) -> &[u32] {
        &self.log[self.log.len() - self.places as usize..]
    }
}

impl<'a> Sequence<'a> {
    pub(super) fn new(
        triangulation: &'a Triangulation<'_>,
        cover: &PathCover,
        order: &[FaceId],
        places: u32,
        weights: Weights,
    ) -> Self {
        let vertex_count = triangulation.triangles().iter().max().map_or(0, |&highest| highest as usize + 1);
        let (graph, triangles) = (triangulation.graph(), triangulation.triangles());
        let places = places as usize;
        let buffer = Buffer {
            places: places as u64,
            entered: vec![0; vertex_count],
            clock: places as u64,
            log: Vec::new(),
        };
        let mut sequence = Self {
            graph,
            triangles,
            places,
            weights,
            strips: Vec::with_capacity(order.len()),
            before: Vec::with_capacity(order.len() * places),
            strip_of: vec![NONE; graph.face_count()],
            free: Vec::new(),
            first: if order.is_empty() { NONE } else { 0 },
            buffer,
            sent: 0,
            saved: 0,
            found: Vec::new(),
            found_before: Vec::new(),
        };
        sequence.buffer.set(&vec![NONE; places]);
        for (i, &start) in order.iter().enumerate() {
            let steps: Vec<Step> = crate::strip::path_steps(graph, cover, start).collect();
            let vertices = sequence.vertices_of(&steps);
            sequence.before.extend_from_slice(sequence.buffer.state());
            let misses = sequence.buffer.send(&vertices);
            steps.iter().for_each(|step| sequence.strip_of[step.triangle as usize] = i as u32);
            sequence.strips.push(Strip {
                steps,
                vertices,
                misses,
                next: if i + 1 < order.len() { i as u32 + 1 } else { NONE },
                previous: if i > 0 { i as u32 - 1 } else { NONE },
                key: (i as u64 + 1) * GAP,
            });
        }
        sequence
    }

    /// Tries changes, from the hottest to the coldest in units of an index, until so many vertices were sent for trial: long strips
    /// take longer to try. `go_on` is asked before each of the [`STAGES`], with that number, the strips, and what was saved.
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
            let heat = (hottest + (coldest - hottest) * cooled) * self.weights.index as f64;
            let odds = metropolis::<RISES>(heat);
            while self.sent < limit * (stage + 1) / STAGES {
                let dare = (random.next_u64() >> 32) as u32;
                self.sent += LEAST_SENT;
                let Some(edits) = self.propose(random) else { continue };
                let Some(rise) = self.price(&edits) else { continue };
                let is_taken = match usize::try_from(rise) {
                    Ok(rise @ 1..) => odds.get(rise - 1).is_some_and(|&odds| dare < odds),
                    _ => true,
                };
                if is_taken {
                    self.saved -= rise;
                    self.commit(edits);
                }
            }
        }
    }

    /// Gives the cover and the first triangle of each path, in order.
    pub(super) fn finish(&self) -> (PathCover, Vec<FaceId>) {
        let mut cover = PathCover::isolated(self.graph.face_count());
        let mut order = Vec::new();
        let mut at = self.first;
        while at != NONE {
            let strip = &self.strips[at as usize];
            order.extend(strip.steps.first().map(|step| FaceId(step.triangle)));
            for step in strip.steps.iter().filter(|step| step.exit != OPEN) {
                cover.link(self.graph, HalfEdge(3 * step.triangle + step.exit));
            }
            at = strip.next;
        }
        (cover, order)
    }

    fn vertices_of(&self, steps: &[Step]) -> Vec<u32> {
        let mut vertices = Vec::with_capacity(steps.len() + steps.len() / 2 + 2);
        send_path(self.triangles, steps.iter().copied(), &mut vertices);
        vertices
    }

    fn edit(&self, strip: u32, parts: Vec<Vec<Step>>) -> Edit {
        let parts: Vec<Vec<Step>> = parts.into_iter().filter(|part| !part.is_empty()).collect();
        let vertices = parts.iter().map(|part| self.vertices_of(part)).collect();
        Edit { strip, parts, vertices }
    }

    /// Draws a change at random; `None` where what was drawn makes none.
    fn propose(&self, random: &mut Random) -> Option<Vec<Edit>> {
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
            _ => self.propose_graft(a, random),
        }
    }

    /// Draws an end of a strip and a neighbour that it takes over.
    fn propose_graft(&self, a: u32, random: &mut Random) -> Option<Vec<Edit>> {
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
        // The strip such that the end that grows is its last.
        let mut grown = if at_end { strip.clone() } else { reversed(strip) };
        grown.last_mut()?.exit = exit;
        // What follows on one side of it comes along, the other side is left.
        let backward = random.coin();
        let (mut gained, mut left) = if backward {
            (reversed(&other[..=at]), other[at + 1..].to_vec())
        } else {
            (other[at..].to_vec(), other[..at].to_vec())
        };
        gained[0].entry = entry;
        if let Some(cut) = if backward { left.first_mut() } else { left.last_mut() } {
            *(if backward { &mut cut.entry } else { &mut cut.exit }) = OPEN;
        }
        grown.extend(gained);
        if !at_end {
            grown = reversed(&grown);
        }
        // A strip that takes all of another may be drawn in its place.
        let (here, there) =
            if left.is_empty() && random.coin() { (vec![], vec![grown]) } else { (vec![grown], vec![left]) };
        Some(self.ordered(self.edit(a, here), self.edit(b, there)))
    }

    fn ordered(&self, a: Edit, b: Edit) -> Vec<Edit> {
        let key = |edit: &Edit| self.strips[edit.strip as usize].key;
        if key(&a) < key(&b) { vec![a, b] } else { vec![b, a] }
    }

    /// Finds by how much a change makes the whole dearer; `None` where the buffer does not settle. What was found is kept for
    /// [`Sequence::commit`].
    fn price(&mut self, edits: &[Edit]) -> Option<i64> {
        self.found.clear();
        self.found_before.clear();
        let (mut indices, mut misses) = (0_i64, 0_i64);
        let mut pending = edits.iter().peekable();
        while let Some(first) = pending.peek() {
            let mut at = first.strip;
            let start = at as usize * self.places;
            self.buffer.set(&self.before[start..start + self.places]);
            let mut unchanged = 0;
            while at != NONE {
                let strip = &self.strips[at as usize];
                let edit = pending.next_if(|edit| edit.strip == at);
                misses -= i64::from(strip.misses);
                let parts = edit.map_or(std::slice::from_ref(&strip.vertices), |edit| &edit.vertices);
                for (part, vertices) in parts.iter().enumerate() {
                    self.found_before.extend_from_slice(self.buffer.state());
                    let missed = self.buffer.send(vertices);
                    self.sent += vertices.len() as u64;
                    self.found.push((Place { strip: at, part: part as u32 }, missed));
                    misses += i64::from(missed);
                }
                if edit.is_some() {
                    let sent = |v: &Vec<u32>| (v.len() + 1).cast_signed() as i64;
                    indices += parts.iter().map(sent).sum::<i64>() - sent(&strip.vertices);
                    unchanged = 0;
                } else {
                    unchanged += 1;
                }
                at = strip.next;
                if at == NONE {
                    break;
                }
                let start = at as usize * self.places;
                if self.before[start..start + self.places] == *self.buffer.state() {
                    break;
                }
                if unchanged == WINDOW {
                    return None;
                }
            }
        }
        Some(self.weights.index * indices + self.weights.miss * misses)
    }

    /// Makes the change that was priced last.
    fn commit(&mut self, edits: Vec<Edit>) {
        let mut added = [NONE; 2];
        for (edit, added) in edits.into_iter().zip(&mut added) {
            let strip = edit.strip;
            let mut contents = edit.parts.into_iter().zip(edit.vertices);
            let Some(content) = contents.next() else {
                self.remove(strip);
                continue;
            };
            self.fill(strip, content);
            if let Some(content) = contents.next() {
                *added = self.insert_after(strip);
                self.fill(*added, content);
            }
        }
        let found = std::mem::take(&mut self.found);
        let edited = |strip: u32, strips: &[Strip]| {
            let next = strips[strip as usize].next;
            added.contains(&next).then_some(next)
        };
        for (&(place, misses), state) in found.iter().zip(self.found_before.chunks_exact(self.places)) {
            let strip = match place.part {
                0 => place.strip,
                _ => edited(place.strip, &self.strips).unwrap_or(place.strip),
            };
            self.strips[strip as usize].misses = misses;
            self.before[strip as usize * self.places..][..self.places].copy_from_slice(state);
        }
        self.found = found;
    }

    fn fill(&mut self, strip: u32, (steps, vertices): (Vec<Step>, Vec<u32>)) {
        steps.iter().for_each(|step| self.strip_of[step.triangle as usize] = strip);
        let place = &mut self.strips[strip as usize];
        (place.steps, place.vertices) = (steps, vertices);
    }

    fn remove(&mut self, strip: u32) {
        let Strip { next, previous, .. } = self.strips[strip as usize];
        match previous {
            NONE => self.first = next,
            _ => self.strips[previous as usize].next = next,
        }
        if next != NONE {
            self.strips[next as usize].previous = previous;
        }
        self.free.push(strip);
    }

    fn insert_after(&mut self, strip: u32) -> u32 {
        let next = self.strips[strip as usize].next;
        let new = self.free.pop().unwrap_or_else(|| {
            self.strips.push(Strip::default());
            self.before.resize(self.strips.len() * self.places, NONE);
            self.strips.len() as u32 - 1
        });
        let from = self.strips[strip as usize].key;
        let to = if next == NONE { from + 2 * GAP } else { self.strips[next as usize].key };
        let place = &mut self.strips[new as usize];
        (place.next, place.previous, place.key) = (next, strip, from + (to - from) / 2);
        self.strips[strip as usize].next = new;
        if next != NONE {
            self.strips[next as usize].previous = new;
        }
        if to - from < 2 {
            self.space_keys();
        }
        new
    }

    /// Lays the keys apart again.
    fn space_keys(&mut self) {
        let (mut at, mut key) = (self.first, 0);
        while at != NONE {
            key += GAP;
            self.strips[at as usize].key = key;
            at = self.strips[at as usize].next;
        }
    }
}

/// Gives a path from its other end.
fn reversed(steps: &[Step]) -> Vec<Step> {
    steps.iter().rev().map(Step::reversed).collect()
}
