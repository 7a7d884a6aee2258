//! Skip Strips: view-dependent detail, with display strips that are never computed again.
//!
//! The collapses of a simplification form a hierarchy of vertices. A view does those whose error it cannot see: more far away, outside of the image and on faces
//! that look away. Strips are made once, for the full mesh. In a view, a vertex of a strip is drawn as its first ancestor that has not collapsed, and a
//! filter removes the degenerate triangles. From frame to frame few vertices change, and only the strips in which they are.
//!
//! ```text
//! Mesh ──▶ merge tree: a CollapseSequence ─┐
//!    └───▶ Strips ─────────────────────────┴─▶ SkipStrips, one per model, shared and immutable
//!                                                 ├──▶ SkipView of a camera: update ─▶ changed ranges of its index buffer
//!                                                 └──▶ SkipView of another one
//! ```
//! # Algorithm
//! *Build*: the modules `vertex_tree` (nodes, parents, pointers that skip ancestors), `dependencies` (which collapses need which), `bounds` (error, sphere and cone of
//! normals of each collapse), `original_strips` (the segments in which a vertex is).
//!
//! *Update*:
//! 1. The travel of the camera since the last frame tells which collapses have to be looked at (`schedule`).
//! 2. Of these, each that is allowed and needs no other one is done; those that it blocked are looked at, too.
//! 3. Each of which the error is too large is split, the largest first. What needs it is split before.
//! 4. Steps 2 and 3 repeat until nothing changes. Then the flagged segments are scanned (module `display`).
//!
//! The result does not depend on the order of the work: a collapse never forbids another one, nor a split another split.
//!
//! # Departures
//! - Children are numbered one after the other, so that the index of the active child is the number of a node.
//! - The published algorithm looks at all active vertices in each frame; here a collapse waits until the camera has moved far enough.
//! - Whole strips are rebuilt there, segments of 64 entries here.
//! - Vertices of one position on a seam collapse together, so that no gap opens.
//! - The pointer used last may also rise, to a farther ancestor; the paper lets it only fall.
//! - A view stores the name of each vertex, its first active ancestor: the vertices below a node are a range, which a collapse or split fills. The pointers that
//!   skip ancestors, as published, find the same names for [`SkipView::simplified_strips`].
//!
//! # References
//! El-Sana, Evans, Kalaiah, Varshney, Skiena, Azanli: *Efficiently Computing and Updating Triangle Strips for Real-Time Rendering*, 2000, sections 4
//! and 5. El-Sana, Azanli, Varshney: *Skip Strips: Maintaining Triangle Strips for View-Dependent Rendering*, 1999. Xia, El-Sana, Varshney: *Adaptive Real-Time
//! Level-of-Detail-Based Rendering for Polygonal Models*, 1997.
//!
//! # Complexity
//! Building takes O(n log n) time for n vertices. An update takes time for the collapses looked at, for the vertices below those that change, and for the segments in which these
//! are. The memory per vertex is in `docs/views.md`.

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

/// A model of which each view has its own detail.
///
/// ```
#[doc = include_str!("skip/example.txt")]
/// let mut view = model.view();
/// for x in 0..8 {
///     let update = view.update(&Camera::new([x as f32, 1.0, -2.0], [4.0, 0.0, 4.0])?, &ViewCriteria::default().with_pixels(2.0))?;
///     // Only these ranges of the buffer have to be sent to the graphics processor.
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
    /// The ids of all collapses in order from the full mesh; none for a collapse that renames nothing.
    order: Vec<OptionalId>,
    /// For each node the triangles that its collapse drops, if it is the id of a collapse, up to 255; the others are in `many_dropped`.
    dropped: Vec<u8>,
    many_dropped: Vec<(u32, u32)>,
    vertex_count: usize,
}

impl SkipStrips {
    /// Builds the model of a simplification and strips of its full mesh, at these positions.
    ///
    /// # Errors
    /// The strips do not draw exactly the triangles of the sequence; a position is missing or not finite.
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

    /// Builds a model without positions, which has levels but no views.
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

    /// Returns the triangles and errors of the levels, of which a view draws none in general.
    ///
    /// ```
    #[doc = include_str!("skip/example.txt")]
    /// assert_eq!(model.levels().collapse_count(), sequence.len());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn levels(&self) -> &LevelTable {
        &self.levels
    }

    /// Returns the height of the merge tree: the most collapses, one into a result of the one before, that lead from a vertex to a root.
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

    /// Returns the largest number of ancestors of a vertex.
    ///
    /// ```
    #[doc = include_str!("skip/example.txt")]
    /// assert!(model.depth() > 1);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn depth(&self) -> u32 {
        self.tree.depth()
    }

    /// Returns the mean number of collapses that a collapse needs, by its list.
    ///
    /// ```
    #[doc = include_str!("skip/example.txt")]
    /// assert!(model.mean_dependencies() > 0.5);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn mean_dependencies(&self) -> f64 {
        self.dependencies.len() as f64 / self.order.len().max(1) as f64
    }

    /// Returns the memory of the strips of the full mesh, and that of everything else, in bytes.
    ///
    /// ```
    #[doc = include_str!("skip/example.txt")]
    /// let [strips, others] = model.memory_by_part();
    /// // Four bytes per vertex of the strips, and per end of one.
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

    /// Counts the triangles that a collapse drops.
    #[inline]
    fn dropped(&self, collapse_id: u32) -> usize {
        let dropped = self.dropped[collapse_id as usize];
        if dropped < u8::MAX {
            return dropped.into();
        }
        let found = self.many_dropped.binary_search_by_key(&collapse_id, |&(collapse_id, _)| collapse_id);
        found.map_or(dropped.into(), |i| self.many_dropped[i].1 as usize)
    }

    /// Counts the vertices that no collapse removes.
    fn base_vertex_count(&self) -> usize {
        (0..self.tree.len() as u32).filter(|&node| self.tree.parent(node).is_none()).count()
    }
}

/// Checks that strips draw exactly the triangles of a sequence.
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
        found: format!("{} triangles, not all of the full mesh", drawn.len()),
        expected: "strips that draw the full mesh",
    })
}
