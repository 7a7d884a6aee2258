//! Whole models through the pipeline: drawn, simplified, chained, packed. All tests are one
//! program, because linking takes longer than running them.

mod chain;
mod drawing;
#[cfg(feature = "fs")]
mod files;
mod filters;
mod flat_shaded;
mod kept_strips;
mod models;
mod normals;
mod progressive;
