//! `repair`: our filter. Display strips for every level that cost about what strips made anew for that level would.
//!
//! The other filters take the vertices of the full mesh's strips as the renaming leaves them, and take out what draws nothing. So
//! their strips fall to pieces as the mesh gets coarser: where a strip is cut, its ends stay where they are. This one keeps the
//! strips as paths over the triangles that a level draws, follows each collapse and each split, and mends the paths beside it.
//!
//! ```text
//!          x                    x
//!   ━ u ━╱━━━╲━ v ━      ━ u ━╱━ v ━       a path through a dropped triangle d is linked where d was
//!      ╱   d   ╲             ╱
//!   kept ──── removed     kept             a path over the edge of the two is cut; dives near it find its ends another way
//! ```
//! # Algorithm
//! *Coarsen*:
//! 1. Cut what is linked to the dropped triangles, rename, drop, and find anew who shares an edge with whom around the kept vertex.
//! 2. Link the two neighbours of a dropped triangle that was linked to both, if they share an edge now.
//! 3. *Search*: take the triangles nearest to the kept vertex, as many as the effort says; start a dive from each, in turn, as often
//!    as the effort says. A dive changes a few links, and is undone if strips cost more then (see `stripify/refine/dive.rs`).
//!
//! *Refine*: the same from the end to the beginning, around both vertices; a triangle that comes back is linked to the two between which it
//! comes, if they were linked.
//!
//! *At a level* at once: drop all that the level does not draw, link triangles of one strip with nothing drawn between them that share an edge,
//! as the filters do, then dive from all triangles.
//!
//! Who shares an edge with whom where more than two triangles meet is told in the module `surface`.
//!
//! # What it depends on
//! The strips of a level depend on the levels passed on the way and on nothing else: the same steps give the same strips, but
//! coarsening and refining again does not give the strips that were there before. Both draw the same triangles.
//!
//! # Effort
//! The bunny of 69,451 triangles, simplified to a twentieth of them in 33,042 collapses, with strips of the full mesh by `best` (36.7 % of
//! three vertices a triangle): what all levels send, and what the base mesh does, in percent of three vertices a triangle; the time of a
//! collapse on one core. Strips made anew for each level by `best` at its usual effort send 39.2 %; at the base mesh, `Dtfs` sends 99.6 % and
//! `Linked` 82.5 %.
//!
//! | level | 0 | 1 | 2 | 3 | 4 | 5 | 6 | 7 |
//! |---|---|---|---|---|---|---|---|---|
//! | all levels, % | 41.4 | 40.8 | 40.4 | 39.9 | 39.7 | 39.5 | 39.5 | 39.3 |
//! | base mesh, % | 45.6 | 44.0 | 43.3 | 42.1 | 41.6 | 41.2 | 41.1 | 40.9 |
//! | microseconds | 2 | 3 | 5 | 12 | 21 | 42 | 70 | 150 |
//!
//! Levels 8 and 9 take about twice and five times as long as 7. Made at once, 40 % of the triangles take 44.2, 40.9 and 40.5 % at levels 1, 3 and 5,
//! in 0.03, 0.1 and 0.5 s; level 0 searches nothing then, and sends what `Linked` does, 55.0 %.
//!
//! # References
//! Stewart: *Tunneling for Triangle Strips in Continuous Level-of-Detail Meshes*, 2001; Porcu, Sanna, Scateni: *Efficiently Keeping an
//! Optimal Stripification over a CLOD Mesh*, 2005 (repair beside each change, by tunnels); Kim, Park, Yang, Neelamkavil: *A Rendering-Efficient
//! Progressive Transmission of 3D Meshes*, 2005 (the filter that it starts from); Lin, Kernighan: *An Effective Heuristic
//! Algorithm for the Traveling-Salesman Problem*, 1973 (chains of changes that are undone where they do not pay).
//!
//! # Complexity
//! A step takes time by the effort and by the valence of the vertices that it names, not by the size of the mesh, but for cuts, which walk to
//! the nearer end of their path. 56 bytes a triangle of the full mesh and 8 a vertex.

#[cfg(test)]
mod tests;

use super::level_mesh::LevelMesh;

use crate::collapse::CollapseSequence;
use crate::cover::PathCover;
use crate::cover::local_search::LocalSearch;
use crate::cover::priced::{PricedPaths, TRIANGLE_LIMIT};
use crate::dual::DualGraph;
use crate::dual::Triangulation;
use crate::effort::Effort;
use crate::error::Error;
use crate::mesh::canonical_triangle;
use crate::strip::{Cost, Strips, emit, strip_triangles};

/// How much is done beside a change, and everywhere where a level is made at once.
#[derive(Debug, Clone, Copy)]
struct Work {
    /// Triangles beside a change to dive from.
    near: usize,
    /// Dives from each of them.
    rounds: u32,
    /// Dives from each triangle of a level.
    all_rounds: u32,
}

/// By effort. Tuned on the bunny.
const WORK: [Work; 10] = [
    Work { near: 6, rounds: 1, all_rounds: 0 },
    Work { near: 12, rounds: 1, all_rounds: 1 },
    Work { near: 24, rounds: 1, all_rounds: 4 },
    Work { near: 40, rounds: 2, all_rounds: 12 },
    Work { near: 80, rounds: 2, all_rounds: 36 },
    Work { near: 120, rounds: 3, all_rounds: 100 },
    Work { near: 160, rounds: 4, all_rounds: 200 },
    Work { near: 240, rounds: 6, all_rounds: 400 },
    Work { near: 400, rounds: 6, all_rounds: 800 },
    Work { near: 640, rounds: 8, all_rounds: 1600 },
];

/// How a repair searches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct RepairOptions {
    effort: Effort,
    seed: u64,
    cost: Cost,
}

/// Usual effort, seed 0, and the vertices sent as the cost.
impl Default for RepairOptions {
    fn default() -> Self {
        Self { effort: Effort::default(), seed: 0, cost: Cost::OpenGl }
    }
}

impl RepairOptions {
    /// Sets how much is done beside each change. At level 0 least is done, and strips made for a level
    /// at once are not searched.
    #[must_use]
    pub fn with_effort(mut self, effort: Effort) -> Self {
        self.effort = effort;
        self
    }

    /// Sets the seed of the random choices.
    #[must_use]
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// Sets what is minimized: the vertices sent, or with [`Cost::Restart`] and [`Cost::Degenerate`] also an index between strips.
    /// [`Cost::Gl`] is taken for the vertices sent.
    #[must_use]
    pub fn with_cost(mut self, cost: Cost) -> Self {
        self.cost = if cost == Cost::Gl { Cost::OpenGl } else { cost };
        self
    }
}

/// The strips of a level of detail, which follow collapses and splits.
///
/// ```
/// use tristrip::{CollapseSequence, Strips, collapse::Rename, lod::{Repair, RepairOptions}};
/// // A strip of four triangles over two rows of vertices; 1 collapses to 0, which drops the first triangle.
/// let mut strips = Strips::default();
/// strips.push(&[0, 1, 2, 3, 4, 5]);
/// let rename = [Rename { removed: 1, kept: 0 }];
/// let triangles = strips.triangles().flatten().collect();
/// let sequence = CollapseSequence::from_collapses(6, triangles, [(&rename[..], 0.5)])?;
/// let mut repair = Repair::new(&sequence, &strips, RepairOptions::default())?;
/// assert_eq!((repair.level(), repair.vertices_sent()), (1, 6));
/// assert!(repair.coarsen());
/// assert_eq!((repair.level(), repair.strips().vertices()), (0, &[5, 4, 3, 2, 0][..]));
/// assert!(repair.refine());
/// assert_eq!(repair.vertices_sent(), 6);
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Repair<'a> {
    sequence: &'a CollapseSequence,
    level: usize,
    triangle_count: usize,
    surface: LevelMesh,
    paths: PricedPaths,
    local_search: LocalSearch,
    work: Work,
    /// Half-edges whose other sides change, and those that come in their place.
    changes: Vec<(u32, Option<u32>)>,
    /// Pairs of half-edges between which a link has gone.
    gaps: Vec<[u32; 2]>,
    near: Near,
}

impl<'a> Repair<'a> {
    /// Takes over the strips of the full mesh, as they are.
    ///
    /// # Errors
    /// The strips do not draw the triangles of the full mesh, each once with its winding, or these are too many.
    pub fn new(
        sequence: &'a CollapseSequence,
        strips: &Strips,
        options: RepairOptions,
    ) -> Result<Self, Error> {
        Self::start(sequence, strips, sequence.len(), options)
    }

    /// Makes display strips of the strips of the full mesh for one level at once.
    ///
    /// # Errors
    /// As [`Repair::new`], or there is no such level.
    ///
    /// ```
    /// # use tristrip::{CollapseSequence, Strips, collapse::Rename, lod::{Repair, RepairOptions}};
    /// # let mut strips = Strips::default();
    /// # strips.push(&[0, 1, 2, 3, 4, 5]);
    /// # let rename = [Rename { removed: 1, kept: 0 }];
    /// # let triangles = strips.triangles().flatten().collect();
    /// # let sequence = CollapseSequence::from_collapses(6, triangles, [(&rename[..], 0.5)])?;
    /// let repair = Repair::at(&sequence, &strips, 0, RepairOptions::default())?;
    /// assert_eq!(repair.strips().vertices(), [5, 4, 3, 2, 0]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn at(
        sequence: &'a CollapseSequence,
        strips: &Strips,
        level: usize,
        options: RepairOptions,
    ) -> Result<Self, Error> {
        if level > sequence.len() {
            return Err(Error::Parameter {
                name: "level",
                found: format!("{level} of {} levels", sequence.len()),
                expected: "a level that there is",
            });
        }
        let mut repair = Self::start(sequence, strips, level, options)?;
        let all: Vec<u32> = (0..repair.paths.len() as u32).filter(|&t| repair.surface.is_drawn(t)).collect();
        for _ in 0..repair.work.all_rounds {
            all.iter().for_each(|&t| repair.local_search.improve_at(&mut repair.paths, t));
        }
        Ok(repair)
    }

    /// Links what is left of the strips at a level, without a search.
    fn start(
        sequence: &'a CollapseSequence,
        strips: &Strips,
        level: usize,
        options: RepairOptions,
    ) -> Result<Self, Error> {
        check_size(sequence)?;
        let mut surface = LevelMesh::new(sequence);
        let order = order_of(strips, &surface)?;
        (level..sequence.len()).rev().for_each(|level| surface.collapse(&sequence.collapse(level)));
        let slots = surface.triangle_count();
        let mut repair = Self {
            sequence,
            level,
            triangle_count: 0,
            surface,
            paths: PricedPaths::empty(slots, options.cost.prices()),
            local_search: LocalSearch::new(options.seed),
            work: WORK[usize::from(options.effort.level())],
            changes: Vec::new(),
            gaps: Vec::new(),
            near: Near { marks: vec![0; slots], ..Near::default() },
        };
        for t in 0..slots as u32 {
            if repair.surface.is_drawn(t) {
                repair.triangle_count += 1;
                repair.paths.insert_triangle(t);
            }
        }
        repair.link_neighbours(&order);
        let mut is_named = vec![true; sequence.vertex_count()];
        let renames = (level..sequence.len()).flat_map(|level| sequence.collapse(level).renames);
        renames.for_each(|rename| is_named[rename.removed as usize] = false);
        for v in (0..).zip(is_named).filter_map(|(v, is_named)| is_named.then_some(v)) {
            repair.pair_around([v]);
        }
        Ok(repair)
    }

    /// Links triangles that follow each other in a strip, those not drawn left out, where they share an edge.
    fn link_neighbours(&mut self, order: &[Place]) {
        let mut last: Option<Place> = None;
        for &place in order.iter().filter(|place| self.surface.is_drawn(place.triangle)) {
            if let Some(before) = last.filter(|last| last.strip == place.strip) {
                let shared = self.surface.shared(before.triangle, place.triangle);
                let free = shared.filter(|sides| sides.iter().all(|&h| self.paths.twin(h).is_none()));
                if let Some([a, b]) = free.min_by_key(|&[_, side]| side != place.entry) {
                    self.paths.set_twin(a, Some(b));
                    self.paths.set_twin(b, Some(a));
                    self.paths.join(a);
                }
            }
            last = Some(place);
        }
    }

    /// Gives the level that is drawn.
    pub fn level(&self) -> usize {
        self.level
    }

    /// Counts the triangles that are drawn.
    pub fn triangle_count(&self) -> usize {
        self.triangle_count
    }

    /// Counts the strips.
    pub fn strip_count(&self) -> usize {
        self.paths.strip_count()
    }

    /// Counts the vertices of all strips, swaps and winding repeats included, in O(1) time.
    pub fn vertices_sent(&self) -> usize {
        // What is known is the cost, in which strips have another price.
        let strips = self.strip_count().cast_signed() as i64;
        let beyond = self.paths.cost() - strips * i64::from(self.paths.prices().strip - 2);
        self.triangle_count + usize::try_from(beyond).unwrap_or(0)
    }

    /// Goes to the next coarser level; `false` where there is none.
    pub fn coarsen(&mut self) -> bool {
        let Some(level) = self.level.checked_sub(1) else { return false };
        let collapse = self.sequence.collapse(level);
        self.gaps.clear();
        for &t in collapse.dropped {
            self.cut_out(t);
        }
        self.surface.collapse(&collapse);
        collapse.dropped.iter().for_each(|&t| self.paths.remove_triangle(t));
        let gaps = std::mem::take(&mut self.gaps);
        self.pair_around(collapse.renames.iter().map(|rename| rename.kept));
        for &[a, b] in &gaps {
            if self.paths.twin(a) == Some(b) {
                self.join(a);
            }
        }
        self.gaps = gaps;
        (self.level, self.triangle_count) = (level, self.triangle_count - collapse.dropped.len());
        self.search(collapse.renames.iter().map(|rename| rename.kept));
        true
    }

    /// Goes to the next finer level; `false` where there is none.
    pub fn refine(&mut self) -> bool {
        if self.level == self.sequence.len() {
            return false;
        }
        let collapse = self.sequence.collapse(self.level);
        let vertices = || collapse.renames.iter().flat_map(|rename| [rename.kept, rename.removed]);
        self.surface.split(&collapse);
        collapse.dropped.iter().for_each(|&t| self.paths.insert_triangle(t));
        self.gaps.clear();
        self.pair_around(vertices());
        let gaps = std::mem::take(&mut self.gaps);
        for &gap in &gaps {
            if let [Some(a), Some(b)] = gap.map(|h| self.paths.twin(h))
                && a / 4 == b / 4
                && collapse.dropped.contains(&(a / 4))
            {
                gap.into_iter().for_each(|h| self.join(h));
            }
        }
        self.gaps = gaps;
        (self.level, self.triangle_count) = (self.level + 1, self.triangle_count + collapse.dropped.len());
        self.search(vertices());
        true
    }

    /// Goes to a level step by step, or to the full mesh where there is no such level.
    pub fn go_to(&mut self, level: usize) {
        while self.level > level && self.coarsen() {}
        while self.level < level && self.refine() {}
    }

    /// Cuts what is linked to a triangle; where that is two others, there is a gap between them.
    fn cut_out(&mut self, t: u32) {
        let links =
            [0, 1, 2].map(|e| (self.paths.mask(t) >> e & 1 == 1).then(|| self.paths.across(4 * t + e)));
        let mut links = links.into_iter().flatten();
        if let (Some(a), b) = (links.next(), links.next()) {
            self.paths.cut(a);
            if let Some(b) = b {
                self.paths.cut(b);
                self.gaps.push([a, b]);
            }
        }
    }

    /// Finds anew who shares an edge with whom around vertices; cuts the links that have lost theirs, and notes the gaps.
    fn pair_around(&mut self, vertices: impl IntoIterator<Item = u32>) {
        let (paths, changes) = (&mut self.paths, &mut self.changes);
        changes.clear();
        for v in vertices {
            let note = |h, twin| {
                if paths.twin(h) != twin {
                    changes.push((h, twin));
                }
            };
            self.surface.sides_around(v, |h| paths.twin(h), note);
        }
        for &(h, _) in &*changes {
            if paths.mask(h / 4) >> (h % 4) & 1 == 1 {
                self.gaps.push([h, paths.across(h)]);
                paths.cut(h);
            }
        }
        changes.iter().for_each(|&(h, twin)| paths.set_twin(h, twin));
    }

    /// Links two triangles over a half-edge, if neither is inside a path and it does not close one.
    fn join(&mut self, h: u32) {
        if [h, self.paths.across(h)].iter().all(|h| self.paths.degree(h / 4) < 2) {
            self.paths.join(h);
        }
    }

    /// Searches near vertices.
    fn search(&mut self, vertices: impl Iterator<Item = u32>) {
        let corners = vertices.flat_map(|v| self.surface.around(v));
        self.near.find(&self.paths, corners.map(|corner| corner / 3), self.work.near);
        for _ in 0..self.work.rounds {
            self.near.triangles.iter().for_each(|&t| self.local_search.improve_at(&mut self.paths, t));
        }
    }

    /// Makes the strips that are drawn, in O(n) time.
    pub fn strips(&self) -> Strips {
        // Numbered without those that are not drawn.
        let mut number = vec![0; self.surface.triangle_count()];
        let (mut corners, mut drawn) = (Vec::new(), Vec::new());
        for t in (0..number.len() as u32).filter(|&t| self.surface.is_drawn(t)) {
            number[t as usize] = drawn.len() as u32;
            drawn.push(t);
            corners.extend(self.surface.triangle(t));
        }
        let mut twins = Vec::with_capacity(corners.len());
        let mut cover = PathCover::isolated(drawn.len());
        for (&t, i) in drawn.iter().zip(0..) {
            for e in 0..3 {
                let twin = self.paths.twin(4 * t + e);
                let there = twin.map(|twin| 3 * number[twin as usize / 4] + twin % 4);
                twins.push(there);
                if let (Some(twin), Some(there)) = (twin, there)
                    && self.paths.mask(t) >> e & 1 == 1
                    && 4 * t + e < twin
                {
                    cover.link_unchecked(3 * i + e, there);
                }
            }
        }
        emit(&Triangulation::from_parts(corners, DualGraph::of_triangle_twins(twins)), &cover)
    }
}

/// The triangles near a change, breadth first.
#[derive(Debug, Clone, Default)]
struct Near {
    triangles: Vec<u32>,
    /// For each triangle the last search that has come to it.
    marks: Vec<u32>,
    search: u32,
}

impl Near {
    /// Finds the triangles nearest to those of the start, these included, up to a number.
    fn find(&mut self, paths: &PricedPaths, start: impl Iterator<Item = u32>, most: usize) {
        self.search = self.search.wrapping_add(1);
        self.triangles.clear();
        start.for_each(|t| self.add(t));
        let mut seen = 0;
        while seen < self.triangles.len() && self.triangles.len() < most {
            let t = self.triangles[seen];
            (0..3).filter_map(|e| paths.twin(4 * t + e)).for_each(|h| self.add(h / 4));
            seen += 1;
        }
        self.triangles.truncate(most);
    }

    fn add(&mut self, t: u32) {
        if std::mem::replace(&mut self.marks[t as usize], self.search) != self.search {
            self.triangles.push(t);
        }
    }
}

/// Checks that corners and vertices can be numbered together.
fn check_size(sequence: &CollapseSequence) -> Result<(), Error> {
    let (triangles, vertices) = (sequence.triangles().len() / 3, sequence.vertex_count());
    let over = |what, found: usize, limit: usize| {
        if found <= limit {
            Ok(())
        } else {
            Err(Error::LimitExceeded { what, found: found as u64, limit: limit as u64 })
        }
    };
    over("triangles", triangles, TRIANGLE_LIMIT)?;
    over("corners and vertices", 3 * triangles + vertices, u32::MAX as usize - 1)
}

/// A triangle of the full mesh in a strip.
#[derive(Debug, Clone, Copy, Default)]
struct Place {
    strip: u32,
    triangle: u32,
    /// The half-edge over which the strip comes, by fours.
    entry: u32,
}

/// Gives the triangles of the full mesh in the order in which strips draw them.
fn order_of(strips: &Strips, surface: &LevelMesh) -> Result<Vec<Place>, Error> {
    let mut known: Vec<([u32; 3], u32)> = (0..surface.triangle_count() as u32)
        .filter(|&t| surface.is_drawn(t))
        .map(|t| (canonical_triangle(surface.triangle(t)), t))
        .collect();
    known.sort_unstable();
    let drawn = strips.iter().zip(0..).flat_map(|(strip, s)| strip_triangles(strip).map(move |t| (t, s)));
    let mut drawn: Vec<([u32; 3], usize, u32, u32)> = drawn
        .enumerate()
        .map(|(i, (triangle, s))| (canonical_triangle(triangle), i, s, triangle[0]))
        .collect();
    drawn.sort_unstable();
    if !known.iter().map(|known| known.0).eq(drawn.iter().map(|drawn| drawn.0)) {
        return Err(Error::Parameter {
            name: "strips",
            found: format!("{} triangles, not all of the full mesh", drawn.len()),
            expected: "strips that draw the full mesh",
        });
    }
    let mut order = vec![Place::default(); known.len()];
    for (&(_, i, strip, first), &(_, t)) in drawn.iter().zip(&known) {
        let entry = (4 * t..).zip(surface.triangle(t)).find(|&(_, v)| v == first).map_or(4 * t, |(h, _)| h);
        order[i] = Place { strip, triangle: t, entry };
    }
    Ok(order)
}
