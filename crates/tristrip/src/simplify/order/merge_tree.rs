//! Merge trees: collapses in independent sets, for vertex hierarchies of small height.
//!
//! Cheapest-first simplification collapses one region many times before it reaches the next. Each
//! of these collapses depends on the ones before it. Here, each level of the tree is a set of
//! collapses that do not touch each other. None of them depends on another collapse of its level,
//! and the tree has about log(n) levels.
//!
//! ```text
//! level 2          a               A kept vertex is promoted to the next level,
//!                ╱   ╲             as is a vertex that takes part in no collapse.
//! level 1      a       c
//!            ╱   ╲   ╱   ╲
//! level 0   a     b c     d
//! ```
//! # Algorithm
//! For each level:
//! 1. Price the best collapse of each vertex, unless nothing has changed around it since it was
//!    last priced.
//! 2. Take collapses in the order of their prices: the edge length, as published, or the quadric at
//!    the kept vertex. A collapse is taken if neither of its vertices shares a triangle with a
//!    vertex of an edge that has been taken at this level. The neighbourhoods of taken collapses
//!    then have no triangle in common. A vertex whose best target is blocked collapses to the best
//!    of its other targets, which makes the set maximal.
//! 3. In the quadric order, only collapses up to a limit are taken. The limit is chosen so that a
//!    quarter of the vertices are below it. A maximal set without a limit would remove feature
//!    vertices early, and every refinement that depends on them would have a large error.
//!
//! The rules of the module `decimate` apply. In addition, no triangle may turn by more than 78
//! degrees from its direction in the full mesh. A triangle that already exceeds this angle may not
//! turn any farther. The reference direction is a sum of full-mesh normals, weighted by area, at
//! the vertices that one corner of the triangle represents. This rule applies to the triangles of
//! the removed vertex. It also applies to the triangles of the kept vertex, because that vertex
//! represents more vertices afterwards. Without this rule, triangles fold over step by step.
//! `decimate/merge_levels.rs` builds the levels.
//!
//! # Departures
//! Collapses are half-edge collapses. The quadric order is not published.
//!
//! # References
//! Xia, El-Sana, Varshney: *Adaptive Real-Time Level-of-Detail-Based Rendering for Polygonal
//! Models*, 1997. El-Sana, Evans, Kalaiah, Varshney, Skiena, Azanli: *Efficiently Computing and
//! Updating Triangle Strips for Real-Time Rendering*, 2000, section 4.2.
//!
//! # Complexity
//! O(n log n) time: each level removes a constant share of the vertices. 110 bytes per triangle
//! during construction.

use super::decimate::Decimation;
use super::stopped::Stopped;
use crate::collapse::CollapseSequence;
use crate::error::Error;
use crate::mesh::{Mesh, attribute_bits};
use crate::names::names;
use crate::simplify::options::{Price, SimplifyOptions};
use crate::simplify::price::attributes::PricedAttributes;

/// The order in which the collapses of a level are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum MergeOrder {
    /// The smallest quadric error at the kept vertex first, up to a limit per level.
    #[default]
    Quadric,
    /// The shortest edge first, as published.
    ShortestEdge,
}

names! {
    "tristrip::simplify::MergeOrder", MergeOrder, "merge order",
    Quadric => "quadric", "Smallest quadric error first, up to a limit per level";
    ShortestEdge => "shortest-edge", "Shortest edge first (Xia et al. 1997)";
}

/// The minimum distance between collapses of the same level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Spacing {
    /// No triangle has vertices of two collapses: each can be applied alone.
    Disjoint,
    /// No triangle has two removed vertices, and irregular points are kept.
    Apart,
}

/// The collapses of a merge tree.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct MergeTree {
    /// The collapses, level by level, starting from the full mesh.
    pub sequence: CollapseSequence,
    /// For each level of the tree, the number of collapses up to its end, counted from the full
    /// mesh.
    pub level_ends: Vec<u32>,
    /// Why the base mesh has more triangles than requested; `None` if the target was reached.
    pub stopped: Option<Stopped>,
}

/// Builds the merge tree of triangles over the vertices of a mesh. The limits and weights of the
/// options apply; their price is ignored.
///
/// # Errors
/// The number of indices is not a multiple of three; an index is out of range; there are more than
/// 2²⁷ triangles; an option is invalid.
///
/// ```
#[doc = include_str!("../example.txt")]
/// use tristrip::simplify::{MergeOrder, merge_tree};
/// let triangles = grid.faces().corners().to_vec();
/// let tree = merge_tree(&grid, triangles, MergeOrder::Quadric, &SimplifyOptions::default())?;
/// assert_eq!(tree.level_ends.last().copied(), Some(tree.sequence.len() as u32));
/// // The grid has 81 vertices.
/// assert!(tree.level_ends.len() < 30);
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn merge_tree(
    mesh: &Mesh,
    triangles: Vec<u32>,
    order: MergeOrder,
    options: &SimplifyOptions,
) -> Result<MergeTree, Error> {
    levels(mesh, triangles, (order, Spacing::Disjoint), options)
}

/// Collapses triangles over the vertices of a mesh in batches for a [stream](crate::stream). No two
/// vertices removed by a batch share a triangle. A batch removes as many of the cheaper vertices as
/// this allows; [`SimplifyOptions::with_error_factors`] weights their errors. Batches are fewer and
/// larger than the levels of a [merge tree](merge_tree), because several collapses of a batch may
/// share their kept vertex. Non-manifold points are kept.
///
/// # Errors
/// The number of indices is not a multiple of three; an index is out of range; there are more than
/// 2²⁷ triangles; an option is invalid.
///
/// ```
#[doc = include_str!("../example.txt")]
/// use tristrip::simplify::{MergeOrder, merge_tree, refinement_batches};
/// let triangles = || grid.faces().corners().to_vec();
/// let options = SimplifyOptions::default();
/// let [batches, tree] =
///     [refinement_batches(&grid, triangles(), &options)?, merge_tree(&grid, triangles(), MergeOrder::Quadric, &options)?];
/// assert!(batches.level_ends.len() < tree.level_ends.len());
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn refinement_batches(
    mesh: &Mesh,
    triangles: Vec<u32>,
    options: &SimplifyOptions,
) -> Result<MergeTree, Error> {
    levels(mesh, triangles, (MergeOrder::Quadric, Spacing::Apart), options)
}

fn levels(
    mesh: &Mesh,
    triangles: Vec<u32>,
    levels: (MergeOrder, Spacing),
    options: &SimplifyOptions,
) -> Result<MergeTree, Error> {
    options.check(mesh.vertex_count(), triangles.len())?;
    let options = options.clone().with_price(Price::Planes);
    let mut sequence = CollapseSequence::new(mesh.vertex_count(), triangles)?;
    let bits = |v| attribute_bits(mesh, v as usize);
    let priced = |triangles: &[u32], unit| PricedAttributes::new(mesh, triangles, unit, options.weights);
    let mut decimation = Decimation::new(mesh.positions(), bits, sequence.triangles(), priced, &options, &[]);
    let level_ends =
        decimation.run_levels(levels, &options.error_factors, options.triangle_count, &mut sequence);
    let is_reached = sequence.triangle_count(0)? <= options.triangle_count;
    let stopped = (!is_reached).then(|| decimation.stopped());
    Ok(MergeTree { sequence, level_ends, stopped })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Faces;
    use crate::simplify::tests::grid;
    use crate::vector::{Point, dot, normal_of};

    /// Returns the number of triangles that face away from the sum of the full mesh's normals at
    /// one of their corners.
    fn turned(positions: &[[f32; 3]], triangles: &[[u32; 3]], sums: &[Point]) -> usize {
        let faces_away = |triangle: &&[u32; 3]| {
            let normal = normal_of(triangle.map(|v| positions[v as usize].map(f64::from)));
            triangle.iter().any(|&v| dot(normal, sums[v as usize]) < 0.0)
        };
        triangles.iter().filter(faces_away).count()
    }

    #[test]
    fn no_level_turns_triangles_over() {
        for (order, flatness) in
            [(MergeOrder::Quadric, 0.03), (MergeOrder::ShortestEdge, 0.03), (MergeOrder::Quadric, 1.0)]
        {
            // A ring whose upper and lower sides nearly touch. Thin shapes fold over most easily.
            let (mut positions, triangles) = grid(40, 16, [true, true]);
            positions.iter_mut().for_each(|p| p[2] *= flatness);
            let mesh =
                Mesh::new(positions.clone(), Faces::from_triangles(triangles.clone()).unwrap()).unwrap();
            let tree = merge_tree(&mesh, triangles, order, &SimplifyOptions::default()).unwrap();
            let sequence = &tree.sequence;
            let mut sums = vec![[0.0; 3]; positions.len()];
            let add = |sums: &mut [Point], v: u32, more: Point| {
                let sum = &mut sums[v as usize];
                *sum = [0, 1, 2].map(|k| sum[k] + more[k]);
            };
            let full = sequence.drawn(sequence.len()).unwrap();
            for triangle in &full {
                let normal = normal_of(triangle.map(|v| positions[v as usize].map(f64::from)));
                triangle.iter().for_each(|&v| add(&mut sums, v, normal));
            }
            let mut least = turned(&positions, &full, &sums);
            for (level, collapse) in (0..sequence.len()).rev().zip(sequence.iter()) {
                for rename in collapse.renames {
                    let sum = sums[rename.removed as usize];
                    add(&mut sums, rename.kept, sum);
                }
                let found = turned(&positions, &sequence.drawn(level).unwrap(), &sums);
                assert!(found <= least, "{order}, level {level}: {found} of {least}");
                least = found;
            }
            assert!(sequence.len() > 400, "{}", sequence.len());
        }
    }
}
