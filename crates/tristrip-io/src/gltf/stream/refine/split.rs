//! Splits the meshes of a stream into parts.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;

use rustc_hash::FxHashMap;
use tristrip::stream::PART;
use tristrip::{AttributeData, Faces, Mesh};

use crate::error::Error;

/// The source of a primitive's triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct StreamedPart {
    /// The index of the mesh in the stream.
    pub stream: u32,
    /// The part of the mesh, if the mesh has the attribute [`PART`](tristrip::stream::PART).
    /// `None`: the whole mesh.
    pub part: Option<u32>,
}

/// Meshes by stream index.
pub type StreamMeshes = BTreeMap<u32, Mesh>;

/// Returns the part for each source, or `None` if the part has no triangles or its mesh is missing.
pub(super) fn parts_of(
    meshes: &StreamMeshes,
    sources: impl Iterator<Item = StreamedPart>,
) -> Result<Vec<Option<Arc<Mesh>>>, Error> {
    let mut split: BTreeMap<u32, FxHashMap<Option<u32>, Arc<Mesh>>> = BTreeMap::new();
    let mut parts = Vec::new();
    for source in sources {
        let Some(mesh) = meshes.get(&source.stream) else {
            parts.push(None);
            continue;
        };
        let of_stream = match split.entry(source.stream) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => entry.insert(split_mesh(mesh)?),
        };
        if source.part.is_some() && of_stream.contains_key(&None) {
            let at = format!("mesh {} of the stream", source.stream);
            return Err(Error::format(
                at,
                "one part",
                format!("an attribute `{PART}`, because a primitive selects a part"),
            ));
        }
        parts.push(of_stream.get(&source.part).cloned());
    }
    Ok(parts)
}

/// Returns the parts of a mesh by index, each with its own vertices. A mesh without parts is
/// returned whole.
fn split_mesh(mesh: &Mesh) -> Result<FxHashMap<Option<u32>, Arc<Mesh>>, Error> {
    let corners = mesh.faces().fans();
    let number =
        mesh.attributes().iter().find(|attribute| attribute.name == PART && attribute.components == 1);
    let number_of = |v: u32| match number.map(|attribute| &attribute.data) {
        Some(AttributeData::U8(data)) => Some(data[v as usize].into()),
        Some(AttributeData::U16(data)) => Some(data[v as usize].into()),
        Some(AttributeData::U32(data)) => Some(data[v as usize]),
        _ => None,
    };
    let mut lists: FxHashMap<Option<u32>, Vec<u32>> = FxHashMap::default();
    for triangle in corners.chunks_exact(3) {
        lists.entry(number_of(triangle[0])).or_default().extend(triangle);
    }
    // The new index of each vertex in the current part, and the vertices of the part.
    let mut own = vec![u32::MAX; mesh.vertex_count()];
    let mut parts = FxHashMap::default();
    for (part, mut list) in lists {
        let mut vertices = Vec::new();
        for v in &mut list {
            let slot = &mut own[*v as usize];
            if *slot == u32::MAX {
                *slot = vertices.len() as u32;
                vertices.push(*v);
            }
            *v = *slot;
        }
        let positions: Vec<[f32; 3]> = vertices.iter().map(|&v| mesh.positions()[v as usize]).collect();
        let mut whole = Mesh::new(positions, Faces::from_triangles(list)?)?;
        for attribute in mesh.attributes().iter().filter(|attribute| attribute.name != PART) {
            whole = whole.with_attribute(attribute.of_vertices(&vertices)?)?;
        }
        vertices.iter().for_each(|&v| own[v as usize] = u32::MAX);
        parts.insert(part, Arc::new(whole));
    }
    Ok(parts)
}
