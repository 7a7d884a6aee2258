//! The layout that encoder and decoder share: the header, the sizes of numbers, and the reserved
//! slots.

use tristrip::Error;
use tristrip::lod::{RESTART, encoded_offset};
use tristrip::text::counted;

/// A byte that is not ASCII, `PS` for progressive strips, and the version.
const SIGNATURE: [u8; 4] = [0x89, b'P', b'S', 1];

/// The bytes of the header, and of a position.
pub(super) const HEADER_BYTES: usize = 20;
pub(super) const POSITION_BYTES: usize = 12;

/// The number of entry values that are not vertices: the restart and four symbols.
const SPECIAL_ENTRIES: u32 = 5;
/// The number of slot values with a special meaning.
const RESERVED_SLOTS: u32 = 2;

/// The number of bytes of an entry of the map, or of a slot: 2, 3 or 4.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Width(usize);

impl Width {
    /// Returns the minimum number of bytes for a number.
    fn of(largest: u32) -> Self {
        Self((2..4).find(|bytes| largest >> (8 * bytes) == 0).unwrap_or(4))
    }

    pub(super) fn bytes(self) -> usize {
        self.0
    }

    fn largest(self) -> u32 {
        u32::MAX >> (32 - 8 * self.0)
    }

    /// Appends the low bytes of a number. The restart and the symbols are the highest numbers of
    /// every width.
    pub(super) fn append(self, number: u32, out: &mut Vec<u8>) {
        out.extend_from_slice(&number.to_le_bytes()[..self.0]);
    }

    /// Returns the entry that a number represents.
    pub(super) fn entry(self, number: u32) -> u32 {
        let below_end = self.largest() - number;
        if below_end < SPECIAL_ENTRIES { u32::MAX - below_end } else { number }
    }

    /// Returns the slot value that ends the record of a vertex, but not the split: another record
    /// of the split follows.
    pub(super) fn goes_on(self) -> u32 {
        (self.largest() >> 1) - 1
    }

    /// Returns the slot value that ends the split of a vertex without slots.
    pub(super) fn no_slot(self) -> u32 {
        self.largest() >> 1
    }
}

/// Decodes a little-endian number.
pub(super) fn number(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |number, &byte| number << 8 | u32::from(byte))
}

/// Returns whether an entry is a vertex below `vertex_count`, a restart or a symbol.
pub(super) fn is_entry(entry: u32, vertex_count: u32) -> bool {
    entry < vertex_count || entry == RESTART || encoded_offset(entry).is_some()
}

/// The counts at the beginning of the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Header {
    /// The number of vertices of the base mesh.
    pub base_vertex_count: u32,
    /// The number of entries of the index map: vertices, symbols and restarts.
    pub entry_count: u32,
    /// The number of vertex splits, which is the level of the full mesh.
    pub split_count: u32,
    /// The number of vertices that the splits restore: one per split, or more on attribute seams.
    pub restored_vertex_count: u32,
}

impl Header {
    /// Returns the size of an entry of the map in bytes: 2 for a base mesh of at most 65,531
    /// vertices, 3 for at most 16,777,211, otherwise 4.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut decoder = WireDecoder::default();
    /// decoder.update(&encoded.bytes)?;
    /// assert_eq!(decoder.header().map(|header| header.entry_bytes()), Some(2));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn entry_bytes(&self) -> usize {
        self.entry_width().bytes()
    }

    /// Returns the size of a slot of a record in bytes: 2 for a map of at most 32,766 entries, 3
    /// for at most 8,388,606, otherwise 4.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut decoder = WireDecoder::default();
    /// decoder.update(&encoded.bytes)?;
    /// assert_eq!(decoder.header().map(|header| header.slot_bytes()), Some(2));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn slot_bytes(&self) -> usize {
        self.slot_width().bytes()
    }

    pub(super) fn entry_width(&self) -> Width {
        Width::of(self.base_vertex_count.saturating_add(SPECIAL_ENTRIES - 1))
    }

    pub(super) fn slot_width(&self) -> Width {
        let highest_slot = self.entry_count.saturating_add(RESERVED_SLOTS - 1);
        Width::of(highest_slot.saturating_mul(2).saturating_add(1))
    }

    /// Returns the header for counts, if the format can represent them.
    pub(super) fn of_counts(counts: [usize; 4]) -> Result<Self, Error> {
        let limits = [Self::MAX_VERTICES, Self::MAX_ENTRIES, u32::MAX, Self::MAX_VERTICES];
        let what =
            ["vertices of the base mesh", "entries of the index map", "vertex splits", "restored vertices"];
        let mut checked = [0; 4];
        for (i, checked) in checked.iter_mut().enumerate() {
            let (found, limit) = (counts[i] as u64, u64::from(limits[i]));
            let fitting = u32::try_from(found).ok().filter(|&count| count <= limits[i]);
            *checked = fitting.ok_or(Error::LimitExceeded { what: what[i], found, limit })?;
        }
        let [base_vertex_count, entry_count, split_count, restored_vertex_count] = checked;
        Ok(Self { base_vertex_count, entry_count, split_count, restored_vertex_count })
    }

    /// The maximum number of vertices: their indices must be below the symbols.
    const MAX_VERTICES: u32 = u32::MAX - SPECIAL_ENTRIES + 1;
    /// The maximum number of entries: their slots must be below the reserved ones.
    const MAX_ENTRIES: u32 = (u32::MAX >> 1) + 1 - RESERVED_SLOTS;

    pub(super) fn append(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(&SIGNATURE);
        let counts = [self.base_vertex_count, self.entry_count, self.split_count, self.restored_vertex_count];
        counts.iter().for_each(|count| out.extend_from_slice(&count.to_le_bytes()));
    }

    /// Decodes the header. An error has the byte offset.
    pub(super) fn read(bytes: &[u8]) -> Result<Self, Error> {
        let wrong = |offset, found: String, expected: String| Error::Format { offset, found, expected };
        let (signature, counts) = bytes.split_at_checked(4).unwrap_or_default();
        if signature != SIGNATURE {
            let found = format!("{signature:02X?}");
            return Err(wrong(0, found, format!("the signature {SIGNATURE:02X?}")));
        }
        let mut all = [0; 4];
        all.iter_mut().zip(counts.chunks(4)).for_each(|(count, bytes)| *count = number(bytes));
        let [base_vertex_count, entry_count, split_count, restored_vertex_count] = all;
        if entry_count > Self::MAX_ENTRIES {
            let expected = format!("at most {}", Self::MAX_ENTRIES);
            return Err(wrong(8, format!("{entry_count} entries"), expected));
        }
        let most = Self::MAX_VERTICES.saturating_sub(base_vertex_count);
        let least = split_count;
        if restored_vertex_count > most
            || restored_vertex_count < least
            || (least == 0) != (restored_vertex_count == 0)
        {
            let found = format!(
                "{} of {}",
                counted(restored_vertex_count, "restored vertex"),
                counted(split_count, "split")
            );
            let expected = format!("one per split or more, at most {most}");
            return Err(wrong(16, found, expected));
        }
        Ok(Self { base_vertex_count, entry_count, split_count, restored_vertex_count })
    }
}

/// The size of each section.
///
/// ```
#[doc = include_str!("example.txt")]
/// let sizes = encoded.sizes;
/// assert_eq!((sizes.header_bytes, sizes.position_bytes, sizes.map_bytes), (20, 4 * 12, 6 * 2));
/// // Two records with one slot each.
/// assert_eq!(sizes.record_bytes, 2 * (12 + 2));
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Sizes {
    /// The size of the header in bytes, 20.
    pub header_bytes: u64,
    /// The size of the positions of the base mesh in bytes, 12 per vertex.
    pub position_bytes: u64,
    /// The size of the index map at the base level in bytes.
    pub map_bytes: u64,
    /// The size of all records in bytes: positions and slots.
    pub record_bytes: u64,
}

impl Sizes {
    /// Returns the total size of all sections in bytes.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// assert_eq!(encoded.sizes.total_bytes(), encoded.bytes.len() as u64);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn total_bytes(&self) -> u64 {
        self.header_bytes + self.position_bytes + self.map_bytes + self.record_bytes
    }

    /// Returns the sizes of the complete sections of a header, and of records that end at an
    /// offset.
    pub(super) fn of(header: &Header, position_count: usize, entry_count: usize, total_bytes: u64) -> Self {
        let header_bytes = HEADER_BYTES as u64;
        let position_bytes =
            POSITION_BYTES as u64 * (position_count as u64).min(header.base_vertex_count.into());
        let map_bytes = header.entry_bytes() as u64 * entry_count as u64;
        let record_bytes = total_bytes.saturating_sub(header_bytes + position_bytes + map_bytes);
        Self { header_bytes, position_bytes, map_bytes, record_bytes }
    }
}
