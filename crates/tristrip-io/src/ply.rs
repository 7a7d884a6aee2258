//! PLY, the polygon file format: a text header that declares elements and their properties, then
//! the rows of each element.
//!
//! The rows are text or binary in either byte order. A property of an element is a number, or a
//! list of numbers preceded by its count:
//!
//! ```text
//! ply                                   vertex row   x y z      (any order, more properties)
//! format binary_little_endian 1.0       face row     3  0 1 2              (count, then corners)
//! element vertex 4                      tristrips    8  0 1 2 3 -1 2 1 4   (−1 restarts)
//! property float x   ...
//! element face 2
//! property list uchar int vertex_indices
//! end_header
//! ```
//!
//! No PLY crate is used. The available crates build a map per row, which is slow for binary files,
//! and do not report the position of an error. The triangles of `tristrips` follow the faces, with
//! the winding in which they are drawn.
//!
//! # References
//! Greg Turk: *The PLY Polygon File Format*, 1994. The `tristrips` element: Stanford 3D Scanning
//! Repository, `ply2` tools, 1999.
//!
//! # Complexity
//! One pass; memory for the file's bytes and the arrays of the result.

mod columns;
mod fixed_rows;
mod header;
mod read;
mod rows;
mod write;

pub(crate) use read::read;
pub(crate) use write::{losses, write};
