//! Index maps: the vertices of all strips one after the other, with [`RESTART`] between strips, as a restart index buffer has them.

/// Separates strips in an index map; no vertex has this number.
pub const RESTART: u32 = u32::MAX;
