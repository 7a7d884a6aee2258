//! `repair`: a filter developed for this library. At every level, its display strips cost about as
//! much as strips computed from scratch for that level.
//!
//! The other filters read the full mesh's strips with renamed vertices and remove degenerate
//! triangles. Their strips break up as the mesh gets coarser, because the ends of a cut strip are
//! never reconnected. This filter stores the strips as paths over the triangles of the current
//! level. At each collapse and each split, it repairs the paths next to the change.
//!
//! ```text
//!          x                    x
//!   ━ u ━╱━━━╲━ v ━      ━ u ━╱━ v ━       a path through a dropped triangle d
//!      ╱   d   ╲             ╱             is linked across it
//!   kept ──── removed     kept
//! ```
//! # Algorithm
//! *Coarsen*:
//! 1. Cut the links of the dropped triangles, apply the collapse, and pair the half-edges that
//!    changed.
//! 2. If a dropped triangle was linked to two neighbours, link these two if they now share an edge.
//!    A path across the edge between the kept and the removed vertex remains cut; the local search
//!    reconnects its ends.
//! 3. *Search*: take the triangles nearest to the kept vertex; the effort sets their number. Start
//!    a local search from each of them in turn; the effort also sets the number of rounds. A local
//!    search changes a few links, and is undone if the strips then cost more (see
//!    `cover/local_search.rs`).
//!
//! *Refine*: apply these steps in reverse, around both vertices. A restored triangle is linked to
//! the two triangles on its sides, if these were linked to each other.
//!
//! *Directly at a level*: drop all triangles that the level does not have. Link consecutive
//! remaining triangles of a strip that share an edge, as the filters do. Then search from all
//! triangles.
//!
//! The module `pairing` defines the twins at edges with more than two triangles.
//!
//! # Determinism
//! The strips of a level depend only on the sequence of levels before it: the same steps give the
//! same strips. Coarsening and then refining can give different strips, but they draw the same
//! triangles.
//!
//! # Effort
//! Measured on the bunny with 69,451 triangles, simplified to a twentieth in 33,042 collapses. The
//! strips of the full mesh are built by `best`. Vertices sent are in percent of a triangle list,
//! which sends three vertices per triangle. The strips of the full mesh send 36.7 %. The table
//! lists the vertices sent, summed over all levels and at the base mesh, and the time per collapse
//! on one core. Strips computed from scratch for each level by `best` at its default effort send
//! 39.2 %. At the base mesh, `Dtfs` sends 99.6 % and `Linked` 82.5 %.
//!
//! | level | 0 | 1 | 2 | 3 | 4 | 5 | 6 | 7 |
//! |---|---|---|---|---|---|---|---|---|
//! | all levels, % | 41.4 | 40.8 | 40.4 | 39.9 | 39.7 | 39.5 | 39.5 | 39.3 |
//! | base mesh, % | 45.6 | 44.0 | 43.3 | 42.1 | 41.6 | 41.2 | 41.1 | 40.9 |
//! | microseconds | 2 | 3 | 5 | 12 | 21 | 42 | 70 | 150 |
//!
//! Efforts 8 and 9 take about two and five times as long as effort 7. When a level with 40 % of the
//! triangles is computed directly, it sends 44.2, 40.9 and 40.5 % at efforts 1, 3 and 5, in 0.03,
//! 0.1 and 0.5 s. Effort 0 does not search in that case, and sends as much as `Linked`, 55.0 %.
//!
//! # References
//! Stewart: *Tunneling for Triangle Strips in Continuous Level-of-Detail Meshes*, 2001; Porcu,
//! Sanna, Scateni: *Efficiently Keeping an Optimal Stripification over a CLOD Mesh*, 2005 (repair
//! next to each change, by tunnels); Kim, Park, Yang, Neelamkavil: *A Rendering-Efficient
//! Progressive Transmission of 3D Meshes*, 2005 (the filter on which this one is based); Lin,
//! Kernighan: *An Effective Heuristic Algorithm for the Traveling-Salesman Problem*, 1973 (chains
//! of changes that are undone if they do not reduce the cost).
//!
//! # Complexity
//! The time of a step depends on the effort and on the valence of the removed vertices, not on the
//! size of the mesh. Cuts are an exception: they walk to the nearer end of their path. Memory: 56
//! bytes per triangle of the full mesh, 8 per vertex and 24 per half-edge without a twin.

mod model;
mod nearby;
mod options;
mod pairing;
mod paths;
mod strip_order;
#[cfg(test)]
mod tests;

pub use model::RepairedStrips;
pub use options::RepairOptions;
pub(crate) use paths::{RepairedPaths, walk_steps};

use std::sync::Arc;

use crate::collapse::CollapseSequence;
use crate::error::Error;
use crate::lod::level::level_mesh::LevelMesh;
use crate::lod::level::level_model::LevelCursor;
use crate::lod::level::level_table::LevelTable;
use crate::strip::{Cost, Strips};
use crate::text::counted;
use options::{SEARCH_AMOUNTS, SearchAmount};
use pairing::{Pairing, TwinChanges};
use strip_order::{StripTriangle, check_size, order_of};

/// A change may take on average 1/16 of the maximum number of walk steps; unused steps are saved
/// for later changes. The test models take up to half of this share. A change of a ribbon of a
/// million triangles takes the maximum.
const AVERAGE_SHARE: u64 = 16;

/// The strips of a level of detail, updated by collapses and splits.
///
/// ```
/// use tristrip::{CollapseSequence, Rename, Strips};
/// use tristrip::lod::{LevelCursor, Repair, RepairOptions};
/// // A strip of four triangles over two rows of vertices. 1 collapses to 0, which drops the first
/// // triangle.
/// let mut strips = Strips::default();
/// strips.push(&[0, 1, 2, 3, 4, 5]);
/// let rename = [Rename { removed: 1, kept: 0 }];
/// let triangles = strips.triangles().flatten().collect();
/// let sequence = CollapseSequence::from_collapses(6, triangles, [(&rename[..], 0.5)])?;
/// let mut repair = Repair::new(sequence, &strips, RepairOptions::default())?;
/// assert_eq!((repair.level(), repair.vertices_sent()), (1, 6));
/// assert!(repair.coarsen());
/// assert_eq!((repair.level(), repair.strips().vertices()), (0, &[5, 4, 3, 2, 0][..]));
/// assert!(repair.refine());
/// assert_eq!(repair.vertices_sent(), 6);
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Repair {
    sequence: Arc<CollapseSequence>,
    levels: Arc<LevelTable>,
    level: usize,
    triangle_count: usize,
    mesh: LevelMesh,
    repaired: RepairedPaths,
    work: SearchAmount,
    pairing: Pairing,
    changes: TwinChanges,
    /// Pairs of half-edges whose link was cut.
    gaps: Vec<[u32; 2]>,
    /// The strips of the level, built on first use through the cursor.
    display: Option<Strips>,
}

impl Repair {
    /// Builds the cursor at the full mesh from its strips.
    ///
    /// # Errors
    /// The strips do not draw every triangle of the full mesh exactly once with its winding, or
    /// there are too many triangles.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut repair = Repair::new(sequence.clone(), &strips, RepairOptions::default())?;
    /// assert_eq!((repair.level(), repair.strips().len()), (2, 1));
    /// strips.push(&[0, 1, 2]); // a second time
    /// assert!(Repair::new(sequence, &strips, RepairOptions::default()).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn new(
        sequence: impl Into<Arc<CollapseSequence>>,
        strips: &Strips,
        options: RepairOptions,
    ) -> Result<Self, Error> {
        let sequence = sequence.into();
        let level = sequence.len();
        Self::linked_at(&sequence, |sequence| LevelMesh::new(sequence), strips, level, options)
    }

    /// Computes the display strips of one level directly from the strips of the full mesh.
    ///
    /// # Errors
    /// The strips do not draw every triangle of the full mesh exactly once with its winding; there
    /// are too many triangles; the level does not exist.
    ///
    /// ```
    /// # use tristrip::{CollapseSequence, Rename, Strips, lod::{LevelCursor, Repair, RepairOptions}};
    /// # let mut strips = Strips::default();
    /// # strips.push(&[0, 1, 2, 3, 4, 5]);
    /// # let rename = [Rename { removed: 1, kept: 0 }];
    /// # let triangles = strips.triangles().flatten().collect();
    /// # let sequence = CollapseSequence::from_collapses(6, triangles, [(&rename[..], 0.5)])?;
    /// let mut repair = Repair::at(sequence, &strips, 0, RepairOptions::default())?;
    /// assert_eq!(repair.strips().vertices(), [5, 4, 3, 2, 0]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn at(
        sequence: impl Into<Arc<CollapseSequence>>,
        strips: &Strips,
        level: usize,
        options: RepairOptions,
    ) -> Result<Self, Error> {
        let sequence = sequence.into();
        if level > sequence.len() {
            return Err(Error::Parameter {
                name: "level",
                found: format!("{level} of {}", counted(sequence.len(), "level")),
                expected: "a level of the sequence",
            });
        }
        let mut repair =
            Self::linked_at(&sequence, |sequence| LevelMesh::new(sequence), strips, level, options)?;
        repair.search_all();
        Ok(repair)
    }

    /// Builds the strips of the base mesh for collapses that are applied and undone in any order.
    pub(super) fn in_any_order(
        sequence: &Arc<CollapseSequence>,
        strips: &Strips,
        options: RepairOptions,
    ) -> Result<Self, Error> {
        let mut repair = Self::linked_at(sequence, LevelMesh::in_any_order, strips, 0, options)?;
        repair.search_all();
        Ok(repair)
    }

    /// Searches from all triangles.
    fn search_all(&mut self) {
        let RepairedPaths { paths, search, .. } = &mut self.repaired;
        let all: Vec<u32> = (0..paths.len() as u32).filter(|&t| self.mesh.is_drawn(t)).collect();
        paths.allow_walks(walk_steps(self.work.all_rounds, all.len()));
        for _ in 0..self.work.all_rounds {
            all.iter().for_each(|&t| search.improve_at(paths, t));
        }
    }

    /// Links what remains of the strips at a level, without search.
    fn linked_at(
        sequence: &Arc<CollapseSequence>,
        full_mesh: impl FnOnce(&Arc<CollapseSequence>) -> LevelMesh,
        strips: &Strips,
        level: usize,
        options: RepairOptions,
    ) -> Result<Self, Error> {
        check_size(sequence)?;
        let mesh = full_mesh(sequence);
        let order = order_of(strips, &mesh)?;
        Ok(Self::linked(sequence, mesh, &order, level, options))
    }

    /// Links what remains of the strips at a level, given the full mesh and the order of its
    /// triangles.
    fn linked(
        sequence: &Arc<CollapseSequence>,
        mut mesh: LevelMesh,
        order: &[StripTriangle],
        level: usize,
        options: RepairOptions,
    ) -> Self {
        (level..sequence.len()).rev().for_each(|level| mesh.collapse(&sequence.collapse_to(level)));
        let slots = mesh.triangle_count();
        let cost = if options.cost == Cost::Gl { Cost::OpenGl } else { options.cost };
        let mut repair = Self {
            levels: Arc::new(LevelTable::of(sequence)),
            sequence: Arc::clone(sequence),
            level,
            triangle_count: 0,
            mesh,
            repaired: RepairedPaths::empty(slots, cost.prices(), options.seed),
            work: SEARCH_AMOUNTS[usize::from(options.effort.level())],
            pairing: Pairing::default(),
            changes: Vec::new(),
            gaps: Vec::new(),
            display: None,
        };
        for t in 0..slots as u32 {
            if repair.mesh.is_drawn(t) {
                repair.triangle_count += 1;
                repair.repaired.paths.insert_triangle(t);
            }
        }
        repair.repaired.paths.allow_walks(walk_steps(repair.work.rounds, repair.work.near));
        repair.link_neighbours(order);
        repair.pairing = Pairing::of(&repair.mesh, &repair.repaired.paths, &mut repair.changes);
        repair.apply_changes();
        repair
    }

    /// Links consecutive drawn triangles of a strip that share an edge.
    fn link_neighbours(&mut self, order: &[StripTriangle]) {
        let mut last: Option<StripTriangle> = None;
        for &next in order.iter().filter(|next| self.mesh.is_drawn(next.triangle)) {
            if let Some(before) = last.filter(|last| last.strip == next.strip) {
                let shared = self.mesh.shared(before.triangle, next.triangle);
                let free =
                    shared.filter(|sides| sides.iter().all(|&h| self.repaired.paths.twin(h).is_none()));
                if let Some([a, b]) = free.min_by_key(|&[_, side]| side != next.entry) {
                    self.repaired.paths.set_twin(a, Some(b));
                    self.repaired.paths.set_twin(b, Some(a));
                    self.repaired.paths.join(a);
                }
            }
            last = Some(next);
        }
    }

    /// Returns the number of vertices of all strips, including swaps and winding repeats, in O(1)
    /// time.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut repair = Repair::new(sequence, &strips, RepairOptions::default())?;
    /// assert_eq!(repair.vertices_sent(), 5);
    /// repair.set_level(0)?;
    /// assert_eq!(repair.vertices_sent(), 3);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn vertices_sent(&self) -> usize {
        self.repaired.vertices_sent(self.triangle_count)
    }

    /// Moves to the next coarser level. Returns `false` at the base mesh.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut repair = Repair::new(sequence, &strips, RepairOptions::default())?;
    /// let mut sent = Vec::new();
    /// while repair.coarsen() {
    ///     sent.push(repair.vertices_sent());
    /// }
    /// assert_eq!(sent, [4, 3]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn coarsen(&mut self) -> bool {
        let Some(level) = self.level.checked_sub(1) else { return false };
        self.collapse_to(level);
        self.level = level;
        true
    }

    /// Applies the collapse that leads to a level, whatever the current level. All collapses that
    /// it depends on must be applied.
    pub(super) fn collapse_to(&mut self, level: usize) {
        self.display = None;
        let sequence = Arc::clone(&self.sequence);
        let collapse = sequence.collapse_to(level);
        self.gaps.clear();
        for &t in collapse.dropped {
            self.cut_out(t);
        }
        self.pairing.release_for_collapse(&collapse, &self.mesh, &self.repaired.paths);
        self.mesh.collapse(&collapse);
        collapse.dropped.iter().for_each(|&t| self.repaired.paths.remove_triangle(t));
        let gaps = std::mem::take(&mut self.gaps);
        self.pair_around(collapse.renames.iter().map(|rename| rename.kept));
        for &[a, b] in &gaps {
            if self.repaired.paths.twin(a) == Some(b) {
                self.join(a);
            }
        }
        self.gaps = gaps;
        self.triangle_count -= collapse.dropped.len();
        self.search(collapse.renames.iter().map(|rename| rename.kept));
    }

    /// Moves to the next finer level. Returns `false` at the full mesh.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut repair = Repair::new(sequence, &strips, RepairOptions::default())?;
    /// assert!(!repair.refine());
    /// assert!(repair.coarsen() && repair.refine());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn refine(&mut self) -> bool {
        if self.level == self.sequence.len() {
            return false;
        }
        self.split_from(self.level);
        self.level += 1;
        true
    }

    /// Undoes the collapse that leads to a level, whatever the current level. No applied collapse
    /// may depend on it.
    pub(super) fn split_from(&mut self, level: usize) {
        self.display = None;
        let sequence = Arc::clone(&self.sequence);
        let collapse = sequence.collapse_to(level);
        let vertices = || collapse.renames.iter().flat_map(|rename| [rename.kept, rename.removed]);
        self.mesh.split(&collapse);
        collapse.dropped.iter().for_each(|&t| self.repaired.paths.insert_triangle(t));
        self.pairing.release_for_split(&collapse, &self.mesh, &self.repaired.paths);
        self.gaps.clear();
        self.pair_around(vertices());
        let gaps = std::mem::take(&mut self.gaps);
        for &gap in &gaps {
            if let [Some(a), Some(b)] = gap.map(|h| self.repaired.paths.twin(h))
                && a / 4 == b / 4
                && collapse.dropped.binary_search(&(a / 4)).is_ok()
            {
                gap.into_iter().for_each(|h| self.join(h));
            }
        }
        self.gaps = gaps;
        self.triangle_count += collapse.dropped.len();
        self.search(vertices());
    }

    /// Cuts the links of a triangle and records the gap between two former neighbours.
    fn cut_out(&mut self, t: u32) {
        let links = [0, 1, 2].map(|e| {
            (self.repaired.paths.mask(t) >> e & 1 == 1).then(|| self.repaired.paths.across(4 * t + e))
        });
        let mut links = links.into_iter().flatten();
        if let (Some(a), b) = (links.next(), links.next()) {
            self.repaired.paths.cut(a);
            if let Some(b) = b {
                self.repaired.paths.cut(b);
                self.gaps.push([a, b]);
            }
        }
    }

    /// Pairs the released half-edges around vertices, cuts links whose edge no longer exists, and
    /// records the gaps.
    fn pair_around(&mut self, vertices: impl Iterator<Item = u32>) {
        self.changes.clear();
        self.pairing.pair_around(vertices, &self.mesh, &self.repaired.paths, &mut self.changes);
        self.apply_changes();
    }

    /// Sets the new twins of half-edges, cuts their links and records the gaps.
    fn apply_changes(&mut self) {
        let paths = &mut self.repaired.paths;
        for &(h, _) in &self.changes {
            if paths.mask(h / 4) >> (h % 4) & 1 == 1 {
                self.gaps.push([h, paths.across(h)]);
                paths.cut(h);
            }
        }
        self.changes.iter().for_each(|&(h, twin)| paths.set_twin(h, twin));
    }

    /// Links two triangles across a half-edge, unless one of them is inside a path or the link
    /// would close a cycle.
    fn join(&mut self, h: u32) {
        if [h, self.repaired.paths.across(h)].iter().all(|h| self.repaired.paths.degree(h / 4) < 2) {
            self.repaired.paths.join(h);
        }
    }

    /// Runs local searches near vertices.
    fn search(&mut self, vertices: impl Iterator<Item = u32>) {
        let corners = vertices.flat_map(|v| self.mesh.around(v));
        self.repaired.find_near(corners.map(|corner| corner / 3), self.work.near);
        let most = walk_steps(self.work.rounds, self.work.near);
        self.repaired.paths.allow_more_walks(most / AVERAGE_SHARE, most);
        self.repaired.search_near(self.work.rounds, |_, _| true);
    }

    /// Builds the strips of the level, in O(n) time.
    pub(super) fn emit(&self) -> Strips {
        self.repaired.emit(|t| self.mesh.is_drawn(t).then(|| self.mesh.triangle(t)))
    }
}

impl LevelCursor for Repair {
    fn levels(&self) -> &LevelTable {
        &self.levels
    }

    fn level(&self) -> usize {
        self.level
    }

    /// Moves to a level step by step, because the strips depend on the levels on the way.
    fn set_level(&mut self, level: usize) -> Result<(), Error> {
        self.levels.check(level)?;
        while self.level > level && self.coarsen() {}
        while self.level < level && self.refine() {}
        Ok(())
    }

    fn strips(&mut self) -> &Strips {
        let display = self.display.take().unwrap_or_else(|| self.emit());
        self.display.insert(display)
    }

    fn memory(&self) -> usize {
        self.mesh.memory()
            + self.pairing.memory()
            + self.repaired.memory()
            + self.display.as_ref().map_or(0, Strips::memory)
    }
}
