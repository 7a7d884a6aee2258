//! The vertices of a scene in a new order: their values are permuted in the buffers, and nothing else in the document changes.
//!
//! # Algorithm
//! 1. Primitives with an accessor in common, as an attribute or in a morph target, form one group with one order.
//! 2. A group keeps its vertex order where something else depends on it: points or lines over the vertices, another use of
//!    one of the accessors, extensions or extras of the primitives, accessors or views that hold whole numbers of unknown
//!    meaning, or bytes that belong to other data too.
//! 3. Every value moves to the slot of its new index, within its accessor: offsets, strides, counts and bounds stay, whether
//!    a view holds one accessor or several interleaved ones. A sparse accessor lists the new indices in ascending order.
//! 4. The moved values are compared with the old ones. Accessors that overlap in any way other than by the same vertices
//!    differ there, and their group is restored.
//!
//! # Complexity
//! Linear in the bytes of the accessors, which have the same limit as decoded ones. Memory: two bytes for each byte of the
//! buffers that change.

use std::collections::{BTreeSet, HashMap, HashSet};

use super::json::{Members, Value};

use super::accessor::AccessorResolver;
use super::budget::{ATTRIBUTE_LIMIT, DecodeBudget};
use super::document::{array, index, items, values};
use super::permute::{AccessorLayout, ByteOwners, OVER_BUDGET, PermutedBuffers};
use super::references::{ExtensionNumbers, has_number, skin_and_animation_accessors};
use super::scene::Scene;
use super::spec::ORDER_EXTENSIONS;
use crate::error::Error;
use crate::vertex_group::VertexGroup;

/// Extensions of primitives that do not refer to vertices by number.
const HARMLESS_EXTENSIONS: [&str; 2] = ["KHR_materials_variants", "EXT_structural_metadata"];

/// The extension for features of vertices: identified by an attribute or texture, or else by vertex number.
const FEATURES: &str = "EXT_mesh_features";

/// Bytes of accessors that may be checked per byte of the buffers, in addition to the constant.
const FACTOR: u64 = 16;

/// Parts over the same vertices.
pub(crate) struct SceneGroup {
    pub(crate) parts: Vec<usize>,
    /// Why the vertices must keep their numbers.
    pub(crate) kept: Option<String>,
    /// The accessors with a value for each vertex.
    accessors: BTreeSet<usize>,
}

/// Finds the groups of a scene's parts, in the order of their first parts.
///
/// # Errors
/// The scene has another number of parts.
pub(crate) fn groups(scene: &Scene, part_count: usize) -> Result<Vec<SceneGroup>, Error> {
    scene.check_part_count(part_count)?;
    let root = &scene.document.root;
    let parts: HashMap<(usize, usize), usize> =
        (scene.primitives.iter().enumerate()).map(|(part, p)| ((p.mesh, p.primitive), part)).collect();
    let mut sets = PrimitiveSets::default();
    let mut primitives = Vec::new();
    for (m, mesh) in array(root, "meshes")?.iter().enumerate() {
        for (p, primitive) in items(mesh, "primitives").iter().enumerate() {
            let accessors: Vec<usize> = vertex_accessors(primitive).collect();
            let number = sets.add(&accessors);
            let may_name_vertices = may_name_vertices(mesh, primitive);
            primitives.push((number, parts.get(&(m, p)).copied(), accessors, may_name_vertices));
        }
    }
    let others = other_uses(root)?;
    let names_bytes = ExtensionNumbers::of(root).names_bytes;
    let mut by_number: HashMap<usize, usize> = HashMap::new();
    let mut groups: Vec<SceneGroup> = Vec::new();
    for (number, part, ..) in &primitives {
        let Some(part) = *part else { continue };
        let group = *by_number.entry(sets.root(*number)).or_insert_with(|| {
            groups.push(SceneGroup { parts: Vec::new(), kept: None, accessors: BTreeSet::new() });
            groups.len() - 1
        });
        groups[group].parts.push(part);
    }
    for (number, part, accessors, may_name_vertices) in primitives {
        let Some(&group) = by_number.get(&sets.root(number)) else { continue };
        let group = &mut groups[group];
        if names_bytes {
            group.keep("an extension names bytes of a buffer");
        }
        if part.is_none() {
            group.keep("points or lines use the same vertices");
        }
        if may_name_vertices {
            group.keep("an extension or extras may refer to vertices by number");
        }
        if accessors.iter().any(|accessor| others.contains(accessor)) {
            group.keep("one of the accessors has another use");
        }
        group.accessors.extend(accessors);
    }
    Ok(groups)
}

/// Returns the scene with the values of each group's vertices in the group's order. A group for which that is not possible
/// keeps its vertex order, with the reason in [`VertexGroup::kept`].
pub(crate) fn apply(scene: &Scene, found: &[SceneGroup], groups: &mut [VertexGroup]) -> Result<Scene, Error> {
    let resolver = AccessorResolver { root: &scene.document.root, buffers: &scene.buffers };
    let mut budget = DecodeBudget::new(ATTRIBUTE_LIMIT, FACTOR, &scene.buffers);
    let mut arrays: Vec<Vec<AccessorLayout>> = Vec::with_capacity(groups.len());
    for (group, found) in groups.iter_mut().zip(found) {
        let mut list = Vec::new();
        if group.kept.is_none() && group.order.moved_count() > 0 {
            let vertex_count = group.order.vertex_count();
            let layouts = found
                .accessors
                .iter()
                .map(|&accessor| AccessorLayout::of_vertices(&resolver, accessor, vertex_count, &mut budget));
            match layouts.collect::<Result<Vec<_>, String>>() {
                Ok(layouts) => list = layouts,
                Err(why) => group.keep(why)?,
            }
        }
        arrays.push(list);
    }
    let moving: HashSet<usize> = (found.iter().zip(&arrays))
        .filter(|(_, arrays)| !arrays.is_empty())
        .flat_map(|(group, _)| group.accessors.iter().copied())
        .collect();
    let mut owners = ByteOwners::new(&scene.buffers);
    let all_marked = owners.mark_others(&resolver, &moving, &mut budget)?;
    let shared = if all_marked { "their bytes belong to other data too" } else { OVER_BUDGET };
    arrays.iter().for_each(|arrays| owners.mark_group(arrays));
    let mut permuted = PermutedBuffers::new(&scene.buffers);
    for (group, arrays) in groups.iter_mut().zip(&arrays).filter(|(_, arrays)| !arrays.is_empty()) {
        if !owners.is_exclusive(arrays) {
            group.keep(shared.into())?;
        } else if let Err(why) = permuted.permute(arrays, &group.order) {
            arrays.iter().for_each(|array| permuted.restore(array));
            group.keep(why)?;
        }
    }
    Ok(Scene { buffers: permuted.finish(), ..scene.clone() })
}

impl SceneGroup {
    fn keep(&mut self, why: &str) {
        self.kept.get_or_insert_with(|| why.to_owned());
    }
}

/// Iterates over the accessors that have a value for each vertex of a primitive.
fn vertex_accessors(primitive: &Value) -> impl Iterator<Item = usize> {
    let attributes = primitive.get("attributes").into_iter().flat_map(values);
    let targets = items(primitive, "targets").iter().flat_map(values);
    attributes.chain(targets).filter_map(index)
}

/// Checks whether extensions or extras of a mesh or primitive may refer to vertices by number.
fn may_name_vertices(mesh: &Value, primitive: &Value) -> bool {
    [mesh, primitive].into_iter().any(|object| {
        let extensions =
            object.get("extensions").and_then(Value::as_object).into_iter().flat_map(Members::iter);
        let names_vertices = |(name, value): (&str, &Value)| match name {
            FEATURES => !items(value, "featureIds").iter().all(has_stored_ids),
            // Extensions about the index order are dropped with the old indices.
            name => {
                !HARMLESS_EXTENSIONS.contains(&name) && !ORDER_EXTENSIONS.contains(&name) && has_number(value)
            }
        };
        object.get("extras").is_some_and(has_number) || extensions.into_iter().any(names_vertices)
    })
}

/// Checks whether the ids of a set of features are stored in an attribute or texture.
fn has_stored_ids(features: &Value) -> bool {
    ["attribute", "texture"].iter().any(|key| features.get(key).is_some())
}

/// Returns the accessors that are used other than for vertices.
fn other_uses(root: &Members) -> Result<HashSet<usize>, Error> {
    let mut used = skin_and_animation_accessors(root)?;
    for mesh in array(root, "meshes")? {
        used.extend(items(mesh, "primitives").iter().filter_map(|p| p.get("indices")).filter_map(index));
    }
    for node in array(root, "nodes")? {
        // Instances of a mesh have attributes of their own.
        let attributes =
            node.get("extensions").into_iter().flat_map(values).filter_map(|e| e.get("attributes"));
        used.extend(attributes.flat_map(values).filter_map(index));
    }
    Ok(used)
}

/// Disjoint sets of primitives, joined through the accessors that they share.
#[derive(Default)]
struct PrimitiveSets {
    parents: Vec<usize>,
    by_accessor: HashMap<usize, usize>,
}

impl PrimitiveSets {
    fn add(&mut self, accessors: &[usize]) -> usize {
        let number = self.parents.len();
        self.parents.push(number);
        for &accessor in accessors {
            let other = *self.by_accessor.entry(accessor).or_insert(number);
            let (a, b) = (self.root(other), self.root(number));
            self.parents[a.max(b)] = a.min(b);
        }
        number
    }

    fn root(&mut self, mut number: usize) -> usize {
        while self.parents[number] != number {
            self.parents[number] = self.parents[self.parents[number]];
            number = self.parents[number];
        }
        number
    }
}
