//! The same scene in fewer bytes: what a file says twice, or says without need, is written once or not at all.
//!
//! ```text
//! accessors   times  joints (16 bits)  times (the same)  unused    positions      accessors   times  joints (8 bits)  positions
//! bytes       ▒▒▒▒   ▓▓▓▓▓▓▓▓▓▓▓▓▓▓▓▓  ▒▒▒▒              ░░░░░░    █████████  ─▶  bytes       █████████  ▓▓▓▓▓▓▓▓  ▒▒▒▒
//! ```
//! # Algorithm
//! 1. Keyframes are removed that the interpolation of their neighbours gives back (`animation.rs`).
//! 2. Joints and indices get the smallest type that holds them (`types.rs`); with rounding also the weights of
//!    joints and the rotations of animations ([`Rounding`]), which is not exact.
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
mod packing;
mod tidy;
mod types;

use std::sync::Arc;

use self::packing::{Fixed, Packing};
use crate::error::Error;
use crate::gltf::BufferFiles;
use crate::gltf::document::accessor::{AccessorResolver, check_views};
use crate::gltf::document::buffer;
use crate::gltf::document::byte_ranges::SharedBytes;
use crate::gltf::document::container::{self, GlbContent};
use crate::gltf::document::references::ExtensionNumbers;
use crate::gltf::document::{Document, array};

pub use packing::Rounding;

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
    let mut packed = None;
    if !is_separate {
        let mut files = BufferFiles::new(&[]);
        let bin = container.bin.as_ref();
        let buffers = buffer::load(&mut document, &container.file, bin, &mut files, None, &[])?;
        packed = pack_document(document, buffers, rounding)?;
    }
    drop(container);
    // A small file may need more bytes for the views than it had.
    match packed.filter(|packed| packed.file_bytes() < glb.len()) {
        Some(packed) => packed.write(),
        None => Ok(Arc::unwrap_or_clone(glb)),
    }
}

/// Packs a file that is not yet written, unless that would make it larger.
pub(in crate::gltf) fn pack_content(content: GlbContent, rounding: Rounding) -> Result<GlbContent, Error> {
    let packed = pack_document(content.document.clone(), content.buffers(), rounding)?;
    Ok(packed.filter(|packed| packed.file_bytes() < content.file_bytes()).unwrap_or(content))
}

/// Packs a document; `None` where it must stay as it is.
fn pack_document(
    document: Document,
    buffers: Vec<SharedBytes>,
    rounding: Rounding,
) -> Result<Option<GlbContent>, Error> {
    if ExtensionNumbers::of(&document.root).names_bytes {
        return Ok(None);
    }
    check_views(&AccessorResolver { root: &document.root, buffers: &buffers })?;
    let fixed = Fixed::of(&document.root)?;
    let mut scene = Packing { document, buffers, fixed };
    animation::reduce(&mut scene, rounding)?;
    types::narrow(&mut scene, rounding)?;
    tidy::tidy(&mut scene, rounding)?;
    layout::lay_out(scene)
}
