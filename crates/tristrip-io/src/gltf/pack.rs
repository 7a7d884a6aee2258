//! Packs a scene into fewer bytes: removes redundant data, or stores it once.
//!
//! ```text
//!            before                                              after
//! accessors  times  joints (16 bits)  times  unused  positions   times  joints (8 bits)  positions
//! bytes      ▒▒▒▒   ▓▓▓▓▓▓▓▓▓▓▓▓▓▓▓▓  ▒▒▒▒   ░░░░░░  █████████   █████████  ▓▓▓▓▓▓▓▓  ▒▒▒▒
//! ```
//! # Algorithm
//! 1. Remove keyframes that interpolation of their neighbours reproduces (`animation.rs`).
//! 2. Store joints and indices in the smallest type that can represent them (`types.rs`). With
//!    rounding, joint weights and animated rotations are also stored in smaller types, with a loss
//!    of precision ([`Rounding`]).
//! 3. Remove JSON members that equal the default, and optional bounds. Write numbers with the
//!    fewest digits that give the same value (`tidy.rs`).
//! 4. Remove unused accessors, store identical arrays once, and put arrays of one kind into a
//!    common buffer view (`layout.rs`).
//!
//! Numbers inside unknown extensions and extras may be indices of accessors or buffer views.
//! Accessors and views up to the highest such index keep their indices and values. If an extension
//! may refer to bytes, the file is not changed.
//!
//! # Complexity
//! Linear in the bytes, n log n in the number of accessors and views; each buffer is copied twice.
//! Keyframes and joints beyond the limit for decoded attributes are not changed.

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

/// Returns a GLB with the same scene in fewer bytes, or the input if packing does not make it
/// smaller.
///
/// # Errors
/// The bytes are not a GLB with valid buffer views, or the result exceeds 4 GiB.
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
    // In a small file, additional views may cost more than packing saves.
    match packed.filter(|packed| packed.file_bytes() < glb.len()) {
        Some(packed) => packed.write(),
        None => Ok(Arc::unwrap_or_clone(glb)),
    }
}

/// Packs content that is not yet written, unless the result would be larger.
pub(in crate::gltf) fn pack_content(content: GlbContent, rounding: Rounding) -> Result<GlbContent, Error> {
    let packed = pack_document(content.document.clone(), content.buffers(), rounding)?;
    Ok(packed.filter(|packed| packed.file_bytes() < content.file_bytes()).unwrap_or(content))
}

/// Packs a document. Returns `None` if it must not change.
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
