//! Index maps: the vertices of all strips in sequence, separated by [`RESTART`], as in an index
//! buffer with primitive restart.

/// Separates strips in an index map. No vertex has this index.
pub const RESTART: u32 = u32::MAX;
