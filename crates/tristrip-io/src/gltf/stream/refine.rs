//! Reads progressive documents: replaces base meshes by the meshes decoded from the stream. The
//! rest of the reader and the writer see an ordinary document.
//!
//! ```text
//! root:      { extensions: { TRISTRIP_progressive: { version: 1, bufferView: 7 } } }  chunks
//! primitive: { extensions: { TRISTRIP_progressive: { stream: 0, part: 2 } } }         source
//! ```
//!
//! # Algorithm
//! All chunks are decoded, unless the meshes of another level are given. Each refined primitive
//! gets accessors with the vertices and triangles of its part, which replace the base mesh. The old
//! accessors, their bytes and the chunks are removed.
//!
//! # Complexity
//! Linear in the decoded bytes, which the decoder's limits bound.

mod split;

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::ops::Range;

use tristrip::stream::{Decoder, StreamError, StreamLimits};
use tristrip::{Layout, Mesh};

use self::split::parts_of;
pub use self::split::{StreamMeshes, StreamedPart};
use crate::error::Error;
use crate::gltf::document::buffer::view_range;
use crate::gltf::document::byte_ranges::SharedBytes;
use crate::gltf::document::json::{Members, Value};
use crate::gltf::document::references::views_of_accessor;
use crate::gltf::document::spec::TRIANGLES;
use crate::gltf::document::{Document, Located, array, entries_mut, index, items, list_mut};
use crate::gltf::read::compressed_views::join;
use crate::gltf::write::build::{DocumentBuilder, check_writable};
use crate::gltf::write::index::runs;
use crate::gltf::write::keep::extensions::{remove_extensions, undeclare};
use crate::gltf::write::keep::unused::{Replaced, UnusedEntries};
use crate::model::Drawing;

pub(in crate::gltf) const EXTENSION: &str = "TRISTRIP_progressive";
pub(in crate::gltf) const VERSION: u64 = 1;
/// Maximum number of triangles of a stream: a constant, plus a number per byte. A flat grid of a
/// million triangles has two per byte.
const MIN_TRIANGLE_LIMIT: usize = 1 << 18;
const TRIANGLES_PER_BYTE: usize = 32;

/// A refined primitive.
#[derive(Debug, Clone, Copy)]
pub(in crate::gltf) struct RefinedPrimitive {
    mesh: usize,
    primitive: usize,
    pub(in crate::gltf) source: StreamedPart,
}

/// The buffer view of a document's stream, and the primitives that it refines.
pub(in crate::gltf) struct StreamInDocument {
    pub(in crate::gltf) view: usize,
    pub(in crate::gltf) primitives: Vec<RefinedPrimitive>,
}

impl StreamInDocument {
    /// Finds the stream of a document, if it has one.
    pub(in crate::gltf) fn find(root: &Members) -> Result<Option<Self>, Error> {
        let Some(extensions) = root.get("extensions") else { return Ok(None) };
        let extensions = Located { value: extensions, at: "extensions".into() };
        let Some(extension) = extensions.field(EXTENSION) else { return Ok(None) };
        let version = extension.need("version")?;
        if version.whole()? != VERSION {
            return Err(version.wrong("1"));
        }
        let view_at = extension.need("bufferView")?;
        view_at.target(root, "bufferViews")?;
        let number = |at: &Located<'_>| u32::try_from(at.whole()?).map_err(|_| at.wrong("a 32-bit number"));
        let mut primitives = Vec::new();
        for (mesh, located_mesh) in Located::entries(root, "meshes")?.enumerate() {
            let Some(list) = located_mesh.field("primitives") else { continue };
            for (primitive, located) in list.items()?.enumerate() {
                let Some(own) = located.field("extensions").and_then(|all| all.field(EXTENSION)) else {
                    continue;
                };
                let (stream, part) = (number(&own.need("stream")?)?, own.field("part"));
                if let Some(targets) = located.field("targets") {
                    return Err(targets.wrong("no morph targets in a refined primitive"));
                }
                let part = part.map(|part| number(&part)).transpose()?;
                let source = StreamedPart { stream, part };
                primitives.push(RefinedPrimitive { mesh, primitive, source });
            }
        }
        Ok(Some(Self { view: view_at.size()?, primitives }))
    }

    /// Returns the stream indices of the meshes that primitives use.
    pub(in crate::gltf) fn numbers(&self) -> BTreeSet<u32> {
        self.primitives.iter().map(|primitive| primitive.source.stream).collect()
    }

    /// Returns the buffer of the stream and its byte range.
    fn range(&self, root: &Members, buffers: &[SharedBytes]) -> Result<(usize, Range<usize>), Error> {
        let view = &array(root, "bufferViews")?[self.view];
        view_range(self.view, view, buffers)
    }
}

/// Replaces the base meshes of a progressive document by `meshes`, or by the full meshes of its
/// stream. Other documents are not changed.
pub(in crate::gltf) fn refine(
    document: &mut Document,
    buffers: Vec<SharedBytes>,
    meshes: Option<&StreamMeshes>,
    notes: &mut Vec<String>,
) -> Result<Vec<SharedBytes>, Error> {
    let Some(stream) = StreamInDocument::find(&document.root)? else { return Ok(buffers) };
    let (buffer, range) = stream.range(&document.root, &buffers)?;
    let decoded;
    let meshes = if let Some(meshes) = meshes {
        meshes
    } else {
        decoded = decode_all(&buffers[buffer].as_slice()[range.clone()])?;
        notes.push(format!("primitives refined to their full meshes: {}", stream.primitives.len()));
        &decoded
    };
    let root = &mut document.root;
    check_view(root, stream.view)?;
    // 1. Remove the extensions first, so their numbers do not count as references.
    remove_from_root(root);
    undeclare(root, EXTENSION);
    for primitive in &stream.primitives {
        change_primitive(root, primitive.mesh, primitive.primitive, |value| {
            remove_extensions(value, &[EXTENSION])
        })?;
    }
    // 2. The parts, and the entries that they replace. A part without triangles at this level keeps
    //    its base mesh.
    let parts = parts_of(meshes, stream.primitives.iter().map(|primitive| primitive.source))?;
    let new: Vec<(&RefinedPrimitive, &Mesh)> =
        stream.primitives.iter().zip(&parts).filter_map(|(p, part)| Some((p, part.as_deref()?))).collect();
    for (primitive, part) in &new {
        check_attributes(root, primitive, part)?;
    }
    let rewritten: HashSet<(usize, usize)> = new.iter().map(|(p, _)| (p.mesh, p.primitive)).collect();
    let unused = UnusedEntries::find(root, &rewritten, Replaced::IndicesAndVertices)?;
    let free_views: BTreeSet<usize> =
        unused.views.iter().copied().filter(|&view| view != stream.view).collect();
    let mut freed = vec![Vec::new(); buffers.len()];
    freed[buffer].push(range);
    for &view in &free_views {
        let entry = Located::entry(root, "bufferViews", view)?;
        let (buffer, range) = view_range(view, entry.value, &buffers)?;
        freed[buffer].push(range);
    }
    // 3. The new values. Free entries are reused in ascending order, the view of the stream last.
    let mut builder = DocumentBuilder::default();
    let mut built: HashMap<StreamedPart, (BTreeMap<&str, usize>, usize)> = HashMap::new();
    for &(&RefinedPrimitive { source, .. }, mesh) in &new {
        built.entry(source).or_insert_with(|| {
            let mut names = BTreeMap::from([("POSITION", builder.positions(mesh.positions()))]);
            for attribute in mesh.attributes() {
                names.insert(&attribute.name, builder.attribute(attribute, mesh.vertex_count()));
            }
            let indices = builder.indices(&runs(mesh, Drawing::Faces, Layout::List));
            (names, indices[0])
        });
    }
    let DocumentBuilder { bytes, views, accessors, .. } = builder;
    let starts: Vec<usize> =
        views.iter().filter_map(|view| Some(view["byteOffset"].as_u64()? as usize)).collect();
    let slots = put_all(root, "bufferViews", free_views.into_iter().chain([stream.view]), views)?;
    let in_slots = |mut accessor: serde_json::Value| {
        let view = accessor["bufferView"].as_u64().and_then(|view| slots.get(view as usize)).copied();
        accessor["bufferView"] = view.unwrap_or_default().into();
        accessor
    };
    let accessors = accessors.into_iter().map(in_slots).collect();
    let free_accessors: BTreeSet<usize> = unused.accessors.into_iter().collect();
    let accessors = put_all(root, "accessors", free_accessors, accessors)?;
    for (primitive, _) in new {
        let Some((names, indices)) = built.get(&primitive.source) else { continue };
        change_primitive(root, primitive.mesh, primitive.primitive, |value| {
            let Some(members) = value.as_object_mut() else { return };
            let names = names.iter().map(|(&name, &accessor)| (name.to_owned(), accessors[accessor].into()));
            members.insert("attributes", serde_json::Value::Object(names.collect()));
            members.insert("indices", accessors[*indices]);
            if members.contains_key("mode") {
                members.insert("mode", TRIANGLES);
            }
        })?;
    }
    // 4. The bytes. The view of the stream is the last one; it is removed if it was not reused.
    let list = list_mut(root, "bufferViews")?;
    if !slots.contains(&stream.view) {
        if stream.view + 1 == list.len() {
            list.pop();
        } else {
            freed[buffer].clear();
        }
    }
    join(root, &buffers, freed, &slots.into_iter().zip(starts).collect(), &bytes)
}

/// Checks that only the stream uses its view.
fn check_view(root: &Members, view: usize) -> Result<(), Error> {
    let mut of_accessors = (0..array(root, "accessors")?.len()).flat_map(|a| views_of_accessor(root, a));
    let mut of_images = array(root, "images")?.iter().filter_map(|image| index(image.get("bufferView")?));
    if of_accessors.any(|other| other == view) || of_images.any(|other| other == view) {
        let found = "a view that accessors or images also use";
        return Err(Error::format(format!("bufferViews[{view}]"), found, "a view used only by the stream"));
    }
    Ok(())
}

/// Decodes all meshes of a stream.
fn decode_all(chunks: &[u8]) -> Result<StreamMeshes, Error> {
    let mut decoder = Decoder::new(limits(chunks.len()));
    decoder.update(chunks).map_err(|fault| stream_error(&fault))?;
    if decoder.offset() < chunks.len() as u64 {
        let at = format!("chunk {} of the stream at its byte {}", decoder.chunk_count(), decoder.offset());
        return Err(Error::format(at, "the end of the stream", "a complete chunk"));
    }
    let streams = 0..limits(0).meshes;
    let parts = streams.filter_map(|stream| Some((stream as u32, decoder.part(stream)?)));
    parts.map(|(stream, part)| Ok((stream, part.mesh()?))).collect()
}

/// Returns the limits of a decoder for a stream of `bytes` bytes.
pub(in crate::gltf) fn limits(bytes: usize) -> StreamLimits {
    let limits = StreamLimits::default();
    let triangles = MIN_TRIANGLE_LIMIT.saturating_add(bytes.saturating_mul(TRIANGLES_PER_BYTE));
    StreamLimits { triangles: triangles.min(limits.triangles), ..limits }
}

/// Converts a stream error.
pub(in crate::gltf) fn stream_error(fault: &StreamError) -> Error {
    if let Some(exceeded) = fault.exceeded {
        let at = format!("{} of the stream, {}", fault.at, exceeded.what);
        return Error::LimitExceeded { at, found: exceeded.found, limit: exceeded.limit };
    }
    Error::format(format!("{} of the stream", fault.at), fault.found.clone(), fault.expected.clone())
}

fn remove_from_root(root: &mut Members) {
    let Some(extensions) = root.get_mut("extensions").and_then(Value::as_object_mut) else { return };
    extensions.remove(EXTENSION);
    if extensions.is_empty() {
        root.remove("extensions");
    }
}

pub(in crate::gltf) fn change_primitive(
    root: &mut Members,
    mesh: usize,
    primitive: usize,
    change: impl FnOnce(&mut Value),
) -> Result<(), Error> {
    let mesh = entries_mut(root, "meshes")?.get_mut(mesh).and_then(Value::as_object_mut);
    let list = mesh.and_then(|mesh| mesh.get_mut("primitives")).and_then(Value::as_array_mut);
    if let Some(value) = list.and_then(|list| list.get_mut(primitive)) {
        change(value);
    }
    Ok(())
}

/// Checks that a mesh has the attributes of the primitive that it refines, in types supported by
/// glTF.
fn check_attributes(root: &Members, primitive: &RefinedPrimitive, mesh: &Mesh) -> Result<(), Error> {
    let at = format!("meshes[{}].primitives[{}].attributes", primitive.mesh, primitive.primitive);
    let list = array(root, "meshes")?.get(primitive.mesh).map(|mesh| items(mesh, "primitives"));
    let value = list.and_then(|list| list.get(primitive.primitive)).and_then(|value| value.get("attributes"));
    let expected: BTreeSet<&str> =
        value.and_then(Value::as_object).into_iter().flat_map(Members::iter).map(|(name, _)| name).collect();
    let names = mesh.attributes().iter().map(|attribute| attribute.name.as_str()).chain(["POSITION"]);
    let found: BTreeSet<&str> = names.collect();
    if found != expected || found.len() != mesh.attributes().len() + 1 {
        return Err(Error::format(at, format!("{expected:?}"), format!("{found:?}, those of the stream")));
    }
    for attribute in mesh.attributes() {
        if let Err(why) = check_writable(attribute) {
            return Err(Error::format(
                at,
                format!("`{}` in the stream", attribute.name),
                format!("an attribute that glTF supports: {why}"),
            ));
        }
    }
    Ok(())
}

/// Puts values into free entries of a list, then at its end. Returns their indices.
fn put_all(
    root: &mut Members,
    list: &str,
    free: impl IntoIterator<Item = usize>,
    values: Vec<serde_json::Value>,
) -> Result<Vec<usize>, Error> {
    let list = list_mut(root, list)?;
    let mut free = free.into_iter();
    let mut slots = Vec::with_capacity(values.len());
    for value in values {
        let slot = free.next().unwrap_or(list.len());
        match list.get_mut(slot) {
            Some(old) => *old = value.into(),
            None => list.push(value.into()),
        }
        slots.push(slot);
    }
    Ok(slots)
}
