//! Proof that strips draw exactly the faces of a mesh, each once, with its winding.
//!
//! [`by_id`] compares by vertex number, [`by_position`] compares two models by the positions of their vertices.

pub mod by_id;
pub mod by_position;
mod triangle_sets;

pub use by_id::{Proof, Unproven, verify, verify_drawing};
pub use by_position::{Difference, verify_models};
