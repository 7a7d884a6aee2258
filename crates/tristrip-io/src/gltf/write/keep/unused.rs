//! Finds the entries of a document that are used only by replaced data.

use std::collections::HashSet;

use crate::gltf::document::json::Members;

use crate::error::Error;
use crate::gltf::document::references::{ExtensionNumbers, skin_and_animation_accessors};
use crate::gltf::document::{array, index, items, values};

/// The replaced data of primitives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::gltf) enum Replaced {
    Indices,
    IndicesAndVertices,
}

/// Accessors and buffer views that become unused when indices, or indices and vertices, are
/// replaced.
pub(in crate::gltf) struct UnusedEntries {
    pub(in crate::gltf) accessors: HashSet<usize>,
    pub(in crate::gltf) views: HashSet<usize>,
    /// Whether an extension may refer to bytes of a buffer.
    pub(super) bytes_named: bool,
}

impl UnusedEntries {
    /// Finds the unused entries. `rewritten` has the mesh and primitive index of each changed
    /// primitive.
    pub(in crate::gltf) fn find(
        root: &Members,
        rewritten: &HashSet<(usize, usize)>,
        replaced: Replaced,
    ) -> Result<Self, Error> {
        let possible = ExtensionNumbers::of(root);

        // Accessors: old ones without another reference.
        let mut pinned = possible.numbers.clone();
        let mut old = HashSet::new();
        for (m, mesh) in array(root, "meshes")?.iter().enumerate() {
            for (p, primitive) in items(mesh, "primitives").iter().enumerate() {
                let is_rewritten = rewritten.contains(&(m, p));
                let sink = if is_rewritten { &mut old } else { &mut pinned };
                sink.extend(primitive.get("indices").and_then(index));
                let replaces_vertices = is_rewritten && replaced == Replaced::IndicesAndVertices;
                let sink = if replaces_vertices { &mut old } else { &mut pinned };
                sink.extend(primitive.get("attributes").into_iter().flat_map(values).filter_map(index));
                for target in items(primitive, "targets") {
                    pinned.extend(values(target).filter_map(index));
                }
            }
        }
        pinned.extend(skin_and_animation_accessors(root)?);
        let accessors: HashSet<usize> = old.difference(&pinned).copied().collect();

        // Views: those of unused accessors without another reference.
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
