//! Reads a document: each primitive of triangles, strips or fans becomes a part.

pub(crate) mod appearance;
pub(in crate::gltf) mod compressed_views;
mod draco;
pub(in crate::gltf) mod placements;
pub(in crate::gltf) mod pose;
mod triangles;

use std::borrow::Cow;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::gltf::document::json::{Members, Value};
use tristrip::{Attribute, Faces, Layout, Mesh};

use crate::error::Error;
use crate::gltf::BufferFiles;
use crate::gltf::document::accessor::{AccessorResolver, check_views};
use crate::gltf::document::budget::{ATTRIBUTE_LIMIT, DecodeBudget, GEOMETRY_LIMIT};
use crate::gltf::document::buffer;
use crate::gltf::document::byte_ranges::SharedBytes;
use crate::gltf::document::container::{self, GlbContainer};
use crate::gltf::document::scene::{PrimitiveRef, Scene};
use crate::gltf::document::spec::{
    COMPRESSIONS, ORDER_EXTENSIONS, QUANTIZATION, RESTART_EXTENSION, TRIANGLE_FAN, TRIANGLE_STRIP, TRIANGLES,
};
use crate::gltf::document::{Document, Located, array, uses};
use crate::gltf::read::triangles::{TriangleCounts, TriangleReader};
use crate::gltf::stream::refine::{StreamMeshes, refine};
use crate::gltf::write::build::build;
use crate::gltf::write::separate::SeparateFiles;
use crate::model::{Drawing, Model, Part, StoredStrips};

/// Decoded bytes allowed per byte of the buffers: a strip of byte indices needs twelve.
const GEOMETRY_FACTOR: u64 = 16;
const ATTRIBUTE_FACTOR: u64 = 4;

/// Name prefixes of extensions that do not affect geometry.
const NOT_GEOMETRY: [&str; 5] =
    ["KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "EXT_lights_"];

/// Reads a GLB or the JSON of a `.gltf` file. The buffers of a `.gltf` are data URIs or files
/// inside `base_dir`.
///
/// # Errors
/// - The parts of the document that define geometry are not valid glTF 2.0.
/// - Decoding exceeds a limit.
/// - The file of a buffer cannot be read or is outside `base_dir`.
///
/// ```
/// let empty = br#"{"asset":{"version":"2.0"}}"#;
/// assert!(tristrip_io::gltf::read(empty.to_vec(), None)?.parts.is_empty());
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn read(bytes: impl Into<Vec<u8>>, base_dir: Option<&Path>) -> Result<Model, Error> {
    let folders: Vec<&Path> = base_dir.into_iter().collect();
    read_with_files(Arc::new(bytes.into()), &mut BufferFiles::new(&folders))
}

/// Reads a document whose external buffers are in `files`.
pub(crate) fn read_with_files(bytes: Arc<Vec<u8>>, files: &mut BufferFiles<'_>) -> Result<Model, Error> {
    read_container(bytes, files, None, None)
}

/// Reads a progressive document whose primitives use the given meshes of its stream.
pub(in crate::gltf) fn read_refined(
    bytes: Arc<Vec<u8>>,
    folders: &[&Path],
    meshes: &StreamMeshes,
) -> Result<Model, Error> {
    read_container(bytes, &mut BufferFiles::new(folders), None, Some(meshes))
}

/// Reads a document and its buffer as written by [`separate`](super::separate()).
///
/// # Errors
/// The document is not valid glTF 2.0 or refers to another buffer, or decoding exceeds a limit.
pub fn read_separate(files: &SeparateFiles) -> Result<Model, Error> {
    read_container(Arc::new(files.json.clone()), &mut BufferFiles::new(&[]), Some(files), None)
}

/// Returns a model with a scene. A model that has one is returned unchanged. Otherwise the function
/// builds the scene that a GLB of the model would have, and reads its parts. Their faces are
/// triangles.
///
/// # Errors
/// Decoding the model's values exceeds a limit.
///
/// ```
/// use tristrip_io::{Format, gltf, read};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", Format::Obj)?;
/// let model = gltf::with_scene(&model)?;
/// assert_eq!((model.scene.is_some(), model.parts[0].mesh.faces().face_count()), (true, 2));
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn with_scene(model: &Model) -> Result<Cow<'_, Model>, Error> {
    if model.scene.is_some() {
        return Ok(Cow::Borrowed(model));
    }
    let content = build(model, &vec![Drawing::Faces; model.parts.len()], Layout::List);
    let buffers = content.buffers();
    read_parts(content.document, buffers, Vec::new(), Vec::new()).map(Cow::Owned)
}

fn read_container(
    bytes: Arc<Vec<u8>>,
    files: &mut BufferFiles<'_>,
    beside: Option<&SeparateFiles>,
    meshes: Option<&StreamMeshes>,
) -> Result<Model, Error> {
    let mut notes = Vec::new();
    let container = container::open(bytes, &mut notes)?;
    let document = Document::parse(container.json_bytes())?;
    let unknown = unknown_requirements(&document.root);
    read_document(document, &container, files, beside, meshes, notes).map_err(|error| match error {
        Error::Format { .. } if !unknown.is_empty() => {
            let names = unknown.join(" and ");
            Error::Unsupported(format!("{error}; the file requires {names}, which is not supported"))
        }
        other => other,
    })
}

fn read_document(
    mut document: Document,
    container: &GlbContainer,
    files: &mut BufferFiles<'_>,
    beside: Option<&SeparateFiles>,
    meshes: Option<&StreamMeshes>,
    mut notes: Vec<String>,
) -> Result<Model, Error> {
    let is_fallback = compressed_views::fallback_buffers(&document.root)?;
    let buffers =
        buffer::load(&mut document, &container.file, container.bin.as_ref(), files, beside, &is_fallback)?;
    let buffers = compressed_views::decompress(&mut document, buffers, &is_fallback, &mut notes)?;
    let buffers = draco::decompress(&mut document, buffers, &mut notes)?;
    let buffers = refine(&mut document, buffers, meshes, &mut notes)?;
    read_parts(document, buffers, files.later_folders(), notes)
}

/// Reads the parts of a document with loaded, uncompressed buffers.
fn read_parts(
    document: Document,
    buffers: Vec<SharedBytes>,
    folders: Vec<PathBuf>,
    mut notes: Vec<String>,
) -> Result<Model, Error> {
    let root = &document.root;
    let resolver = AccessorResolver { root, buffers: &buffers };
    check_views(&resolver)?;
    check_nodes(root)?;
    let mut reader = PrimitiveReader {
        positions: HashMap::new(),
        vertices: HashMap::new(),
        geometry: DecodeBudget::new(GEOMETRY_LIMIT, GEOMETRY_FACTOR, &buffers),
        attributes: DecodeBudget::new(ATTRIBUTE_LIMIT, ATTRIBUTE_FACTOR, &buffers),
        triangles: TriangleReader::default(),
        counts: ReadCounts::default(),
        primitives: Vec::new(),
        resolver,
    };
    let parts = reader.parts()?;
    let PrimitiveReader { counts, triangles, primitives, .. } = reader;
    counts.add_notes(triangles.counts, root, &mut notes);
    note_document(root, &mut notes)?;
    Ok(Model { parts, notes, scene: Some(Scene { document, buffers, primitives, folders }), materials: None })
}

struct PrimitiveReader<'a> {
    resolver: AccessorResolver<'a>,
    /// Meshes without faces, by position accessor.
    positions: HashMap<usize, Mesh>,
    /// Meshes without faces, with all attributes, by the names and accessors of these. Primitives
    /// with the same set share them.
    vertices: HashMap<Vec<(&'a str, usize)>, Mesh>,
    geometry: DecodeBudget,
    attributes: DecodeBudget,
    triangles: TriangleReader,
    counts: ReadCounts,
    primitives: Vec<PrimitiveRef>,
}

/// Counts for the notes.
#[derive(Default)]
struct ReadCounts {
    other_modes: u64,
    attributes_over_budget: u64,
    matrix_attributes: u64,
}

impl<'a> PrimitiveReader<'a> {
    fn parts(&mut self) -> Result<Vec<Part>, Error> {
        let mut parts = Vec::new();
        for (mesh, located_mesh) in Located::entries(self.resolver.root, "meshes")?.enumerate() {
            let name = located_mesh.field("name").and_then(|n| n.value.as_str()).map(str::to_owned);
            for (primitive, located) in located_mesh.need("primitives")?.items()?.enumerate() {
                let mode = match located.field("mode") {
                    None => TRIANGLES,
                    Some(mode) => match mode.whole()? {
                        known @ 0..=TRIANGLE_FAN => known,
                        _ => return Err(mode.wrong("0 to 6")),
                    },
                };
                if mode < TRIANGLES {
                    self.counts.other_modes += 1;
                    continue;
                }
                let (mesh_of_part, stored) = self.mesh(&located, mode, &parts)?;
                self.primitives.push(PrimitiveRef { mesh, primitive, mode, is_redrawn: false });
                let material = self.material(&located)?;
                let stripped = mode == TRIANGLE_STRIP || mode == TRIANGLE_FAN;
                parts.push(Part { name: name.clone(), material, mesh: mesh_of_part, stripped, stored });
            }
        }
        Ok(parts)
    }

    fn material(&self, primitive: &Located<'a>) -> Result<Option<String>, Error> {
        let Some(material) = primitive.field("material") else { return Ok(None) };
        let material = material.target(self.resolver.root, "materials")?;
        Ok(material.field("name").and_then(|n| n.value.as_str()).map(str::to_owned))
    }

    fn mesh(
        &mut self,
        primitive: &Located<'a>,
        mode: u64,
        parts: &[Part],
    ) -> Result<(Mesh, Option<StoredStrips>), Error> {
        // 1. Vertices: shared between primitives and checked once.
        let vertices = self.vertices(&primitive.need("attributes")?)?;
        // 2. Triangles, also shared between primitives.
        self.triangles.read(&self.resolver, primitive, mode, &vertices, parts, &mut self.geometry)
    }

    /// Decodes positions and attributes, or returns those of an earlier primitive with the same
    /// accessors.
    fn vertices(&mut self, attributes: &Located<'a>) -> Result<Mesh, Error> {
        let position = attributes.need("POSITION")?;
        let key = attributes.members()?.map(|(name, accessor)| Ok((name, accessor.size()?)));
        let key = key.collect::<Result<Vec<_>, Error>>()?;
        if let Some(known) = self.vertices.get(&key) {
            return Ok(known.clone());
        }
        let mut mesh = match self.positions.entry(position.size()?) {
            Entry::Occupied(known) => known.get().clone(),
            Entry::Vacant(new) => {
                let values = self.resolver.values(&position)?;
                let decoded = values.positions(self.resolver.root, &mut self.geometry)?;
                new.insert(Mesh::new(decoded, Faces::default())?).clone()
            }
        };
        let vertex_count = mesh.vertex_count();
        for (name, accessor) in attributes.members()?.filter(|(name, _)| *name != "POSITION") {
            if let Some(attribute) = self.attribute(name, &accessor, vertex_count)? {
                mesh = mesh.with_attribute(attribute)?;
            }
        }
        self.vertices.insert(key, mesh.clone());
        Ok(mesh)
    }

    fn attribute(
        &mut self,
        name: &str,
        accessor: &Located<'a>,
        vertex_count: usize,
    ) -> Result<Option<Attribute>, Error> {
        let values = self.resolver.values(accessor)?;
        if values.count != vertex_count {
            let expected = format!("{vertex_count}, one per vertex");
            return Err(Error::format(format!("{}.count", values.at), values.count.to_string(), expected));
        }
        if values.matrix {
            self.counts.matrix_attributes += 1;
            return Ok(None);
        }
        if !self.attributes.try_charge(values.count, values.components * values.component.bytes()) {
            self.counts.attributes_over_budget += 1;
            return Ok(None);
        }
        Ok(Some(Attribute {
            name: name.to_owned(),
            components: values.components as u8,
            normalized: values.normalized,
            data: values.attribute()?,
        }))
    }
}

impl ReadCounts {
    fn add_notes(&self, triangles: TriangleCounts, root: &Members, notes: &mut Vec<String>) {
        let mut note = |text: &str, count: u64| {
            if count > 0 {
                notes.push(format!("{text}: {count}"));
            }
        };
        note("primitives of points or lines, kept only in a GLB", self.other_modes);
        note("dropped degenerate triangles of strips and fans", triangles.degenerate);
        note(
            "dropped indices at the end of triangle lists that form no triangle",
            triangles.incomplete_indices,
        );
        note(
            "vertex attributes not decoded because of their size, kept only in a GLB",
            self.attributes_over_budget,
        );
        note("matrix vertex attributes not decoded, kept only in a GLB", self.matrix_attributes);
        if !uses(root, RESTART_EXTENSION) {
            note(
                &format!("restart indices accepted although the file does not use {RESTART_EXTENSION}"),
                triangles.restarts,
            );
        }
    }
}

/// Returns the required extensions that may be the reason why the geometry cannot be read.
fn unknown_requirements(root: &Members) -> Vec<String> {
    let names = root.get("extensionsRequired").and_then(Value::as_array).unwrap_or_default();
    let names = names.iter().filter_map(Value::as_str);
    let is_known = |name: &str| {
        name == QUANTIZATION
            || name == RESTART_EXTENSION
            || name == draco::DRACO
            || COMPRESSIONS.contains(&name)
            || NOT_GEOMETRY.iter().any(|p| name.starts_with(p))
    };
    names.filter(|name| !is_known(name)).map(str::to_owned).collect()
}

/// Checks that children exist and that no node is its own ancestor.
fn check_nodes(root: &Members) -> Result<(), Error> {
    let count = array(root, "nodes")?.len();
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); count];
    let mut parent_count = vec![0u32; count];
    for (list, node) in children.iter_mut().zip(Located::entries(root, "nodes")?) {
        let Some(list_of_children) = node.field("children") else { continue };
        for child in list_of_children.items()? {
            let index = child.size()?;
            let Some(parents) = parent_count.get_mut(index) else {
                return Err(child.wrong(format!("less than {count}, the number of nodes")));
            };
            *parents += 1;
            list.push(index);
        }
    }
    // Repeatedly remove nodes without a remaining parent. Nodes that are left form cycles.
    let mut open: Vec<usize> = (0..count).filter(|&node| parent_count[node] == 0).collect();
    let mut seen = 0;
    while let Some(node) = open.pop() {
        seen += 1;
        for &child in &children[node] {
            parent_count[child] -= 1;
            if parent_count[child] == 0 {
                open.push(child);
            }
        }
    }
    if seen < count {
        let node = parent_count.iter().position(|&parents| parents > 0).unwrap_or(0);
        return Err(Error::format(format!("nodes[{node}]"), "a cycle of children", "a tree"));
    }
    Ok(())
}

/// Adds notes on how a GLB written from this document will differ from it, other than in indices
/// and modes.
fn note_document(root: &Members, notes: &mut Vec<String>) -> Result<(), Error> {
    let buffer_count = array(root, "buffers")?.len();
    if buffer_count > 1 {
        notes.push(format!("buffers merged into one when written as GLB: {buffer_count}"));
    }
    let external = array(root, "images")?
        .iter()
        .filter_map(|image| image.get("uri").and_then(Value::as_str))
        .filter(|uri| !uri.starts_with("data:"))
        .count();
    if external > 0 {
        notes.push(format!("images in separate files: {external}"));
    }
    for name in ORDER_EXTENSIONS.iter().filter(|name| uses(root, name)) {
        notes.push(format!("{name} describes the order of indices: dropped from meshes with new indices"));
    }
    Ok(())
}
