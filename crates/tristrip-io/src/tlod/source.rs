//! Reads the sections of a file in bounded pieces and verifies their checksums.

use std::io::{ErrorKind, Read};

use crc32fast::Hasher;

use super::limits::check;
use super::sections::{PIECE_BYTES, SectionKind};
use crate::error::Error;
use tristrip::text::counted;

/// A stream of bytes from the start of the file.
pub(super) struct TlodSource<'a> {
    reader: &'a mut dyn Read,
    /// The number of bytes read.
    at: u64,
    /// The end of the current section's content.
    section_end: u64,
    checksum: Hasher,
    piece: Vec<u8>,
    /// Maximum file size in bytes.
    limit: u64,
}

impl<'a> TlodSource<'a> {
    pub(super) fn new(reader: &'a mut dyn Read, limit: u64) -> Self {
        let (checksum, piece) = (Hasher::new(), Vec::new());
        Self { reader, at: 0, section_end: 0, checksum, piece, limit }
    }

    /// Returns the number of bytes read.
    pub(super) fn at(&self) -> u64 {
        self.at
    }

    /// Reads a few bytes.
    pub(super) fn bytes<const N: usize>(&mut self, expected: &str) -> Result<[u8; N], Error> {
        check(self.at, "the file", self.at + N as u64, self.limit)?;
        let mut bytes = [0; N];
        self.fill(&mut bytes, expected)?;
        Ok(bytes)
    }

    /// Begins a section of a kind and returns the length of its content. The length must be
    /// `length`, if that is given.
    pub(super) fn begin(&mut self, kind: SectionKind, length: Option<u64>) -> Result<u64, Error> {
        let start = self.at;
        let name = String::from_utf8_lossy(&kind.code()).into_owned();
        self.checksum = Hasher::new();
        let code: [u8; 4] = self.bytes(&format!("section {name}"))?;
        if code != kind.code() {
            let known =
                if SectionKind::ALL.iter().any(|kind| kind.code() == code) { "" } else { "the unknown " };
            let found = format!("{known}section {}", code.escape_ascii());
            return Err(Error::format(format!("byte {start}"), found, format!("section {name}")));
        }
        let found = u64::from_le_bytes(self.bytes(&format!("the length of section {name}"))?);
        if let Some(expected) = length.filter(|&length| length != found) {
            return Err(wrong_length(start + 4, &name, found, expected));
        }
        check(start + 4, "the file", self.at.saturating_add(found).saturating_add(4), self.limit)?;
        self.section_end = self.at.saturating_add(found);
        Ok(found)
    }

    /// Returns the number of unread bytes in the section.
    pub(super) fn left(&self) -> u64 {
        self.section_end - self.at
    }

    /// Reads `count` numbers of `N` bytes each; the section must have as many. The list grows with
    /// the data read.
    pub(super) fn numbers<T, const N: usize>(
        &mut self,
        count: u64,
        expected: &str,
        number: impl Fn([u8; N]) -> T,
    ) -> Result<Vec<T>, Error> {
        let mut numbers = Vec::new();
        let mut left = count;
        while left > 0 {
            let here = left.min((PIECE_BYTES / N) as u64) as usize;
            let mut piece = std::mem::take(&mut self.piece);
            piece.resize(here * N, 0);
            self.fill(&mut piece, expected)?;
            if numbers.capacity() < numbers.len() + here {
                // Double the size, without capacity beyond the last number.
                let more = (numbers.len().max(here) as u64).min(left);
                numbers.reserve_exact(more as usize);
            }
            numbers.extend(piece.as_chunks().0.iter().map(|&bytes| number(bytes)));
            self.piece = piece;
            left -= here as u64;
        }
        Ok(numbers)
    }

    /// Reads and verifies the checksum of the section.
    pub(super) fn end(&mut self) -> Result<(), Error> {
        let (at, expected) = (self.at, self.checksum.clone().finalize());
        let found = u32::from_le_bytes(self.bytes("a checksum")?);
        if found == expected {
            return Ok(());
        }
        Err(Error::format(
            format!("byte {at}"),
            format!("checksum {found:08x}"),
            format!("{expected:08x}, the checksum of the section"),
        ))
    }

    /// Checks that no bytes follow.
    pub(super) fn finish(&mut self) -> Result<(), Error> {
        let mut byte = [0];
        match self.some(&mut byte)? {
            0 => Ok(()),
            _ => Err(Error::format(format!("byte {}", self.at), "more bytes", "the end of the file")),
        }
    }

    /// Fills the slice completely.
    fn fill(&mut self, bytes: &mut [u8], expected: &str) -> Result<(), Error> {
        let mut done = 0;
        while done < bytes.len() {
            let count = self.some(&mut bytes[done..])?;
            if count == 0 {
                return Err(Error::format(format!("byte {}", self.at), "the end of the file", expected));
            }
            self.at += count as u64;
            done += count;
        }
        self.checksum.update(bytes);
        Ok(())
    }

    /// Reads at least one byte, unless the file ends.
    fn some(&mut self, bytes: &mut [u8]) -> Result<usize, Error> {
        loop {
            match self.reader.read(bytes) {
                // A faulty reader may report more bytes than fit.
                Ok(count) => return Ok(count.min(bytes.len())),
                Err(error) if error.kind() == ErrorKind::Interrupted => (),
                Err(source) => {
                    return Err(Error::Io { path: format!("byte {} of the model", self.at), source });
                }
            }
        }
    }
}

/// Returns the error for a section whose length differs from the expected one.
pub(super) fn wrong_length(at: u64, section: &str, found: u64, expected: u64) -> Error {
    let found = format!("{} in section {section}", counted(found, "byte"));
    Error::format(format!("byte {at}"), found, format!("{expected}, according to the counts"))
}
