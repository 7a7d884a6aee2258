//! Decodes one item after the other. Each item is checked; it changes the decoder or is an error at
//! its offset.

use super::super::layout::{HEADER_BYTES, Header, POSITION_BYTES, is_entry, number};
use super::{Next, WireDecoder, references};
use tristrip::Error;
use tristrip::lod::RESTART;
use tristrip::text::counted;

impl WireDecoder {
    /// Decodes all items that end within some bytes.
    pub(super) fn read(&mut self, mut bytes: &[u8]) -> Result<(), Error> {
        while !bytes.is_empty() {
            let item_bytes = self.item_bytes();
            let missing = item_bytes - self.partial.len();
            let Some((end, rest)) = bytes.split_at_checked(missing) else {
                self.partial.extend_from_slice(bytes);
                return Ok(());
            };
            if self.partial.is_empty() {
                self.item(end)?;
            } else {
                let mut item = std::mem::take(&mut self.partial);
                item.extend_from_slice(end);
                self.item(&item)?;
                item.clear();
                self.partial = item;
            }
            self.offset += item_bytes as u64;
            bytes = rest;
        }
        Ok(())
    }

    /// Returns the size of the next item.
    fn item_bytes(&self) -> usize {
        match self.next {
            Next::Header => HEADER_BYTES,
            Next::Position | Next::RestoredPosition => POSITION_BYTES,
            Next::Entry => self.header.entry_bytes(),
            Next::Slot => self.header.slot_bytes(),
            Next::End => 1,
        }
    }

    /// Decodes a complete item.
    fn item(&mut self, item: &[u8]) -> Result<(), Error> {
        match self.next {
            Next::Header => {
                self.header = Header::read(item)?;
                self.next = Next::Position;
            }
            Next::Position => self.position(item)?,
            Next::Entry => self.entry(number(item))?,
            Next::RestoredPosition => {
                self.position(item)?;
                self.next = Next::Slot;
            }
            Next::Slot => self.slot(number(item))?,
            Next::End => return Err(self.wrong("another byte", "the end")),
        }
        self.leave_complete_sections()
    }

    /// Advances to the next section while the current one is complete.
    fn leave_complete_sections(&mut self) -> Result<(), Error> {
        if self.next == Next::Position && self.positions.len() == self.header.base_vertex_count as usize {
            self.next = Next::Entry;
        }
        if self.next == Next::Entry && self.entries.len() == self.header.entry_count as usize {
            self.check_references()?;
            self.next = Next::RestoredPosition;
        }
        if self.next == Next::RestoredPosition && self.records.len() == self.header.split_count as usize {
            self.next = Next::End;
        }
        Ok(())
    }

    fn position(&mut self, item: &[u8]) -> Result<(), Error> {
        let mut position = [0.0; 3];
        position.iter_mut().zip(item.chunks(4)).for_each(|(x, bytes)| *x = f32::from_bits(number(bytes)));
        if let Some(x) = position.iter().find(|x| !x.is_finite()) {
            return Err(self.wrong(format!("the coordinate {x}"), "a finite number"));
        }
        self.positions.push(position);
        Ok(())
    }

    fn entry(&mut self, number: u32) -> Result<(), Error> {
        let entry = self.header.entry_width().entry(number);
        let vertex_count = self.header.base_vertex_count;
        if !is_entry(entry, vertex_count) {
            let expected = format!("less than {vertex_count}, a symbol or a restart");
            return Err(self.wrong(format!("entry {number}"), expected));
        }
        self.entries.push(entry);
        Ok(())
    }

    /// Checks that the references of the base map lead to vertices. Records only write vertices, so
    /// later levels are then valid, too.
    fn check_references(&self) -> Result<(), Error> {
        let Some(slot) = references::first_without_vertex(&self.entries) else { return Ok(()) };
        let from_end = (self.entries.len() - slot) as u64 * self.header.entry_bytes() as u64;
        // The last item is not counted yet, unless there are no entries.
        let offset = self.offset + self.header.entry_bytes() as u64 - from_end;
        let (found, expected) = ("a symbol".into(), "one that leads to a vertex of its strip".into());
        Err(Error::Format { offset, found, expected })
    }

    /// Decodes a slot of the open record.
    fn slot(&mut self, number: u32) -> Result<(), Error> {
        let (slot, is_last) = (number >> 1, number & 1 == 1);
        let width = self.header.slot_width();
        let record_start = self.split.record_ends.last().copied().unwrap_or(0);
        let before = self.split.slots[record_start..].last().copied();
        if slot == width.goes_on() && is_last {
            return self.end_record();
        }
        if slot == width.no_slot() && is_last && before.is_none() {
            return self.end_split();
        }
        let found = || format!("slot {slot}");
        match self.entries.get(slot as usize) {
            None => return Err(self.wrong(found(), format!("less than {}", self.entries.len()))),
            Some(&RESTART) => return Err(self.wrong(found(), "one of a vertex, not of a restart")),
            Some(_) => {}
        }
        if let Some(before) = before.filter(|&before| before >= slot) {
            return Err(self.wrong(found(), format!("more than {before}")));
        }
        self.split.slots.push(slot);
        if is_last { self.end_split() } else { Ok(()) }
    }

    /// Ends a record that is not the last one of its split.
    fn end_record(&mut self) -> Result<(), Error> {
        self.split.record_ends.push(self.split.slots.len());
        let (left, splits) = self.left();
        if left < splits {
            let found = format!("another record of a split, of {left} that are left");
            return Err(self.wrong(found, format!("one or more per split, of {splits}")));
        }
        self.next = Next::RestoredPosition;
        Ok(())
    }

    /// Ends the last record of a split, and adds its level.
    fn end_split(&mut self) -> Result<(), Error> {
        let (left, splits) = self.left();
        if splits == 1 && left > 0 {
            let found = format!("the last split, {} before the last one", counted(left, "vertex"));
            return Err(self.wrong(found, "another record of the split"));
        }
        self.split.record_ends.push(self.split.slots.len());
        let first = self.positions.len() - self.split.record_ends.len();
        let mut start = 0;
        for (vertex, &end) in (first as u32..).zip(&self.split.record_ends) {
            let slots = self.split.slots[start..end].iter();
            let entries = &mut self.entries;
            let written = slots.map(|&slot| (slot, std::mem::replace(&mut entries[slot as usize], vertex)));
            self.records.push(vertex, written);
            start = end;
        }
        self.split.slots.clear();
        self.split.record_ends.clear();
        self.is_current &= self.lower.is_some();
        self.next = Next::RestoredPosition;
        self.records.end(self.entries.len())
    }

    /// Returns the number of vertices that have not arrived, and of incomplete splits.
    fn left(&self) -> (usize, usize) {
        let vertices = self.header.base_vertex_count as usize + self.header.restored_vertex_count as usize;
        (vertices - self.positions.len(), self.header.split_count as usize - self.records.len())
    }

    /// Returns an error at the offset of the item.
    fn wrong(&self, found: impl Into<String>, expected: impl Into<String>) -> Error {
        Error::Format { offset: self.offset, found: found.into(), expected: expected.into() }
    }
}
