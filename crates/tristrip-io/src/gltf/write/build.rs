//! Writes a model without a scene: builds a minimal document for the parts.
//!
//! # Attributes
//! `NORMAL`, `TANGENT`, `TEXCOORD_n` and `COLOR_n` are written under these names if their values
//! meet the requirements of glTF: normals and tangents have unit length, colours are from 0 to 1,
//! and the numbers n are consecutive. All others become custom attributes with a leading
//! underscore; their values do not change. Attributes without a glTF type (64-bit floats, 32-bit
//! integers, more than four components, values that are not finite) are not written; [`losses`]
//! lists them.
//!
//! Texture coordinates have their origin at the bottom in OBJ and at the top in glTF, so `v`
//! becomes 1 − v.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;

use serde_json::{Value, json};
use tristrip::{Attribute, AttributeData, Layout, Mesh};

use crate::gltf::document::Document;
use crate::gltf::document::container::GlbContent;
use crate::gltf::document::json::{JsonContent, Members};
use crate::gltf::document::spec::ComponentType;
use crate::gltf::document::spec::{ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER, RESTART_EXTENSION};
use crate::gltf::write::index::{IndexRun, pack_runs, runs};
use crate::gltf::write::material_builder::{JPEG, MaterialBuilder};
use crate::join;
use crate::le_bytes::{append, fill_rows};
use crate::materials::SideFile;
use crate::model::{Drawing, Model, Part};

/// Maximum difference between the length of a normal and 1; the Khronos validator allows 0.00674.
const UNIT_TOLERANCE: f64 = 0.006;

/// Lists the data of a model that a GLB cannot store, or stores in another form, with counts. Empty
/// for a model with a scene, which loses nothing. There is one drawing per part.
pub(crate) fn losses(model: &Model, drawings: &[Drawing<'_>]) -> Vec<String> {
    if model.scene.is_some() {
        return Vec::new();
    }
    let mut empty = 0;
    let mut attributes: BTreeMap<String, usize> = BTreeMap::new();
    for mesh in model.parts.iter().map(|part| &part.mesh) {
        if mesh.vertex_count() == 0 {
            empty += 1;
            continue;
        }
        for (attribute, chosen) in mesh.attributes().iter().zip(attribute_names(mesh)) {
            let name = &attribute.name;
            let words = match chosen {
                Err(why) => format!("attribute `{name}` not written: {why}"),
                Ok(new) if new != *name => format!("attribute `{name}` written as `{new}`"),
                Ok(_) => continue,
            };
            *attributes.entry(words).or_default() += 1;
        }
    }
    let polygons_of = |part: &Part| part.mesh.faces().iter().filter(|face| face.len() > 3).count();
    let polygons: usize = join::drawn_by_faces(model, drawings).map(polygons_of).sum();
    let counts = [
        ("parts without vertices, not written".to_owned(), empty),
        ("polygons cut into fans".to_owned(), polygons),
    ];
    let counted = counts.into_iter().filter(|(_, count)| *count > 0).chain(attributes);
    counted.map(|(words, count)| format!("{words}: {count}")).collect()
}

/// Builds the minimal document. The caller has checked the drawings.
pub(in crate::gltf) fn build(model: &Model, drawings: &[Drawing<'_>], layout: Layout) -> GlbContent {
    let flips = model.materials.as_ref().is_some_and(|materials| !materials.counts_down);
    let mut builder = DocumentBuilder { flips, ..DocumentBuilder::default() };
    let mut meshes: Vec<Value> = Vec::new();
    let mut names: Vec<Option<&str>> = Vec::new();
    let mut materials = MaterialBuilder::new(model.materials.as_ref());
    let mut restarts = false;
    for (part, drawing) in model.parts.iter().zip(drawings) {
        let mesh = &part.mesh;
        if mesh.vertex_count() == 0 {
            continue;
        }
        // 1. One mesh per run of parts with the same name.
        let name = part.name.as_deref();
        if names.last() != Some(&name) {
            names.push(name);
            let mut object = json!({ "primitives": [] });
            if let Some(name) = name {
                object["name"] = name.into();
            }
            meshes.push(object);
        }
        // 2. The members shared by the primitives of the part.
        let mut common = json!({ "attributes": builder.attributes(mesh) });
        if let Some(material) = part.material.as_deref() {
            let has_coordinates = common["attributes"].get("TEXCOORD_0").is_some();
            common["material"] = materials.id(material, has_coordinates).into();
        }
        // 3. Indices.
        let runs = runs(mesh, *drawing, layout);
        restarts |= runs.iter().any(IndexRun::has_restarts);
        let accessors = builder.indices(&runs);
        let Some(Value::Array(primitives)) = meshes.last_mut().and_then(|m| m.get_mut("primitives")) else {
            continue;
        };
        for (run, accessor) in runs.iter().zip(accessors) {
            let mut primitive = common.clone();
            primitive["indices"] = accessor.into();
            primitive["mode"] = run.mode.into();
            primitives.push(primitive);
        }
    }
    builder.finish(meshes, &names, materials, restarts)
}

/// Collects the values of meshes, their buffer views and accessors.
#[derive(Default)]
pub(in crate::gltf) struct DocumentBuilder<'a> {
    /// Whether the origin of texture coordinates is at the bottom.
    flips: bool,
    pub(in crate::gltf) bytes: Vec<u8>,
    pub(in crate::gltf) views: Vec<Value>,
    pub(in crate::gltf) accessors: Vec<Value>,
    /// Accessors by the address of the position array, which the model keeps alive. Parts that
    /// share an array share its accessor.
    shared: HashMap<*const Vec<[f32; 3]>, SharedPositions<'a>>,
}

/// The accessors over one position array.
struct SharedPositions<'a> {
    accessor: usize,
    /// The last written attribute of each name for these positions.
    attributes: BTreeMap<String, (&'a Attribute, usize)>,
}

impl<'a> DocumentBuilder<'a> {
    fn view(&mut self, start: usize, target: u32, stride: Option<usize>) -> usize {
        let mut view = json!({
            "buffer": 0, "byteOffset": start, "byteLength": self.bytes.len() - start, "target": target,
        });
        if let Some(stride) = stride {
            view["byteStride"] = stride.into();
        }
        self.views.push(view);
        self.align();
        self.views.len() - 1
    }

    fn align(&mut self) {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Writes positions and attributes, or reuses those of an earlier part. Returns the accessors
    /// by name.
    fn attributes(&mut self, mesh: &'a Mesh) -> Value {
        let positions = mesh.shared_positions();
        let key = Arc::as_ptr(&positions);
        let accessor = match self.shared.get(&key) {
            Some(shared) => shared.accessor,
            None => self.positions(mesh.positions()),
        };
        let mut shared = self
            .shared
            .remove(&key)
            .unwrap_or_else(|| SharedPositions { accessor, attributes: BTreeMap::new() });
        let mut names = json!({ "POSITION": accessor });
        for (attribute, chosen) in mesh.attributes().iter().zip(attribute_names(mesh)) {
            let Ok(name) = chosen else { continue };
            let accessor = match shared.attributes.get(&name) {
                Some((same, accessor)) if std::ptr::eq(*same, attribute) || *same == attribute => *accessor,
                _ => self.attribute(attribute, mesh.vertex_count()),
            };
            names[&name] = accessor.into();
            shared.attributes.insert(name, (attribute, accessor));
        }
        self.shared.insert(key, shared);
        names
    }

    pub(in crate::gltf) fn positions(&mut self, positions: &[[f32; 3]]) -> usize {
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        let start = self.bytes.len();
        append(&mut self.bytes, positions.as_flattened(), f32::to_le_bytes);
        for p in positions {
            for (axis, &x) in p.iter().enumerate() {
                low[axis] = low[axis].min(x);
                high[axis] = high[axis].max(x);
            }
        }
        let view = self.view(start, ARRAY_BUFFER, None);
        self.accessor(json!({
            "bufferView": view,
            "componentType": ComponentType::F32.code(),
            "count": positions.len(),
            "type": "VEC3",
            "min": low.map(f64::from),
            "max": high.map(f64::from),
        }))
    }

    pub(in crate::gltf) fn attribute(&mut self, attribute: &Attribute, count: usize) -> usize {
        let components = usize::from(attribute.components);
        let start = self.bytes.len();
        let flips = self.flips && components == 2 && attribute.name.starts_with("TEXCOORD_");
        let component = match &attribute.data {
            AttributeData::U8(v) if flips && attribute.normalized => {
                let flipped = flipped(v, |x| u8::MAX - x);
                self.values(&flipped, components, ComponentType::U8, u8::to_le_bytes)
            }
            AttributeData::U16(v) if flips && attribute.normalized => {
                let flipped = flipped(v, |x| u16::MAX - x);
                self.values(&flipped, components, ComponentType::U16, u16::to_le_bytes)
            }
            AttributeData::U8(v) => self.values(v, components, ComponentType::U8, u8::to_le_bytes),
            AttributeData::I8(v) => self.values(v, components, ComponentType::I8, i8::to_le_bytes),
            AttributeData::U16(v) => self.values(v, components, ComponentType::U16, u16::to_le_bytes),
            AttributeData::I16(v) => self.values(v, components, ComponentType::I16, i16::to_le_bytes),
            AttributeData::F32(v) if flips => {
                let flipped = flipped(v, |x| 1.0 - x);
                self.values(&flipped, components, ComponentType::F32, f32::to_le_bytes)
            }
            AttributeData::F32(v) => self.values(v, components, ComponentType::F32, f32::to_le_bytes),
            // `attribute_names` has excluded these.
            AttributeData::F64(_) | AttributeData::U32(_) | AttributeData::I32(_) => ComponentType::F32,
        };
        let element = components * component.bytes();
        let stride = element.next_multiple_of(4);
        let view = self.view(start, ARRAY_BUFFER, (stride != element).then_some(stride));
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][components - 1];
        let mut accessor = json!({
            "bufferView": view,
            "componentType": component.code(),
            "count": count,
            "type": kind,
        });
        if attribute.normalized && component.bytes() < 4 {
            accessor["normalized"] = true.into();
        }
        self.accessor(accessor)
    }

    /// Appends values, aligned to four bytes per vertex.
    fn values<T: Copy, const N: usize>(
        &mut self,
        values: &[T],
        components: usize,
        component: ComponentType,
        bytes: impl Fn(T) -> [u8; N],
    ) -> ComponentType {
        let stride = (components * N).next_multiple_of(4);
        let start = self.bytes.len();
        self.bytes.resize(start + values.len() / components * stride, 0);
        fill_rows(&mut self.bytes[start..], stride, 0, values, components, bytes);
        component
    }

    pub(in crate::gltf) fn indices(&mut self, runs: &[IndexRun<'_>]) -> Vec<usize> {
        let start = self.bytes.len();
        let offsets = pack_runs(runs, &mut self.bytes);
        let view = self.view(start, ELEMENT_ARRAY_BUFFER, None);
        runs.iter().zip(offsets).map(|(run, offset)| self.accessor(run.accessor(view, offset))).collect()
    }

    /// Appends the bytes of images and returns their entries.
    fn images(&mut self, images: &[&SideFile]) -> Vec<Value> {
        let mut entries = Vec::with_capacity(images.len());
        for image in images {
            let start = self.bytes.len();
            self.bytes.extend_from_slice(&image.bytes);
            self.views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": image.bytes.len() }));
            self.align();
            let kind = if image.bytes.starts_with(JPEG) { "image/jpeg" } else { "image/png" };
            entries.push(json!({ "name": image.name, "bufferView": self.views.len() - 1, "mimeType": kind }));
        }
        entries
    }

    fn finish(
        mut self,
        meshes: Vec<Value>,
        names: &[Option<&str>],
        materials: MaterialBuilder<'_>,
        restarts: bool,
    ) -> GlbContent {
        let mut root = json!({ "asset": { "version": "2.0", "generator": "tristrip" } });
        if restarts {
            root["extensionsUsed"] = json!([RESTART_EXTENSION]);
            root["extensionsRequired"] = json!([RESTART_EXTENSION]);
        }
        if !meshes.is_empty() {
            let nodes = names.iter().enumerate().map(|(mesh, name)| match name {
                Some(name) => json!({ "name": name, "mesh": mesh }),
                None => json!({ "mesh": mesh }),
            });
            root["scene"] = 0.into();
            root["scenes"] = json!([{ "nodes": (0..meshes.len()).collect::<Vec<_>>() }]);
            root["nodes"] = nodes.collect();
            root["meshes"] = meshes.into();
            materials.add_to(&mut root, |images| self.images(images));
            root["accessors"] = self.accessors.into();
            root["bufferViews"] = self.views.into();
            root["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        }
        let root = match crate::gltf::document::json::Value::from(root).content {
            JsonContent::Object(members) => members,
            _ => Members::default(),
        };
        GlbContent { document: Document::of_members(root), buffer: self.bytes.into() }
    }
}

/// Returns texture coordinates with `flip` applied to each v.
fn flipped<T: Copy>(values: &[T], flip: impl Fn(T) -> T) -> Vec<T> {
    values.iter().enumerate().map(|(i, &x)| if i % 2 == 1 { flip(x) } else { x }).collect()
}

/// Returns the name under which each attribute of a mesh is written, or the reason why it is not.
fn attribute_names(mesh: &Mesh) -> Vec<Result<String, String>> {
    let attributes = mesh.attributes();
    let mut core: Vec<bool> = attributes.iter().map(is_core).collect();
    let named = |core: &[bool], name: &str| (attributes.iter().zip(core)).any(|(a, &c)| c && a.name == name);
    // Numbered names must be consecutive; tangents need normals.
    for prefix in ["TEXCOORD_", "COLOR_"] {
        let end = (0..attributes.len())
            .find(|n| !named(&core, &format!("{prefix}{n}")))
            .unwrap_or(attributes.len());
        for (attribute, core) in attributes.iter().zip(&mut core) {
            if let Some(number) = attribute.name.strip_prefix(prefix) {
                *core &= number.parse::<usize>().is_ok_and(|n| n < end);
            }
        }
    }
    if !named(&core, "NORMAL") {
        for (attribute, core) in attributes.iter().zip(&mut core) {
            *core &= attribute.name != "TANGENT";
        }
    }
    let mut taken: BTreeSet<String> = BTreeSet::from(["POSITION".to_owned()]);
    let choose = |(attribute, core): (&Attribute, bool)| {
        let name = match core {
            true => attribute.name.clone(),
            false if attribute.name.starts_with('_') => attribute.name.clone(),
            false => format!("_{}", attribute.name),
        };
        check_writable(attribute)?;
        if taken.insert(name.clone()) {
            Ok(name)
        } else {
            Err(format!("another attribute is written as `{name}`"))
        }
    };
    attributes.iter().zip(core).map(choose).collect()
}

/// Checks that glTF has a type for an attribute.
pub(in crate::gltf) fn check_writable(attribute: &Attribute) -> Result<(), String> {
    if !(1..=4).contains(&attribute.components) {
        return Err(format!("it has {} components; glTF allows 1 to 4", attribute.components));
    }
    match &attribute.data {
        AttributeData::F64(_) | AttributeData::U32(_) | AttributeData::I32(_) => {
            Err("glTF has no 64-bit floats or 32-bit integers for vertices".into())
        }
        AttributeData::F32(values) if !values.iter().all(|x| x.is_finite()) => {
            Err("it has values that are not finite".into())
        }
        _ => Ok(()),
    }
}

/// Checks whether an attribute meets the requirements of glTF for its name, except consecutive
/// numbering.
fn is_core(attribute: &Attribute) -> bool {
    let floats = match &attribute.data {
        AttributeData::F32(values) => Some(values.as_slice()),
        _ => None,
    };
    let fraction =
        attribute.normalized && matches!(attribute.data, AttributeData::U8(_) | AttributeData::U16(_));
    let unit = |v: &[f32]| {
        let length = v.iter().map(|&x| f64::from(x) * f64::from(x)).sum::<f64>().sqrt();
        (length - 1.0).abs() <= UNIT_TOLERANCE
    };
    #[allow(clippy::float_cmp, reason = "the sign is exact")]
    let tangent = |v: &[f32]| unit(&v[..3]) && v[3].abs() == 1.0;
    match (attribute.name.as_str(), attribute.components) {
        ("NORMAL", 3) => floats.is_some_and(|v| v.chunks_exact(3).all(unit)),
        ("TANGENT", 4) => floats.is_some_and(|v| v.chunks_exact(4).all(tangent)),
        (name, 2) if is_numbered(name, "TEXCOORD_") => fraction || floats.is_some(),
        (name, 3 | 4) if is_numbered(name, "COLOR_") => {
            fraction || floats.is_some_and(|v| v.iter().all(|x| (0.0..=1.0).contains(x)))
        }
        _ => false,
    }
}

/// Checks whether a name consists of a prefix and a number without leading zeros.
fn is_numbered(name: &str, prefix: &str) -> bool {
    name.strip_prefix(prefix).is_some_and(|n| n.parse::<u32>().is_ok_and(|number| number.to_string() == n))
}
