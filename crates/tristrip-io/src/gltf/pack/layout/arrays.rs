//! Splits buffer views into the arrays of their accessors.

use std::collections::HashSet;
use std::ops::Range;

use super::super::packing::{OWN_MEMBERS, Packing};
use super::uses::{UseKind, Uses};
use crate::error::Error;
use crate::gltf::document::budget::{ATTRIBUTE_LIMIT, DecodeBudget};
use crate::gltf::document::buffer::view_range;
use crate::gltf::document::json::Value;
use crate::gltf::document::{Located, array, index};
use crate::gltf::edit::permute::{AccessorLayout, StridedRange, VERTEX_FACTOR};

/// The objects of an accessor that refer to a view.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Holder {
    Accessor,
    SparseIndices,
    SparseValues,
}

impl Holder {
    /// Returns this object of an accessor.
    fn of(self, accessor: &Value) -> Option<&Value> {
        match self {
            Self::Accessor => Some(accessor),
            Self::SparseIndices => accessor.get("sparse")?.get("indices"),
            Self::SparseValues => accessor.get("sparse")?.get("values"),
        }
    }
}

/// The values, sparse indices or sparse values of an accessor in a view.
#[derive(Clone, Copy)]
pub(super) struct Slots {
    pub(super) accessor: usize,
    pub(super) holder: Holder,
    kind: UseKind,
    view: usize,
    pub(super) range: StridedRange,
}

/// Slots whose bytes overlap or interleave.
pub(super) struct Array {
    pub(super) kind: UseKind,
    pub(super) slots: Vec<Slots>,
    /// The bytes from the first value to the end of the last.
    pub(super) span: Range<usize>,
}

impl Array {
    /// Returns the longest range of the array if its slots differ only in their count.
    pub(super) fn single(&self) -> Option<StridedRange> {
        let (first, others) = self.slots.split_first()?;
        let same = |a: &StridedRange, b: &StridedRange| {
            (a.start, a.stride, a.element) == (b.start, b.stride, b.element)
        };
        let longest = others.iter().map(|slots| slots.range).fold(first.range, |longest, range| {
            if range.span().end > longest.span().end { range } else { longest }
        });
        self.slots.iter().all(|slots| same(&slots.range, &longest)).then_some(longest)
    }

    /// Checks whether the array can share a view with others of its kind.
    fn fits(&self) -> bool {
        let first = &self.slots[0].range;
        let is_packed = |slots: &Slots| slots.range.stride == slots.range.element;
        match self.kind {
            _ if self.single().is_some() => true,
            UseKind::Attribute => {
                first.stride.is_multiple_of(4)
                    && self.slots.iter().all(|slots| slots.range.stride == first.stride)
            }
            _ => self.slots.iter().all(is_packed),
        }
    }
}

/// How a buffer view of the scene is written.
pub(super) enum ViewArrays {
    /// The view is not used.
    Unused,
    /// Its arrays may be moved separately.
    Apart(Vec<Array>),
    /// It is copied unchanged.
    Whole,
}

impl ViewArrays {
    /// Splits all views. Returns `None` if an accessor cannot be read.
    pub(super) fn of(scene: &Packing, uses: &Uses) -> Result<Option<Vec<Self>>, Error> {
        let root = &scene.document.root;
        let views = array(root, "bufferViews")?;
        let Some(found) = slots(scene, uses)? else { return Ok(None) };
        let mut by_view: Vec<Vec<Slots>> = views.iter().map(|_| Vec::new()).collect();
        let mut whole: HashSet<usize> = uses.images.iter().copied().chain(0..scene.fixed.views).collect();
        whole.extend(found.whole);
        for slots in found.slots {
            by_view[slots.view].push(slots);
        }
        let is_used = |view: &usize| !by_view[*view].is_empty() || whole.contains(view);
        whole.extend(overlapping(scene, (0..views.len()).filter(is_used))?);
        let mut out = Vec::with_capacity(views.len());
        for (number, (view, slots)) in views.iter().zip(by_view).enumerate() {
            let has_own = OWN_MEMBERS[1..].iter().any(|name| view.get(name).is_some());
            let is_empty = slots.is_empty();
            let arrays = Some(slots).filter(|_| !whole.contains(&number) && !has_own).and_then(apart);
            out.push(match arrays {
                _ if is_empty && !whole.contains(&number) => Self::Unused,
                Some(arrays) => Self::Apart(arrays),
                None => Self::Whole,
            });
        }
        Ok(Some(out))
    }
}

/// The slots of the used accessors, and the views that must not be split.
#[derive(Default)]
struct FoundSlots {
    slots: Vec<Slots>,
    whole: HashSet<usize>,
}

/// Finds the slots of the used accessors. Returns `None` if one cannot be read.
fn slots(scene: &Packing, uses: &Uses) -> Result<Option<FoundSlots>, Error> {
    let resolver = scene.resolver();
    let mut budget = DecodeBudget::new(ATTRIBUTE_LIMIT, VERTEX_FACTOR, &scene.buffers);
    let mut found = FoundSlots::default();
    for (number, accessor) in array(resolver.root, "accessors")?.iter().enumerate() {
        let Some(kind) = uses.kind(number) else { continue };
        let layout = AccessorLayout::find(&resolver, number, &mut budget);
        if layout.is_err() {
            let value = Value::from(number);
            let reference = Located { value: &value, at: format!("accessors[{number}]") };
            if resolver.values(&reference).is_err() {
                return Ok(None);
            }
        }
        let layout = layout.ok();
        let ranges = layout.map_or([None; 3], |layout| {
            let [indices, values] = layout.sparse.map_or([None; 2], |sparse| sparse.map(Some));
            [layout.base, indices, values]
        });
        let holders = [Holder::Accessor, Holder::SparseIndices, Holder::SparseValues];
        for (holder, range) in holders.into_iter().zip(ranges) {
            let view = holder.of(accessor).and_then(|object| index(object.get("bufferView")?));
            let kind = if holder == Holder::Accessor { kind } else { UseKind::Other };
            match view.zip(range) {
                Some((view, range)) => {
                    found.slots.push(Slots { accessor: number, holder, kind, view, range })
                }
                None => found.whole.extend(view),
            }
        }
    }
    Ok(Some(found))
}

/// Returns the views that overlap another one.
fn overlapping(scene: &Packing, used: impl Iterator<Item = usize>) -> Result<Vec<usize>, Error> {
    let views = array(&scene.document.root, "bufferViews")?;
    let range = |view: usize| Ok((view_range(view, &views[view], &scene.buffers)?, view));
    let mut ranges = used.map(range).collect::<Result<Vec<_>, Error>>()?;
    ranges.sort_unstable_by_key(|((buffer, range), view)| (*buffer, range.start, *view));
    let mut out = Vec::new();
    // The view with the largest end so far.
    let mut furthest: Option<(usize, usize, usize)> = None;
    for ((buffer, range), view) in ranges {
        match furthest.filter(|&(of, end, _)| of == buffer && range.start < end) {
            Some((_, end, other)) => {
                out.extend([other, view]);
                furthest =
                    Some(if range.end > end { (buffer, range.end, view) } else { (buffer, end, other) });
            }
            None => furthest = Some((buffer, range.end, view)),
        }
    }
    Ok(out)
}

/// Splits a view into arrays of one kind. Returns `None` if this is not possible.
fn apart(mut slots: Vec<Slots>) -> Option<Vec<Array>> {
    let kind = slots.first()?.kind;
    if kind == UseKind::Mixed || slots.iter().any(|slots| slots.kind != kind) {
        return None;
    }
    slots.sort_by_key(|slots| slots.range.start);
    let mut arrays: Vec<Array> = Vec::new();
    for slots in slots {
        let span = slots.range.span();
        match arrays.last_mut().filter(|last| span.start < last.span.end) {
            Some(last) => {
                last.span.end = last.span.end.max(span.end);
                last.slots.push(slots);
            }
            None => arrays.push(Array { kind, slots: vec![slots], span }),
        }
    }
    arrays.iter().all(Array::fits).then_some(arrays)
}
