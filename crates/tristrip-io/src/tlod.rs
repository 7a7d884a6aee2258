//! `.tlod`: a view-dependent level-of-detail model in one file: a mesh, its strips and its collapses.
//!
//! The file has what [`SkipStrips::new`](tristrip::lod::SkipStrips::new) takes. All numbers are little-endian. It begins with 12 bytes, which sections
//! follow, and ends with the last of them:
//!
//! ```text
//! file      8 bytes  89 54 4C 4F 44 0D 0A 1A: a byte that is not ASCII, `TLOD`, CR LF, and the end of a text file
//!           u32      version, 1
//! section   4 bytes  kind, in ASCII
//!           u64      length of the content in bytes
//!           content
//!           u32      CRC-32 (that of PNG) of kind, length and content
//!
//! HEAD      u32 × 7  vertices, attributes, strips, vertices of all strips, triangles, collapses, renames
//! POSN      f32 × 3  for each vertex: its position, finite
//! ATTR      u32      bytes of the name           one section for each attribute
//!           u8       type of the values: 0 f32, 1 f64, 2 u8, 3 i8, 4 u16, 5 i16, 6 u32, 7 i32
//!           u8       components, at least 1
//!           u8       1 if integers are fractions of their range, else 0
//!           u8       0
//!           name     UTF-8
//!           values   for each vertex: one for each component
//! STRP      u32      for each strip: the end of its vertices in the following list
//!           u32      for each vertex of all strips: its number
//! COLL      f32      for each collapse, the first from the full mesh first: its error
//!           u32      for each collapse: the end of its renames in the following list
//!           u32 × 2  for each rename: the vertex removed, and the vertex kept
//! ```
//!
//! Sections are in this order. Triangles are not stored: they are those of the strips, in drawing order.
//!
//! # Algorithm
//! The reader reads at most 64 KiB at a time, and each list grows with the bytes that have been read: a count without data allocates
//! nothing. The length of a section must match the counts. Numbers are checked after the checksum of their section. Finally the
//! collapses are replayed, which checks that each of them renames vertices that are still drawn.
//!
//! # Complexity
//! O(n log n) time. 4 bytes per number, plus 44 per collapse. The reader uses at most [`MEMORY_PER_BYTE`]
//! bytes of memory per byte of the file, plus 1 MiB.
//!
//! ```
#![doc = include_str!("tlod/example.txt")]
//! let mut bytes = Vec::new();
//! tlod::write(&model, &mut bytes)?;
//! assert!(tlod::read(&bytes[..], &TlodLimits::default())? == model);
//! # Ok::<(), tristrip_io::Error>(())
//! ```

mod limits;
mod model;
mod read;
mod sections;
mod source;
mod write;

pub use limits::{MEMORY_PER_BYTE, TlodLimits};
pub use model::TlodModel;
pub use read::read;
pub use write::write;

/// Checks whether bytes begin as a `.tlod` file does.
pub(crate) fn is_tlod(bytes: &[u8]) -> bool {
    bytes.starts_with(&sections::MAGIC)
}
