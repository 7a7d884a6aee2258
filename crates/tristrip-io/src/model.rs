//! What a file holds: parts with a mesh each, and for glTF the scene around them.

use tristrip::{Mesh, Strips};

/// A file's geometry, in the order of the file.
#[derive(Debug, Default)]
pub struct Model {
    /// The meshes, each of which is stripified and drawn by itself.
    pub parts: Vec<Part>,
    /// What was dropped or changed while reading, in words, with counts: nothing is lost silently.
    pub notes: Vec<String>,
    /// The document around the parts, for glTF and GLB.
    pub scene: Option<crate::gltf::Scene>,
}

/// One mesh: the faces of one material (OBJ), one primitive (glTF), or the whole file (PLY, OFF, STL).
#[derive(Debug, Default)]
pub struct Part {
    /// Object, group or mesh name, where the file has one.
    pub name: Option<String>,
    /// Material name, where the file has one.
    pub material: Option<String>,
    /// The geometry.
    pub mesh: Mesh,
    /// Whether the file drew the part as strips or fans, of which the faces are the triangles in order.
    pub stripped: bool,
}

/// What to write for a part.
#[derive(Debug, Clone, Copy)]
pub enum Drawing<'a> {
    /// The part's own faces, polygons kept where the format has polygons.
    Faces,
    /// These triangle strips, over the part's vertices.
    Strips(&'a Strips),
}
