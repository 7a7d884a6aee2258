//! Shortens accessors and removes the bytes of removed values from the buffers.
//!
//! ```text
//! view      ├ positions ──────────┤├ normals ────────────┤├ …   two accessors of one group
//! cut off   ├ positions ─┤░░░░░░░░░├ normals ───┤░░░░░░░░░├ …
//! written   ├ positions ─┤├ normals ───┤├ …
//! ```
//! # Algorithm
//! 1. The count of each accessor of a group is updated. For sparse accessors, the number of sparse
//!    values is also updated. The remaining values are already first.
//! 2. Minimum and maximum are recomputed for positions, where glTF requires them, and for other
//!    accessors that had them.
//! 3. The bytes of removed values are deleted unless other data uses them: another accessor, an
//!    image, a view without an accessor, or a view that an extension or extras may refer to. Bytes
//!    are deleted in multiples of 8, so the remaining bytes keep their alignment. Interleaved
//!    accessors have the same count, so whole rows are deleted.
//! 4. Views move and become shorter; accessor offsets are adjusted to match. No accessor or view is
//!    removed, because anything may refer to them by index.
//!
//! # Complexity
//! Linear in the bytes of the buffers and of the accessors, with the limits for decoded values; n
//! log n in the number of accessors and views.

use std::collections::BTreeSet;
use std::ops::Range;

use crate::edit::vertex_group::Renumbering;
use crate::error::Error;
use crate::gltf::document::accessor::AccessorResolver;
use crate::gltf::document::bounds::bounds;
use crate::gltf::document::budget::{ATTRIBUTE_LIMIT, DecodeBudget};
use crate::gltf::document::buffer::view_range;
use crate::gltf::document::byte_ranges::RemovedBytes;
use crate::gltf::document::byte_ranges::SharedBytes;
use crate::gltf::document::json::{Members, Value};
use crate::gltf::document::references::{ExtensionNumbers, position_accessors, views_of_accessor};
use crate::gltf::document::scene::Scene;
use crate::gltf::document::{Located, array, entries_mut, index};
use crate::gltf::edit::permute::{AccessorLayout, PermutedBuffers, VERTEX_FACTOR};

/// The accessors of groups that lose vertices.
#[derive(Default)]
pub(in crate::gltf) struct Shrink {
    cuts: Vec<Cut>,
    /// Accessors whose values change; their bounds may change too.
    changed: BTreeSet<usize>,
    /// The range of each buffer that held values of removed vertices.
    freed: Vec<(usize, Range<usize>)>,
}

/// An accessor with fewer values.
struct Cut {
    accessor: usize,
    count: usize,
    /// The number of remaining sparse values, for a sparse accessor.
    sparse: Option<usize>,
}

impl Shrink {
    /// Adds the accessors of a group whose values were permuted.
    pub(in crate::gltf) fn add(
        &mut self,
        arrays: &[AccessorLayout],
        renumbering: &Renumbering,
        permuted: &PermutedBuffers<'_>,
    ) {
        for array in arrays {
            self.changed.insert(array.accessor);
            if array.holds_indices {
                continue;
            }
            let sparse = array.sparse.map(|slots| (slots, permuted.sparse_left(array, renumbering)));
            self.freed.extend(array.base.map(|base| (base.buffer, base.tail(renumbering.left))));
            for (slots, left) in sparse.iter().flat_map(|&(slots, left)| slots.map(|slots| (slots, left))) {
                self.freed.push((slots.buffer, slots.tail(left)));
            }
            let sparse = sparse.map(|(_, left)| left);
            self.cuts.push(Cut { accessor: array.accessor, count: renumbering.left, sparse });
        }
    }

    /// Adds an accessor with new values.
    pub(in crate::gltf) fn change(&mut self, accessor: usize) {
        self.changed.insert(accessor);
    }

    /// Adds the old bytes of an accessor whose values were moved.
    pub(in crate::gltf) fn free(&mut self, layout: &AccessorLayout) {
        self.freed.extend(layout.slots().map(|slots| (slots.buffer, slots.span())));
    }

    /// Returns the scene with shortened accessors and without unused bytes.
    pub(in crate::gltf) fn apply(self, mut scene: Scene) -> Result<Scene, Error> {
        if self.cuts.is_empty() && self.freed.is_empty() && self.changed.is_empty() {
            return Ok(scene);
        }
        self.cut_accessors(&mut scene.document.root)?;
        self.update_bounds(&mut scene)?;
        let removed = self.plan_removal(&scene)?;
        move_views(&mut scene, &removed)?;
        scene.buffers = (scene.buffers.iter().zip(&removed))
            .map(|(bytes, removed)| match removed.total() {
                0 => bytes.clone(),
                _ => removed.slices(bytes.as_slice()).collect::<Vec<_>>().concat().into(),
            })
            .collect();
        Ok(scene)
    }

    fn cut_accessors(&self, root: &mut Members) -> Result<(), Error> {
        let accessors = entries_mut(root, "accessors")?;
        for cut in &self.cuts {
            let Some(accessor) = accessors.get_mut(cut.accessor).and_then(Value::as_object_mut) else {
                continue;
            };
            accessor.insert("count", cut.count);
            match cut.sparse {
                None => {}
                // A sparse accessor must have at least one sparse value.
                Some(0) => accessor.remove("sparse"),
                Some(count) => {
                    let sparse = accessor.get_mut("sparse").and_then(Value::as_object_mut);
                    sparse.into_iter().for_each(|sparse| sparse.insert("count", count));
                }
            }
        }
        Ok(())
    }

    /// Computes the bounds of the accessors whose values changed.
    fn update_bounds(&self, scene: &mut Scene) -> Result<(), Error> {
        let root = &scene.document.root;
        let positions = position_accessors(root)?;
        let resolver = AccessorResolver { root, buffers: &scene.buffers };
        let mut found = Vec::new();
        for &accessor in &self.changed {
            let Some(old) = array(root, "accessors")?.get(accessor) else { continue };
            if positions.contains(&accessor) || old.get("min").is_some() || old.get("max").is_some() {
                let number = Value::from(accessor);
                let reference = Located { value: &number, at: format!("accessors[{accessor}]") };
                found.push((accessor, bounds(&resolver.values(&reference)?)?));
            }
        }
        let accessors = entries_mut(&mut scene.document.root, "accessors")?;
        for (accessor, bounds) in found {
            let Some(members) = accessors.get_mut(accessor).and_then(Value::as_object_mut) else { continue };
            match bounds {
                Some([lowest, highest]) => {
                    members.insert("min", lowest);
                    members.insert("max", highest);
                }
                // JSON cannot represent values that are not finite.
                None => ["min", "max"].into_iter().for_each(|name| members.remove(name)),
            }
        }
        Ok(())
    }

    /// Plans which bytes are removed from each buffer.
    fn plan_removal(self, scene: &Scene) -> Result<Vec<RemovedBytes>, Error> {
        let (root, buffers) = (&scene.document.root, &scene.buffers);
        let resolver = AccessorResolver { root, buffers };
        let mut budget = DecodeBudget::new(ATTRIBUTE_LIMIT, VERTEX_FACTOR, buffers);
        let mut kept: Vec<Vec<Range<usize>>> = vec![Vec::new(); buffers.len()];
        // 1. Values of accessors. If an accessor cannot be decoded, its views are kept completely.
        let mut whole = ExtensionNumbers::of(root).numbers;
        for accessor in 0..array(root, "accessors")?.len() {
            match AccessorLayout::find(&resolver, accessor, &mut budget) {
                Ok(layout) => layout.slots().for_each(|slots| kept[slots.buffer].push(slots.span())),
                Err(_) => whole.extend(views_of_accessor(root, accessor)),
            }
        }
        // 2. Views that hold more than values of accessors.
        let images = array(root, "images")?.iter();
        whole.extend(images.filter_map(|image| index(image.get("bufferView")?)));
        for (v, view) in array(root, "bufferViews")?.iter().enumerate() {
            let (buffer, range) = view_range(v, view, buffers)?;
            let is_whole = whole.contains(&v) || view.get("extensions").is_some();
            // A view must have at least one byte, even if no accessor uses it.
            let is_empty = range.is_empty();
            let end = if is_whole || is_empty { range.end } else { range.start + 1 };
            kept[buffer].push(range.start..end);
        }
        let mut freed: Vec<Vec<Range<usize>>> = vec![Vec::new(); buffers.len()];
        self.freed.into_iter().for_each(|(buffer, range)| freed[buffer].push(range));
        Ok(freed.into_iter().zip(kept).map(|(freed, kept)| RemovedBytes::plan(freed, kept)).collect())
    }
}

/// Moves views and accessors to the new offsets of the remaining bytes.
fn move_views(scene: &mut Scene, removed: &[RemovedBytes]) -> Result<(), Error> {
    let (root, buffers) = (&mut scene.document.root, &scene.buffers);
    let views = array(root, "bufferViews")?.iter().enumerate();
    let old = views.map(|(v, view)| view_range(v, view, buffers)).collect::<Result<Vec<_>, Error>>()?;
    for (view, (buffer, range)) in entries_mut(root, "bufferViews")?.iter_mut().zip(&old) {
        let [start, end] = [range.start, range.end].map(|offset| removed[*buffer].moved(offset));
        set(view, "byteOffset", range.start, start);
        set(view, "byteLength", range.len(), end - start);
    }
    // The old and new offset of values within their view.
    let moved = |holder: &Value| {
        let (buffer, range) = old.get(index(holder.get("bufferView")?)?)?;
        let offset = holder.get("byteOffset").and_then(index).unwrap_or(0);
        let [start, at] = (offset <= range.len()).then_some([range.start, range.start + offset])?;
        Some((offset, removed[*buffer].moved(at) - removed[*buffer].moved(start)))
    };
    let update = |holder: &mut Value| {
        if let Some((old, new)) = moved(holder) {
            set(holder, "byteOffset", old, new);
        }
    };
    for accessor in entries_mut(root, "accessors")? {
        update(accessor);
        let moves = |part: &Value| moved(part).is_some_and(|(old, new)| old != new);
        for part in ["indices", "values"] {
            if !accessor.get("sparse").and_then(|sparse| sparse.get(part)).is_some_and(moves) {
                continue;
            }
            let sparse = accessor.as_object_mut().and_then(|accessor| accessor.get_mut("sparse"));
            let part = sparse.and_then(|sparse| sparse.as_object_mut()?.get_mut(part));
            part.into_iter().for_each(update);
        }
    }
    for (buffer, (bytes, removed)) in
        entries_mut(root, "buffers")?.iter_mut().zip(buffers.iter().map(SharedBytes::len).zip(removed))
    {
        set(buffer, "byteLength", bytes, bytes - removed.total());
    }
    Ok(())
}

/// Sets a member if its value changes.
fn set(object: &mut Value, name: &str, old: usize, new: usize) {
    if let Some(members) = Some(object).filter(|_| old != new).and_then(Value::as_object_mut) {
        members.insert(name, new);
    }
}
