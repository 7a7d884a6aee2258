//! Measurements: reproductions of papers, charts of methods and levels of detail, and camera
//! flights.
//!
//! ```text
//! PreparedModel ─▶ pareto: every method, indices against misses   ─▶ chart (SVG)
//! ModelLevels   ─▶ traffic: what every filter sends               ─▶ tables, chart
//! ModelLevels   ─▶ recovery: time and memory of every level model ─▶ table, chart
//! models, papers ─▶ repro: published and measured                 ─▶ pages, charts
//! SkipStrips, cameras ─▶ flight: what each frame of a view draws  ─▶ page, chart
//! ProgressiveStrips ─▶ wire: the transmission of paper 001         ─▶ bytes
//! baselines: level models that are needed only for comparison
//! ```
//! All texts and charts have the same bytes on every machine, except for the times of `recovery`
//! and `flight`.

#![forbid(unsafe_code)]

pub mod baselines;
mod error;
pub mod flight;
pub mod pareto;
pub mod recovery;
pub mod repro;
#[cfg(test)]
mod samples;
pub mod traffic;
pub mod wire;

pub use error::Error;
