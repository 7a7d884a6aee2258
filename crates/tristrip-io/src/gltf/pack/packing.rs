//! The state of a document while it is packed: its fixed entries, and the accessors appended to it.

use serde_json::json;

use crate::error::Error;
use crate::gltf::document::accessor::AccessorResolver;
use crate::gltf::document::byte_ranges::SharedBytes;
use crate::gltf::document::json::{Members, Value};
use crate::gltf::document::references::ExtensionNumbers;
use crate::gltf::document::{Document, array, entries_mut, list_mut};

/// Members of accessors and views that must be preserved.
pub(super) const OWN_MEMBERS: [&str; 3] = ["name", "extensions", "extras"];

/// The values that [`pack`](super::pack()) may round.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Rounding {
    /// Rounds nothing. Vertices and JSON values are preserved exactly; animation tracks change by
    /// at most a millionth of their largest absolute value.
    #[default]
    None,
    /// Rounds joint weights to 16 bits: each changes by less than 1/65535 if the weights of a
    /// vertex sum to 1. Node transforms that are exact 32-bit floats are written with the fewest
    /// digits of these; as 64-bit floats, they change by a relative error below 1e-7.
    Weights,
    /// Rounds joint weights to 8 bits: each changes by less than 1/255. Rounds animated rotations
    /// to 16 bits: each quaternion component changes by at most 1/65534, and the angle by less than
    /// 0.004 degrees. Node transforms are rounded as with `Weights`.
    WeightsAndRotations,
}

/// A document during packing.
pub(super) struct Packing {
    pub(super) document: Document,
    pub(super) buffers: Vec<SharedBytes>,
    pub(super) fixed: Fixed,
}

impl Packing {
    pub(super) fn resolver(&self) -> AccessorResolver<'_> {
        AccessorResolver { root: &self.document.root, buffers: &self.buffers }
    }

    /// Appends accessors and their values, starting at the index that [`AppendedAccessors::of`]
    /// determined.
    pub(super) fn append(&mut self, new: AppendedAccessors) -> Result<(), Error> {
        if new.accessors.is_empty() {
            return Ok(());
        }
        let (root, buffer) = (&mut self.document.root, self.buffers.len());
        let first_view = array(root, "bufferViews")?.len();
        let views = new.views.into_iter().map(|(offset, length)| {
            json!({ "buffer": buffer, "byteOffset": offset, "byteLength": length }).into()
        });
        list_mut(root, "bufferViews")?.extend(views);
        list_mut(root, "buffers")?.push(json!({ "byteLength": new.bytes.len() }).into());
        for (i, mut accessor) in new.accessors.into_iter().enumerate() {
            let members = accessor.as_object_mut();
            members.into_iter().for_each(|members| members.insert("bufferView", first_view + i));
            list_mut(root, "accessors")?.push(accessor);
        }
        self.buffers.push(SharedBytes::from(new.bytes));
        Ok(())
    }
}

/// Accessors to append, each with its own view.
pub(super) struct AppendedAccessors {
    /// The number of existing accessors.
    first: usize,
    bytes: Vec<u8>,
    views: Vec<(usize, usize)>,
    accessors: Vec<Value>,
}

impl AppendedAccessors {
    pub(super) fn of(root: &Members) -> Result<Self, Error> {
        let first = array(root, "accessors")?.len();
        Ok(Self { first, bytes: Vec::new(), views: Vec::new(), accessors: Vec::new() })
    }

    /// Adds an accessor over at least one byte and returns its index.
    pub(super) fn add(&mut self, bytes: &[u8], accessor: impl Into<Value>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push((self.bytes.len(), bytes.len()));
        self.bytes.extend_from_slice(bytes);
        self.accessors.push(accessor.into());
        self.first + self.accessors.len() - 1
    }
}

/// The number of leading accessors and buffer views that keep their indices and values, because
/// extensions or extras may refer to them.
#[derive(Clone, Copy)]
pub(super) struct Fixed {
    pub(super) accessors: usize,
    pub(super) views: usize,
}

impl Fixed {
    pub(super) fn of(root: &Members) -> Result<Self, Error> {
        let possible = ExtensionNumbers::of(root).numbers;
        let count = |list| {
            let count = array(root, list)?.len();
            Ok::<_, Error>(possible.iter().filter(|&&number| number < count).max().map_or(0, |last| last + 1))
        };
        Ok(Self { accessors: count("accessors")?, views: count("bufferViews")? })
    }
}

/// Returns the members of an entry of a top-level array for modification, if the entry is an
/// object.
pub(super) fn entry_mut<'a>(
    root: &'a mut Members,
    list: &str,
    number: usize,
) -> Result<Option<&'a mut Members>, Error> {
    Ok(entries_mut(root, list)?.get_mut(number).and_then(Value::as_object_mut))
}
