//! Merge trees: collapses level by level, so that a vertex hierarchy for view-dependent detail is low.
//!
//! Cheapest-first simplification collapses one place many times before it comes to the next, and each of these collapses needs the ones before it. Here
//! each level of the tree is a set of collapses that do not touch each other: none of them needs another one of its level, and the tree has
//! about log(n) levels.
//!
//! ```text
//! level 2          a               A vertex that is kept is promoted to the next level, as is one that takes part in no collapse.
//!                ╱   ╲
//! level 1      a       c
//!            ╱   ╲   ╱   ╲
//! level 0   a     b c     d
//! ```
//! # Algorithm
//! For each level:
//! 1. The best collapse of each vertex is priced, unless nothing has changed around it since it was priced.
//! 2. Collapses are taken in the order of their prices: the edge length, as published, or the quadric at the kept vertex. One is taken if neither of
//!    its vertices has a triangle with a vertex of an edge that this level has taken, so that their neighbourhoods have no triangle in common. A vertex
//!    whose best target has one takes the best of the other targets: the set is maximal.
//! 3. By quadric, only collapses up to a limit count, below which a quarter of the vertices are: a maximal set of all would remove vertices of features early, and
//!    what depends on them could never be drawn without a large error.
//!
//! What is never allowed is as in the module `decimate`. Moreover, no triangle may turn by more than 78 degrees from the full mesh, or farther where it has already: from the
//! sum of the normals, weighted by area, of the full mesh at the vertices that one of its corners stands for. That holds for the triangles of the removed vertex, and for those of
//! the kept one, which then stands for more. Without it triangles fold over step by step. The levels themselves are in `decimate/merge_levels.rs`.
//!
//! # Departures
//! Collapses are half-edge collapses, and the order by quadric is not published.
//!
//! # References
//! Xia, El-Sana, Varshney: *Adaptive Real-Time Level-of-Detail-Based Rendering for Polygonal Models*, 1997. El-Sana, Evans, Kalaiah, Varshney, Skiena,
//! Azanli: *Efficiently Computing and Updating Triangle Strips for Real-Time Rendering*, 2000, section 4.2.
//!
//! # Complexity
//! O(n log n) time: each level has a share less vertices than the one before. 110 bytes per triangle while it runs.

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
    /// The least quadric at the kept vertex first, up to a limit per level.
    #[default]
    Quadric,
    /// The shortest edge first, as published.
    ShortestEdge,
}

names! {
    "tristrip::simplify::MergeOrder", MergeOrder, "merge order",
    Quadric => "quadric", "The least quadric error first, up to a limit per level";
    ShortestEdge => "shortest-edge", "The shortest edge first (Xia et al. 1997)";
}

/// How far the collapses of a level are from each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Spacing {
    /// No triangle has a vertex of two of them: each could be done alone.
    Disjoint,
    /// No triangle has two vertices that are removed, and irregular points stay.
    Apart,
}

/// The collapses of a merge tree.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct MergeTree {
    /// The collapses, level by level from the full mesh on.
    pub sequence: CollapseSequence,
    /// For each level of the tree the number of collapses up to its end, counted from the full mesh.
    pub level_ends: Vec<u32>,
    /// The reasons for which there are more triangles than requested, if there are.
    pub stopped: Option<Stopped>,
}

/// Builds the merge tree of triangles over the vertices of a mesh. The limits and weights of the options apply; their price does not.
///
/// # Errors
/// The number of indices is not a multiple of three, or an index is out of range; there are more than 2²⁷ triangles; an option is
/// invalid.
///
/// ```
#[doc = include_str!("../example.txt")]
/// use tristrip::simplify::{MergeOrder, merge_tree};
/// let triangles = grid.faces().corners().to_vec();
/// let tree = merge_tree(&grid, triangles, MergeOrder::Quadric, &SimplifyOptions::default())?;
/// assert_eq!(tree.level_ends.last().copied(), Some(tree.sequence.len() as u32));
/// // 81 vertices.
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

/// Collapses triangles over the vertices of a mesh in batches for a [stream](crate::stream): a batch removes vertices of which no two have a common triangle, as many
/// as there can be among the cheaper ones, by [`SimplifyOptions::with_error_factors`] relative to where they are seen from. These are fewer and larger than the levels of a [merge tree](merge_tree), since a vertex may be kept by several collapses of a batch; where a
/// surface is not manifold, its points stay.
///
/// # Errors
/// The number of indices is not a multiple of three, or an index is out of range; there are more than 2²⁷ triangles; an option is
/// invalid.
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

    /// Counts the triangles that face away from the sum of the normals of the full mesh at one of their corners.
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
            // A ring whose upper and lower side nearly touch: thin sheets are folded most easily.
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
