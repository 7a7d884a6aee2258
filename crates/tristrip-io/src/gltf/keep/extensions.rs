//! The extensions that new indices need, or make invalid.

use std::collections::HashSet;

use serde_json::{Map, Value};

use crate::error::Error;
use crate::gltf::document::{array, items, list_mut, uses, whole};
use crate::gltf::spec::ORDER_EXTENSIONS;

/// Removes extensions that describe the order of indices from the meshes whose indices are new.
pub(super) fn drop_order_extensions(
    root: &mut Map<String, Value>,
    rewritten: &HashSet<(usize, usize)>,
) -> Result<(), Error> {
    if !ORDER_EXTENSIONS.iter().any(|name| uses(root, name)) {
        return Ok(());
    }
    let rewritten_meshes: HashSet<usize> = rewritten.iter().map(|&(mesh, _)| mesh).collect();
    let mut still_used: HashSet<&str> = HashSet::new();
    for (m, mesh) in list_mut(root, "meshes")?.iter_mut().enumerate() {
        let mut remove = |object: &mut Value| {
            let Some(Value::Object(extensions)) = object.get_mut("extensions") else { return };
            for name in ORDER_EXTENSIONS {
                if rewritten_meshes.contains(&m) {
                    extensions.shift_remove(name);
                } else if extensions.contains_key(name) {
                    still_used.insert(name);
                }
            }
            if extensions.is_empty()
                && let Value::Object(members) = object
            {
                members.shift_remove("extensions");
            }
        };
        remove(mesh);
        if let Some(Value::Array(primitives)) = mesh.get_mut("primitives") {
            primitives.iter_mut().for_each(remove);
        }
    }
    for name in ORDER_EXTENSIONS.iter().filter(|name| !still_used.contains(*name)) {
        undeclare(root, name);
    }
    Ok(())
}

/// Checks whether there are line strips or loops, which may have restarts; triangle strips and fans are always rewritten.
pub(super) fn has_line_strips(root: &Map<String, Value>) -> Result<bool, Error> {
    Ok(array(root, "meshes")?.iter().any(|mesh| {
        items(mesh, "primitives").iter().any(|p| matches!(p.get("mode").and_then(whole), Some(2 | 3)))
    }))
}

/// Lists an extension as used and required.
pub(super) fn declare(root: &mut Map<String, Value>, name: &str) -> Result<(), Error> {
    for list in ["extensionsUsed", "extensionsRequired"] {
        let names = list_mut(root, list)?;
        if !names.iter().any(|n| n == name) {
            names.push(name.into());
        }
    }
    Ok(())
}

/// Removes an extension from both lists.
pub(super) fn undeclare(root: &mut Map<String, Value>, name: &str) {
    for list in ["extensionsUsed", "extensionsRequired"] {
        if let Some(Value::Array(names)) = root.get_mut(list) {
            let before = names.len();
            names.retain(|n| n != name);
            // An empty list is not allowed.
            if names.is_empty() && before > 0 {
                root.shift_remove(list);
            }
        }
    }
}
