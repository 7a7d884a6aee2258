//! Verifies that strips draw every face of a mesh exactly once, with its original winding.
//!
//! [`verify`](fn@verify) compares by vertex index. [`verify_models`] compares two models by
//! position.

mod by_id;
mod by_position;
mod triangle_sets;

pub use by_id::{Proof, Unproven, verify, verify_drawing};
pub use by_position::{Difference, verify_models};
