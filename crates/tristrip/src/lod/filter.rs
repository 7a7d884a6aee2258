//! Filters: how the strips of the full mesh become display strips for a level of detail, which draw its triangles and little else.

pub mod repair;

pub use repair::Repair;
