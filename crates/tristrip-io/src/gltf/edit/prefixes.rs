//! Builds accessors over the first values of other accessors, for the vertices of a lower level of
//! detail.
//!
//! ```text
//! view        ├ positions ───────────────┤├ normals ─────────────────┤
//! full mesh   ├──────────────────────────┤├──────────────────────────┤
//! a level     ├──────────┤                ├──────────┤           same views and offsets
//! ```
//! A view that several accessors use must declare its stride. If a view has no stride, the size of
//! its values becomes its stride. This requires that the view holds only vertex data of this size;
//! otherwise the level uses all vertices of the primitive.
//!
//! # Complexity
//! Linear in the values of the new accessors. Their bounds are computed within the limit for
//! decoded values.

use std::collections::{BTreeMap, HashMap, HashSet};

use crate::error::Error;
use crate::gltf::document::accessor::{AccessorResolver, AccessorValues};
use crate::gltf::document::bounds::bounds;
use crate::gltf::document::budget::{ATTRIBUTE_LIMIT, DecodeBudget};
use crate::gltf::document::json::{Members, Value};
use crate::gltf::document::references::{position_accessors, views_of_accessor};
use crate::gltf::document::scene::Scene;
use crate::gltf::document::{Located, array, index, items, list_mut};
use crate::gltf::edit::permute::VERTEX_FACTOR;
use crate::gltf::edit::renumber::vertex_accessors;

/// The strides that the specification allows for vertex data.
const STRIDES: std::ops::RangeInclusive<usize> = 4..=252;

/// New accessors over the first values of a document's accessors, not yet added to it.
pub(in crate::gltf) struct Prefixes<'a> {
    resolver: AccessorResolver<'a>,
    budget: DecodeBudget,
    /// The value size of each view that has no stride and may get one.
    sizes: HashMap<usize, usize>,
    positions: HashSet<usize>,
    /// The new accessors by old accessor and number of values.
    made: HashMap<(usize, usize), usize>,
    new: PrefixAccessors,
}

/// Accessors and strides to be added to a document.
#[derive(Default)]
pub(in crate::gltf) struct PrefixAccessors {
    accessors: Vec<Value>,
    strides: BTreeMap<usize, usize>,
}

impl<'a> Prefixes<'a> {
    pub(in crate::gltf) fn new(scene: &'a Scene) -> Result<Self, Error> {
        let root = &scene.document.root;
        let resolver = AccessorResolver { root, buffers: &scene.buffers };
        Ok(Self {
            budget: DecodeBudget::new(ATTRIBUTE_LIMIT, VERTEX_FACTOR, &scene.buffers),
            sizes: sizes_of_views(&resolver)?,
            positions: position_accessors(root)?,
            made: HashMap::new(),
            new: PrefixAccessors::default(),
            resolver,
        })
    }

    /// Returns the prefix accessor for each vertex accessor of a primitive. Empty if the accessors
    /// are unchanged.
    pub(in crate::gltf) fn of_primitive(
        &mut self,
        primitive: &Value,
        count: usize,
    ) -> Result<HashMap<usize, usize>, Error> {
        let all: HashSet<usize> = vertex_accessors(primitive).collect();
        let mut cut = Vec::new();
        for &accessor in &all {
            let values = self.values(accessor)?;
            if values.count > count {
                cut.push(accessor);
            }
            let is_known = self.made.contains_key(&(accessor, count));
            if !is_known && !self.budget.try_charge(count, values.element) || !self.has_stride(accessor)? {
                return Ok(HashMap::new());
            }
        }
        cut.sort_unstable();
        cut.into_iter().map(|accessor| Ok((accessor, self.prefix(accessor, count)?))).collect()
    }

    /// Returns the new accessors.
    pub(in crate::gltf) fn finish(self) -> PrefixAccessors {
        self.new
    }

    fn values(&self, accessor: usize) -> Result<AccessorValues<'a>, Error> {
        self.resolver.values_of(Located::entry(self.resolver.root, "accessors", accessor)?)
    }

    /// Checks whether the view of an accessor has a stride or can get one.
    fn has_stride(&self, accessor: usize) -> Result<bool, Error> {
        let object = array(self.resolver.root, "accessors")?.get(accessor);
        let Some(view) = object.and_then(|object| index(object.get("bufferView")?)) else { return Ok(true) };
        let stated = array(self.resolver.root, "bufferViews")?.get(view).and_then(|v| v.get("byteStride"));
        Ok(stated.is_some() || self.sizes.contains_key(&view))
    }

    /// Returns the accessor over the first `count` values of another.
    fn prefix(&mut self, accessor: usize, count: usize) -> Result<usize, Error> {
        if let Some(&known) = self.made.get(&(accessor, count)) {
            return Ok(known);
        }
        let accessors = array(self.resolver.root, "accessors")?;
        let number = accessors.len() + self.new.accessors.len();
        let mut new = accessors[accessor].clone();
        let values = self.values(accessor)?.first(count)?;
        let has_bounds = new.get("min").is_some() || new.get("max").is_some();
        let bounds = if has_bounds || self.positions.contains(&accessor) { bounds(&values)? } else { None };
        if let Some(members) = new.as_object_mut() {
            members.insert("count", values.count);
            match (values.sparse_count(), members.get_mut("sparse").and_then(Value::as_object_mut)) {
                // A sparse accessor must have at least one sparse value.
                (0, _) => members.remove("sparse"),
                (left, Some(sparse)) => sparse.insert("count", left),
                (_, None) => {}
            }
            ["min", "max"].into_iter().for_each(|name| members.remove(name));
            for (name, bound) in ["min", "max"].into_iter().zip(bounds.into_iter().flatten()) {
                members.insert(name, bound);
            }
            if let Some(view) = members.get("bufferView").and_then(index) {
                self.new.strides.extend(self.sizes.get(&view).map(|&size| (view, size)));
            }
        }
        self.new.accessors.push(new);
        self.made.insert((accessor, count), number);
        Ok(number)
    }
}

impl PrefixAccessors {
    /// Adds the accessors and strides to the document for which they were built.
    pub(in crate::gltf) fn apply(self, root: &mut Members) -> Result<(), Error> {
        if self.accessors.is_empty() {
            return Ok(());
        }
        list_mut(root, "accessors")?.extend(self.accessors);
        for (view, stride) in self.strides {
            let view = list_mut(root, "bufferViews")?.get_mut(view).and_then(Value::as_object_mut);
            view.into_iter().for_each(|view| view.insert("byteStride", stride));
        }
        Ok(())
    }
}

/// Returns the value size of each view that has no stride and can get one, because it holds only
/// vertex data of one size.
fn sizes_of_views(resolver: &AccessorResolver<'_>) -> Result<HashMap<usize, usize>, Error> {
    let root = resolver.root;
    let primitives = array(root, "meshes")?.iter().flat_map(|mesh| items(mesh, "primitives"));
    let of_vertices: HashSet<usize> = primitives.flat_map(vertex_accessors).collect();
    let mut sizes: HashMap<usize, usize> = HashMap::new();
    let images = array(root, "images")?.iter().filter_map(|image| index(image.get("bufferView")?));
    let mut others: HashSet<usize> = images.collect();
    for (a, accessor) in Located::entries(root, "accessors")?.enumerate() {
        let view = accessor.value.get("bufferView").and_then(index);
        others
            .extend(views_of_accessor(root, a).filter(|&one| Some(one) != view || !of_vertices.contains(&a)));
        let Some(view) = view.filter(|_| of_vertices.contains(&a)) else { continue };
        let size = resolver.values_of(accessor)?.element;
        if *sizes.entry(view).or_insert(size) != size {
            others.insert(view);
        }
    }
    sizes.retain(|view, size| STRIDES.contains(size) && size.is_multiple_of(4) && !others.contains(view));
    Ok(sizes)
}
