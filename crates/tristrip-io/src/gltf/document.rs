//! A glTF document: its JSON and buffers, and the accessors and other references between them.
//!
//! These modules process only the document. [`super::read`] converts its primitives to the parts of
//! a model.

pub(in crate::gltf) mod accessor;
pub(in crate::gltf) mod bounds;
pub(in crate::gltf) mod budget;
pub(in crate::gltf) mod buffer;
#[cfg(feature = "fs")]
pub(in crate::gltf) mod buffer_files;
pub(in crate::gltf) mod byte_ranges;
pub(in crate::gltf) mod container;
pub(in crate::gltf) mod json;
pub(in crate::gltf) mod references;
pub(crate) mod scene;
pub(in crate::gltf) mod spec;
mod tree;

pub(in crate::gltf) use tree::{
    Document, JSON_VALUE_LIMIT, Located, array, entries_mut, index, items, list_mut, uses, values, whole,
};
