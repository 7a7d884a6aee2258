//! Compressed buffer views: decodes `EXT_meshopt_compression` and its successor
//! `KHR_meshopt_compression`. The rest of the reader and the writer see only uncompressed buffers.
//!
//! ```text
//! bufferViews[i]: { buffer: 1, byteLength: 48,     layout after decompression; fallback buffer
//!   extensions: { EXT_meshopt_compression:
//!     { buffer: 0, byteOffset: 96, byteLength: 37, range of the compressed bytes
//!       mode: ATTRIBUTES, filter: OCTAHEDRAL, byteStride: 8, count: 6 } } }
//!
//!  buffers[0]                        buffers[1]                     one buffer
//!  image ▒▒▒▒▒▒ compressed ▒▒▒▒▒▒ +  (fallback, no bytes)     ─▶    image, view, view, …
//! ```
//!
//! # Algorithm
//! 1. A buffer is a fallback if it is marked as one or if only compressed views use it. Fallbacks
//!    are not loaded.
//! 2. Each compressed view is checked against the minimum encoded size for its count, and against
//!    the budget, before memory is allocated. Then it is decoded and its filter is inverted.
//! 3. All buffers are merged into one: the bytes of other views, then the decoded ones. Bytes that
//!    no view uses are dropped from buffers with compressed data. The extension is removed from
//!    views, buffers and the extension lists.
//! 4. Filters are lossy, and an encoder may have computed `min` and `max` of an accessor before
//!    filtering. The bounds of accessors over filtered views are recomputed.
//!
//! The crate `draco-gltf` implements the codecs. The reader accepts more than the extensions allow:
//! version 1 of the attribute codec and the filter `COLOR` under either name, and buffers used by
//! both extensions.
//!
//! # References
//! A. Kapoulkine, J. St. Pierre: *`EXT_meshopt_compression`*, 2021. A. Kapoulkine and others:
//! *`KHR_meshopt_compression`*, 2025.
//!
//! # Complexity
//! Linear in the compressed and decoded bytes. One byte of the attribute codec can encode 1024
//! bytes, so [`DECOMPRESSED_LIMIT`] bounds the decoded size.

use std::collections::{BTreeMap, HashSet};
use std::ops::Range;

use draco_gltf::meshopt::{MeshoptFilter, MeshoptMode, decode_buffer_view};
use tristrip::AttributeData;
use tristrip::text::counted;

use crate::error::Error;
use crate::gltf::document::accessor::AccessorResolver;
use crate::gltf::document::budget::{DECOMPRESSED_LIMIT, DecodeBudget};
use crate::gltf::document::buffer::view_range;
use crate::gltf::document::byte_ranges::ALIGNMENT;
use crate::gltf::document::byte_ranges::SharedBytes;
use crate::gltf::document::json::{Members, Value};
use crate::gltf::document::references::ExtensionNumbers;
use crate::gltf::document::spec::COMPRESSIONS;
use crate::gltf::document::{Document, Located, array, entries_mut};
use crate::gltf::write::keep::compact::{BufferCompaction, set_buffer};
use crate::gltf::write::keep::extensions::{remove_extensions, undeclare};

/// Decompressed bytes allowed per byte of the buffers.
const FACTOR: u64 = 32;
/// Maximum element size of the attribute codec.
const MAX_ATTRIBUTE_STRIDE: usize = 256;

/// Finds the buffers that are not loaded: those marked as fallbacks, and those used only by
/// compressed views.
///
/// # Errors
/// An uncompressed view, or the compressed bytes of a view, are in a buffer marked as a fallback.
pub(in crate::gltf) fn fallback_buffers(root: &Members) -> Result<Vec<bool>, Error> {
    let mut marked = Vec::new();
    for buffer in Located::entries(root, "buffers")? {
        marked.push(match extension(&buffer).and_then(|extension| extension.field("fallback")) {
            None => false,
            Some(flag) => flag.value.as_bool().ok_or_else(|| flag.wrong("true or false"))?,
        });
    }
    let mut holds_data = vec![false; marked.len()];
    let mut holds_compressed_views = holds_data.clone();
    for view in Located::entries(root, "bufferViews")? {
        let mut data_in = view.field("buffer");
        if let Some(extension) = extension(&view) {
            // References are checked where they are resolved.
            let fallback = data_in.and_then(|buffer| buffer.size().ok());
            if let Some(holds) = fallback.and_then(|buffer| holds_compressed_views.get_mut(buffer)) {
                *holds = true;
            }
            data_in = extension.field("buffer");
        }
        let Some(data_in) = data_in else { continue };
        let Ok(index) = data_in.size() else { continue };
        if marked.get(index).copied().unwrap_or(false) {
            let expected = format!("a buffer with data; buffers[{index}] is marked as a fallback");
            return Err(data_in.wrong(expected));
        }
        if let Some(holds) = holds_data.get_mut(index) {
            *holds = true;
        }
    }
    let unread = holds_compressed_views.iter().zip(holds_data).map(|(&compressed, data)| compressed && !data);
    Ok(marked.iter().zip(unread).map(|(&marked, unread)| marked || unread).collect())
}

/// Decodes all compressed views and merges the buffers into one. A document without compressed
/// views and fallbacks is not changed.
///
/// # Errors
/// A view's extension is invalid, its bytes cannot be decoded, or the decoded bytes exceed the
/// budget.
pub(in crate::gltf) fn decompress(
    document: &mut Document,
    buffers: Vec<SharedBytes>,
    is_fallback: &[bool],
    notes: &mut Vec<String>,
) -> Result<Vec<SharedBytes>, Error> {
    let root = &document.root;
    let mut budget = DecodeBudget::new(DECOMPRESSED_LIMIT, FACTOR, &buffers);
    let mut decoded = Vec::new();
    let mut views: BTreeMap<usize, usize> = BTreeMap::new();
    let mut filtered = HashSet::new();
    let mut freed: Vec<Vec<Range<usize>>> = vec![Vec::new(); buffers.len()];
    for (index, view) in Located::entries(root, "bufferViews")?.enumerate() {
        let Some(extension) = extension(&view) else { continue };
        let compressed = CompressedView::of(&view, &extension, &buffers)?;
        let all = 0..buffers[compressed.buffer].len();
        freed[compressed.buffer].push(all);
        views.insert(index, compressed.decode(&mut budget, &mut decoded)?);
        if compressed.filter != MeshoptFilter::None {
            filtered.insert(index);
        }
    }
    if views.is_empty() && !is_fallback.contains(&true) {
        return Ok(buffers);
    }
    if !views.is_empty() {
        notes.push(format!("compressed buffer views, uncompressed when written as GLB: {}", views.len()));
    }
    remove_declarations(document)?;
    let joined = join(&mut document.root, &buffers, freed, &views, &decoded)?;
    // A new budget of the same size: accessors over distinct bytes never exceed it.
    let mut budget = DecodeBudget::new(DECOMPRESSED_LIMIT, FACTOR, &buffers);
    for (index, bounds) in inexact_bounds(&document.root, &joined, &filtered, &mut budget)? {
        let accessor = entries_mut(&mut document.root, "accessors")?.get_mut(index);
        if let Some(members) = accessor.and_then(Value::as_object_mut) {
            bounds.into_iter().for_each(|(name, bound)| members.insert(name, bound));
        }
    }
    Ok(joined)
}

/// A new `min` or `max` of an accessor, with its name.
type NewBound = (&'static str, serde_json::Value);

/// Finds the accessors over filtered views whose `min` or `max` do not match their values.
fn inexact_bounds(
    root: &Members,
    buffers: &[SharedBytes],
    filtered: &HashSet<usize>,
    budget: &mut DecodeBudget,
) -> Result<Vec<(usize, Vec<NewBound>)>, Error> {
    let resolver = AccessorResolver { root, buffers };
    let mut out = Vec::new();
    for (index, accessor) in Located::entries(root, "accessors")?.enumerate() {
        let view = accessor.field("bufferView").and_then(|view| view.size().ok());
        let declared = |name| accessor.field(name).map(|bound| (name, bound));
        let declared: Vec<_> = ["min", "max"].into_iter().filter_map(declared).collect();
        if declared.is_empty() || !view.is_some_and(|view| filtered.contains(&view)) {
            continue;
        }
        // An invalid accessor is rejected where it is used.
        let Ok(values) = resolver.values_of(accessor.clone()) else { continue };
        if values.matrix {
            continue;
        }
        budget.charge(&values.at, values.count, values.element)?;
        let Some([min, max]) = values.attribute().ok().and_then(|data| bounds_of(&data, values.components))
        else {
            continue;
        };
        let new = declared.into_iter().filter_map(|(name, bound)| {
            let exact = if name == "min" { &min } else { &max };
            let found = bound.items().ok()?.map(|x| x.number().ok()).collect::<Option<Vec<f64>>>();
            (found.as_ref() != Some(exact)).then(|| (name, exact.iter().map(|&x| json_number(x)).collect()))
        });
        let new: Vec<NewBound> = new.collect();
        if !new.is_empty() {
            out.push((index, new));
        }
    }
    Ok(out)
}

/// Returns the minimum and maximum of each component, or `None` if a value is not finite.
fn bounds_of(data: &AttributeData, components: usize) -> Option<[Vec<f64>; 2]> {
    fn of<T: Copy + Into<f64>>(values: &[T], components: usize) -> Option<[Vec<f64>; 2]> {
        let mut bounds = [vec![f64::INFINITY; components], vec![f64::NEG_INFINITY; components]];
        for value in values.chunks_exact(components) {
            for (axis, &x) in value.iter().enumerate() {
                let x: f64 = x.into();
                if !x.is_finite() {
                    return None;
                }
                bounds[0][axis] = bounds[0][axis].min(x);
                bounds[1][axis] = bounds[1][axis].max(x);
            }
        }
        Some(bounds)
    }
    match data {
        AttributeData::I8(values) => of(values, components),
        AttributeData::U8(values) => of(values, components),
        AttributeData::I16(values) => of(values, components),
        AttributeData::U16(values) => of(values, components),
        AttributeData::I32(values) => of(values, components),
        AttributeData::U32(values) => of(values, components),
        AttributeData::F32(values) => of(values, components),
        AttributeData::F64(values) => of(values, components),
    }
}

/// Returns a number as JSON; integers have no fraction.
fn json_number(x: f64) -> serde_json::Value {
    const EXACT: f64 = 9_007_199_254_740_992.0;
    if x.fract() == 0.0 && x.abs() < EXACT { (x as i64).into() } else { x.into() }
}

/// Returns the object of the first compression extension of a view or buffer.
fn extension<'a>(object: &Located<'a>) -> Option<Located<'a>> {
    let extensions = object.field("extensions")?;
    COMPRESSIONS.iter().find_map(|name| extensions.field(name))
}

/// A compressed view with a checked description.
struct CompressedView<'a> {
    /// The JSON path of the extension's object.
    at: String,
    /// The buffer of the compressed bytes.
    buffer: usize,
    bytes: &'a [u8],
    mode: MeshoptMode,
    filter: MeshoptFilter,
    count: usize,
    stride: usize,
}

impl<'a> CompressedView<'a> {
    /// Checks the description of a view.
    fn of(view: &Located<'_>, extension: &Located<'_>, buffers: &'a [SharedBytes]) -> Result<Self, Error> {
        let (buffer, bytes) = compressed_bytes(extension, buffers)?;
        let stride_at = extension.need("byteStride")?;
        let count_at = extension.need("count")?;
        let (stride, count) = (stride_at.size()?, count_at.size()?);
        let (mode, filter) = (mode_of(&extension.need("mode")?)?, filter_of(extension)?);
        if mode == MeshoptMode::Attributes {
            if stride == 0 || stride > MAX_ATTRIBUTE_STRIDE || !stride.is_multiple_of(4) {
                return Err(stride_at.wrong("a multiple of 4 from 4 to 256 for ATTRIBUTES"));
            }
            let (is_valid, expected) = match filter {
                MeshoptFilter::None | MeshoptFilter::Exponential => (true, ""),
                MeshoptFilter::Quaternion => (stride == 8, "8 for this filter"),
                MeshoptFilter::Octahedral | MeshoptFilter::Color => {
                    (stride == 4 || stride == 8, "4 or 8 for this filter")
                }
            };
            if !is_valid {
                return Err(stride_at.wrong(expected));
            }
        } else {
            if stride != 2 && stride != 4 {
                return Err(stride_at.wrong("2 or 4 for indices"));
            }
            if let Some(filter_at) = extension.field("filter").filter(|_| filter != MeshoptFilter::None) {
                return Err(filter_at.wrong("\"NONE\" for indices"));
            }
            if mode == MeshoptMode::Triangles && !count.is_multiple_of(3) {
                return Err(count_at.wrong("a multiple of 3 for TRIANGLES"));
            }
        }
        // Check that the bytes can encode this count before allocating memory for it.
        let least = least_bytes(mode, bytes, count, stride);
        if least > bytes.len() as u64 {
            let held = counted(bytes.len(), "byte");
            let expected = format!("a count that fits into {held}; this count needs at least {least}");
            return Err(count_at.wrong(expected));
        }
        let length_at = view.need("byteLength")?;
        if Some(length_at.size()?) != count.checked_mul(stride) {
            let elements = counted(count, "element");
            let expected =
                format!("{}, {elements} of {}", count.saturating_mul(stride), counted(stride, "byte"));
            return Err(length_at.wrong(expected));
        }
        Ok(Self { at: extension.at.clone(), buffer, bytes, mode, filter, count, stride })
    }

    /// Appends the decoded bytes, aligned, and returns their start.
    fn decode(&self, budget: &mut DecodeBudget, out: &mut Vec<u8>) -> Result<usize, Error> {
        budget.charge(&self.at, self.count, self.stride)?;
        let start = out.len().next_multiple_of(ALIGNMENT);
        out.resize(start + self.count * self.stride, 0);
        let Self { bytes, mode, filter, count, stride, .. } = *self;
        decode_buffer_view(&mut out[start..], bytes, mode, filter, count, stride).map_err(|error| {
            let words = error.to_string();
            let why = words.rsplit(": ").next().unwrap_or(&words).to_owned();
            let found = format!("{} that cannot be decoded ({why})", counted(bytes.len(), "byte"));
            let expected = format!("{} of {}", counted(count, "element"), counted(stride, "byte"));
            Error::format(self.at.clone(), found, expected)
        })?;
        Ok(start)
    }
}

/// Returns the buffer and the bytes that an extension object refers to.
fn compressed_bytes<'a>(
    extension: &Located<'_>,
    buffers: &'a [SharedBytes],
) -> Result<(usize, &'a [u8]), Error> {
    let buffer_at = extension.need("buffer")?;
    let buffer = buffer_at.size()?;
    let Some(all) = buffers.get(buffer).map(SharedBytes::as_slice) else {
        return Err(buffer_at.wrong(format!("less than {}, the number of buffers", buffers.len())));
    };
    let (offset, length) = (extension.size_or("byteOffset", 0)?, extension.need("byteLength")?.size()?);
    let bytes = offset.checked_add(length).and_then(|end| all.get(offset..end)).ok_or_else(|| {
        let found = format!("{} from byte {offset}", counted(length, "byte"));
        let expected = format!("a range within the {} of buffers[{buffer}]", counted(all.len(), "byte"));
        Error::format(extension.at.clone(), found, expected)
    })?;
    Ok((buffer, bytes))
}

fn mode_of(mode: &Located<'_>) -> Result<MeshoptMode, Error> {
    match mode.text()? {
        "ATTRIBUTES" => Ok(MeshoptMode::Attributes),
        "TRIANGLES" => Ok(MeshoptMode::Triangles),
        "INDICES" => Ok(MeshoptMode::Indices),
        _ => Err(mode.wrong("ATTRIBUTES, TRIANGLES or INDICES")),
    }
}

fn filter_of(extension: &Located<'_>) -> Result<MeshoptFilter, Error> {
    let Some(filter) = extension.field("filter") else { return Ok(MeshoptFilter::None) };
    match filter.text()? {
        "NONE" => Ok(MeshoptFilter::None),
        "OCTAHEDRAL" => Ok(MeshoptFilter::Octahedral),
        "QUATERNION" => Ok(MeshoptFilter::Quaternion),
        "EXPONENTIAL" => Ok(MeshoptFilter::Exponential),
        "COLOR" => Ok(MeshoptFilter::Color),
        _ => Err(filter.wrong("NONE, OCTAHEDRAL, QUATERNION, EXPONENTIAL or COLOR")),
    }
}

/// Returns a lower bound on the size of `count` encoded elements. The first byte of `bytes` is the
/// header.
fn least_bytes(mode: MeshoptMode, bytes: &[u8], count: usize, stride: usize) -> u64 {
    const HEADER: u64 = 1;
    let count = count as u64;
    match mode {
        // One code per triangle, and a table.
        MeshoptMode::Triangles => HEADER + count / 3 + 16,
        // One byte per index, and padding.
        MeshoptMode::Indices => (HEADER + 4).saturating_add(count),
        MeshoptMode::Attributes => {
            let stride = stride as u64;
            // Blocks of at most 256 elements and 8 KiB, and the padded first element at the end.
            let elements = (8192 / stride / 16 * 16).min(256);
            let (blocks, rest) = (count / elements, count % elements);
            let is_version_0 = bytes.first().is_none_or(|header| header % 16 == 0);
            let (tail, blocks) = if is_version_0 {
                // Per byte of an element: two bits per group of 16 elements, rounded up to bytes.
                let header = |elements: u64| elements.div_ceil(16 * 4);
                (stride.max(32), stride.saturating_mul(blocks * header(elements) + header(rest)))
            } else {
                // Two bits per byte of an element.
                let control = stride / 4;
                ((stride + control).max(24), control.saturating_mul(blocks + u64::from(rest > 0)))
            };
            blocks.saturating_add(HEADER + tail)
        }
    }
}

/// Removes the extensions from views, buffers and the extension lists.
fn remove_declarations(document: &mut Document) -> Result<(), Error> {
    let root = &mut document.root;
    for list in ["buffers", "bufferViews"] {
        if !array(root, list)?.is_empty() {
            entries_mut(root, list)?.iter_mut().for_each(|object| remove_extensions(object, &COMPRESSIONS));
        }
    }
    COMPRESSIONS.iter().for_each(|name| undeclare(root, name));
    Ok(())
}

/// Merges all buffers into one, with the decoded views, and without the freed ranges that no
/// uncompressed view uses.
pub(in crate::gltf) fn join(
    root: &mut Members,
    buffers: &[SharedBytes],
    mut freed: Vec<Vec<Range<usize>>>,
    views: &BTreeMap<usize, usize>,
    decoded: &[u8],
) -> Result<Vec<SharedBytes>, Error> {
    if ExtensionNumbers::of(root).names_bytes {
        if buffers.iter().skip(1).any(|buffer| buffer.len() > 0) {
            return Err(Error::Unsupported(
                "an extension refers to bytes of a buffer: the buffers cannot be merged for decompression"
                    .into(),
            ));
        }
        freed.iter_mut().for_each(Vec::clear);
    }
    let mut kept: Vec<Vec<Range<usize>>> = vec![Vec::new(); buffers.len()];
    let entries: &[Value] = array(root, "bufferViews")?;
    for (index, view) in entries.iter().enumerate().filter(|(index, _)| !views.contains_key(index)) {
        let (buffer, range) = view_range(index, view, buffers)?;
        kept[buffer].push(range);
    }
    let compaction = BufferCompaction::without(buffers, freed, kept);
    compaction.apply(root, views)?;
    let joined = compaction.slices(buffers, decoded).concat();
    set_buffer(root, joined.len())?;
    Ok(vec![SharedBytes::from(joined)])
}
