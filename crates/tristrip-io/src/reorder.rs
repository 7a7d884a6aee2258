//! Models with their vertices in the order in which strips first use them, so that drawing them fetches vertices one after
//! the other.
//!
//! ```text
//! model, strips ─▶ groups of parts over the same vertices ─▶ an order each ─▶ model, strips ─▶ write
//! ```
//! # Algorithm
//! 1. Parts whose vertices the file holds once are one group: in PLY and OBJ those with positions and attributes in common, in
//!    a GLB those with the same positions, and in a scene those that share any accessor.
//! 2. The order of a group is that of the index buffers that the writer makes of its strips. Joined strips are joined beforehand:
//!    how they are joined depends on the numbers of vertices.
//! 3. Positions, attributes, faces and strips take the new numbers; in a scene also whatever else has a value for each
//!    vertex. What shared its vertices shares them again.
//!
//! # Complexity
//! Linear time; the vertices and faces are kept twice, and 8 bytes a vertex.

use std::sync::Arc;

use rustc_hash::FxHashMap;
use tristrip::strip::VertexOrder;
use tristrip::{Faces, Layout, Mesh, Strips};

use crate::{Drawing, Error, Format, Model, Part, gltf, join};

/// Parts over the same vertices, and the order of these.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VertexGroup {
    /// The parts, by their places in the model, rising.
    pub parts: Vec<usize>,
    /// Which vertex came to which place.
    pub order: VertexOrder,
    /// Why the vertices kept their numbers, where something in the scene counts on them.
    pub kept: Option<String>,
}

/// A model with its vertices in another order, and the strips that draw it.
#[derive(Debug)]
pub struct Reordered {
    /// The parts in their order, each over re-ordered vertices.
    pub model: Model,
    /// The strips over the new numbers, for each part.
    pub strips: Vec<Strips>,
    /// The layout to write them in: [`Layout::Separate`] for strips that are joined already.
    pub layout: Layout,
    /// The groups in the order of their first parts; together they have every part once.
    pub groups: Vec<VertexGroup>,
}

impl VertexGroup {
    /// Leaves the vertices their numbers.
    pub(crate) fn keep(&mut self, why: String) -> Result<(), Error> {
        self.order = VertexOrder::identity(self.order.vertex_count())?;
        self.kept = Some(why);
        Ok(())
    }
}

/// Numbers vertices in the order in which strips, written in a format and layout, first use them; vertices that no strip
/// uses come last, in their old order. Writing the result needs its own strips and layout.
///
/// Where something else in a scene counts on the numbers, or nobody can tell whether it does, the vertices stay as they are,
/// and [`VertexGroup::kept`] says why.
///
/// # Errors
/// There are not strips for each part, the scene is that of other parts, or strips name a vertex that their part does not have.
///
/// ```
/// use tristrip_io::{Drawing, Format, read, reorder, write};
/// let model = read(b"v 9 9 9\nv 0 1 0\nv 0 0 0\nv 1 0 0\nf 3 4 2\n", Format::Obj)?;
/// let mut strips = tristrip::Strips::default();
/// strips.push(&[2, 3, 1]);
/// let reordered = reorder(&model, &[strips], Format::Ply, tristrip::Layout::Restart)?;
/// assert_eq!(reordered.groups[0].order.new_to_old(), [2, 3, 1, 0]);
/// assert_eq!(reordered.strips[0].vertices(), [0, 1, 2]);
/// let drawings = [Drawing::Strips(&reordered.strips[0])];
/// let ply = write(&reordered.model, &drawings, Format::Ply, reordered.layout)?;
/// assert_eq!(read(&ply, Format::Ply)?.parts[0].mesh.positions()[3], [9.0; 3]);
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn reorder(model: &Model, strips: &[Strips], format: Format, layout: Layout) -> Result<Reordered, Error> {
    let drawings: Vec<_> = strips.iter().map(Drawing::Strips).collect();
    join::check_drawings(model, &drawings)?;
    let layout = if format == Format::Obj { Layout::List } else { layout };
    let (strips, layout) = match layout {
        Layout::Degenerate => (strips.iter().map(joined).collect(), Layout::Separate),
        other => (strips.to_vec(), other),
    };
    // 1. Groups, and their orders.
    let order = |parts: Vec<usize>, kept: Option<String>| {
        let vertex_count = parts.first().map_or(0, |&part| model.parts[part].mesh.vertex_count());
        let indices = parts.iter().filter(|_| kept.is_none()).flat_map(|&part| drawn(&strips[part], layout));
        Ok(VertexGroup { order: VertexOrder::of_indices(vertex_count, indices)?, parts, kept })
    };
    let scene = model.scene.as_ref().filter(|_| format == Format::Glb);
    let found = scene.map(|scene| gltf::reorder::groups(scene, strips.len())).transpose()?;
    let by_parts: Vec<(Vec<usize>, Option<String>)> = match &found {
        Some(found) => found.iter().map(|group| (group.parts.clone(), group.kept.clone())).collect(),
        None => parts_by_vertices(model, format)?.into_iter().map(|parts| (parts, None)).collect(),
    };
    let each = by_parts.into_iter().map(|(parts, kept)| order(parts, kept));
    let mut groups = each.collect::<Result<Vec<VertexGroup>, Error>>()?;
    // 2. The scene, which may have reasons to keep more groups as they are.
    let scene = match scene.zip(found) {
        Some((scene, found)) => Some(gltf::reorder::apply(scene, &found, &mut groups)?),
        None => model.scene.clone(),
    };
    // 3. Parts and strips.
    let parts = reordered_parts(model, &groups)?;
    let mut out = vec![Strips::default(); strips.len()];
    for group in &groups {
        for &part in &group.parts {
            out[part] = group.order.strips(&strips[part])?;
        }
    }
    let model = Model { parts, notes: model.notes.clone(), scene };
    Ok(Reordered { model, strips: out, layout, groups })
}

/// Joins strips into one.
fn joined(strips: &Strips) -> Strips {
    let mut out = Strips::default();
    let all = strips.to_degenerate();
    if !all.is_empty() {
        out.push(&all);
    }
    out
}

/// Gives the vertices of strips in the order in which a layout has them.
fn drawn(strips: &Strips, layout: Layout) -> Vec<u32> {
    if layout == Layout::List { strips.to_list() } else { strips.vertices().to_vec() }
}

/// Gives the parts whose vertices are written once, as the writers of a format without a scene see it.
pub(crate) fn parts_by_vertices(model: &Model, format: Format) -> Result<Vec<Vec<usize>>, Error> {
    let first: Vec<usize> = if format == Format::Glb {
        let mut first = FxHashMap::default();
        let of =
            |(i, part): (usize, &Part)| *first.entry(Arc::as_ptr(&part.mesh.shared_positions())).or_insert(i);
        model.parts.iter().enumerate().map(of).collect()
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

/// Gives the parts with vertices and faces in the new order; those of a group that shared positions or attributes still do.
fn reordered_parts(model: &Model, groups: &[VertexGroup]) -> Result<Vec<Part>, Error> {
    let mut meshes: Vec<Mesh> = model.parts.iter().map(|part| part.mesh.clone()).collect();
    for group in groups.iter().filter(|group| group.order.moved_count() > 0) {
        let order = &group.order;
        let mut positions = FxHashMap::default();
        let mut vertices: FxHashMap<_, Mesh> = FxHashMap::default();
        for &part in &group.parts {
            let mesh = &model.parts[part].mesh;
            let places = mesh.positions().as_ptr();
            let faces = order.faces(mesh.faces())?;
            let key = (places, mesh.attributes().as_ptr());
            if let Some(known) = vertices.get(&key) {
                meshes[part] = known.with_faces(faces)?;
                continue;
            }
            let moved = match positions.get(&places) {
                Some(known) => Arc::clone(known),
                None => Arc::new(order.values(mesh.positions(), 1)?),
            };
            positions.insert(places, Arc::clone(&moved));
            let mut bare = Mesh::new(moved, Faces::default())?;
            for attribute in mesh.attributes() {
                bare = bare.with_attribute(order.attribute(attribute)?)?;
            }
            meshes[part] = bare.with_faces(faces)?;
            vertices.insert(key, bare);
        }
    }
    let named = |(part, mesh): (&Part, Mesh)| Part {
        name: part.name.clone(),
        material: part.material.clone(),
        mesh,
        stripped: part.stripped,
        // The indices of the file name the old vertices, and what is drawn is another drawing.
        stored: None,
    };
    Ok(model.parts.iter().zip(meshes).map(named).collect())
}
