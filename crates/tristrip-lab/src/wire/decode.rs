//! Decodes progressive strips as their bytes arrive, in pieces of any size. Each item is decoded
//! once it is complete.
//!
//! ```text
//! header ─▶ positions ─▶ entries ─▶ base mesh ─▶ position ─▶ slots ─▶ one level more ─▶ end
//!                                                   ▲          │           │
//!                                                   └──────────┴───────────┘
//! ```
//! An item is the header, a position, an entry or a slot. An item that continues in the next piece
//! is kept in `partial`, and a split with missing records in `split`. Nothing else is buffered.

mod items;
mod references;

use super::layout::{Header, Sizes};
use super::records::WireRecords;
use tristrip::Error;
use tristrip::Strips;
use tristrip::lod::{Filter, decode_entries};

/// The kind of the next item.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Next {
    #[default]
    Header,
    /// A position of the base mesh.
    Position,
    Entry,
    /// The position of a restored vertex.
    RestoredPosition,
    Slot,
    End,
}

/// The records of an incomplete split.
#[derive(Debug, Clone, Default)]
struct OpenSplit {
    slots: Vec<u32>,
    /// For each complete record, the end of its range of slots.
    record_ends: Vec<usize>,
}

/// The entries at a level below the highest one that has arrived.
#[derive(Debug, Clone)]
struct Lower {
    entries: Vec<u32>,
    level: usize,
}

/// Progressive strips that arrive in pieces. The decoder has all levels whose records have arrived.
/// Its current level is the highest one, or a selected one.
///
/// ```
#[doc = include_str!("example.txt")]
/// let mut decoder = WireDecoder::default();
/// let mut drawn = Vec::new();
/// for piece in encoded.bytes.chunks(7) {
///     decoder.update(piece)?;
///     drawn.push(decoder.strips().triangles().count());
/// }
/// assert_eq!(drawn, [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 2, 2, 4]);
/// assert!(decoder.is_complete());
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct WireDecoder {
    next: Next,
    header: Header,
    /// The bytes of an incomplete item.
    partial: Vec<u8>,
    /// The offset of the item.
    offset: u64,
    failure: Option<Error>,
    /// The positions of all vertices that have arrived.
    positions: Vec<[f32; 3]>,
    /// The entries at the highest level that has arrived.
    entries: Vec<u32>,
    records: WireRecords,
    /// The selected level, if it is not the highest one.
    lower: Option<Lower>,
    split: OpenSplit,
    filter: Filter,
    /// A buffer for the decoded map.
    map: Vec<u32>,
    /// The display strips, and whether they belong to the current level.
    display: Strips,
    is_current: bool,
}

impl WireDecoder {
    /// Sets the filter of the display strips; the default is [`Filter::Linked`].
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut decoder = WireDecoder::default().with_filter(Filter::None);
    /// decoder.update(&encoded.bytes)?;
    /// decoder.set_level(0)?;
    /// // Every strip as it is, degenerate triangles included.
    /// assert_eq!(decoder.strips().vertices(), [0, 1, 2, 2, 2, 3]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    #[must_use]
    pub fn with_filter(mut self, filter: Filter) -> Self {
        self.filter = filter;
        self
    }

    /// Decodes the next bytes, any number of them. If the current level is the highest one, it
    /// follows the new levels; a selected lower level does not change.
    ///
    /// # Errors
    /// [`Error::Format`]: the bytes are not what [`encode`](super::encode()) writes. The levels
    /// before them are kept, and all later updates return the same error. [`Error::LimitExceeded`]:
    /// the records have more than 256 slots per entry of the map.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut decoder = WireDecoder::default();
    /// let (base, records) = encoded.bytes.split_at(80);
    /// decoder.update(base)?;
    /// assert_eq!(decoder.level(), Some(0));
    /// // A damaged slot of the second record.
    /// let mut records = records.to_vec();
    /// records[26] = 99;
    /// let error = decoder.update(&records).unwrap_err();
    /// assert_eq!(error.to_string(), "byte 106: found slot 49, expected less than 6");
    /// assert_eq!(decoder.level(), Some(1));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn update(&mut self, bytes: &[u8]) -> Result<(), Error> {
        if let Some(failure) = &self.failure {
            return Err(failure.clone());
        }
        let result = self.read(bytes);
        self.failure = result.clone().err();
        result
    }

    /// Selects a level that has arrived. Takes one step per slot of the records in between, and per
    /// entry of the map when leaving the highest level.
    ///
    /// # Errors
    /// The level has not arrived.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut decoder = WireDecoder::default();
    /// assert!(decoder.set_level(0).is_err());
    /// decoder.update(&encoded.bytes)?;
    /// decoder.set_level(0)?;
    /// assert_eq!(decoder.strips().vertices(), [0, 1, 2]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn set_level(&mut self, level: usize) -> Result<(), Error> {
        if level >= self.level_count() {
            let found = format!("{level} of {} levels that have arrived", self.level_count());
            return Err(Error::Parameter { name: "level", found, expected: "one that has arrived" });
        }
        self.go_to(level);
        Ok(())
    }

    /// Returns the current level, from 0 for the base mesh; `None` before the base mesh has
    /// arrived.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut decoder = WireDecoder::default();
    /// assert_eq!(decoder.level(), None);
    /// decoder.update(&encoded.bytes)?;
    /// assert_eq!(decoder.level(), Some(2));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn level(&self) -> Option<usize> {
        self.has_base().then(|| self.current())
    }

    /// Returns the number of levels that have arrived, including the base mesh.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut decoder = WireDecoder::default();
    /// let mut counts = Vec::new();
    /// for piece in encoded.bytes.chunks(40) {
    ///     decoder.update(piece)?;
    ///     counts.push(decoder.level_count());
    /// }
    /// assert_eq!(counts, [0, 1, 3]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn level_count(&self) -> usize {
        if self.has_base() { self.records.len() + 1 } else { 0 }
    }

    /// Returns whether all levels have arrived.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let (last, before) = encoded.bytes.split_last().expect("bytes");
    /// let mut decoder = WireDecoder::default();
    /// decoder.update(before)?;
    /// assert!(!decoder.is_complete());
    /// decoder.update(&[*last])?;
    /// assert!(decoder.is_complete());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn is_complete(&self) -> bool {
        self.next == Next::End
    }

    /// Returns the total counts, for progress and buffer sizes; `None` before the header has
    /// arrived.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut decoder = WireDecoder::default();
    /// assert!(decoder.header().is_none());
    /// decoder.update(&encoded.bytes[..20])?;
    /// let header = decoder.header().expect("20 bytes");
    /// assert_eq!((header.base_vertex_count, header.restored_vertex_count, header.split_count), (4, 2, 2));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn header(&self) -> Option<Header> {
        (self.next != Next::Header).then_some(self.header)
    }

    /// Returns the positions of the vertices at the current level, in the order in which they were
    /// sent. A lower level uses a prefix of them.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut decoder = WireDecoder::default();
    /// decoder.update(&encoded.bytes)?;
    /// let all = decoder.positions().to_vec();
    /// decoder.set_level(0)?;
    /// assert_eq!((all.len(), decoder.positions()), (6, &all[..4]));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn positions(&self) -> &[[f32; 3]] {
        if !self.has_base() {
            return &[];
        }
        let count = self.header.base_vertex_count as usize + self.records.vertex_count_of(self.current());
        &self.positions[..count]
    }

    /// Returns the display strips at the current level, over the vertices of
    /// [`WireDecoder::positions`]; empty before the base mesh has arrived.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut decoder = WireDecoder::default();
    /// decoder.update(&encoded.bytes)?;
    /// // The strip 0 1 2 3 4 5 with the vertices in the order in which they were sent.
    /// assert_eq!(encoded.vertices, [0, 1, 2, 5, 3, 4]);
    /// assert_eq!(decoder.strips().vertices(), [0, 1, 2, 4, 5, 3]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn strips(&mut self) -> &Strips {
        if !self.is_current && self.has_base() {
            let entries = self.lower.as_ref().map_or(&self.entries, |lower| &lower.entries);
            decode_entries(entries, &mut self.map);
            self.display.clear();
            self.filter.map_to(&self.map, &mut self.display);
            self.is_current = true;
        }
        &self.display
    }

    /// Returns the bytes that have arrived, by section.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut decoder = WireDecoder::default();
    /// decoder.update(&encoded.bytes)?;
    /// assert_eq!(decoder.sizes(), encoded.sizes);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn sizes(&self) -> Sizes {
        match self.next {
            Next::Header => Sizes::default(),
            _ => Sizes::of(&self.header, self.positions.len(), self.entries.len(), self.offset),
        }
    }

    /// Returns the memory of the decoder in bytes. It is bounded by the bytes that have arrived.
    ///
    /// ```
    /// use tristrip_lab::wire::WireDecoder;
    /// // A header that announces four billion splits.
    /// let mut decoder = WireDecoder::default();
    /// decoder.update(&[0x89, b'P', b'S', 1, 3, 0, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0xF0, 0, 0, 0, 0xF0])?;
    /// assert!(decoder.memory() < 1000);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn memory(&self) -> usize {
        let lists = [&self.entries, &self.map, &self.split.slots];
        lists.map(|list| size_of_val(&list[..])).iter().sum::<usize>()
            + self.lower.as_ref().map_or(0, |lower| size_of_val(&lower.entries[..]))
            + size_of_val(&self.positions[..])
            + size_of_val(&self.split.record_ends[..])
            + self.partial.len()
            + self.records.memory()
            + self.display.memory()
    }

    fn has_base(&self) -> bool {
        matches!(self.next, Next::RestoredPosition | Next::Slot | Next::End)
    }

    /// Returns the current level; 0 before the base mesh has arrived.
    fn current(&self) -> usize {
        self.lower.as_ref().map_or(self.records.len(), |lower| lower.level)
    }

    /// Moves to a level that has arrived.
    fn go_to(&mut self, level: usize) {
        let highest = self.records.len();
        self.is_current &= level == self.current();
        if level == highest {
            self.lower = None;
            return;
        }
        let at_highest = || Lower { entries: self.entries.clone(), level: highest };
        let lower = self.lower.get_or_insert_with(at_highest);
        while lower.level < level {
            self.records.split(lower.level, &mut lower.entries);
            lower.level += 1;
        }
        while lower.level > level {
            lower.level -= 1;
            self.records.collapse(lower.level, &mut lower.entries);
        }
    }
}
