//! Progressive strips: strips that follow every collapse and every vertex split, by the few places that it renames.
//!
//! The vertices of all strips stand in one *index map*, with a restart between strips. A collapse writes another entry over the removed
//! vertex wherever it stands; the vertex split that undoes it writes the vertex back. So the record of a split is the vertex and its
//! places, and no step looks at anything else.
//!
//! ```text
//! level 8   0 1 2 3 4 R 3 2 5       4 collapses to 2, then 3 to 2
//! level 7   0 1 2 3 2 R 3 2 5       the split of level 7: vertex 4 at place 4
//! level 6   0 1 2 2 2 R 2 2 5       the split of level 6: vertex 3 at places 3 and 6
//! ```
//! How many places there are, u, is what a refinement costs on its way to a client: 12 bytes for the position of the vertex and 2
//! for each place. Vertices pile up in the map toward the base mesh, and u grows with them; [`encoded`] has it stay near three.
//!
//! # References
//! Hoppe: *Progressive Meshes*, 1996 ([`pm`]). Kim, Park, Yang, Neelamkavil: *A Rendering-Efficient Progressive Transmission of 3D
//! Meshes*, 2005, section 3.
//!
//! # Complexity
//! A step takes O(u) time. Memory: 4 bytes an entry of the map; for a collapse 12 bytes, and 8 for each of its places.

pub mod encoded;
pub mod naive;
pub mod pm;

#[cfg(test)]
mod tests;

pub use pm::ProgressiveMesh;

use super::index_map::RESTART;
use super::replay::Replay;
pub use super::replay::Update;
use crate::collapse::CollapseSequence;
use crate::error::{Error, MeshProblem};
use crate::strip::Strips;

/// What a collapse writes over the places of the removed vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Encoding {
    /// The kept vertex: see [`naive`].
    Naive,
    /// Where the kept vertex stands nearby, a symbol that refers to it: see [`encoded`].
    #[default]
    Offsets,
}

/// The strips of a mesh at any level of a collapse sequence, as an index map that is updated in place.
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
    /// Makes the model of strips under a sequence of collapses, at the level of the full mesh.
    ///
    /// # Errors
    /// A strip has a vertex that the sequence does not have; there are more than 2³² − 5 vertices, or more than 256 places for each entry of
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

    /// Gives what collapses write.
    pub fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// Counts the collapses, which is the level of the full mesh.
    pub fn len(&self) -> usize {
        self.replay.records.len()
    }

    /// Tells whether there is no collapse.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Gives the level at which the map stands.
    pub fn level(&self) -> usize {
        self.replay.level
    }

    /// Splits a vertex: goes one level up. Gives `false` at the full mesh.
    pub fn refine(&mut self) -> bool {
        self.replay.refine()
    }

    /// Collapses a vertex: goes one level down. Gives `false` at the base mesh.
    pub fn coarsen(&mut self) -> bool {
        self.replay.coarsen()
    }

    /// Goes to a level, step by step.
    ///
    /// # Panics
    /// `level` is greater than [`ProgressiveStrips::len`].
    pub fn go_to(&mut self, level: usize) {
        self.replay.go_to(level);
    }

    /// Gives the map as it stands: vertices, [`RESTART`] between strips, and the [symbols](encoded::offset) of [`Encoding::Offsets`].
    pub fn entries(&self) -> &[u32] {
        &self.replay.entries
    }

    /// Fills `map` with the vertices at the level, [`RESTART`] between strips. What it held is dropped, its memory used again.
    pub fn decode_to(&self, map: &mut Vec<u32>) {
        match self.encoding {
            Encoding::Naive => map.clone_from(&self.replay.entries),
            Encoding::Offsets => encoded::decode(&self.replay.entries, map),
        }
    }

    /// Gives what the split from `level` to the next one writes: an update for each vertex that it brings back.
    ///
    /// # Panics
    /// `level` is not less than [`ProgressiveStrips::len`].
    pub fn split(&self, level: usize) -> impl ExactSizeIterator<Item = Update<'_>> {
        self.replay.records.split(level)
    }

    /// Counts the places that the split from `level` to the next one writes: the u of the literature.
    ///
    /// # Panics
    /// `level` is not less than [`ProgressiveStrips::len`].
    pub fn place_count(&self, level: usize) -> usize {
        self.split(level).map(|update| update.places.len()).sum()
    }
}

fn check(strips: &Strips, sequence: &CollapseSequence) -> Result<(), Error> {
    let vertex_count = sequence.vertex_count();
    if vertex_count as u64 > encoded::MOST_VERTICES as u64 {
        let (found, limit) = (vertex_count as u64, encoded::MOST_VERTICES as u64);
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
