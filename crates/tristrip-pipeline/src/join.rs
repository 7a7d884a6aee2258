//! Joins the parts of a model into one mesh.

use std::collections::HashMap;

use tristrip::{Attribute, Faces, MAX_COUNT, Mesh};
use tristrip_io::gltf::Scene;
use tristrip_io::{Model, Part};

use crate::error::Error;

/// A mesh of all parts.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Joined {
    /// The mesh.
    pub mesh: Mesh,
    /// The notes of the model, and notes on data that was dropped.
    pub notes: Vec<String>,
}

/// Joins the parts of a model in their own coordinates; node transforms are not applied. Vertices
/// that parts share are stored once. An attribute is kept if all parts have it with the same type.
///
/// # Errors
/// There are too many vertices or corners for 32-bit ids.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::join;
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 3 2 1\n", Format::Obj)?;
/// let joined = join(model)?;
/// assert_eq!((joined.mesh.vertex_count(), joined.mesh.faces().triangle_count()), (6, 2));
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn join(model: Model) -> Result<Joined, Error> {
    let Model { parts, mut notes, scene, .. } = model;
    notes.extend(scene.iter().flat_map(Scene::beyond_parts).map(|what| format!("not written: {what}")));
    let materials = parts.iter().filter(|part| part.material.is_some()).count();
    if materials > 0 {
        notes.push(format!("material names not written: {materials}"));
    }
    let mesh = match &parts[..] {
        [part] => part.mesh.clone(),
        parts => join_parts(parts, &mut notes)?,
    };
    Ok(Joined { mesh, notes })
}

fn join_parts(parts: &[Part], notes: &mut Vec<String>) -> Result<Mesh, Error> {
    notes.push(format!("parts joined into one: {}", parts.len()));
    let Blocks { owners, bases } = Blocks::of(parts)?;
    let owners: Vec<&Mesh> = owners.iter().map(|&part| &parts[part].mesh).collect();
    let positions: Vec<_> = owners.iter().flat_map(|mesh| mesh.positions()).copied().collect();
    let mut mesh = Mesh::new(positions, faces(parts, &bases)?)?;
    let shared = owners.first().map_or(&[][..], |first| first.attributes());
    let shared = shared.iter().filter_map(|attribute| joined(attribute, &owners));
    for attribute in shared {
        mesh = mesh.with_attribute(attribute)?;
    }
    notes.extend(dropped(&owners, &mesh));
    Ok(mesh)
}

/// The vertices of all parts, one block after the other.
struct Blocks {
    /// The part that each block of vertices comes from.
    owners: Vec<usize>,
    /// For each part, the number of vertices before its own block.
    bases: Vec<u32>,
}

impl Blocks {
    fn of(parts: &[Part]) -> Result<Self, Error> {
        let (mut owners, mut bases): (Vec<usize>, Vec<u32>) = (Vec::new(), Vec::new());
        let mut seen = HashMap::new();
        let (mut vertex_count, mut corner_count) = (0, 0);
        for (i, part) in parts.iter().enumerate() {
            let mesh = &part.mesh;
            corner_count += mesh.faces().corner_count();
            let first = *seen.entry(mesh.positions().as_ptr()).or_insert(i);
            if first < i && mesh.shares_vertices(&parts[first].mesh) {
                bases.push(bases[first]);
                continue;
            }
            owners.push(i);
            bases.push(vertex_count as u32);
            vertex_count += mesh.vertex_count();
            if vertex_count.max(corner_count) > MAX_COUNT {
                let (what, found) =
                    ("vertices or corners of joined parts", vertex_count.max(corner_count) as u64);
                return Err(tristrip::Error::LimitExceeded { what, found, limit: MAX_COUNT as u64 }.into());
            }
        }
        Ok(Self { owners, bases })
    }
}

/// Returns the faces of all parts over the vertices of all blocks.
fn faces(parts: &[Part], bases: &[u32]) -> Result<Faces, Error> {
    let corners = parts.iter().zip(bases);
    let corners =
        corners.flat_map(|(part, &base)| part.mesh.faces().corners().iter().map(move |&v| base + v));
    let corners: Vec<u32> = corners.collect();
    if parts.iter().all(|part| part.mesh.faces().as_triangles().is_some()) {
        return Ok(Faces::from_triangles(corners)?);
    }
    let mut offsets = vec![0];
    let mut end = 0;
    for face in parts.iter().flat_map(|part| part.mesh.faces().iter()) {
        end += face.len() as u32;
        offsets.push(end);
    }
    Ok(Faces::from_offsets(offsets, corners)?)
}

/// Returns the values of all blocks for an attribute of the first block; `None` unless all blocks
/// have it with the same type.
fn joined(attribute: &Attribute, owners: &[&Mesh]) -> Option<Attribute> {
    let mut all = attribute.clone();
    for mesh in owners.iter().skip(1) {
        mesh.attributes().iter().find(|other| all.append(other).is_ok())?;
    }
    Some(all)
}

/// Returns a note on the attributes that some blocks have and the joined mesh lacks.
fn dropped(owners: &[&Mesh], mesh: &Mesh) -> Option<String> {
    let mut names = Vec::new();
    for attribute in owners.iter().flat_map(|mesh| mesh.attributes()) {
        let stays = mesh.attributes().iter().any(|kept| kept.name == attribute.name);
        if !stays && !names.contains(&&attribute.name[..]) {
            names.push(&attribute.name);
        }
    }
    (!names.is_empty()).then(|| {
        format!("attributes dropped that not all parts have with the same type: {}", names.join(", "))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use tristrip::AttributeData;
    use tristrip_io::{Format, read};

    fn attribute(name: &str, data: AttributeData) -> Attribute {
        Attribute { name: name.into(), components: 1, normalized: false, data }
    }

    fn part(mesh: Mesh) -> Part {
        Part { mesh, ..Part::default() }
    }

    #[test]
    fn vertices_and_attributes_that_parts_share_stay() {
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        let triangles = |corners: &[u32]| Faces::from_triangles(corners.to_vec()).unwrap();
        let quad = Faces::from_polygons([[0, 1, 3, 2]]).unwrap();
        let values = |x: u8| AttributeData::U8(vec![x; 4]);
        let first = Mesh::new(positions.clone(), triangles(&[0, 1, 2])).unwrap();
        let first = first.with_attribute(attribute("a", values(1))).unwrap();
        let first = first.with_attribute(attribute("b", values(2))).unwrap();
        let second = first.with_faces(triangles(&[2, 1, 3])).unwrap();
        let third = Mesh::new(positions, quad).unwrap();
        let third = third.with_attribute(attribute("b", values(3))).unwrap();
        let third = third.with_attribute(attribute("a", AttributeData::I8(vec![0; 4]))).unwrap();
        let parts = vec![part(first), part(second), part(third)];
        let Joined { mesh, notes } = join(Model { parts, ..Model::default() }).unwrap();
        assert_eq!(mesh.vertex_count(), 8);
        assert_eq!(mesh.faces().iter().collect::<Vec<_>>(), [&[0, 1, 2][..], &[2, 1, 3], &[4, 5, 7, 6]]);
        let both = AttributeData::U8(vec![2, 2, 2, 2, 3, 3, 3, 3]);
        assert_eq!(mesh.attributes(), [attribute("b", both)]);
        let expected =
            ["parts joined into one: 3", "attributes dropped that not all parts have with the same type: a"];
        assert_eq!(notes, expected);
    }

    #[test]
    fn one_part_stays_as_it_is() {
        let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 9 9 9\nusemtl m\nf 1 2 3\n", Format::Obj).unwrap();
        let mesh = model.parts[0].mesh.clone();
        let Joined { mesh: joined, notes } = join(model).unwrap();
        assert!(joined.shares_vertices(&mesh));
        assert_eq!(notes, ["material names not written: 1"]);
        let none = join(Model::default()).unwrap();
        assert_eq!((none.mesh.vertex_count(), none.notes.len()), (0, 1));
    }
}
