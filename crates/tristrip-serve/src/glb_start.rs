//! The start of a GLB: the header and the JSON.

use std::fs::File;
use std::io;

use crate::bytes_source::read_at;

/// The number of bytes before the JSON.
pub(crate) const HEAD_BYTES: u64 = 20;

/// Reads at most `most` bytes from the start of a file.
pub(crate) fn first_bytes(file: &File, most: u64) -> io::Result<Vec<u8>> {
    bytes_at(file, 0, most)
}

/// Reads at most `most` bytes of a file from an offset, fewer at the end of the file.
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

/// Returns the size of the JSON in bytes that the header of a GLB states, or `None` for other
/// files.
pub(crate) fn json_bytes(head: &[u8]) -> Option<u64> {
    let length = head.get(12..16).and_then(|bytes| bytes.try_into().ok()).map(u32::from_le_bytes)?;
    (head.starts_with(b"glTF") && head.len() as u64 >= HEAD_BYTES).then_some(u64::from(length))
}

/// Returns the JSON of a GLB if `start` contains all of it.
pub(crate) fn json_of(start: &[u8]) -> Option<&[u8]> {
    let length = start.get(12..16).and_then(|bytes| bytes.try_into().ok()).map(u32::from_le_bytes)?;
    start.get(20..)?.get(..length as usize)
}
