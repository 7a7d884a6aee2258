//! The path cover: disjoint simple paths over the dual graph of triangles, one path per strip.
//!
//! Each triangle stores which of its three edges link it to its neighbours on the path. The links
//! of a triangle take one byte. Links have no direction, so they stay valid when paths are cut or
//! joined.
//!
//! ```text
//!   ●━━●━━●  ○   ●━━●      three paths: six nodes, three links, four ends and an isolated triangle
//! ```
//!
//! # References
//! Stewart: *Tunneling for Triangle Strips in Continuous Level-of-Detail Meshes*, 2001 (the cover
//! as red and black edges); Pósa: *Hamiltonian circuits in random graphs*, 1976 (rotations).
//!
//! # Complexity
//! 1 byte per triangle. Linking and cutting take O(1) time. Joining and rotating take O(length of
//! the affected paths). Numbering the paths takes O(n) time and 8 bytes per triangle.

mod diagonals;
pub(crate) mod local_search;
pub(crate) mod moves;
pub(crate) mod priced;

use crate::dual::DualGraph;
use crate::ids::{FaceId, HalfEdge};

/// The two bits that represent a missing link.
const FREE: u8 = 3;

/// Disjoint paths over the triangles of a dual graph. Each path becomes a strip.
///
/// ```
/// use tristrip::{DualGraph, Faces, Mesh, PreparedFaces, StripifyOptions, stripify::plan};
/// let mesh = Mesh::new(vec![[0.0; 3]; 7], Faces::from_triangles(vec![0, 1, 2, 2, 1, 3, 4, 5, 6])?)?;
/// let prepared = PreparedFaces::new(&mesh, false);
/// let graph = DualGraph::new(prepared.faces());
/// let plan = plan(&prepared, &graph, &StripifyOptions::default())?;
/// assert_eq!((plan.cover().len(), plan.cover().path_count()), (3, 2));
/// assert_eq!(plan.cover().check(plan.triangulation().graph()), Ok(()));
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PathCover {
    /// Bits 0–1 and 2–3: the linked edges, or `FREE`.
    links: Vec<u8>,
    link_count: usize,
}

/// A violated invariant of a cover.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CoverFault {
    /// The cover does not have one node per triangle of the graph.
    #[error("the cover does not have one node per triangle of the graph")]
    Size,
    /// A link crosses a boundary.
    #[error("a link crosses a boundary at {0:?}")]
    NoTwin(HalfEdge),
    /// A link is stored on one side only, or twice in one triangle.
    #[error("a link is stored on one side only, or twice, at {0:?}")]
    OneSided(HalfEdge),
    /// The path through this triangle is closed.
    #[error("the path through {0:?} is closed")]
    Cycle(FaceId),
    /// The number of links differs from the stored count.
    #[error("the number of links differs from the stored count")]
    Count,
}

/// The path of each triangle and its position on that path.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Numbering {
    /// The path of each triangle. Paths are numbered in order of their lowest triangles.
    pub(crate) path: Vec<u32>,
    /// The position of each triangle on its path, from the path's first end.
    pub(crate) position: Vec<u32>,
    /// The first triangle of each path.
    pub(crate) first: Vec<FaceId>,
}

impl PathCover {
    /// Creates a cover in which every triangle is a path of its own.
    ///
    /// ```
    /// use tristrip::PathCover;
    /// assert_eq!(PathCover::isolated(3).path_count(), 3);
    /// ```
    pub fn isolated(triangle_count: usize) -> Self {
        Self { links: vec![FREE | FREE << 2; triangle_count], link_count: 0 }
    }

    /// Counts the triangles.
    ///
    /// ```
    #[doc = include_str!("dual/example.txt")]
    /// assert_eq!(plan.cover().len(), 3);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn len(&self) -> usize {
        self.links.len()
    }

    /// Returns whether there are no triangles.
    ///
    /// ```
    #[doc = include_str!("dual/example.txt")]
    /// let nothing = Mesh::default();
    /// let nothing = PreparedFaces::new(&nothing, false);
    /// let graph = DualGraph::new(nothing.faces());
    /// let no_strips = stripify::plan(&nothing, &graph, &StripifyOptions::default())?;
    /// assert!(no_strips.cover().is_empty() && !plan.cover().is_empty());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn is_empty(&self) -> bool {
        self.links.is_empty()
    }

    /// Counts the paths.
    ///
    /// ```
    #[doc = include_str!("dual/example.txt")]
    /// assert_eq!((plan.cover().path_count(), plan.strips().len()), (2, 2));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn path_count(&self) -> usize {
        self.links.len() - self.link_count
    }

    /// Counts the links of a triangle: 0 if it is isolated, 1 at the end of a path, 2 inside a
    /// path.
    #[inline]
    pub(crate) fn degree(&self, face: FaceId) -> usize {
        self.edges(face).into_iter().flatten().count()
    }

    /// Returns the half-edges over which a triangle is linked.
    #[inline]
    pub(crate) fn edges(&self, face: FaceId) -> [Option<HalfEdge>; 2] {
        let links = self.links[face.0 as usize];
        [links & 3, links >> 2 & 3]
            .map(|edge| (edge != FREE).then_some(HalfEdge(3 * face.0 + u32::from(edge))))
    }

    /// Returns whether a path crosses a half-edge.
    #[inline]
    pub(crate) fn is_linked(&self, half_edge: HalfEdge) -> bool {
        self.edges(FaceId(half_edge.0 / 3)).contains(&Some(half_edge))
    }

    /// Links two triangles across a half-edge and its twin. Does not check for cycles;
    /// [`PathCover::join`] does. Returns `false` and changes nothing if the twin does not exist,
    /// one of the triangles has two links, or the triangles are already linked across this edge.
    #[inline]
    pub(crate) fn link(&mut self, graph: &DualGraph, half_edge: HalfEdge) -> bool {
        let Some(twin) = graph.twin(half_edge) else { return false };
        let free = |h: HalfEdge| self.degree(FaceId(h.0 / 3)) < 2 && !self.is_linked(h);
        if !free(half_edge) || !free(twin) {
            return false;
        }
        self.set(half_edge);
        self.set(twin);
        self.link_count += 1;
        true
    }

    /// Removes the link across a half-edge. Returns whether there was one.
    #[inline]
    pub(crate) fn cut(&mut self, graph: &DualGraph, half_edge: HalfEdge) -> bool {
        let Some(twin) = graph.twin(half_edge) else { return false };
        if !self.is_linked(half_edge) {
            return false;
        }
        self.clear(half_edge);
        self.clear(twin);
        self.link_count -= 1;
        true
    }

    /// Joins two paths at their ends across a half-edge of the graph, and returns whether it
    /// succeeded. The half-edge must have a twin, and its two triangles must be ends of different
    /// paths. The time is proportional to the length of one of the paths.
    ///
    /// ```
    /// use tristrip::{DualGraph, Faces, HalfEdge, PathCover};
    /// // Three triangles around vertex 0.
    /// let graph = DualGraph::new(&Faces::from_triangles(vec![0, 1, 2, 0, 2, 3, 0, 3, 1])?);
    /// let mut cover = PathCover::isolated(3);
    /// let joined: Vec<bool> = (0..9).map(|half_edge| cover.join(&graph, HalfEdge(half_edge))).collect();
    /// // Half-edges 1, 4 and 7 are boundary edges. A third link would close the path.
    /// assert_eq!(joined, [true, false, true, false, false, false, false, false, false]);
    /// assert_eq!((cover.path_count(), cover.check(&graph)), (1, Ok(())));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn join(&mut self, graph: &DualGraph, half_edge: HalfEdge) -> bool {
        let is_of_graph = graph.is_of_triangles() && graph.face_count() == self.links.len();
        if !is_of_graph || half_edge.0 as usize >= graph.half_edge_count() {
            return false;
        }
        let Some(twin) = graph.twin(half_edge) else { return false };
        let (face, other) = (graph.face_of(half_edge), graph.face_of(twin));
        self.other_end(graph, face) != Some(other) && face != other && self.link(graph, half_edge)
    }

    /// Iterates over a path from one of its ends, with the half-edges over which the path enters
    /// and leaves each triangle. From a triangle inside a path, the iteration goes in one direction
    /// only, over the second stored link.
    pub(crate) fn walk<'a>(&'a self, graph: &'a DualGraph, start: FaceId) -> PathWalk<'a> {
        let [a, b] = self.edges(start);
        let exit = if a.is_some() && b.is_some() { b } else { a.or(b) };
        PathWalk { cover: self, graph, state: Some((start, None, exit)), left: self.links.len() }
    }

    /// Returns the other end of the path that ends at this triangle. An isolated triangle returns
    /// itself, and a triangle inside a path `None`.
    pub(crate) fn other_end(&self, graph: &DualGraph, end: FaceId) -> Option<FaceId> {
        if self.degree(end) == 2 {
            return None;
        }
        self.walk(graph, end).last().map(|(face, _, _)| face)
    }

    /// Iterates over the first triangles of all paths, in order of the paths' lowest triangles.
    pub(crate) fn path_starts<'a>(&'a self, graph: &'a DualGraph) -> impl Iterator<Item = FaceId> + 'a {
        let mut seen = vec![false; self.links.len()];
        (0..self.links.len() as u32).filter_map(move |lowest| {
            if seen[lowest as usize] {
                return None;
            }
            // The first end of a path is the end in the direction of the lowest triangle's first
            // link. The path is marked from there.
            let mut start = FaceId(lowest);
            if self.degree(start) == 2 {
                let [first, _] = self.edges(start);
                let mut exit = first;
                while let Some(twin) = exit.and_then(|h| graph.twin(h)) {
                    start = graph.face_of(twin);
                    if start.0 == lowest {
                        break; // a cycle: `check` reports it
                    }
                    exit = self.edges(start).into_iter().flatten().find(|&h| h != twin);
                }
            }
            for (face, _, _) in self.walk(graph, start) {
                seen[face.0 as usize] = true;
            }
            Some(start)
        })
    }

    /// Returns the path of each triangle and its position on that path.
    pub(crate) fn renumber(&self, graph: &DualGraph) -> Numbering {
        let mut numbering = Numbering {
            path: vec![0; self.links.len()],
            position: vec![0; self.links.len()],
            first: Vec::with_capacity(self.path_count()),
        };
        for start in self.path_starts(graph) {
            for (position, (face, _, _)) in self.walk(graph, start).enumerate() {
                numbering.path[face.0 as usize] = numbering.first.len() as u32;
                numbering.position[face.0 as usize] = position as u32;
            }
            numbering.first.push(start);
        }
        numbering
    }

    /// Checks that links are stored on both sides, that no path is closed, and that the stored link
    /// count is correct.
    ///
    /// # Errors
    /// Returns the first violation found.
    ///
    /// ```
    #[doc = include_str!("dual/example.txt")]
    /// assert_eq!(plan.cover().check(plan.triangulation().graph()), Ok(()));
    /// // The graph of the faces has one node for the quadrilateral.
    /// assert_eq!(plan.cover().check(&graph), Err(CoverFault::Size));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn check(&self, graph: &DualGraph) -> Result<(), CoverFault> {
        if !graph.is_of_triangles() || graph.face_count() != self.links.len() {
            return Err(CoverFault::Size);
        }
        let mut ends = 0;
        for face in (0..self.links.len() as u32).map(FaceId) {
            let edges = self.edges(face);
            if let [Some(a), Some(b)] = edges
                && a == b
            {
                return Err(CoverFault::OneSided(a));
            }
            for h in edges.into_iter().flatten() {
                let twin = graph.twin(h).ok_or(CoverFault::NoTwin(h))?;
                if !self.is_linked(twin) {
                    return Err(CoverFault::OneSided(h));
                }
            }
            ends += 2 - self.degree(face);
        }
        if ends != 2 * self.path_count() {
            return Err(CoverFault::Count);
        }
        // A node that is not reached from any end lies on a cycle.
        let mut reached = vec![false; self.links.len()];
        for face in (0..self.links.len() as u32).map(FaceId) {
            if self.degree(face) < 2 && !reached[face.0 as usize] {
                for (on_path, _, _) in self.walk(graph, face) {
                    reached[on_path.0 as usize] = true;
                }
            }
        }
        match reached.iter().position(|&r| !r) {
            Some(face) => Err(CoverFault::Cycle(FaceId(face as u32))),
            None => Ok(()),
        }
    }

    /// Links two triangles across a pair of twins. The triangles must not be linked there, and the
    /// link must not close a path.
    #[inline]
    pub(crate) fn link_unchecked(&mut self, half_edge: u32, twin: u32) {
        self.set(HalfEdge(half_edge));
        self.set(HalfEdge(twin));
        self.link_count += 1;
    }

    /// Removes the link across a pair of twins. The link must exist.
    #[inline]
    pub(crate) fn cut_unchecked(&mut self, half_edge: u32, twin: u32) {
        self.clear(HalfEdge(half_edge));
        self.clear(HalfEdge(twin));
        self.link_count -= 1;
    }

    /// Copies the links of triangles that were covered separately. Their indices in this cover
    /// start at `first`, and they must still be isolated.
    #[cfg(feature = "rayon")]
    pub(crate) fn put_back(&mut self, first: usize, part: &Self) {
        self.links[first..first + part.len()].copy_from_slice(&part.links);
        self.link_count += part.link_count;
    }

    /// Sets the two edges (0–2) over which an inner triangle of a path is linked. The links of its
    /// neighbours must match.
    #[inline]
    pub(crate) fn set_edges(&mut self, triangle: u32, first: u32, second: u32) {
        self.links[triangle as usize] = (first | second << 2) as u8;
    }

    /// Returns the edges (0–2) over which a triangle is linked, or 3 for a missing link.
    #[inline]
    pub(crate) fn packed_edges(&self, triangle: u32) -> (u32, u32) {
        let links = u32::from(self.links[triangle as usize]);
        (links & 3, links >> 2)
    }

    #[inline]
    fn set(&mut self, half_edge: HalfEdge) {
        let (links, edge) = (&mut self.links[half_edge.0 as usize / 3], (half_edge.0 % 3) as u8);
        *links = if *links & 3 == FREE { *links & !3 | edge } else { *links & 3 | edge << 2 };
    }

    #[inline]
    fn clear(&mut self, half_edge: HalfEdge) {
        let (links, edge) = (&mut self.links[half_edge.0 as usize / 3], (half_edge.0 % 3) as u8);
        *links |= if *links & 3 == edge { FREE } else { FREE << 2 };
    }
}

/// Iterator over a path: see [`PathCover::walk`].
#[derive(Debug)]
pub(crate) struct PathWalk<'a> {
    cover: &'a PathCover,
    graph: &'a DualGraph,
    state: Option<(FaceId, Option<HalfEdge>, Option<HalfEdge>)>,
    /// The number of triangles that may still be visited. It ends the iteration on invalid covers.
    left: usize,
}

impl Iterator for PathWalk<'_> {
    type Item = (FaceId, Option<HalfEdge>, Option<HalfEdge>);

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        let here = self.state.take()?;
        if self.left == 0 {
            return None;
        }
        self.left -= 1;
        if let Some(entry) = here.2.and_then(|exit| self.graph.twin(exit)) {
            let face = self.graph.face_of(entry);
            let exit = self.cover.edges(face).into_iter().flatten().find(|&h| h != entry);
            self.state = Some((face, Some(entry), exit));
        }
        Some(here)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Faces;

    /// A row of triangles in which each shares an edge with the next, optionally closed to a ring.
    fn row(n: u32, ring: bool) -> DualGraph {
        let v = |i: u32| if ring { i % n } else { i };
        let corners = (0..n)
            .flat_map(|i| if i % 2 == 0 { [v(i), v(i + 1), v(i + 2)] } else { [v(i + 1), v(i), v(i + 2)] });
        DualGraph::new(&Faces::from_triangles(corners.collect()).unwrap())
    }

    fn arc(graph: &DualGraph, a: u32, b: u32) -> HalfEdge {
        graph.half_edges(FaceId(a)).find(|&h| graph.twin(h).is_some_and(|t| graph.face_of(t).0 == b)).unwrap()
    }

    #[test]
    fn joins_cuts_and_refuses_cycles() {
        let graph = row(8, true);
        let mut cover = PathCover::isolated(8);
        for i in 0..7 {
            assert!(cover.join(&graph, arc(&graph, i, i + 1)));
            assert_eq!(cover.check(&graph), Ok(()));
        }
        assert_eq!(cover.path_count(), 1);
        assert!(!cover.join(&graph, arc(&graph, 7, 0)), "it would close the path");
        assert!(cover.link(&graph, arc(&graph, 7, 0)));
        assert!(matches!(cover.check(&graph), Err(CoverFault::Count | CoverFault::Cycle(_))));
        assert!(cover.cut(&graph, arc(&graph, 3, 4)));
        assert!(!cover.cut(&graph, arc(&graph, 3, 4)));
        assert_eq!(cover.check(&graph), Ok(()));
        let numbering = cover.renumber(&graph);
        assert_eq!(numbering.first.len(), 1);
        let mut positions = numbering.position.clone();
        positions.sort_unstable();
        assert_eq!(positions, (0..8).collect::<Vec<_>>());
        assert_eq!(cover.other_end(&graph, FaceId(3)), Some(FaceId(4)));
    }
}
