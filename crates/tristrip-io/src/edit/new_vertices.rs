//! Adds vertices to parts. Each new vertex is a copy of an old vertex with a new normal and
//! tangent, a new position, or both.
//!
//! # Algorithm
//! In a scene written as a GLB, the new vertices follow the old ones of their group, because the
//! parts of a group share accessors. `gltf/edit/extend.rs` writes all their values, including those
//! that were not decoded. In other formats, the new vertices replace the old vertices of the part.
//! [`with_triangles`](crate::with_triangles) can then remove unused vertices.
//!
//! # Complexity
//! Linear in the values of the old and the new vertices.

use rustc_hash::FxHashMap;
use tristrip::text::counted;
use tristrip::{Attribute, Mesh};

use crate::edit::new_values::{NewValues, NewVertices, can_hold_directions, with_values};
use crate::error::Error;
use crate::format::Format;
use crate::gltf;
use crate::model::Model;

/// A model with new vertices.
#[derive(Debug)]
pub struct Extended {
    /// The parts, in their original order. Parts with new vertices have no faces, except in a scene
    /// written as a GLB.
    pub model: Model,
    /// The index of the first new vertex of each part; `None` for a part without new vertices.
    pub first: Vec<Option<u32>>,
}

/// Returns, for each part, the reason why its vertices cannot get such new values in a file of
/// `format`, or `None` if they can.
///
/// # Errors
/// The number of parts differs from the number of parts in the scene.
///
/// ```
/// use tristrip_io::{Format, NewValues, fixed_vertices, read};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n", Format::Obj)?;
/// assert_eq!(fixed_vertices(&model, NewValues::Positions, Format::Ply)?, [None]);
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn fixed_vertices(
    model: &Model,
    values: NewValues,
    format: Format,
) -> Result<Vec<Option<String>>, Error> {
    let mut fixed = match model.scene.as_ref() {
        Some(scene) => gltf::edit::extend::fixed_parts(scene, model, values, format == Format::Glb)?,
        None => vec![None; model.parts.len()],
    };
    if values == NewValues::Positions {
        return Ok(fixed);
    }
    for (why, part) in fixed.iter_mut().zip(&model.parts) {
        let named = |name: &str| part.mesh.attributes().iter().find(|a| a.name == name);
        let is_wrong = |attribute: &Attribute| !can_hold_directions(attribute);
        if why.is_none() && ["NORMAL", "TANGENT"].into_iter().filter_map(named).any(is_wrong) {
            *why = Some("the type of the normals or tangents cannot represent directions".into());
        }
    }
    Ok(fixed)
}

/// Adds vertices to parts of a model.
///
/// # Errors
/// - The length of `added` differs from the number of parts.
/// - A source is not a vertex of the part.
/// - The number of normals, tangents or positions is neither 0 nor the number of sources.
/// - [`fixed_vertices`] reports that a part cannot have these values.
///
/// ```
/// use tristrip_io::{Format, NewVertices, read, with_new_vertices, with_triangles};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 1 0 0\nf 1//1 2//1 3//1\n", Format::Obj)?;
/// let normals = vec![[0.0, 0.0, 1.0]; 3];
/// let new = NewVertices { sources: vec![0, 1, 2], normals, ..NewVertices::default() };
/// let extended = with_new_vertices(&model, &[Some(new)], Format::Ply)?;
/// let first = extended.first[0].unwrap_or(0);
/// let triangles = vec![vec![first, first + 1, first + 2]];
/// let result = with_triangles(&extended.model, triangles, Format::Ply)?;
/// let mesh = &result.model.parts[0].mesh;
/// assert_eq!((mesh.vertex_count(), mesh.attributes()[0].float(2)), (3, Some(1.0)));
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn with_new_vertices(
    model: &Model,
    added: &[Option<NewVertices>],
    format: Format,
) -> Result<Extended, Error> {
    check(model, added)?;
    let mut meshes: Vec<Mesh> = model.parts.iter().map(|part| part.mesh.clone()).collect();
    let mut first = vec![None; meshes.len()];
    let mut scene = model.scene.clone();
    if let Some(old) = model.scene.as_ref().filter(|_| format == Format::Glb) {
        let groups = gltf::edit::renumber::groups(old, meshes.len())?;
        let has_new =
            |group: &&gltf::edit::renumber::SceneGroup| group.parts.iter().any(|&p| added[p].is_some());
        let mut extensions = Vec::new();
        for group in groups.iter().filter(has_new) {
            let sources = extend_group(&mut meshes, &group.parts, added, &mut first)?;
            extensions.push(gltf::edit::extend::Extension { group, sources });
        }
        scene = Some(gltf::edit::extend::apply(old, &extensions, &meshes, added, &first)?);
    } else {
        for (part, new) in added.iter().enumerate() {
            if let Some(new) = new {
                let selected = meshes[part].select_vertices(&new.sources)?;
                meshes[part] = with_values(&selected, &[(0, new)], &[(0, new)])?;
                first[part] = Some(0);
            }
        }
    }
    let parts = model.parts.iter().zip(meshes).map(|(part, mesh)| part.with_mesh(mesh)).collect();
    Ok(Extended {
        model: Model { parts, notes: model.notes.clone(), scene, materials: model.materials.clone() },
        first,
    })
}

fn check(model: &Model, added: &[Option<NewVertices>]) -> Result<(), Error> {
    let unsupported = |message: String| Err(Error::Unsupported(message));
    if added.len() != model.parts.len() {
        let (found, expected) = (added.len(), model.parts.len());
        return unsupported(format!(
            "lists of new vertices: found {found}, expected {expected} (one per part)"
        ));
    }
    for (part, new) in added.iter().enumerate().filter_map(|(part, new)| Some((part, new.as_ref()?))) {
        let sources = new.sources.len();
        let lists = [
            ("normal", new.normals.len()),
            ("tangent", new.tangents.len()),
            ("position", new.positions.len()),
        ];
        if let Some((name, found)) = lists.into_iter().find(|&(_, found)| found != 0 && found != sources) {
            return unsupported(format!(
                "part {part}: found {}, expected one for each of {}, or none",
                counted(found, name),
                counted(sources, "new vertex")
            ));
        }
    }
    Ok(())
}

/// Appends the new vertices of a group's parts to its common vertices, and returns the source of
/// each vertex. Meshes that share attributes still share them.
fn extend_group(
    meshes: &mut [Mesh],
    parts: &[usize],
    added: &[Option<NewVertices>],
    first: &mut [Option<u32>],
) -> Result<Vec<u32>, Error> {
    let vertex_count = parts.iter().map(|&part| meshes[part].vertex_count()).max().unwrap_or(0);
    let mut sources: Vec<u32> = (0..vertex_count as u32).collect();
    let mut by_attributes: FxHashMap<_, Vec<usize>> = FxHashMap::default();
    for &part in parts {
        let key = (meshes[part].positions().as_ptr(), meshes[part].attributes().as_ptr());
        by_attributes.entry(key).or_default().push(part);
        if let Some(new) = &added[part] {
            first[part] = Some(sources.len() as u32);
            sources.extend(&new.sources);
        }
    }
    let old: Vec<*const [f32; 3]> = parts.iter().map(|&part| meshes[part].positions().as_ptr()).collect();
    for ((positions, _), sharing) in by_attributes {
        let new = |part: &usize| Some((first[*part]?, added[*part].as_ref()?));
        let directions: Vec<(u32, &NewVertices)> = sharing.iter().filter_map(new).collect();
        let same = parts.iter().zip(&old).filter(|(_, old)| **old == positions);
        let positions: Vec<(u32, &NewVertices)> = same.filter_map(|(part, _)| new(part)).collect();
        let selected = meshes[sharing[0]].select_vertices(&sources)?;
        let extended = with_values(&selected, &directions, &positions)?;
        for part in sharing {
            meshes[part] = extended.with_faces(meshes[part].faces().clone())?;
        }
    }
    Ok(sources)
}

#[cfg(test)]
mod tests {
    use tristrip::Faces;

    use super::*;
    use crate::model::Part;

    #[test]
    fn invalid_lists_are_refused() {
        let mesh = Mesh::new(vec![[0.0; 3]; 3], Faces::default()).unwrap();
        let model = Model { parts: vec![Part { mesh, ..Part::default() }], ..Model::default() };
        let new = |sources: Vec<u32>, normals: Vec<[f32; 3]>| NewVertices {
            positions: normals.clone(),
            sources,
            normals,
            ..NewVertices::default()
        };
        let refused = |added: &[Option<NewVertices>]| with_new_vertices(&model, added, Format::Ply).is_err();
        assert!(refused(&[]));
        assert!(refused(&[Some(new(vec![3], vec![[0.0; 3]]))]));
        assert!(refused(&[Some(new(vec![0, 1], vec![[0.0; 3]]))]));
        assert!(!refused(&[Some(new(vec![0, 0], vec![[0.0; 3]; 2]))]) && !refused(&[None]));
    }
}
