//! The library's errors, sorted by who can act on them.

/// Says why a computation could not be done.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The mesh itself is not usable.
    #[error("{0}")]
    Mesh(#[from] MeshProblem),
    /// An option has a value that makes no sense.
    #[error("parameter `{name}`: found {found}, expected {expected}")]
    Parameter {
        /// The option's name, as in the command line and the docs.
        name: &'static str,
        /// The value found.
        found: String,
        /// What would have been accepted.
        expected: &'static str,
    },
    /// The input is larger than 32-bit ids can name.
    #[error("{what}: found {found}, the limit is {limit}")]
    LimitExceeded {
        /// What was counted.
        what: &'static str,
        /// How many there were.
        found: u64,
        /// How many there may be.
        limit: u64,
    },
}

/// A defect of a mesh that no method can work around.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshProblem {
    /// A corner names a vertex that does not exist.
    #[error("face {face}, corner {corner}: found vertex index {found}, expected less than {vertex_count}")]
    VertexIndex {
        /// Face, counted from 0.
        face: u32,
        /// Corner of the face, counted from 0.
        corner: u32,
        /// The index found.
        found: u32,
        /// Number of vertices of the mesh.
        vertex_count: u32,
    },
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex}: found coordinate {found}, expected a finite number")]
    NotFinite {
        /// Vertex, counted from 0.
        vertex: u32,
        /// The coordinate found.
        found: f32,
    },
    /// The corners do not divide into faces as the sizes say.
    #[error("faces: found {found} corners, expected {expected}")]
    CornerCount {
        /// Number of corners given.
        found: u64,
        /// Number that the faces need.
        expected: String,
    },
    /// A vertex attribute has another length than the positions.
    #[error("attribute `{name}`: found {found} values, expected {expected} (one for each vertex)")]
    AttributeLength {
        /// Name of the attribute.
        name: String,
        /// Vertices that it has values for.
        found: u64,
        /// Vertices of the mesh.
        expected: u64,
    },
}
