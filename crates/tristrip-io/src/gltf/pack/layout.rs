//! The buffer laid out again: arrays of one kind in one buffer view, equal ones once, without accessors and bytes that nothing uses.
//!
//! ```text
//! views before   ├positions┤├joints┤├positions┤├image┤├times┤├times┤├indices┤
//! views after    ├positions positions┤├joints┤├indices┤├times┤├image┤
//! ```
//! # Algorithm
//! 1. Accessors that meshes, skins or animations refer to stay, and all up to the last that an extension may name.
//! 2. A view that only accessors of one kind use, and that no other view overlaps, is taken apart into arrays. Accessors whose values
//!    interleave or overlap are one array; the rows of others are written without the bytes between them.
//! 3. Arrays of one kind and stride share a view, each from a multiple of 4 bytes on. Of arrays with equal bytes one is written.
//! 4. All other views stay whole. Those that overlap are written as one range of bytes, so that nothing is written twice.
//! 5. Accessors that are equal then are one, unless they have a name, extensions or extras.

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

/// Lays the scene out; `None` if a reference of the document leads nowhere.
pub(super) fn lay_out(scene: Packing) -> Result<Option<GlbContent>, Error> {
    let Some(uses) = Uses::of(&scene)? else { return Ok(None) };
    let Some(views) = ViewArrays::of(&scene, &uses)? else { return Ok(None) };
    let layout = BufferLayout::of(&scene, &views)?;
    let Packing { mut document, fixed, .. } = scene;

    // 1. The accessors, of which equal ones become one.
    let (accessors, numbers) = accessors(&document, &uses, &layout, fixed.accessors)?;
    let root = &mut document.root;
    for (list, entries) in [("accessors", accessors), ("bufferViews", layout.views)] {
        root.remove(list);
        // An empty list is not allowed.
        if !entries.is_empty() {
            root.insert(list, JsonContent::Array(entries));
        }
    }

    // 2. The references to them.
    renumber(root, &numbers, &layout.view_numbers)?;
    set_buffer(root, layout.bytes.len())?;
    Ok(Some(GlbContent { document, buffer: layout.bytes.into() }))
}

/// Returns the accessors that stay, and the new number of each old one.
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
            // In any order of the members.
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
