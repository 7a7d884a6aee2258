//! Common parts of the OBJ and PLY writers: one vertex list for several parts, attributes, and
//! names.
//!
//! Vertices that parts share are written once, such as the vertices of glTF primitives with common
//! accessors.

use rustc_hash::FxHashMap;
use tristrip::MAX_COUNT;
use tristrip::{Attribute, Mesh};

use crate::error::Error;
use crate::gltf::document::scene::Scene;
use crate::model::{Drawing, Model, Part};

/// The vertices of all parts, in consecutive blocks.
#[derive(Debug)]
pub(crate) struct VertexBlocks {
    /// The parts whose vertices are written, in order.
    pub(crate) parts: Vec<usize>,
    /// For each part: the part that owns its vertices, which is the part itself or an earlier one
    /// with the same vertices.
    pub(crate) owners: Vec<usize>,
    /// For each part: the number of vertices before its own.
    pub(crate) bases: Vec<u32>,
    /// The number of vertices in all blocks.
    pub(crate) vertex_count: usize,
}

/// Assigns a vertex block to each part of a model.
///
/// # Errors
/// The total number of vertices exceeds 32-bit ids.
pub(crate) fn blocks(model: &Model) -> Result<VertexBlocks, Error> {
    let mut out = VertexBlocks { parts: Vec::new(), owners: Vec::new(), bases: Vec::new(), vertex_count: 0 };
    let mut seen: FxHashMap<*const [f32; 3], usize> = FxHashMap::default();
    for (i, part) in model.parts.iter().enumerate() {
        let first = *seen.entry(part.mesh.positions().as_ptr()).or_insert(i);
        if first < i && same_vertices(&model.parts[first].mesh, &part.mesh) {
            out.owners.push(first);
            out.bases.push(out.bases[first]);
            continue;
        }
        out.parts.push(i);
        out.owners.push(i);
        out.bases.push(out.vertex_count as u32);
        out.vertex_count += part.mesh.vertex_count();
        if out.vertex_count > MAX_COUNT {
            let (at, found) = ("vertices of all parts".to_owned(), out.vertex_count as u64);
            return Err(Error::LimitExceeded { at, found, limit: MAX_COUNT as u64 });
        }
    }
    Ok(out)
}

fn same_vertices(a: &Mesh, b: &Mesh) -> bool {
    a.shares_vertices(b) || (a.vertex_count() == b.vertex_count() && a.attributes() == b.attributes())
}

/// Iterates over the parts that are drawn as faces, not as strips.
pub(crate) fn drawn_by_faces<'a>(
    model: &'a Model,
    drawings: &[Drawing<'_>],
) -> impl Iterator<Item = &'a Part> {
    let drawn = model.parts.iter().zip(drawings);
    drawn.filter(|(_, drawing)| matches!(drawing, Drawing::Faces)).map(|(part, _)| part)
}

/// Lists the content of the scene, for formats that store only parts.
pub(crate) fn scene_losses(model: &Model) -> impl Iterator<Item = String> {
    let scene = model.scene.iter().flat_map(Scene::beyond_parts);
    // The material library of an OBJ contains the textures.
    scene
        .filter(|what| model.materials.is_none() || !what.starts_with("textures"))
        .map(|what| format!("not written: {what}"))
}

/// Returns the attribute named `name` if it has at least `components` components.
pub(crate) fn attribute<'a>(mesh: &'a Mesh, name: &str, components: u8) -> Option<&'a Attribute> {
    mesh.attributes().iter().find(|a| a.name == name && a.components >= components)
}

/// Returns the material name under which a part is written. With several parts, each gets a name,
/// which keeps them separate.
pub(crate) fn material_name(part: &Part, index: usize, part_count: usize) -> Option<String> {
    let material = part.material.as_deref().map(clean).filter(|name| !name.is_empty());
    material.or_else(|| (part_count > 1).then(|| format!("part_{index}")))
}

/// Returns a name that is safe in all formats: one line, without control characters.
pub(crate) fn clean(name: &str) -> String {
    let name: String = name.trim().chars().map(|c| if c.is_control() { '_' } else { c }).collect();
    match name.strip_suffix('\\') {
        Some(start) => format!("{start}_"),
        None => name,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tristrip::Faces;

    fn part(mesh: &Mesh) -> Part {
        Part { mesh: mesh.clone(), ..Part::default() }
    }

    #[test]
    fn shared_vertices_make_one_block() {
        let shared = Mesh::new(vec![[0.0; 3]; 4], Faces::default()).unwrap();
        let other = Mesh::new(vec![[0.0; 3]; 4], Faces::default()).unwrap();
        let parts = vec![part(&shared), part(&other), part(&shared)];
        let blocks = blocks(&Model { parts, ..Model::default() }).unwrap();
        assert_eq!((blocks.parts, blocks.owners, blocks.bases), (vec![0, 1], vec![0, 1, 0], vec![0, 4, 0]));
    }

    #[test]
    fn names_are_cleaned_to_one_line() {
        assert_eq!(clean(" a\nf 1 2 3 \\"), "a_f 1 2 3 _");
    }
}
