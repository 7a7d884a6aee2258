//! Measurements around triangle strips: reproductions of the papers, charts of methods and of levels of detail, pictures of
//! strips.
//!
//! ```text
//! PreparedModel ─▶ pareto: every method, indices against misses   ─▶ chart (SVG)
//! ModelLevels   ─▶ traffic: what every filter sends               ─▶ tables, chart
//! ModelLevels   ─▶ recovery: time and memory of every level model ─▶ table, chart
//! Analysis      ─▶ analysis: misses by cache size, strip lengths  ─▶ chart
//! models, papers ─▶ repro: published beside measured              ─▶ pages, charts
//! SkipStrips, cameras ─▶ flight: what each frame of a view draws  ─▶ page, chart
//! positions, strips ─▶ render: one colour per strip               ─▶ picture (PNG)
//! ```
//! All texts and pictures have the same bytes on every machine, except the times of `recovery` and `flight`.

#![forbid(unsafe_code)]

pub mod analysis;
mod chart;
mod error;
pub mod flight;
pub mod pareto;
pub mod rate;
pub mod recovery;
pub mod render;
pub mod repro;
pub mod text;
pub mod traffic;

pub use error::{Error, system_message};
