//! Images of meshes, strips and textured models, SVG charts, and text tables.
//!
//! ```text
//! positions, strips ─▶ images: one colour per strip             ─▶ PNG
//! model             ─▶ images: base colours, textures           ─▶ PNG
//! analyze::Outcome  ─▶ analysis: misses by cache size, lengths  ─▶ chart
//! chunks            ─▶ rate: error against bytes                ─▶ chart
//! rows              ─▶ text: aligned and Markdown tables
//! ```
//! All texts, charts and images have the same bytes on every machine.

#![forbid(unsafe_code)]

pub mod analysis;
pub mod chart;
mod error;
pub mod images;
pub mod rate;
pub mod text;

pub use error::Error;
