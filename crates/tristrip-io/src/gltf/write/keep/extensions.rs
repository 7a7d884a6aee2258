//! Updates extensions that new indices require or invalidate.

use std::collections::HashSet;

use crate::gltf::document::json::{Members, Value};

use crate::error::Error;
use crate::gltf::document::spec::ORDER_EXTENSIONS;
use crate::gltf::document::{array, entries_mut, items, list_mut, uses, whole};

/// Removes extensions that describe the index order from the meshes with new indices.
pub(super) fn drop_order_extensions(
    root: &mut Members,
    rewritten: &HashSet<(usize, usize)>,
) -> Result<(), Error> {
    if !ORDER_EXTENSIONS.iter().any(|name| uses(root, name)) {
        return Ok(());
    }
    let rewritten_meshes: HashSet<usize> = rewritten.iter().map(|&(mesh, _)| mesh).collect();
    let mut still_used: HashSet<&str> = HashSet::new();
    for (m, mesh) in entries_mut(root, "meshes")?.iter_mut().enumerate() {
        if !rewritten_meshes.contains(&m) {
            still_used.extend(order_extensions(mesh));
            items(mesh, "primitives")
                .iter()
                .for_each(|primitive| still_used.extend(order_extensions(primitive)));
            continue;
        }
        remove_order_extensions(mesh);
        if items(mesh, "primitives").iter().any(|primitive| order_extensions(primitive).next().is_some()) {
            let primitives = mesh.as_object_mut().and_then(|mesh| mesh.get_mut("primitives")?.as_array_mut());
            primitives.into_iter().flatten().for_each(remove_order_extensions);
        }
    }
    for name in ORDER_EXTENSIONS.iter().filter(|name| !still_used.contains(*name)) {
        undeclare(root, name);
    }
    Ok(())
}

/// Iterates over the extensions of an object that describe the index order.
fn order_extensions(object: &Value) -> impl Iterator<Item = &'static str> {
    let extensions = object.get("extensions").and_then(Value::as_object);
    ORDER_EXTENSIONS.into_iter().filter(move |name| extensions.is_some_and(|e| e.contains_key(name)))
}

/// Removes the extensions of an object that describe the index order.
fn remove_order_extensions(object: &mut Value) {
    remove_extensions(object, &ORDER_EXTENSIONS);
}

/// Removes extensions of an object, and its member `extensions` if that becomes empty.
pub(in crate::gltf) fn remove_extensions(object: &mut Value, names: &[&str]) {
    let has = |extensions: &Members| names.iter().any(|name| extensions.contains_key(name));
    if !object.get("extensions").and_then(Value::as_object).is_some_and(has) {
        return;
    }
    let Some(members) = object.as_object_mut() else { return };
    let Some(extensions) = members.get_mut("extensions").and_then(Value::as_object_mut) else { return };
    names.iter().for_each(|name| extensions.remove(name));
    if extensions.is_empty() {
        members.remove("extensions");
    }
}

/// Checks whether there are line strips or loops, which may contain restarts. Triangle strips and
/// fans are always rewritten.
pub(super) fn has_line_strips(root: &Members) -> Result<bool, Error> {
    Ok(array(root, "meshes")?.iter().any(|mesh| {
        items(mesh, "primitives").iter().any(|p| matches!(p.get("mode").and_then(whole), Some(2 | 3)))
    }))
}

/// Adds an extension to both extension lists.
pub(super) fn declare(root: &mut Members, name: &str) -> Result<(), Error> {
    for list in ["extensionsUsed", "extensionsRequired"] {
        if !array(root, list)?.iter().any(|n| n.as_str() == Some(name)) {
            list_mut(root, list)?.push(name.into());
        }
    }
    Ok(())
}

/// Removes an extension from both extension lists.
pub(in crate::gltf) fn undeclare(root: &mut Members, name: &str) {
    for list in ["extensionsUsed", "extensionsRequired"] {
        let names = root.get(list).and_then(Value::as_array).unwrap_or_default();
        if !names.iter().any(|n| n.as_str() == Some(name)) {
            continue;
        }
        let Some(names) = root.get_mut(list).and_then(Value::as_array_mut) else { continue };
        names.retain(|n| n.as_str() != Some(name));
        // glTF does not allow empty lists.
        if names.is_empty() {
            root.remove(list);
        }
    }
}
