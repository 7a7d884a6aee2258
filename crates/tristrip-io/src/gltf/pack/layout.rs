//! Lays out the buffer again: arrays of one kind share a buffer view, identical arrays are stored
//! once, and unused accessors and bytes are removed.
//!
//! ```text
//! views before   ├positions┤├joints┤├positions┤├image┤├times┤├times┤├indices┤
//! views after    ├positions positions┤├joints┤├indices┤├times┤├image┤
//! ```
//! # Algorithm
//! 1. Keep accessors that meshes, skins or animations use, and all accessors up to the highest
//!    index that an extension may contain.
//! 2. Split a view into arrays if only accessors of one kind use it and no other view overlaps it.
//!    Accessors whose values interleave or overlap form one array; the values of other arrays are
//!    written without padding between them.
//! 3. Write arrays of one kind and stride to a common view, each aligned to 4 bytes. Write
//!    identical arrays once.
//! 4. Copy all other views unchanged. Overlapping views are copied as one byte range, so no byte is
//!    written twice.
//! 5. Merge accessors that are now equal, unless they have a name, extensions or extras.

mod arrays;
mod bytes;
mod uses;

use std::collections::HashMap;

use self::arrays::ViewArrays;
use self::bytes::BufferLayout;
use self::uses::{Uses, renumber};
use super::packing::{OWN_MEMBERS, Packing};
use crate::error::Error;
use crate::gltf::document::container::GlbContent;
use crate::gltf::document::json::{JsonContent, Members, Value};
use crate::gltf::document::{Document, array};
use crate::gltf::write::keep::compact::set_buffer;

/// Lays out the scene. Returns `None` if a reference in the document is invalid.
pub(super) fn lay_out(scene: Packing) -> Result<Option<GlbContent>, Error> {
    let Some(uses) = Uses::of(&scene)? else { return Ok(None) };
    let Some(views) = ViewArrays::of(&scene, &uses)? else { return Ok(None) };
    let layout = BufferLayout::of(&scene, &views)?;
    let Packing { mut document, fixed, .. } = scene;

    // 1. The accessors; equal ones are merged.
    let (accessors, numbers) = accessors(&document, &uses, &layout, fixed.accessors)?;
    let root = &mut document.root;
    for (list, entries) in [("accessors", accessors), ("bufferViews", layout.views)] {
        root.remove(list);
        // glTF does not allow empty lists.
        if !entries.is_empty() {
            root.insert(list, JsonContent::Array(entries));
        }
    }

    // 2. The references to them.
    renumber(root, &numbers, &layout.view_numbers)?;
    set_buffer(root, layout.bytes.len())?;
    Ok(Some(GlbContent { document, buffer: layout.bytes.into() }))
}

/// Returns the remaining accessors and the new index of each old one.
fn accessors(
    document: &Document,
    uses: &Uses,
    layout: &BufferLayout,
    fixed: usize,
) -> Result<(Vec<Value>, Vec<Option<usize>>), Error> {
    let mut kept: Vec<Value> = Vec::new();
    let mut numbers = Vec::new();
    let mut by_members: HashMap<Vec<(String, Vec<u8>)>, usize> = HashMap::new();
    for (number, accessor) in array(&document.root, "accessors")?.iter().enumerate() {
        if uses.kind(number).is_none() {
            numbers.push(None);
            continue;
        }
        let moved = layout.moved(number, accessor);
        let is_own = number < fixed || OWN_MEMBERS.iter().any(|name| moved.get(name).is_some());
        let new = if is_own {
            kept.len()
        } else {
            // The key is independent of the order of members.
            let members = moved.as_object().into_iter().flat_map(Members::iter);
            let mut key: Vec<_> =
                members.map(|(name, value)| (name.to_owned(), document.text_of(value))).collect();
            key.sort();
            *by_members.entry(key).or_insert(kept.len())
        };
        if new == kept.len() {
            kept.push(moved);
        }
        numbers.push(Some(new));
    }
    Ok((kept, numbers))
}
