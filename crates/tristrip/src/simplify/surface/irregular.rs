//! Collapses at points whose triangles form neither a disk nor a half disk.
//!
//! ```text
//!        u ───── w
//!       ╱ ╲     ╱ ╲
//!      ╱   ╲   ╱   ╲
//!     ·────── b ──────·
//! ```
//! The link of the point b is a graph: its nodes are the neighbours of b, and its arcs are the
//! edges opposite to b, such as u–w. The link of an inner point is a circle, and the link of a
//! border point is a path. An edge from b to a node that does not have two arcs is *singular*: a
//! border, or an edge where three or more sheets meet. A point is on a line if it has two singular
//! edges with the same number of sheets. Lines meet or end at a point with any other singular
//! edges.
//!
//! Triangles of the same three points, such as the two sides of a doubled face, count once.
//!
//! A collapse is allowed if
//! - all common neighbours of both points are corners of their common triangles, and no edge is
//!   opposite to both (the link condition). Then no hole opens or closes, and no components are
//!   merged. A fin, a triangle attached by only one edge, can vanish;
//! - a point on singular edges moves along one of them;
//! - a triangle remains at each edge that two edges are merged into. The last triangle of an edge
//!   is therefore kept, and so is a triangle that is the only connection between two others.
//!
//! # References
//! Dey, Edelsbrunner, Guha, Nekhayev: *Topology Preserving Edge Contraction*, 1999. Attali,
//! Lieutier, Salinas: *Efficient Data Structure for Representing and Simplifying Simplicial
//! Complexes in High Dimensions*, 2012: the link condition preserves the homotopy type.

use super::topology::Topology;

/// The link of a point.
#[derive(Debug, Default)]
struct PointLink {
    /// The arcs, each as its lower and its higher point, ascending.
    arcs: Vec<[u32; 2]>,
    /// The points with their numbers of arcs, ascending.
    nodes: Vec<(u32, u32)>,
}

impl PointLink {
    /// Collects the link of a point.
    fn collect(&mut self, topology: &Topology, point: u32) {
        self.arcs.clear();
        let ordered = |[u, w]: [u32; 2]| [u.min(w), u.max(w)];
        self.arcs.extend(topology.opposite(point).iter().map(|&edge| ordered(edge)));
        self.arcs.sort_unstable();
        self.arcs.dedup();
        self.nodes.clear();
        self.nodes.extend(self.arcs.iter().flatten().map(|&node| (node, 1)));
        self.nodes.sort_unstable();
        self.nodes.dedup_by(|node, before| {
            let is_same = node.0 == before.0;
            before.1 += u32::from(is_same);
            is_same
        });
    }

    /// Returns the number of arcs of a point.
    fn arcs_of(&self, point: u32) -> Option<u32> {
        self.nodes.binary_search_by_key(&point, |node| node.0).ok().map(|i| self.nodes[i].1)
    }

    /// Iterates over the points that do not have two arcs, with their numbers of arcs.
    fn singular(&self) -> impl Iterator<Item = (u32, u32)> {
        self.nodes.iter().copied().filter(|&(_, arcs)| arcs != 2)
    }
}

/// The links of two points.
#[derive(Debug, Default)]
pub(crate) struct Links {
    removed: PointLink,
    kept: PointLink,
}

impl Links {
    /// Collects the neighbours that a point may move to, ascending: those along its singular edges,
    /// or all if it has none.
    pub(crate) fn neighbours(&mut self, topology: &Topology, point: u32, found: &mut Vec<u32>) {
        self.removed.collect(topology, point);
        found.clear();
        found.extend(self.removed.singular().map(|(node, _)| node));
        if found.is_empty() {
            found.extend(self.removed.nodes.iter().map(|&(node, _)| node));
        }
    }

    /// Returns whether a collapse preserves the arrangement of the sheets, and leaves a triangle.
    pub(crate) fn allow(&mut self, topology: &Topology, removed: u32, kept: u32) -> bool {
        self.removed.collect(topology, removed);
        self.kept.collect(topology, kept);
        let Self { removed: from, kept: to } = self;
        let Some(sheets) = from.arcs_of(kept) else { return false };
        // 1. Common neighbours are only those of common triangles; there are as many as sheets.
        let common = from.nodes.iter().filter(|&&(node, _)| to.arcs_of(node).is_some()).count();
        if common != sheets as usize || from.arcs.iter().any(|arc| to.arcs.binary_search(arc).is_ok()) {
            return false;
        }
        // 2. Points on a line move along it.
        if sheets == 2 && from.singular().next().is_some() {
            return false;
        }
        // 3. A triangle remains at each merged edge.
        let in_more = |link: &PointLink, node: u32| link.arcs_of(node).is_some_and(|arcs| arcs > 1);
        let mut ends =
            from.arcs.iter().filter(|arc| arc.contains(&kept)).map(|&[u, w]| if u == kept { w } else { u });
        ends.all(|node| in_more(from, node) || in_more(to, node))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn topology(vertices: &[u32]) -> Topology {
        let positions: Vec<[f32; 3]> = (0..20).map(|i| [i as f32, (i * i) as f32, 0.0]).collect();
        Topology::new(&positions[..], |_| Vec::new(), vertices, false, 0.0)
    }

    /// Returns the points of vertices below 20.
    fn points(topology: &Topology) -> impl Fn(u32) -> u32 {
        let vertices: Vec<u32> = (0..topology.point_count() as u32).map(|p| topology.vertex_of(p)).collect();
        move |v| vertices.iter().position(|&vertex| vertex == v).unwrap() as u32
    }

    fn allows(vertices: &[u32], removed: u32, kept: u32) -> bool {
        let topology = topology(vertices);
        let at = points(&topology);
        Links::default().allow(&topology, at(removed), at(kept))
    }

    /// Three sheets along the line 0–1–2, each of two triangles.
    const BOOK: [u32; 18] = [0, 1, 3, 1, 2, 3, 0, 1, 4, 1, 2, 4, 0, 1, 5, 1, 2, 5];

    #[test]
    fn a_point_on_a_line_moves_along_it() {
        assert!(allows(&BOOK, 1, 0) && allows(&BOOK, 1, 2));
        assert!(!allows(&BOOK, 1, 3), "off the line");
        assert!(allows(&BOOK, 0, 1), "the end of the line moves along it");
        let topology = topology(&BOOK);
        let (at, mut found) = (points(&topology), Vec::new());
        Links::default().neighbours(&topology, at(1), &mut found);
        found.sort_unstable();
        assert_eq!(found, [at(0).min(at(2)), at(0).max(at(2))]);
    }

    #[test]
    fn the_last_triangles_of_each_sheet_stay() {
        // One triangle per sheet. Both ends of the line are corners, and no other edge is common to
        // all sheets.
        assert!(!allows(&[0, 1, 2, 0, 1, 3, 0, 1, 4], 0, 1));
        assert!(!allows(&[0, 1, 2], 0, 1), "a single triangle");
    }

    #[test]
    fn doubled_faces_count_once() {
        // A closed fan around point 0, and the same triangles from the other side: there are two
        // common neighbours.
        let side = (1..=5_u32).flat_map(|i| [0, i, i % 5 + 1]);
        let both: Vec<u32> = side.clone().chain((1..=5).flat_map(|i| [0, i % 5 + 1, i])).collect();
        assert!((1..6).all(|v| allows(&both, 0, v)));
    }

    #[test]
    fn two_fans_that_touch_are_no_reason_to_stay() {
        let vertices: Vec<u32> = (1..=4_u32)
            .flat_map(|i| [0, i, i % 4 + 1])
            .chain((5..=8).flat_map(|i| [0, i, (i - 4) % 4 + 5]))
            .collect();
        assert!(allows(&vertices, 0, 1));
        assert!(!allows(&vertices, 1, 5), "no common triangle");
    }
}
