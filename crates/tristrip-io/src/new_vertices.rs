//! Parts with new vertices: each is a copy of an old one with another normal and tangent.
//!
//! # Algorithm
//! In a scene that is written as a GLB, the new vertices follow the old ones of their group: the parts of a group have accessors in
//! common. `gltf/extend.rs` writes all their values, also those that are not decoded. Elsewhere the new vertices replace those of the part.
//! Vertices that are unused afterwards are dropped by [`with_triangles`](crate::with_triangles).
//!
//! # Complexity
//! Linear in the values of the vertices, old and new.

use rustc_hash::FxHashMap;
use tristrip::{Attribute, AttributeData, Faces, Mesh};

use crate::error::Error;
use crate::format::Format;
use crate::gltf;
use crate::model::Model;

/// New vertices of a part.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct NewVertices {
    /// The old vertex that each is a copy of.
    pub sources: Vec<u32>,
    /// The unit normal of each.
    pub normals: Vec<[f32; 3]>,
    /// The tangent of each, as glTF has it: a unit vector and the sign of the bitangent. Empty to copy those of the old vertices.
    pub tangents: Vec<[f32; 4]>,
}

impl NewVertices {
    /// Returns a mesh of old vertices and then the new ones, without faces.
    ///
    /// # Errors
    /// A source is not a vertex of the mesh, or there are too many vertices.
    ///
    /// ```
    /// use tristrip_io::{Format, NewVertices, read};
    /// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 1 0 0\nf 1//1 2//1 3//1\n", Format::Obj)?;
    /// let new = NewVertices { sources: vec![2], normals: vec![[0.0, 0.0, 1.0]], tangents: vec![] };
    /// let mesh = new.behind(&model.parts[0].mesh)?;
    /// assert_eq!((mesh.positions()[3], mesh.attributes()[0].float(11)), ([0.0, 1.0, 0.0], Some(1.0)));
    /// # Ok::<(), tristrip_io::Error>(())
    /// ```
    pub fn behind(&self, mesh: &Mesh) -> Result<Mesh, Error> {
        let first = mesh.vertex_count() as u32;
        let sources: Vec<u32> = (0..first).chain(self.sources.iter().copied()).collect();
        with_values(&mesh.select_vertices(&sources)?, &[(first, self)])
    }
}

/// A model with new vertices.
#[derive(Debug)]
pub struct Extended {
    /// The parts in their order, over more vertices and without faces; a part without new vertices has its faces.
    pub model: Model,
    /// The number of the first new vertex of each part; `None` for a part without new vertices.
    pub first: Vec<Option<u32>>,
}

/// Returns for each part why it cannot have new vertices in a file of a format; `None` if it can.
///
/// # Errors
/// The model's scene has another number of parts.
///
/// ```
/// use tristrip_io::{Format, fixed_vertices, read};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n", Format::Obj)?;
/// assert_eq!(fixed_vertices(&model, Format::Ply)?, [None]);
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn fixed_vertices(model: &Model, format: Format) -> Result<Vec<Option<String>>, Error> {
    let mut fixed = match model.scene.as_ref() {
        Some(scene) => gltf::extend::fixed_parts(scene, model, format == Format::Glb)?,
        None => vec![None; model.parts.len()],
    };
    for (why, part) in fixed.iter_mut().zip(&model.parts) {
        let named = |name: &str| part.mesh.attributes().iter().find(|a| a.name == name);
        let is_wrong = |attribute: &Attribute| !can_hold_directions(attribute);
        if why.is_none() && ["NORMAL", "TANGENT"].into_iter().filter_map(named).any(is_wrong) {
            *why = Some("normals or tangents are of a type that cannot hold directions".into());
        }
    }
    Ok(fixed)
}

/// Adds vertices to parts of a model.
///
/// # Errors
/// There is not one entry for each part; a source is not a vertex of the part; there is not one normal for each source, or another number
/// of tangents than none or as many; [`fixed_vertices`] has a reason why the part cannot have them.
///
/// ```
/// use tristrip_io::{Format, NewVertices, read, with_new_vertices, with_triangles};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 1 0 0\nf 1//1 2//1 3//1\n", Format::Obj)?;
/// let normals = vec![[0.0, 0.0, 1.0]; 3];
/// let new = NewVertices { sources: vec![0, 1, 2], normals, ..NewVertices::default() };
/// let extended = with_new_vertices(&model, &[Some(new)], Format::Ply)?;
/// let first = extended.first[0].unwrap_or(0);
/// let result = with_triangles(&extended.model, vec![vec![first, first + 1, first + 2]], Format::Ply)?;
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
        let groups = gltf::renumber::groups(old, meshes.len())?;
        let has_new = |group: &&gltf::renumber::SceneGroup| group.parts.iter().any(|&p| added[p].is_some());
        let mut extensions = Vec::new();
        for group in groups.iter().filter(has_new) {
            let sources = extend_group(&mut meshes, &group.parts, added, &mut first)?;
            extensions.push(gltf::extend::Extension { group, sources });
        }
        scene = Some(gltf::extend::apply(old, &extensions, &meshes, &first)?);
    } else {
        for (part, new) in added.iter().enumerate() {
            if let Some(new) = new {
                meshes[part] = with_values(&meshes[part].select_vertices(&new.sources)?, &[(0, new)])?;
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
            "lists of new vertices: found {found}, expected {expected} (one for each part)"
        ));
    }
    for (part, new) in added.iter().enumerate().filter_map(|(part, new)| Some((part, new.as_ref()?))) {
        let (sources, tangents) = (new.sources.len(), new.tangents.len());
        if new.normals.len() != sources || tangents > 0 && tangents != sources {
            return unsupported(format!(
                "part {part}: found {} normals and {tangents} tangents, expected one for each of {sources} new vertices",
                new.normals.len()
            ));
        }
    }
    Ok(())
}

/// Appends the new vertices of a group's parts to the vertices that they have in common, and returns the old vertex that each of all
/// vertices is a copy of. Meshes that share attributes share them again.
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
    for sharing in by_attributes.into_values() {
        let new: Vec<(u32, &NewVertices)> =
            sharing.iter().filter_map(|&part| Some((first[part]?, added[part].as_ref()?))).collect();
        let extended = with_values(&meshes[sharing[0]].select_vertices(&sources)?, &new)?;
        for part in sharing {
            meshes[part] = extended.with_faces(meshes[part].faces().clone())?;
        }
    }
    Ok(sources)
}

/// Replaces the normals and tangents of the vertices from some on.
fn with_values(mesh: &Mesh, new: &[(u32, &NewVertices)]) -> Result<Mesh, Error> {
    let mut replaced = Mesh::new(mesh.shared_positions(), Faces::default())?;
    for attribute in mesh.attributes() {
        let mut attribute = attribute.clone();
        for &(first, new) in new {
            let at = first as usize * usize::from(attribute.components);
            match (attribute.name.as_str(), attribute.components) {
                ("NORMAL", 3) => set(&mut attribute, at, new.normals.as_flattened()),
                ("TANGENT", 4) => set(&mut attribute, at, new.tangents.as_flattened()),
                _ => (),
            }
        }
        replaced = replaced.with_attribute(attribute)?;
    }
    Ok(replaced)
}

/// Returns whether an attribute has a type for numbers from −1 to 1.
fn can_hold_directions(attribute: &Attribute) -> bool {
    match attribute.data {
        AttributeData::F32(_) | AttributeData::F64(_) => true,
        AttributeData::I8(_) | AttributeData::I16(_) | AttributeData::I32(_) => attribute.normalized,
        AttributeData::U8(_) | AttributeData::U16(_) | AttributeData::U32(_) => false,
    }
}

/// Sets values from one on, each from −1 to 1.
fn set(attribute: &mut Attribute, first: usize, values: &[f32]) {
    fn replace<T>(data: &mut [T], values: &[f32], value: impl Fn(f32) -> T) {
        data.iter_mut().zip(values).for_each(|(slot, &x)| *slot = value(x));
    }
    let most = |highest: i32| f64::from(highest);
    let fraction = |x: f32, highest: i32| (f64::from(x) * most(highest)).round();
    match &mut attribute.data {
        AttributeData::F32(data) => replace(&mut data[first..], values, |x| x),
        AttributeData::F64(data) => replace(&mut data[first..], values, f64::from),
        AttributeData::I8(data) => replace(&mut data[first..], values, |x| fraction(x, i8::MAX.into()) as i8),
        AttributeData::I16(data) => {
            replace(&mut data[first..], values, |x| fraction(x, i16::MAX.into()) as i16);
        }
        AttributeData::I32(data) => replace(&mut data[first..], values, |x| fraction(x, i32::MAX) as i32),
        AttributeData::U8(_) | AttributeData::U16(_) | AttributeData::U32(_) => (),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Part;

    #[test]
    fn directions_are_stored_in_the_type_that_there_is() {
        let of = |data| Attribute { name: "NORMAL".into(), components: 3, normalized: true, data };
        let values = [-1.0, 0.0, 0.5];
        for (data, expected) in [
            (AttributeData::I8(vec![7; 6]), AttributeData::I8(vec![7, 7, 7, -127, 0, 64])),
            (AttributeData::I16(vec![7; 6]), AttributeData::I16(vec![7, 7, 7, -32767, 0, 16384])),
            (AttributeData::F64(vec![7.0; 6]), AttributeData::F64(vec![7.0, 7.0, 7.0, -1.0, 0.0, 0.5])),
        ] {
            let mut attribute = of(data);
            assert!(can_hold_directions(&attribute));
            set(&mut attribute, 3, &values);
            assert_eq!(attribute.data, expected);
        }
        assert!(!can_hold_directions(&of(AttributeData::U8(vec![0; 3]))));
    }

    #[test]
    fn invalid_lists_are_refused() {
        let mesh = Mesh::new(vec![[0.0; 3]; 3], Faces::default()).unwrap();
        let model = Model { parts: vec![Part { mesh, ..Part::default() }], ..Model::default() };
        let new = |sources: Vec<u32>, normals| NewVertices { sources, normals, tangents: vec![] };
        let refused = |added: &[Option<NewVertices>]| with_new_vertices(&model, added, Format::Ply).is_err();
        assert!(refused(&[]));
        assert!(refused(&[Some(new(vec![3], vec![[0.0; 3]]))]));
        assert!(refused(&[Some(new(vec![0, 1], vec![[0.0; 3]]))]));
        assert!(!refused(&[Some(new(vec![0, 0], vec![[0.0; 3]; 2]))]) && !refused(&[None]));
    }
}
