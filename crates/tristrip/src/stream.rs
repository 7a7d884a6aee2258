//! Streams: a mesh that can be drawn after its first bytes, and that the others refine to the full mesh.
//!
//! ```text
//! Mesh, CollapseSequence in batches ─ encode ─▶ chunk 0: base mesh │ chunk 1 │ chunk 2 │ …  ─ Decoder::update ─▶ triangles of every level
//! ```
//! A stream holds the base mesh of a simplification and its collapses in reverse, as vertex splits. Each chunk leads to a level: a client draws after any chunk, stops at any, and
//! goes on later from the byte at which the next one starts. A file may hold several meshes, whose chunks come in any order.
//!
//! # Algorithm
//! Splits come in batches. A batch is a set of collapses whose removed points have no triangle in common, so their order is free: they are written
//! fan by fan, and fans near each other follow one another. For each fan a batch has whether it is split, which of its corners move, the position
//! of the new point and the attributes of its vertex, as residuals against a prediction from the neighbouring mesh. Each of these is a sequence of
//! decisions for a range coder with adaptive models. Positions are on a grid whose step is halved as the error of the levels gets smaller. The
//! encoder plans all splits, and fits the weights of the predictions in rehearsals, before it writes.
//!
//! On an attribute seam, and where a surface is not manifold, a point has several fans, which are split together.
//!
//! Everything that decides is an integer, so that decoders in other languages agree with this one.
//! `docs/formats/progressive-glb.md` defines the bytes.
//!
//! # Sizes
//! At 14 bits per coordinate, in bits per vertex that a triangle uses, all chunks included:
//!
//! | model | vertices | connectivity | all |
//! |---|---|---|---|
//! | bunny | 34,834 | 4.8 | 23.4 |
//! | horse | 48,485 | 4.8 | 21.1 |
//! | `armadillo_43k` | 43,243 | 4.9 | 23.0 |
//! | dragon | 435,545 | 5.4 | 18.4 |
//!
//! # References
//! Hoppe: *Progressive Meshes*, 1996. Pajarola, Rossignac: *Compressed Progressive Meshes*, 2000. Alliez, Desbrun: *Progressive Compression for Lossless Transmission of Triangle
//! Meshes*, 2001. Kim, Park, Yang, Neelamkavil: *A Rendering-Efficient Progressive Transmission of 3D Meshes*, 2005.

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
