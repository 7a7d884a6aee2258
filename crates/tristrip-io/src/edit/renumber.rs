//! Renumbers the vertices of a model. Redrawing, reordering and levels of detail use this module.
//!
//! # Complexity
//! Linear in the vertices and their values. For a scene, see `gltf/edit/renumber.rs`.

use std::sync::Arc;

use rustc_hash::FxHashMap;
use tristrip::{Faces, Mesh};

use crate::edit::vertex_group::Renumbering;
use crate::error::Error;
use crate::format::Format;
use crate::gltf::document::scene::Scene;
use crate::gltf::edit::renumber::{self as scene_vertices, SceneGroup};
use crate::join;
use crate::model::{Model, Part};

/// Parts that share a vertex order, and that order.
pub(crate) type RenumberedGroup = (Vec<usize>, Renumbering);

/// Renumbers the vertices of a model and removes some of them. All operations that keep or remove
/// vertices use this function.
///
/// 1. Parts that share vertices in the file form a group: in PLY and OBJ, parts with common
///    positions and attributes; in a GLB, parts with the same positions; in a scene written as a
///    GLB, parts that share any accessor.
/// 2. `number` returns the renumbering of each group. It receives the parts and, for such a scene,
///    the group of the scene.
/// 3. The scene permutes and shortens all other vertex values, or finds more groups that must keep
///    them.
/// 4. The meshes are renumbered. Meshes that shared arrays still share them.
///
/// `meshes` are the meshes of the parts with their final faces. If the triangles are new, the scene
/// replaces all indices when it is written.
pub(crate) fn renumbered(
    model: &Model,
    mut meshes: Vec<Mesh>,
    (format, has_new_triangles): (Format, bool),
    mut number: impl FnMut(&[Mesh], &[usize], Option<&SceneGroup>) -> Result<Renumbering, Error>,
) -> Result<(Model, Vec<RenumberedGroup>), Error> {
    let scene = model.scene.as_ref().filter(|_| format == Format::Glb);
    let found = scene.map(|scene| scene_vertices::groups(scene, meshes.len())).transpose()?;
    let groups: Vec<Vec<usize>> = match &found {
        Some(found) => found.iter().map(|group| group.parts.clone()).collect(),
        None => parts_by_vertices(model, format)?,
    };
    let each = groups.iter().enumerate();
    let each = each.map(|(i, parts)| number(&meshes, parts, found.as_ref().map(|found| &found[i])));
    let mut renumberings = each.collect::<Result<Vec<Renumbering>, Error>>()?;
    let mut scene = match scene.zip(found) {
        Some((scene, found)) => Some(scene_vertices::apply(scene, &found, &mut renumberings)?),
        None => model.scene.clone(),
    };
    if has_new_triangles && format == Format::Glb {
        scene = scene.map(Scene::redrawn).transpose()?;
    }
    for (parts, renumbering) in groups.iter().zip(&renumberings).filter(|(_, one)| one.changes()) {
        renumber_meshes(&mut meshes, parts, renumbering)?;
    }
    let parts = model.parts.iter().zip(meshes).map(|(part, mesh)| part.with_mesh(mesh)).collect();
    let model = Model { parts, notes: model.notes.clone(), scene, materials: model.materials.clone() };
    Ok((model, groups.into_iter().zip(renumberings).collect()))
}

/// Returns the groups of parts whose vertices are written once in a format without a scene.
fn parts_by_vertices(model: &Model, format: Format) -> Result<Vec<Vec<usize>>, Error> {
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

/// Renumbers the vertices of a group's meshes and removes the rest. Meshes that shared positions or
/// attributes still share them.
fn renumber_meshes(meshes: &mut [Mesh], group: &[usize], renumbering: &Renumbering) -> Result<(), Error> {
    let Renumbering { order, left, .. } = renumbering;
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
            values.truncate(*left);
            Arc::new(values)
        };
        positions.insert(address, Arc::clone(&renumbered));
        let mut bare = Mesh::new(renumbered, Faces::default())?;
        for attribute in mesh.attributes() {
            bare = bare.with_attribute(attribute.of_vertices(renumbering.left_to_old())?)?;
        }
        meshes[part] = bare.with_faces(faces)?;
        vertices.insert(key, bare);
    }
    Ok(())
}
