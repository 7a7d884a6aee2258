//! Naive progressive strips: the kept vertex is written into every slot of the removed one.
//!
//! A vertex accumulates the slots of all vertices that collapsed to it, including slots in swaps
//! and in degenerate parts of strips. When it collapses, its slots go to the next kept vertex. For
//! the models of the paper, a collapse renames six or seven slots on average.
//!
//! # References
//! Kim et al. 2005, section 3.2.
//!
//! # Complexity
//! One step per slot written, and temporarily 4 bytes per entry and per vertex.

use crate::collapse::{CollapseSequence, Rename};
use crate::error::Error;
use crate::lod::level::replay::{Records, VertexSlots};

/// Records all collapses over a map of vertices and restarts. Returns the entries of the full mesh,
/// and the records. Entries from `live(level)` on are not drawn at that level or below, and are not
/// renamed.
pub(super) fn record(
    map: Vec<u32>,
    sequence: &CollapseSequence,
    live: impl Fn(usize) -> u32,
) -> Result<(Vec<u32>, Records), Error> {
    let mut of_vertex = VertexSlots::of(&map, sequence.vertex_count(), |_| true);
    let (mut records, mut taken) = (Records::default(), Vec::new());
    for (i, collapse) in sequence.iter().enumerate() {
        let live = live(sequence.len() - 1 - i);
        for &Rename { removed, kept } in collapse.renames {
            of_vertex.take(removed, &mut taken);
            taken.truncate(taken.partition_point(|&slot| slot < live));
            taken.iter().for_each(|&slot| of_vertex.add(kept, slot));
            records.push(removed, taken.iter().map(|&slot| (slot, kept)));
        }
        records.end(map.len())?;
    }
    Ok((map, records))
}
