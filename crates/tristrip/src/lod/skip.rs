//! Skip Strips: view-dependent level of detail whose display strips are updated incrementally.
//!
//! The collapses of a simplification form a vertex hierarchy. A view applies every collapse whose
//! error is too small to see. It therefore draws less detail far from the camera, outside the view
//! frustum and on back faces. Strips are built once, for the full mesh. A view replaces each strip
//! vertex with its first active ancestor, and a filter removes the degenerate triangles. Only a few
//! vertices change from frame to frame, and only the strips around them are rebuilt.
//!
//! ```text
//! Mesh ──▶ merge tree: a CollapseSequence ─┐
//!    └───▶ Strips ─────────────────────────┴─▶ SkipStrips, one per model, shared and immutable
//!                                                 ├──▶ SkipView of one camera: update
//!                                                 └──▶ SkipView of another camera
//! ```
//! # Algorithm
//! *Build* is split into modules: `vertex_tree` (nodes, parents, skip pointers to ancestors),
//! `dependencies` (the collapses that each collapse depends on), `bounds` (error, sphere and normal
//! cone of each collapse) and `original_strips` (the strip segments that contain each vertex).
//!
//! *Update*:
//! 1. The travel of the camera since the last frame determines which collapses are evaluated again
//!    (`schedule`).
//! 2. Each of these collapses is applied if its error is allowed and its dependencies are applied.
//!    The collapses that depend on it are evaluated next.
//! 3. Each collapse whose error is too large is split, largest error first. The collapses that
//!    depend on it are split before it.
//! 4. Steps 2 and 3 repeat until nothing changes. Then the flagged segments are scanned (module
//!    `display`).
//!
//! The result does not depend on the order of operations: no collapse prevents another collapse,
//! and no split prevents another split.
//!
//! # Departures
//! - Nodes are numbered depth-first instead of having lists of child pointers. The active child of
//!   a node is stored as a node id.
//! - The published algorithm evaluates all active vertices in every frame. Here a collapse is
//!   evaluated again only after the camera has moved far enough.
//! - The paper rebuilds whole strips; this implementation rebuilds segments of 64 entries.
//! - Vertices at the same position on a seam collapse together, which prevents cracks.
//! - The search for the first active ancestor starts with the skip pointer used last. In the paper,
//!   the search can only choose a shorter pointer; here it can also choose a longer one.
//! - A view stores the name of each node: the vertex of its first active ancestor. The descendants
//!   of a node are a contiguous range, so a collapse or split fills a range of names.
//!   [`SkipView::simplified_strips`] finds the same names with the skip pointers, as published.
//!
//! # References
//! El-Sana, Evans, Kalaiah, Varshney, Skiena, Azanli: *Efficiently Computing and Updating Triangle
//! Strips for Real-Time Rendering*, 2000, sections 4 and 5. El-Sana, Azanli, Varshney: *Skip
//! Strips: Maintaining Triangle Strips for View-Dependent Rendering*, 1999. Xia, El-Sana, Varshney:
//! *Adaptive Real-Time Level-of-Detail-Based Rendering for Polygonal Models*, 1997.
//!
//! # Complexity
//! Building takes O(n log n) time for n vertices. The time of an update is proportional to the
//! collapses evaluated, the descendants of the changed nodes, and the segments scanned.
//! `docs/views.md` lists the memory per vertex.

mod bounds;
mod camera;
mod cone;
mod criteria;
mod dependencies;
mod display;
mod foveation;
mod level_cursor;
mod original_strips;
mod repaired_view;
mod schedule;
mod state;
#[cfg(test)]
mod tests;
mod vertex_tree;
mod view;

use crate::collapse::{Collapse, CollapseSequence};
use crate::error::Error;
use crate::ids::OptionalId;
use crate::lod::level::level_table::LevelTable;
use crate::mesh::{Positions, canonical_triangles, triangles_of};
use crate::strip::Strips;
use bounds::TreeBounds;
pub use camera::Camera;
pub use criteria::ViewCriteria;
use dependencies::Dependencies;
pub use foveation::Foveation;
pub use level_cursor::SkipLevelCursor;
use original_strips::OriginalStrips;
pub use repaired_view::RepairedView;
use vertex_tree::VertexTree;
pub use view::{SkipView, ViewGeomorphs, ViewSnapshot, ViewUpdate};

/// A view-dependent level-of-detail model, shared by any number of views.
///
/// ```
#[doc = include_str!("skip/example.txt")]
/// let mut view = model.view();
/// for x in 0..8 {
///     let update = view.update(&Camera::new([x as f32, 1.0, -2.0], [4.0, 0.0, 4.0])?, &ViewCriteria::default().with_pixels(2.0))?;
///     // Only these ranges of the buffer must be uploaded to the GPU.
///     assert!(update.changed.iter().all(|range| range.end <= view.indices().len()));
/// }
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SkipStrips {
    tree: VertexTree,
    dependencies: Dependencies,
    bounds: Option<TreeBounds>,
    strips: OriginalStrips,
    levels: LevelTable,
    /// The ids of all collapses in order from the full mesh; none for a collapse without renames.
    order: Vec<OptionalId>,
    /// The number of triangles that each collapse drops, by collapse id, clamped to 255.
    /// `many_dropped` has the larger counts.
    dropped: Vec<u8>,
    many_dropped: Vec<(u32, u32)>,
    vertex_count: usize,
}

impl SkipStrips {
    /// Builds the model from strips of the full mesh, a collapse sequence, and vertex positions.
    ///
    /// # Errors
    /// The strips do not draw exactly the triangles of the sequence, or a position is missing or
    /// not finite.
    ///
    /// ```
    #[doc = include_str!("skip/example.txt")]
    /// assert!(SkipStrips::new(&Strips::default(), &sequence, grid.positions()).is_err());
    /// assert!(model.height() >= model.depth());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn new<P: Positions + ?Sized>(
        strips: &Strips,
        sequence: &CollapseSequence,
        positions: &P,
    ) -> Result<Self, Error> {
        Self::build(strips, sequence, Some(positions))
    }

    /// Builds a model without positions. The model supports levels, but its views cannot follow a
    /// camera.
    ///
    /// # Errors
    /// The strips do not draw exactly the triangles of the sequence.
    ///
    /// ```
    #[doc = include_str!("skip/example.txt")]
    /// let mut view = Arc::new(SkipStrips::of_levels(&strips, &sequence)?).view();
    /// assert!(view.update(&Camera::new([0.0; 3], [1.0; 3])?, &ViewCriteria::default()).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn of_levels(strips: &Strips, sequence: &CollapseSequence) -> Result<Self, Error> {
        Self::build(strips, sequence, None::<&[[f32; 3]]>)
    }

    fn build<P: Positions + ?Sized>(
        strips: &Strips,
        sequence: &CollapseSequence,
        positions: Option<&P>,
    ) -> Result<Self, Error> {
        strips.check_vertices(sequence.vertex_count())?;
        check_triangles(strips, sequence)?;
        let (tree, numbers) = VertexTree::new(sequence)?;
        let collapse_id =
            |collapse: Collapse<'_>| collapse.renames.first().map(|first| numbers.of(first.removed));
        let order: Vec<OptionalId> = sequence.iter().map(|collapse| collapse_id(collapse).into()).collect();
        let dependencies = Dependencies::new(sequence, &tree, &numbers);
        let bounds =
            positions.map(|positions| TreeBounds::new(positions, sequence, (&tree, &numbers), &dependencies));
        let mut dropped = vec![0; tree.len()];
        let mut many_dropped = Vec::new();
        for (collapse, collapse_id) in sequence.iter().zip(&order) {
            let Some(collapse_id) = collapse_id.get() else { continue };
            dropped[collapse_id as usize] = u8::try_from(collapse.dropped.len()).unwrap_or_else(|_| {
                many_dropped.push((collapse_id, collapse.dropped.len() as u32));
                u8::MAX
            });
        }
        many_dropped.sort_unstable();
        Ok(Self {
            strips: OriginalStrips::new(strips, &tree, &numbers),
            bounds: bounds.transpose()?,
            levels: LevelTable::of(sequence),
            tree,
            dependencies,
            order,
            dropped,
            many_dropped,
            vertex_count: sequence.vertex_count(),
        })
    }

    /// Returns the triangle count and the error of each level. A view generally matches none of
    /// these levels.
    ///
    /// ```
    #[doc = include_str!("skip/example.txt")]
    /// assert_eq!(model.levels().collapse_count(), sequence.len());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn levels(&self) -> &LevelTable {
        &self.levels
    }

    /// Returns the height of the merge tree: the maximum number of successive collapses on the path
    /// from a vertex to its root.
    ///
    /// ```
    #[doc = include_str!("skip/example.txt")]
    /// assert!((6..30).contains(&model.height()));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn height(&self) -> u32 {
        let mut heights = vec![0_u32; self.tree.len()];
        for collapse_id in self.order.iter().filter_map(|collapse_id| collapse_id.get()) {
            for node in self.tree.members(collapse_id) {
                if let Some(parent) = self.tree.parent(node) {
                    let height = heights[node as usize].max(heights[parent as usize]) + 1;
                    heights[parent as usize] = height;
                }
            }
        }
        heights.into_iter().max().unwrap_or(0)
    }

    /// Returns the maximum number of ancestors of a vertex.
    ///
    /// ```
    #[doc = include_str!("skip/example.txt")]
    /// assert!(model.depth() > 1);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn depth(&self) -> u32 {
        self.tree.depth()
    }

    /// Returns the mean number of direct dependencies per collapse.
    ///
    /// ```
    #[doc = include_str!("skip/example.txt")]
    /// assert!(model.mean_dependencies() > 0.5);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn mean_dependencies(&self) -> f64 {
        self.dependencies.len() as f64 / self.order.len().max(1) as f64
    }

    /// Returns the memory in bytes, as `[strips, others]`: the strips of the full mesh, and
    /// everything else.
    ///
    /// ```
    #[doc = include_str!("skip/example.txt")]
    /// let [strips, others] = model.memory_by_part();
    /// // Four bytes per strip vertex and per restart.
    /// assert!(strips >= 4 * (128 + 2) && others > 81 * 4);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn memory_by_part(&self) -> [usize; 2] {
        let [strips, segments] = self.strips.memory();
        let others = self.tree.memory()
            + self.dependencies.memory()
            + self.bounds.as_ref().map_or(0, TreeBounds::memory)
            + segments
            + self.levels.memory()
            + size_of_val(&self.order[..])
            + size_of_val(&self.dropped[..])
            + size_of_val(&self.many_dropped[..]);
        [strips, others]
    }

    /// Returns the number of triangles that a collapse drops.
    #[inline]
    fn dropped(&self, collapse_id: u32) -> usize {
        let dropped = self.dropped[collapse_id as usize];
        if dropped < u8::MAX {
            return dropped.into();
        }
        let found = self.many_dropped.binary_search_by_key(&collapse_id, |&(collapse_id, _)| collapse_id);
        found.map_or(dropped.into(), |i| self.many_dropped[i].1 as usize)
    }

    /// Returns the number of vertices that no collapse removes.
    fn base_vertex_count(&self) -> usize {
        (0..self.tree.len() as u32).filter(|&node| self.tree.parent(node).is_none()).count()
    }
}

/// Checks that the strips draw exactly the triangles of the sequence.
fn check_triangles(strips: &Strips, sequence: &CollapseSequence) -> Result<(), Error> {
    let triangles = sequence.triangles();
    if strips.triangles().eq(triangles_of(triangles)) {
        return Ok(());
    }
    let drawn = canonical_triangles(strips.triangles());
    if drawn == canonical_triangles(triangles_of(triangles)) {
        return Ok(());
    }
    Err(Error::Parameter {
        name: "strips",
        found: format!("{} triangles, not those of the full mesh", drawn.len()),
        expected: "strips that draw the full mesh",
    })
}
