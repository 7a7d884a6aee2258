//! Small components that may be removed, and the error of their removal.
//!
//! Collapses reduce a component, such as a bolt on an engine, to two or four triangles at best. A
//! component may be removed if both conditions hold:
//! - it is small: half of the diagonal of its bounding box is at most the error limit;
//! - it is near the rest: each of its vertices is within the limit of a component that is not
//!   small. The maximum of these distances is the error of its removal.
//!
//! A plant whose leaves are all small keeps its leaves, because none of them is near a component
//! that stays. Each part keeps at least one component, because files cannot contain empty parts.

use std::collections::BTreeSet;

use tristrip::union_find::UnionFind;
use tristrip::{CollapseSequence, Error, Faces, Mesh, PositionIds};

use crate::surface_change::{MAX_VISITS, Side};

/// A component of the surface of some parts.
#[derive(Debug, Clone, Copy)]
struct Component {
    low: [f64; 3],
    high: [f64; 3],
    /// The error of its removal; infinite if it stays.
    error: f64,
}

impl Component {
    const NONE: Self = Self { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3], error: f64::INFINITY };

    fn add(&mut self, p: [f32; 3]) {
        for (k, x) in p.map(f64::from).into_iter().enumerate() {
            self.low[k] = self.low[k].min(x);
            self.high[k] = self.high[k].max(x);
        }
    }

    fn is_small(&self, limit: f64) -> bool {
        let squares = (0..3).map(|k| (self.high[k] - self.low[k]).powi(2));
        0.5 * squares.sum::<f64>().sqrt() <= limit
    }
}

/// The removable components of parts that are simplified as one surface, over the concatenated
/// vertices of these parts.
#[derive(Debug, Default)]
pub(super) struct Vanishing {
    /// For each vertex, the error of removing its component, in part units; infinite if it stays.
    /// Empty if no component may be removed.
    pub(super) errors: Vec<f32>,
    /// The component of each vertex.
    components: Vec<u32>,
}

impl Vanishing {
    /// Finds the components that may be removed within an error limit.
    pub(super) fn new(parts: &[(&Mesh, &[u32])], limit: f64) -> Result<Self, Error> {
        let is_limit = limit > 0.0 && limit.is_finite();
        if is_limit { find(parts, limit) } else { Ok(Self::default()) }
    }

    /// Counts the removed components, given the collapses of each part.
    pub(super) fn count<'a>(
        &self,
        parts: impl Iterator<Item = &'a CollapseSequence>,
    ) -> Result<usize, Error> {
        if self.errors.is_empty() {
            return Ok(0);
        }
        let may_vanish = self.components.iter().zip(&self.errors).filter(|(_, error)| error.is_finite());
        let mut gone: BTreeSet<u32> = may_vanish.map(|(&component, _)| component).collect();
        let mut first = 0;
        for sequence in parts {
            for &vertex in sequence.drawn(0)?.as_flattened() {
                gone.remove(&self.components[first + vertex as usize]);
            }
            first += sequence.vertex_count();
        }
        Ok(gone.len())
    }
}

fn find(parts: &[(&Mesh, &[u32])], limit: f64) -> Result<Vanishing, Error> {
    // 1. The components, by position.
    let drawn: Vec<Mesh> = parts
        .iter()
        .map(|(mesh, triangles)| mesh.with_faces(Faces::from_triangles(triangles.to_vec())?))
        .collect::<Result<_, _>>()?;
    let mut ids = PositionIds::default();
    let faces = ids.faces(&drawn.iter().collect::<Vec<_>>())?;
    let count = faces.corners().iter().max().map_or(0, |&id| id as usize + 1);
    let mut sets = UnionFind::new(count);
    for triangle in faces.corners().chunks_exact(3) {
        sets.unite(triangle[0], triangle[1]);
        sets.unite(triangle[0], triangle[2]);
    }
    let mut components = vec![Component::NONE; count];
    for id in 0..count as u32 {
        components[sets.find(id) as usize].add(ids.position(id).unwrap_or_default());
    }
    let is_small: Vec<bool> =
        (0..count as u32).map(|id| components[sets.find(id) as usize].is_small(limit)).collect();
    if is_small.iter().all(|&small| small) || !is_small.contains(&true) {
        return Ok(Vanishing::default());
    }
    // 2. The components that stay, in a tree.
    let mut stays = Side::default();
    let mut candidates = vec![false; count];
    let mut corners = faces.corners();
    for &(mesh, triangles) in parts {
        let (own, rest) = corners.split_at(triangles.len());
        corners = rest;
        let triangles = triangles.chunks_exact(3).zip(own.chunks_exact(3));
        let large = triangles.filter(|(_, ids)| !is_small[ids[0] as usize]);
        let large: Vec<u32> = large.flat_map(|(triangle, _)| triangle).copied().collect();
        if large.is_empty() {
            // The part needs all of its components.
            own.iter().for_each(|&id| components[sets.find(id) as usize].error = -1.0);
        }
        stays.add(mesh, &large)?;
        own.iter().filter(|&&id| is_small[id as usize]).for_each(|&id| candidates[id as usize] = true);
    }
    let tree = stays.tree();
    let searches = candidates.iter().filter(|&&candidate| candidate).count() as f64;
    if stays.crowd(&tree) * searches > MAX_VISITS {
        return Ok(Vanishing::default());
    }
    // 3. The maximum distance of each component.
    for id in (0..count as u32).filter(|&id| candidates[id as usize]) {
        let component = &mut components[sets.find(id) as usize];
        if component.error < 0.0 {
            continue;
        }
        let p = ids.position(id).unwrap_or_default().map(f64::from);
        let distance = tree.nearest_neighbor(p).map_or(f64::INFINITY, |facet| facet.nearest(p).0.sqrt());
        component.error =
            if component.error.is_infinite() { distance } else { component.error.max(distance) };
        if distance > limit {
            component.error = -1.0;
        }
    }
    // 4. The errors by vertex.
    let mut found = Vanishing::default();
    let mut corners = faces.corners().iter();
    for (mesh, triangles) in parts {
        let first = found.errors.len();
        let end = first + mesh.vertex_count();
        found.errors.resize(end, f32::INFINITY);
        found.components.resize(end, 0);
        for (&vertex, &id) in triangles.iter().zip(&mut corners) {
            let component = sets.find(id);
            let error = components[component as usize].error;
            found.components[first + vertex as usize] = component;
            if error >= 0.0 {
                found.errors[first + vertex as usize] = error as f32;
            }
        }
    }
    Ok(found)
}
