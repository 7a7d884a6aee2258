//! Progressive streams: a mesh that can be drawn after the first bytes and is refined to the full
//! mesh as more bytes arrive.
//!
//! ```text
//! Mesh, CollapseSequence in batches
//!   │ encode
//!   ▼
//! chunk 0: base mesh │ chunk 1 │ chunk 2 │ …
//!   │ Decoder::update
//!   ▼
//! triangles of every level
//! ```
//! A stream stores the base mesh of a simplification, followed by its collapses in reverse order,
//! as vertex splits. Each chunk leads to a level. A client can draw after every chunk, stop
//! anywhere, and resume at the next chunk's byte offset. A file can hold several meshes; their
//! chunks can be interleaved in any order.
//!
//! # Algorithm
//! Splits are grouped into batches. No two points that a batch removes share a triangle, so the
//! splits of a batch can be written in any order. They are written fan by fan, with neighbouring
//! fans close together. For each fan, the stream stores whether it is split. For a split, it stores
//! which corners move to the new vertex, the position of the new point, and the attributes of the
//! new vertex. Positions and attributes are residuals against a prediction from the neighbouring
//! mesh. All of these are coded as decisions by a range coder with adaptive models. Positions lie
//! on a grid. The grid step is halved as the error of the levels decreases. The encoder plans all
//! splits and fits the weights of the predictions in rehearsal passes before it writes.
//!
//! Points on attribute seams and non-manifold points have several fans, which are split together.
//!
//! All values that affect decoding are integers, so decoders in other languages produce the same
//! result. `docs/formats/progressive-glb.md` defines the bytes.
//!
//! # Sizes
//! The table lists bits per vertex at 14 bits per coordinate, for all chunks. Vertices that no
//! triangle uses are not counted.
//!
//! | model | vertices | connectivity | total |
//! |---|---|---|---|
//! | bunny | 34,834 | 4.8 | 23.4 |
//! | horse | 48,485 | 4.8 | 21.1 |
//! | `armadillo_43k` | 43,243 | 4.9 | 23.0 |
//! | dragon | 435,545 | 5.4 | 18.4 |
//!
//! # References
//! Hoppe: *Progressive Meshes*, 1996. Pajarola, Rossignac: *Compressed Progressive Meshes*, 2000.
//! Alliez, Desbrun: *Progressive Compression for Lossless Transmission of Triangle Meshes*, 2001.
//! Kim, Park, Yang, Neelamkavil: *A Rendering-Efficient Progressive Transmission of 3D Meshes*,
//! 2005.

mod base;
mod channels;
mod chunk;
mod costs;
mod decoder;
mod encoder;
mod fans;
mod fault;
mod fit;
mod grid;
mod head;
mod levels;
mod options;
mod part;
mod places;
mod plan;
mod refiner;
mod run;
#[cfg(test)]
mod samples;
mod source;
mod splits;
mod strips;
mod surface;
#[cfg(test)]
mod tests;

pub use costs::StreamCosts;
pub use decoder::{ChunkView, Decoder, StreamLimits, chunks};
pub use encoder::{EncodedStream, StreamChunk, encode, unsplittable};
pub use fault::{ExceededLimit, StreamError};
pub use grid::PART;
pub use options::StreamOptions;
pub use part::StreamPart;
