//! The start of a GLB: the first bytes of a file, and the JSON in them.

use std::fs::File;
use std::io;

use crate::bytes_source::read_at;

/// The bytes before the JSON.
pub(crate) const HEAD_BYTES: u64 = 20;

/// Reads the first bytes of a file.
pub(crate) fn first_bytes(file: &File, most: u64) -> io::Result<Vec<u8>> {
    bytes_at(file, 0, most)
}

/// Reads so many bytes of a file from an offset on, fewer at its end.
pub(crate) fn bytes_at(file: &File, offset: u64, most: u64) -> io::Result<Vec<u8>> {
    let length = file.metadata()?.len().saturating_sub(offset).min(most);
    let mut bytes = vec![0; length as usize];
    let mut filled = 0;
    while filled < bytes.len() {
        match read_at(file, &mut bytes[filled..], offset + filled as u64)? {
            0 => break,
            count => filled += count,
        }
    }
    bytes.truncate(filled);
    Ok(bytes)
}

/// Returns the bytes of the JSON, as the head of a GLB says; `None` for another file.
pub(crate) fn json_bytes(head: &[u8]) -> Option<u64> {
    let length = head.get(12..16).and_then(|bytes| bytes.try_into().ok()).map(u32::from_le_bytes)?;
    (head.starts_with(b"glTF") && head.len() as u64 >= HEAD_BYTES).then_some(u64::from(length))
}

/// Returns the JSON of a GLB, if it is there to its end.
pub(crate) fn json_of(start: &[u8]) -> Option<&[u8]> {
    let length = start.get(12..16).and_then(|bytes| bytes.try_into().ok()).map(u32::from_le_bytes)?;
    start.get(20..)?.get(..length as usize)
}
