//! glTF 2.0 and GLB.

/// A glTF document: everything around the parts, kept as it was read.
#[derive(Debug, Clone, Default)]
pub struct Scene {}
