//! Progressive strips: strips that follow every collapse and every vertex split, by the few slots that it renames.
//!
//! The vertices of all strips stand in one *index map*, with a restart between strips. A collapse overwrites the removed vertex with another entry in
//! every slot that holds it; the vertex split that undoes the collapse writes the vertex back. The record of a split is therefore the vertex
//! and its slots, and no step reads anything else.
//!
//! ```text
//! level 8   0 1 2 3 4 R 3 2 5       4 collapses to 2, then 3 to 2
//! level 7   0 1 2 3 2 R 3 2 5       the split of level 7: vertex 4 in slot 4
//! level 6   0 1 2 2 2 R 2 2 5       the split of level 6: vertex 3 in slots 3 and 6
//! ```
//! The number of slots, u, is the cost of sending a refinement: 12 bytes for the position of the vertex and 2 per slot. Toward the base mesh vertices
//! accumulate slots, and u grows with them; [`encoded`] keeps it near three.
//!
//! # References
//! Hoppe: *Progressive Meshes*, 1996 ([`pm`]). Kim, Park, Yang, Neelamkavil: *A Rendering-Efficient Progressive Transmission of 3D
//! Meshes*, 2005, section 3.
//!
//! # Complexity
//! A step takes O(u) time. Memory: 4 bytes per entry of the map, 12 bytes per collapse, and 8 bytes per slot that it renames.

pub mod encoded;
pub mod naive;
pub mod pm;

#[cfg(test)]
mod tests;

pub use pm::ProgressiveMesh;

use super::index_map::RESTART;
use super::replay::Replay;
pub use super::replay::SlotUpdate;
use crate::collapse::CollapseSequence;
use crate::error::{Error, MeshProblem};
use crate::strip::Strips;

/// What a collapse writes into the slots of the removed vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Encoding {
    /// The kept vertex: see [`naive`].
    Naive,
    /// A symbol that refers to the kept vertex if that is nearby: see [`encoded`].
    #[default]
    Offsets,
}

/// The strips of a mesh at any level of a collapse sequence, as an index map that is updated in slot.
///
/// ```
/// use tristrip::lod::{Filter, progressive::{Encoding, ProgressiveStrips}};
/// use tristrip::{CollapseSequence, Strips, collapse::Rename};
/// let mut strips = Strips::default();
/// strips.push(&[0, 1, 2, 3]);
/// let rename = [Rename { removed: 3, kept: 2 }];
/// let sequence = CollapseSequence::from_collapses(4, strips.to_list(), [(&rename[..], 0.5)])?;
///
/// let mut model = ProgressiveStrips::new(&strips, &sequence, Encoding::Offsets)?;
/// model.go_to(0);
/// let (mut map, mut display) = (Vec::new(), Strips::default());
/// model.decode_to(&mut map);
/// assert_eq!(map, [0, 1, 2, 2]);
/// Filter::Linked.map_to(&map, &mut display);
/// assert_eq!(display.vertices(), [0, 1, 2]);
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProgressiveStrips {
    replay: Replay,
    encoding: Encoding,
}

impl ProgressiveStrips {
    /// Builds the model of strips under a sequence of collapses, at the level of the full mesh.
    ///
    /// # Errors
    /// A strip has a vertex that the sequence does not have; there are more than 2³² − 5 vertices, or more than 256 renamed slots per entry of
    /// the map.
    pub fn new(strips: &Strips, sequence: &CollapseSequence, encoding: Encoding) -> Result<Self, Error> {
        let map = strips.to_restart(RESTART);
        check(strips, sequence)?;
        let replay = match encoding {
            Encoding::Naive => naive::replay(map, sequence, |_| u32::MAX)?,
            Encoding::Offsets => encoded::replay(&map, sequence)?,
        };
        Ok(Self { replay, encoding })
    }

    /// Returns what collapses write.
    pub fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// Returns the number of collapses, which is the level of the full mesh.
    pub fn len(&self) -> usize {
        self.replay.records.len()
    }

    /// Returns whether there is no collapse.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the level of the map.
    pub fn level(&self) -> usize {
        self.replay.level
    }

    /// Splits a vertex: one level up. Returns `false` at the full mesh.
    pub fn refine(&mut self) -> bool {
        self.replay.refine()
    }

    /// Collapses a vertex: one level down. Returns `false` at the base mesh.
    pub fn coarsen(&mut self) -> bool {
        self.replay.coarsen()
    }

    /// Moves to a level, step by step.
    ///
    /// # Panics
    /// `level` is greater than [`ProgressiveStrips::len`].
    pub fn go_to(&mut self, level: usize) {
        self.replay.go_to(level);
    }

    /// Returns the entries of the map at its level: vertices, [`RESTART`] between strips, and the [symbols](encoded::offset) of [`Encoding::Offsets`].
    pub fn entries(&self) -> &[u32] {
        &self.replay.entries
    }

    /// Fills `map` with the vertices at the level, [`RESTART`] between strips. Its contents are replaced and its memory is reused.
    pub fn decode_to(&self, map: &mut Vec<u32>) {
        match self.encoding {
            Encoding::Naive => map.clone_from(&self.replay.entries),
            Encoding::Offsets => encoded::decode(&self.replay.entries, map),
        }
    }

    /// Returns what the split from `level` to the next one writes: an update per restored vertex.
    ///
    /// # Panics
    /// `level` is not less than [`ProgressiveStrips::len`].
    pub fn split(&self, level: usize) -> impl ExactSizeIterator<Item = SlotUpdate<'_>> {
        self.replay.records.split(level)
    }

    /// Returns the number of slots that the split from `level` to the next one writes: the u of the literature.
    ///
    /// # Panics
    /// `level` is not less than [`ProgressiveStrips::len`].
    pub fn slot_count(&self, level: usize) -> usize {
        self.split(level).map(|update| update.slots.len()).sum()
    }
}

fn check(strips: &Strips, sequence: &CollapseSequence) -> Result<(), Error> {
    let vertex_count = sequence.vertex_count();
    if vertex_count as u64 > encoded::MAX_VERTEX_COUNT as u64 {
        let (found, limit) = (vertex_count as u64, encoded::MAX_VERTEX_COUNT as u64);
        return Err(Error::LimitExceeded { what: "vertices of progressive strips", found, limit });
    }
    for (face, strip) in strips.iter().enumerate() {
        if let Some(corner) = strip.iter().position(|&v| v as usize >= vertex_count) {
            let (found, vertex_count) = (strip[corner], vertex_count as u32);
            let (face, corner) = (face as u32, corner as u32);
            return Err(MeshProblem::VertexIndex { face, corner, found, vertex_count }.into());
        }
    }
    Ok(())
}
