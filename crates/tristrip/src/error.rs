//! The errors of the library, grouped by who can fix them.

/// Why a computation failed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The mesh is invalid.
    #[error("{0}")]
    Mesh(#[from] MeshProblem),
    /// An option has an invalid value.
    #[error("parameter `{name}`: found {found}, expected {expected}")]
    Parameter {
        /// The name of the option, as on the command line and in the documentation.
        name: &'static str,
        /// The value found.
        found: String,
        /// The accepted values.
        expected: &'static str,
    },
    /// The bytes do not conform to their format.
    #[error("byte {offset}: found {found}, expected {expected}")]
    Format {
        /// The byte offset, counted from 0.
        offset: u64,
        /// What was found at the offset.
        found: String,
        /// What the format requires.
        expected: String,
    },
    /// The number of items exceeds a limit: of 32-bit indices, of an index type, of a buffer, or of
    /// memory.
    #[error("{what}: found {found}, the limit is {limit}")]
    LimitExceeded {
        /// The kind of item that is limited.
        what: &'static str,
        /// The number of items that the input has or needs.
        found: u64,
        /// The maximum number.
        limit: u64,
    },
}

/// A defect of a mesh that no method can process.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshProblem {
    /// A corner refers to a vertex that does not exist.
    #[error("face {face}, corner {corner}: found vertex index {found}, expected less than {vertex_count}")]
    VertexIndex {
        /// Index of the face, counted from 0.
        face: u32,
        /// Corner of the face, counted from 0.
        corner: u32,
        /// The vertex index found.
        found: u32,
        /// Number of vertices of the mesh.
        vertex_count: u32,
    },
    /// A strip refers to a vertex that does not exist.
    #[error(
        "strip {strip}, vertex {position}: found vertex index {found}, expected less than {vertex_count}"
    )]
    StripVertex {
        /// Index of the strip, counted from 0.
        strip: u32,
        /// Position in the strip, counted from 0.
        position: u32,
        /// The vertex index found.
        found: u32,
        /// Number of vertices of the mesh.
        vertex_count: u32,
    },
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex}: found coordinate {found}, expected a finite number")]
    NotFinite {
        /// Index of the vertex, counted from 0.
        vertex: u32,
        /// The coordinate found.
        found: f32,
    },
    /// The number of corners does not match the face sizes.
    #[error("faces: number of corners: found {found}, expected {expected}")]
    CornerCount {
        /// Number of corners found.
        found: u64,
        /// The number of corners that the faces require.
        expected: String,
    },
    /// The length of a vertex attribute does not match the number of positions.
    #[error("attribute `{name}`: number of values: found {found}, expected {expected} (one per vertex)")]
    AttributeLength {
        /// Name of the attribute.
        name: String,
        /// Number of vertices that the attribute has values for.
        found: u64,
        /// Number of vertices of the mesh.
        expected: u64,
    },
}
