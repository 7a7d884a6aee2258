//! The topology of a surface under half-edge collapses: the triangles around each point, and how a
//! collapse changes their arrangement.

pub(crate) mod curve;
pub(crate) mod irregular;
pub(crate) mod outcome;
pub(crate) mod topology;
