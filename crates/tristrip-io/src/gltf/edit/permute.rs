//! Permutes vertex data of accessors in place. Values of removed vertices are not moved: the
//! remaining values come first, and the bytes after them are undefined.

use std::collections::HashSet;
use std::ops::Range;

use tristrip::VertexOrder;

use crate::edit::vertex_group::Renumbering;
use crate::error::Error;
use crate::gltf::document::accessor::AccessorResolver;
use crate::gltf::document::budget::DecodeBudget;
use crate::gltf::document::byte_ranges::SharedBytes;
use crate::gltf::document::json::{Members, Value};
use crate::gltf::document::references::{has_number, views_of_accessor};
use crate::gltf::document::{Located, array, index};

/// Bytes of accessors that may be checked per byte of the buffers, in addition to the constant.
pub(in crate::gltf) const VERTEX_FACTOR: u64 = 16;

pub(in crate::gltf) const OVER_BUDGET: &str = "the buffers contain more data than the limits allow";

/// Values at a constant stride within a buffer; each value occupies one slot.
#[derive(Clone, Copy)]
pub(in crate::gltf) struct StridedRange {
    pub(in crate::gltf) buffer: usize,
    pub(in crate::gltf) start: usize,
    pub(in crate::gltf) stride: usize,
    pub(in crate::gltf) element: usize,
    count: usize,
    /// The end of the view.
    end: usize,
}

impl StridedRange {
    /// Returns the slots of `count` values in the view that `holder` refers to. The reader has
    /// checked their range.
    fn of(root: &Members, holder: &Value, element: usize, count: usize) -> Option<Self> {
        let view = array(root, "bufferViews").ok()?.get(holder.get("bufferView").and_then(index)?)?;
        let field = |object: &Value, name| object.get(name).and_then(index);
        let start = field(view, "byteOffset").unwrap_or(0);
        Some(Self {
            buffer: field(view, "buffer")?,
            start: start + field(holder, "byteOffset").unwrap_or(0),
            end: start + field(view, "byteLength")?,
            stride: field(view, "byteStride").unwrap_or(element),
            element,
            count,
        })
    }

    fn packed(self) -> Self {
        Self { stride: self.element, ..self }
    }

    fn range(&self, slot: usize) -> Range<usize> {
        let start = self.start + slot * self.stride;
        start..start + self.element
    }

    pub(in crate::gltf) fn ranges(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let slots = *self;
        (0..slots.count).map(move |slot| slots.range(slot))
    }

    /// Returns the byte range from the first value to the end of the last.
    pub(in crate::gltf) fn span(&self) -> Range<usize> {
        let end = self.count.checked_sub(1).map_or(self.start, |last| self.range(last).end);
        self.start..end
    }

    /// Returns the byte range after the first `left` values, including the padding between values.
    pub(in crate::gltf) fn tail(&self, left: usize) -> Range<usize> {
        let end = (self.span().end + (self.stride - self.element)).min(self.end);
        (self.start + left * self.stride).min(end)..end
    }
}

/// The slots of an accessor's values.
pub(in crate::gltf) struct AccessorLayout {
    /// The index of the accessor.
    pub(in crate::gltf) accessor: usize,
    /// Whether the values are vertex indices, which are renamed in place instead of moved.
    pub(in crate::gltf) holds_indices: bool,
    count: usize,
    /// `None` if all base values are zero.
    pub(in crate::gltf) base: Option<StridedRange>,
    /// Indices and values of the vertices that differ from the base.
    pub(in crate::gltf) sparse: Option<[StridedRange; 2]>,
}

impl AccessorLayout {
    /// Finds the slots of an accessor that has a value for each of `vertex_count` vertices, or
    /// returns why they cannot be permuted.
    pub(in crate::gltf) fn of_vertices(
        resolver: &AccessorResolver<'_>,
        accessor: usize,
        vertex_count: usize,
        budget: &mut DecodeBudget,
    ) -> Result<Self, String> {
        let array = Self::find(resolver, accessor, budget)?;
        if array.count != vertex_count {
            return Err(format!("accessors[{accessor}] does not have one value per vertex"));
        }
        Ok(array)
    }

    /// Finds the slots of the indices of points or lines, or returns why they cannot be changed.
    pub(in crate::gltf) fn of_indices(
        resolver: &AccessorResolver<'_>,
        accessor: usize,
        budget: &mut DecodeBudget,
    ) -> Result<Self, String> {
        let array = Self::find(resolver, accessor, budget)?;
        if array.sparse.is_some() {
            return Err("points or lines that use the vertices have sparse indices".into());
        }
        Ok(Self { holds_indices: true, ..array })
    }

    /// Finds the slots of an accessor, or returns why they cannot be permuted.
    pub(in crate::gltf) fn find(
        resolver: &AccessorResolver<'_>,
        accessor: usize,
        budget: &mut DecodeBudget,
    ) -> Result<Self, String> {
        let object = array(resolver.root, "accessors").ok().and_then(|all| all.get(accessor));
        let object = object.ok_or("an accessor is missing")?;
        // The next step reads the sparse indices.
        let sparse_count = object.get("sparse").and_then(|sparse| index(sparse.get("count")?)).unwrap_or(0);
        if !budget.try_charge(sparse_count, size_of::<u32>()) {
            return Err(OVER_BUDGET.into());
        }
        let number = Value::from(accessor);
        let reference = Located { value: &number, at: format!("accessors[{accessor}]") };
        let values = resolver.values(&reference).map_err(|error| error.to_string())?;
        values.check_sparse_indices().map_err(|error| error.to_string())?;
        let (count, element) = (values.count, values.element);
        let view = |holder: &Value| {
            array(resolver.root, "bufferViews").ok()?.get(holder.get("bufferView").and_then(index)?)
        };
        let mut holders = vec![object];
        let sparse = object.get("sparse").and_then(|sparse| {
            let count = sparse.get("count").and_then(index)?;
            let (indices, values) = (sparse.get("indices")?, sparse.get("values")?);
            holders.extend([indices, values]);
            let width = match indices.get("componentType").and_then(index)? {
                5121 => 1,
                5123 => 2,
                _ => 4,
            };
            let slots = |holder, element| {
                StridedRange::of(resolver.root, holder, element, count).map(StridedRange::packed)
            };
            Some([slots(indices, width)?, slots(values, element)?])
        });
        let may_name_vertices = |object: &Value| {
            ["extensions", "extras"].iter().filter_map(|key| object.get(key)).any(has_number)
        };
        if (holders.iter())
            .any(|holder| may_name_vertices(holder) || view(holder).is_some_and(may_name_vertices))
        {
            return Err("an extension or extras of an accessor or view may refer to vertices by index".into());
        }
        let base = StridedRange::of(resolver.root, object, element, count);
        let array = Self { accessor, holds_indices: false, count, base, sparse };
        for slots in array.slots() {
            if !budget.try_charge(slots.count, slots.element) {
                return Err(OVER_BUDGET.into());
            }
        }
        Ok(array)
    }

    pub(in crate::gltf) fn slots(&self) -> impl Iterator<Item = StridedRange> + use<> {
        self.base.into_iter().chain(self.sparse.into_iter().flatten())
    }
}

/// Flags of a byte: used by data that is not permuted, by one group, by a second group.
const OTHER: u8 = 1;
const ONE_GROUP: u8 = 2;
const TWO_GROUPS: u8 = 4;

/// The owners of each byte of the buffers, as flags.
pub(in crate::gltf) struct ByteOwners(Vec<Vec<u8>>);

impl ByteOwners {
    pub(in crate::gltf) fn new(buffers: &[SharedBytes]) -> Self {
        Self(buffers.iter().map(|bytes| vec![0; bytes.len()]).collect())
    }

    /// Marks the bytes of everything that is not permuted. Returns false if this exceeds the
    /// budget.
    pub(in crate::gltf) fn mark_others(
        &mut self,
        resolver: &AccessorResolver<'_>,
        moving: &HashSet<usize>,
        budget: &mut DecodeBudget,
    ) -> Result<bool, Error> {
        let mut of_accessors = HashSet::new();
        let mut whole = HashSet::new();
        for number in 0..array(resolver.root, "accessors")?.len() {
            let views = || views_of_accessor(resolver.root, number);
            of_accessors.extend(views());
            if moving.contains(&number) {
                continue;
            }
            match AccessorLayout::find(resolver, number, budget) {
                Ok(array) => array.slots().for_each(|slots| self.mark(&slots, OTHER)),
                Err(_) => whole.extend(views()),
            }
        }
        for image in array(resolver.root, "images")? {
            whole.extend(image.get("bufferView").and_then(index));
        }
        let views = array(resolver.root, "bufferViews")?;
        whole.extend((0..views.len()).filter(|view| !of_accessors.contains(view)));
        for view in whole.into_iter().filter_map(|view| views.get(view)) {
            let field = |name| view.get(name).and_then(index);
            let (Some(buffer), Some(element)) = (field("buffer"), field("byteLength")) else { continue };
            let start = field("byteOffset").unwrap_or(0);
            if !budget.try_charge(1, element) {
                self.0.iter_mut().for_each(|bytes| bytes.fill(OTHER));
                return Ok(false);
            }
            self.mark(
                &StridedRange { buffer, start, stride: element, element, count: 1, end: start + element },
                OTHER,
            );
        }
        Ok(true)
    }

    /// Marks the bytes of one group.
    pub(in crate::gltf) fn mark_group(&mut self, arrays: &[AccessorLayout]) {
        for slots in arrays.iter().flat_map(AccessorLayout::slots) {
            for byte in self.bytes(&slots).filter(|byte| **byte & ONE_GROUP != 0) {
                *byte |= TWO_GROUPS;
            }
        }
        arrays.iter().flat_map(AccessorLayout::slots).for_each(|slots| self.mark(&slots, ONE_GROUP));
    }

    /// Checks whether all bytes of a group belong only to it.
    pub(in crate::gltf) fn is_exclusive(&mut self, arrays: &[AccessorLayout]) -> bool {
        let mut slots = arrays.iter().flat_map(AccessorLayout::slots);
        slots.all(|slots| self.bytes(&slots).all(|byte| *byte == ONE_GROUP))
    }

    /// Checks whether other data uses bytes of an accessor.
    pub(in crate::gltf) fn has_others(&mut self, array: &AccessorLayout) -> bool {
        array.slots().any(|slots| self.bytes(&slots).any(|byte| *byte & OTHER != 0))
    }

    fn mark(&mut self, slots: &StridedRange, owner: u8) {
        self.bytes(slots).for_each(|byte| *byte |= owner);
    }

    fn bytes(&mut self, slots: &StridedRange) -> impl Iterator<Item = &mut u8> {
        let bytes = self.0.get_mut(slots.buffer).and_then(|bytes| bytes.get_mut(slots.start..));
        let (element, count) = (slots.element, slots.count);
        let values = bytes.into_iter().flat_map(|bytes| bytes.chunks_mut(slots.stride.max(1))).take(count);
        values.flat_map(move |value| value.iter_mut().take(element))
    }
}

/// Buffers with the values of some accessors in a new order.
pub(in crate::gltf) struct PermutedBuffers<'a> {
    old: &'a [SharedBytes],
    /// `None` for an unchanged buffer.
    new: Vec<Option<Vec<u8>>>,
}

impl<'a> PermutedBuffers<'a> {
    pub(in crate::gltf) fn new(buffers: &'a [SharedBytes]) -> Self {
        Self { old: buffers, new: vec![None; buffers.len()] }
    }

    /// Returns the buffers; unchanged ones share their bytes with the old ones.
    pub(in crate::gltf) fn finish(self) -> Vec<SharedBytes> {
        (self.old.iter().zip(self.new))
            .map(|(old, new)| new.map_or_else(|| old.clone(), SharedBytes::from))
            .collect()
    }

    /// Moves the values of a group and checks the result.
    pub(in crate::gltf) fn permute(
        &mut self,
        arrays: &[AccessorLayout],
        renumbering: &Renumbering,
    ) -> Result<(), String> {
        for array in arrays {
            self.permute_accessor(array, renumbering)?;
        }
        if arrays.iter().all(|array| self.has_new_order(array, renumbering)) {
            return Ok(());
        }
        Err("accessors overlap at different vertices".into())
    }

    fn permute_accessor(&mut self, array: &AccessorLayout, renumbering: &Renumbering) -> Result<(), String> {
        if array.holds_indices {
            return self.rename_indices(array, &renumbering.order);
        }
        if let Some(base) = array.base {
            let (old, new) = self.buffer(base.buffer).ok_or("a buffer is missing")?;
            for (new_range, &old_slot) in base.ranges().zip(renumbering.left_to_old()) {
                new[new_range].copy_from_slice(&old[base.range(old_slot as usize)]);
            }
        }
        let Some([indices, values]) = array.sparse else { return Ok(()) };
        let renamed = self.renamed(&indices, renumbering);
        let highest = renamed.last().map_or(0, |&(vertex, _)| u64::from(vertex));
        if highest >> (8 * indices.element) > 0 {
            return Err("the new vertex indices do not fit the index type of a sparse accessor".into());
        }
        for (slot, (vertex, from)) in renamed.into_iter().enumerate() {
            let (_, new) = self.buffer(indices.buffer).ok_or("a buffer is missing")?;
            new[indices.range(slot)].copy_from_slice(&vertex.to_le_bytes()[..indices.element]);
            let (old, new) = self.buffer(values.buffer).ok_or("a buffer is missing")?;
            new[values.range(slot)].copy_from_slice(&old[values.range(from)]);
        }
        Ok(())
    }

    /// Renames the vertices in the indices of points or lines; restarts are unchanged.
    fn rename_indices(&mut self, array: &AccessorLayout, order: &VertexOrder) -> Result<(), String> {
        let Some(base) = array.base else { return Ok(()) };
        let (old, new) = self.buffer(base.buffer).ok_or("a buffer is missing")?;
        for range in base.ranges() {
            let vertex = renamed_index(&old[range.clone()], order);
            let vertex =
                vertex.ok_or("the new vertex indices do not fit the index type of points or lines")?;
            new[range].copy_from_slice(&vertex.to_le_bytes()[..base.element]);
        }
        Ok(())
    }

    /// Returns the new vertex indices of sparse values in ascending order, each with the slot of
    /// its value. Removed vertices are omitted.
    fn renamed(&self, indices: &StridedRange, renumbering: &Renumbering) -> Vec<(u32, usize)> {
        let Some(old) = self.old.get(indices.buffer).map(SharedBytes::as_slice) else { return Vec::new() };
        let new =
            |vertex: u32| renumbering.order.old_to_new().get(vertex as usize).copied().unwrap_or(vertex);
        let mut renamed: Vec<_> =
            indices.ranges().map(|range| number(&old[range])).map(new).zip(0..).collect();
        renamed.retain(|&(vertex, _)| (vertex as usize) < renumbering.left);
        renamed.sort_unstable();
        renamed
    }

    /// Returns the number of sparse values of an accessor whose vertices are kept.
    pub(in crate::gltf) fn sparse_left(&self, array: &AccessorLayout, renumbering: &Renumbering) -> usize {
        array.sparse.map_or(0, |[indices, _]| self.renamed(&indices, renumbering).len())
    }

    /// Checks whether the values of an accessor are in the new order.
    fn has_new_order(&self, array: &AccessorLayout, renumbering: &Renumbering) -> bool {
        let bytes_of = |buffer: usize| {
            let old = self.old.get(buffer).map(SharedBytes::as_slice);
            (old, self.new.get(buffer).and_then(Option::as_deref).or(old))
        };
        let is_moved = |slots: &StridedRange, new: usize, old: usize| {
            let (bytes, moved) = bytes_of(slots.buffer);
            moved.and_then(|b| b.get(slots.range(new))) == bytes.and_then(|b| b.get(slots.range(old)))
        };
        let is_renamed = |slots: &StridedRange, slot: usize, vertex: u32| {
            let expected = &vertex.to_le_bytes()[..slots.element];
            bytes_of(slots.buffer).1.and_then(|b| b.get(slots.range(slot))) == Some(expected)
        };
        if array.holds_indices {
            return array.base.is_none_or(|base| {
                let Some(old) = bytes_of(base.buffer).0 else { return false };
                let new = |range: Range<usize>| renamed_index(old.get(range)?, &renumbering.order);
                (0..base.count).all(|slot| new(base.range(slot)).is_some_and(|v| is_renamed(&base, slot, v)))
            });
        }
        let base = array.base.is_none_or(|base| {
            let mut left = renumbering.left_to_old().iter().enumerate();
            left.all(|(new, &old)| is_moved(&base, new, old as usize))
        });
        let sparse = array.sparse.is_none_or(|[indices, values]| {
            let mut renamed = self.renamed(&indices, renumbering).into_iter().enumerate();
            renamed.all(|(slot, (vertex, from))| {
                is_renamed(&indices, slot, vertex) && is_moved(&values, slot, from)
            })
        });
        base && sparse
    }

    /// Restores the old values of an accessor whose bytes belong to no other group.
    pub(in crate::gltf) fn restore(&mut self, array: &AccessorLayout) {
        for slots in array.slots() {
            let Some((old, new)) = self.buffer(slots.buffer) else { continue };
            for range in slots.ranges() {
                new[range.clone()].copy_from_slice(&old[range]);
            }
        }
    }

    /// Returns the old and the new bytes of a buffer.
    fn buffer(&mut self, buffer: usize) -> Option<(&[u8], &mut Vec<u8>)> {
        let old = self.old.get(buffer)?.as_slice();
        Some((old, self.new.get_mut(buffer)?.get_or_insert_with(|| old.to_vec())))
    }
}

/// Reads a little-endian integer of at most four bytes.
fn number(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |n, &b| n << 8 | u32::from(b))
}

/// Returns the new vertex of an index if it fits the index type. A restart, the highest value of
/// the type, is unchanged.
fn renamed_index(index: &[u8], order: &VertexOrder) -> Option<u32> {
    let restart = u32::MAX.checked_shr(32 - 8 * index.len() as u32)?;
    let vertex = number(index);
    if vertex == restart {
        return Some(restart);
    }
    order.old_to_new().get(vertex as usize).copied().filter(|&new| new < restart)
}
