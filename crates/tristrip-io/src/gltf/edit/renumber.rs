//! The vertices of a scene with new numbers, or fewer of them: their values are permuted in the buffers and, where vertices are
//! dropped, cut off behind those that stay.
//!
//! ```text
//! values of an accessor    a b c d e f      used: b d e
//! permuted                 b d e . . .      in the bytes that they have
//! cut off                  b d e            the accessor has another count, and the buffer fewer bytes
//! ```
//! # Algorithm
//! 1. Primitives with an accessor in common, as an attribute or in a morph target, form one group with one order.
//! 2. A group keeps its vertices where something else depends on their numbers: another use of one of the accessors,
//!    extensions or extras of the primitives, accessors or views that hold whole numbers of unknown meaning, or bytes that
//!    belong to other data too. It keeps their order where points or lines use them. To drop vertices, the indices of points and
//!    lines are changed as well, and no extension or extras anywhere may hold the number of one of the accessors or views.
//! 3. Every value moves to the slot of its new index, within its accessor, whether a view holds one accessor or several
//!    interleaved ones. A sparse accessor lists the new indices in ascending order.
//! 4. The moved values are compared with the old ones. Accessors that overlap in any way other than by the same vertices
//!    differ there, and their group is restored.
//! 5. Where vertices are dropped, [`crate::gltf::edit::shrink`] cuts the accessors off and removes the bytes.
//!
//! # Complexity
//! Linear in the bytes of the accessors, which have the same limit as decoded ones. Memory: two bytes for each byte of the
//! buffers that change.

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

/// Extensions of primitives that do not refer to vertices by number.
const HARMLESS_EXTENSIONS: [&str; 2] = ["KHR_materials_variants", "EXT_structural_metadata"];

/// The extension for features of vertices: identified by an attribute or texture, or else by vertex number.
const FEATURES: &str = "EXT_mesh_features";

/// Why the vertices keep their order where points or lines are drawn from them.
const POINTS_OR_LINES: &str = "points or lines use the same vertices";

/// Parts over the same vertices.
pub(crate) struct SceneGroup {
    pub(crate) parts: Vec<usize>,
    /// Why the vertices must keep their numbers.
    kept: Option<String>,
    /// Why none of the vertices can be dropped, where only that is impossible.
    complete: Option<String>,
    /// Whether there are points or lines over the vertices.
    has_others: bool,
    /// Whether points or lines without indices draw all vertices.
    draws_all: bool,
    /// The accessors with the indices of points and lines.
    other_indices: BTreeSet<usize>,
    /// The accessors with a value for each vertex.
    accessors: BTreeSet<usize>,
}

/// A primitive of the document.
struct Primitive {
    /// The number of its set of primitives with accessors in common.
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
/// The scene has another number of parts.
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
    // The set of primitives whose points or lines have the indices; `None` for several sets.
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
            group.keep("an extension names bytes of a buffer");
        }
        if primitive.may_name_vertices {
            group.keep("an extension or extras may refer to vertices by number");
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
                "an extension or extras may refer to their accessors or buffer views by number",
            );
        }
    }
    Ok(groups)
}

/// Finds the vertices that points and lines draw, within the limit of decoded values for all groups together.
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

    /// Marks the vertices of a group that its points and lines draw.
    ///
    /// # Errors
    /// Returns why these vertices are not known.
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
                return Err("an index of points or lines is either a vertex or a restart".into());
            }
            indices.runs().flatten().for_each(|&vertex| is_used[vertex as usize] = true);
        }
        Ok(())
    }
}

/// Returns the scene with the new numbers of each group's vertices, without those that are dropped. A group for which that is not
/// possible keeps its vertices, with the reason in [`Renumbering::kept`].
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
    let shared = if all_marked { "their bytes belong to other data too" } else { OVER_BUDGET };
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
                self.stay_complete("points or lines over other vertices have the same indices");
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

    /// Returns the accessors with a value for each vertex, ascending.
    pub(in crate::gltf) fn accessors(&self) -> &BTreeSet<usize> {
        &self.accessors
    }

    /// Returns why no vertex can be dropped, if none can.
    pub(crate) fn why_complete(&self) -> Option<String> {
        self.kept.clone().or_else(|| self.complete.clone())
    }
}

/// Iterates over the accessors that have a value for each vertex of a primitive.
pub(in crate::gltf) fn vertex_accessors(primitive: &Value) -> impl Iterator<Item = usize> {
    let attributes = primitive.get("attributes").into_iter().flat_map(values);
    let targets = items(primitive, "targets").iter().flat_map(values);
    attributes.chain(targets).filter_map(index)
}

/// Checks whether extensions or extras of a mesh or a primitive may refer to vertices by number.
fn may_name_vertices(object: &Value) -> bool {
    let mut extensions =
        object.get("extensions").and_then(Value::as_object).into_iter().flat_map(Members::iter);
    let names_vertices = |(name, value): (&str, &Value)| match name {
        FEATURES => !items(value, "featureIds").iter().all(has_stored_ids),
        // Extensions about the index order are dropped with the old indices.
        name => {
            !HARMLESS_EXTENSIONS.contains(&name) && !ORDER_EXTENSIONS.contains(&name) && has_number(value)
        }
    };
    object.get("extras").is_some_and(has_number) || extensions.any(names_vertices)
}

/// Checks whether the ids of a set of features are stored in an attribute or texture.
fn has_stored_ids(features: &Value) -> bool {
    ["attribute", "texture"].iter().any(|key| features.get(key).is_some())
}

/// The uses of accessors.
struct OtherUses {
    /// Those with indices of primitives.
    of_indices: HashSet<usize>,
    /// Those with values of vertices.
    of_vertices: HashSet<usize>,
    /// Those with a use of another kind.
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
            // Instances of a mesh have attributes of their own.
            let attributes =
                node.get("extensions").into_iter().flat_map(values).filter_map(|e| e.get("attributes"));
            others.extend(attributes.flat_map(values).filter_map(index));
        }
        Ok(Self { of_indices, of_vertices, others })
    }
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
