//! Known and possible references to accessors and buffer views in a document.

use std::collections::HashSet;

use crate::gltf::document::json::{JsonContent, Members, Value};

use crate::error::Error;
use crate::gltf::document::spec::{LEVELS_OF_DETAIL, SCREEN_COVERAGE};
use crate::gltf::document::{array, index, items};

/// Extensions whose numbers are all known: none refers to an accessor or a buffer view. Numbers
/// inside their own extensions and extras still count.
const WITHOUT_REFERENCES: [&str; 8] = [
    "EXT_lights_image_based",
    "EXT_texture_avif",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_mesh_quantization",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    LEVELS_OF_DETAIL,
];

/// Name prefix of further extensions of this kind.
const MATERIALS: &str = "KHR_materials_";

/// Numbers inside extensions and extras. Any of them may be a reference.
#[derive(Default)]
pub(in crate::gltf) struct ExtensionNumbers {
    pub(in crate::gltf) numbers: HashSet<usize>,
    /// Whether an extension may refer to bytes of a buffer.
    pub(in crate::gltf) names_bytes: bool,
}

impl ExtensionNumbers {
    /// Collects the numbers of a document.
    pub(in crate::gltf) fn of(root: &Members) -> Self {
        let mut found = Self::default();
        root.iter().for_each(|(key, value)| found.add(key, value, false));
        found
    }

    fn add(&mut self, key: &str, value: &Value, inside: bool) {
        if key == SCREEN_COVERAGE {
            return;
        }
        self.names_bytes |= inside && matches!(key, "buffer" | "byteOffset" | "byteLength");
        match &value.content {
            JsonContent::Object(members) if key == "extensions" => {
                members.iter().for_each(|(name, extension)| {
                    self.add(
                        "",
                        extension,
                        !WITHOUT_REFERENCES.contains(&name) && !name.starts_with(MATERIALS),
                    );
                })
            }
            JsonContent::Object(members) => {
                members.iter().for_each(|(k, v)| self.add(k, v, inside || key == "extras"));
            }
            JsonContent::Array(items) => {
                items.iter().for_each(|v| self.add("", v, inside || key == "extras"))
            }
            JsonContent::Whole(_) | JsonContent::Number(_) if inside || key == "extras" => {
                self.numbers.extend(index(value))
            }
            _ => {}
        }
    }
}

/// Checks whether a value contains a number that may be an index.
pub(in crate::gltf) fn has_number(value: &Value) -> bool {
    match &value.content {
        JsonContent::Array(items) => items.iter().any(has_number),
        JsonContent::Object(members) => members.values().any(has_number),
        _ => index(value).is_some(),
    }
}

/// Iterates over the buffer views that an accessor refers to.
pub(in crate::gltf) fn views_of_accessor(root: &Members, accessor: usize) -> impl Iterator<Item = usize> {
    let accessor = array(root, "accessors").ok().and_then(|all| all.get(accessor));
    let sparse = accessor.and_then(|accessor| accessor.get("sparse"));
    let holders = [accessor, sparse.and_then(|s| s.get("indices")), sparse.and_then(|s| s.get("values"))];
    holders.into_iter().flatten().filter_map(|holder| index(holder.get("bufferView")?))
}

/// Returns the accessors that skins and animations refer to.
pub(in crate::gltf) fn skin_and_animation_accessors(root: &Members) -> Result<HashSet<usize>, Error> {
    let mut used = HashSet::new();
    for skin in array(root, "skins")? {
        used.extend(skin.get("inverseBindMatrices").and_then(index));
    }
    for animation in array(root, "animations")? {
        for sampler in items(animation, "samplers") {
            used.extend(["input", "output"].iter().filter_map(|key| sampler.get(key)).filter_map(index));
        }
    }
    Ok(used)
}

/// Returns the accessors of positions, including those of morph targets.
pub(in crate::gltf) fn position_accessors(root: &Members) -> Result<HashSet<usize>, Error> {
    let primitives = array(root, "meshes")?.iter().flat_map(|mesh| items(mesh, "primitives"));
    let objects = primitives.flat_map(|p| items(p, "targets").iter().chain(p.get("attributes")));
    Ok(objects.filter_map(|object| index(object.get("POSITION")?)).collect())
}
