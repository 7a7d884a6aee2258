//! The strips of all levels in the form that the multiresolution strip models store: collapses
//! rename vertices, and superfluous vertices are removed.
//!
//! ```text
//! a b c d e f g h    c → d   a b d d e f g h     nothing to remove
//!                    a → b   b b d d e f g h     the first two draw nothing:   d d e f g h
//!                    f → d   d d e d g h         the first two draw nothing:   e d g h
//! ```
//! # Algorithm
//! A pair of consecutive vertices is removed if the strip draws the same triangles without it.
//! Removing an even number of vertices preserves the winding of all triangles after it (Belmonte et
//! al. 2006, section 3.2: the number of removed vertices is even, and the remaining ones describe
//! no new triangle). Pairs next to every renamed slot are tried, in the order of the strip, and
//! again next to every removed pair. Longer subsequences are removed pair by pair.
//!
//! Nothing follows the end of a strip, so any number of vertices may be removed there. As long as
//! the last three vertices draw nothing, the last one is removed. In figure 1 of the paper, the
//! last step also removes a single vertex.
//!
//! # Complexity
//! A constant number of steps per renamed slot, and temporarily 20 bytes per slot and 4 per vertex.

use crate::collapse::{CollapseSequence, Rename};
use crate::csr::Csr;
use crate::error::Error;
use crate::lod::level::replay::{MAX_SLOTS_PER_ENTRY, VertexSlots};
use crate::mesh::{canonical_triangle, is_degenerate};
use crate::strip::Strips;

/// No slot.
pub const NONE: u32 = u32::MAX;

/// A change of a slot by a collapse.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SlotEdit {
    /// The number of the collapse, counted from 1 at the full mesh.
    pub step: u32,
    /// The slot in the strip at the full mesh, counted from 0.
    pub slot: u32,
    /// The new vertex in the slot; [`NONE`] if the slot is removed.
    pub vertex: u32,
}

/// Returns the changes of all collapses by strip, in the order of the collapses and, within a
/// collapse, of the slots.
///
/// # Errors
/// The collapses rename too many slots.
pub fn edits_of(strips: &Strips, sequence: &CollapseSequence) -> Result<Csr<SlotEdit>, Error> {
    let mut shortened = ShortenedStrips::new(strips, sequence.vertex_count());
    let mut edits: Vec<(u32, SlotEdit)> = Vec::new();
    for (step, collapse) in (1..).zip(sequence.iter()) {
        shortened.collapse(collapse.renames)?;
        edits.extend(shortened.changed.iter().map(|&slot| {
            let strip = shortened.strip_of[slot as usize];
            let is_removed = shortened.is_removed[slot as usize];
            let vertex = if is_removed { NONE } else { shortened.vertices[slot as usize] };
            (strip, SlotEdit { step, slot: slot - shortened.start_of(strip), vertex })
        }));
    }
    Ok(Csr::group_items(edits.iter().copied(), strips.len()))
}

/// The strips while collapses are applied to them. Slots are numbered as in the full mesh, over all
/// strips; removed slots remain empty.
#[derive(Debug)]
pub(crate) struct ShortenedStrips {
    vertices: Vec<u32>,
    ends: Vec<u32>,
    strip_of: Vec<u32>,
    /// The slots before and after each slot in its strip. For a removed slot, a slot that was
    /// before it.
    previous: Vec<u32>,
    next: Vec<u32>,
    is_removed: Vec<bool>,
    /// The first and the last slot of each strip.
    bounds: Vec<[u32; 2]>,
    of_vertex: VertexSlots,
    changed: Vec<u32>,
    taken: Vec<u32>,
    renamed_count: usize,
}

impl ShortenedStrips {
    /// Starts with the strips of the full mesh. Their vertices must be less than `vertex_count`.
    pub(crate) fn new(strips: &Strips, vertex_count: usize) -> Self {
        let vertices = strips.vertices().to_vec();
        let slot_count = vertices.len() as u32;
        let (mut ends, mut strip_of) = (Vec::with_capacity(strips.len()), Vec::with_capacity(vertices.len()));
        let mut bounds = Vec::with_capacity(strips.len());
        let mut previous: Vec<u32> = (0..slot_count).map(|slot| slot.wrapping_sub(1)).collect();
        let mut next: Vec<u32> = (1..=slot_count).collect();
        let mut start = 0;
        for (number, strip) in (0..).zip(strips.iter()) {
            let end = start + strip.len() as u32;
            strip_of.resize(end as usize, number);
            ends.push(end);
            bounds.push(if start == end { [NONE; 2] } else { [start, end - 1] });
            if start < end {
                previous[start as usize] = NONE;
                next[end as usize - 1] = NONE;
            }
            start = end;
        }
        let of_vertex = VertexSlots::of(&vertices, vertex_count, |_| true);
        let is_removed = vec![false; vertices.len()];
        let (changed, taken) = (Vec::new(), Vec::new());
        Self {
            vertices,
            ends,
            strip_of,
            previous,
            next,
            is_removed,
            bounds,
            of_vertex,
            changed,
            taken,
            renamed_count: 0,
        }
    }

    /// Returns the first slot of a strip at the full mesh.
    fn start_of(&self, strip: u32) -> u32 {
        if strip == 0 { 0 } else { self.ends[strip as usize - 1] }
    }

    /// Returns the nearest slot before a removed one that is not removed itself.
    fn before(&mut self, slot: u32) -> Option<u32> {
        let mut found = self.previous[slot as usize];
        while found != NONE && self.is_removed[found as usize] {
            found = self.previous[found as usize];
        }
        // Path compression: all slots on the way now point directly to the result, which keeps the
        // total time linear.
        let mut at = slot;
        while at != found {
            at = std::mem::replace(&mut self.previous[at as usize], found);
        }
        (found != NONE).then_some(found)
    }

    /// Applies a collapse, and lists the slots that it changed in ascending order.
    ///
    /// # Errors
    /// All collapses together rename too many slots.
    fn collapse(&mut self, renames: &[Rename]) -> Result<(), Error> {
        self.changed.clear();
        let mut taken = std::mem::take(&mut self.taken);
        for &Rename { removed, kept } in renames {
            self.of_vertex.take(removed, &mut taken);
            for &slot in taken.iter().filter(|&&slot| !self.is_removed[slot as usize]) {
                self.of_vertex.add(kept, slot);
                self.vertices[slot as usize] = kept;
                self.changed.push(slot);
            }
        }
        self.taken = taken;
        self.renamed_count += self.changed.len();
        let limit = self.vertices.len().saturating_mul(MAX_SLOTS_PER_ENTRY).min(u32::MAX as usize / 2);
        if self.renamed_count > limit {
            let (found, limit) = (self.renamed_count as u64, limit as u64);
            return Err(Error::LimitExceeded { what: "slots renamed by all collapses", found, limit });
        }
        self.changed.sort_unstable();
        for i in 0..self.changed.len() {
            let slot = self.changed[i];
            self.remove_pairs_near(slot);
            self.remove_at_end(self.strip_of[slot as usize]);
        }
        // Slots that were renamed and then removed are listed twice.
        self.changed.sort_unstable();
        self.changed.dedup();
        Ok(())
    }

    /// Removes the pairs that became superfluous through the vertex in a slot.
    fn remove_pairs_near(&mut self, slot: u32) {
        let strip = self.strip_of[slot as usize] as usize;
        let start = if self.is_removed[slot as usize] { self.before(slot) } else { Some(slot) };
        let mut pair = start.map_or(self.bounds[strip][0], |slot| self.back(slot, 3));
        if pair == NONE {
            return;
        }
        let mut left = 6;
        while left > 0 {
            if self.is_superfluous(pair) {
                let second = self.next[pair as usize];
                let before = self.previous[pair as usize];
                self.remove(pair);
                self.remove(second);
                pair = if before == NONE { self.bounds[strip][0] } else { self.back(before, 3) };
                if pair == NONE {
                    return;
                }
                left = 8;
            } else if self.next[pair as usize] == NONE {
                return;
            } else {
                pair = self.next[pair as usize];
                left -= 1;
            }
        }
    }

    /// Returns the slot `steps` slots back, or the first one.
    fn back(&self, mut slot: u32, steps: u32) -> u32 {
        for _ in 0..steps {
            if self.previous[slot as usize] == NONE {
                break;
            }
            slot = self.previous[slot as usize];
        }
        slot
    }

    /// Returns whether the strip draws the same triangles without this vertex and the next.
    fn is_superfluous(&self, pair: u32) -> bool {
        let second = self.next[pair as usize];
        if second == NONE {
            return false;
        }
        // The pair with up to two slots on either side.
        let before = |slot: u32| if slot == NONE { NONE } else { self.previous[slot as usize] };
        let after = |slot: u32| if slot == NONE { NONE } else { self.next[slot as usize] };
        let (left, right) = (before(pair), after(second));
        let around = [before(left), left, pair, second, right, after(right)];
        let skipped = around.iter().take_while(|&&slot| slot == NONE).count();
        let len = around[skipped..].iter().take_while(|&&slot| slot != NONE).count();
        let around = &around[skipped..][..len];
        let (mut with, mut with_len) = ([[0; 3]; 4], 0);
        for triple in around.windows(3) {
            if let Some(triangle) = self.triangle(triple) {
                // The shorter sequence has at most two triangles.
                if with_len == 2 {
                    return false;
                }
                with[with_len] = triangle;
                with_len += 1;
            }
        }
        let (mut shorter, mut shorter_len) = ([NONE; 4], 0);
        for &slot in around.iter().filter(|&&slot| slot != pair && slot != second) {
            shorter[shorter_len] = slot;
            shorter_len += 1;
        }
        let (mut without, mut without_len) = ([[0; 3]; 2], 0);
        for triple in shorter[..shorter_len].windows(3) {
            if let Some(triangle) = self.triangle(triple) {
                without[without_len] = triangle;
                without_len += 1;
            }
        }
        let (with, without) = (&mut with[..with_len], &mut without[..without_len]);
        with.sort_unstable();
        without.sort_unstable();
        with == without
    }

    /// Returns the triangle of three slots that are consecutive, possibly after a pair between them
    /// is removed.
    fn triangle(&self, slots: &[u32]) -> Option<[u32; 3]> {
        let [a, b, c] = [slots[0], slots[1], slots[2]].map(|slot| self.vertices[slot as usize]);
        if is_degenerate([a, b, c]) {
            return None;
        }
        // Slots are removed in pairs, so the parity of a slot in its strip does not change.
        let is_odd = (slots[0] - self.start_of(self.strip_of[slots[0] as usize])) % 2 == 1;
        Some(canonical_triangle(if is_odd { [b, a, c] } else { [a, b, c] }))
    }

    /// Removes vertices from the end of a strip while the last three draw nothing.
    fn remove_at_end(&mut self, strip: u32) {
        loop {
            let c = self.bounds[strip as usize][1];
            if c == NONE {
                return;
            }
            let b = self.previous[c as usize];
            let a = if b == NONE { NONE } else { self.previous[b as usize] };
            if a != NONE && self.triangle(&[a, b, c]).is_some() {
                return;
            }
            self.remove(c);
        }
    }

    fn remove(&mut self, slot: u32) {
        let (previous, next) = (self.previous[slot as usize], self.next[slot as usize]);
        let strip = self.strip_of[slot as usize];
        match previous {
            NONE => self.bounds[strip as usize][0] = next,
            previous => self.next[previous as usize] = next,
        }
        match next {
            NONE => self.bounds[strip as usize][1] = previous,
            next => self.previous[next as usize] = previous,
        }
        self.is_removed[slot as usize] = true;
        self.changed.push(slot);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::lod::samples::{samples, sorted};
    use crate::strip::strip_triangles;

    /// Returns the vertices of a strip that are not removed.
    fn left(strips: &ShortenedStrips, strip: u32) -> Vec<u32> {
        let mut slot = strips.bounds[strip as usize][0];
        let mut vertices = Vec::new();
        while slot != NONE {
            vertices.push(strips.vertices[slot as usize]);
            slot = strips.next[slot as usize];
        }
        vertices
    }

    /// Returns whether a pair of consecutive vertices, or the last vertex, can be removed from a
    /// strip. This is the definition, applied to whole strips.
    fn can_be_shortened(strip: &[u32]) -> bool {
        let drawn = sorted(strip_triangles(strip));
        let without = |from: usize, to: usize| [&strip[..from], &strip[to..]].concat();
        let is_same = |shorter: &[u32]| sorted(strip_triangles(shorter)) == drawn;
        let pair = (0..strip.len().saturating_sub(1)).any(|i| is_same(&without(i, i + 2)));
        pair || !strip.is_empty() && is_same(&strip[..strip.len() - 1])
    }

    proptest! {
        #[test]
        fn strips_draw_every_level_and_are_as_short_as_promised(sample in samples()) {
            let mut strips = ShortenedStrips::new(&sample.strips, sample.sequence.vertex_count());
            let count = sample.strips.len() as u32;
            let mut is_changed = vec![false; count as usize];
            for (i, collapse) in sample.sequence.iter().enumerate() {
                strips.collapse(collapse.renames).unwrap();
                for &slot in &strips.changed {
                    is_changed[strips.strip_of[slot as usize] as usize] = true;
                }
                let vertices: Vec<Vec<u32>> = (0..count).map(|strip| left(&strips, strip)).collect();
                let drawn = vertices.iter().flat_map(|strip| strip_triangles(strip));
                prop_assert_eq!(sorted(drawn), sorted(sample.sequence.drawn(sample.sequence.len() - 1 - i).unwrap()));
                for (strip, _) in vertices.iter().zip(&is_changed).filter(|(_, changed)| **changed) {
                    prop_assert!(strip.is_empty() || strip_triangles(strip).count() > 0, "{:?}", strip);
                }
            }
            // Strips of the full mesh can have useless swaps; the algorithm does not look for them.
            let stays = |i: &u32| is_changed[*i as usize] && !can_be_shortened(sample.strips.iter().nth(*i as usize).unwrap());
            for strip in (0..count).filter(stays) {
                prop_assert!(!can_be_shortened(&left(&strips, strip)), "{:?}", left(&strips, strip));
            }
        }
    }

    #[test]
    fn too_many_renames_are_refused() {
        // Two vertices that alternate would be a cycle. A hub that moves with each collapse renames
        // its slots each time.
        let count = 2_000_u32;
        let mut strips = Strips::default();
        (1..count).for_each(|v| strips.push(&[0, v, v + 1]));
        let renames: Vec<[Rename; 1]> =
            (0..count - 1).map(|v| [Rename { removed: v, kept: v + 1 }]).collect();
        let collapses = renames.iter().map(|renames| (&renames[..], 0.0));
        let sequence =
            CollapseSequence::from_collapses(count as usize + 1, strips.to_list(), collapses).unwrap();
        let error = edits_of(&strips, &sequence).map(|edits| edits.item_count()).unwrap_err();
        assert!(matches!(error, Error::LimitExceeded { .. }), "{error}");
    }
}
