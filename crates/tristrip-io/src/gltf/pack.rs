//! The same scene in fewer bytes: what a file says twice, or says without need, is written once or not at all.
//!
//! ```text
//! accessors   times  joints (16 bits)  times (the same)  unused    positions      accessors   times  joints (8 bits)  positions
//! bytes       ▒▒▒▒   ▓▓▓▓▓▓▓▓▓▓▓▓▓▓▓▓  ▒▒▒▒              ░░░░░░    █████████  ─▶  bytes       █████████  ▓▓▓▓▓▓▓▓  ▒▒▒▒
//! ```
//! # Algorithm
//! 1. Keyframes are removed that the interpolation of their neighbours gives back (`animation.rs`).
//! 2. Joints and indices get the smallest type that holds them (`types.rs`); with [`Rounding::WeightsAndRotations`] also the weights of
//!    joints and the rotations of animations, which is not exact.
//! 3. Members of the JSON are removed that have the value that a missing member has, and bounds that are not required; numbers are
//!    written with the fewest digits of the same value (`tidy.rs`).
//! 4. Accessors that nothing uses are removed; arrays of the same bytes are written once; arrays of one kind share a buffer view
//!    (`layout.rs`).
//!
//! Numbers inside extensions and extras whose meaning is unknown may be those of accessors or buffer views: up to the highest of them that
//! is one, accessors and views keep their numbers and values. Where an extension may name bytes, the file stays as it is.
//!
//! # Complexity
//! Linear in the bytes, but n log n in the number of accessors and views; each buffer is copied twice. Keyframes and joints are decoded
//! within the limit of attributes; those beyond it stay.

mod animation;
mod layout;
mod tidy;
mod types;

use std::sync::Arc;

use serde_json::json;

use super::accessor::{AccessorResolver, check_views};
use super::buffer;
use super::container;
use super::document::{Document, array, entries_mut, list_mut};
use super::json::{Members, Value};
use super::references::ExtensionNumbers;
use super::shared_bytes::SharedBytes;
use crate::error::Error;

/// What [`pack`] may round.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Rounding {
    /// Nothing: vertices and the JSON keep their values, and a track of an animation is nowhere further than a millionth of
    /// its greatest value from what it was.
    #[default]
    None,
    /// Weights of joints to 8 bits, which changes each by less than 1/255; rotations of animations to 16 bits, which changes each
    /// component of a quaternion by at most 1/65534, the angle by less than 0.004 degrees.
    WeightsAndRotations,
}

/// Returns a GLB with the same scene in fewer bytes.
///
/// # Errors
/// The bytes are not a GLB whose buffer views are valid, or the result exceeds 4 GiB.
///
/// ```
/// use tristrip_io::{Drawing, Format, gltf, read, write};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj)?;
/// let glb = write(&model, &[Drawing::Faces], Format::Glb, tristrip::Layout::List)?;
/// let packed = gltf::pack(glb.clone(), gltf::Rounding::None)?;
/// assert!(packed.len() <= glb.len());
/// assert_eq!(read(&packed, Format::Glb)?.parts[0].mesh, model.parts[0].mesh);
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn pack(glb: Vec<u8>, rounding: Rounding) -> Result<Vec<u8>, Error> {
    let glb = Arc::new(glb);
    let container = container::open(Arc::clone(&glb), &mut Vec::new())?;
    let mut document = Document::parse(container.json_bytes())?.without_spaces()?;
    let is_separate = array(&document.root, "buffers")?.iter().any(|buffer| buffer.get("uri").is_some());
    if is_separate || ExtensionNumbers::of(&document.root).names_bytes {
        drop(container);
        return Ok(Arc::unwrap_or_clone(glb));
    }
    let buffers = buffer::load(&mut document, &container.file, container.bin.as_ref(), &[], None, &[])?;
    check_views(&AccessorResolver { root: &document.root, buffers: &buffers })?;
    let fixed = Fixed::of(&document.root)?;
    let mut scene = Packing { document, buffers, fixed };
    animation::reduce(&mut scene, rounding)?;
    types::narrow(&mut scene, rounding)?;
    tidy::tidy(&mut scene)?;
    let packed = layout::write(scene)?;
    drop(container);
    // A small file may need more bytes for the views than it had.
    Ok(packed.filter(|packed| packed.len() < glb.len()).unwrap_or_else(|| Arc::unwrap_or_clone(glb)))
}

/// A document while it is packed.
struct Packing {
    document: Document,
    buffers: Vec<SharedBytes>,
    fixed: Fixed,
}

impl Packing {
    fn resolver(&self) -> AccessorResolver<'_> {
        AccessorResolver { root: &self.document.root, buffers: &self.buffers }
    }

    /// Appends accessors with values of their own, from the number on that [`NewAccessors::of`] found.
    fn append(&mut self, new: NewAccessors) -> Result<(), Error> {
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

/// Accessors that are to be appended, each with a view of its own.
struct NewAccessors {
    /// The number of accessors that are there already.
    first: usize,
    bytes: Vec<u8>,
    views: Vec<(usize, usize)>,
    accessors: Vec<Value>,
}

impl NewAccessors {
    fn of(root: &Members) -> Result<Self, Error> {
        let first = array(root, "accessors")?.len();
        Ok(Self { first, bytes: Vec::new(), views: Vec::new(), accessors: Vec::new() })
    }

    /// Adds an accessor over at least one byte; returns its number.
    fn add(&mut self, bytes: &[u8], accessor: impl Into<Value>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push((self.bytes.len(), bytes.len()));
        self.bytes.extend_from_slice(bytes);
        self.accessors.push(accessor.into());
        self.first + self.accessors.len() - 1
    }
}

/// How many of the first accessors and buffer views keep their numbers and values, since extensions or extras may name them.
#[derive(Clone, Copy)]
struct Fixed {
    accessors: usize,
    views: usize,
}

impl Fixed {
    fn of(root: &Members) -> Result<Self, Error> {
        let possible = ExtensionNumbers::of(root).numbers;
        let count = |list| {
            let count = array(root, list)?.len();
            Ok::<_, Error>(possible.iter().filter(|&&number| number < count).max().map_or(0, |last| last + 1))
        };
        Ok(Self { accessors: count("accessors")?, views: count("bufferViews")? })
    }
}

/// Returns the members of an entry of one of the document's arrays for a change, if it is an object.
fn entry_mut<'a>(root: &'a mut Members, list: &str, number: usize) -> Result<Option<&'a mut Members>, Error> {
    Ok(entries_mut(root, list)?.get_mut(number).and_then(Value::as_object_mut))
}
