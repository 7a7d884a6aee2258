//! The progressive mesh: triangles drawn one by one, three vertices each. It is the baseline for
//! progressive strips.
//!
//! # Algorithm
//! The triangles are stored in the order in which vertex splits add them, so the triangles of a
//! level are a prefix of the list. A split adds the next triangles and renames corners of earlier
//! ones. The published record describes these corners by its two *wing* vertices: the triangles
//! around the split vertex from one wing to the other. This works on manifold surfaces. This module
//! supports any mesh, including seams and edges with three triangles, so the corners are listed
//! explicitly, like the slots of strips. The wings are stored in addition.
//!
//! ```text
//!       left wing                    left wing
//!       ╱   │   ╲                    ╱  ╱ ╲  ╲
//!      ·  kept   ·     split ─▶     · kept─new ·    new triangles: left and right of kept ─ new;
//!       ╲   │   ╱                    ╲  ╲ ╱  ╱      corners to the right of the wings are renamed
//!       right wing                   right wing
//! ```
//! # References
//! Hoppe: *Progressive Meshes*, 1996, section 3. Kim et al. 2005, section 3.2.
//!
//! # Complexity
//! 12 bytes per triangle. Per collapse, 28 bytes plus about four corners of 8 bytes.

use std::sync::Arc;

use super::naive;
use crate::collapse::CollapseSequence;
use crate::error::Error;
use crate::ids::OptionalId;
use crate::lod::level::level_model::{LevelCursor, LevelModel};
use crate::lod::level::level_table::LevelTable;
use crate::lod::level::replay::{Records, Replay};
use crate::mesh::{is_degenerate, triangles_of};
use crate::strip::Strips;

/// The triangles of a mesh at all levels of a collapse sequence, stored as a list and the corners
/// that each collapse renames in it. The model is immutable; a [`ProgressiveMeshCursor`] stores the
/// list of one level.
///
/// ```
/// use std::sync::Arc;
/// use tristrip::{CollapseSequence, Rename};
/// use tristrip::lod::{LevelCursor, ProgressiveMesh};
/// let rename = [Rename { removed: 3, kept: 2 }];
/// let sequence = CollapseSequence::from_collapses(4, vec![2, 1, 3, 0, 1, 2], [(&rename[..], 0.5)])?;
/// let model = Arc::new(ProgressiveMesh::new(&sequence)?);
/// let mut cursor = model.cursor();
/// assert_eq!(cursor.corners(), [0, 1, 2, 2, 1, 3]);
/// assert_eq!(model.splits(0).unwrap().next().map(|split| split.wings), Some([None, Some(1)]));
/// cursor.set_level(0)?;
/// assert_eq!(cursor.corners(), [0, 1, 2]);
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ProgressiveMesh {
    /// The corners of the full mesh.
    full: Vec<u32>,
    records: Records,
    levels: LevelTable,
    /// The kept vertex of each renamed vertex, in the order of the records.
    kept: Vec<u32>,
    /// The wings of each renamed vertex, in the same order.
    wings: Vec<[OptionalId; 2]>,
}

/// A vertex split as published: the vertex that is split in two, and its neighbours at both ends of
/// the opening.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VertexSplit {
    /// The restored vertex.
    pub vertex: u32,
    /// The vertex that it is split from.
    pub kept: u32,
    /// The third vertices of two new triangles: the first with the directed edge `kept` → `vertex`,
    /// and the first with `vertex` → `kept`. `None` at a boundary.
    pub wings: [Option<u32>; 2],
}

impl ProgressiveMesh {
    /// Builds the model from a sequence of collapses.
    ///
    /// # Errors
    /// The collapses rename more than 256 corners per corner of the mesh.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let model = ProgressiveMesh::new(&sequence)?;
    /// assert_eq!((0..=2).map(|level| model.levels().triangle_count(level)).sum::<Result<usize, _>>()?, 6);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn new(sequence: &CollapseSequence) -> Result<Self, Error> {
        let levels = LevelTable::of(sequence);
        let corners = in_order_of_splits(sequence);
        let (full, records) =
            naive::record(corners, sequence, |level| 3 * levels.triangles_at(level) as u32)?;
        let kept = sequence.iter().flat_map(|c| c.renames.iter().map(|rename| rename.kept)).collect();
        let mut model = Self { full, records, levels, kept, wings: Vec::new() };
        model.wings = model.find_wings();
        Ok(model)
    }

    /// Returns a cursor at the level of the full mesh.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let model = Arc::new(ProgressiveMesh::new(&sequence)?);
    /// assert_eq!((model.cursor().level(), model.cursor().corners().len()), (2, 9));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn cursor(self: &Arc<Self>) -> ProgressiveMeshCursor {
        let replay = Replay { entries: self.full.clone(), level: self.records.len() };
        ProgressiveMeshCursor {
            model: Arc::clone(self),
            replay,
            display: Strips::default(),
            is_current: false,
        }
    }

    /// Returns the vertex splits from `level` to `level` + 1; `None` if there is no such level. A
    /// point on an attribute seam has one split for each of its vertices.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let model = ProgressiveMesh::new(&sequence)?;
    /// let split = model.splits(1).and_then(|mut splits| splits.next());
    /// assert_eq!(split, Some(VertexSplit { vertex: 4, kept: 3, wings: [Some(2), None] }));
    /// assert!(model.splits(2).is_none());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn splits(&self, level: usize) -> Option<impl ExactSizeIterator<Item = VertexSplit>> {
        let split = |i: usize| VertexSplit {
            vertex: self.records.vertices[i],
            kept: self.kept[i],
            wings: self.wings[i].map(OptionalId::get),
        };
        (level < self.records.len()).then(|| self.records.vertices_of(level).map(split))
    }

    /// Finds the wings of each collapse from the triangles that it drops.
    fn find_wings(&self) -> Vec<[OptionalId; 2]> {
        let mut wings = vec![[OptionalId::NONE; 2]; self.kept.len()];
        let mut replay = Replay { entries: self.full.clone(), level: self.records.len() };
        for level in (0..self.records.len()).rev() {
            let dropped = 3 * self.levels.triangles_at(level)..3 * self.levels.triangles_at(level + 1);
            for i in self.records.vertices_of(level) {
                let (removed, kept) = (self.records.vertices[i], self.kept[i]);
                // In reverse order, so that the first triangle determines the wing.
                for t in replay.entries[dropped.clone()].chunks_exact(3).rev() {
                    for [a, b, c] in [[t[0], t[1], t[2]], [t[1], t[2], t[0]], [t[2], t[0], t[1]]] {
                        match () {
                            () if [a, b] == [kept, removed] => wings[i][0] = OptionalId::some(c),
                            () if [a, b] == [removed, kept] => wings[i][1] = OptionalId::some(c),
                            () => {}
                        }
                    }
                }
            }
            replay.coarsen(&self.records);
        }
        wings
    }
}

impl LevelModel for ProgressiveMesh {
    fn levels(&self) -> &LevelTable {
        &self.levels
    }

    fn memory(&self) -> usize {
        let lists = size_of_val(&self.full[..]) + size_of_val(&self.kept[..]) + size_of_val(&self.wings[..]);
        lists + self.records.memory() + self.levels.memory()
    }

    fn start(self: Arc<Self>) -> Box<dyn LevelCursor> {
        Box::new(self.cursor())
    }
}

/// The list of a [`ProgressiveMesh`] at one level.
#[derive(Debug, Clone)]
pub struct ProgressiveMeshCursor {
    model: Arc<ProgressiveMesh>,
    replay: Replay,
    /// A strip per triangle; valid for the current level if `is_current`.
    display: Strips,
    is_current: bool,
}

impl ProgressiveMeshCursor {
    /// Returns the triangles of the current level, three vertices each. The triangles of coarser
    /// levels come first.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let mut cursor = Arc::new(ProgressiveMesh::new(&sequence)?).cursor();
    /// let full = cursor.corners().to_vec();
    /// cursor.set_level(1)?;
    /// // The triangle dropped by the collapse is the last one.
    /// assert_eq!((cursor.corners(), &full[6..]), (&full[..6], &[2, 3, 4][..]));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn corners(&self) -> &[u32] {
        &self.replay.entries[..3 * self.model.levels.triangles_at(self.replay.level)]
    }
}

impl LevelCursor for ProgressiveMeshCursor {
    fn levels(&self) -> &LevelTable {
        &self.model.levels
    }

    fn level(&self) -> usize {
        self.replay.level
    }

    fn set_level(&mut self, level: usize) -> Result<(), Error> {
        self.model.levels.check(level)?;
        if level != self.replay.level {
            self.is_current = false;
            self.replay.go_to(level, &self.model.records);
        }
        Ok(())
    }

    /// Returns one strip per triangle: the progressive mesh is drawn as a list.
    fn strips(&mut self) -> &Strips {
        if !self.is_current {
            let (triangles, display) = (self.model.levels.triangles_at(self.replay.level), &mut self.display);
            display.clear();
            self.replay.entries[..3 * triangles].chunks_exact(3).for_each(|triangle| display.push(triangle));
            self.is_current = true;
        }
        &self.display
    }

    fn memory(&self) -> usize {
        size_of_val(&self.replay.entries[..]) + self.display.memory()
    }
}

/// Returns the corners of all triangles, those of coarser levels first. Triangles that are
/// degenerate in the full mesh are left out.
fn in_order_of_splits(sequence: &CollapseSequence) -> Vec<u32> {
    let triangles = sequence.triangles();
    let corners_of = |t: usize| &triangles[3 * t..3 * t + 3];
    let mut is_in_base: Vec<bool> = triangles_of(triangles).map(|t| !is_degenerate(t)).collect();
    sequence.iter().flat_map(|c| c.dropped).for_each(|&t| is_in_base[t as usize] = false);
    let base = (0..is_in_base.len()).filter(|&t| is_in_base[t]);
    let mut corners: Vec<u32> = base.flat_map(corners_of).copied().collect();
    for level in 0..sequence.len() {
        corners.extend(sequence.collapse_to(level).dropped.iter().flat_map(|&t| corners_of(t as usize)));
    }
    corners
}
