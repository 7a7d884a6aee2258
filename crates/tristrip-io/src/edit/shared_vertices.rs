//! Parts that share vertices: which parts a file stores over the same vertices, and renumbering that keeps arrays shared.

use std::sync::Arc;

use rustc_hash::FxHashMap;
use tristrip::{Faces, Mesh, VertexOrder};

use crate::error::Error;
use crate::format::Format;
use crate::join;
use crate::model::{Model, Part};

/// Returns the groups of parts whose vertices are written once, by the rules of the writers of a format without a scene.
pub(crate) fn parts_by_vertices(model: &Model, format: Format) -> Result<Vec<Vec<usize>>, Error> {
    let first: Vec<usize> = if format == Format::Glb {
        let mut first = FxHashMap::default();
        let first_part =
            |(i, part): (usize, &Part)| *first.entry(Arc::as_ptr(&part.mesh.shared_positions())).or_insert(i);
        model.parts.iter().enumerate().map(first_part).collect()
    } else {
        join::blocks(model)?.owners
    };
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let mut by_first: FxHashMap<usize, usize> = FxHashMap::default();
    for (part, first) in first.into_iter().enumerate() {
        let group = *by_first.entry(first).or_insert_with(|| {
            groups.push(Vec::new());
            groups.len() - 1
        });
        groups[group].push(part);
    }
    Ok(groups)
}

/// Renumbers the vertices of a group's meshes, and keeps the first `kept` of the new order. Meshes that shared positions or
/// attributes share them again.
pub(crate) fn renumber(
    meshes: &mut [Mesh],
    group: &[usize],
    order: &VertexOrder,
    kept: usize,
) -> Result<(), Error> {
    let mut positions = FxHashMap::default();
    let mut vertices: FxHashMap<_, Mesh> = FxHashMap::default();
    for &part in group {
        let mesh = meshes[part].clone();
        let faces = order.faces(mesh.faces())?;
        let address = mesh.positions().as_ptr();
        let key = (address, mesh.attributes().as_ptr());
        if let Some(known) = vertices.get(&key) {
            meshes[part] = known.with_faces(faces)?;
            continue;
        }
        let renumbered = if let Some(known) = positions.get(&address) {
            Arc::clone(known)
        } else {
            let mut values = order.values(mesh.positions(), 1)?;
            values.truncate(kept);
            Arc::new(values)
        };
        positions.insert(address, Arc::clone(&renumbered));
        let mut bare = Mesh::new(renumbered, Faces::default())?;
        for attribute in mesh.attributes() {
            bare = bare.with_attribute(attribute.of_vertices(&order.new_to_old()[..kept])?)?;
        }
        meshes[part] = bare.with_faces(faces)?;
        vertices.insert(key, bare);
    }
    Ok(())
}
