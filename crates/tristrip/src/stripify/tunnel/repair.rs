//! Repair: joins what a local change of the mesh has left in pieces, by tunnels near the change only.
//!
//! A collapse or a split of an edge takes a few links away, and each leaves two ends more. The strips elsewhere are as good as they were,
//! so that it is enough to search from those ends.
//!
//! # Algorithm
//! For each terminal at or beside a changed triangle, in turn, until none finds anything:
//! 1. Take the triangles within some steps of it, its k-star. Where no other strip has a terminal there, that was all.
//! 2. Tag the strips inside with what they are as a whole: two parts of a strip that is connected outside have one tag, as if a temporary
//!    edge joined them.
//! 3. Search a tunnel as `eta` does, within the star, and complement it.
//!
//! The strips as a whole are known from a tree each, which follows the changes (see the module `order`). Without it, ends of
//! strips too long to be walked along could not be joined, for they might be the two ends of one: measured with walks of 64 steps, a grid
//! of one strip had 18 after 300 collapses, with it 13.
//!
//! # References
//! Porcu, Sanna, Scateni: *Efficiently Keeping an Optimal Stripification over a CLOD Mesh*, 2005, which repairs by rules for
//! each kind of change and then by tunnels; here it is tunnels alone. The star is that of the authors' paper of 2006, section 4.1.
//!
//! # Complexity
//! A number of questions for each changed triangle that depends on the effort, not on the mesh, each in O(log n) time; 41 bytes a
//! triangle, which are kept from call to call.

use super::eta::{Limits, Search};
use super::ids::{Ids, NONE, complement};
use super::order::Order;
use super::star::{Place, Star};
use super::{Searched, Tally};
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::effort::Effort;
use crate::ids::FaceId;
use crate::random::Random;

/// How far a repair looks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reach {
    /// Steps from a terminal to the rim of its star.
    pub(super) radius: u32,
    /// Accesses to nodes of a search.
    pub(super) threshold: u32,
}

impl Reach {
    /// At level 5 a star has some hundred triangles.
    fn of(effort: Effort) -> Self {
        let level = u32::from(effort.level());
        Self { radius: 3 + level, threshold: 16 * (level + 1) }
    }
}

/// Times that the terminals are gone over again, for a tunnel may open another.
const PASSES: usize = 3;

/// What a repair has done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Repaired {
    /// Strips joined, by which the cover has fewer.
    pub joined: usize,
    /// Accesses to triangles: the work.
    pub accesses: u64,
}

/// Repairs path covers after local changes, and keeps its buffers from call to call.
///
/// ```
/// use tristrip::{DualGraph, FaceId, Faces, HalfEdge, PathCover};
/// use tristrip::stripify::{Effort, tunnel::Repairer};
/// let graph = DualGraph::new(&Faces::from_triangles(vec![0, 1, 2, 2, 1, 3])?);
/// let mut cover = PathCover::isolated(2);
/// cover.join(&graph, HalfEdge(1));
/// let mut repairer = Repairer::new(&graph, &cover);
/// cover.cut(&graph, HalfEdge(1));
/// let repaired = repairer.repair(&graph, &mut cover, &[FaceId(0)], Effort::default());
/// assert_eq!((repaired.joined, cover.path_count()), (1, 1));
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug)]
pub struct Repairer {
    order: Order,
    ids: Ids,
    star: Star,
    search: Search,
    /// The triangles of a star, in the order of their steps from the terminal.
    ball: Vec<u32>,
    /// The triangles to search from.
    starts: Vec<u32>,
}

impl Repairer {
    /// Prepares for repairs of a cover, in O(n) time.
    pub fn new(graph: &DualGraph, cover: &PathCover) -> Self {
        let (star, search) = (Star::default(), Search::default());
        let (ball, starts) = (Vec::new(), Vec::new());
        Self { order: Order::new(graph, cover), ids: Ids::of_parts(), star, search, ball, starts }
    }

    /// Joins strips near triangles that have changed: all whose links are not what they were after the last repair, and those where
    /// it may be worth while, because they have other neighbours. The cover must be one of the graph as it is now. Triangles keep
    /// their numbers; new ones come last, and one that is no more in use has no neighbours.
    pub fn repair(
        &mut self,
        graph: &DualGraph,
        cover: &mut PathCover,
        changed: &[FaceId],
        effort: Effort,
    ) -> Repaired {
        self.repair_within(graph, cover, changed, Reach::of(effort))
    }

    /// See [`Repairer::repair`].
    pub(super) fn repair_within(
        &mut self,
        graph: &DualGraph,
        cover: &mut PathCover,
        changed: &[FaceId],
        reach: Reach,
    ) -> Repaired {
        let mut repaired = Repaired::default();
        if graph.half_edge_count() != 3 * cover.len() {
            return repaired;
        }
        let strips = cover.path_count();
        let mut tally = Tally::new(&());
        let known = changed.iter().map(|face| face.0).filter(|&t| (t as usize) < cover.len());
        self.order.grow(cover.len());
        self.order.follow(graph, cover, known.clone());
        self.find_starts(graph, cover, known);
        for _ in 0..PASSES {
            let before = cover.path_count();
            for i in 0..self.starts.len() {
                while self.join(graph, cover, self.starts[i], reach, &mut tally) {}
            }
            if cover.path_count() == before {
                break;
            }
        }
        repaired.joined = strips - cover.path_count();
        repaired.accesses = tally.accesses;
        repaired
    }

    /// Finds the terminals at and beside the changed triangles.
    fn find_starts(&mut self, graph: &DualGraph, cover: &PathCover, changed: impl Iterator<Item = u32>) {
        self.starts.clear();
        self.ids.begin_part(cover.len());
        for face in changed.map(FaceId) {
            for t in graph.neighbours(face).chain([face]) {
                if self.ids.enter(t.0) && cover.degree(t) < 2 {
                    self.starts.push(t.0);
                }
            }
        }
    }

    /// Searches from a triangle and complements what it finds. Returns whether it found a tunnel.
    fn join(
        &mut self,
        graph: &DualGraph,
        cover: &mut PathCover,
        start: u32,
        reach: Reach,
        tally: &mut Tally<'_>,
    ) -> bool {
        if cover.degree(FaceId(start)) == 2 || !self.find_ball(graph, cover, start, reach.radius) {
            return false;
        }
        tally.accesses += self.ball.len() as u64;
        self.ids.tag_part(graph, cover, &mut self.order, &self.ball);
        let place = Place { graph, cover, ids: &self.ids };
        let limit = 2 * reach.radius + 1;
        let limits = Limits { limit, threshold: reach.threshold, loops: 0 };
        if !self.star.find(&place, start, limit, tally) {
            return false;
        }
        let mut random = Random::new(u64::from(start));
        let searched = self.search.tunnel(&place, &self.star, start, limits, &mut random, tally);
        if searched == Searched::Found {
            let steps = &self.search.steps;
            complement(graph, cover, steps);
            let edges = steps.iter().flat_map(|step| [step.red, step.black]).filter(|&h| h != NONE);
            let changed = edges.flat_map(|h| [h / 3, graph.twins()[h as usize] / 3]);
            self.order.follow(graph, cover, changed);
        }
        searched == Searched::Found
    }

    /// Finds the triangles around a terminal. Returns whether there is another terminal, and no link that is not known on both sides.
    fn find_ball(&mut self, graph: &DualGraph, cover: &PathCover, start: u32, radius: u32) -> bool {
        self.ids.begin_part(cover.len());
        self.ball.clear();
        self.ids.enter(start);
        self.ball.push(start);
        let (mut ring, mut is_alone) = (0..1, true);
        for _ in 0..radius {
            for i in ring.clone() {
                for t in graph.neighbours(FaceId(self.ball[i])) {
                    if self.ids.enter(t.0) {
                        self.ball.push(t.0);
                        is_alone &= cover.degree(t) == 2;
                    }
                }
            }
            ring = ring.end..self.ball.len();
        }
        let mut links = self.ball.iter().flat_map(|&t| cover.edges(FaceId(t))).flatten();
        !is_alone && links.all(|link| graph.twin(link).is_some_and(|twin| cover.is_linked(twin)))
    }
}
