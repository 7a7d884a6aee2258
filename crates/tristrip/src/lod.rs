//! Levels of detail: the strips of the full mesh, render-ready at every level of a [`CollapseSequence`](crate::CollapseSequence).
//!
//! A collapse renames vertices, also where they stand in strips. So the strips are made once, for the full mesh; at any other level they
//! are the same strips with some vertices renamed, and a [`Filter`] takes out what draws nothing any more.
//!
//! ```text
//! Strips of the full mesh ─ renamed for a level ─▶ simplified strips ─ filter ─▶ display strips
//! ```

pub mod filter;
pub mod progressive;
#[cfg(test)]
mod samples;
pub mod traffic;

pub use filter::{Filter, Repair, Sent};
pub use progressive::{ProgressiveMesh, ProgressiveStrips};

/// Separates strips in an index map; no vertex has this number.
pub const RESTART: u32 = u32::MAX;
