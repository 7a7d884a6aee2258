//! Simplification: half-edge collapses, cheapest first, from a mesh to as coarse a one as is asked for.

pub mod collapse;

pub use collapse::{Collapse, CollapseSequence, Rename};
