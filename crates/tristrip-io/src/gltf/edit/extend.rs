//! Adds vertices to a scene. The accessors of a group get new buffer views with all values of the
//! old and the new vertices.
//!
//! # Algorithm
//! 1. A group can be extended if no vertex has to keep its index, no other data uses its accessors,
//!    and the values are within a limit. The first two conditions also apply when vertices are
//!    removed (`renumber.rs`).
//! 2. The values of each accessor are written consecutively, in the order of `sources`, to a new
//!    buffer. Sparse accessors become dense.
//! 3. The accessor keeps its index. Its bounds are recomputed if it has new values. It keeps its
//!    view if nothing else uses that view; otherwise it gets a new one.
//! 4. The bytes of the old values are deleted in the same way as the bytes of removed vertices.
//!
//! # Complexity
//! Linear in the bytes of the buffers and of the extended accessors.

use std::collections::{HashMap, HashSet};

use serde_json::json;
use tristrip::{Attribute, AttributeData, Mesh};

use crate::edit::new_values::{NewValues, NewVertices};
use crate::error::Error;
use crate::gltf::document::accessor::AccessorResolver;
use crate::gltf::document::budget::{ATTRIBUTE_LIMIT, DecodeBudget};
use crate::gltf::document::byte_ranges::SharedBytes;
use crate::gltf::document::json::{Members, Value};
use crate::gltf::document::references::{ExtensionNumbers, views_of_accessor};
use crate::gltf::document::scene::Scene;
use crate::gltf::document::spec::ARRAY_BUFFER;
use crate::gltf::document::spec::ComponentType;
use crate::gltf::document::{Located, array, index, items, list_mut, values};
use crate::gltf::edit::permute::{AccessorLayout, ByteOwners, VERTEX_FACTOR};
use crate::gltf::edit::renumber::{SceneGroup, groups};
use crate::gltf::edit::shrink::Shrink;
use crate::le_bytes::append;
use crate::model::Model;

/// The alignment of vertex values.
const ALIGNMENT: usize = 4;

/// A group that gets vertices.
pub(crate) struct Extension<'a> {
    pub(crate) group: &'a SceneGroup,
    /// The old vertex that each vertex is copied from.
    pub(crate) sources: Vec<u32>,
}

/// Returns for each part why its vertices cannot get new values. If the scene is not written
/// (`is_written` is false), only morph targets that change these values count.
pub(crate) fn fixed_parts(
    scene: &Scene,
    model: &Model,
    values: NewValues,
    is_written: bool,
) -> Result<Vec<Option<String>>, Error> {
    let mut fixed: Vec<Option<String>> =
        (0..model.parts.len()).map(|part| morphs(scene, part, values)).collect();
    if !is_written {
        return Ok(fixed);
    }
    let (shared, root) = (shared_roles(scene)?, &scene.document.root);
    let component = |a: usize| index(array(root, "accessors").ok()?.get(a)?.get("componentType")?);
    let is_float = |a: usize| component(a) == Some(ComponentType::F32.code() as usize);
    for (part, why) in fixed.iter_mut().enumerate() {
        let attributes = primitive(scene, part).and_then(|primitive| primitive.get("attributes"));
        let of = |name: &&str| attributes.and_then(|attributes| index(attributes.get(name)?));
        let accessors = || values.names().iter().filter_map(of);
        if why.is_none() && accessors().any(|a| shared.contains(&a)) {
            *why = Some("other values share their accessor".into());
        }
        if why.is_none() && values == NewValues::Positions && !accessors().all(is_float) {
            *why = Some("they are stored as integers".into());
        }
    }
    let resolver = AccessorResolver { root: &scene.document.root, buffers: &scene.buffers };
    let mut budget = DecodeBudget::new(ATTRIBUTE_LIMIT, VERTEX_FACTOR, &scene.buffers);
    for group in groups(scene, model.parts.len())? {
        let meshes: Vec<&Mesh> = group.parts.iter().map(|&part| &model.parts[part].mesh).collect();
        let vertex_count = meshes.iter().map(|mesh| mesh.vertex_count()).max().unwrap_or(0);
        let most = vertex_count + meshes.iter().map(|mesh| mesh.faces().corner_count()).sum::<usize>();
        let differ = meshes.iter().any(|mesh| mesh.vertex_count() != vertex_count);
        let several = differ.then(|| "parts with shared accessors have different vertex counts".into());
        let mut why = group.why_complete().or(several);
        for &accessor in group.accessors() {
            if why.is_none() {
                why = check_accessor(&resolver, accessor, vertex_count, most, &mut budget).err();
            }
        }
        if let Some(why) = why {
            for &part in &group.parts {
                fixed[part].get_or_insert_with(|| why.clone());
            }
        }
    }
    Ok(fixed)
}

/// Checks that an accessor can be decoded and stays within the budget with the new vertices.
fn check_accessor(
    resolver: &AccessorResolver<'_>,
    accessor: usize,
    vertex_count: usize,
    most: usize,
    budget: &mut DecodeBudget,
) -> Result<(), String> {
    AccessorLayout::of_vertices(resolver, accessor, vertex_count, budget)?;
    let number = Value::from(accessor);
    let reference = Located { value: &number, at: format!("accessors[{accessor}]") };
    let element = resolver.values(&reference).map_err(|error| error.to_string())?.element;
    budget.charge("values of new vertices", most, element).map_err(|error| error.to_string())
}

/// Returns the accessors of vertex values that are used for more than one attribute.
fn shared_roles(scene: &Scene) -> Result<HashSet<usize>, Error> {
    let mut roles: HashMap<usize, &str> = HashMap::new();
    let mut shared = HashSet::new();
    for primitive in array(&scene.document.root, "meshes")?.iter().flat_map(|mesh| items(mesh, "primitives"))
    {
        let attributes = primitive.get("attributes").and_then(Value::as_object);
        let of_vertices = attributes.into_iter().flat_map(Members::iter);
        let of_targets = items(primitive, "targets").iter().flat_map(values).map(|value| ("a target", value));
        for (role, value) in of_vertices.chain(of_targets) {
            let Some(accessor) = index(value) else { continue };
            if *roles.entry(accessor).or_insert(role) != role {
                shared.insert(accessor);
            }
        }
    }
    Ok(shared)
}

/// Returns why values of a part must not change, if a morph target changes them.
fn morphs(scene: &Scene, part: usize, values: NewValues) -> Option<String> {
    let targets = items(primitive(scene, part)?, "targets");
    let changes = targets.iter().any(|target| values.names().iter().any(|name| target.get(name).is_some()));
    changes.then(|| "a morph target changes them".into())
}

fn primitive(scene: &Scene, part: usize) -> Option<&Value> {
    let source = scene.primitives.get(part)?;
    let mesh = array(&scene.document.root, "meshes").ok()?.get(source.mesh)?;
    items(mesh, "primitives").get(source.primitive)
}

/// Extends groups. `meshes` are the parts with their new vertices; `added` has the values of the
/// new vertices, and `first` the index of the first.
pub(crate) fn apply(
    scene: &Scene,
    extensions: &[Extension<'_>],
    meshes: &[Mesh],
    added: &[Option<NewVertices>],
    first: &[Option<u32>],
) -> Result<Scene, Error> {
    let resolver = AccessorResolver { root: &scene.document.root, buffers: &scene.buffers };
    let mut extended = scene.clone();
    let freed = freed_bytes(scene, extensions)?;
    let mut writer = ValueWriter::of(scene)?;
    let mut shrink = Shrink::default();
    for extension in extensions {
        let rebuilt = rebuilt_values(scene, extension.group, meshes, added, first);
        for &accessor in extension.group.accessors() {
            let number = Value::from(accessor);
            let values =
                resolver.values(&Located { value: &number, at: format!("accessors[{accessor}]") })?;
            let (element, stride) = (values.element, values.element.next_multiple_of(ALIGNMENT));
            let start = writer.bytes.len();
            writer.copy(&values.raw()?, element, &extension.sources)?;
            for (first, new) in rebuilt.get(&accessor).into_iter().flatten() {
                let rows = writer.bytes[start + first * stride..].chunks_exact_mut(stride);
                rows.zip(new.chunks_exact(element))
                    .for_each(|(row, new)| row[..element].copy_from_slice(new));
            }
            let view = json!({
                "buffer": scene.buffers.len(),
                "byteOffset": start,
                "byteLength": writer.bytes.len() - start,
                "byteStride": stride,
                "target": ARRAY_BUFFER,
            });
            let view = writer.put_view(&mut extended.document.root, accessor, view.into())?;
            update(&mut extended.document.root, accessor, view, extension.sources.len())?;
            if rebuilt.contains_key(&accessor) {
                shrink.change(accessor);
            }
        }
    }
    clear_unused_views(&mut extended.document.root, &writer.uses)?;
    list_mut(&mut extended.document.root, "buffers")?.push(json!({"byteLength": writer.bytes.len()}).into());
    extended.buffers.push(SharedBytes::from(writer.bytes));
    freed.iter().for_each(|layout| shrink.free(layout));
    shrink.apply(extended)
}

/// Removes the stride of views that accessors no longer use: most of their bytes are removed, and a
/// stride must fit into the rest.
fn clear_unused_views(root: &mut Members, uses: &HashMap<usize, usize>) -> Result<(), Error> {
    let used: HashSet<usize> =
        (0..array(root, "accessors")?.len()).flat_map(|a| views_of_accessor(root, a)).collect();
    for (view, members) in list_mut(root, "bufferViews")?.iter_mut().enumerate() {
        if uses.contains_key(&view) && !used.contains(&view) {
            members.as_object_mut().into_iter().for_each(|members| members.remove("byteStride"));
        }
    }
    Ok(())
}

/// Returns the old locations of the values of extended accessors, except bytes that other data uses
/// too.
fn freed_bytes(scene: &Scene, extensions: &[Extension<'_>]) -> Result<Vec<AccessorLayout>, Error> {
    let resolver = AccessorResolver { root: &scene.document.root, buffers: &scene.buffers };
    let mut budget = DecodeBudget::new(ATTRIBUTE_LIMIT, VERTEX_FACTOR, &scene.buffers);
    let all: HashSet<usize> = extensions.iter().flat_map(|e| e.group.accessors()).copied().collect();
    let mut owners = ByteOwners::new(&scene.buffers);
    owners.mark_others(&resolver, &all, &mut budget)?;
    let mut freed = Vec::new();
    for extension in extensions {
        let find = |&accessor| AccessorLayout::find(&resolver, accessor, &mut budget).ok();
        let layouts: Option<Vec<_>> = extension.group.accessors().iter().map(find).collect();
        freed.extend(layouts.into_iter().flatten().filter(|layout| !owners.has_others(layout)));
    }
    Ok(freed)
}

/// Returns the bytes of new values by accessor, each with the first vertex to which they apply.
fn rebuilt_values(
    scene: &Scene,
    group: &SceneGroup,
    meshes: &[Mesh],
    added: &[Option<NewVertices>],
    first: &[Option<u32>],
) -> HashMap<usize, Vec<(usize, Vec<u8>)>> {
    let mut rebuilt: HashMap<usize, Vec<_>> = HashMap::new();
    for &part in &group.parts {
        let attributes = primitive(scene, part).and_then(|primitive| primitive.get("attributes"));
        let (Some(attributes), Some(new), Some(first)) = (attributes, &added[part], first[part]) else {
            continue;
        };
        let first = first as usize;
        let mut put = |name: &str, bytes: Vec<u8>| {
            if let Some(accessor) = attributes.get(name).and_then(index).filter(|_| !bytes.is_empty()) {
                rebuilt.entry(accessor).or_default().push((first, bytes));
            }
        };
        for &name in NewValues::Directions.names().iter().filter(|_| !new.normals.is_empty()) {
            let attribute = meshes[part].attributes().iter().find(|attribute| attribute.name == name);
            put(name, attribute.map(|attribute| bytes_from(attribute, first)).unwrap_or_default());
        }
        for name in NewValues::Positions.names() {
            let mut bytes = Vec::new();
            append(&mut bytes, new.positions.as_flattened(), f32::to_le_bytes);
            put(name, bytes);
        }
    }
    // Values from the first vertex of a later part on belong to that part.
    rebuilt.values_mut().for_each(|list| list.sort_unstable_by_key(|&(first, _)| first));
    rebuilt
}

/// Returns the bytes of an attribute from `vertex` on.
fn bytes_from(attribute: &Attribute, vertex: usize) -> Vec<u8> {
    let from = vertex * usize::from(attribute.components);
    let mut out = Vec::new();
    match &attribute.data {
        AttributeData::F32(data) => append(&mut out, &data[from..], f32::to_le_bytes),
        AttributeData::F64(data) => append(&mut out, &data[from..], f64::to_le_bytes),
        AttributeData::U8(data) => append(&mut out, &data[from..], u8::to_le_bytes),
        AttributeData::I8(data) => append(&mut out, &data[from..], i8::to_le_bytes),
        AttributeData::U16(data) => append(&mut out, &data[from..], u16::to_le_bytes),
        AttributeData::I16(data) => append(&mut out, &data[from..], i16::to_le_bytes),
        AttributeData::U32(data) => append(&mut out, &data[from..], u32::to_le_bytes),
        AttributeData::I32(data) => append(&mut out, &data[from..], i32::to_le_bytes),
    }
    out
}

/// The values of extended accessors, one accessor after the other.
struct ValueWriter {
    bytes: Vec<u8>,
    /// The number of accessors and images that use each view.
    uses: HashMap<usize, usize>,
    /// Numbers inside extensions and extras; any of them may be a view.
    possible: HashSet<usize>,
}

impl ValueWriter {
    fn of(scene: &Scene) -> Result<Self, Error> {
        let root = &scene.document.root;
        let mut uses: HashMap<usize, usize> = HashMap::new();
        let of_accessors = (0..array(root, "accessors")?.len()).flat_map(|a| views_of_accessor(root, a));
        let of_images = array(root, "images")?.iter().filter_map(|image| index(image.get("bufferView")?));
        of_accessors.chain(of_images).for_each(|view| *uses.entry(view).or_default() += 1);
        Ok(Self { bytes: Vec::new(), uses, possible: ExtensionNumbers::of(root).numbers })
    }

    /// Appends the values of the sources.
    fn copy(&mut self, raw: &[u8], element: usize, sources: &[u32]) -> Result<(), Error> {
        let stride = element.next_multiple_of(ALIGNMENT);
        let start = self.bytes.len();
        let end = start + stride * sources.len();
        if end > u32::MAX as usize {
            let (found, limit) = (end as u64, u32::MAX.into());
            return Err(Error::LimitExceeded { at: "bytes of a GLB".into(), found, limit });
        }
        self.bytes.resize(end, 0);
        for (row, &source) in self.bytes[start..].chunks_exact_mut(stride).zip(sources) {
            row[..element].copy_from_slice(&raw[source as usize * element..][..element]);
        }
        Ok(())
    }

    /// Replaces the view of an accessor if nothing else uses it; otherwise appends `view`. Returns
    /// the index of the view.
    fn put_view(&self, root: &mut Members, accessor: usize, view: Value) -> Result<usize, Error> {
        let old = array(root, "accessors")?.get(accessor).and_then(|a| index(a.get("bufferView")?));
        let views = list_mut(root, "bufferViews")?;
        let is_free = |old: &usize| self.uses.get(old) == Some(&1) && !self.possible.contains(old);
        let own = old.filter(is_free).filter(|&old| {
            views
                .get(old)
                .is_some_and(|view| view.get("extensions").is_none() && view.get("extras").is_none())
        });
        let Some(own) = own else {
            views.push(view);
            return Ok(views.len() - 1);
        };
        let new = view.as_object().into_iter().flat_map(Members::iter);
        if let Some(members) = views.get_mut(own).and_then(Value::as_object_mut) {
            new.for_each(|(name, value)| members.insert(name, value.clone()));
        }
        Ok(own)
    }
}

/// Points an accessor at all values of a view.
fn update(root: &mut Members, accessor: usize, view: usize, count: usize) -> Result<(), Error> {
    let accessor = list_mut(root, "accessors")?.get_mut(accessor).and_then(Value::as_object_mut);
    let Some(members) = accessor else { return Ok(()) };
    members.insert("bufferView", view);
    members.insert("count", count);
    members.remove("byteOffset");
    members.remove("sparse");
    Ok(())
}
