//! Changes to the vertices of a whole model: other triangles, another order, new vertices, and levels of detail over one vertex array.
//!
//! Parts whose vertices a file stores once change together; `gltf::edit` changes the scene around them.

pub(crate) mod levels;
pub(crate) mod new_values;
pub(crate) mod new_vertices;
pub(crate) mod redraw;
mod renumber;
pub(crate) mod reorder;
pub(crate) mod vertex_group;
