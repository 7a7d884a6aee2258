//! The transmission format for progressive strips from the literature: the base mesh, and 12 + 2 u
//! bytes for each vertex that is added to it.
//!
//! The index map of the [progressive strips](tristrip::lod::ProgressiveStrips) is sent at the base
//! level. A record restores one vertex: it has the position of the vertex, and the u slots of the
//! map that it is written into. The map already defines the other slots of the vertex, which refer
//! to these.
//!
//! ```text
//! strip 0 1 2 3 4 5; vertex 4 collapses to 3, then 3 to 2; ◁ is the symbol R−1
//!
//! header                                                            20 bytes
//! base      positions of 0 1 2 5, numbered 0 1 2 3                  48 bytes
//! map       0 1 2 ◁ ◁ 3                          draws level 0      12 bytes
//! record    position of 3, number 4; slot 3      0 1 2 4 ◁ 3        14 bytes
//! record    position of 4, number 5; slot 4      0 1 2 4 5 3        14 bytes
//! ```
//!
//! # Algorithm
//! 1. Vertices are renumbered in the order in which they are sent: first those of the base map by
//!    their first slot, then each restored vertex. The paper inserts a vertex at its old index and
//!    increments all indices from there on. With our order, a restored vertex is always the last
//!    one: its index is not sent, and no other index changes. Vertices that are in no slot at any
//!    level are not sent.
//! 2. The base map is sent: vertices, restarts, and the four symbols R−2, R−1, R+1, R+2 of
//!    [`Encoding::Offsets`](tristrip::lod::Encoding). The exceptions of the paper, disjoint and
//!    closed vertices, are slots that contain the vertex itself, at the base level or in a record.
//! 3. For each level, a record per restored vertex is sent, as in equation 2.
//!
//! Deviations from the paper:
//! - A header of 20 bytes has the counts, so the data describes itself.
//! - Equation 2 does not define where a record ends. Here, the lowest bit of each slot does; a
//!   record still takes 12 + 2 u bytes.
//! - Two bytes hold slots up to 32,765. Larger maps have slots of three bytes, and records of 12 +
//!   3 u bytes, or slots of four bytes. The paper's bunny has about 88,000 slots, which also exceed
//!   two bytes. Entries of the map take more than two bytes if the base mesh has more than 65,531
//!   vertices.
//! - A split on an attribute seam restores several vertices at one position. The record of each but
//!   the last is one slot longer. A vertex without a slot takes as many bytes as one with a slot;
//!   this occurs only if strips do not draw the triangles of the collapses.
//! - Only positions are sent, without normals or texture coordinates. The paper calls 12 bytes "at
//!   least" the geometry, and counts nothing else.
//! - Errors of levels are not sent.
//!
//! # References
//! Kim, Park, Yang, Neelamkavil: *A Rendering-Efficient Progressive Transmission of 3D Meshes*,
//! 2005, section 3.
//!
//! # Complexity
//! Both directions take one step per entry and per slot sent. A [`WireDecoder`] uses 12 bytes per
//! position, 8 bytes per entry, 12 bytes per record and 8 bytes per slot, in addition to the
//! display strips. Below the highest level it uses 4 more bytes per entry. It allocates nothing for
//! bytes that have not arrived.

mod decode;
mod encode;
mod layout;
mod model;
mod records;

#[cfg(test)]
mod tests;

pub use decode::WireDecoder;
pub use encode::{Encoded, encode};
pub use layout::{Header, Sizes};
pub(crate) use model::encode_part;
pub use model::{Level, Published, pack, unpack};
