//! Reading: each primitive of triangles, strips or fans becomes a part.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::Path;

use serde_json::{Map, Value};
use tristrip::{Attribute, Faces, Mesh};

use super::accessor::{Budget, Source, check_views, undeclared_restart};
use super::document::{self, Place, array, format_error};
use super::{PrimitiveAt, Scene, TRIANGLE_FAN, TRIANGLE_STRIP, TRIANGLES, buffer, container};
use crate::error::Error;
use crate::model::{Model, Part, Stored};

/// Decoded bytes allowed for each byte of the buffers: strips of byte indices take twelve.
const GEOMETRY_FACTOR: u64 = 16;
const ATTRIBUTE_FACTOR: u64 = 4;

/// Extensions that say something about the order of indices, and lose their meaning with it.
pub(super) const ORDER_EXTENSIONS: [&str; 3] =
    ["EXT_mesh_manifold", "EXT_mesh_primitive_edge_visibility", "EXT_mesh_primitive_restart"];

/// Extensions that hide a buffer view's bytes.
const COMPRESSIONS: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];
const DRACO: &str = "KHR_draco_mesh_compression";

/// Reads a GLB, or the JSON of a `.gltf` whose buffers are data URIs or files inside of `base_dir`.
///
/// # Errors
/// The bytes are no valid glTF 2.0 as far as the geometry needs it, decoding would take more than the limits, the
/// geometry is compressed, or a buffer's file cannot be read or lies elsewhere.
///
/// ```
/// let empty = br#"{"asset":{"version":"2.0"}}"#;
/// assert!(tristrip_io::gltf::read(empty.to_vec(), None)?.parts.is_empty());
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn read(bytes: impl Into<Vec<u8>>, base_dir: Option<&Path>) -> Result<Model, Error> {
    let mut notes = Vec::new();
    let container = container::open(bytes.into(), &mut notes)?;
    let mut root = document::parse(&container.file[container.json.clone()])?;
    let buffers = buffer::load(&mut root, &container.file, container.bin.as_ref(), base_dir)?;
    let source = Source { root: &root, buffers: &buffers };
    refuse_compressed_views(&root)?;
    check_views(&source)?;
    check_nodes(&root)?;
    let mut reader = Reader {
        positions: HashMap::new(),
        vertices: HashMap::new(),
        geometry: Budget::new(&buffers, GEOMETRY_FACTOR),
        attributes: Budget::new(&buffers, ATTRIBUTE_FACTOR),
        tally: Tally::default(),
        primitives: Vec::new(),
        source,
    };
    let parts = reader.parts()?;
    let Reader { tally, primitives, .. } = reader;
    tally.write(&root, &mut notes);
    note_document(&root, &mut notes)?;
    Ok(Model { parts, notes, scene: Some(Scene { root, buffers, primitives }) })
}

struct Reader<'a> {
    source: Source<'a>,
    /// Meshes without faces, by the accessor of their positions.
    positions: HashMap<usize, Mesh>,
    /// The same with the other attributes, by name and accessor of them all: primitives that have the same share them.
    vertices: HashMap<Vec<(&'a str, usize)>, Mesh>,
    geometry: Budget,
    attributes: Budget,
    tally: Tally,
    primitives: Vec<PrimitiveAt>,
}

/// What was seen on the way and belongs into the notes.
#[derive(Default)]
struct Tally {
    other_modes: u64,
    degenerate: u64,
    restarts: u64,
    loose_corners: u64,
    attributes_over_budget: u64,
    matrix_attributes: u64,
}

impl<'a> Reader<'a> {
    fn parts(&mut self) -> Result<Vec<Part>, Error> {
        let mut parts = Vec::new();
        for (mesh, place) in Place::entries(self.source.root, "meshes")?.enumerate() {
            let name = place.field("name").and_then(|n| n.value.as_str()).map(str::to_owned);
            for (primitive, place) in place.need("primitives")?.items()?.enumerate() {
                let mode = match place.field("mode") {
                    None => TRIANGLES,
                    Some(mode) => match mode.whole()? {
                        known @ 0..=TRIANGLE_FAN => known,
                        _ => return Err(mode.wrong("0 to 6")),
                    },
                };
                if mode < TRIANGLES {
                    self.tally.other_modes += 1;
                    continue;
                }
                let (mesh_of_part, stored) = self.mesh(&place, mode)?;
                self.primitives.push(PrimitiveAt { mesh, primitive, mode });
                let material = self.material(&place)?;
                let stripped = mode == TRIANGLE_STRIP || mode == TRIANGLE_FAN;
                parts.push(Part { name: name.clone(), material, mesh: mesh_of_part, stripped, stored });
            }
        }
        Ok(parts)
    }

    fn material(&self, primitive: &Place<'a>) -> Result<Option<String>, Error> {
        let Some(material) = primitive.field("material") else { return Ok(None) };
        let place = material.target(self.source.root, "materials")?;
        Ok(place.field("name").and_then(|n| n.value.as_str()).map(str::to_owned))
    }

    fn mesh(&mut self, primitive: &Place<'a>, mode: u64) -> Result<(Mesh, Option<Stored>), Error> {
        let extensions = primitive.field("extensions");
        if extensions.and_then(|e| e.field(DRACO)).is_some() {
            return Err(Error::Unsupported(format!("{}: {DRACO} is not supported", primitive.at)));
        }
        // 1. Vertices, shared between primitives and checked once.
        let vertices = self.vertices(&primitive.need("attributes")?)?;
        // 2. Indices: those of the file, or every vertex in order.
        let vertex_count = vertices.vertex_count();
        let indices = if let Some(indices) = primitive.field("indices") {
            let values = self.source.values(&indices)?;
            values.indices(vertex_count, mode != TRIANGLES, &mut self.geometry)?
        } else {
            self.afford(primitive, vertex_count, size_of::<u32>())?;
            (0..vertex_count as u32).collect()
        };
        // 3. Triangles.
        let (corners, stored) = if mode == TRIANGLES {
            let mut corners = indices;
            let loose = corners.len() % 3;
            self.tally.loose_corners += loose as u64;
            corners.truncate(corners.len() - loose);
            (corners, None)
        } else {
            self.afford(primitive, indices.len(), 3 * size_of::<u32>())?;
            let stored = Stored::new(&indices, u32::MAX, mode == TRIANGLE_FAN);
            (self.unpack(&indices, mode), Some(stored))
        };
        Ok((vertices.with_faces(Faces::from_triangles(corners)?)?, stored))
    }

    /// Decodes positions and attributes, unless a primitive before had the same.
    fn vertices(&mut self, attributes: &Place<'a>) -> Result<Mesh, Error> {
        let position = attributes.need("POSITION")?;
        let key = attributes.members()?.map(|(name, place)| Ok((name, place.size()?)));
        let key = key.collect::<Result<Vec<_>, Error>>()?;
        if let Some(known) = self.vertices.get(&key) {
            return Ok(known.clone());
        }
        let mut mesh = match self.positions.entry(position.size()?) {
            Entry::Occupied(known) => known.get().clone(),
            Entry::Vacant(new) => {
                let values = self.source.values(&position)?;
                let decoded = values.positions(self.source.root, &mut self.geometry)?;
                new.insert(Mesh::new(decoded, Faces::default())?).clone()
            }
        };
        let vertex_count = mesh.vertex_count();
        for (name, place) in attributes.members()?.filter(|(name, _)| *name != "POSITION") {
            if let Some(attribute) = self.attribute(name, &place, vertex_count)? {
                mesh = mesh.with_attribute(attribute)?;
            }
        }
        self.vertices.insert(key, mesh.clone());
        Ok(mesh)
    }

    fn attribute(
        &mut self,
        name: &str,
        place: &Place<'a>,
        vertex_count: usize,
    ) -> Result<Option<Attribute>, Error> {
        let values = self.source.values(place)?;
        if values.count != vertex_count {
            let expected = format!("{vertex_count}, one for each vertex");
            return Err(format_error(format!("{}.count", values.at), values.count.to_string(), expected));
        }
        if values.matrix {
            self.tally.matrix_attributes += 1;
            return Ok(None);
        }
        if self.attributes.take(values.count, values.components * values.component.bytes()).is_err() {
            self.tally.attributes_over_budget += 1;
            return Ok(None);
        }
        Ok(Some(Attribute {
            name: name.to_owned(),
            components: values.components as u8,
            normalized: values.normalized,
            data: values.attribute(),
        }))
    }

    /// Unpacks strips or fans between restarts; triangles with a repeated corner draw nothing and are left out.
    fn unpack(&mut self, indices: &[u32], mode: u64) -> Vec<u32> {
        let mut corners = Vec::with_capacity(3 * indices.len());
        for run in indices.split(|&i| i == u32::MAX) {
            self.tally.restarts += 1;
            for i in 2..run.len() {
                let [a, b, c] = if mode == TRIANGLE_FAN {
                    [run[0], run[i - 1], run[i]]
                } else if i % 2 == 0 {
                    [run[i - 2], run[i - 1], run[i]]
                } else {
                    [run[i - 1], run[i - 2], run[i]]
                };
                if a == b || b == c || a == c {
                    self.tally.degenerate += 1;
                } else {
                    corners.extend([a, b, c]);
                }
            }
        }
        self.tally.restarts -= 1;
        debug_assert!(mode == TRIANGLE_FAN || mode == TRIANGLE_STRIP);
        corners
    }

    fn afford(&mut self, place: &Place<'_>, count: usize, bytes_each: usize) -> Result<(), Error> {
        self.geometry.take(count, bytes_each).map_err(|(found, limit)| Error::LimitExceeded {
            at: format!("{}, bytes decoded up to here", place.at),
            found,
            limit,
        })
    }
}

impl Tally {
    fn write(&self, root: &Map<String, Value>, notes: &mut Vec<String>) {
        let mut note = |text: &str, count: u64| {
            if count > 0 {
                notes.push(format!("{text}: {count}"));
            }
        };
        note("primitives of points or lines, kept in a GLB alone", self.other_modes);
        note("degenerate triangles of strips and fans left out, which draw nothing", self.degenerate);
        note("indices at the end of triangle lists left out, which make no triangle", self.loose_corners);
        note(
            "vertex attributes not decoded for their size, kept in a GLB alone",
            self.attributes_over_budget,
        );
        note("vertex attributes of matrices not decoded, kept in a GLB alone", self.matrix_attributes);
        notes.extend(undeclared_restart(root, self.restarts));
    }
}

fn refuse_compressed_views(root: &Map<String, Value>) -> Result<(), Error> {
    for (index, view) in array(root, "bufferViews")?.iter().enumerate() {
        let Some(Value::Object(extensions)) = view.get("extensions") else { continue };
        if let Some(name) = COMPRESSIONS.iter().find(|name| extensions.contains_key(**name)) {
            return Err(Error::Unsupported(format!("bufferViews[{index}]: {name} is not supported")));
        }
    }
    Ok(())
}

/// Checks that children exist and that no node is its own ancestor.
fn check_nodes(root: &Map<String, Value>) -> Result<(), Error> {
    let count = array(root, "nodes")?.len();
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); count];
    let mut parent_count = vec![0u32; count];
    for (list, node) in children.iter_mut().zip(Place::entries(root, "nodes")?) {
        let Some(place) = node.field("children") else { continue };
        for child in place.items()? {
            let index = child.size()?;
            let Some(parents) = parent_count.get_mut(index) else {
                return Err(child.wrong(format!("less than {count}, the number of nodes")));
            };
            *parents += 1;
            list.push(index);
        }
    }
    // Nodes without a parent left are taken away until none is left, or only cycles are.
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
        return Err(format_error(format!("nodes[{node}]"), "a cycle of children", "a tree"));
    }
    Ok(())
}

/// Notes what a GLB written from this document will have otherwise, beside indices and modes.
fn note_document(root: &Map<String, Value>, notes: &mut Vec<String>) -> Result<(), Error> {
    let buffer_count = array(root, "buffers")?.len();
    if buffer_count > 1 {
        notes.push(format!("buffers, joined into one in a GLB: {buffer_count}"));
    }
    let external = array(root, "images")?
        .iter()
        .filter_map(|image| image.get("uri").and_then(Value::as_str))
        .filter(|uri| !uri.starts_with("data:"))
        .count();
    if external > 0 {
        notes.push(format!("images in files of their own, which a GLB goes on naming: {external}"));
    }
    for name in ORDER_EXTENSIONS.iter().filter(|name| document::uses(root, name)) {
        notes.push(format!("{name} describes the order of indices: dropped from meshes that get new ones"));
    }
    Ok(())
}
