//! Models with other triangles over their vertices, without the vertices that are not used any more.
//!
//! # Algorithm
//! 1. Parts whose vertices the file holds once are one group, as in [`crate::reorder`]; a vertex stays where a part of its group uses it.
//! 2. Positions, attributes and triangles take the new numbers, which are in the order of the old ones. Where nothing is drawn
//!    at all, vertices stay, since not every format has files without any.
//! 3. In a scene that is written as a GLB vertices stay: skins, morph targets and whatever else has a value for each of them count on
//!    their number.
//!
//! # Complexity
//! Linear time; 8 bytes a vertex beside what stays of the model.

use std::sync::Arc;

use rustc_hash::FxHashMap;
use tristrip::strip::VertexOrder;
use tristrip::{Attribute, AttributeData, Faces, Mesh, Strips};

use crate::reorder::parts_by_vertices;
use crate::{Error, Format, Model, Part};

/// A model with other triangles, and what became of its vertices.
#[derive(Debug)]
pub struct Redrawn {
    /// The parts in their order, each with its new triangles as faces.
    pub model: Model,
    /// Vertices that triangles use.
    pub used: usize,
    /// Vertices that no triangle uses and that are gone.
    pub dropped: usize,
    /// Vertices that no triangle uses and that are still there, as a scene counts on them, or as nothing is drawn at all.
    pub kept: usize,
    /// The new numbers of groups of parts whose vertices are not all in use.
    orders: Vec<VertexOrder>,
    /// For each part its group's, if it has new numbers.
    order_of: Vec<Option<usize>>,
}

impl Redrawn {
    /// Gives strips over the old vertices of a part, of those that are in use, over its new ones.
    ///
    /// # Errors
    /// The strips have a vertex that the part does not have.
    ///
    /// # Panics
    /// There is no such part.
    pub fn strips(&self, part: usize, strips: &Strips) -> Result<Strips, Error> {
        let order = self.order_of[part].map(|order| &self.orders[order]);
        Ok(order.map_or_else(|| Ok(strips.clone()), |order| order.strips(strips))?)
    }
}

/// Gives the parts of a model other triangles, three vertices each, and drops the vertices that no part uses any more, where they
/// can be dropped from a file of this format.
///
/// # Errors
/// There are not triangles for each part, they name a vertex that their part does not have, or are not three corners each.
///
/// ```
/// use tristrip_io::{Format, read, with_triangles};
/// let model = read(b"v 9 9 9\nv 0 1 0\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf 3 4 5 2\n", Format::Obj)?;
/// let smaller = with_triangles(&model, vec![vec![2, 3, 1]], Format::Ply)?;
/// assert_eq!(smaller.model.parts[0].mesh.faces().corners(), [1, 2, 0]);
/// assert_eq!((smaller.model.parts[0].mesh.vertex_count(), smaller.dropped, smaller.kept), (3, 2, 0));
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn with_triangles(model: &Model, triangles: Vec<Vec<u32>>, format: Format) -> Result<Redrawn, Error> {
    if triangles.len() != model.parts.len() {
        let (found, expected) = (triangles.len(), model.parts.len());
        let message = format!("lists of triangles: found {found}, expected {expected} (one for each part)");
        return Err(Error::Unsupported(message));
    }
    let mut meshes = Vec::with_capacity(model.parts.len());
    for (part, corners) in model.parts.iter().zip(triangles) {
        meshes.push(part.mesh.with_faces(Faces::from_triangles(corners)?)?);
    }
    // An OBJ without any vertex would be an empty file.
    let is_empty = meshes.iter().all(|mesh| mesh.faces().corner_count() == 0);
    let stays = is_empty || (format == Format::Glb && model.scene.is_some());
    let (mut in_use, mut dropped, mut kept) = (0, 0, 0);
    let (mut orders, mut order_of) = (Vec::new(), vec![None; meshes.len()]);
    for group in parts_by_vertices(model, format)? {
        let used = Used::of(&meshes, &group);
        in_use += used.count;
        if stays {
            kept += used.unused_count();
        } else if used.unused_count() > 0 {
            dropped += used.unused_count();
            group.iter().for_each(|&part| order_of[part] = Some(orders.len()));
            orders.push(used.keep_only(&mut meshes, &group)?);
        }
    }
    let redrawn = |(part, mesh): (&Part, Mesh)| Part {
        name: part.name.clone(),
        material: part.material.clone(),
        mesh,
        stripped: false,
        stored: None,
    };
    let parts = model.parts.iter().zip(meshes).map(redrawn).collect();
    let model = Model { parts, notes: model.notes.clone(), scene: model.scene.clone() };
    Ok(Redrawn { model, used: in_use, dropped, kept, orders, order_of })
}

/// The vertices of a group that its parts use.
struct Used {
    /// Vertices in use, in their order, then the others.
    order: Vec<u32>,
    count: usize,
}

impl Used {
    fn of(meshes: &[Mesh], group: &[usize]) -> Self {
        let vertex_count = group.first().map_or(0, |&part| meshes[part].vertex_count());
        let mut is_used = vec![false; vertex_count];
        for &part in group {
            meshes[part].faces().corners().iter().for_each(|&v| is_used[v as usize] = true);
        }
        let (mut order, unused): (Vec<u32>, Vec<u32>) =
            (0..vertex_count as u32).partition(|&v| is_used[v as usize]);
        let count = order.len();
        order.extend(unused);
        Self { order, count }
    }

    fn unused_count(&self) -> usize {
        self.order.len() - self.count
    }

    /// Leaves the parts of the group only the vertices in use; what shared its arrays shares them again. Gives the new
    /// numbers.
    fn keep_only(&self, meshes: &mut [Mesh], group: &[usize]) -> Result<VertexOrder, Error> {
        let order = VertexOrder::from_new_to_old(&self.order)?;
        let mut positions = FxHashMap::default();
        let mut vertices: FxHashMap<_, Mesh> = FxHashMap::default();
        for &part in group {
            let mesh = meshes[part].clone();
            let faces = order.faces(mesh.faces())?;
            let at = mesh.positions().as_ptr();
            let key = (at, mesh.attributes().as_ptr());
            if let Some(known) = vertices.get(&key) {
                meshes[part] = known.with_faces(faces)?;
                continue;
            }
            let fewer = if let Some(known) = positions.get(&at) {
                Arc::clone(known)
            } else {
                let mut all = order.values(mesh.positions(), 1)?;
                all.truncate(self.count);
                Arc::new(all)
            };
            positions.insert(at, Arc::clone(&fewer));
            let mut bare = Mesh::new(fewer, Faces::default())?;
            for attribute in mesh.attributes() {
                bare = bare.with_attribute(truncated(order.attribute(attribute)?, self.count))?;
            }
            meshes[part] = bare.with_faces(faces)?;
            vertices.insert(key, bare);
        }
        Ok(order)
    }
}

/// Leaves an attribute the values of the first vertices.
fn truncated(mut attribute: Attribute, vertex_count: usize) -> Attribute {
    let count = vertex_count * usize::from(attribute.components.max(1));
    match &mut attribute.data {
        AttributeData::F32(values) => values.truncate(count),
        AttributeData::F64(values) => values.truncate(count),
        AttributeData::U8(values) => values.truncate(count),
        AttributeData::I8(values) => values.truncate(count),
        AttributeData::U16(values) => values.truncate(count),
        AttributeData::I16(values) => values.truncate(count),
        AttributeData::U32(values) => values.truncate(count),
        AttributeData::I32(values) => values.truncate(count),
    }
    attribute
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(name: &str) -> Mesh {
        let mesh =
            Mesh::new((0..4).map(|i| [i as f32, 0.0, 1.0]).collect::<Vec<_>>(), Faces::default()).unwrap();
        let data = AttributeData::U8((0..8).collect());
        mesh.with_attribute(Attribute { name: name.into(), components: 2, normalized: false, data }).unwrap()
    }

    fn model(meshes: &[&Mesh]) -> Model {
        let parts = meshes.iter().map(|&mesh| Part { mesh: mesh.clone(), ..Part::default() }).collect();
        Model { parts, ..Model::default() }
    }

    #[test]
    fn what_no_part_uses_is_dropped_with_all_that_belongs_to_it() {
        let shared = square("uv");
        let of = with_triangles(&model(&[&shared, &shared]), vec![vec![3, 3, 3], vec![1, 3, 1]], Format::Ply)
            .unwrap();
        let meshes: Vec<&Mesh> = of.model.parts.iter().map(|part| &part.mesh).collect();
        assert!(meshes[0].shares_vertices(meshes[1]));
        assert_eq!(
            (meshes[0].faces().corners(), meshes[1].faces().corners()),
            (&[1, 1, 1][..], &[0, 1, 0][..])
        );
        assert_eq!(meshes[0].positions(), [[1.0, 0.0, 1.0], [3.0, 0.0, 1.0]]);
        assert_eq!(meshes[0].attributes()[0].data, AttributeData::U8(vec![2, 3, 6, 7]));
        assert_eq!((of.used, of.dropped, of.kept), (2, 2, 0));
        let mut strips = Strips::default();
        strips.push(&[1, 3, 3]);
        assert_eq!(of.strips(1, &strips).unwrap().vertices(), [0, 1, 1]);
    }

    #[test]
    fn parts_with_vertices_of_their_own_keep_what_they_use() {
        let (a, b) = (square("uv"), square("uv"));
        let of = with_triangles(&model(&[&a, &b]), vec![vec![0, 1, 2], vec![]], Format::Obj).unwrap();
        assert_eq!(of.model.parts.iter().map(|part| part.mesh.vertex_count()).collect::<Vec<_>>(), [3, 0]);
        assert_eq!(of.dropped, 5);
    }

    #[test]
    fn a_scene_keeps_its_vertices_in_a_glb_alone() {
        let mut with_scene = model(&[&square("uv")]);
        with_scene.scene = Some(crate::gltf::Scene::default());
        let of = |format| with_triangles(&with_scene, vec![vec![0, 1, 2]], format).unwrap();
        assert_eq!((of(Format::Glb).dropped, of(Format::Glb).kept), (0, 1));
        assert_eq!((of(Format::Ply).dropped, of(Format::Ply).kept), (1, 0));
    }

    #[test]
    fn what_draws_nothing_keeps_its_vertices() {
        let of = with_triangles(&model(&[&square("uv")]), vec![vec![]], Format::Obj).unwrap();
        assert_eq!((of.model.parts[0].mesh.vertex_count(), of.dropped, of.kept), (4, 0, 4));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let one = model(&[&square("uv")]);
        assert!(with_triangles(&one, vec![], Format::Ply).is_err());
        assert!(with_triangles(&one, vec![vec![0, 1, 4]], Format::Ply).is_err());
        assert!(with_triangles(&one, vec![vec![0, 1]], Format::Ply).is_err());
    }
}
