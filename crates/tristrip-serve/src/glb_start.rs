//! The start of a GLB: the first bytes of a file, and the JSON in them.

use std::fs::File;
use std::io;

use crate::bytes_source::read_at;

/// Reads the first bytes of a file.
pub(crate) fn first_bytes(file: &File, most: u64) -> io::Result<Vec<u8>> {
    let length = file.metadata()?.len().min(most);
    let mut bytes = vec![0; length as usize];
    let mut filled = 0;
    while filled < bytes.len() {
        match read_at(file, &mut bytes[filled..], filled as u64)? {
            0 => break,
            count => filled += count,
        }
    }
    bytes.truncate(filled);
    Ok(bytes)
}

/// Returns the JSON of a GLB, if it is there to its end.
pub(crate) fn json_of(start: &[u8]) -> Option<&[u8]> {
    let length = start.get(12..16).and_then(|bytes| bytes.try_into().ok()).map(u32::from_le_bytes)?;
    start.get(20..)?.get(..length as usize)
}
