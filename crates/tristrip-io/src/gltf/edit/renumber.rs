//! Renumbers or removes vertices of a scene: values are permuted in the buffers, and the values of
//! removed vertices are cut off.
//!
//! ```text
//! values of an accessor    a b c d e f      used: b d e
//! values of an accessor    a b c d e f      used: b d e
//! permuted                 b d e . . .      in place
//! cut off                  b d e            smaller count, shorter buffer
//! ```
//! # Algorithm
//! 1. Primitives that share an accessor, as an attribute or in a morph target, form a group with a
//!    common vertex order.
//! 2. A group keeps its vertices if other data depends on their indices: another use of one of the
//!    accessors, extensions or extras of the primitives, integers of unknown meaning on accessors
//!    or views, or bytes shared with other data. A group keeps the order of its vertices if points
//!    or lines use them. Vertices can be removed only if no extension or extras in the document
//!    contains the index of one of the accessors or views. The indices of points and lines are then
//!    updated.
//! 3. Every value moves to the slot of its new index within its accessor; views may be interleaved.
//!    A sparse accessor lists the new indices in ascending order.
//! 4. The moved values are compared with the old ones. If different vertices share bytes because
//!    accessors overlap, the values differ, and the group is restored.
//! 5. [`crate::gltf::edit::shrink`] removes the values of removed vertices and their bytes.
//!
//! # Complexity
//! Linear in the bytes of the accessors, up to the limit for decoded values. Memory: two bytes per
//! byte of the changed buffers.

use std::collections::{BTreeSet, HashMap, HashSet};

use crate::gltf::document::json::{Members, Value};

use crate::edit::vertex_group::Renumbering;
use crate::error::Error;
use crate::gltf::document::accessor::AccessorResolver;
use crate::gltf::document::budget::{ATTRIBUTE_LIMIT, DecodeBudget};
use crate::gltf::document::references::{
    ExtensionNumbers, has_number, skin_and_animation_accessors, views_of_accessor,
};
use crate::gltf::document::scene::Scene;
use crate::gltf::document::spec::ORDER_EXTENSIONS;
use crate::gltf::document::{Located, array, index, items, values};
use crate::gltf::edit::permute::{AccessorLayout, ByteOwners, OVER_BUDGET, PermutedBuffers, VERTEX_FACTOR};
use crate::gltf::edit::shrink::Shrink;

/// Extensions of primitives that do not refer to vertices by index.
const HARMLESS_EXTENSIONS: [&str; 2] = ["KHR_materials_variants", "EXT_structural_metadata"];

/// The extension for vertex features, identified by an attribute, a texture or the vertex index.
const FEATURES: &str = "EXT_mesh_features";

/// Why vertices keep their order if points or lines use them.
const POINTS_OR_LINES: &str = "points or lines use the same vertices";

/// Parts that share vertices.
pub(crate) struct SceneGroup {
    pub(crate) parts: Vec<usize>,
    /// Why the vertices must keep their indices, if they must.
    kept: Option<String>,
    /// Why no vertex can be removed, if the vertices could otherwise change.
    complete: Option<String>,
    /// Whether points or lines use the vertices.
    has_others: bool,
    /// Whether points or lines without indices use all vertices.
    draws_all: bool,
    /// The accessors with the indices of points and lines.
    other_indices: BTreeSet<usize>,
    /// The accessors with a value per vertex.
    accessors: BTreeSet<usize>,
}

/// A primitive of the document.
struct Primitive {
    /// The set of primitives that share accessors with this one.
    set: usize,
    /// `None` for points and lines.
    part: Option<usize>,
    indices: Option<usize>,
    accessors: Vec<usize>,
    may_name_vertices: bool,
}

/// Finds the groups of a scene's parts, in the order of their first parts.
///
/// # Errors
/// `part_count` is not the number of parts of the scene.
pub(crate) fn groups(scene: &Scene, part_count: usize) -> Result<Vec<SceneGroup>, Error> {
    scene.check_part_count(part_count)?;
    let root = &scene.document.root;
    let parts: HashMap<(usize, usize), usize> =
        (scene.primitives.iter().enumerate()).map(|(part, p)| ((p.mesh, p.primitive), part)).collect();
    let mut sets = PrimitiveSets::default();
    let mut primitives = Vec::new();
    for (m, mesh) in array(root, "meshes")?.iter().enumerate() {
        let mesh_may_name_vertices = may_name_vertices(mesh);
        for (p, primitive) in items(mesh, "primitives").iter().enumerate() {
            let accessors: Vec<usize> = vertex_accessors(primitive).collect();
            primitives.push(Primitive {
                set: sets.add(&accessors),
                part: parts.get(&(m, p)).copied(),
                indices: primitive.get("indices").and_then(index),
                accessors,
                may_name_vertices: mesh_may_name_vertices || may_name_vertices(primitive),
            });
        }
    }
    let mut by_number: HashMap<usize, usize> = HashMap::new();
    let mut groups: Vec<SceneGroup> = Vec::new();
    for primitive in &primitives {
        let Some(part) = primitive.part else { continue };
        let group = *by_number.entry(sets.root(primitive.set)).or_insert_with(|| {
            groups.push(SceneGroup::new());
            groups.len() - 1
        });
        groups[group].parts.push(part);
    }
    // The set of primitives whose points or lines use the indices; `None` if there are several.
    let mut owners: HashMap<usize, Option<usize>> = HashMap::new();
    for primitive in primitives.iter().filter(|primitive| primitive.part.is_none()) {
        let set = sets.root(primitive.set);
        if let Some(accessor) = primitive.indices {
            owners
                .entry(accessor)
                .and_modify(|owner| *owner = owner.filter(|&one| one == set))
                .or_insert(Some(set));
        }
    }
    let other_uses = OtherUses::of(root)?;
    let names = ExtensionNumbers::of(root);
    for primitive in primitives {
        let set = sets.root(primitive.set);
        let Some(group) = by_number.get(&set).map(|&group| &mut groups[group]) else { continue };
        if names.names_bytes {
            group.keep("an extension refers to bytes of a buffer");
        }
        if primitive.may_name_vertices {
            group.keep("an extension or extras may refer to vertices by index");
        }
        if primitive
            .accessors
            .iter()
            .any(|a| other_uses.of_indices.contains(a) || other_uses.others.contains(a))
        {
            group.keep("one of the accessors has another use");
        }
        if primitive.part.is_none() {
            group.has_others = true;
            group.add_other(primitive.indices, &owners, &other_uses);
        }
        group.accessors.extend(primitive.accessors);
    }
    for group in &mut groups {
        let all = || group.accessors.iter().chain(&group.other_indices).copied();
        let mut views = all().flat_map(|accessor| views_of_accessor(root, accessor));
        if all().any(|a| names.numbers.contains(&a)) || views.any(|view| names.numbers.contains(&view)) {
            group.stay_complete(
                "an extension or extras may refer to their accessors or buffer views by index",
            );
        }
    }
    Ok(groups)
}

/// Finds the vertices used by points and lines. One limit on decoded values covers all groups.
pub(crate) struct OtherVertices<'a> {
    resolver: AccessorResolver<'a>,
    budget: DecodeBudget,
}

impl<'a> OtherVertices<'a> {
    pub(crate) fn of(scene: &'a Scene) -> Self {
        Self {
            resolver: AccessorResolver { root: &scene.document.root, buffers: &scene.buffers },
            budget: DecodeBudget::new(ATTRIBUTE_LIMIT, VERTEX_FACTOR, &scene.buffers),
        }
    }

    /// Marks the vertices of a group that its points and lines use.
    ///
    /// # Errors
    /// The reason why these vertices are unknown.
    pub(crate) fn mark(&mut self, group: &SceneGroup, is_used: &mut [bool]) -> Result<(), String> {
        if group.draws_all {
            is_used.fill(true);
        }
        for &accessor in &group.other_indices {
            let number = Value::from(accessor);
            let reference = Located { value: &number, at: format!("accessors[{accessor}]") };
            let values = self.resolver.values(&reference).map_err(|error| error.to_string())?;
            let indices = values.strip_indices(is_used.len(), &mut self.budget);
            let indices = indices.map_err(|error| error.to_string())?;
            let highest = u32::MAX >> (32 - 8 * values.component.bytes());
            if is_used.len() > highest as usize && indices.runs().count() > 1 {
                return Err("the highest index of points or lines may be a vertex or a restart".into());
            }
            indices.runs().flatten().for_each(|&vertex| is_used[vertex as usize] = true);
        }
        Ok(())
    }
}

/// Returns the scene with renumbered vertices and without the removed ones. A group that cannot
/// change keeps its vertices; [`Renumbering::kept`] states the reason.
pub(crate) fn apply(
    scene: &Scene,
    found: &[SceneGroup],
    renumberings: &mut [Renumbering],
) -> Result<Scene, Error> {
    let resolver = AccessorResolver { root: &scene.document.root, buffers: &scene.buffers };
    let mut budget = DecodeBudget::new(ATTRIBUTE_LIMIT, VERTEX_FACTOR, &scene.buffers);
    let mut arrays: Vec<Vec<AccessorLayout>> = Vec::with_capacity(found.len());
    for (renumbering, group) in renumberings.iter_mut().zip(found) {
        let mut list = Vec::new();
        if renumbering.kept.is_none() && renumbering.changes() {
            let vertex_count = renumbering.order.vertex_count();
            let of_vertices =
                |&accessor| AccessorLayout::of_vertices(&resolver, accessor, vertex_count, &mut budget);
            let layouts: Result<Vec<_>, String> = group.accessors.iter().map(of_vertices).collect();
            let of_indices = |&accessor| AccessorLayout::of_indices(&resolver, accessor, &mut budget);
            let indices: Result<Vec<_>, String> = group.other_indices.iter().map(of_indices).collect();
            match layouts.and_then(|layouts| Ok((layouts, indices?))) {
                Ok((layouts, indices)) => list.extend(layouts.into_iter().chain(indices)),
                Err(why) => renumbering.keep(why)?,
            }
        }
        arrays.push(list);
    }
    let moving: HashSet<usize> = arrays.iter().flatten().map(|array| array.accessor).collect();
    let mut owners = ByteOwners::new(&scene.buffers);
    let all_marked = owners.mark_others(&resolver, &moving, &mut budget)?;
    let shared = if all_marked { "other data uses the same bytes" } else { OVER_BUDGET };
    arrays.iter().for_each(|arrays| owners.mark_group(arrays));
    let mut permuted = PermutedBuffers::new(&scene.buffers);
    let mut shrink = Shrink::default();
    let mut primitives = scene.primitives.clone();
    let groups =
        renumberings.iter_mut().zip(&arrays).zip(found).filter(|((_, arrays), _)| !arrays.is_empty());
    for ((renumbering, arrays), group) in groups {
        if !owners.is_exclusive(arrays) {
            renumbering.keep(shared.into())?;
        } else if let Err(why) = permuted.permute(arrays, renumbering) {
            arrays.iter().for_each(|array| permuted.restore(array));
            renumbering.keep(why)?;
        } else {
            group.parts.iter().for_each(|&part| primitives[part].is_redrawn = true);
            if renumbering.drops() {
                shrink.add(arrays, renumbering, &permuted);
            }
        }
    }
    let (document, folders) = (scene.document.clone(), scene.folders.clone());
    let permuted = Scene { buffers: permuted.finish(), primitives, document, folders };
    shrink.apply(permuted)
}

impl SceneGroup {
    fn new() -> Self {
        Self {
            parts: Vec::new(),
            kept: None,
            complete: None,
            has_others: false,
            draws_all: false,
            other_indices: BTreeSet::new(),
            accessors: BTreeSet::new(),
        }
    }

    fn keep(&mut self, why: &str) {
        self.kept.get_or_insert_with(|| why.to_owned());
    }

    fn stay_complete(&mut self, why: &str) {
        self.complete.get_or_insert_with(|| why.to_owned());
    }

    /// Adds the indices of points or lines.
    fn add_other(
        &mut self,
        indices: Option<usize>,
        owners: &HashMap<usize, Option<usize>>,
        uses: &OtherUses,
    ) {
        match indices {
            None => self.draws_all = true,
            Some(indices) if owners.get(&indices).copied().flatten().is_none() => {
                self.stay_complete("points or lines with other vertices use the same index accessor");
            }
            Some(indices) if uses.of_vertices.contains(&indices) || uses.others.contains(&indices) => {
                self.stay_complete("the indices of points or lines have another use");
            }
            Some(indices) => drop(self.other_indices.insert(indices)),
        }
    }

    /// Returns why the vertices must keep their order, if they must.
    pub(crate) fn why_ordered(&self) -> Option<String> {
        self.kept.clone().or_else(|| self.has_others.then(|| POINTS_OR_LINES.to_owned()))
    }

    /// Returns the accessors with a value per vertex, in ascending order.
    pub(in crate::gltf) fn accessors(&self) -> &BTreeSet<usize> {
        &self.accessors
    }

    /// Returns why no vertex can be removed, if none can.
    pub(crate) fn why_complete(&self) -> Option<String> {
        self.kept.clone().or_else(|| self.complete.clone())
    }
}

/// Iterates over the accessors that have a value per vertex of a primitive.
pub(in crate::gltf) fn vertex_accessors(primitive: &Value) -> impl Iterator<Item = usize> {
    let attributes = primitive.get("attributes").into_iter().flat_map(values);
    let targets = items(primitive, "targets").iter().flat_map(values);
    attributes.chain(targets).filter_map(index)
}

/// Checks whether extensions or extras of a mesh or a primitive may refer to vertices by index.
fn may_name_vertices(object: &Value) -> bool {
    let mut extensions =
        object.get("extensions").and_then(Value::as_object).into_iter().flat_map(Members::iter);
    let names_vertices = |(name, value): (&str, &Value)| match name {
        FEATURES => !items(value, "featureIds").iter().all(has_stored_ids),
        // Extensions that describe the index order are dropped together with the old indices.
        name => {
            !HARMLESS_EXTENSIONS.contains(&name) && !ORDER_EXTENSIONS.contains(&name) && has_number(value)
        }
    };
    object.get("extras").is_some_and(has_number) || extensions.any(names_vertices)
}

/// Checks whether feature ids are stored in an attribute or a texture.
fn has_stored_ids(features: &Value) -> bool {
    ["attribute", "texture"].iter().any(|key| features.get(key).is_some())
}

/// The uses of accessors.
struct OtherUses {
    /// Accessors with indices of primitives.
    of_indices: HashSet<usize>,
    /// Accessors with vertex values.
    of_vertices: HashSet<usize>,
    /// Accessors with any other use.
    others: HashSet<usize>,
}

impl OtherUses {
    fn of(root: &Members) -> Result<Self, Error> {
        let mut of_indices = HashSet::new();
        let mut of_vertices = HashSet::new();
        for primitive in array(root, "meshes")?.iter().flat_map(|mesh| items(mesh, "primitives")) {
            of_indices.extend(primitive.get("indices").and_then(index));
            of_vertices.extend(vertex_accessors(primitive));
        }
        let mut others = skin_and_animation_accessors(root)?;
        for node in array(root, "nodes")? {
            // Mesh instances have their own attributes.
            let attributes =
                node.get("extensions").into_iter().flat_map(values).filter_map(|e| e.get("attributes"));
            others.extend(attributes.flat_map(values).filter_map(index));
        }
        Ok(Self { of_indices, of_vertices, others })
    }
}

/// Disjoint sets of primitives, joined by shared accessors.
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
