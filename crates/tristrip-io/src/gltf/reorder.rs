//! Vertices of a scene in another order: the bytes of their values change places, and nothing else of the document changes.
//!
//! # Algorithm
//! 1. Primitives that have an accessor in common, as an attribute or in a morph target, are one group with one order.
//! 2. A group keeps its vertices as they are where somebody else counts on their places: points and lines over them, another
//!    use of one of its accessors, extensions or extras of its primitives, accessors or views that hold whole numbers of
//!    unknown meaning, or bytes that belong to other data too.
//! 3. Every value moves to the place of its new number, within its accessor: offsets, strides, counts and bounds stay, whether a
//!    view holds one accessor or several interleaved. A sparse accessor names its vertices by their new numbers, rising.
//! 4. What was moved is compared with where it came from; accessors that overlap in another way than by the same vertices
//!    would differ there, and their group is put back.
//!
//! # Complexity
//! Linear in the bytes of the accessors, which are bounded as those that are decoded; two bytes for each byte of the buffers that change.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::ops::Range;

use serde_json::{Map, Value};
use tristrip::strip::VertexOrder;

use super::Scene;
use super::accessor::{Budget, Source};
use super::buffer::Bytes;
use super::document::{Place, array, index, items, values};
use super::keep::names_bytes;
use super::read::ORDER_EXTENSIONS;
use crate::error::Error;
use crate::reorder::VertexGroup;

/// Extensions of primitives that say nothing of the numbers of vertices.
const HARMLESS_EXTENSIONS: [&str; 2] = ["KHR_materials_variants", "EXT_structural_metadata"];

/// Features by vertex: by an attribute or texture, or else by the numbers of the vertices.
const FEATURES: &str = "EXT_mesh_features";

/// Bytes of accessors that may be looked at for each byte of the buffers, beside the constant.
const FACTOR: u64 = 16;

const TOO_MUCH: &str = "there is more in the buffers than the limits allow to look at";

/// Parts over the same vertices.
pub(crate) struct SceneGroup {
    pub(crate) parts: Vec<usize>,
    /// Why the vertices must keep their numbers.
    pub(crate) kept: Option<String>,
    /// What has a value for each vertex.
    accessors: BTreeSet<usize>,
}

/// Finds the groups of a scene's parts, in the order of their first ones.
///
/// # Errors
/// The scene is that of another number of parts.
pub(crate) fn groups(scene: &Scene, part_count: usize) -> Result<Vec<SceneGroup>, Error> {
    scene.check_part_count(part_count)?;
    let root = &scene.root;
    let parts: HashMap<(usize, usize), usize> =
        scene.primitives.iter().enumerate().map(|(part, at)| ((at.mesh, at.primitive), part)).collect();
    let mut joined = Joined::default();
    let mut primitives = Vec::new();
    for (m, mesh) in array(root, "meshes")?.iter().enumerate() {
        for (p, primitive) in items(mesh, "primitives").iter().enumerate() {
            let accessors: Vec<usize> = vertex_values(primitive).collect();
            let number = joined.add(&accessors);
            primitives.push((number, parts.get(&(m, p)).copied(), accessors, may_count(mesh, primitive)));
        }
    }
    let others = other_uses(root)?;
    let bytes_named = names_bytes(root);
    let mut by_number: HashMap<usize, usize> = HashMap::new();
    let mut groups: Vec<SceneGroup> = Vec::new();
    for (number, part, ..) in &primitives {
        let Some(part) = *part else { continue };
        let group = *by_number.entry(joined.root(*number)).or_insert_with(|| {
            groups.push(SceneGroup { parts: Vec::new(), kept: None, accessors: BTreeSet::new() });
            groups.len() - 1
        });
        groups[group].parts.push(part);
    }
    for (number, part, accessors, counts) in primitives {
        let Some(&group) = by_number.get(&joined.root(number)) else { continue };
        let group = &mut groups[group];
        if bytes_named {
            group.keep("an extension names bytes of a buffer");
        }
        if part.is_none() {
            group.keep("points or lines use the same vertices");
        }
        if counts {
            group.keep("an extension or extras may name vertices by their numbers");
        }
        if accessors.iter().any(|accessor| others.contains(accessor)) {
            group.keep("one of the accessors has another use");
        }
        group.accessors.extend(accessors);
    }
    Ok(groups)
}

/// Gives the scene with the values of each group's vertices in its order. A group for which that cannot be done keeps its
/// vertices, and says why.
pub(crate) fn apply(scene: &Scene, found: &[SceneGroup], groups: &mut [VertexGroup]) -> Result<Scene, Error> {
    let source = Source { root: &scene.root, buffers: &scene.buffers };
    let mut budget = Budget::new(&scene.buffers, FACTOR);
    let mut arrays: Vec<Vec<Array>> = Vec::with_capacity(groups.len());
    for (group, found) in groups.iter_mut().zip(found) {
        let mut list = Vec::new();
        if group.kept.is_none() && group.order.moved_count() > 0 {
            match Array::of_group(&source, found, group.order.vertex_count(), &mut budget) {
                Ok(found) => list = found,
                Err(why) => group.keep(why)?,
            }
        }
        arrays.push(list);
    }
    let moving: HashSet<usize> = (found.iter().zip(&arrays))
        .filter(|(_, arrays)| !arrays.is_empty())
        .flat_map(|(group, _)| group.accessors.iter().copied())
        .collect();
    let mut claims = Claims::new(&scene.buffers);
    let all_known = claims.mark_others(&source, &moving, &mut budget)?;
    let shared = if all_known { "their bytes belong to other data too" } else { TOO_MUCH };
    arrays.iter().for_each(|arrays| claims.mark_group(arrays));
    let mut moves = Moving { old: &scene.buffers, new: vec![None; scene.buffers.len()] };
    for (group, arrays) in groups.iter_mut().zip(&arrays).filter(|(_, arrays)| !arrays.is_empty()) {
        if !claims.are_free(arrays) {
            group.keep(shared.into())?;
        } else if let Err(why) = moves.group(arrays, &group.order) {
            arrays.iter().for_each(|array| moves.restore(array));
            group.keep(why)?;
        }
    }
    let buffers = (scene.buffers.iter().zip(moves.new))
        .map(|(old, new)| new.map_or_else(|| old.clone(), Bytes::from))
        .collect();
    Ok(Scene { buffers, ..scene.clone() })
}

impl SceneGroup {
    fn keep(&mut self, why: &str) {
        self.kept.get_or_insert_with(|| why.to_owned());
    }
}

/// Walks over the accessors that have a value for each vertex of a primitive.
fn vertex_values(primitive: &Value) -> impl Iterator<Item = usize> {
    let attributes = primitive.get("attributes").into_iter().flat_map(values);
    let targets = items(primitive, "targets").iter().flat_map(values);
    attributes.chain(targets).filter_map(index)
}

/// Tells whether what a mesh or primitive says beside the specification may mean numbers of vertices.
fn may_count(mesh: &Value, primitive: &Value) -> bool {
    [mesh, primitive].into_iter().any(|object| {
        let extensions = object.get("extensions").and_then(Value::as_object).into_iter().flatten();
        let counts = |(name, value): (&String, &Value)| match name.as_str() {
            FEATURES => !items(value, "featureIds").iter().all(are_stored),
            // The latter go with the old indices.
            name => {
                !HARMLESS_EXTENSIONS.contains(&name) && !ORDER_EXTENSIONS.contains(&name) && has_number(value)
            }
        };
        object.get("extras").is_some_and(has_number) || extensions.into_iter().any(counts)
    })
}

/// Tells whether the ids of a set of features stand in an attribute or texture.
fn are_stored(features: &Value) -> bool {
    ["attribute", "texture"].iter().any(|key| features.get(*key).is_some())
}

/// Tells whether there is a whole number in a value.
fn has_number(value: &Value) -> bool {
    match value {
        Value::Array(items) => items.iter().any(has_number),
        Value::Object(members) => members.values().any(has_number),
        other => index(other).is_some(),
    }
}

/// Gives the accessors that are used otherwise than for vertices.
fn other_uses(root: &Map<String, Value>) -> Result<HashSet<usize>, Error> {
    let mut used = HashSet::new();
    for mesh in array(root, "meshes")? {
        used.extend(items(mesh, "primitives").iter().filter_map(|p| p.get("indices")).filter_map(index));
    }
    for skin in array(root, "skins")? {
        used.extend(skin.get("inverseBindMatrices").and_then(index));
    }
    for animation in array(root, "animations")? {
        for sampler in items(animation, "samplers") {
            used.extend(["input", "output"].iter().filter_map(|key| sampler.get(*key)).filter_map(index));
        }
    }
    for node in array(root, "nodes")? {
        // Copies of a mesh have attributes of their own.
        let attributes =
            node.get("extensions").into_iter().flat_map(values).filter_map(|e| e.get("attributes"));
        used.extend(attributes.flat_map(values).filter_map(index));
    }
    Ok(used)
}

/// Primitives joined over the accessors that they share.
#[derive(Default)]
struct Joined {
    parents: Vec<usize>,
    by_accessor: HashMap<usize, usize>,
}

impl Joined {
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

/// Values at equal distances within a buffer.
#[derive(Clone, Copy)]
struct Slots {
    buffer: usize,
    start: usize,
    stride: usize,
    element: usize,
    count: usize,
}

impl Slots {
    /// Gives the place of a view's values; reading has checked that they lie within.
    fn of(root: &Map<String, Value>, holder: &Value, element: usize, count: usize) -> Option<Self> {
        let view = array(root, "bufferViews").ok()?.get(holder.get("bufferView").and_then(index)?)?;
        let field = |object: &Value, name| object.get(name).and_then(index);
        Some(Self {
            buffer: field(view, "buffer")?,
            start: field(view, "byteOffset").unwrap_or(0) + field(holder, "byteOffset").unwrap_or(0),
            stride: field(view, "byteStride").unwrap_or(element),
            element,
            count,
        })
    }

    fn packed(self) -> Self {
        Self { stride: self.element, ..self }
    }

    fn range(&self, place: usize) -> Range<usize> {
        let start = self.start + place * self.stride;
        start..start + self.element
    }

    fn ranges(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let slots = *self;
        (0..slots.count).map(move |place| slots.range(place))
    }
}

/// Where the values of an accessor stand.
struct Array {
    count: usize,
    /// `None` for zeros.
    base: Option<Slots>,
    /// Indices and values of the vertices that differ from the base.
    sparse: Option<[Slots; 2]>,
}

impl Array {
    /// Finds the values of all accessors of a group.
    fn of_group(
        source: &Source<'_>,
        group: &SceneGroup,
        vertex_count: usize,
        budget: &mut Budget,
    ) -> Result<Vec<Self>, String> {
        let each = group.accessors.iter().map(|&accessor| {
            let array = Self::find(source, accessor, budget)?;
            if array.count != vertex_count {
                return Err(format!("accessors[{accessor}] has not a value for each vertex"));
            }
            Ok(array)
        });
        each.collect()
    }

    /// Finds the values of an accessor, or says why that cannot be done.
    fn find(source: &Source<'_>, accessor: usize, budget: &mut Budget) -> Result<Self, String> {
        let object = array(source.root, "accessors").ok().and_then(|all| all.get(accessor));
        let object = object.ok_or("an accessor is missing")?;
        // Finding them reads the sparse indices.
        let sparse_count = object.get("sparse").and_then(|sparse| index(sparse.get("count")?)).unwrap_or(0);
        budget.take(sparse_count, size_of::<u32>()).map_err(|_| TOO_MUCH)?;
        let number = Value::from(accessor);
        let place = Place { value: &number, at: format!("accessors[{accessor}]") };
        let decoded = source.values(&place).map_err(|error| error.to_string())?;
        let (count, element) = (decoded.count, decoded.element);
        let view = |holder: &Value| {
            array(source.root, "bufferViews").ok()?.get(holder.get("bufferView").and_then(index)?)
        };
        let mut holders = vec![object];
        let sparse = object.get("sparse").and_then(|sparse| {
            let count = sparse.get("count").and_then(index)?;
            let (indices, values) = (sparse.get("indices")?, sparse.get("values")?);
            holders.extend([indices, values]);
            let width = match indices.get("componentType").and_then(index)? {
                5121 => 1,
                5123 => 2,
                _ => 4,
            };
            let slots = |holder, element| Slots::of(source.root, holder, element, count).map(Slots::packed);
            Some([slots(indices, width)?, slots(values, element)?])
        });
        let spoken = |object: &Value| {
            ["extensions", "extras"].iter().filter_map(|key| object.get(*key)).any(has_number)
        };
        if holders.iter().any(|holder| spoken(holder) || view(holder).is_some_and(spoken)) {
            return Err(
                "an extension or extras of an accessor or view may name vertices by their numbers".into()
            );
        }
        let base = Slots::of(source.root, object, element, count);
        let array = Self { count, base, sparse };
        for slots in array.slots() {
            let taken = budget.take(slots.count, slots.element);
            taken.map_err(|_| TOO_MUCH)?;
        }
        Ok(array)
    }

    fn slots(&self) -> impl Iterator<Item = Slots> + use<> {
        self.base.into_iter().chain(self.sparse.into_iter().flatten())
    }
}

const OTHER: u8 = 1;
const ONE_GROUP: u8 = 2;
const TWO_GROUPS: u8 = 4;

/// Whose each byte of the buffers is.
struct Claims(Vec<Vec<u8>>);

impl Claims {
    fn new(buffers: &[Bytes]) -> Self {
        Self(buffers.iter().map(|bytes| vec![0; bytes.len()]).collect())
    }

    /// Marks the bytes of everything that stays where it is; tells whether that was not too much.
    fn mark_others(
        &mut self,
        source: &Source<'_>,
        moving: &HashSet<usize>,
        budget: &mut Budget,
    ) -> Result<bool, Error> {
        let mut of_accessors = HashSet::new();
        let mut whole = HashSet::new();
        for (number, accessor) in array(source.root, "accessors")?.iter().enumerate() {
            let sparse = accessor.get("sparse");
            let holders =
                [Some(accessor), sparse.and_then(|s| s.get("indices")), sparse.and_then(|s| s.get("values"))];
            let views =
                || holders.iter().flatten().filter_map(|holder| holder.get("bufferView").and_then(index));
            of_accessors.extend(views());
            if moving.contains(&number) {
                continue;
            }
            match Array::find(source, number, budget) {
                Ok(array) => array.slots().for_each(|slots| self.mark(&slots, OTHER)),
                Err(_) => whole.extend(views()),
            }
        }
        for image in array(source.root, "images")? {
            whole.extend(image.get("bufferView").and_then(index));
        }
        let views = array(source.root, "bufferViews")?;
        whole.extend((0..views.len()).filter(|view| !of_accessors.contains(view)));
        for view in whole.into_iter().filter_map(|view| views.get(view)) {
            let field = |name| view.get(name).and_then(index);
            let (Some(buffer), Some(element)) = (field("buffer"), field("byteLength")) else { continue };
            let start = field("byteOffset").unwrap_or(0);
            if budget.take(1, element).is_err() {
                self.0.iter_mut().for_each(|bytes| bytes.fill(OTHER));
                return Ok(false);
            }
            self.mark(&Slots { buffer, start, stride: element, element, count: 1 }, OTHER);
        }
        Ok(true)
    }

    /// Marks the bytes of one group.
    fn mark_group(&mut self, arrays: &[Array]) {
        for slots in arrays.iter().flat_map(Array::slots) {
            for byte in self.bytes(&slots).filter(|byte| **byte & ONE_GROUP != 0) {
                *byte |= TWO_GROUPS;
            }
        }
        arrays.iter().flat_map(Array::slots).for_each(|slots| self.mark(&slots, ONE_GROUP));
    }

    /// Tells whether a group's bytes are its own.
    fn are_free(&mut self, arrays: &[Array]) -> bool {
        let mut slots = arrays.iter().flat_map(Array::slots);
        slots.all(|slots| self.bytes(&slots).all(|byte| *byte == ONE_GROUP))
    }

    fn mark(&mut self, slots: &Slots, as_whose: u8) {
        self.bytes(slots).for_each(|byte| *byte |= as_whose);
    }

    fn bytes(&mut self, slots: &Slots) -> impl Iterator<Item = &mut u8> {
        let bytes = self.0.get_mut(slots.buffer).and_then(|bytes| bytes.get_mut(slots.start..));
        let (element, count) = (slots.element, slots.count);
        let values = bytes.into_iter().flat_map(|bytes| bytes.chunks_mut(slots.stride.max(1))).take(count);
        values.flat_map(move |value| value.iter_mut().take(element))
    }
}

/// Buffers of which the values change places.
struct Moving<'a> {
    old: &'a [Bytes],
    /// `None` for a buffer that stays as it is.
    new: Vec<Option<Vec<u8>>>,
}

impl Moving<'_> {
    /// Moves the values of a group, and looks whether all of them arrived.
    fn group(&mut self, arrays: &[Array], order: &VertexOrder) -> Result<(), String> {
        for array in arrays {
            self.array(array, order)?;
        }
        if arrays.iter().all(|array| self.arrived(array, order)) {
            return Ok(());
        }
        Err("accessors overlap in another way than by the same vertices".into())
    }

    fn array(&mut self, array: &Array, order: &VertexOrder) -> Result<(), String> {
        if let Some(base) = array.base {
            let (old, new) = self.buffer(base.buffer).ok_or("a buffer is missing")?;
            for (new_place, &old_place) in base.ranges().zip(order.new_to_old()) {
                new[new_place].copy_from_slice(&old[base.range(old_place as usize)]);
            }
        }
        let Some([indices, values]) = array.sparse else { return Ok(()) };
        let renamed = self.renamed(&indices, order);
        let highest = renamed.last().map_or(0, |&(vertex, _)| u64::from(vertex));
        if highest >> (8 * indices.element) > 0 {
            return Err("the new numbers do not fit the index type of a sparse accessor".into());
        }
        for (place, (vertex, from)) in renamed.into_iter().enumerate() {
            let (_, new) = self.buffer(indices.buffer).ok_or("a buffer is missing")?;
            new[indices.range(place)].copy_from_slice(&vertex.to_le_bytes()[..indices.element]);
            let (old, new) = self.buffer(values.buffer).ok_or("a buffer is missing")?;
            new[values.range(place)].copy_from_slice(&old[values.range(from)]);
        }
        Ok(())
    }

    /// Gives the new numbers that sparse indices stand for, rising, each with the place of its value.
    fn renamed(&self, indices: &Slots, order: &VertexOrder) -> Vec<(u32, usize)> {
        let Some(old) = self.old.get(indices.buffer).map(Bytes::as_slice) else { return Vec::new() };
        let number = |range: Range<usize>| old[range].iter().rev().fold(0, |n, &b| n << 8 | u32::from(b));
        let new = |vertex: u32| order.old_to_new().get(vertex as usize).copied().unwrap_or(vertex);
        let mut renamed: Vec<_> = indices.ranges().map(number).map(new).zip(0..).collect();
        renamed.sort_unstable();
        renamed
    }

    /// Tells whether the values of an accessor stand in the new order.
    fn arrived(&self, array: &Array, order: &VertexOrder) -> bool {
        let at = |slots: &Slots, new: usize, old: usize| {
            let bytes = self.old.get(slots.buffer).map(Bytes::as_slice);
            let moved = self.new.get(slots.buffer).and_then(Option::as_deref).or(bytes);
            moved.and_then(|b| b.get(slots.range(new))) == bytes.and_then(|b| b.get(slots.range(old)))
        };
        let base = array.base.is_none_or(|base| {
            order.new_to_old().iter().enumerate().all(|(new, &old)| at(&base, new, old as usize))
        });
        let sparse = array.sparse.is_none_or(|[indices, values]| {
            let named = |place: usize, vertex: u32| {
                let bytes = self.new.get(indices.buffer).and_then(Option::as_deref);
                bytes.is_some_and(|b| b[indices.range(place)] == vertex.to_le_bytes()[..indices.element])
            };
            let renamed = self.renamed(&indices, order);
            renamed
                .into_iter()
                .enumerate()
                .all(|(place, (vertex, from))| named(place, vertex) && at(&values, place, from))
        });
        base && sparse
    }

    /// Puts back what stood in the places of an accessor; nobody else has them.
    fn restore(&mut self, array: &Array) {
        for slots in array.slots() {
            let Some((old, new)) = self.buffer(slots.buffer) else { continue };
            for range in slots.ranges() {
                new[range.clone()].copy_from_slice(&old[range]);
            }
        }
    }

    /// Gives a buffer as it was, and as it will be.
    fn buffer(&mut self, buffer: usize) -> Option<(&[u8], &mut Vec<u8>)> {
        let old = self.old.get(buffer)?.as_slice();
        Some((old, self.new.get_mut(buffer)?.get_or_insert_with(|| old.to_vec())))
    }
}
