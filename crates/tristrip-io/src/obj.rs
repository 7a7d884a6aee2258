//! OBJ: lines that start with a keyword. The corners of faces have separate indices for positions,
//! texture coordinates and normals.
//!
//! ```text
//! v x y z [r g b]     position, counted from 1     f 1 2 3         corners: position
//! vt u v              texture coordinate           f 1/4 2/5 3/6   position / texture coordinate
//! vn x y z            normal                       f 1/4/7 2//8 -1 … / normal; −1: last so far
//! usemtl name         material of the next faces   mtllib name     material library
//! ```
//!
//! A vertex of the result is a distinct triple of indices, in order of first use. If no face has a
//! texture coordinate or normal, the vertices of the file are used unchanged. The faces of each
//! material form a part; with several parts, each has only the vertices that it uses. The crate
//! `tobj` is not used, because it splits or merges the corners of polygons differently and its
//! errors have no line numbers.
//!
//! # References
//! Wavefront Technologies: *The Advanced Visualizer*, appendix B1, *Object Files*.
//!
//! # Complexity
//! Two passes over the corners; 4 to 12 bytes per corner in addition to the arrays of the result.

mod read;
#[cfg(feature = "fs")]
pub(crate) mod scene_library;
mod split;
mod tables;
mod write;

pub(crate) use read::read;
pub(crate) use write::{losses, write};
