//! OBJ: lines that begin with a keyword; faces name positions, texture coordinates and normals by indices of their own.
//!
//! ```text
//! v x y z [r g b]        position, counted from 1           f 1 2 3            corners: position
//! vt u v                 texture coordinate                 f 1/4 2/5 3/6      position / texture coordinate
//! vn x y z               normal                             f 1/4/7 2//8 -1    … / normal; −1 is the last one so far
//! usemtl name            material of the faces that follow
//! ```
//!
//! A vertex of the result is a distinct triple of indices, in order of first use; where no face names a texture coordinate or
//! normal, the vertices are those of the file. Faces are gathered by material, a part each, which holds only the vertices
//! that it uses where there are several. The parser is our own: `tobj` splits or merges polygons' corners in its own way and
//! names no line in its errors.
//!
//! # References
//! Wavefront Technologies: *The Advanced Visualizer*, appendix B1, *Object Files*.
//!
//! # Complexity
//! Two passes over the corners; 4 to 12 bytes a corner beside the arrays of the result.

mod read;
mod split;
mod write;

pub(crate) use read::read;
pub(crate) use write::{losses, write};
