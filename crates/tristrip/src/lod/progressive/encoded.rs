//! Encoded progressive strips: if the kept vertex is nearby in the strip, a collapse writes a
//! symbol that refers to it, so fewer slots contain the vertex.
//!
//! The two vertices of a collapsed edge that a strip draws are at most two slots apart. The slot of
//! the removed vertex does not need a copy of the kept vertex. It gets a symbol, R−2, R−1, R+1 or
//! R+2, for "the vertex 2 slots before, 1 before, 1 after or 2 after".
//!
//! ```text
//! map        0 1 2 3 4 5           4 collapses to 3, then 3 to 2
//! naive      0 1 2 3 3 5           0 1 2 2 2 5            two slots
//! offsets    0 1 2 3 ◁ 5           0 1 2 ◁ ◁ 5            one: R−1 in slot 4 follows slot 3
//! ```
//! A symbol refers to a slot, not to a vertex. When that slot is renamed later, the slots that
//! refer to it change with it, although no record lists them. Only the slots that contain the
//! vertex itself, its *roots*, are updated and listed in the record of the split.
//!
//! # Algorithm
//! 1. Swaps and winding repeats are symbols already in the full mesh.
//! 2. At a collapse, each root of the removed vertex examines the slots 1 and 2 before and after it
//!    in its strip. It refers to a slot that represents the kept vertex. It may also refer to a
//!    slot that represents the removed vertex through another root, since the same collapse renames
//!    that root. If there is no such slot, the kept vertex is written. This includes both
//!    exceptions of the paper: a *disjoint* vertex, where the edge is not in this strip or not at
//!    this position, and a *closed* one, which a strip passes twice.
//! 3. References never form a cycle: a root may only refer to a slot with another root.
//!
//! Joining trees of the same vertex is not in the paper; it saves less than one percent of the
//! slots. A split writes the vertex back into its roots, and the slots that refer to them change
//! with them.
//!
//! Decoding resolves each reference once: chains are followed to their root, and the vertex is
//! written to the whole chain.
//!
//! # References
//! Kim et al. 2005, sections 3.3 and 3.4.
//!
//! # Complexity
//! Decoding is O(n). Recording takes one step per slot that the naive encoding renames, and
//! temporarily 12 bytes per entry.

use crate::collapse::{CollapseSequence, Rename};
use crate::error::Error;
use crate::lod::level::index_map::RESTART;
use crate::lod::level::replay::{Records, VertexSlots};

/// The maximum number of vertices whose ids are below the symbols.
pub(super) const MAX_VERTEX_COUNT: u32 = u32::MAX - 4;

/// The meaning of the symbols, from the lowest.
const SYMBOLS: [i8; 4] = [-2, -1, 1, 2];

/// The slots that a root examines, nearest first.
const OFFSETS: [i8; 4] = [-1, 1, -2, 2];

/// The maximum length of a chain of references, which bounds the time of a collapse.
const MAX_CHAIN: usize = 64;

/// Returns the offset of the slot that an entry of an encoded map refers to: −2, −1, 1 or 2
/// entries; `None` for a vertex or a restart.
///
/// ```
/// use tristrip::lod::{RESTART, encoded_offset};
/// assert_eq!([u32::MAX - 4, u32::MAX - 1, RESTART, 7].map(encoded_offset), [Some(-2), Some(2), None, None]);
/// ```
pub fn encoded_offset(entry: u32) -> Option<i8> {
    let symbol = entry.checked_sub(MAX_VERTEX_COUNT)?;
    SYMBOLS.get(symbol as usize).copied()
}

fn symbol(offset: i8) -> u32 {
    MAX_VERTEX_COUNT + SYMBOLS.iter().take_while(|&&other| other != offset).count() as u32
}

/// Records all collapses over a map of vertices and restarts. Returns the entries of the full mesh,
/// and the records.
pub(super) fn record(map: &[u32], sequence: &CollapseSequence) -> Result<(Vec<u32>, Records), Error> {
    let full = encode_repeats(map);
    let mut roots = VertexSlots::of(map, sequence.vertex_count(), |slot| full[slot] == map[slot]);
    let mut entries = full.clone();
    let (mut records, mut taken) = (Records::default(), Vec::new());
    for collapse in sequence.iter() {
        for &Rename { removed, kept } in collapse.renames {
            roots.take(removed, &mut taken);
            for &slot in &taken {
                entries[slot as usize] = match reference(&entries, slot as usize, [removed, kept]) {
                    Some(offset) => symbol(offset),
                    None => removed,
                };
            }
            // All entries that refer to a root without a reference now represent `kept`.
            for &slot in &taken {
                if entries[slot as usize] == removed {
                    entries[slot as usize] = kept;
                    roots.add(kept, slot);
                }
            }
            records.push(removed, taken.iter().map(|&slot| (slot, entries[slot as usize])));
        }
        records.end(map.len())?;
    }
    Ok((full, records))
}

/// Writes symbols for vertices that occur one or two slots earlier in the same strip.
fn encode_repeats(map: &[u32]) -> Vec<u32> {
    let repeats = |slot: usize, back: usize| {
        slot >= back && map[slot] != RESTART && map[slot] == map[slot - back] && map[slot - 1] != RESTART
    };
    (0..map.len())
        .map(|slot| match () {
            () if repeats(slot, 1) => symbol(-1),
            () if repeats(slot, 2) => symbol(-2),
            () => map[slot],
        })
        .collect()
}

/// Finds a neighbouring slot in the strip that represents one of two vertices, but not through the
/// slot itself.
fn reference(entries: &[u32], slot: usize, vertices: [u32; 2]) -> Option<i8> {
    let [removed, kept] = vertices;
    let is_near = |offset: i8| {
        let near = slot.checked_add_signed(offset as isize)?;
        let between = slot.checked_add_signed(offset.signum() as isize)?;
        let is_outside = *entries.get(near)? == RESTART || entries[between] == RESTART;
        let root = if is_outside { None } else { root(entries, near) }?;
        let vertex = entries[root];
        (vertex == kept || vertex == removed && root != slot).then_some(offset)
    };
    OFFSETS.into_iter().find_map(is_near)
}

/// Follows references to the slot of a vertex. Returns `None` if the chain is too long.
fn root(entries: &[u32], slot: usize) -> Option<usize> {
    let mut root = slot;
    for _ in 0..MAX_CHAIN {
        match encoded_offset(entries[root]) {
            Some(offset) => root = root.wrapping_add_signed(offset as isize),
            None => return Some(root),
        }
    }
    None
}

/// Fills `map` with the vertices that entries represent. Every chain of references must end at a
/// vertex.
///
/// ```
/// use tristrip::lod::decode_entries;
/// let mut map = Vec::new();
/// // The symbol R−1 represents the vertex before it in the strip.
/// decode_entries(&[7, u32::MAX - 3, 9], &mut map);
/// assert_eq!(map, [7, 7, 9]);
/// ```
pub fn decode(entries: &[u32], map: &mut Vec<u32>) {
    map.clear();
    map.extend_from_slice(entries);
    for slot in 0..map.len() {
        let Some(first) = encoded_offset(map[slot]) else { continue };
        // Follow the chain to a vertex or a decoded entry. Follow it again to write the vertex.
        let follow = |at: usize, offset: i8| at.wrapping_add_signed(offset as isize);
        let mut end = follow(slot, first);
        while let Some(next) = encoded_offset(map[end]) {
            end = follow(end, next);
        }
        let vertex = map[end];
        let mut at = slot;
        while let Some(next) = encoded_offset(map[at]) {
            map[at] = vertex;
            at = follow(at, next);
        }
    }
}
