//! Models at several levels of detail over one vertex array: every level draws from the first vertices.
//!
//! ```text
//! vertices   ├ 10 % ─┤─ 25 % ───┤─ 50 % ───────────┤─ 100 % ──────────────────┤     each level beyond the next coarser one
//! level 3    ├───────┤
//! level 2    ├──────────────────┤
//! level 1    ├──────────────────────────────────────┤
//! level 0    ├─────────────────────────────────────────────────────────────────┤
//! ```
//! # Algorithm
//! 1. Each group of parts (those of `renumber.rs`, which does the rest) has one order: the vertices of the coarsest level of all its
//!    parts, then those that each finer level adds.
//! 2. Positions, attributes and triangles are renumbered, and vertices that no level uses are dropped; in a scene that is written as
//!    a GLB together with all other values of the vertices: morph targets, joints and weights, attributes that are not decoded.
//! 3. A group whose vertices something else in the scene depends on keeps its order or its vertices; [`VertexGroup::kept`] has the
//!    reason. All its levels then draw from all vertices.
//!
//! # Complexity
//! Linear in the vertices, and in the triangles of all levels.

use tristrip::{Faces, Mesh, VertexOrder};

use crate::edit::renumber::renumbered;
use crate::edit::vertex_group::{Renumbering, VertexGroup};
use crate::error::Error;
use crate::format::Format;
use crate::gltf;
use crate::gltf::edit::levels::PartAtLevel;
use crate::gltf::edit::renumber::SceneGroup;
use crate::model::Model;

/// What a part draws at a level of detail.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PartLevel {
    /// The triangles, three vertices of the part each.
    pub triangles: Vec<u32>,
    /// The vertices that the level has beyond the next coarser one, in the order in which refinement adds them; others that the
    /// triangles use follow in their order.
    pub added: Vec<u32>,
}

/// A model at several levels of detail over one vertex array, the finest first.
#[derive(Debug, Default)]
pub struct LeveledModel {
    /// The model at the finest level, over the vertices that it uses.
    pub model: Model,
    /// For each level and part the triangles, over the vertices of the model.
    pub triangles: Vec<Vec<Vec<u32>>>,
    /// For each level and part the number of vertices, from the first on, that the level may use.
    pub vertex_counts: Vec<Vec<usize>>,
    /// The groups of parts over the same vertices, with the order of the vertices.
    pub groups: Vec<VertexGroup>,
}

/// A scene that holds a model at all its levels: the nodes of lower levels are named by `MSFT_lod`.
#[derive(Debug)]
pub struct SceneLevels {
    /// The scene; its parts are those of all levels.
    pub model: Model,
    /// For each level, the finest first, the parts that it draws.
    pub parts: Vec<Vec<usize>>,
    /// For each level the meshes of the document that it draws.
    pub meshes: Vec<Vec<usize>>,
    /// The number of nodes that show their finest level only, since an extension animates their morph weights.
    pub nodes_without: usize,
}

/// Numbers the vertices of a model so that each level of detail uses the first ones, and drops those that no level uses, if a file of
/// this format allows it. The levels are given from the finest to the coarsest, each with what it draws of each part.
///
/// # Errors
/// There is no level, a level does not have an entry for each part, a vertex does not exist, or the number of corners is not a multiple
/// of three.
///
/// ```
/// use tristrip_io::{Format, PartLevel, in_level_order, read};
/// let model = read(b"v 9 9 9\nv 0 1 0\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf 3 4 5 2\n", Format::Obj)?;
/// let coarse = PartLevel { triangles: vec![2, 3, 4], added: vec![] };
/// let fine = PartLevel { triangles: vec![2, 3, 4, 2, 4, 1], added: vec![1] };
/// let leveled = in_level_order(&model, &[vec![fine], vec![coarse]], Format::Ply)?;
/// assert_eq!(leveled.triangles, [[vec![0, 1, 2, 0, 2, 3]], [vec![0, 1, 2]]]);
/// assert_eq!(leveled.vertex_counts, [[4], [3]]);
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn in_level_order(
    model: &Model,
    levels: &[Vec<PartLevel>],
    format: Format,
) -> Result<LeveledModel, Error> {
    let finest = check_levels(model, levels)?;
    let meshes = model.parts.iter().zip(finest);
    let meshes = meshes
        .map(|(part, level)| Ok(part.mesh.with_faces(Faces::from_triangles(level.triangles.clone())?)?));
    let meshes: Vec<Mesh> = meshes.collect::<Result<_, Error>>()?;

    // 1. The order of each group.
    let is_empty = finest.iter().all(|level| level.triangles.is_empty());
    let mut used = Vec::new();
    let number =
        |meshes: &[Mesh], parts: &[usize], group: Option<&SceneGroup>| -> Result<Renumbering, Error> {
            let counts: Vec<usize> = parts.iter().map(|&part| meshes[part].vertex_count()).collect();
            let vertex_count = counts.iter().copied().max().unwrap_or(0);
            let mut kept = group.and_then(SceneGroup::why_ordered);
            if counts.iter().any(|&count| count != vertex_count) {
                kept.get_or_insert_with(|| {
                    "parts over shared accessors have different numbers of vertices".into()
                });
            }
            if is_empty {
                kept.get_or_insert_with(|| "nothing is drawn".into());
            }
            let mut listed = ListedVertices::of(vertex_count, levels, parts)?;
            if group.is_some() {
                listed.have_one();
            }
            let left = if group.is_some_and(|group| group.why_complete().is_some()) {
                vertex_count
            } else {
                listed.order.len()
            };
            let order = match kept {
                Some(_) => VertexOrder::identity(vertex_count)?,
                None => VertexOrder::of_indices(vertex_count, listed.order)?,
            };
            let left = if kept.is_some() { vertex_count } else { left };
            used.push(listed.counts);
            Ok(Renumbering { order, left, kept })
        };

    // 2. The scene and the parts, then the levels.
    let (model, groups) = renumbered(model, meshes, (format, true), number)?;
    let mut triangles: Vec<Vec<Vec<u32>>> = vec![vec![Vec::new(); model.parts.len()]; levels.len()];
    let mut vertex_counts = vec![vec![0; model.parts.len()]; levels.len()];
    for ((parts, renumbering), counts) in groups.iter().zip(&used) {
        for (level, drawn) in levels.iter().enumerate() {
            for &part in parts {
                triangles[level][part] = renumbering.order.indices(&drawn[part].triangles)?;
                let is_ordered = renumbering.kept.is_none();
                vertex_counts[level][part] = if is_ordered { counts[level] } else { renumbering.left };
            }
        }
    }
    let groups = groups.into_iter().map(VertexGroup::from).collect();
    Ok(LeveledModel { model, triangles, vertex_counts, groups })
}

/// Checks that there are levels with an entry for each part, and returns the finest.
fn check_levels<'a>(model: &Model, levels: &'a [Vec<PartLevel>]) -> Result<&'a [PartLevel], Error> {
    let expected = model.parts.len();
    if let Some(level) = levels.iter().find(|level| level.len() != expected) {
        let found = level.len();
        return Err(Error::Unsupported(format!("parts of a level: found {found}, expected {expected}")));
    }
    levels.first().map(Vec::as_slice).ok_or_else(|| Error::Unsupported("levels: found none".into()))
}

/// The vertices of a group in the order in which levels need them.
struct ListedVertices {
    order: Vec<u32>,
    /// For each level, the finest first, the number of vertices that it and all coarser ones need.
    counts: Vec<usize>,
}

impl ListedVertices {
    fn of(vertex_count: usize, levels: &[Vec<PartLevel>], parts: &[usize]) -> Result<Self, Error> {
        let mut is_listed = vec![false; vertex_count];
        let (mut order, mut counts) = (Vec::new(), vec![0; levels.len()]);
        for (level, count) in levels.iter().zip(&mut counts).rev() {
            let all = parts.iter().map(|&part| &level[part]);
            for &vertex in all.flat_map(|part| part.added.iter().chain(&part.triangles)) {
                let Some(is_listed) = is_listed.get_mut(vertex as usize) else {
                    let message =
                        format!("vertex of a level: found {vertex}, expected less than {vertex_count}");
                    return Err(Error::Unsupported(message));
                };
                if !std::mem::replace(is_listed, true) {
                    order.push(vertex);
                }
            }
            *count = order.len();
        }
        Ok(Self { order, counts })
    }

    /// Makes each level have a vertex: an accessor must have a value.
    fn have_one(&mut self) {
        if self.order.is_empty() {
            self.order.push(0);
        }
        self.counts.iter_mut().for_each(|count| *count = (*count).max(1));
    }
}

impl LeveledModel {
    /// Returns the number of levels.
    pub fn level_count(&self) -> usize {
        self.triangles.len()
    }

    /// Returns the number of vertices, from the first on of each group, that a level uses.
    ///
    /// # Errors
    /// There is no such level.
    ///
    /// ```
    /// use tristrip_io::{Format, PartLevel, in_level_order, read};
    /// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj)?;
    /// let level = PartLevel { triangles: vec![0, 1, 2], added: vec![] };
    /// let leveled = in_level_order(&model, &[vec![level]], Format::Ply)?;
    /// assert_eq!((leveled.level_count(), leveled.vertex_count(0)?), (1, 3));
    /// assert!(leveled.vertex_count(1).is_err());
    /// # Ok::<(), tristrip_io::Error>(())
    /// ```
    pub fn vertex_count(&self, level: usize) -> Result<usize, Error> {
        let counts = self.vertex_counts.get(level).ok_or_else(|| self.no_level(level))?;
        Ok(self.groups.iter().filter_map(|group| counts.get(*group.parts.first()?)).sum())
    }

    fn no_level(&self, level: usize) -> Error {
        Error::Unsupported(format!("level: found {level}, expected less than {}", self.level_count()))
    }

    /// Builds a scene with all levels, to be written as one GLB: each node with a mesh that changes gets a node for each lower level.
    /// `coverage` returns for some parts, which are one mesh of the document, the screen coverages down to which the levels are drawn.
    /// A model without a scene gets the one that a GLB of it has, without parts that have no vertices.
    ///
    /// # Errors
    /// The scene already has levels of detail, or the document would be too large.
    ///
    /// ```
    /// use tristrip_io::{Format, PartLevel, in_level_order, read};
    /// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", Format::Obj)?;
    /// let coarse = PartLevel { triangles: vec![0, 1, 2], added: vec![] };
    /// let fine = PartLevel { triangles: vec![0, 1, 2, 0, 2, 3], added: vec![3] };
    /// let leveled = in_level_order(&model, &[vec![fine], vec![coarse]], Format::Glb)?;
    /// let scene = leveled.scene(&|_| vec![0.5, 0.0])?;
    /// assert_eq!((scene.parts, scene.meshes), (vec![vec![0], vec![1]], vec![vec![0], vec![1]]));
    /// assert_eq!(scene.model.parts[1].mesh.faces().face_count(), 1);
    /// # Ok::<(), tristrip_io::Error>(())
    /// ```
    pub fn scene(&self, coverage: &dyn Fn(&[usize]) -> Vec<f64>) -> Result<SceneLevels, Error> {
        // The parts that the scene has, and the scene.
        let is_built = self.model.scene.is_none();
        let has_vertices = |part: &usize| !is_built || self.model.parts[*part].mesh.vertex_count() > 0;
        let of_scene: Vec<usize> = (0..self.model.parts.len()).filter(has_vertices).collect();
        let model = gltf::with_scene(&self.model)?;
        let scene = model.scene.clone().unwrap_or_default();
        let lower = (1..self.level_count()).map(|level| {
            let at_level = of_scene.iter().map(|&part| PartAtLevel {
                vertex_count: self.vertex_counts[level][part],
                is_same: self.is_same(level, part),
            });
            at_level.collect::<Vec<_>>()
        });
        let lower: Vec<Vec<PartAtLevel>> = lower.collect();
        let outward = |parts: &[usize]| parts.iter().map(|&part| of_scene[part]).collect::<Vec<_>>();
        let with = gltf::edit::levels::add(&scene, &lower, &|parts| coverage(&outward(parts)))?;

        // The parts of all levels.
        let mut parts = Vec::new();
        for (triangles, numbers) in self.triangles.iter().zip(&with.parts) {
            let first_new = parts.len();
            for (slot, _) in numbers.iter().enumerate().filter(|(_, number)| **number >= first_new) {
                let faces = Faces::from_triangles(triangles[of_scene[slot]].clone())?;
                let part = &model.parts[slot];
                parts.push(part.with_mesh(part.mesh.with_faces(faces)?));
            }
        }
        let model =
            Model { parts, notes: self.model.notes.clone(), scene: Some(with.scene), materials: None };
        Ok(SceneLevels { model, parts: with.parts, meshes: with.meshes, nodes_without: with.nodes_without })
    }

    /// Returns whether a level draws a part as the next finer one does, from as many vertices.
    fn is_same(&self, level: usize, part: usize) -> bool {
        self.triangles[level][part] == self.triangles[level - 1][part]
            && self.vertex_counts[level][part] == self.vertex_counts[level - 1][part]
    }
}
