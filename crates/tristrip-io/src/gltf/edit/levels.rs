//! A scene with meshes for lower levels of detail. These meshes use the first vertices of the full
//! meshes.
//!
//! # Algorithm
//! 1. A mesh is copied if one of its parts changes from one level to the next. The copy keeps
//!    names, materials, morph weights, points and lines. The vertex accessors of a part become
//!    accessors over their first values ([`crate::gltf::edit::prefixes`]). An unchanged mesh is
//!    used at both levels.
//! 2. Each copied primitive becomes an additional part of the model, so the writer gives it its own
//!    indices.
//! 3. Every node with such a mesh gets nodes for the lower levels
//!    ([`crate::gltf::edit::level_nodes`]).
//!
//! # Complexity
//! Linear in the document per level, and in the values of the new accessors. [`JSON_VALUE_LIMIT`]
//! bounds the document.

use std::collections::{BTreeMap, HashMap};

use crate::error::Error;
use crate::gltf::document::accessor::AccessorResolver;
use crate::gltf::document::json::{Members, Value};
use crate::gltf::document::scene::{PrimitiveRef, Scene};
use crate::gltf::document::{JSON_VALUE_LIMIT, Located, array, index, items, list_mut};
use crate::gltf::edit::level_nodes::{self, MeshLevels};
use crate::gltf::edit::prefixes::Prefixes;
use crate::gltf::edit::renumber::vertex_accessors;

/// A part at a lower level of detail.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PartAtLevel {
    /// The number of vertices that its triangles may use, from the first on.
    pub(crate) vertex_count: usize,
    /// Whether the triangles are the same as at the next finer level.
    pub(crate) is_same: bool,
}

/// A scene with lower levels.
pub(crate) struct WithLevels {
    pub(crate) scene: Scene,
    /// For each level, finest first: the part of the new scene that draws each part.
    pub(crate) parts: Vec<Vec<usize>>,
    /// For each level: the meshes with triangles, in the order of those of the finest level.
    pub(crate) meshes: Vec<Vec<usize>>,
    /// The number of nodes that have only their finest level.
    pub(crate) nodes_without: usize,
}

/// Adds lower levels to a scene. `lower` has the parts of each level, finest first. `coverage`
/// returns the screen coverages of all levels of a mesh, given its parts.
pub(crate) fn add(
    scene: &Scene,
    lower: &[Vec<PartAtLevel>],
    coverage: &dyn Fn(&[usize]) -> Vec<f64>,
) -> Result<WithLevels, Error> {
    check_size(&scene.document.root, lower.len())?;
    let mut of_mesh: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    scene.primitives.iter().enumerate().for_each(|(part, p)| of_mesh.entry(p.mesh).or_default().push(part));
    let mut primitives = scene.primitives.clone();
    let mut parts = vec![(0..primitives.len()).collect::<Vec<usize>>()];
    let mut meshes = vec![of_mesh.keys().copied().collect::<Vec<usize>>()];

    // 1. Meshes.
    let mut prefixes = Prefixes::new(scene)?;
    let mut new_meshes: Vec<Value> = Vec::new();
    let old_meshes = array(&scene.document.root, "meshes")?;
    for (level, at_level) in (1..).zip(lower) {
        let (mut level_parts, mut level_meshes) = (parts[level - 1].clone(), meshes[level - 1].clone());
        for (slot, (&mesh, of_mesh)) in of_mesh.iter().enumerate() {
            if of_mesh.iter().all(|&part| at_level[part].is_same) {
                continue;
            }
            level_meshes[slot] = old_meshes.len() + new_meshes.len();
            let cut = of_mesh.iter().map(|&part| (scene.primitives[part], at_level[part].vertex_count));
            new_meshes.push(mesh_at_level(&old_meshes[mesh], level, cut, &mut prefixes)?);
            for &part in of_mesh {
                level_parts[part] = primitives.len();
                let mesh = level_meshes[slot];
                primitives.push(PrimitiveRef { mesh, is_redrawn: true, ..scene.primitives[part] });
            }
        }
        parts.push(level_parts);
        meshes.push(level_meshes);
    }
    let accessors = prefixes.finish();
    let mut scene = Scene { primitives, ..scene.clone() };
    let root = &mut scene.document.root;
    accessors.apply(root)?;
    if !new_meshes.is_empty() {
        list_mut(root, "meshes")?.extend(new_meshes);
    }

    // 2. Nodes.
    let all = of_mesh.iter().enumerate().map(|(slot, (&mesh, of_mesh))| {
        let lower: Vec<usize> = meshes[1..].iter().map(|meshes| meshes[slot]).collect();
        (mesh, MeshLevels { lower, coverage: coverage(of_mesh) })
    });
    let changed = all.filter(|(mesh, levels)| levels.lower.iter().any(|lower| lower != mesh));
    let nodes_without = level_nodes::add(root, &changed.collect())?;
    Ok(WithLevels { scene, parts, meshes, nodes_without })
}

/// Checks that the document stays below the reader's limit with this many levels.
fn check_size(root: &Members, lower: usize) -> Result<(), Error> {
    // Approximate number of JSON values per node, primitive and accessor.
    const VALUES: usize = 8;
    let primitives = array(root, "meshes")?.iter().map(|mesh| items(mesh, "primitives").len());
    let entries = primitives.sum::<usize>() + array(root, "nodes")?.len() + array(root, "accessors")?.len();
    let found = (entries * lower * VALUES) as u64;
    if found <= JSON_VALUE_LIMIT {
        return Ok(());
    }
    Err(Error::LimitExceeded {
        at: "values of the JSON with all levels".into(),
        found,
        limit: JSON_VALUE_LIMIT,
    })
}

/// Returns a copy of a mesh whose triangle primitives use only their first vertices.
fn mesh_at_level(
    mesh: &Value,
    level: usize,
    cut: impl Iterator<Item = (PrimitiveRef, usize)>,
    prefixes: &mut Prefixes<'_>,
) -> Result<Value, Error> {
    let mut copy = mesh.clone();
    let Some(members) = copy.as_object_mut() else { return Ok(copy) };
    level_nodes::name_level(members, level);
    let Some(primitives) = members.get_mut("primitives").and_then(Value::as_array_mut) else {
        return Ok(copy);
    };
    for (PrimitiveRef { primitive, .. }, vertex_count) in cut {
        let Some(primitive) = primitives.get_mut(primitive) else { continue };
        let replaced = prefixes.of_primitive(primitive, vertex_count)?;
        if !replaced.is_empty() {
            replace_accessors(primitive, &replaced);
        }
    }
    Ok(copy)
}

/// Replaces the vertex accessors of a primitive.
fn replace_accessors(primitive: &mut Value, replaced: &HashMap<usize, usize>) {
    let Some(members) = primitive.as_object_mut() else { return };
    let replace = |object: &mut Value| {
        let names: Vec<(String, usize)> = object
            .as_object()
            .into_iter()
            .flat_map(Members::iter)
            .filter_map(|(name, old)| Some((name.to_owned(), *replaced.get(&index(old)?)?)))
            .collect();
        if let Some(members) = object.as_object_mut() {
            names.into_iter().for_each(|(name, new)| members.insert(&name, new));
        }
    };
    members.get_mut("attributes").into_iter().for_each(replace);
    let targets = members.get_mut("targets").and_then(Value::as_array_mut);
    targets.into_iter().flatten().for_each(replace);
}

impl Scene {
    /// Returns the index of the document's mesh that each part belongs to.
    ///
    /// ```
    /// let json = br#"{"asset":{"version":"2.0"}}"#;
    /// let model = tristrip_io::read(json, tristrip_io::Format::Gltf)?;
    /// assert!(model.scene.unwrap_or_default().mesh_of_parts().is_empty());
    /// # Ok::<(), tristrip_io::Error>(())
    /// ```
    pub fn mesh_of_parts(&self) -> Vec<usize> {
        self.primitives.iter().map(|primitive| primitive.mesh).collect()
    }

    /// Returns the size in bytes of all values used by the given meshes: indices, vertices and
    /// morph targets. Shared accessors count once.
    ///
    /// # Errors
    /// An accessor is invalid.
    ///
    /// ```
    /// use tristrip_io::{Drawing, Format, read, write};
    /// let triangle = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj)?;
    /// let glb = write(&triangle, &[Drawing::Faces], Format::Glb, tristrip::Layout::List)?;
    /// let scene = read(&glb, Format::Glb)?.scene.unwrap_or_default();
    /// assert_eq!(scene.bytes_of_meshes(&[0])?, 3 * 12 + 3);
    /// # Ok::<(), tristrip_io::Error>(())
    /// ```
    pub fn bytes_of_meshes(&self, meshes: &[usize]) -> Result<usize, Error> {
        let root = &self.document.root;
        let resolver = AccessorResolver { root, buffers: &self.buffers };
        let all = array(root, "meshes")?;
        let primitives = meshes.iter().filter_map(|&m| all.get(m)).flat_map(|mesh| items(mesh, "primitives"));
        let used = primitives.flat_map(|p| vertex_accessors(p).chain(p.get("indices").and_then(index)));
        let used: std::collections::BTreeSet<usize> = used.collect();
        let bytes = used.into_iter().map(|accessor| {
            let number = Value::from(accessor);
            let reference = Located { value: &number, at: format!("accessors[{accessor}]") };
            Ok(resolver.values(&reference)?.stored_bytes())
        });
        bytes.sum()
    }
}
