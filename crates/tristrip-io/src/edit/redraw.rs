//! Replaces the triangles of models and removes vertices that become unused.
//!
//! # Algorithm
//! 1. A vertex is kept if a part of its group uses it, or if points or lines in the scene use it.
//!    `renumber.rs` defines the groups.
//! 2. Positions, attributes and triangles are renumbered; the vertices keep their order. If there
//!    are no triangles at all, all vertices are kept, because not every format allows files without
//!    vertices.
//! 3. In a scene written as a GLB, the other values of removed vertices are also removed: morph
//!    targets, joints and weights, and attributes that were not decoded. Bytes that become unused
//!    are deleted. A group keeps its vertices if other data depends on them;
//!    [`Redrawn::kept_groups`] states the reason.
//!
//! # Complexity
//! Linear time; 8 bytes per vertex in addition to the new model. For a scene, see
//! `gltf/edit/renumber.rs`.

use tristrip::VertexOrder;
use tristrip::text::counted;
use tristrip::{Faces, Mesh, Strips};

use crate::edit::renumber::renumbered;
use crate::edit::vertex_group::Renumbering;
use crate::error::Error;
use crate::format::Format;
use crate::gltf;
use crate::gltf::edit::renumber::SceneGroup;
use crate::model::Model;

/// A model with new triangles, and counts of its vertices.
#[derive(Debug, Clone)]
pub struct Redrawn {
    /// The parts, in their original order, with their new triangles as faces.
    pub model: Model,
    /// The number of vertices used by triangles.
    pub used: usize,
    /// The number of unused vertices that were removed.
    pub dropped: usize,
    /// The number of unused vertices that were kept, because a scene depends on them or there are
    /// no triangles at all.
    pub kept: usize,
    /// The groups of parts whose unused vertices were kept.
    pub kept_groups: Vec<KeptVertices>,
    /// The new vertex order of each group with unused vertices.
    orders: Vec<VertexOrder>,
    /// For each part: the index of its group's order, if its vertices were renumbered.
    order_of: Vec<Option<usize>>,
}

/// Unused vertices that were kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KeptVertices {
    /// The indices of the parts with these vertices, ascending.
    pub parts: Vec<usize>,
    /// The number of unused vertices.
    pub vertex_count: usize,
    /// The reason for keeping them.
    pub why: String,
}

impl Redrawn {
    /// Returns the old index of each vertex of a part.
    ///
    /// # Errors
    /// The part does not exist.
    ///
    /// ```
    /// use tristrip_io::{Format, read, with_triangles};
    /// let model = read(b"v 9 9 9\nv 0 1 0\nv 0 0 0\nv 1 0 0\nf 2 3 4\n", Format::Obj)?;
    /// let smaller = with_triangles(&model, vec![vec![1, 2, 3]], Format::Ply)?;
    /// assert_eq!(smaller.old_vertices(0)?, [1, 2, 3]);
    /// # Ok::<(), tristrip_io::Error>(())
    /// ```
    pub fn old_vertices(&self, part: usize) -> Result<Vec<u32>, Error> {
        let (Some(order), Some(new)) = (self.order_of.get(part), self.model.parts.get(part)) else {
            let message = format!("part {part}: found {}", counted(self.order_of.len(), "part"));
            return Err(Error::Unsupported(message));
        };
        let vertex_count = new.mesh.vertex_count();
        Ok(match order.map(|order| self.orders[order].new_to_old()) {
            Some(old) => old.iter().copied().take(vertex_count).collect(),
            None => (0..vertex_count as u32).collect(),
        })
    }

    /// Renumbers strips of a part from its old vertices to its new vertices. The strips must use
    /// only vertices of the new triangles.
    ///
    /// # Errors
    /// The part does not exist, or a strip uses a vertex that the part does not have.
    ///
    /// ```
    /// use tristrip_io::{Format, read, with_triangles};
    /// let model = read(b"v 9 9 9\nv 0 1 0\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf 3 4 5 2\n", Format::Obj)?;
    /// let mut strips = tristrip::Strips::default();
    /// strips.push(&[2, 3, 1, 4]);
    /// let smaller = with_triangles(&model, vec![strips.to_list()], Format::Ply)?;
    /// // Vertex 0 is unused and dropped.
    /// assert_eq!(smaller.strips(0, &strips)?.vertices(), [1, 2, 0, 3]);
    /// # Ok::<(), tristrip_io::Error>(())
    /// ```
    pub fn strips(&self, part: usize, strips: &Strips) -> Result<Strips, Error> {
        let Some(order) = self.order_of.get(part) else {
            let message = format!("part {part}: found {}", counted(self.order_of.len(), "part"));
            return Err(Error::Unsupported(message));
        };
        let Some(order) = order.map(|order| &self.orders[order]) else { return Ok(strips.clone()) };
        Ok(order.strips(strips)?.with_welds_below(self.model.parts[part].mesh.vertex_count()))
    }
}

/// Replaces the triangles of each part, and removes vertices that no part uses if the file format
/// allows it. `triangles` contains one list per part, with three vertex indices per triangle.
///
/// # Errors
/// The number of lists differs from the number of parts, a list contains a vertex that its part
/// does not have, or the length of a list is not a multiple of three.
///
/// ```
/// use tristrip_io::{Format, read, with_triangles};
/// let model = read(b"v 9 9 9\nv 0 1 0\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf 3 4 5 2\n", Format::Obj)?;
/// let smaller = with_triangles(&model, vec![vec![2, 3, 1]], Format::Ply)?;
/// assert_eq!(smaller.model.parts[0].mesh.faces().corners(), [1, 2, 0]);
/// assert_eq!(smaller.model.parts[0].mesh.vertex_count(), 3);
/// assert_eq!((smaller.dropped, smaller.kept), (2, 0));
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn with_triangles(model: &Model, triangles: Vec<Vec<u32>>, format: Format) -> Result<Redrawn, Error> {
    check_lists(model, &triangles)?;
    let mut meshes = Vec::with_capacity(model.parts.len());
    for (part, corners) in model.parts.iter().zip(triangles) {
        meshes.push(part.mesh.with_faces(Faces::from_triangles(corners)?)?);
    }
    // 1. The kept vertices of each group.
    let scene = model.scene.as_ref().filter(|_| format == Format::Glb);
    // An OBJ without vertices would be an empty file.
    let is_empty = meshes.iter().all(|mesh| mesh.faces().corner_count() == 0);
    let mut others = scene.map(gltf::edit::renumber::OtherVertices::of);
    let mut counts = Vec::new();
    let number =
        |meshes: &[Mesh], parts: &[usize], group: Option<&SceneGroup>| -> Result<Renumbering, Error> {
            let mut used = VertexUse::of(meshes, parts);
            let by_triangles = used.count();
            let mut kept = None;
            if let Some((others, group)) = others.as_mut().zip(group) {
                let unknown = others.mark(group, &mut used.is_used).err();
                let has_all = |&part: &usize| meshes[part].vertex_count() == used.is_used.len();
                let several = (!parts.iter().all(has_all))
                    .then(|| "parts with shared accessors have different vertex counts".to_owned());
                kept = group.why_complete().or(several).or(unknown);
            }
            if is_empty {
                kept = Some("nothing is drawn".to_owned());
            }
            let unused = used.is_used.len() - used.count();
            if unused == used.is_used.len() && scene.is_some() {
                // An accessor must have at least one value.
                used.is_used.iter_mut().take(1).for_each(|is_used| *is_used = true);
            }
            counts.push((by_triangles, unused));
            used.renumbering(kept)
        };
    // 2. The scene and the parts.
    let (model, groups) = renumbered(model, meshes, (format, true), number)?;
    let (mut dropped, mut kept_groups) = (0, Vec::new());
    let (mut orders, mut order_of) = (Vec::new(), vec![None; model.parts.len()]);
    for ((parts, renumbering), &(_, unused)) in groups.into_iter().zip(&counts) {
        if let Some(why) = renumbering.kept {
            if unused > 0 {
                kept_groups.push(KeptVertices { parts, vertex_count: unused, why });
            }
        } else if renumbering.drops() {
            dropped += renumbering.order.vertex_count() - renumbering.left;
            parts.iter().for_each(|&part| order_of[part] = Some(orders.len()));
            orders.push(renumbering.order);
        }
    }
    let kept = kept_groups.iter().map(|group| group.vertex_count).sum();
    let used = counts.iter().map(|(by_triangles, _)| by_triangles).sum();
    Ok(Redrawn { model, used, dropped, kept, kept_groups, orders, order_of })
}

/// Replaces each vertex in `triangles` by the first vertex that is equal in every value, if a scene
/// is written as a GLB. Otherwise the triangles do not change. [`with_triangles`] can then remove
/// the unused vertices.
///
/// # Errors
/// The number of lists differs from the number of parts.
///
/// ```
/// use tristrip_io::{Format, gltf, merge_equal_vertices};
/// let json = br#"{"asset":{"version":"2.0"},
///     "accessors":[{"componentType":5126,"type":"VEC3","count":3}],
///     "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}]}"#;
/// let model = gltf::read(json.to_vec(), None)?;
/// let mut triangles = vec![vec![0, 1, 2]];
/// // An accessor without bytes: all three vertices are zero.
/// merge_equal_vertices(&model, &mut triangles, Format::Glb)?;
/// assert_eq!(triangles, [[0, 0, 0]]);
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn merge_equal_vertices(model: &Model, triangles: &mut [Vec<u32>], format: Format) -> Result<(), Error> {
    check_lists(model, triangles)?;
    let Some(scene) = model.scene.as_ref().filter(|_| format == Format::Glb) else { return Ok(()) };
    let counts: Vec<usize> = model.parts.iter().map(|part| part.mesh.vertex_count()).collect();
    for (corners, first) in triangles.iter_mut().zip(gltf::edit::equal_vertices::first_equal(scene, &counts)?)
    {
        let Some(first) = first else { continue };
        corners.iter_mut().for_each(|v| *v = first.get(*v as usize).copied().unwrap_or(*v));
    }
    Ok(())
}

/// Checks that there is one list of triangles per part.
fn check_lists(model: &Model, triangles: &[Vec<u32>]) -> Result<(), Error> {
    if triangles.len() == model.parts.len() {
        return Ok(());
    }
    let (found, expected) = (triangles.len(), model.parts.len());
    let message = format!("lists of triangles: found {found}, expected {expected} (one per part)");
    Err(Error::Unsupported(message))
}

/// The used vertices of a group.
#[derive(Clone)]
struct VertexUse {
    is_used: Vec<bool>,
}

impl VertexUse {
    fn of(meshes: &[Mesh], group: &[usize]) -> Self {
        let vertex_count = group.iter().map(|&part| meshes[part].vertex_count()).max().unwrap_or(0);
        let mut is_used = vec![false; vertex_count];
        for &part in group {
            meshes[part].faces().corners().iter().for_each(|&v| is_used[v as usize] = true);
        }
        Self { is_used }
    }

    fn count(&self) -> usize {
        self.is_used.iter().filter(|&&is_used| is_used).count()
    }

    /// Returns the renumbering that removes unused vertices, or keeps all if there is a reason.
    fn renumbering(&self, kept: Option<String>) -> Result<Renumbering, Error> {
        let vertex_count = self.is_used.len();
        if kept.is_some() {
            return Ok(Renumbering::of_order(VertexOrder::identity(vertex_count)?, kept));
        }
        let in_use = (0..vertex_count as u32).filter(|&v| self.is_used[v as usize]);
        // Unused vertices are last in this order.
        let order = VertexOrder::of_indices(vertex_count, in_use)?;
        Ok(Renumbering { order, left: self.count(), kept: None })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Part;
    use tristrip::{Attribute, AttributeData};

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

    /// Strips of a welded mesh leave the welded vertices unused. They are removed together with
    /// their welds.
    #[test]
    fn welded_strips_are_proven_over_the_vertices_left() {
        let corners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 1., 0.], [1., 0., 0.], [1., 1., 0.]];
        let mesh = Mesh::new(corners.to_vec(), Faces::from_triangles((0..6).collect()).unwrap()).unwrap();
        let strips =
            tristrip::stripify(&mesh, &tristrip::StripifyOptions::default().with_weld(true)).unwrap();
        assert_eq!(strips.welds().len(), 2);
        let smaller = with_triangles(&model(&[&mesh]), vec![strips.to_list()], Format::Ply).unwrap();
        assert_eq!(smaller.dropped, 2);
        let strips = smaller.strips(0, &strips).unwrap();
        assert!(tristrip::verify::verify(&smaller.model.parts[0].mesh, &strips).is_ok());
    }

    #[test]
    fn unused_vertices_are_dropped_with_their_attributes() {
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
        assert!(of.strips(2, &strips).is_err() && of.strips(usize::MAX, &strips).is_err());
        strips.push(&[u32::MAX]);
        assert!(of.strips(1, &strips).is_err());
    }

    #[test]
    fn parts_with_separate_vertices_keep_those_in_use() {
        let (a, b) = (square("uv"), square("uv"));
        let of = with_triangles(&model(&[&a, &b]), vec![vec![0, 1, 2], vec![]], Format::Obj).unwrap();
        assert_eq!(of.model.parts.iter().map(|part| part.mesh.vertex_count()).collect::<Vec<_>>(), [3, 0]);
        assert_eq!(of.dropped, 5);
    }

    #[test]
    fn a_model_without_triangles_keeps_its_vertices() {
        let of = with_triangles(&model(&[&square("uv")]), vec![vec![]], Format::Obj).unwrap();
        assert_eq!((of.model.parts[0].mesh.vertex_count(), of.dropped, of.kept), (4, 0, 4));
    }

    #[test]
    fn invalid_triangles_are_refused() {
        let one = model(&[&square("uv")]);
        assert!(with_triangles(&one, vec![], Format::Ply).is_err());
        assert!(with_triangles(&one, vec![vec![0, 1, 4]], Format::Ply).is_err());
        assert!(with_triangles(&one, vec![vec![0, 1]], Format::Ply).is_err());
    }
}
