//! The entries of a document that only the old indices use.

use std::collections::HashSet;

use crate::gltf::json::Members;

use crate::error::Error;
use crate::gltf::document::{array, index, items, values};
use crate::gltf::references::{ExtensionNumbers, skin_and_animation_accessors};

/// Accessors and buffer views that nothing refers to once the old indices are replaced.
pub(super) struct UnusedEntries {
    pub(super) accessors: HashSet<usize>,
    pub(super) views: HashSet<usize>,
    /// Whether an extension may name bytes of a buffer.
    pub(super) bytes_named: bool,
}

impl UnusedEntries {
    /// Finds them; `rewritten` has the mesh and number of each primitive with new indices.
    pub(super) fn find(root: &Members, rewritten: &HashSet<(usize, usize)>) -> Result<Self, Error> {
        let possible = ExtensionNumbers::of(root);

        // Accessors: old indices, except those that something else refers to.
        let mut pinned = possible.numbers.clone();
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
        pinned.extend(skin_and_animation_accessors(root)?);
        let accessors: HashSet<usize> = old.difference(&pinned).copied().collect();

        // Views: those of unused accessors, except those that something else refers to.
        let mut pinned = possible.numbers;
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
        Ok(Self { accessors, views, bytes_named: possible.names_bytes })
    }
}
