//! Vertices of a scene that are equal in all values stored in the file.
//!
//! # Algorithm
//! All vertices of a group start in one class. Each accessor of the group then splits the classes:
//! two vertices stay in the same class if their values have the same bytes. Vertices still in one
//! class at the end are interchangeable, including morph targets, joints and weights.
//!
//! # Complexity
//! Linear in the bytes of the accessors, up to the limit for decoded attributes. Groups beyond the
//! limit are treated as having no equal vertices.

use std::collections::HashMap;
use std::sync::Arc;

use crate::error::Error;
use crate::gltf::document::Located;
use crate::gltf::document::accessor::AccessorResolver;
use crate::gltf::document::budget::{ATTRIBUTE_LIMIT, DecodeBudget};
use crate::gltf::document::json::Value;
use crate::gltf::document::scene::Scene;
use crate::gltf::edit::permute::{AccessorLayout, VERTEX_FACTOR};
use crate::gltf::edit::renumber::{SceneGroup, groups};

/// Returns for each part the first equal vertex of each vertex. `None` if the vertices cannot
/// change or are all different.
pub(crate) fn first_equal(
    scene: &Scene,
    vertex_counts: &[usize],
) -> Result<Vec<Option<Arc<Vec<u32>>>>, Error> {
    let resolver = AccessorResolver { root: &scene.document.root, buffers: &scene.buffers };
    let mut budget = DecodeBudget::new(ATTRIBUTE_LIMIT, VERTEX_FACTOR, &scene.buffers);
    let mut first = vec![None; vertex_counts.len()];
    for group in groups(scene, vertex_counts.len())? {
        let counts = group.parts.iter().map(|&part| vertex_counts[part]);
        let (Some(vertex_count), None) = (counts.clone().max(), group.why_complete()) else { continue };
        if counts.clone().any(|count| count != vertex_count) {
            continue;
        }
        let equal = of_group(&resolver, &group, vertex_count, &mut budget).map(Arc::new);
        group.parts.iter().for_each(|&part| first[part].clone_from(&equal));
    }
    Ok(first)
}

fn of_group(
    resolver: &AccessorResolver<'_>,
    group: &SceneGroup,
    vertex_count: usize,
    budget: &mut DecodeBudget,
) -> Option<Vec<u32>> {
    // `first[v]` is at most `v`: the first vertex of a class represents it.
    let mut first: Vec<u32> = vec![0; vertex_count];
    for &accessor in group.accessors() {
        AccessorLayout::of_vertices(resolver, accessor, vertex_count, budget).ok()?;
        let number = Value::from(accessor);
        let values =
            resolver.values(&Located { value: &number, at: format!("accessors[{accessor}]") }).ok()?;
        if !budget.try_charge(vertex_count, values.element + size_of::<u32>()) {
            return None;
        }
        let raw = values.raw().ok()?;
        let mut known: HashMap<(u32, &[u8]), u32> = HashMap::new();
        for (vertex, (number, value)) in first.iter_mut().zip(raw.chunks_exact(values.element)).enumerate() {
            *number = *known.entry((*number, value)).or_insert(vertex as u32);
        }
        if known.len() == vertex_count {
            return None;
        }
    }
    Some(first)
}
