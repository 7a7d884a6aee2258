//! Numbers and names of the glTF specification and of its extensions that several modules use.

/// The primitive mode of a triangle list.
pub(super) const TRIANGLES: u64 = 4;
pub(super) const TRIANGLE_STRIP: u64 = 5;
pub(super) const TRIANGLE_FAN: u64 = 6;

/// The `target` of a buffer view with vertex attributes.
pub(super) const ARRAY_BUFFER: u32 = 34962;
/// The `target` of a buffer view with indices.
pub(super) const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// The extension that allows integer positions.
pub(super) const QUANTIZATION: &str = "KHR_mesh_quantization";

/// The extensions that compress the bytes of a buffer view; the second is the successor of the first, of the same shape.
pub(super) const COMPRESSIONS: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// The extension that allows the restart index.
pub(super) const RESTART_EXTENSION: &str = "KHR_mesh_primitive_restart";

/// The extension that names the nodes, or materials, of lower levels of detail, and nothing else.
pub(super) const LEVELS_OF_DETAIL: &str = "MSFT_lod";

/// The extras of a node with levels of detail: the screen coverages down to which its levels are drawn.
pub(super) const SCREEN_COVERAGE: &str = "MSFT_screencoverage";

/// Extensions that describe the order of indices, and become invalid when the indices change.
pub(super) const ORDER_EXTENSIONS: [&str; 3] =
    ["EXT_mesh_manifold", "EXT_mesh_primitive_edge_visibility", "EXT_mesh_primitive_restart"];
