//! The bytes of a response: in memory, or in a file that is read in small pieces. The memory per
//! client therefore does not depend on the file size.

use std::fs::File;
use std::io;
use std::sync::Arc;

use axum::body::Body;
use bytes::Bytes;
use futures_util::stream::{iter, try_unfold};

/// The size of the pieces that are read from a file. A file of at most this size is read when it is
/// opened.
pub(crate) const PIECE_BYTES: usize = 64 << 10;

/// The source of the bytes of a response.
#[derive(Debug, Clone)]
pub(crate) enum BytesSource {
    Memory(Bytes),
    /// A byte range of a file.
    File {
        file: Arc<File>,
        offset: u64,
        length: u64,
    },
}

impl BytesSource {
    /// Creates a source from a byte range of a file. Short ranges are read immediately. May block.
    pub(crate) fn of_file(file: File, offset: u64, length: u64) -> io::Result<Self> {
        if length > PIECE_BYTES as u64 {
            return Ok(Self::File { file: Arc::new(file), offset, length });
        }
        Ok(Self::Memory(read_exact_at(&file, offset, length as usize)?.into()))
    }

    pub(crate) fn len(&self) -> u64 {
        match self {
            Self::Memory(bytes) => bytes.len() as u64,
            Self::File { length, .. } => *length,
        }
    }

    /// Returns a body with a part of the bytes; the part must lie within them. If the file has
    /// become shorter, the body ends with an error, which closes the connection.
    pub(crate) fn body(&self, start: u64, length: u64) -> Body {
        match self {
            Self::Memory(bytes) => in_pieces(bytes.slice(start as usize..(start + length) as usize)),
            Self::File { file, offset, .. } => {
                let first = offset + start;
                let state = (Arc::clone(file), first, first + length);
                Body::from_stream(try_unfold(state, |(file, at, end)| async move {
                    if at == end {
                        return Ok::<_, io::Error>(None);
                    }
                    let (file, piece) = read_piece(file, at, end).await?;
                    let next = at + piece.len() as u64;
                    Ok(Some((piece, (file, next, end))))
                }))
            }
        }
    }

    /// Reads all bytes.
    #[cfg(test)]
    pub(crate) fn read(&self) -> io::Result<Vec<u8>> {
        match self {
            Self::Memory(bytes) => Ok(bytes.to_vec()),
            Self::File { file, offset, length } => {
                let length = usize::try_from(*length).map_err(|_| io::ErrorKind::FileTooLarge)?;
                read_exact_at(file, *offset, length)
            }
        }
    }
}

/// Returns a body in pieces, which lasts as long as its client reads. A connection counts as idle
/// once all of its bodies are handed to the socket, even if most bytes are not sent yet.
fn in_pieces(mut bytes: Bytes) -> Body {
    if bytes.len() <= PIECE_BYTES {
        return Body::from(bytes);
    }
    Body::from_stream(iter(std::iter::from_fn(move || {
        let piece = bytes.split_to(bytes.len().min(PIECE_BYTES));
        (!piece.is_empty()).then_some(Ok::<_, io::Error>(piece))
    })))
}

/// Reads the next piece on a blocking thread.
async fn read_piece(file: Arc<File>, at: u64, end: u64) -> io::Result<(Arc<File>, Bytes)> {
    let read = tokio::task::spawn_blocking(move || {
        let mut piece = vec![0; (end - at).min(PIECE_BYTES as u64) as usize];
        let count = read_at(&file, &mut piece, at)?;
        piece.truncate(count);
        Ok::<_, io::Error>((file, piece))
    });
    let (file, piece) = read.await.map_err(io::Error::other)??;
    if piece.is_empty() {
        return Err(io::Error::new(io::ErrorKind::UnexpectedEof, "the file has become shorter"));
    }
    Ok((file, piece.into()))
}

fn read_exact_at(file: &File, offset: u64, length: usize) -> io::Result<Vec<u8>> {
    let mut bytes = vec![0; length];
    let mut filled = 0;
    while filled < length {
        match read_at(file, &mut bytes[filled..], offset + filled as u64)? {
            0 => return Err(io::ErrorKind::UnexpectedEof.into()),
            count => filled += count,
        }
    }
    Ok(bytes)
}

/// Reads bytes at an offset. The file position does not move: responses share the file.
pub(crate) fn read_at(file: &File, buffer: &mut [u8], offset: u64) -> io::Result<usize> {
    loop {
        #[cfg(unix)]
        let read = std::os::unix::fs::FileExt::read_at(file, buffer, offset);
        #[cfg(windows)]
        let read = std::os::windows::fs::FileExt::seek_read(file, buffer, offset);
        match read {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => (),
            read => return read,
        }
    }
}
