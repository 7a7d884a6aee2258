//! Whole models through the pipeline: drawn, simplified, chained, packed. One program, because linking takes longer than the tests.

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
