//! The topology of a surface while half-edge collapses change it: which triangles are around a point, and what a collapse does to their arrangement.

pub(crate) mod curve;
pub(crate) mod irregular;
pub(crate) mod outcome;
pub(crate) mod topology;
