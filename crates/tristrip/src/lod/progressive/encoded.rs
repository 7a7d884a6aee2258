//! Where the kept vertex stands nearby in the strip, a collapse writes a symbol that refers to it, so that fewer places hold it.
//!
//! The two vertices of a collapsed edge that a strip draws are at most two places apart. The removed one need not become another copy of
//! the kept one: the symbol R−2, R−1, R+1 or R+2 in its place means "the vertex that stands 2 before, 1 before, 1 after, 2 after".
//!
//! ```text
//! map        0 1 2 3 4 5           4 collapses to 3, then 3 to 2
//! naive      0 1 2 3 3 5           0 1 2 2 2 5            two places
//! offsets    0 1 2 3 ◁ 5           0 1 2 ◁ ◁ 5            one: R−1 at place 4 follows place 3
//! ```
//! A symbol refers to a place, not to a vertex: whatever that place is renamed to later, its followers are too, though no record
//! names them. So only the places that hold the vertex itself, its *roots*, are updated, and stand in the record of the split.
//!
//! # Algorithm
//! 1. Swaps, and winding repeats, are symbols in the full mesh already.
//! 2. At a collapse each root of the removed vertex looks at the places 1 and 2 before and after it in its strip. One that stands for the
//!    kept vertex is referred to; so is one that stands for the removed vertex through another root, since that root will be renamed
//!    now. Else the kept vertex is written, as it must be in both exceptions of the paper: a *disjoint* vertex, where the
//!    edge is not in this strip or not at this place of it, and a *closed* one, which a strip passes twice.
//! 3. References never close a cycle: a root comes to refer to a place whose root is another one.
//!
//! That trees of the same vertex are joined is ours; it is less than a hundredth of the places. A split writes the vertex back at
//! its roots, and followers follow.
//!
//! Decoding resolves each reference once: chains are followed to their root, and the vertex is written to all of the chain.
//!
//! # References
//! Kim et al. 2005, sections 3.3 and 3.4.
//!
//! # Complexity
//! Decoding is O(n). Recording takes as many steps as naive places are renamed, and 12 bytes an entry meanwhile.

use crate::collapse::{CollapseSequence, Rename};
use crate::error::Error;
use crate::lod::index_map::RESTART;
use crate::lod::replay::{Places, Records, Replay};

/// Vertices that have numbers below those of the symbols.
pub(super) const MOST_VERTICES: u32 = u32::MAX - 4;

/// What the symbols mean, from the lowest.
const SYMBOLS: [i8; 4] = [-2, -1, 1, 2];

/// The places that a root looks at, nearest first.
const OFFSETS: [i8; 4] = [-1, 1, -2, 2];

/// A chain of more references than this is not made longer: so a collapse takes bounded time.
const LONGEST_CHAIN: usize = 64;

/// Gives the place to which an entry of an encoded map refers, as an offset in entries: −2, −1, 1 or 2; `None` for a vertex or a restart.
///
/// ```
/// use tristrip::lod::{RESTART, progressive::encoded::offset};
/// assert_eq!([u32::MAX - 4, u32::MAX - 1, RESTART, 7].map(offset), [Some(-2), Some(2), None, None]);
/// ```
pub fn offset(entry: u32) -> Option<i8> {
    let symbol = entry.checked_sub(MOST_VERTICES)?;
    SYMBOLS.get(symbol as usize).copied()
}

fn symbol(offset: i8) -> u32 {
    MOST_VERTICES + SYMBOLS.iter().take_while(|&&other| other != offset).count() as u32
}

/// Records all collapses over a map of vertices and restarts.
pub(super) fn replay(map: &[u32], sequence: &CollapseSequence) -> Result<Replay, Error> {
    let full = encode_repeats(map);
    let mut roots = Places::of(map, sequence.vertex_count(), |place| full[place] == map[place]);
    let mut entries = full.clone();
    let (mut records, mut taken) = (Records::default(), Vec::new());
    for collapse in sequence.iter() {
        for &Rename { removed, kept } in collapse.renames {
            roots.take(removed, &mut taken);
            for &place in &taken {
                entries[place as usize] = match reference(&entries, place as usize, [removed, kept]) {
                    Some(offset) => symbol(offset),
                    None => removed,
                };
            }
            // Those that found nothing, and now stand for all that came to refer to them.
            for &place in &taken {
                if entries[place as usize] == removed {
                    entries[place as usize] = kept;
                    roots.add(kept, place);
                }
            }
            records.push(removed, taken.iter().map(|&place| (place, entries[place as usize])));
        }
        records.end(map.len())?;
    }
    Ok(Replay { level: records.len(), entries: full, records })
}

/// Writes symbols for vertices that stand one or two places before in the same strip.
fn encode_repeats(map: &[u32]) -> Vec<u32> {
    let repeats = |place: usize, back: usize| {
        place >= back && map[place] != RESTART && map[place] == map[place - back] && map[place - 1] != RESTART
    };
    (0..map.len())
        .map(|place| match () {
            () if repeats(place, 1) => symbol(-1),
            () if repeats(place, 2) => symbol(-2),
            () => map[place],
        })
        .collect()
}

/// Finds a neighbour in the strip that stands for one of two vertices, but not through the place itself.
fn reference(entries: &[u32], place: usize, vertices: [u32; 2]) -> Option<i8> {
    let [removed, kept] = vertices;
    let is_near = |offset: i8| {
        let near = place.checked_add_signed(offset as isize)?;
        let between = place.checked_add_signed(offset.signum() as isize)?;
        let is_outside = *entries.get(near)? == RESTART || entries[between] == RESTART;
        let root = if is_outside { None } else { root(entries, near) }?;
        let vertex = entries[root];
        (vertex == kept || vertex == removed && root != place).then_some(offset)
    };
    OFFSETS.into_iter().find_map(is_near)
}

/// Follows references to the place of a vertex; `None` where the chain is long.
fn root(entries: &[u32], place: usize) -> Option<usize> {
    let mut root = place;
    for _ in 0..LONGEST_CHAIN {
        match offset(entries[root]) {
            Some(offset) => root = root.wrapping_add_signed(offset as isize),
            None => return Some(root),
        }
    }
    None
}

/// Fills `map` with the vertices that entries stand for.
pub(super) fn decode(entries: &[u32], map: &mut Vec<u32>) {
    map.clear();
    map.extend_from_slice(entries);
    for place in 0..map.len() {
        let Some(first) = offset(map[place]) else { continue };
        // The chain to what is a vertex or was decoded before; then once more, to write it.
        let follow = |at: usize, offset: i8| at.wrapping_add_signed(offset as isize);
        let mut end = follow(place, first);
        while let Some(next) = offset(map[end]) {
            end = follow(end, next);
        }
        let vertex = map[end];
        let mut at = place;
        while let Some(next) = offset(map[at]) {
            map[at] = vertex;
            at = follow(at, next);
        }
    }
}
