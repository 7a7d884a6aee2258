//! Bytes become progressive strips as they arrive, in pieces of any size: each item is read once,
//! whole.
//!
//! ```text
//! header ─▶ positions ─▶ entries ─▶ base mesh ─▶ position ─▶ slots ─▶ one level more ─▶ end
//!                                                   ▲          │           │
//!                                                   └──────────┴───────────┘
//! ```
//! An item is the header, a position, an entry or a slot. An item that ends beyond a piece waits in
//! `partial`, and a split of which records are missing in `split`; nothing else is kept back.

mod items;
mod references;

use super::layout::{Header, Sizes};
use super::records::WireRecords;
use tristrip::Error;
use tristrip::Strips;
use tristrip::lod::{Filter, decode_entries};

/// What the next bytes are.
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

/// The records of a split that is not complete.
#[derive(Debug, Clone, Default)]
struct OpenSplit {
    slots: Vec<u32>,
    /// The end of each whole record among the slots.
    record_ends: Vec<usize>,
}

/// The entries at a level below the highest one that has arrived.
#[derive(Debug, Clone)]
struct Lower {
    entries: Vec<u32>,
    level: usize,
}

/// Progressive strips that arrive in pieces. It has all levels whose records have arrived, and
/// stands at the highest one, or at one that was chosen.
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
    /// The bytes of an item of which some are missing.
    partial: Vec<u8>,
    /// The offset of the item.
    offset: u64,
    failure: Option<Error>,
    /// The positions of all vertices that have arrived.
    positions: Vec<[f32; 3]>,
    /// The entries at the highest level that has arrived.
    entries: Vec<u32>,
    records: WireRecords,
    /// Where the decoder stands, if it is not the highest level.
    lower: Option<Lower>,
    split: OpenSplit,
    filter: Filter,
    /// Memory for the decoded map.
    map: Vec<u32>,
    /// The display strips, and whether they are those of the level.
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

    /// Reads the next bytes, as many as there are. A decoder that stands at the highest level stays
    /// at the highest one; at a lower level that was chosen it stays there.
    ///
    /// # Errors
    /// [`Error::Format`]: the bytes are not what [`encode`](super::encode()) writes. The levels
    /// before them stay, and all later updates return the same error. [`Error::LimitExceeded`]: the
    /// records have more than 256 slots per entry of the map.
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

    /// Goes to a level that has arrived. Time: one step per slot of the records between, and per
    /// entry of the map from the highest level.
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

    /// Returns the level at which the decoder stands, from 0 for the base mesh; `None` before the
    /// base mesh has arrived.
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

    /// Counts the levels that have arrived, the base mesh included.
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

    /// Returns the counts of all that arrives, for progress and for buffers; `None` before the
    /// header has arrived.
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

    /// Returns the positions of the vertices at the level, in the order in which they were sent:
    /// those of a lower level are its first ones.
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

    /// Returns the display strips at the level, over the vertices of [`WireDecoder::positions`]; none
    /// before the base mesh has arrived.
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

    /// Returns the memory of the decoder in bytes, which is bounded by the bytes that have arrived.
    ///
    /// ```
    /// use tristrip_lab::wire::WireDecoder;
    /// // A header that promises four billion splits.
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

    /// Returns the level, if the base mesh has arrived.
    fn current(&self) -> usize {
        self.lower.as_ref().map_or(self.records.len(), |lower| lower.level)
    }

    /// Goes to a level that has arrived.
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
