//! Accessors: the byte ranges of their values in the buffers. Ranges are checked once; values are
//! decoded into arrays within a budget.

use tristrip::AttributeData;
use tristrip::text::counted;

use crate::error::Error;
use crate::gltf::document::budget::DecodeBudget;
use crate::gltf::document::byte_ranges::SharedBytes;
use crate::gltf::document::json::Members;
use crate::gltf::document::spec::ComponentType;
use crate::gltf::document::spec::QUANTIZATION;
use crate::gltf::document::{Located, uses};

/// The largest `byteStride` that the specification allows.
const MAX_STRIDE: usize = 252;

/// A document and its buffers: finds the bytes that accessors refer to.
pub(in crate::gltf) struct AccessorResolver<'a> {
    pub(in crate::gltf) root: &'a Members,
    pub(in crate::gltf) buffers: &'a [SharedBytes],
}

/// A buffer view with a checked range.
struct BufferView<'a> {
    bytes: &'a [u8],
    /// The buffer and the offset of the view's first byte in it.
    start: (&'a SharedBytes, usize),
    stride: Option<usize>,
}

/// The values of an accessor, with checked ranges. Decoding can fail only because of the values
/// themselves.
pub(in crate::gltf) struct AccessorValues<'a> {
    pub(in crate::gltf) at: String,
    pub(in crate::gltf) component: ComponentType,
    /// Components per value: 1 to 4, or more for matrices.
    pub(in crate::gltf) components: usize,
    /// Whether the value is a matrix, whose columns may be padded.
    pub(in crate::gltf) matrix: bool,
    /// Bytes per value.
    pub(in crate::gltf) element: usize,
    pub(in crate::gltf) count: usize,
    pub(in crate::gltf) normalized: bool,
    /// `None` if all values are zero.
    base: Option<(&'a [u8], usize)>,
    sparse: Option<SparseValues<'a>>,
}

/// Replacement values of a sparse accessor. Their indices have not been decoded.
struct SparseValues<'a> {
    /// The JSON path of the indices.
    at: String,
    component: ComponentType,
    indices: &'a [u8],
    values: &'a [u8],
}

impl<'a> AccessorResolver<'a> {
    /// Returns the bytes of a buffer view.
    fn view(&self, view: &Located<'a>) -> Result<BufferView<'a>, Error> {
        let buffer_at = view.need("buffer")?;
        let buffer = buffer_at.size()?;
        let Some(owner) = self.buffers.get(buffer) else {
            return Err(buffer_at.wrong(format!("less than {}, the number of buffers", self.buffers.len())));
        };
        let bytes = owner.as_slice();
        let length_at = view.need("byteLength")?;
        let (offset, length) = (view.size_or("byteOffset", 0)?, length_at.size()?);
        if length == 0 {
            return Err(length_at.wrong("at least 1"));
        }
        let stride = match view.field("byteStride") {
            None => None,
            Some(stride) => match stride.size()? {
                allowed @ 0..=MAX_STRIDE => Some(allowed),
                _ => return Err(stride.wrong(format!("at most {MAX_STRIDE}"))),
            },
        };
        match offset.checked_add(length).and_then(|end| bytes.get(offset..end)) {
            Some(bytes) => Ok(BufferView { bytes, start: (owner, offset), stride }),
            None => Err(Error::format(
                view.at.clone(),
                format!("{} from byte {offset}", counted(length, "byte")),
                format!("a range within the {} of buffers[{buffer}]", counted(bytes.len(), "byte")),
            )),
        }
    }

    /// Returns the bytes of the buffer view at index `reference`, shared with the buffer.
    pub(in crate::gltf) fn shared_view(&self, reference: &Located<'a>) -> Result<SharedBytes, Error> {
        let view = self.view(&reference.target(self.root, "bufferViews")?)?;
        let (owner, offset) = view.start;
        let first = owner.range.start + offset;
        Ok(SharedBytes { owner: owner.owner.clone(), range: first..first + view.bytes.len() })
    }

    /// Returns the values of the accessor at index `reference`.
    pub(in crate::gltf) fn values(&self, reference: &Located<'a>) -> Result<AccessorValues<'a>, Error> {
        self.values_of(reference.target(self.root, "accessors")?)
    }

    /// Returns the values of an accessor.
    pub(in crate::gltf) fn values_of(&self, accessor: Located<'a>) -> Result<AccessorValues<'a>, Error> {
        let component = ComponentType::from_code(&accessor.need("componentType")?)?;
        let kind = accessor.need("type")?;
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
        let count_at = accessor.need("count")?;
        let count = count_at.size()?;
        if count == 0 || count > tristrip::MAX_COUNT {
            return Err(count_at.wrong(format!("1 to {}", tristrip::MAX_COUNT)));
        }
        let matrix = columns > 1;
        let column = rows * component.bytes();
        let element = if matrix { columns * column.next_multiple_of(4) } else { column };
        let offset = accessor.size_or("byteOffset", 0)?;
        let base = match accessor.field("bufferView") {
            None => None,
            Some(view) => Some(self.strided(&accessor, &view, offset, element, count)?),
        };
        let sparse =
            accessor.field("sparse").map(|sparse| self.sparse(&sparse, element, count)).transpose()?;
        let normalized = match accessor.field("normalized") {
            None => false,
            Some(p) => p.value.as_bool().ok_or_else(|| p.wrong("true or false"))?,
        };
        let components = rows * columns;
        let at = accessor.at;
        Ok(AccessorValues { at, component, components, matrix, element, count, normalized, base, sparse })
    }

    /// Returns the bytes starting at an accessor's first value, and the stride of its values.
    fn strided(
        &self,
        accessor: &Located<'_>,
        view: &Located<'a>,
        offset: usize,
        element: usize,
        count: usize,
    ) -> Result<(&'a [u8], usize), Error> {
        let view_at = view.target(self.root, "bufferViews")?;
        let view = self.view(&view_at)?;
        let stride = view.stride.unwrap_or(element);
        if stride < element {
            return Err(Error::format(
                format!("{}.byteStride", view_at.at),
                stride.to_string(),
                format!("at least {element}, the size of the values of {}", accessor.at),
            ));
        }
        let length = (count as u64 - 1) * stride as u64 + element as u64;
        match view.bytes.get(offset..) {
            Some(bytes) if bytes.len() as u64 >= length => Ok((bytes, stride)),
            _ => Err(Error::format(
                accessor.at.clone(),
                format!("{}: {} from byte {offset}", counted(count, "value"), counted(length, "byte")),
                format!("a range within the {} of {}", counted(view.bytes.len(), "byte"), view_at.at),
            )),
        }
    }

    fn sparse(&self, sparse: &Located<'a>, element: usize, count: usize) -> Result<SparseValues<'a>, Error> {
        let count_at = sparse.need("count")?;
        let sparse_count = count_at.size()?;
        if sparse_count == 0 || sparse_count > count {
            return Err(count_at.wrong(format!("1 to {count}, the accessor's count")));
        }
        let indices = sparse.need("indices")?;
        let code = indices.need("componentType")?;
        let component = ComponentType::from_code(&code)?;
        if !matches!(component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32) {
            return Err(code.wrong("5121, 5123 or 5125"));
        }
        let bytes_of = |array: &Located<'a>, element| {
            let offset = array.size_or("byteOffset", 0)?;
            self.strided(array, &array.need("bufferView")?, offset, element, sparse_count)
        };
        let (bytes, _) = bytes_of(&indices, component.bytes())?;
        let (values, _) = bytes_of(&sparse.need("values")?, element)?;
        let (indices, at) = (&bytes[..sparse_count * component.bytes()], indices.at);
        Ok(SparseValues { at, component, indices, values: &values[..sparse_count * element] })
    }
}

impl SparseValues<'_> {
    /// Decodes the indices and checks that they are ascending and below `count`.
    fn indices(&self, count: usize) -> Result<Vec<u32>, Error> {
        let mut replaced = Vec::with_capacity(self.indices.len() / self.component.bytes());
        for (i, raw) in self.indices.chunks_exact(self.component.bytes()).enumerate() {
            let index = self.component.index(raw);
            if index as usize >= count || replaced.last().is_some_and(|&last| index <= last) {
                return Err(Error::format(
                    format!("{}, index {i}", self.at),
                    index.to_string(),
                    format!("ascending indices below {count}"),
                ));
            }
            replaced.push(index);
        }
        Ok(replaced)
    }
}

impl AccessorValues<'_> {
    /// Checks the indices of the sparse values.
    pub(in crate::gltf) fn check_sparse_indices(&self) -> Result<(), Error> {
        self.sparse.as_ref().map_or(Ok(()), |sparse| sparse.indices(self.count).map(drop))
    }

    /// Returns the first `count` values, or all if there are fewer. Sparse replacements among them
    /// are kept.
    pub(in crate::gltf) fn first(mut self, count: usize) -> Result<Self, Error> {
        let count = count.min(self.count);
        if let Some(sparse) = &mut self.sparse {
            let left = sparse.indices(self.count)?.partition_point(|&index| (index as usize) < count);
            sparse.indices = &sparse.indices[..left * sparse.component.bytes()];
            sparse.values = &sparse.values[..left * self.element];
        }
        Ok(Self { count, ..self })
    }

    /// Checks whether the values are contiguous in a view and none of them is replaced.
    pub(in crate::gltf) fn is_packed(&self) -> bool {
        self.sparse.is_none() && self.base.is_some_and(|(_, stride)| stride == self.element)
    }

    /// Returns the number of sparse replacements.
    pub(in crate::gltf) fn sparse_count(&self) -> usize {
        self.sparse.as_ref().map_or(0, |sparse| sparse.values.len() / self.element)
    }

    /// Returns the size of the values in the file, without the bytes between them. Replaced values
    /// count twice, and their indices are included.
    pub(in crate::gltf) fn stored_bytes(&self) -> usize {
        let base = if self.base.is_some() { self.count * self.element } else { 0 };
        base + self.sparse.as_ref().map_or(0, |sparse| sparse.indices.len() + sparse.values.len())
    }

    /// Decodes all values; each has `per` items of `N` bytes.
    fn decode<T: Copy, const N: usize>(
        &self,
        per: usize,
        read: impl Fn([u8; N]) -> T,
    ) -> Result<Vec<T>, Error> {
        let append = |raw: &[u8], out: &mut Vec<T>| {
            out.extend(raw.as_chunks::<N>().0.iter().map(|&item| read(item)));
        };
        let mut out = Vec::with_capacity(self.count * per);
        match self.base {
            Some((bytes, stride)) if stride == per * N => append(&bytes[..self.count * stride], &mut out),
            Some((bytes, stride)) => {
                let values = bytes.chunks(stride).take(self.count);
                values.for_each(|value| append(&value[..per * N], &mut out));
            }
            None => out.resize(self.count * per, read([0; N])),
        }
        if let Some(sparse) = &self.sparse {
            let mut one = Vec::with_capacity(per);
            let replaced = sparse.indices(self.count)?;
            for (index, raw) in replaced.into_iter().zip(sparse.values.chunks_exact(self.element)) {
                one.clear();
                append(raw, &mut one);
                out[index as usize * per..][..per].copy_from_slice(&one);
            }
        }
        Ok(out)
    }

    /// Returns the bytes of all values, one value after the other.
    pub(in crate::gltf) fn raw(&self) -> Result<Vec<u8>, Error> {
        self.decode(self.element, u8::from_le_bytes)
    }

    /// Iterates over the byte offsets of the components within a value; the columns of matrices may
    /// be padded.
    pub(in crate::gltf) fn component_offsets(&self) -> impl Iterator<Item = usize> + use<> {
        let rows = if self.matrix { self.components.isqrt() } else { self.components };
        let (bytes, column) = (self.component.bytes(), self.element * rows / self.components);
        (0..self.components).map(move |i| i / rows * column + i % rows * bytes)
    }

    /// Decodes positions; integers are allowed only with `KHR_mesh_quantization`.
    pub(in crate::gltf) fn positions(
        &self,
        root: &Members,
        budget: &mut DecodeBudget,
    ) -> Result<Vec<[f32; 3]>, Error> {
        if self.components != 3 {
            let found = counted(self.components, "component");
            return Err(Error::format(format!("{}.type", self.at), found, "VEC3 for POSITION"));
        }
        let integer = matches!(
            self.component,
            ComponentType::I8 | ComponentType::U8 | ComponentType::I16 | ComponentType::U16
        );
        if self.component != ComponentType::F32 && !(integer && uses(root, QUANTIZATION)) {
            return Err(Error::format(
                format!("{}.componentType", self.at),
                self.component.code().to_string(),
                format!("5126 (FLOAT) for POSITION, or a smaller integer under {QUANTIZATION}"),
            ));
        }
        budget.charge(&self.at, self.count, size_of::<[f32; 3]>())?;
        let scale = match (self.normalized, self.component) {
            (true, ComponentType::I8) => 127.0,
            (true, ComponentType::U8) => 255.0,
            (true, ComponentType::I16) => 32767.0,
            (true, ComponentType::U16) => 65535.0,
            _ => 1.0,
        };
        let signed = |x: f32| (x / scale).max(lowest(scale));
        let out = match self.component {
            ComponentType::F32 => self.decode(1, |raw: [u8; 12]| vector(&raw, f32::from_le_bytes)),
            ComponentType::I8 => {
                self.decode(1, |raw: [u8; 3]| vector(&raw, |b| signed(i8::from_le_bytes(b).into())))
            }
            ComponentType::U8 => {
                self.decode(1, |raw: [u8; 3]| vector(&raw, |b| f32::from(u8::from_le_bytes(b)) / scale))
            }
            ComponentType::I16 => {
                self.decode(1, |raw: [u8; 6]| vector(&raw, |b| signed(i16::from_le_bytes(b).into())))
            }
            ComponentType::U16 | ComponentType::U32 => {
                self.decode(1, |raw: [u8; 6]| vector(&raw, |b| f32::from(u16::from_le_bytes(b)) / scale))
            }
        }?;
        let bad = out.iter().enumerate().find(|(_, p)| !p.iter().all(|x| x.is_finite()));
        if let Some((element, p)) = bad {
            let found = p.iter().copied().find(|x| !x.is_finite()).unwrap_or(f32::NAN);
            let at = format!("{}, element {element}", self.at);
            return Err(Error::format(at, format!("coordinate {found}"), "a finite number"));
        }
        Ok(out)
    }

    /// Decodes indices of a triangle list, all below `vertex_count`.
    pub(in crate::gltf) fn list_indices(
        &self,
        vertex_count: usize,
        budget: &mut DecodeBudget,
    ) -> Result<Vec<u32>, Error> {
        let indices = self.decode_indices(budget)?;
        self.check_indices(&indices, vertex_count, |_| false)?;
        Ok(indices)
    }

    /// Decodes indices of strips or fans. Each is below `vertex_count` or a restart, the highest
    /// value of the index type.
    pub(in crate::gltf) fn strip_indices(
        &self,
        vertex_count: usize,
        budget: &mut DecodeBudget,
    ) -> Result<StripIndices, Error> {
        let mut values = self.decode_indices(budget)?;
        let highest = u32::MAX >> (32 - 8 * self.component.bytes());
        if highest != StripIndices::RESTART {
            values.iter_mut().filter(|i| **i == highest).for_each(|i| *i = StripIndices::RESTART);
        }
        self.check_indices(&values, vertex_count, |i| i == StripIndices::RESTART)?;
        Ok(StripIndices(values))
    }

    fn decode_indices(&self, budget: &mut DecodeBudget) -> Result<Vec<u32>, Error> {
        let unsigned = matches!(self.component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32);
        if self.components != 1 || !unsigned {
            return Err(Error::format(
                self.at.clone(),
                format!("{} of type {}", counted(self.components, "component"), self.component.code()),
                "SCALAR of 5121, 5123 or 5125 for indices",
            ));
        }
        budget.charge(&self.at, self.count, size_of::<u32>())?;
        match self.component {
            ComponentType::U8 => self.decode(1, |b| u8::from_le_bytes(b).into()),
            ComponentType::U16 => self.decode(1, |b| u16::from_le_bytes(b).into()),
            _ => self.decode(1, u32::from_le_bytes),
        }
    }

    fn check_indices(
        &self,
        indices: &[u32],
        vertex_count: usize,
        is_restart: impl Fn(u32) -> bool,
    ) -> Result<(), Error> {
        let is_valid = |i: u32| ((i as usize) < vertex_count) | is_restart(i);
        // No early exit, so the check vectorizes; a second pass finds the position.
        if indices.iter().fold(true, |all, &i| all & is_valid(i)) {
            return Ok(());
        }
        match indices.iter().enumerate().find(|&(_, &i)| !is_valid(i)) {
            None => Ok(()),
            Some((element, found)) => Err(Error::format(
                format!("{}, element {element}", self.at),
                format!("index {found}"),
                format!("less than {vertex_count}, the number of vertices"),
            )),
        }
    }

    /// Decodes the values of any attribute.
    pub(in crate::gltf) fn attribute(&self) -> Result<AttributeData, Error> {
        let per = self.components;
        Ok(match self.component {
            ComponentType::I8 => AttributeData::I8(self.decode(per, i8::from_le_bytes)?),
            ComponentType::U8 => AttributeData::U8(self.decode(per, u8::from_le_bytes)?),
            ComponentType::I16 => AttributeData::I16(self.decode(per, i16::from_le_bytes)?),
            ComponentType::U16 => AttributeData::U16(self.decode(per, u16::from_le_bytes)?),
            ComponentType::U32 => AttributeData::U32(self.decode(per, u32::from_le_bytes)?),
            ComponentType::F32 => AttributeData::F32(self.decode(per, f32::from_le_bytes)?),
        })
    }
}

/// The indices of the strips or fans of one primitive, separated by restarts.
pub(in crate::gltf) struct StripIndices(Vec<u32>);

impl StripIndices {
    /// The restart index. No vertex has this index, because a mesh has fewer vertices.
    const RESTART: u32 = u32::MAX;

    /// Returns every vertex in order, as a primitive without indices draws them.
    pub(in crate::gltf) fn all_vertices(vertex_count: usize) -> Self {
        Self((0..vertex_count as u32).collect())
    }

    /// Returns the number of indices, restarts included.
    pub(in crate::gltf) fn len(&self) -> usize {
        self.0.len()
    }

    /// Returns the indices themselves.
    pub(in crate::gltf) fn into_indices(self) -> Vec<u32> {
        self.0
    }

    /// Iterates over the strips or fans between restarts, empty ones included.
    pub(in crate::gltf) fn runs(&self) -> impl Iterator<Item = &[u32]> {
        self.0.split(|&i| i == Self::RESTART)
    }
}

/// Checks every buffer view, including those that reading does not use, so writing cannot fail on
/// one.
pub(in crate::gltf) fn check_views(source: &AccessorResolver<'_>) -> Result<(), Error> {
    for view in Located::entries(source.root, "bufferViews")? {
        source.view(&view)?;
    }
    Ok(())
}

/// Returns the lower bound of decoded values: −1 for normalized integers.
fn lowest(scale: f32) -> f32 {
    if scale > 1.0 { -1.0 } else { f32::MIN }
}

/// Reads three components; the raw value must have at least three.
fn vector<const N: usize>(raw: &[u8], read: impl Fn([u8; N]) -> f32) -> [f32; 3] {
    let mut out = [0.0; 3];
    for (x, b) in out.iter_mut().zip(raw.as_chunks::<N>().0) {
        *x = read(*b);
    }
    out
}
