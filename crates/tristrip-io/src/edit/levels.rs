//! Models with several levels of detail in one vertex array: every level uses a prefix of the
//! vertices.
//!
//! ```text
//! vertices   ├ 10 % ─┤─ 25 % ───┤─ 50 % ───────────┤─ 100 % ──────────────────┤
//! level 3    ├───────┤
//! level 2    ├──────────────────┤
//! level 1    ├──────────────────────────────────────┤
//! level 0    ├─────────────────────────────────────────────────────────────────┤
//! ```
//! # Algorithm
//! 1. Each group of parts (see `renumber.rs`) has one vertex order: first the vertices of the
//!    coarsest level of all its parts, then the vertices that each finer level adds.
//! 2. Positions, attributes and triangles are renumbered, and vertices that no level uses are
//!    removed. In a scene written as a GLB, this includes all other vertex values: morph targets,
//!    joints and weights, and attributes that were not decoded.
//! 3. A group keeps its order or its vertices if other data in the scene depends on them;
//!    [`VertexGroup::kept`] states the reason. All its levels then use all vertices.
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

/// A part at a level of detail.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PartLevel {
    /// The triangles, as three indices of the part's vertices per triangle.
    pub triangles: Vec<u32>,
    /// The vertices that this level adds to the next coarser one, in refinement order. The other
    /// vertices that the triangles use follow in their original order.
    pub added: Vec<u32>,
}

/// A model with several levels of detail in one vertex array, finest first.
#[derive(Debug, Default)]
pub struct LeveledModel {
    /// The model at the finest level, with only the vertices that it uses.
    pub model: Model,
    /// The triangles per level and part, as vertex indices of the model.
    pub triangles: Vec<Vec<Vec<u32>>>,
    /// The number of leading vertices that each level may use, per level and part.
    pub vertex_counts: Vec<Vec<usize>>,
    /// The groups of parts that share vertices, with their vertex orders.
    pub groups: Vec<VertexGroup>,
}

/// A scene with a model at all levels; `MSFT_lod` lists the nodes of lower levels.
#[derive(Debug)]
pub struct SceneLevels {
    /// The scene, with the parts of all levels.
    pub model: Model,
    /// The parts of each level, finest first.
    pub parts: Vec<Vec<usize>>,
    /// The meshes of the document that each level uses.
    pub meshes: Vec<Vec<usize>>,
    /// The number of nodes that have only their finest level, because an extension animates their
    /// morph weights.
    pub nodes_without: usize,
}

/// Orders the vertices of a model so that each level of detail uses a prefix, and removes vertices
/// that no level uses if the file format allows it. `levels` is ordered from the finest level to
/// the coarsest, and each level has one entry per part.
///
/// # Errors
/// `levels` is empty, the number of entries of a level differs from the number of parts, a vertex
/// does not exist, or the number of corners is not a multiple of three.
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
                kept.get_or_insert_with(|| "parts with shared accessors have different vertex counts".into());
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

    // 2. The scene, the parts, and the levels.
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

/// Checks that there are levels with one entry per part, and returns the finest.
fn check_levels<'a>(model: &Model, levels: &'a [Vec<PartLevel>]) -> Result<&'a [PartLevel], Error> {
    let expected = model.parts.len();
    if let Some(level) = levels.iter().find(|level| level.len() != expected) {
        let found = level.len();
        return Err(Error::Unsupported(format!("parts of a level: found {found}, expected {expected}")));
    }
    levels
        .first()
        .map(Vec::as_slice)
        .ok_or_else(|| Error::Unsupported("levels: found none, expected at least one".into()))
}

/// The vertices of a group in the order in which levels use them.
struct ListedVertices {
    order: Vec<u32>,
    /// For each level, finest first: the number of vertices of this level and all coarser ones.
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

    /// Gives each level at least one vertex, because an accessor must have a value.
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

    /// Returns the number of vertices that a level uses, summed over the groups.
    ///
    /// # Errors
    /// The level does not exist.
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

    /// Builds a scene with all levels, to be written as one GLB. For each node whose mesh has lower
    /// levels, one new node per lower level is added. `coverage` receives the parts of a mesh and
    /// returns the minimum screen coverage of each level. For a model without a scene, the function
    /// builds the scene that its GLB would have, without the parts that have no vertices.
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
        // The parts in the scene, and the scene.
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

    /// Returns whether a part has the same triangles and vertex count as at the next finer level.
    fn is_same(&self, level: usize, part: usize) -> bool {
        self.triangles[level][part] == self.triangles[level - 1][part]
            && self.vertex_counts[level][part] == self.vertex_counts[level - 1][part]
    }
}
