//! The bytes of the new buffer, and the buffer views over them.

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;

use indexmap::IndexSet;
use serde_json::json;

use super::super::packing::Packing;
use super::arrays::{Array, Holder, ViewArrays};
use super::uses::UseKind;
use crate::error::Error;
use crate::gltf::document::buffer::view_range;
use crate::gltf::document::byte_ranges;
use crate::gltf::document::json::{Members, Value};
use crate::gltf::document::spec::{ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER};
use crate::gltf::document::{array, index};

/// The alignment of arrays.
const ALIGNMENT: usize = 4;

/// The kind of the arrays in a common view, and the stride of vertex attributes.
type Class = (UseKind, Option<usize>);

/// The new buffer.
pub(super) struct BufferLayout {
    pub(super) bytes: Vec<u8>,
    pub(super) views: Vec<Value>,
    /// The new indices of the views that stay whole.
    pub(super) view_numbers: Vec<Option<usize>>,
    /// The view and offset of moved values.
    places: HashMap<(usize, Holder), (usize, usize)>,
}

impl BufferLayout {
    /// Lays out all views.
    pub(super) fn of(scene: &Packing, views: &[ViewArrays]) -> Result<Self, Error> {
        let old = array(&scene.document.root, "bufferViews")?;
        let mut layout = Self {
            bytes: Vec::new(),
            views: old[..scene.fixed.views].to_vec(),
            view_numbers: vec![None; old.len()],
            places: HashMap::new(),
        };
        layout.add_arrays(scene, views);
        layout.add_whole_views(scene, views)?;
        Ok(layout)
    }

    /// Writes the arrays of split views, and one view per class.
    fn add_arrays(&mut self, scene: &Packing, views: &[ViewArrays]) {
        let mut classes: BTreeMap<Class, IndexSet<Vec<u8>>> = BTreeMap::new();
        let mut placed = Vec::new();
        let arrays = views
            .iter()
            .filter_map(|view| if let ViewArrays::Apart(arrays) = view { Some(arrays) } else { None });
        for array in arrays.flatten() {
            let (class, start, bytes) = bytes_of(array, scene);
            let (number, _) = classes.entry(class).or_default().insert_full(bytes);
            placed.extend(array.slots.iter().map(|slots| (slots, class, number, slots.range.start - start)));
        }
        let mut starts: BTreeMap<Class, (usize, Vec<usize>)> = BTreeMap::new();
        for ((kind, stride), arrays) in classes {
            let start = self.align(ALIGNMENT, 0);
            let mut offsets = Vec::with_capacity(arrays.len());
            for bytes in arrays {
                offsets.push(self.align(ALIGNMENT, 0) - start);
                self.bytes.extend_from_slice(&bytes);
            }
            starts.insert((kind, stride), (self.views.len(), offsets));
            let mut view =
                json!({ "buffer": 0, "byteOffset": start, "byteLength": self.bytes.len() - start });
            if let Some(stride) = stride {
                view["byteStride"] = stride.into();
            }
            match kind {
                UseKind::Attribute => view["target"] = ARRAY_BUFFER.into(),
                UseKind::Indices => view["target"] = ELEMENT_ARRAY_BUFFER.into(),
                UseKind::Matrices | UseKind::Other | UseKind::Mixed => {}
            }
            self.views.push(without_zero_offset(view.into()));
        }
        for (slots, class, number, within) in placed {
            if let Some((view, offset)) =
                starts.get(&class).and_then(|(view, offsets)| Some((*view, *offsets.get(number)?)))
            {
                self.places.insert((slots.accessor, slots.holder), (view, offset + within));
            }
        }
    }

    /// Writes the other views; overlapping ones as one range.
    fn add_whole_views(&mut self, scene: &Packing, views: &[ViewArrays]) -> Result<(), Error> {
        let old = array(&scene.document.root, "bufferViews")?;
        let mut whole = Vec::new();
        for (number, _) in views.iter().enumerate().filter(|(_, view)| matches!(view, ViewArrays::Whole)) {
            let (buffer, range) = view_range(number, &old[number], &scene.buffers)?;
            whole.push((buffer, range, number));
        }
        whole.sort_unstable_by_key(|(buffer, range, number)| (*buffer, range.start, *number));
        let mut ranges: Vec<(usize, Range<usize>)> = Vec::new();
        for (buffer, range, _) in &whole {
            match ranges.last_mut().filter(|(of, last)| of == buffer && range.start < last.end) {
                Some((_, last)) => last.end = last.end.max(range.end),
                None => ranges.push((*buffer, range.clone())),
            }
        }
        let mut moved = Vec::with_capacity(ranges.len());
        for (buffer, range) in &ranges {
            // The largest alignment that a known extension requires.
            let alignment = byte_ranges::ALIGNMENT;
            moved.push(self.align(alignment, range.start % alignment));
            self.bytes.extend_from_slice(&scene.buffers[*buffer].as_slice()[range.clone()]);
        }
        // In the order of their indices.
        whole.sort_unstable_by_key(|&(_, _, number)| number);
        for (buffer, range, number) in whole {
            let holder = ranges.partition_point(|(of, one)| (*of, one.start) <= (buffer, range.start)) - 1;
            let mut view = old[number].clone();
            if let Some(members) = view.as_object_mut() {
                members.insert("buffer", 0_usize);
                members.insert("byteOffset", moved[holder] + range.start - ranges[holder].1.start);
            }
            let view = without_zero_offset(view);
            let new = if number < scene.fixed.views { number } else { self.views.len() };
            match self.views.get_mut(new) {
                Some(fixed) => *fixed = view,
                None => self.views.push(view),
            }
            self.view_numbers[number] = Some(new);
        }
        Ok(())
    }

    /// Appends zeros up to the next offset with the given remainder modulo `alignment`, and returns
    /// the offset.
    fn align(&mut self, alignment: usize, remainder: usize) -> usize {
        let missing = (remainder + alignment - self.bytes.len() % alignment) % alignment;
        self.bytes.resize(self.bytes.len() + missing, 0);
        self.bytes.len()
    }

    /// Returns an accessor with the new view and offset of its values.
    pub(super) fn moved(&self, number: usize, accessor: &Value) -> Value {
        let mut moved = accessor.clone();
        let Some(members) = moved.as_object_mut() else { return moved };
        self.move_holder((number, Holder::Accessor), members);
        if members.contains_key("sparse") {
            let mut parts = members.get_mut("sparse").and_then(Value::as_object_mut);
            for (name, holder) in [("indices", Holder::SparseIndices), ("values", Holder::SparseValues)] {
                let part = parts.as_mut().and_then(|parts| parts.get_mut(name)?.as_object_mut());
                part.into_iter().for_each(|part| self.move_holder((number, holder), part));
            }
        }
        moved
    }

    fn move_holder(&self, holder: (usize, Holder), members: &mut Members) {
        if let Some(&(view, offset)) = self.places.get(&holder) {
            members.insert("bufferView", view);
            members.remove("byteOffset");
            if offset > 0 {
                members.insert("byteOffset", offset);
            }
        } else if let Some(new) =
            members.get("bufferView").and_then(index).and_then(|view| *self.view_numbers.get(view)?)
        {
            members.insert("bufferView", new);
        }
    }
}

/// Returns the class and the bytes of an array, and the offset in the old buffer where they begin.
fn bytes_of(array: &Array, scene: &Packing) -> (Class, usize, Vec<u8>) {
    let buffer = array.slots.first().map_or(0, |slots| slots.range.buffer);
    let old = scene.buffers[buffer].as_slice();
    let Some(single) = array.single() else {
        // The values keep their alignment.
        let start = array.span.start / ALIGNMENT * ALIGNMENT;
        let stride =
            array.slots.first().map(|slots| slots.range.stride).filter(|_| array.kind == UseKind::Attribute);
        return ((array.kind, stride), start, old[start..array.span.end].to_vec());
    };
    let stride = match array.kind {
        UseKind::Attribute => single.element.next_multiple_of(ALIGNMENT),
        _ => single.element,
    };
    let mut bytes = Vec::with_capacity(array.span.len());
    for value in single.ranges() {
        bytes.extend_from_slice(&old[value]);
        bytes.resize(bytes.len().next_multiple_of(stride), 0);
    }
    ((array.kind, Some(stride).filter(|_| array.kind == UseKind::Attribute)), single.start, bytes)
}

/// Removes a zero `byteOffset`, which is the default.
fn without_zero_offset(mut view: Value) -> Value {
    if view.get("byteOffset").and_then(index) == Some(0) {
        view.as_object_mut().into_iter().for_each(|members| members.remove("byteOffset"));
    }
    view
}
