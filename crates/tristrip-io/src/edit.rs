//! Edits the vertices of a whole model: replaces its triangles, reorders or adds vertices, and
//! builds levels of detail over one vertex array.
//!
//! Parts that share vertices in a file change together; `gltf::edit` updates the scene.

pub(crate) mod levels;
pub(crate) mod new_values;
pub(crate) mod new_vertices;
pub(crate) mod redraw;
mod renumber;
pub(crate) mod reorder;
pub(crate) mod vertex_group;
