//! The uses of accessors, and the references to them.

use std::collections::HashSet;

use super::super::packing::Packing;
use crate::error::Error;
use crate::gltf::document::json::{Members, Value};
use crate::gltf::document::{array, entries_mut, index, items};

/// The kind of an array, which determines the properties of its buffer view.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum UseKind {
    /// Vertex values.
    Attribute,
    Indices,
    /// Inverse bind matrices of skins.
    Matrices,
    /// Values of animations and of sparse accessors.
    Other,
    /// More than one kind, or an unknown one.
    Mixed,
}

/// The uses of accessors and views.
pub(super) struct Uses {
    /// `None` for unused accessors.
    kinds: Vec<Option<UseKind>>,
    /// The views of images.
    pub(super) images: HashSet<usize>,
}

impl Uses {
    /// Finds the uses. Returns `None` if a reference is invalid.
    pub(super) fn of(scene: &Packing) -> Result<Option<Self>, Error> {
        let root = &scene.document.root;
        let mut kinds: Vec<Option<UseKind>> = vec![None; array(root, "accessors")?.len()];
        kinds.iter_mut().take(scene.fixed.accessors).for_each(|kind| *kind = Some(UseKind::Mixed));
        let mut is_whole = true;
        let mut add =
            |value: &Value, kind: UseKind| match index(value).and_then(|number| kinds.get_mut(number)) {
                None => is_whole = false,
                Some(known) if known.is_none_or(|known| known == kind) => *known = Some(kind),
                Some(known) => *known = Some(UseKind::Mixed),
            };
        for primitive in array(root, "meshes")?.iter().flat_map(|mesh| items(mesh, "primitives")) {
            primitive.get("indices").into_iter().for_each(|value| add(value, UseKind::Indices));
            let objects = primitive.get("attributes").into_iter().chain(items(primitive, "targets"));
            let members = objects.flat_map(|object| object.as_object().into_iter().flat_map(Members::values));
            members.for_each(|value| add(value, UseKind::Attribute));
        }
        for skin in array(root, "skins")? {
            skin.get("inverseBindMatrices").into_iter().for_each(|value| add(value, UseKind::Matrices));
        }
        for sampler in array(root, "animations")?.iter().flat_map(|animation| items(animation, "samplers")) {
            ["input", "output"]
                .iter()
                .filter_map(|name| sampler.get(name))
                .for_each(|value| add(value, UseKind::Other));
        }
        let views = array(root, "images")?.iter().filter_map(|image| image.get("bufferView"));
        let images: HashSet<usize> = views.map(|view| index(view).unwrap_or(usize::MAX)).collect();
        let view_count = array(root, "bufferViews")?.len();
        is_whole &= images.iter().all(|&view| view < view_count);
        Ok(is_whole.then_some(Self { kinds, images }))
    }

    /// Returns the kind of an accessor, or `None` if it is not used.
    pub(super) fn kind(&self, accessor: usize) -> Option<UseKind> {
        self.kinds.get(accessor).copied().flatten()
    }
}

/// Updates all references to accessors, and those of images to views.
pub(super) fn renumber(
    root: &mut Members,
    accessors: &[Option<usize>],
    views: &[Option<usize>],
) -> Result<(), Error> {
    let accessor = |value: &mut Value| set(value, accessors);
    for mesh in entries_mut(root, "meshes")? {
        for primitive in list(mesh, "primitives") {
            let Some(members) = primitive.as_object_mut() else { continue };
            members.get_mut("indices").into_iter().for_each(accessor);
            let attributes = members.get_mut("attributes").and_then(Value::as_object_mut);
            attributes.into_iter().flat_map(Members::iter_mut).for_each(|(_, value)| accessor(value));
            let targets = members.get_mut("targets").and_then(Value::as_array_mut).into_iter().flatten();
            let targets = targets.filter_map(Value::as_object_mut).flat_map(Members::iter_mut);
            targets.for_each(|(_, value)| accessor(value));
        }
    }
    for skin in entries_mut(root, "skins")? {
        member(skin, "inverseBindMatrices").into_iter().for_each(accessor);
    }
    for animation in entries_mut(root, "animations")? {
        for sampler in list(animation, "samplers") {
            ["input", "output"]
                .into_iter()
                .for_each(|name| member(sampler, name).into_iter().for_each(accessor));
        }
    }
    for image in entries_mut(root, "images")? {
        member(image, "bufferView").into_iter().for_each(|value| set(value, views));
    }
    Ok(())
}

/// Replaces an index by the new one.
fn set(value: &mut Value, numbers: &[Option<usize>]) {
    let new = index(value).and_then(|old| Some((old, numbers.get(old).copied().flatten()?)));
    if let Some((_, new)) = new.filter(|(old, new)| old != new) {
        *value = Value::from(new);
    }
}

/// Returns a member for modification, if it exists.
fn member<'a>(object: &'a mut Value, name: &str) -> Option<&'a mut Value> {
    // Mutable access drops the source text of the object.
    object.get(name)?;
    object.as_object_mut()?.get_mut(name)
}

/// Iterates over a list of an object for modification.
fn list<'a>(object: &'a mut Value, name: &str) -> impl Iterator<Item = &'a mut Value> {
    member(object, name).and_then(Value::as_array_mut).into_iter().flatten()
}
