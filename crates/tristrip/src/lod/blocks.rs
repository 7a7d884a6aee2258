//! `blocks`: a level model designed for current memory hierarchies. The index buffer of the current
//! level is always ready, and a level change writes only the slots that differ.
//!
//! Strips with renamed vertices get worse with each collapse, because dropped triangles remain in
//! them as degenerate triangles. Here, some levels have strips of their own, which are repaired
//! when the model is built. These levels are the *keys*. Between two keys, collapses rename slots
//! of the buffer in place.
//!
//! ```text
//! level   full ────────▶ key 1 ─────────▶ key 2 ── … ─▶ 0
//!         buffer 0       buffer 1         buffer 2       copied when the key changes
//!           slots renamed  slots renamed                 written one by one
//! ```
//! # Algorithm
//! *Keys*: the next coarser key follows when the number of triangles has fallen by x·√(T·F), or by
//! half. T is the number of triangles of the last key, and F is the number of triangles of the full
//! mesh. These distances minimize the memory of all key buffers for a given number of vertices sent
//! over all levels: a key costs memory in proportion to T, and saves vertices in proportion to the
//! square of the distance. The constant x follows from the memory that the options allow.
//!
//! *Strips of a key*: [`Repair`](crate::lod::Repair) follows the collapses from the strips of the
//! full mesh.
//!
//! *Level change*: within the range of a key, each split writes the removed vertex into its slots,
//! and each collapse writes the kept vertex into them. The records are stored once, in the order of
//! the levels. To enter the range of another key, copy its buffer and apply collapses from it.
//!
//! *Ends*: some degenerate triangles are at an end of a strip, or between two triangles that share
//! no slot. Their slots are overwritten with [`Index::RESTART`], so fewer vertices are sent (module
//! `live_buffer`).
//!
//! *Changes*: the records between two positions list the slots that differ, regardless of the level
//! changes in between. Nothing has to be recorded during a level change.
//!
//! # Complexity
//! A level change takes one step per renamed slot, about three per collapse, plus a copy of the
//! buffer when the key changes. Building repairs the strips once over all levels and takes linear
//! time per key; there are about 15 keys.

mod changed_ranges;
mod key_strips;
mod live_buffer;
mod options;
mod records;
#[cfg(test)]
mod tests;
mod upload_order;

use std::ops::Range;
use std::sync::Arc;

use crate::collapse::CollapseSequence;
use crate::error::Error;
use crate::index::Index;
use crate::lod::level::index_map::RESTART;
use crate::lod::level::level_model::{LevelCursor, LevelModel};
use crate::lod::level::level_table::LevelTable;
use crate::lod::level::replay::MAX_SLOTS_PER_ENTRY;
use crate::packed::{Packed, bits_for};
use crate::strip::Strips;
use changed_ranges::ChangedRanges;
use key_strips::KeyStrips;
use live_buffer::{Change, LiveBuffer};
pub use options::BlockOptions;
use records::{BlockRecords, Position, RecordList, index_of};
use upload_order::SlotChanges;

/// A level model that stores the index buffers of some levels, and the slots that collapses rename
/// between them.
///
/// ```
/// use std::sync::Arc;
/// use tristrip::lod::{BlockOptions, Blocks, LevelCursor};
/// use tristrip::{CollapseSequence, Rename, Strips};
/// let mut strips = Strips::default();
/// strips.push(&[0, 1, 2, 3, 4, 5, 6, 7]);
/// let renames = [[Rename { removed: 5, kept: 4 }], [Rename { removed: 0, kept: 1 }]];
/// let collapses = renames.iter().zip([0.25, 0.5]).map(|(renames, error)| (&renames[..], error));
/// let sequence = CollapseSequence::from_collapses(8, strips.to_list(), collapses)?;
/// let model = Arc::new(Blocks::new(&strips, sequence, &BlockOptions::default().with_memory(1))?);
/// let mut cursor = model.cursor::<u16>()?;
/// assert_eq!(cursor.take_changed(256), [0..8]);
/// assert_eq!(cursor.indices(), [0, 1, 2, 3, 4, 5, 6, 7]);
/// cursor.set_level(1)?;
/// assert_eq!(cursor.indices(), [0, 1, 2, 3, 4, 4, 6, 7]);
/// // Ranges are whole blocks of 16 slots, cut at the end of the buffer.
/// assert_eq!(cursor.take_changed(256), [0..8]);
/// assert_eq!(cursor.strips().triangles().count(), 4);
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Blocks {
    levels: LevelTable,
    /// The keys, starting with the full mesh.
    keys: Vec<Key>,
    /// The index buffers of all keys. A restart is stored as the largest vertex plus one.
    entries: Packed,
    largest: u32,
    records: BlockRecords,
}

/// A level with its own strips.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Key {
    level: usize,
    /// The range of its index buffer in `entries`.
    entries: Range<usize>,
    /// The position where the records of the collapses below it begin.
    records: Position,
}

impl Blocks {
    /// Builds the model from strips of the full mesh.
    ///
    /// # Errors
    /// The strips do not draw every triangle of the full mesh exactly once with its winding, or the
    /// collapses rename too many slots.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let model = Arc::new(Blocks::new(&strips, sequence, &BlockOptions::default())?);
    /// let mut cursor = model.start();
    /// cursor.set_level(1)?;
    /// assert_eq!(cursor.strips().triangles().count(), 2);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn new(
        strips: &Strips,
        sequence: impl Into<Arc<CollapseSequence>>,
        options: &BlockOptions,
    ) -> Result<Self, Error> {
        let sequence: Arc<CollapseSequence> = sequence.into();
        let vertex_count = sequence.vertex_count();
        strips.check_vertices(vertex_count)?;
        // A collapse can introduce a vertex that no strip contains.
        let kept = sequence.iter().flat_map(|collapse| collapse.renames.iter().map(|rename| rename.kept));
        let largest = strips.vertices().iter().copied().chain(kept).max().unwrap_or(0);
        let entry_bits = bits_for(largest + 1);
        let levels = LevelTable::of(&sequence);
        let key_levels = options.key_levels(&levels, strips, largest);
        let mut of_keys = KeyStrips::new(strips, &sequence, options)?;
        let (mut keys, mut entries, mut records) = (Vec::new(), Packed::default(), RecordList::new(largest));
        let mut entry_count = 0;
        let mut limit = RenameLimit::new(strips);
        for (i, &level) in key_levels.iter().enumerate() {
            // The level of the next key has its own strips.
            let end = key_levels.get(i + 1).map_or(0, |next| next + 1);
            let mut map = of_keys.at(level)?;
            if options.small_uploads {
                map = in_upload_order(map, &sequence, end..level, RenameLimit::new(strips))?;
            }
            let mut buffer = LiveBuffer::new(map, vertex_count);
            buffer.entries().iter().for_each(|&entry| entries.push(entry.min(largest + 1), entry_bits));
            let start = entry_count;
            entry_count += buffer.entries().len();
            keys.push(Key { level, entries: start..entry_count, records: records.end() });
            for below in (end..level).rev() {
                let changes = buffer.collapse(sequence.collapse_to(below).renames);
                limit.count(changes)?;
                records.push(changes)?;
            }
        }
        Ok(Self { levels, keys, entries, largest, records: records.pack() })
    }

    /// Returns a cursor at the level of the full mesh, with indices of type `I`.
    ///
    /// # Errors
    /// A vertex index does not fit into the type, or equals its restart value.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let model = Arc::new(Blocks::new(&strips, sequence, &BlockOptions::default())?);
    /// let (mut near, mut far) = (model.cursor::<u32>()?, model.cursor::<u8>()?);
    /// far.set_level(0)?;
    /// assert_eq!((near.strips().triangles().count(), far.strips().triangles().count()), (3, 1));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn cursor<I: Index>(self: &Arc<Self>) -> Result<BlocksCursor<I>, Error> {
        if I::from_vertex(self.largest).is_none_or(|index| index == I::RESTART) {
            let limit = I::RESTART.to_vertex().map_or(u64::from(RESTART), u64::from) - 1;
            return Err(Error::LimitExceeded { what: I::DESCRIPTION, found: u64::from(self.largest), limit });
        }
        Ok(self.any_cursor())
    }

    /// Returns a cursor with an index type that fits all vertices.
    fn any_cursor<I: Index>(self: &Arc<Self>) -> BlocksCursor<I> {
        let longest = self.keys.iter().map(|key| key.entries.len()).max().unwrap_or(0);
        let mut cursor = BlocksCursor {
            model: Arc::clone(self),
            level: 0,
            key: 0,
            position: Position::default(),
            buffer: Vec::with_capacity(longest),
            taken: None,
            display: Strips::default(),
            is_current: false,
        };
        cursor.load(0);
        cursor
    }

    /// Returns the levels that have their own strips, starting with the full mesh.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let model = Blocks::new(&strips, sequence, &BlockOptions::default())?;
    /// assert_eq!(model.keys().next(), Some(2));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn keys(&self) -> impl ExactSizeIterator<Item = usize> {
        self.keys.iter().map(|key| key.level)
    }

    /// Returns the index of the key whose buffer is used for a level.
    fn key_of(&self, level: usize) -> usize {
        self.keys.partition_point(|key| key.level >= level).saturating_sub(1)
    }
}

impl LevelModel for Blocks {
    fn levels(&self) -> &LevelTable {
        &self.levels
    }

    fn memory(&self) -> usize {
        self.levels.memory() + size_of_val(&self.keys[..]) + self.entries.memory() + self.records.memory()
    }

    /// Indices have 16 bits if the vertices fit, otherwise 32.
    fn start(self: Arc<Self>) -> Box<dyn LevelCursor> {
        match self.cursor::<u16>() {
            Ok(cursor) => Box::new(cursor),
            Err(_) => Box::new(self.any_cursor::<u32>()),
        }
    }
}

/// The index buffer of [`Blocks`] at one level.
#[derive(Debug, Clone)]
pub struct BlocksCursor<I> {
    model: Arc<Blocks>,
    level: usize,
    key: usize,
    /// The position where the records of the next collapse begin.
    position: Position,
    buffer: Vec<I>,
    /// The key and the position at the last call of [`BlocksCursor::take_changed`].
    taken: Option<(usize, Position)>,
    display: Strips,
    is_current: bool,
}

impl<I: Index> BlocksCursor<I> {
    /// Returns the index buffer of the level: strips separated by one or more [`Index::RESTART`].
    /// It can contain degenerate triangles, which draw nothing.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut cursor = Arc::new(Blocks::new(&strips, sequence, &BlockOptions::default())?).cursor::<u32>()?;
    /// assert_eq!(cursor.indices(), [0, 1, 2, 3, 4]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn indices(&self) -> &[I] {
        &self.buffer
    }

    /// Returns the index ranges changed since the last call, sorted and non-empty. They are merged
    /// to at most `most` ranges, or to one range if `most` is 0. Ranges with the smallest gaps
    /// between them are merged first. The first call returns the whole buffer, as does the first
    /// call after a change to another key.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut cursor = Arc::new(Blocks::new(&strips, sequence, &BlockOptions::default())?).cursor::<u32>()?;
    /// assert_eq!(cursor.take_changed(8), [0..5]);
    /// assert!(cursor.take_changed(8).is_empty());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn take_changed(&mut self, most: usize) -> Vec<Range<usize>> {
        let now = (self.key, self.position);
        let Some((_, position)) = self.taken.replace(now).filter(|(key, _)| *key == self.key) else {
            return std::iter::once(0..self.buffer.len()).collect();
        };
        let between = position.min(self.position)..position.max(self.position);
        let mut changed = ChangedRanges::of(self.buffer.len());
        self.model.records.slots(between).for_each(|slot| changed.mark(slot));
        changed.ranges(most)
    }

    /// Copies the buffer of a key and sets the level to the key's level.
    fn load(&mut self, key: usize) {
        let of = &self.model.keys[key];
        self.buffer.clear();
        let (restart, bits) = (self.model.largest + 1, bits_for(self.model.largest + 1));
        self.buffer.resize(of.entries.len(), I::RESTART);
        let start = of.entries.start * bits as usize;
        self.model.entries.unpack(start, bits, &mut self.buffer, |entry| index_of(entry, restart));
        (self.key, self.level, self.position) = (key, of.level, of.records);
    }
}

impl<I: Index> LevelCursor for BlocksCursor<I> {
    fn levels(&self) -> &LevelTable {
        &self.model.levels
    }

    fn level(&self) -> usize {
        self.level
    }

    fn set_level(&mut self, level: usize) -> Result<(), Error> {
        self.model.levels.check(level)?;
        if level == self.level {
            return Ok(());
        }
        self.is_current = false;
        let key = self.model.key_of(level);
        if key != self.key {
            self.load(key);
        }
        let records = &self.model.records;
        if level < self.level {
            records.collapse(self.level - level, &mut self.position, &mut self.buffer);
        } else {
            records.split(level - self.level, &mut self.position, &mut self.buffer);
        }
        self.level = level;
        Ok(())
    }

    fn strips(&mut self) -> &Strips {
        if !self.is_current {
            self.display.clear();
            let mut strip = Vec::new();
            for entries in self.buffer.split(|&index| index == I::RESTART).filter(|strip| !strip.is_empty()) {
                strip.clear();
                strip.extend(entries.iter().filter_map(|index| index.to_vertex()));
                self.display.push(&strip);
            }
            self.is_current = true;
        }
        &self.display
    }

    fn memory(&self) -> usize {
        self.buffer.capacity() * size_of::<I>() + self.display.memory()
    }
}

/// Orders the strips of a key by the level changes that write them.
fn in_upload_order(
    map: Vec<u32>,
    sequence: &CollapseSequence,
    levels: Range<usize>,
    mut limit: RenameLimit,
) -> Result<Vec<u32>, Error> {
    // A level change by a percent of all levels is about as long as the smallest intervals.
    let mut changes = SlotChanges::new(map.len().max(1), levels.len(), sequence.len() / 100);
    let mut buffer = LiveBuffer::new(map, sequence.vertex_count());
    let entries = buffer.entries().to_vec();
    for (number, below) in (0..).zip(levels.rev()) {
        let of_collapse = buffer.collapse(sequence.collapse_to(below).renames);
        limit.count(of_collapse)?;
        let changed = of_collapse.iter().filter(|change| change.fine != change.coarse);
        changed.for_each(|change| changes.add(change.slot, number));
    }
    Ok(upload_order::ordered(&entries, &changes))
}

/// Limits the number of renamed slots, which is very large for a malicious sequence.
struct RenameLimit {
    found: u64,
    limit: u64,
}

impl RenameLimit {
    fn new(strips: &Strips) -> Self {
        Self { found: 0, limit: strips.vertices_sent().saturating_mul(MAX_SLOTS_PER_ENTRY) as u64 }
    }

    fn count(&mut self, changes: &[Change]) -> Result<(), Error> {
        self.found += changes.iter().filter(|change| change.fine != change.coarse).count() as u64;
        let Self { found, limit } = *self;
        if found > limit {
            return Err(Error::LimitExceeded { what: "slots renamed by all collapses", found, limit });
        }
        Ok(())
    }
}
