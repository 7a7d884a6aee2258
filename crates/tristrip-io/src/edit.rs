//! Changes the vertices of a whole model: new triangles, another order, new vertices, and levels of
//! detail with a common vertex array.
//!
//! Parts that share vertices in a file change together; `gltf::edit` updates the scene.

pub(crate) mod levels;
pub(crate) mod new_values;
pub(crate) mod new_vertices;
pub(crate) mod redraw;
mod renumber;
pub(crate) mod reorder;
pub(crate) mod vertex_group;
