//! The progressive mesh: triangles drawn one by one, three vertices each. It is the baseline for progressive strips.
//!
//! # Algorithm
//! The triangles stand in the order in which vertex splits add them, so that those of a level are a prefix of the list. A split adds the next ones
//! and renames corners of earlier ones. The published record describes these corners by its two *wing* vertices: the triangles around the
//! split vertex from one wing to the other. That holds on a manifold surface. Here it must hold on any mesh, with seams and with edges of
//! three triangles, so that the corners are listed as the slots of strips are. The wings are given in addition.
//!
//! ```text
//!       left wing                    left wing
//!       ╱   │   ╲                    ╱  ╱ ╲  ╲
//!      ·  kept   ·     split ─▶     · kept─new ·      new triangles: left and right of kept ─ new;
//!       ╲   │   ╱                    ╲  ╲ ╱  ╱        corners to the right of the wings are renamed
//!       right wing                   right wing
//! ```
//! # References
//! Hoppe: *Progressive Meshes*, 1996, section 3. Kim et al. 2005, section 3.2.
//!
//! # Complexity
//! 12 bytes per triangle; about four corners of 8 bytes, and 28 bytes, per collapse.

use super::naive;
use crate::collapse::CollapseSequence;
use crate::error::Error;
use crate::ids::OptionalId;
use crate::lod::replay::Replay;
use crate::mesh::{is_degenerate, triangles_of};

/// The triangles of a mesh at any level of a collapse sequence, as a list that is updated in slot.
///
/// ```
/// use tristrip::{CollapseSequence, collapse::Rename, lod::progressive::ProgressiveMesh};
/// let rename = [Rename { removed: 3, kept: 2 }];
/// let sequence = CollapseSequence::from_collapses(4, vec![2, 1, 3, 0, 1, 2], [(&rename[..], 0.5)])?;
/// let mut model = ProgressiveMesh::new(&sequence)?;
/// assert_eq!(model.corners(), [0, 1, 2, 2, 1, 3]);
/// assert_eq!(model.splits(0).next().map(|split| split.wings), Some([None, Some(1)]));
/// model.coarsen();
/// assert_eq!(model.corners(), [0, 1, 2]);
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProgressiveMesh {
    replay: Replay,
    /// The number of triangles at each level.
    triangle_counts: Vec<u32>,
    /// The kept vertex of each renamed vertex, in the order of the records.
    kept: Vec<u32>,
    /// The wings of each renamed vertex, in the same order.
    wings: Vec<[OptionalId; 2]>,
}

/// A vertex split as published: the vertex that becomes two, and the neighbours between which it opens.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VertexSplit {
    /// The restored vertex.
    pub vertex: u32,
    /// The vertex that it is split from.
    pub kept: u32,
    /// The third vertices of the first new triangles with the directed edge `kept` → `vertex`, and `vertex` → `kept`; `None` at a
    /// boundary.
    pub wings: [Option<u32>; 2],
}

impl ProgressiveMesh {
    /// Builds the model of a sequence of collapses, at the level of the full mesh.
    ///
    /// # Errors
    /// There are more than 256 corners to rename per corner of the mesh.
    pub fn new(sequence: &CollapseSequence) -> Result<Self, Error> {
        let (corners, triangle_counts) = in_order_of_splits(sequence);
        let replay = naive::replay(corners, sequence, |level| 3 * triangle_counts[level])?;
        let kept = sequence.iter().flat_map(|c| c.renames.iter().map(|rename| rename.kept)).collect();
        let mut model = Self { replay, triangle_counts, kept, wings: Vec::new() };
        model.wings = model.find_wings();
        Ok(model)
    }

    /// Returns the number of collapses, which is the level of the full mesh.
    pub fn len(&self) -> usize {
        self.replay.records.len()
    }

    /// Returns whether there is no collapse.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the level of the list.
    pub fn level(&self) -> usize {
        self.replay.level
    }

    /// Splits a vertex: one level up. Returns `false` at the full mesh.
    pub fn refine(&mut self) -> bool {
        self.replay.refine()
    }

    /// Collapses a vertex: one level down. Returns `false` at the base mesh.
    pub fn coarsen(&mut self) -> bool {
        self.replay.coarsen()
    }

    /// Moves to a level, step by step.
    ///
    /// # Panics
    /// `level` is greater than [`ProgressiveMesh::len`].
    pub fn go_to(&mut self, level: usize) {
        self.replay.go_to(level);
    }

    /// Returns the triangles at the level, three vertices each, those of coarser levels first.
    pub fn corners(&self) -> &[u32] {
        &self.replay.entries[..3 * self.triangle_counts[self.replay.level] as usize]
    }

    /// Returns the number of triangles at a level.
    ///
    /// # Panics
    /// `level` is greater than [`ProgressiveMesh::len`].
    pub fn triangle_count(&self, level: usize) -> usize {
        self.triangle_counts[level] as usize
    }

    /// Returns the vertex splits that lead from `level` to the next one: one, or several of one position where attributes differ.
    ///
    /// # Panics
    /// `level` is not less than [`ProgressiveMesh::len`].
    pub fn splits(&self, level: usize) -> impl ExactSizeIterator<Item = VertexSplit> {
        self.replay.records.vertices_of(level).map(move |i| VertexSplit {
            vertex: self.replay.records.vertices[i],
            kept: self.kept[i],
            wings: self.wings[i].map(OptionalId::get),
        })
    }

    /// Finds the wings of each collapse from the triangles that it drops. Leaves the list unchanged.
    fn find_wings(&mut self) -> Vec<[OptionalId; 2]> {
        let mut wings = vec![[OptionalId::NONE; 2]; self.kept.len()];
        for level in (0..self.len()).rev() {
            let dropped =
                3 * self.triangle_counts[level] as usize..3 * self.triangle_counts[level + 1] as usize;
            for i in self.replay.records.vertices_of(level) {
                let (removed, kept) = (self.replay.records.vertices[i], self.kept[i]);
                // Backward, so that the first triangle decides.
                for t in self.replay.entries[dropped.clone()].chunks_exact(3).rev() {
                    for [a, b, c] in [[t[0], t[1], t[2]], [t[1], t[2], t[0]], [t[2], t[0], t[1]]] {
                        match () {
                            () if [a, b] == [kept, removed] => wings[i][0] = OptionalId::some(c),
                            () if [a, b] == [removed, kept] => wings[i][1] = OptionalId::some(c),
                            () => {}
                        }
                    }
                }
            }
            self.replay.coarsen();
        }
        self.replay.go_to(self.len());
        wings
    }
}

/// Returns the corners of all triangles, those of coarser levels first, and the number of triangles at each level. Triangles that are
/// degenerate in the full mesh are left out.
fn in_order_of_splits(sequence: &CollapseSequence) -> (Vec<u32>, Vec<u32>) {
    let triangles = sequence.triangles();
    let corners_of = |t: usize| &triangles[3 * t..3 * t + 3];
    let mut is_in_base: Vec<bool> = triangles_of(triangles).map(|t| !is_degenerate(t)).collect();
    sequence.iter().flat_map(|c| c.dropped).for_each(|&t| is_in_base[t as usize] = false);
    let base = (0..is_in_base.len()).filter(|&t| is_in_base[t]);
    let mut corners: Vec<u32> = base.flat_map(corners_of).copied().collect();
    let mut counts = vec![(corners.len() / 3) as u32];
    for level in 0..sequence.len() {
        corners.extend(sequence.collapse(level).dropped.iter().flat_map(|&t| corners_of(t as usize)));
        counts.push((corners.len() / 3) as u32);
    }
    (corners, counts)
}
