//! Accessors: where values lie within the buffers, checked once, and decoded into arrays within a budget.

use serde_json::{Map, Value};
use tristrip::AttributeData;

use super::buffer::Bytes;
use super::document::{Place, format_error, uses};
use super::{DECODED_LIMIT, RESTART_EXTENSION};
use crate::error::Error;

/// The extension that allows integer positions.
const QUANTIZATION: &str = "KHR_mesh_quantization";

/// The largest `byteStride` that the specification allows.
const MAX_STRIDE: usize = 252;

/// A type of numbers in a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn from_code(place: &Place<'_>) -> Result<Self, Error> {
        Ok(match place.whole()? {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return Err(place.wrong("5120, 5121, 5122, 5123, 5125 or 5126")),
        })
    }

    pub(super) fn code(self) -> u32 {
        match self {
            Self::I8 => 5120,
            Self::U8 => 5121,
            Self::I16 => 5122,
            Self::U16 => 5123,
            Self::U32 => 5125,
            Self::F32 => 5126,
        }
    }

    pub(super) fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }
}

/// A bound on what is decoded.
pub(super) struct Budget {
    limit: u64,
    used: u64,
}

impl Budget {
    /// Allows some bytes for each byte of the buffers, beside the constant.
    pub(super) fn new(buffers: &[Bytes], factor: u64) -> Self {
        let input: u64 = buffers.iter().map(|b| b.len() as u64).sum();
        Self { limit: DECODED_LIMIT.saturating_add(input.saturating_mul(factor)), used: 0 }
    }

    /// Takes room for values, or tells that there is none.
    pub(super) fn take(&mut self, count: usize, bytes_each: usize) -> Result<(), (u64, u64)> {
        let used = self.used.saturating_add((count as u64).saturating_mul(bytes_each as u64));
        if used > self.limit {
            return Err((used, self.limit));
        }
        self.used = used;
        Ok(())
    }
}

/// A document and its bytes, while it is read.
pub(super) struct Source<'a> {
    pub(super) root: &'a Map<String, Value>,
    pub(super) buffers: &'a [Bytes],
}

/// A buffer view, in range.
struct View<'a> {
    bytes: &'a [u8],
    stride: Option<usize>,
}

/// The values of an accessor, in range; decoding cannot fail but for the values themselves.
pub(super) struct Values<'a> {
    pub(super) at: String,
    pub(super) component: Component,
    /// Components of a value: 1 to 4, or more for matrices.
    pub(super) components: usize,
    /// Whether columns may be padded.
    pub(super) matrix: bool,
    /// Bytes of a value.
    pub(super) element: usize,
    pub(super) count: usize,
    pub(super) normalized: bool,
    /// `None` for zeros.
    base: Option<(&'a [u8], usize)>,
    /// Which values are replaced, ascending, and by what.
    sparse: Option<(Vec<u32>, &'a [u8])>,
}

impl<'a> Source<'a> {
    /// Looks at a buffer view.
    fn view(&self, place: &Place<'a>) -> Result<View<'a>, Error> {
        let buffer_at = place.need("buffer")?;
        let buffer = buffer_at.size()?;
        let Some(bytes) = self.buffers.get(buffer) else {
            return Err(buffer_at.wrong(format!("less than {}, the number of buffers", self.buffers.len())));
        };
        let bytes = bytes.as_slice();
        let length_at = place.need("byteLength")?;
        let (offset, length) = (place.size_or("byteOffset", 0)?, length_at.size()?);
        if length == 0 {
            return Err(length_at.wrong("at least 1"));
        }
        let stride = match place.field("byteStride") {
            None => None,
            Some(stride) => match stride.size()? {
                allowed @ 0..=MAX_STRIDE => Some(allowed),
                _ => return Err(stride.wrong(format!("at most {MAX_STRIDE}"))),
            },
        };
        match offset.checked_add(length).and_then(|end| bytes.get(offset..end)) {
            Some(bytes) => Ok(View { bytes, stride }),
            None => Err(format_error(
                place.at.clone(),
                format!("{length} bytes from byte {offset}"),
                format!("a range within the {} bytes of buffers[{buffer}]", bytes.len()),
            )),
        }
    }

    /// Finds the values of the accessor that a value names.
    pub(super) fn values(&self, reference: &Place<'a>) -> Result<Values<'a>, Error> {
        let place = reference.target(self.root, "accessors")?;
        let component = Component::from_code(&place.need("componentType")?)?;
        let kind = place.need("type")?;
        let (rows, columns) = match kind.text()? {
            "SCALAR" => (1, 1),
            "VEC2" => (2, 1),
            "VEC3" => (3, 1),
            "VEC4" => (4, 1),
            "MAT2" => (2, 2),
            "MAT3" => (3, 3),
            "MAT4" => (4, 4),
            _ => return Err(kind.wrong("SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4")),
        };
        let count_at = place.need("count")?;
        let count = count_at.size()?;
        if count == 0 || count > tristrip::mesh::MAX_COUNT {
            return Err(count_at.wrong(format!("1 to {}", tristrip::mesh::MAX_COUNT)));
        }
        let matrix = columns > 1;
        let column = rows * component.bytes();
        let element = if matrix { columns * column.next_multiple_of(4) } else { column };
        let offset = place.size_or("byteOffset", 0)?;
        let base = match place.field("bufferView") {
            None => None,
            Some(view) => Some(self.strided(&place, &view, offset, element, count)?),
        };
        let sparse = place.field("sparse").map(|sparse| self.sparse(&sparse, element, count)).transpose()?;
        let normalized = match place.field("normalized") {
            None => false,
            Some(p) => p.value.as_bool().ok_or_else(|| p.wrong("true or false"))?,
        };
        let components = rows * columns;
        Ok(Values { at: place.at, component, components, matrix, element, count, normalized, base, sparse })
    }

    /// Finds the bytes from an accessor's first value on, and the distance of its values.
    fn strided(
        &self,
        accessor: &Place<'_>,
        view: &Place<'a>,
        offset: usize,
        element: usize,
        count: usize,
    ) -> Result<(&'a [u8], usize), Error> {
        let view_at = view.target(self.root, "bufferViews")?;
        let view = self.view(&view_at)?;
        let stride = view.stride.unwrap_or(element);
        if stride < element {
            return Err(format_error(
                format!("{}.byteStride", view_at.at),
                stride.to_string(),
                format!("at least {element}, the size of the values of {}", accessor.at),
            ));
        }
        let length = (count as u64 - 1) * stride as u64 + element as u64;
        match view.bytes.get(offset..) {
            Some(bytes) if bytes.len() as u64 >= length => Ok((bytes, stride)),
            _ => Err(format_error(
                accessor.at.clone(),
                format!("{count} values: {length} bytes from byte {offset}"),
                format!("a range within the {} bytes of {}", view.bytes.len(), view_at.at),
            )),
        }
    }

    fn sparse(&self, place: &Place<'a>, element: usize, count: usize) -> Result<(Vec<u32>, &'a [u8]), Error> {
        let count_at = place.need("count")?;
        let sparse_count = count_at.size()?;
        if sparse_count == 0 || sparse_count > count {
            return Err(count_at.wrong(format!("1 to {count}, the accessor's count")));
        }
        let indices = place.need("indices")?;
        let code = indices.need("componentType")?;
        let component = Component::from_code(&code)?;
        if !matches!(component, Component::U8 | Component::U16 | Component::U32) {
            return Err(code.wrong("5121, 5123 or 5125"));
        }
        let part = |place: &Place<'a>, element| {
            let offset = place.size_or("byteOffset", 0)?;
            self.strided(place, &place.need("bufferView")?, offset, element, sparse_count)
        };
        let (bytes, _) = part(&indices, component.bytes())?;
        let mut places = Vec::with_capacity(sparse_count);
        for (i, raw) in bytes.chunks_exact(component.bytes()).take(sparse_count).enumerate() {
            let index = index_of(component, raw);
            if index as usize >= count || places.last().is_some_and(|&last| index <= last) {
                return Err(format_error(
                    format!("{}, index {i}", indices.at),
                    index.to_string(),
                    format!("rising indices below {count}"),
                ));
            }
            places.push(index);
        }
        let (values, _) = part(&place.need("values")?, element)?;
        Ok((places, &values[..sparse_count * element]))
    }
}

impl Values<'_> {
    /// Decodes all values; `per` of `T` make a value.
    fn decode<T: Copy>(&self, per: usize, push: impl Fn(&[u8], &mut Vec<T>)) -> Vec<T> {
        let element = self.element;
        let mut out = Vec::with_capacity(self.count * per);
        match self.base {
            Some((bytes, stride)) if stride == element => {
                bytes.chunks_exact(element).take(self.count).for_each(|raw| push(raw, &mut out));
            }
            Some((bytes, stride)) => {
                bytes.chunks(stride).take(self.count).for_each(|raw| push(&raw[..element], &mut out));
            }
            None => {
                let zeros = [0; 64];
                (0..self.count).for_each(|_| push(&zeros[..element], &mut out));
            }
        }
        if let Some((places, values)) = &self.sparse {
            let mut one = Vec::with_capacity(per);
            for (&place, raw) in places.iter().zip(values.chunks_exact(element)) {
                one.clear();
                push(raw, &mut one);
                let at = place as usize * per;
                out[at..at + per].copy_from_slice(&one);
            }
        }
        out
    }

    /// Decodes positions; integers are allowed under `KHR_mesh_quantization`.
    pub(super) fn positions(
        &self,
        root: &Map<String, Value>,
        budget: &mut Budget,
    ) -> Result<Vec<[f32; 3]>, Error> {
        if self.components != 3 {
            let found = format!("{} components", self.components);
            return Err(format_error(format!("{}.type", self.at), found, "VEC3 for POSITION"));
        }
        let integer =
            matches!(self.component, Component::I8 | Component::U8 | Component::I16 | Component::U16);
        if self.component != Component::F32 && !(integer && uses(root, QUANTIZATION)) {
            return Err(format_error(
                format!("{}.componentType", self.at),
                self.component.code().to_string(),
                format!("5126 (FLOAT) for POSITION, or a smaller integer under {QUANTIZATION}"),
            ));
        }
        self.afford(budget, size_of::<[f32; 3]>())?;
        let scale = match (self.normalized, self.component) {
            (true, Component::I8) => 127.0,
            (true, Component::U8) => 255.0,
            (true, Component::I16) => 32767.0,
            (true, Component::U16) => 65535.0,
            _ => 1.0,
        };
        let out = match self.component {
            Component::F32 => self.decode(1, |raw, out| out.push(vector(raw, f32_of))),
            Component::I8 => self.decode(1, |raw, out| {
                out.push(vector(raw, |b: [u8; 1]| {
                    (f32::from(i8::from_le_bytes(b)) / scale).max(floor(scale))
                }));
            }),
            Component::U8 => {
                self.decode(1, |raw, out| out.push(vector(raw, |b: [u8; 1]| f32::from(b[0]) / scale)))
            }
            Component::I16 => self.decode(1, |raw, out| {
                out.push(vector(raw, |b| (f32::from(i16::from_le_bytes(b)) / scale).max(floor(scale))));
            }),
            Component::U16 | Component::U32 => {
                self.decode(1, |raw, out| out.push(vector(raw, |b| f32::from(u16::from_le_bytes(b)) / scale)))
            }
        };
        let bad = out.iter().enumerate().find(|(_, p)| !p.iter().all(|x| x.is_finite()));
        if let Some((element, p)) = bad {
            let found = p.iter().copied().find(|x| !x.is_finite()).unwrap_or(f32::NAN);
            let at = format!("{}, element {element}", self.at);
            return Err(format_error(at, format!("coordinate {found}"), "a finite number"));
        }
        Ok(out)
    }

    /// Decodes indices below a number of vertices. Where restarts are allowed the highest value of the type becomes
    /// `u32::MAX`.
    pub(super) fn indices(
        &self,
        vertex_count: usize,
        restarts: bool,
        budget: &mut Budget,
    ) -> Result<Vec<u32>, Error> {
        let unsigned = matches!(self.component, Component::U8 | Component::U16 | Component::U32);
        if self.components != 1 || !unsigned {
            return Err(format_error(
                self.at.clone(),
                format!("{} components of type {}", self.components, self.component.code()),
                "SCALAR of 5121, 5123 or 5125 for indices",
            ));
        }
        self.afford(budget, size_of::<u32>())?;
        let component = self.component;
        let highest = u32::MAX >> (32 - 8 * component.bytes());
        let mut out = match component {
            Component::U8 => self.decode(1, |raw, out| out.push(u32::from(raw[0]))),
            Component::U16 => {
                self.decode(1, |raw, out| out.push(u32::from(u16::from_le_bytes([raw[0], raw[1]]))))
            }
            _ => self.decode(1, |raw, out| out.push(index_of(Component::U32, raw))),
        };
        if restarts && highest != u32::MAX {
            out.iter_mut().filter(|i| **i == highest).for_each(|i| *i = u32::MAX);
        }
        let good = |i: u32| (i as usize) < vertex_count || restarts && i == u32::MAX;
        if let Some((element, &found)) = out.iter().enumerate().find(|&(_, &i)| !good(i)) {
            return Err(format_error(
                format!("{}, element {element}", self.at),
                format!("index {found}"),
                format!("less than {vertex_count}, the number of vertices"),
            ));
        }
        Ok(out)
    }

    /// Decodes the values of any attribute.
    pub(super) fn attribute(&self) -> AttributeData {
        let per = self.components;
        match self.component {
            Component::I8 => AttributeData::I8(self.flat(per, i8::from_le_bytes)),
            Component::U8 => AttributeData::U8(self.flat(per, u8::from_le_bytes)),
            Component::I16 => AttributeData::I16(self.flat(per, i16::from_le_bytes)),
            Component::U16 => AttributeData::U16(self.flat(per, u16::from_le_bytes)),
            Component::U32 => AttributeData::U32(self.flat(per, u32::from_le_bytes)),
            Component::F32 => AttributeData::F32(self.flat(per, f32::from_le_bytes)),
        }
    }

    fn flat<const N: usize, T: Copy>(&self, per: usize, read: impl Fn([u8; N]) -> T) -> Vec<T> {
        self.decode(per, |raw, out| {
            out.extend(raw.as_chunks::<N>().0.iter().map(|&b| read(b)));
        })
    }

    fn afford(&self, budget: &mut Budget, bytes_each: usize) -> Result<(), Error> {
        budget.take(self.count, bytes_each).map_err(|(found, limit)| Error::LimitExceeded {
            at: format!("{}, bytes decoded up to here", self.at),
            found,
            limit,
        })
    }
}

/// Looks at every buffer view, so that writing need not fail for one that reading did not touch.
pub(super) fn check_views(source: &Source<'_>) -> Result<(), Error> {
    for view in Place::entries(source.root, "bufferViews")? {
        source.view(&view)?;
    }
    Ok(())
}

/// Tells in words that restarts stand in a file that does not declare them.
pub(super) fn undeclared_restart(root: &Map<String, Value>, count: u64) -> Option<String> {
    (count > 0 && !uses(root, RESTART_EXTENSION)).then(|| {
        format!("restart indices in a file that does not use {RESTART_EXTENSION}, taken as restarts: {count}")
    })
}

/// Normalised signed integers stop at -1: the lowest value lies beyond it.
fn floor(scale: f32) -> f32 {
    if scale > 1.0 { -1.0 } else { f32::MIN }
}

fn f32_of(raw: [u8; 4]) -> f32 {
    f32::from_le_bytes(raw)
}

/// Reads three components; the raw value has that many.
fn vector<const N: usize>(raw: &[u8], read: impl Fn([u8; N]) -> f32) -> [f32; 3] {
    let mut out = [0.0; 3];
    for (x, b) in out.iter_mut().zip(raw.as_chunks::<N>().0) {
        *x = read(*b);
    }
    out
}

fn index_of(component: Component, raw: &[u8]) -> u32 {
    raw[..component.bytes()].iter().rev().fold(0, |index, &b| index << 8 | u32::from(b))
}
