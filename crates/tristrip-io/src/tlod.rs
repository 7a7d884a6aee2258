//! `.tlod`: a view-dependent level-of-detail model in one file, with a mesh, its strips and its
//! collapses.
//!
//! The file contains the input of [`SkipStrips::new`](tristrip::lod::SkipStrips::new). All numbers
//! are little-endian. A header of 12 bytes is followed by sections; nothing follows the last
//! section:
//!
//! ```text
//! file      8 bytes  89 54 4C 4F 44 0D 0A 1A: a non-ASCII byte, `TLOD`, CR LF, Ctrl-Z
//!           u32      version, 1
//! section   4 bytes  kind, in ASCII
//!           u64      length of the content in bytes
//!           content
//!           u32      CRC-32 (as in PNG) of kind, length and content
//!
//! HEAD      u32 × 7  vertices, attributes, strips, strip vertices, triangles, collapses, renames
//! POSN      f32 × 3  per vertex: its position, finite
//! ATTR      u32      length of the name in bytes (one section per attribute)
//!           u8       type of the values: 0 f32, 1 f64, 2 u8, 3 i8, 4 u16, 5 i16, 6 u32, 7 i32
//!           u8       components, at least 1
//!           u8       1 if integers are normalized, else 0
//!           u8       0
//!           name     UTF-8
//!           values   per vertex: one per component
//! STRP      u32      per strip: the end of its vertices in the following list
//!           u32      per strip vertex: its index
//! COLL      f32      per collapse, from the full mesh on: its error
//!           u32      per collapse: the end of its renames in the following list
//!           u32 × 2  per rename: the removed vertex and the kept vertex
//! ```
//!
//! Sections are in this order. Triangles are not stored: they are the triangles of the strips, in
//! drawing order.
//!
//! # Algorithm
//! The reader reads at most 64 KiB at a time, and each list grows with the bytes that were read, so
//! a count without data allocates nothing. The length of a section must match the counts. Numbers
//! are checked after the checksum of their section. Finally, the collapses are replayed. This
//! checks that each renames only vertices that are still in use.
//!
//! # Complexity
//! O(n log n) time. Size: 4 bytes per number, plus 44 per collapse. The reader uses at most
//! [`MEMORY_PER_BYTE`] bytes of memory per byte of the file, plus 1 MiB.
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

/// Checks whether a file starts with the `.tlod` magic.
pub(crate) fn is_tlod(bytes: &[u8]) -> bool {
    bytes.starts_with(&sections::MAGIC)
}
