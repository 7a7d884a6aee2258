//! The framing of a stream: chunks, each with a header and a checksum.
//!
//! ```text
//! chunk = stream · bytes of the payload · visits · level · triangles · error · checksum · payload
//! ```
//! Numbers are written in groups of seven bits, lowest first. The eighth bit of a byte is set if
//! another byte follows.

use crc32fast::Hasher;

/// The header of a chunk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ChunkHead {
    /// The index of the mesh that the chunk refines.
    pub(super) stream: u32,
    pub(super) payload_bytes: u32,
    /// The number of fans that it visits; 0 for a base mesh.
    pub(super) visits: u32,
    /// The level after the chunk, with its triangles and its error.
    pub(super) level: u32,
    pub(super) triangles: u32,
    pub(super) error: f32,
}

/// The maximum size of a header with its checksum.
pub(super) const MAX_HEAD_BYTES: usize = 5 * 5 + 4 + 4;

pub(super) fn push_number(bytes: &mut Vec<u8>, mut number: u32) {
    while number >= 0x80 {
        bytes.push(number as u8 | 0x80);
        number >>= 7;
    }
    bytes.push(number as u8);
}

/// Reads from the start of a byte slice.
#[derive(Debug, Clone)]
pub(super) struct ChunkReader<'a> {
    pub(super) bytes: &'a [u8],
}

impl<'a> ChunkReader<'a> {
    /// Takes the next bytes. Returns `None` if there are too few.
    pub(super) fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.bytes.split_at_checked(count)?;
        self.bytes = rest;
        Some(taken)
    }

    pub(super) fn byte(&mut self) -> Option<u8> {
        self.take(1).map(|bytes| bytes[0])
    }

    /// Reads a number of at most 32 bits. Returns `None` if the bytes end, and an error if the
    /// number is longer.
    pub(super) fn number(&mut self) -> Option<Result<u32, NotANumber>> {
        let mut number = 0_u64;
        for i in 0..5 {
            let byte = self.byte()?;
            number |= u64::from(byte & 0x7F) << (7 * i);
            if byte < 0x80 {
                return Some(u32::try_from(number).map_err(|_| NotANumber));
            }
        }
        Some(Err(NotANumber))
    }

    pub(super) fn float(&mut self) -> Option<f32> {
        let bytes = self.take(4)?;
        bytes.try_into().ok().map(f32::from_le_bytes)
    }

    pub(super) fn double(&mut self) -> Option<f64> {
        let bytes = self.take(8)?;
        bytes.try_into().ok().map(f64::from_le_bytes)
    }
}

/// A number of more than 32 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct NotANumber;

impl ChunkHead {
    /// Returns the bytes of a chunk with this header.
    pub(super) fn with_payload(self, payload: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(MAX_HEAD_BYTES + payload.len());
        for number in [self.stream, payload.len() as u32, self.visits, self.level, self.triangles] {
            push_number(&mut bytes, number);
        }
        bytes.extend(self.error.to_le_bytes());
        let checksum = checksum(&bytes, payload);
        bytes.extend(checksum.to_le_bytes());
        bytes.extend(payload);
        bytes
    }

    /// Reads a header with its checksum. Returns the header, the checksum and the length of both;
    /// `None` if the bytes end.
    pub(super) fn read(bytes: &[u8]) -> Option<Result<(Self, u32, usize), NotANumber>> {
        let mut reader = ChunkReader { bytes };
        let mut numbers = [0; 5];
        for number in &mut numbers {
            *number = match reader.number()? {
                Ok(number) => number,
                Err(fault) => return Some(Err(fault)),
            };
        }
        let error = reader.float()?;
        let checksum = reader.take(4)?.iter().rev().fold(0, |sum, &byte| sum << 8 | u32::from(byte));
        let [stream, payload_bytes, visits, level, triangles] = numbers;
        let head = Self { stream, payload_bytes, visits, level, triangles, error };
        Some(Ok((head, checksum, bytes.len() - reader.bytes.len())))
    }
}

/// Returns the CRC-32 of the header before the checksum, and the payload.
pub(super) fn checksum(head: &[u8], payload: &[u8]) -> u32 {
    let mut hasher = Hasher::new();
    hasher.update(head);
    hasher.update(payload);
    hasher.finalize()
}
