//! Progressive strips: strips that are updated at every collapse and every vertex split by renaming
//! a few slots.
//!
//! The vertices of all strips are stored in one *index map*, with a restart between strips. A
//! collapse overwrites the removed vertex with another entry in every slot that contains it. The
//! vertex split that undoes the collapse writes the vertex back. The record of a split therefore
//! consists of the vertex and its slots. Moving to the next level requires no other data.
//!
//! ```text
//! level 8   0 1 2 3 4 R 3 2 5       4 collapses to 2, then 3 to 2
//! level 7   0 1 2 3 2 R 3 2 5       the split of level 7: vertex 4 in slot 4
//! level 6   0 1 2 2 2 R 2 2 5       the split of level 6: vertex 3 in slots 3 and 6
//! ```
//! The number of slots, u, determines the cost of sending a refinement: 12 bytes for the position
//! of the vertex and 2 bytes per slot. Toward the base mesh, vertices accumulate slots and u grows;
//! [`encoded`] limits it to about three.
//!
//! # References
//! Hoppe: *Progressive Meshes*, 1996 ([`ProgressiveMesh`]). Kim, Park, Yang, Neelamkavil: *A
//! Rendering-Efficient Progressive Transmission of 3D Meshes*, 2005, section 3.
//!
//! # Complexity
//! A step takes O(u) time. Memory: 4 bytes per entry of the map, 12 bytes per collapse, and 8 bytes
//! per slot that it renames.

mod encoded;
mod naive;
mod pm;

#[cfg(test)]
mod tests;

pub use encoded::decode as decode_entries;
pub use encoded::encoded_offset;
pub use pm::{ProgressiveMesh, ProgressiveMeshCursor, VertexSplit};

use std::sync::Arc;

use super::filter::Filter;
use crate::collapse::CollapseSequence;
use crate::error::Error;
use crate::lod::level::index_map::RESTART;
use crate::lod::level::level_model::{LevelCursor, LevelModel};
use crate::lod::level::level_table::LevelTable;
pub use crate::lod::level::replay::SlotUpdate;
use crate::lod::level::replay::{Records, Replay};
use crate::names::names;
use crate::strip::Strips;

/// What a collapse writes into the slots of the removed vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Encoding {
    /// The kept vertex.
    Naive,
    /// A symbol that refers to the kept vertex if it is nearby; see [`encoded_offset`].
    #[default]
    Offsets,
}

names! {
    "tristrip::lod::Encoding", Encoding, "encoding",
    Naive => "naive", "Progressive strips that store every slot that a collapse renames";
    Offsets => "offsets", "E-PS: slots that follow a neighbour are stored once (Kim et al. 2005)";
}

/// The strips of a mesh at all levels of a collapse sequence, stored as an index map and the slots
/// that each collapse renames in it. The model is immutable; a [`ProgressiveStripsCursor`] stores
/// the map of one level.
///
/// ```
/// use std::sync::Arc;
/// use tristrip::lod::{Encoding, LevelCursor, ProgressiveStrips};
/// use tristrip::{CollapseSequence, Rename, Strips};
/// let mut strips = Strips::default();
/// strips.push(&[0, 1, 2, 3]);
/// let rename = [Rename { removed: 3, kept: 2 }];
/// let sequence = CollapseSequence::from_collapses(4, strips.to_list(), [(&rename[..], 0.5)])?;
///
/// let model = Arc::new(ProgressiveStrips::new(&strips, &sequence, Encoding::Offsets)?);
/// let mut cursor = model.cursor();
/// cursor.set_level(0)?;
/// let mut map = Vec::new();
/// cursor.decode_to(&mut map);
/// assert_eq!(map, [0, 1, 2, 2]);
/// assert_eq!(cursor.strips().vertices(), [0, 1, 2]);
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ProgressiveStrips {
    /// The entries of the full mesh.
    full: Vec<u32>,
    records: Records,
    levels: LevelTable,
    encoding: Encoding,
    filter: Filter,
}

impl ProgressiveStrips {
    /// Builds the model from strips and a sequence of collapses.
    ///
    /// # Errors
    /// A strip has a vertex that is not in the sequence; there are more than 2³² − 5 vertices; the
    /// collapses rename more than 256 slots per entry of the map.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let model = ProgressiveStrips::new(&strips, &sequence, Encoding::Offsets)?;
    /// assert_eq!(model.levels().triangle_count(1)?, 2);
    /// strips.push(&[7, 8, 9]); // of another mesh
    /// assert!(ProgressiveStrips::new(&strips, &sequence, Encoding::Offsets).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn new(strips: &Strips, sequence: &CollapseSequence, encoding: Encoding) -> Result<Self, Error> {
        let vertex_count = sequence.vertex_count();
        if vertex_count as u64 > encoded::MAX_VERTEX_COUNT as u64 {
            let (found, limit) = (vertex_count as u64, encoded::MAX_VERTEX_COUNT as u64);
            return Err(Error::LimitExceeded { what: "vertices of progressive strips", found, limit });
        }
        strips.check_vertices(vertex_count)?;
        let map = strips.to_restart(RESTART);
        let (full, records) = match encoding {
            Encoding::Naive => naive::record(map, sequence, |_| u32::MAX)?,
            Encoding::Offsets => encoded::record(&map, sequence)?,
        };
        let levels = LevelTable::of(sequence);
        Ok(Self { full, records, levels, encoding, filter: Filter::default() })
    }

    crate::setters! {
        /// Sets the filter of the display strips; the default is [`Filter::Linked`].
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// let model = ProgressiveStrips::new(&strips, &sequence, Encoding::Offsets)?.with_filter(Filter::None);
        /// let mut cursor = Arc::new(model).cursor();
        /// cursor.set_level(0)?;
        /// assert_eq!(cursor.strips().vertices(), [0, 1, 2, 2, 2]);
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_filter(filter: Filter);
    }

    /// Returns the encoding: what collapses write into slots.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let model = ProgressiveStrips::new(&strips, &sequence, Encoding::Naive)?;
    /// assert_eq!(model.encoding(), Encoding::Naive);
    /// assert_ne!(model.encoding(), Encoding::default());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// Returns a cursor at the level of the full mesh.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let model = Arc::new(ProgressiveStrips::new(&strips, &sequence, Encoding::Offsets)?);
    /// let (mut first, second) = (model.cursor(), model.cursor());
    /// first.coarsen();
    /// assert_eq!((first.level(), second.level()), (1, 2));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn cursor(self: &Arc<Self>) -> ProgressiveStripsCursor {
        let replay = Replay { entries: self.full.clone(), level: self.records.len() };
        ProgressiveStripsCursor {
            model: Arc::clone(self),
            replay,
            map: Vec::new(),
            display: Strips::default(),
            is_current: false,
        }
    }

    /// Returns the slot updates of the split from `level` to `level` + 1, one update per restored
    /// vertex; `None` if there is no such split.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let model = ProgressiveStrips::new(&strips, &sequence, Encoding::Naive)?;
    /// let updates: Vec<SlotUpdate<'_>> = model.split(0).into_iter().flatten().collect();
    /// // The strip of level 0 is 0 1 2 2 2.
    /// assert_eq!(updates, [SlotUpdate { vertex: 3, slots: &[3, 4] }]);
    /// assert!(model.split(2).is_none());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn split(&self, level: usize) -> Option<impl ExactSizeIterator<Item = SlotUpdate<'_>>> {
        (level < self.records.len()).then(|| self.records.split_of(level))
    }

    /// Returns the number of slots written by the split from `level` to `level` + 1, called u in
    /// the literature; 0 if there is no such split.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let slots = |encoding| ProgressiveStrips::new(&strips, &sequence, encoding).map(|model| model.slot_count(0));
    /// assert_eq!((slots(Encoding::Naive)?, slots(Encoding::Offsets)?), (2, 1));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn slot_count(&self, level: usize) -> usize {
        self.split(level).into_iter().flatten().map(|update| update.slots.len()).sum()
    }
}

impl LevelModel for ProgressiveStrips {
    fn levels(&self) -> &LevelTable {
        &self.levels
    }

    fn memory(&self) -> usize {
        size_of_val(&self.full[..]) + self.records.memory() + self.levels.memory()
    }

    fn start(self: Arc<Self>) -> Box<dyn LevelCursor> {
        Box::new(self.cursor())
    }
}

/// The index map of [`ProgressiveStrips`] at one level.
#[derive(Debug, Clone)]
pub struct ProgressiveStripsCursor {
    model: Arc<ProgressiveStrips>,
    replay: Replay,
    /// Reused memory for the decoded map.
    map: Vec<u32>,
    /// The display strips; valid for the current level if `is_current`.
    display: Strips,
    is_current: bool,
}

impl ProgressiveStripsCursor {
    /// Returns the model.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let cursor = Arc::new(ProgressiveStrips::new(&strips, &sequence, Encoding::Offsets)?).cursor();
    /// // Another cursor of the same model.
    /// let other = cursor.model().cursor();
    /// assert!(Arc::ptr_eq(other.model(), cursor.model()));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn model(&self) -> &Arc<ProgressiveStrips> {
        &self.model
    }

    /// Moves one level up by splitting a vertex. Returns `false` at the full mesh.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut cursor = Arc::new(ProgressiveStrips::new(&strips, &sequence, Encoding::Offsets)?).cursor();
    /// cursor.set_level(0)?;
    /// let mut triangles = vec![cursor.strips().triangles().count()];
    /// while cursor.refine() {
    ///     triangles.push(cursor.strips().triangles().count());
    /// }
    /// assert_eq!(triangles, [1, 2, 3]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn refine(&mut self) -> bool {
        self.is_current = false;
        self.replay.refine(&self.model.records)
    }

    /// Moves one level down by collapsing a vertex. Returns `false` at the base mesh.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut cursor = Arc::new(ProgressiveStrips::new(&strips, &sequence, Encoding::Offsets)?).cursor();
    /// assert!(cursor.coarsen() && cursor.coarsen());
    /// assert!(!cursor.coarsen());
    /// assert_eq!(cursor.strips().vertices(), [0, 1, 2]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn coarsen(&mut self) -> bool {
        self.is_current = false;
        self.replay.coarsen(&self.model.records)
    }

    /// Returns the entries of the map at the current level: vertices, [`RESTART`] between strips,
    /// and the [symbols](encoded_offset) of [`Encoding::Offsets`].
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut cursor = Arc::new(ProgressiveStrips::new(&strips, &sequence, Encoding::Offsets)?).cursor();
    /// cursor.coarsen();
    /// assert_eq!(cursor.entries()[..4], [0, 1, 2, 3]);
    /// // Slot 4 refers to slot 3, regardless of its vertex.
    /// assert_eq!(encoded_offset(cursor.entries()[4]), Some(-1));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn entries(&self) -> &[u32] {
        &self.replay.entries
    }

    /// Fills `map` with the vertices of the current level, with [`RESTART`] between strips.
    /// Replaces its contents and reuses its memory.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// strips.push(&[4, 3, 1]);
    /// let mut cursor = Arc::new(ProgressiveStrips::new(&strips, &sequence, Encoding::Offsets)?).cursor();
    /// cursor.coarsen();
    /// let mut map = Vec::new();
    /// cursor.decode_to(&mut map);
    /// assert_eq!(map, [0, 1, 2, 3, 3, RESTART, 3, 3, 1]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn decode_to(&self, map: &mut Vec<u32>) {
        match self.model.encoding {
            Encoding::Naive => map.clone_from(&self.replay.entries),
            Encoding::Offsets => encoded::decode(&self.replay.entries, map),
        }
    }
}

impl LevelCursor for ProgressiveStripsCursor {
    fn levels(&self) -> &LevelTable {
        &self.model.levels
    }

    fn level(&self) -> usize {
        self.replay.level
    }

    fn set_level(&mut self, level: usize) -> Result<(), Error> {
        self.model.levels.check(level)?;
        if level != self.replay.level {
            self.is_current = false;
            self.replay.go_to(level, &self.model.records);
        }
        Ok(())
    }

    fn strips(&mut self) -> &Strips {
        if !self.is_current {
            let mut map = std::mem::take(&mut self.map);
            self.decode_to(&mut map);
            self.display.clear();
            self.model.filter.map_to(&map, &mut self.display);
            (self.map, self.is_current) = (map, true);
        }
        &self.display
    }

    fn memory(&self) -> usize {
        size_of_val(&self.replay.entries[..]) + size_of_val(&self.map[..]) + self.display.memory()
    }
}
