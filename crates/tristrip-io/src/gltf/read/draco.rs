//! Decodes primitives compressed with Draco. The rest of the reader and the writer see ordinary
//! accessors.
//!
//! ```text
//! primitive: { attributes: { POSITION: 0 }, indices: 1,  accessors with type, count, no view
//!   extensions: { KHR_draco_mesh_compression:
//!     { bufferView: 4, attributes: { POSITION: 7 } } } } the stream, and the attribute id in it
//!
//! ─▶ { attributes: { POSITION: 0 }, indices: 1 }         accessors over new buffer views
//! ```
//!
//! # Algorithm
//! 1. Before a stream is decoded, its size and the size declared by its accessors are charged to
//!    the budget. The decoder must not produce more bytes than this. Attributes of the stream that
//!    the primitive does not use are skipped.
//! 2. Each decoded attribute, and the indices, get their own buffer view. Accessors that several
//!    primitives use are decoded once.
//! 3. The buffers are merged into one without the streams. The extension is removed from primitives
//!    and from the extension lists.
//!
//! If the accessors of a primitive also have uncompressed values, these are used.
//!
//! # References
//! Google: *Draco 3D data compression*, 2017; the crate `draco-gltf` decodes it. The Khronos Group:
//! *`KHR_draco_mesh_compression`*, 2018.
//!
//! # Complexity
//! Linear in the decoded bytes, which are bounded by [`DECOMPRESSED_LIMIT`] and the file size.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use draco_gltf::{
    ComponentType, DecodeLimits, DracoPrimitiveContract, DracoPrimitiveExtension, JsonValue, PackedAttribute,
    PackedGeometry, PackedIndices,
};
use serde_json::json;

use crate::error::Error;
use crate::gltf::document::accessor::AccessorResolver;
use crate::gltf::document::budget::{DECOMPRESSED_LIMIT, DecodeBudget};
use crate::gltf::document::buffer::view_range;
use crate::gltf::document::byte_ranges::ALIGNMENT;
use crate::gltf::document::byte_ranges::SharedBytes;
use crate::gltf::document::json::{Members, Value};
use crate::gltf::document::spec::TRIANGLES;
use crate::gltf::document::{Document, Located, array, entries_mut, list_mut};
use crate::gltf::read::compressed_views::join;
use crate::gltf::write::keep::extensions::{remove_extensions, undeclare};

pub(in crate::gltf) const DRACO: &str = "KHR_draco_mesh_compression";
/// Decoded bytes allowed per byte of the buffers: a vertex of a regular surface takes a few bits.
const FACTOR: u64 = 256;
/// Maximum size of a value: four floats.
const VALUE_BYTES: usize = 16;

/// Decoded bytes that are always allowed per stream.
const MIN_DECODED_BYTES: usize = 1 << 16;

/// The decoded values of a compressed accessor.
struct DecodedAccessor {
    bytes: Vec<u8>,
    component_type: usize,
    count: usize,
    kind: &'static str,
    /// The stride in bytes, if elements are padded.
    stride: Option<usize>,
}

impl DecodedAccessor {
    /// Converts a decoded attribute, padding each value to a multiple of [`ALIGNMENT`] bytes.
    fn of_vertices(attribute: &PackedAttribute) -> Self {
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][usize::from(attribute.components().clamp(1, 4)) - 1];
        let (count, component_type) = (attribute.count(), attribute.component_type() as usize);
        let size = attribute.bytes().len() / count.max(1);
        let stride = size.next_multiple_of(ALIGNMENT);
        if stride == size || size == 0 {
            return Self { bytes: attribute.bytes().to_vec(), component_type, count, kind, stride: None };
        }
        let mut bytes = Vec::with_capacity(count * stride);
        for element in attribute.bytes().chunks_exact(size) {
            bytes.extend_from_slice(element);
            bytes.resize(bytes.len() + stride - size, 0);
        }
        Self { bytes, component_type, count, kind, stride: Some(stride) }
    }

    fn of_indices(indices: &PackedIndices) -> Self {
        let (count, component_type) = (indices.count(), indices.component_type() as usize);
        Self { bytes: indices.bytes().to_vec(), component_type, count, kind: "SCALAR", stride: None }
    }
}

/// The decoded values of all compressed primitives of a document.
#[derive(Default)]
struct DecodedDraco {
    /// The compressed primitives: mesh index, and primitive index in the mesh.
    primitives: Vec<(usize, usize)>,
    accessors: BTreeMap<usize, DecodedAccessor>,
    /// The buffer views of the streams.
    streams: BTreeSet<usize>,
}

/// Decodes all compressed primitives and merges the buffers into one. A document without such
/// primitives is not changed.
///
/// # Errors
/// A primitive's extension is invalid, its stream cannot be decoded, or the decoded bytes exceed
/// the budget.
pub(in crate::gltf) fn decompress(
    document: &mut Document,
    buffers: Vec<SharedBytes>,
    notes: &mut Vec<String>,
) -> Result<Vec<SharedBytes>, Error> {
    let DecodedDraco { primitives, accessors, streams } = decode(&document.root, &buffers)?;
    if primitives.is_empty() {
        return Ok(buffers);
    }
    notes.push(format!(
        "primitives compressed with Draco, uncompressed when written as GLB: {}",
        primitives.len()
    ));
    let root = &mut document.root;
    // 1. The ranges of the streams, except bytes that another view uses.
    let mut freed = vec![Vec::new(); buffers.len()];
    for &view in &streams {
        if let Some(value) = array(root, "bufferViews")?.get(view) {
            let (buffer, range) = view_range(view, value, &buffers)?;
            freed[buffer].push(range);
        }
    }
    // 2. A view for each decoded accessor. The views of the streams are reused first; each stream
    //    has at least positions.
    let (mut bytes, mut views): (Vec<u8>, BTreeMap<usize, usize>) = (Vec::new(), BTreeMap::new());
    let mut unused: Vec<usize> = streams.into_iter().rev().collect();
    for (index, accessor) in accessors {
        let mut value = json!({ "buffer": 0, "byteLength": accessor.bytes.len() });
        if let Some(stride) = accessor.stride {
            value["byteStride"] = stride.into();
        }
        let list = list_mut(root, "bufferViews")?;
        let view = unused.pop().unwrap_or(list.len());
        match list.get_mut(view) {
            Some(old) => *old = value.into(),
            None => list.push(value.into()),
        }
        views.insert(view, bytes.len());
        bytes.extend_from_slice(&accessor.bytes);
        bytes.resize(bytes.len().next_multiple_of(ALIGNMENT), 0);
        if let Some(members) = entries_mut(root, "accessors")?.get_mut(index).and_then(Value::as_object_mut) {
            members.remove("byteOffset");
            members.insert("bufferView", view);
            members.insert("componentType", accessor.component_type);
            members.insert("count", accessor.count);
            members.insert("type", accessor.kind);
        }
    }
    // 3. The primitives.
    for (mesh, primitive) in primitives {
        let mesh = entries_mut(root, "meshes")?.get_mut(mesh).and_then(Value::as_object_mut);
        let list = mesh.and_then(|mesh| mesh.get_mut("primitives")).and_then(Value::as_array_mut);
        if let Some(primitive) = list.and_then(|list| list.get_mut(primitive)) {
            remove_extensions(primitive, &[DRACO]);
            // A stream contains a triangle list, whatever the declared mode.
            if let Some(members) = primitive.as_object_mut().filter(|members| members.contains_key("mode")) {
                members.insert("mode", TRIANGLES);
            }
        }
    }
    undeclare(root, DRACO);
    join(root, &buffers, freed, &views, &bytes)
}

/// Decodes the compressed primitives.
fn decode(root: &Members, buffers: &[SharedBytes]) -> Result<DecodedDraco, Error> {
    let resolver = AccessorResolver { root, buffers };
    let mut budget = DecodeBudget::new(DECOMPRESSED_LIMIT, FACTOR, buffers);
    let mut decoded = DecodedDraco::default();
    // The stream of each accessor.
    let mut stream_of: HashMap<usize, usize> = HashMap::new();
    for (mesh, located_mesh) in Located::entries(root, "meshes")?.enumerate() {
        let Some(primitives) = located_mesh.field("primitives") else { continue };
        for (number, located) in primitives.items()?.enumerate() {
            let extension = located.field("extensions").and_then(|all| all.field(DRACO));
            let Some(extension) = extension else { continue };
            let primitive = CompressedPrimitive::of(&located, &extension, root)?;
            decoded.primitives.push((mesh, number));
            let stream = primitive.stream;
            let is_known = |index: usize| stream_of.get(&index) == Some(&stream);
            let all = || primitive.attributes.values().copied().chain([primitive.indices]);
            if all().all(|accessor| is_known(accessor) || has_values(root, accessor)) {
                continue;
            }
            if let Some(index) = all().find(|index| stream_of.get(index).is_some_and(|of| *of != stream)) {
                return Err(extension.wrong(format!("accessors[{index}] in one stream only")));
            }
            let geometry = primitive.decode(&extension, &resolver, &mut budget)?;
            decoded.streams.insert(stream);
            for attribute in geometry.attributes() {
                let Some(&index) = primitive.attributes.get(attribute.semantic()) else { continue };
                check_type(&located, attribute.component_type())?;
                stream_of.insert(index, stream);
                decoded.accessors.insert(index, DecodedAccessor::of_vertices(attribute));
            }
            if let Some(indices) = geometry.indices() {
                stream_of.insert(primitive.indices, stream);
                decoded.accessors.insert(primitive.indices, DecodedAccessor::of_indices(indices));
            }
        }
    }
    Ok(decoded)
}

/// A compressed primitive: its stream, and its accessors by attribute name.
struct CompressedPrimitive<'a> {
    stream: usize,
    attributes: BTreeMap<&'a str, usize>,
    indices: usize,
}

impl<'a> CompressedPrimitive<'a> {
    fn of(located: &Located<'a>, extension: &Located<'a>, root: &'a Members) -> Result<Self, Error> {
        let accessor = |at: &Located<'a>| at.target(root, "accessors").and(at.size());
        let attributes = located.need("attributes")?.members()?.map(|(name, at)| Ok((name, accessor(&at)?)));
        let attributes = attributes.collect::<Result<_, Error>>()?;
        let view = extension.need("bufferView")?;
        view.target(root, "bufferViews")?;
        let indices = accessor(&located.need("indices")?)?;
        Ok(Self { stream: view.size()?, attributes, indices })
    }

    /// Decodes the stream, limited by the declared counts of the accessors.
    fn decode(
        &self,
        extension: &Located<'a>,
        resolver: &AccessorResolver<'a>,
        budget: &mut DecodeBudget,
    ) -> Result<PackedGeometry, Error> {
        let accessor = |index: usize| Located::entry(resolver.root, "accessors", index);
        let count = |accessor: &Located<'_>| accessor.need("count")?.size();
        let corners = count(&accessor(self.indices)?)?;
        let mut contract = DracoPrimitiveContract::new().with_indices(corners as u64);
        let mut vertices = 0;
        for (&name, &index) in &self.attributes {
            let accessor = accessor(index)?;
            let own = count(&accessor)?;
            vertices = own.max(vertices);
            let normalized = accessor.field("normalized").and_then(|flag| flag.value.as_bool());
            contract = contract.with_attribute(name, own as u64, normalized.unwrap_or(false));
        }
        let bytes = resolver.shared_view(&extension.need("bufferView")?)?;
        budget.charge(&extension.at, bytes.len(), 1)?;
        budget.charge(&extension.at, corners, size_of::<u32>())?;
        let vertex_bytes = VALUE_BYTES * self.attributes.len();
        budget.charge(&extension.at, vertices, vertex_bytes)?;
        let numbers = self.numbers(extension)?;
        let decoded = vertices.saturating_mul(vertex_bytes).max(MIN_DECODED_BYTES);
        // The decoder copies an attribute once per name.
        let distinct: BTreeSet<u64> = numbers.values().copied().collect();
        budget.charge(&extension.at, numbers.len() - distinct.len(), decoded)?;
        let mut limits = DecodeLimits::default();
        limits.max_points = vertices as u64;
        limits.max_faces = corners as u64 / 3;
        limits.max_decoded_bytes = decoded as u64;
        let failed = |why: String| Error::format(extension.at.clone(), why, "a Draco stream");
        let text = json!({ "bufferView": self.stream, "attributes": numbers }).to_string().into_bytes();
        let json = JsonValue::parse(&text).map_err(failed)?;
        let parsed = DracoPrimitiveExtension::from_json(&json).map_err(|error| failed(error.to_string()))?;
        let geometry = parsed.decode(bytes.as_slice(), &contract.with_limits(limits));
        geometry.map_err(|error| failed(error.to_string()))
    }

    /// Returns the ids in the stream of the primitive's attributes.
    fn numbers(&self, extension: &Located<'a>) -> Result<BTreeMap<&'a str, u64>, Error> {
        let all = extension.need("attributes")?.members()?;
        let own = all.filter(|(name, _)| self.attributes.contains_key(name));
        own.map(|(name, number)| Ok((name, number.whole()?))).collect()
    }
}

/// Returns whether an accessor has values outside the stream.
fn has_values(root: &Members, accessor: usize) -> bool {
    let accessor = array(root, "accessors").unwrap_or_default().get(accessor);
    accessor.is_some_and(|accessor| accessor.get("bufferView").is_some() || accessor.get("sparse").is_some())
}

/// Checks that glTF supports a component type.
fn check_type(primitive: &Located<'_>, component_type: ComponentType) -> Result<(), Error> {
    use ComponentType::{F32, I8, I16, U8, U16, U32};
    match component_type {
        I8 | U8 | I16 | U16 | U32 | F32 => Ok(()),
        other => Err(Error::format(
            primitive.at.clone(),
            format!("{other:?} in a Draco stream"),
            "a component type of glTF 2.0",
        )),
    }
}
