//! Progressive strips as they are transmitted in the literature: the base mesh, and 12 + 2 u bytes
//! for each vertex that is added to it.
//!
//! The index map of the [progressive strips](tristrip::lod::ProgressiveStrips) arrives at the base
//! level. A record restores one vertex: its position, and the u slots of the map that it is written
//! into. What the other slots of the vertex are, followers of these, the map says already.
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
//! 1. Vertices get new numbers in the order in which they are sent: those of the base map by their
//!    first slot, then each restored one. The paper inserts a vertex at its old index, and
//!    increments all indices from there on; with this order it is always the last one, and neither
//!    its index is sent nor another index changes. Vertices in no slot of any level are not sent.
//! 2. The base map is sent: vertices, restarts, and the four symbols R−2, R−1, R+1, R+2 of
//!    [`Encoding::Offsets`](tristrip::lod::Encoding). The exceptions of the paper, disjoint and
//!    closed vertices, are slots that hold the vertex itself, at the base level or in a record.
//! 3. For each level a record per restored vertex is sent, as equation 2 has it.
//!
//! Departures from the paper:
//! - A header of 20 bytes has the counts: the bytes describe themselves.
//! - Equation 2 does not say where a record ends. Here the lowest bit of each slot does; a record
//!   still takes 12 + 2 u bytes.
//! - Two bytes hold slots up to 32,765. A larger map has slots of three bytes, and records of 12 +
//!   3 u, or of four. The bunny of the paper has about 88,000 slots, which two bytes cannot name
//!   either. Entries of the map have more than two bytes if the base mesh has more than 65,531
//!   vertices.
//! - A split on an attribute seam restores several vertices of one position. The record of each but
//!   the last is longer by a slot. A vertex without a slot takes as many bytes as with one; that
//!   occurs only where strips do not draw the triangles of the collapses.
//! - Only positions are sent, no normals or texture coordinates: 12 bytes are "at least" the
//!   geometry in the paper, and all that it counts.
//! - Errors of levels are not sent.
//!
//! # References
//! Kim, Park, Yang, Neelamkavil: *A Rendering-Efficient Progressive Transmission of 3D Meshes*,
//! 2005, section 3.
//!
//! # Complexity
//! Both directions take one step per entry and per slot sent. A [`WireDecoder`] holds 12 bytes per
//! position, 8 bytes per entry, 12 bytes per record and 8 bytes per slot, beside the display
//! strips, 4 more per entry below the highest level, and nothing for bytes that have not arrived.

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
