//! What of a document only the old indices need.

use std::collections::HashSet;

use serde_json::{Map, Value};

use crate::error::Error;
use crate::gltf::document::{array, index, items, values};

/// Accessors and views that nobody refers to once the new indices are in place.
pub(super) struct Free {
    pub(super) accessors: HashSet<usize>,
    pub(super) views: HashSet<usize>,
    /// Whether an extension may name bytes of a buffer.
    pub(super) bytes_named: bool,
}

impl Free {
    pub(super) fn find(
        root: &Map<String, Value>,
        rewritten: &HashSet<(usize, usize)>,
    ) -> Result<Self, Error> {
        let loose = Loose::of(root);

        // Accessors: old indices, less everything else that is referred to.
        let mut pinned = loose.numbers.clone();
        let mut old = HashSet::new();
        for (m, mesh) in array(root, "meshes")?.iter().enumerate() {
            for (p, primitive) in items(mesh, "primitives").iter().enumerate() {
                let sink = if rewritten.contains(&(m, p)) { &mut old } else { &mut pinned };
                sink.extend(primitive.get("indices").and_then(index));
                pinned.extend(primitive.get("attributes").into_iter().flat_map(values).filter_map(index));
                for target in items(primitive, "targets") {
                    pinned.extend(values(target).filter_map(index));
                }
            }
        }
        for skin in array(root, "skins")? {
            pinned.extend(skin.get("inverseBindMatrices").and_then(index));
        }
        for animation in array(root, "animations")? {
            for sampler in items(animation, "samplers") {
                pinned.extend(["input", "output"].iter().filter_map(|k| sampler.get(*k)).filter_map(index));
            }
        }
        let accessors: HashSet<usize> = old.difference(&pinned).copied().collect();

        // Views: those of free accessors, less everything else that is referred to.
        let mut pinned = loose.numbers;
        let mut old = HashSet::new();
        for (a, accessor) in array(root, "accessors")?.iter().enumerate() {
            let sink = if accessors.contains(&a) { &mut old } else { &mut pinned };
            sink.extend(accessor.get("bufferView").and_then(index));
            for part in ["indices", "values"] {
                let view = accessor.get("sparse").and_then(|s| s.get(part)?.get("bufferView"));
                pinned.extend(view.and_then(index));
            }
        }
        for image in array(root, "images")? {
            pinned.extend(image.get("bufferView").and_then(index));
        }
        let views = old.difference(&pinned).copied().collect();
        Ok(Self { accessors, views, bytes_named: loose.bytes_named })
    }
}

/// Numbers inside of extensions and extras.
#[derive(Default)]
pub(super) struct Loose {
    numbers: HashSet<usize>,
    pub(super) bytes_named: bool,
}

impl Loose {
    pub(super) fn of(root: &Map<String, Value>) -> Self {
        let mut loose = Self::default();
        root.iter().for_each(|(key, value)| loose.member(key, value, false));
        loose
    }

    fn member(&mut self, key: &str, value: &Value, inside: bool) {
        let inside_now = inside || key == "extensions" || key == "extras";
        self.bytes_named |= inside && matches!(key, "buffer" | "byteOffset" | "byteLength");
        match value {
            Value::Object(members) => members.iter().for_each(|(k, v)| self.member(k, v, inside_now)),
            Value::Array(items) => items.iter().for_each(|v| self.member("", v, inside_now)),
            Value::Number(_) if inside_now => self.numbers.extend(index(value)),
            _ => {}
        }
    }
}
