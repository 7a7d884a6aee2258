//! The kept vertex is written at every place of the removed one.
//!
//! A vertex gathers the places of all that collapsed to it, swaps and degenerate stretches of strips included, and hands
//! them on when it collapses itself. For the models of the paper a collapse renames six or seven places on the average.
//!
//! # References
//! Kim et al. 2005, section 3.2.
//!
//! # Complexity
//! As many steps as places are written, and 4 bytes an entry and a vertex meanwhile.

use crate::collapse::{CollapseSequence, Rename};
use crate::error::Error;
use crate::lod::replay::{Places, Records, Replay};

/// Records all collapses over a map of vertices and restarts, of which the entries from `live(level)` on are not drawn at that level or
/// below it: they stay as they were.
pub(super) fn replay(
    map: Vec<u32>,
    sequence: &CollapseSequence,
    live: impl Fn(usize) -> u32,
) -> Result<Replay, Error> {
    let mut of_vertex = Places::of(&map, sequence.vertex_count(), |_| true);
    let (mut records, mut taken) = (Records::default(), Vec::new());
    for (i, collapse) in sequence.iter().enumerate() {
        let live = live(sequence.len() - 1 - i);
        for &Rename { removed, kept } in collapse.renames {
            of_vertex.take(removed, &mut taken);
            taken.truncate(taken.partition_point(|&place| place < live));
            taken.iter().for_each(|&place| of_vertex.add(kept, place));
            records.push(removed, taken.iter().map(|&place| (place, kept)));
        }
        records.end(map.len())?;
    }
    Ok(Replay { level: records.len(), entries: map, records })
}
