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

use super::RESTART;
use crate::collapse::CollapseSequence;
use crate::error::{Error, MeshProblem};
use crate::strip::Strips;

/// The most places that a model may have for each entry of its map, on the average over all collapses: meshes have about
/// five, a hostile sequence has as many as there are collapses.
const MOST_PLACES_PER_ENTRY: usize = 256;

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

/// What a vertex split writes: one vertex, at some places of the index map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Update<'a> {
    /// The vertex that comes back.
    pub vertex: u32,
    /// Its places in the index map, counted from 0, rising.
    pub places: &'a [u32],
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

/// Entries of a map at a level, and what leads to other levels.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Replay {
    entries: Vec<u32>,
    level: usize,
    records: Records,
}

impl Replay {
    fn refine(&mut self) -> bool {
        if self.level == self.records.len() {
            return false;
        }
        for update in self.records.split(self.level) {
            update.places.iter().for_each(|&place| self.entries[place as usize] = update.vertex);
        }
        self.level += 1;
        true
    }

    fn coarsen(&mut self) -> bool {
        if self.level == 0 {
            return false;
        }
        self.level -= 1;
        let range = self.records.places_of(self.level);
        for (&place, &entry) in self.records.places[range.clone()].iter().zip(&self.records.coarse[range]) {
            self.entries[place as usize] = entry;
        }
        true
    }

    fn go_to(&mut self, level: usize) {
        assert!(level <= self.records.len(), "level {level} of {}", self.records.len());
        while self.level < level {
            self.refine();
        }
        while self.level > level {
            self.coarsen();
        }
    }
}

/// What the collapses write, and over what, in the order from the full mesh to the base mesh.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
struct Records {
    /// End of each collapse among the vertices.
    vertex_ends: Vec<u32>,
    /// The vertices removed.
    vertices: Vec<u32>,
    /// End of each vertex among the places.
    place_ends: Vec<u32>,
    places: Vec<u32>,
    /// What the collapse writes at each place.
    coarse: Vec<u32>,
}

impl Records {
    fn len(&self) -> usize {
        self.vertex_ends.len()
    }

    fn vertices_of(&self, level: usize) -> std::ops::Range<usize> {
        range(&self.vertex_ends, self.len() - 1 - level)
    }

    fn places_of(&self, level: usize) -> std::ops::Range<usize> {
        let vertices = self.vertices_of(level);
        let end = |i: usize| if i == 0 { 0 } else { self.place_ends[i - 1] as usize };
        end(vertices.start)..end(vertices.end)
    }

    fn split(&self, level: usize) -> impl ExactSizeIterator<Item = Update<'_>> {
        self.vertices_of(level)
            .map(|i| Update { vertex: self.vertices[i], places: &self.places[range(&self.place_ends, i)] })
    }

    /// Adds a removed vertex and what is written over it, places rising, to the collapse that is not ended yet.
    fn push(&mut self, vertex: u32, written: impl Iterator<Item = (u32, u32)>) {
        self.vertices.push(vertex);
        for (place, entry) in written {
            self.places.push(place);
            self.coarse.push(entry);
        }
        self.place_ends.push(self.places.len() as u32);
    }

    /// Ends a collapse, unless there are too many places for a map of so many entries.
    fn end(&mut self, entry_count: usize) -> Result<(), Error> {
        self.vertex_ends.push(self.vertices.len() as u32);
        let limit = entry_count.saturating_mul(MOST_PLACES_PER_ENTRY).min(u32::MAX as usize);
        if self.places.len() > limit {
            let (found, limit) = (self.places.len() as u64, limit as u64);
            return Err(Error::LimitExceeded { what: "places of all collapses", found, limit });
        }
        Ok(())
    }
}

fn range(ends: &[u32], i: usize) -> std::ops::Range<usize> {
    if i == 0 { 0..ends[0] as usize } else { ends[i - 1] as usize..ends[i] as usize }
}

/// The places of each vertex, as lists through the map, to be taken and joined.
struct Places {
    /// First place of each vertex, plus one; 0 where there is none.
    first: Vec<u32>,
    /// The next place of the same vertex after each one, plus one.
    next: Vec<u32>,
}

impl Places {
    /// Lists the places of a map that pass a test.
    fn of(map: &[u32], vertex_count: usize, is_listed: impl Fn(usize) -> bool) -> Self {
        let mut places = Self { first: vec![0; vertex_count], next: vec![0; map.len()] };
        for (place, &vertex) in map.iter().enumerate().rev() {
            if vertex != RESTART && is_listed(place) {
                places.add(vertex, place as u32);
            }
        }
        places
    }

    fn add(&mut self, vertex: u32, place: u32) {
        self.next[place as usize] = std::mem::replace(&mut self.first[vertex as usize], place + 1);
    }

    /// Takes all places of a vertex, rising.
    fn take(&mut self, vertex: u32, taken: &mut Vec<u32>) {
        taken.clear();
        let mut place = std::mem::take(&mut self.first[vertex as usize]);
        while place > 0 {
            taken.push(place - 1);
            place = self.next[place as usize - 1];
        }
        taken.sort_unstable();
    }
}
