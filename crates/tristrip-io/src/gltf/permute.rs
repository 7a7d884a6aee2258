//! Vertex data of accessors moved into a new vertex order, within the bytes that the accessors already have.

use std::collections::HashSet;
use std::ops::Range;

use tristrip::VertexOrder;

use super::accessor::AccessorResolver;
use super::budget::DecodeBudget;
use super::document::{Located, array, index};
use super::json::{Members, Value};
use super::references::has_number;
use super::shared_bytes::SharedBytes;
use crate::error::Error;

pub(super) const OVER_BUDGET: &str = "the buffers hold more data than the limits allow to check";

/// Values at a constant stride within a buffer, one slot each.
#[derive(Clone, Copy)]
struct StridedRange {
    buffer: usize,
    start: usize,
    stride: usize,
    element: usize,
    count: usize,
}

impl StridedRange {
    /// Returns the slots of `count` values in the view that `holder` refers to; the reader has checked their range.
    fn of(root: &Members, holder: &Value, element: usize, count: usize) -> Option<Self> {
        let view = array(root, "bufferViews").ok()?.get(holder.get("bufferView").and_then(index)?)?;
        let field = |object: &Value, name| object.get(name).and_then(index);
        Some(Self {
            buffer: field(view, "buffer")?,
            start: field(view, "byteOffset").unwrap_or(0) + field(holder, "byteOffset").unwrap_or(0),
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

    fn ranges(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let slots = *self;
        (0..slots.count).map(move |slot| slots.range(slot))
    }
}

/// The slots of the values of an accessor.
pub(super) struct AccessorLayout {
    count: usize,
    /// `None` for zeros.
    base: Option<StridedRange>,
    /// Indices and values of the vertices that differ from the base.
    sparse: Option<[StridedRange; 2]>,
}

impl AccessorLayout {
    /// Finds the slots of an accessor that has a value for each of `vertex_count` vertices, or returns why they cannot be
    /// permuted.
    pub(super) fn of_vertices(
        resolver: &AccessorResolver<'_>,
        accessor: usize,
        vertex_count: usize,
        budget: &mut DecodeBudget,
    ) -> Result<Self, String> {
        let array = Self::find(resolver, accessor, budget)?;
        if array.count != vertex_count {
            return Err(format!("accessors[{accessor}] does not have a value for each vertex"));
        }
        Ok(array)
    }

    /// Finds the slots of an accessor, or returns why they cannot be permuted.
    fn find(
        resolver: &AccessorResolver<'_>,
        accessor: usize,
        budget: &mut DecodeBudget,
    ) -> Result<Self, String> {
        let object = array(resolver.root, "accessors").ok().and_then(|all| all.get(accessor));
        let object = object.ok_or("an accessor is missing")?;
        // Finding them reads the sparse indices.
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
            return Err(
                "an extension or extras of an accessor or view may refer to vertices by number".into()
            );
        }
        let base = StridedRange::of(resolver.root, object, element, count);
        let array = Self { count, base, sparse };
        for slots in array.slots() {
            if !budget.try_charge(slots.count, slots.element) {
                return Err(OVER_BUDGET.into());
            }
        }
        Ok(array)
    }

    fn slots(&self) -> impl Iterator<Item = StridedRange> + use<> {
        self.base.into_iter().chain(self.sparse.into_iter().flatten())
    }
}

/// Flags of a byte: data that is not permuted, a group, a second group.
const OTHER: u8 = 1;
const ONE_GROUP: u8 = 2;
const TWO_GROUPS: u8 = 4;

/// The owners of each byte of the buffers, as flags.
pub(super) struct ByteOwners(Vec<Vec<u8>>);

impl ByteOwners {
    pub(super) fn new(buffers: &[SharedBytes]) -> Self {
        Self(buffers.iter().map(|bytes| vec![0; bytes.len()]).collect())
    }

    /// Marks the bytes of everything that is not permuted; returns false if that exceeds the budget.
    pub(super) fn mark_others(
        &mut self,
        resolver: &AccessorResolver<'_>,
        moving: &HashSet<usize>,
        budget: &mut DecodeBudget,
    ) -> Result<bool, Error> {
        let mut of_accessors = HashSet::new();
        let mut whole = HashSet::new();
        for (number, accessor) in array(resolver.root, "accessors")?.iter().enumerate() {
            let sparse = accessor.get("sparse");
            let holders =
                [Some(accessor), sparse.and_then(|s| s.get("indices")), sparse.and_then(|s| s.get("values"))];
            let views =
                || holders.iter().flatten().filter_map(|holder| holder.get("bufferView").and_then(index));
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
            self.mark(&StridedRange { buffer, start, stride: element, element, count: 1 }, OTHER);
        }
        Ok(true)
    }

    /// Marks the bytes of one group.
    pub(super) fn mark_group(&mut self, arrays: &[AccessorLayout]) {
        for slots in arrays.iter().flat_map(AccessorLayout::slots) {
            for byte in self.bytes(&slots).filter(|byte| **byte & ONE_GROUP != 0) {
                *byte |= TWO_GROUPS;
            }
        }
        arrays.iter().flat_map(AccessorLayout::slots).for_each(|slots| self.mark(&slots, ONE_GROUP));
    }

    /// Checks whether all bytes of a group belong only to it.
    pub(super) fn is_exclusive(&mut self, arrays: &[AccessorLayout]) -> bool {
        let mut slots = arrays.iter().flat_map(AccessorLayout::slots);
        slots.all(|slots| self.bytes(&slots).all(|byte| *byte == ONE_GROUP))
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
pub(super) struct PermutedBuffers<'a> {
    old: &'a [SharedBytes],
    /// `None` for a buffer that does not change.
    new: Vec<Option<Vec<u8>>>,
}

impl<'a> PermutedBuffers<'a> {
    pub(super) fn new(buffers: &'a [SharedBytes]) -> Self {
        Self { old: buffers, new: vec![None; buffers.len()] }
    }

    /// Returns the buffers; those without changes are shared with the old ones.
    pub(super) fn finish(self) -> Vec<SharedBytes> {
        (self.old.iter().zip(self.new))
            .map(|(old, new)| new.map_or_else(|| old.clone(), SharedBytes::from))
            .collect()
    }

    /// Moves the values of a group, and checks that all of them arrived.
    pub(super) fn permute(&mut self, arrays: &[AccessorLayout], order: &VertexOrder) -> Result<(), String> {
        for array in arrays {
            self.permute_accessor(array, order)?;
        }
        if arrays.iter().all(|array| self.has_new_order(array, order)) {
            return Ok(());
        }
        Err("accessors overlap other than by the same vertices".into())
    }

    fn permute_accessor(&mut self, array: &AccessorLayout, order: &VertexOrder) -> Result<(), String> {
        if let Some(base) = array.base {
            let (old, new) = self.buffer(base.buffer).ok_or("a buffer is missing")?;
            for (new_range, &old_slot) in base.ranges().zip(order.new_to_old()) {
                new[new_range].copy_from_slice(&old[base.range(old_slot as usize)]);
            }
        }
        let Some([indices, values]) = array.sparse else { return Ok(()) };
        let renamed = self.renamed(&indices, order);
        let highest = renamed.last().map_or(0, |&(vertex, _)| u64::from(vertex));
        if highest >> (8 * indices.element) > 0 {
            return Err("the new vertex numbers do not fit the index type of a sparse accessor".into());
        }
        for (slot, (vertex, from)) in renamed.into_iter().enumerate() {
            let (_, new) = self.buffer(indices.buffer).ok_or("a buffer is missing")?;
            new[indices.range(slot)].copy_from_slice(&vertex.to_le_bytes()[..indices.element]);
            let (old, new) = self.buffer(values.buffer).ok_or("a buffer is missing")?;
            new[values.range(slot)].copy_from_slice(&old[values.range(from)]);
        }
        Ok(())
    }

    /// Returns the new vertex numbers of sparse indices in ascending order, each with the slot of its value.
    fn renamed(&self, indices: &StridedRange, order: &VertexOrder) -> Vec<(u32, usize)> {
        let Some(old) = self.old.get(indices.buffer).map(SharedBytes::as_slice) else { return Vec::new() };
        let number = |range: Range<usize>| old[range].iter().rev().fold(0, |n, &b| n << 8 | u32::from(b));
        let new = |vertex: u32| order.old_to_new().get(vertex as usize).copied().unwrap_or(vertex);
        let mut renamed: Vec<_> = indices.ranges().map(number).map(new).zip(0..).collect();
        renamed.sort_unstable();
        renamed
    }

    /// Checks whether the values of an accessor are in the new order.
    fn has_new_order(&self, array: &AccessorLayout, order: &VertexOrder) -> bool {
        let is_moved = |slots: &StridedRange, new: usize, old: usize| {
            let bytes = self.old.get(slots.buffer).map(SharedBytes::as_slice);
            let moved = self.new.get(slots.buffer).and_then(Option::as_deref).or(bytes);
            moved.and_then(|b| b.get(slots.range(new))) == bytes.and_then(|b| b.get(slots.range(old)))
        };
        let base = array.base.is_none_or(|base| {
            order.new_to_old().iter().enumerate().all(|(new, &old)| is_moved(&base, new, old as usize))
        });
        let sparse = array.sparse.is_none_or(|[indices, values]| {
            let is_renamed = |slot: usize, vertex: u32| {
                let bytes = self.new.get(indices.buffer).and_then(Option::as_deref);
                bytes.is_some_and(|b| b[indices.range(slot)] == vertex.to_le_bytes()[..indices.element])
            };
            let renamed = self.renamed(&indices, order);
            renamed
                .into_iter()
                .enumerate()
                .all(|(slot, (vertex, from))| is_renamed(slot, vertex) && is_moved(&values, slot, from))
        });
        base && sparse
    }

    /// Restores the old values of an accessor, whose bytes belong to no other group.
    pub(super) fn restore(&mut self, array: &AccessorLayout) {
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
