//! Converts a path cover into strips. Each path becomes the shortest possible strip.
//!
//! ```text
//!   enter p → q, third vertex w        even position in the strip: sent … p q w, drawn (p, q, w)
//!         w                            the last two are (q, w): leaving across q → w is free,
//!        / \                           leaving across w → p requires a swap: … p q p w
//!       /   \                          odd position: sent … q p w, drawn (p, q, w)
//!      p ──▶ q                         the last two are (p, w): leaving across w → p is free
//! ```
//! A strip begins with the vertex opposite the first exit, so the first triangle has the right
//! winding. Each turn is free on one side only, depending on the position in the strip. A strip
//! whose first turn is not free needs a winding repeat or a swap at that turn. Both cost one index.
//! The first turn may be free if the strip starts at the other end of the path, so both directions
//! are compared.
//!
//! # References
//! Evans, Skiena, Varshney: *Efficiently Generating Triangle Strips for Fast Rendering*, 1996,
//! section 1 and figure 3.
//!
//! # Complexity
//! O(n) time. Memory: the strips, one byte per triangle, and one path.

use super::Strips;
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::dual::Triangulation;
use crate::ids::{FaceId, HalfEdge};

/// The edge number that stands for "no edge"; the edges of a triangle are 0 to 2.
pub(crate) const OPEN: u32 = 3;

/// Converts each path of a cover into a strip. The strips are in the order of their lowest
/// triangles.
pub(crate) fn emit(triangulation: &Triangulation<'_>, cover: &PathCover) -> Strips {
    let (triangles, graph) = (triangulation.triangles(), triangulation.graph());
    let mut strips = Strips::with_capacity(cover.len() + cover.len() / 3, cover.path_count());
    let mut seen = vec![false; cover.len()];
    let (mut back, mut ahead, mut path) = (Vec::new(), Vec::new(), Vec::new());
    for lowest in 0..cover.len() as u32 {
        if seen[lowest as usize] {
            continue;
        }
        seen[lowest as usize] = true;
        let (first, second) = cover.packed_edges(lowest);
        back.clear();
        ahead.clear();
        // Walk in both directions at once: each step waits for memory, and the two walks are
        // independent.
        let mut walks =
            [TriangleWalk { triangle: lowest, exit: first }, TriangleWalk { triangle: lowest, exit: second }];
        while walks.iter().any(|walk| walk.exit != OPEN) {
            let [backward, forward] = &mut walks;
            back.extend(backward.step(graph, cover, &mut seen));
            ahead.extend(forward.step(graph, cover, &mut seen));
        }
        path.clear();
        path.extend(back.iter().rev().map(Step::reversed));
        path.push(Step { triangle: lowest, entry: first, exit: second });
        path.extend_from_slice(&ahead);
        if swaps_at_start(&path) > swaps_at_start_reversed(&path) {
            send_path(triangles, path.iter().rev().map(Step::reversed), &mut strips.vertices);
        } else {
            send_path(triangles, path.iter().copied(), &mut strips.vertices);
        }
        strips.ends.push(strips.vertices.len() as u32);
    }
    strips
}

/// Converts paths into strips in the given order: `order` contains the first triangle of each path,
/// in drawing order.
///
/// The order is [kept](Strips::with_kept_order). Paths that are missing from `order` are not drawn.
/// Paths are not reversed, even if the first turn then needs a swap.
pub(crate) fn emit_in_order(
    triangulation: &Triangulation<'_>,
    cover: &PathCover,
    order: &[FaceId],
) -> Strips {
    let (triangles, graph) = (triangulation.triangles(), triangulation.graph());
    let mut strips = Strips::with_capacity(cover.len() + cover.len() / 3, order.len());
    for &start in order {
        send_path(triangles, path_steps(graph, cover, start), &mut strips.vertices);
        strips.ends.push(strips.vertices.len() as u32);
    }
    strips.with_kept_order()
}

/// Iterates over the steps of a path, starting at one of its ends.
pub(crate) fn path_steps<'a>(
    graph: &'a DualGraph,
    cover: &'a PathCover,
    start: FaceId,
) -> impl Iterator<Item = Step> + 'a {
    let edge = |h: Option<HalfEdge>| h.map_or(OPEN, |h| h.0 % 3);
    cover.walk(graph, start).map(move |(face, entry, exit)| Step {
        triangle: face.0,
        entry: edge(entry),
        exit: edge(exit),
    })
}

/// A triangle of a path with the edges (0–2) over which the path enters and leaves it. At an end of
/// the path, the missing edge is `OPEN`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Step {
    pub(crate) triangle: u32,
    pub(crate) entry: u32,
    pub(crate) exit: u32,
}

impl Step {
    pub(crate) fn reversed(&self) -> Self {
        Self { triangle: self.triangle, entry: self.exit, exit: self.entry }
    }

    /// Returns whether the strip can leave the triangle without a swap at an even position.
    /// Otherwise it can do so at an odd position.
    #[inline]
    pub(crate) fn is_free_at_even(&self) -> bool {
        self.exit == if self.entry == 2 { 0 } else { self.entry + 1 }
    }
}

/// A walk along a path: the current triangle, and the edge over which the walk continues (`OPEN` at
/// the end of the path).
struct TriangleWalk {
    triangle: u32,
    exit: u32,
}

impl TriangleWalk {
    /// Advances by one triangle, or returns `None` at the end of the path. Also stops on a closed
    /// path, which no valid cover has.
    #[inline]
    fn step(&mut self, graph: &DualGraph, cover: &PathCover, seen: &mut [bool]) -> Option<Step> {
        if self.exit == OPEN {
            return None;
        }
        let Some(twin) = graph.twin_of(3 * self.triangle + self.exit) else {
            self.exit = OPEN;
            return None;
        };
        self.triangle = twin / 3;
        self.exit = OPEN;
        if std::mem::replace(&mut seen[self.triangle as usize], true) {
            return None;
        }
        let entry = twin % 3;
        let (first, second) = cover.packed_edges(self.triangle);
        self.exit = if first == entry { second } else { first };
        Some(Step { triangle: self.triangle, entry, exit: self.exit })
    }
}

/// Counts the swap at the first turn: the second triangle is at an odd position.
fn swaps_at_start(path: &[Step]) -> usize {
    let turns = path.len().saturating_sub(2);
    path.get(1).map_or(0, |step| usize::from(turns > 0 && step.is_free_at_even()))
}

fn swaps_at_start_reversed(path: &[Step]) -> usize {
    let turns = path.len().saturating_sub(2);
    path.len().checked_sub(2).map_or(0, |i| usize::from(turns > 0 && path[i].reversed().is_free_at_even()))
}

/// Counts the swaps, one per pair of consecutive turns in the same direction. The count is the same
/// in both directions.
fn swaps_inside(path: &[Step]) -> usize {
    let turns = path.get(1..path.len().saturating_sub(1)).unwrap_or_default();
    turns.windows(2).filter(|w| w[0].is_free_at_even() == w[1].is_free_at_even()).count()
}

/// Appends the vertices of one path.
#[inline]
pub(crate) fn send_path(triangles: &[u32], path: impl Iterator<Item = Step>, out: &mut Vec<u32>) {
    // The vertex opposite an edge is two corners after the edge's start.
    let corner = |triangle: u32, edge: u32| {
        triangles[(3 * triangle + if edge >= 3 { edge - 3 } else { edge }) as usize]
    };
    let mut even = true;
    for step in path {
        if step.entry == OPEN {
            let exit = if step.exit == OPEN { 1 } else { step.exit };
            out.extend([
                corner(step.triangle, exit + 2),
                corner(step.triangle, exit),
                corner(step.triangle, exit + 1),
            ]);
            even = false;
            continue;
        }
        if step.exit != OPEN {
            if step.is_free_at_even() == even {
                even = !even;
            } else {
                out.push(out[out.len() - 2]);
            }
        }
        out.push(corner(step.triangle, step.entry + 2));
    }
}

/// Counts the vertices of the strip that [`emit`] makes of the path at `start`, without emitting
/// it.
pub(crate) fn path_cost(graph: &DualGraph, cover: &PathCover, start: FaceId) -> usize {
    let path: Vec<Step> = path_steps(graph, cover, start).collect();
    path.len() + 2 + swaps_inside(&path) + swaps_at_start(&path).min(swaps_at_start_reversed(&path))
}

/// Counts the vertices and restarts of a cover's strips, one restart per strip, without emitting
/// them.
pub(crate) fn cover_cost(graph: &DualGraph, cover: &PathCover) -> usize {
    cover.path_starts(graph).map(|start| path_cost(graph, cover, start) + 1).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Faces, Mesh, canonical_triangle, canonical_triangles, is_degenerate};
    use crate::prepare::PreparedFaces;
    use proptest::prelude::*;

    /// Returns the length of the shortest strip for a path. Searches breadth first over (triangle,
    /// last two vertices) and tries a repeat at every position.
    fn cheapest(triangles: &[[u32; 3]]) -> usize {
        let same =
            |t: [u32; 3], a: u32, b: u32, c: u32| canonical_triangle(t) == canonical_triangle([a, b, c]);
        let vertices: Vec<u32> = triangles.iter().flatten().copied().collect();
        let mut states: Vec<(usize, usize, u32, u32)> = Vec::new(); // triangles drawn, parity, last two
        for &a in &vertices {
            for &b in &vertices {
                states.push((0, 0, a, b));
            }
        }
        for sent in 3.. {
            let mut next = Vec::new();
            for &(drawn, parity, a, b) in &states {
                for &c in &vertices {
                    let (x, y) = if parity == 0 { (a, b) } else { (b, a) };
                    let drawn = match () {
                        () if is_degenerate([a, b, c]) => drawn,
                        () if same(triangles[drawn], x, y, c) => drawn + 1,
                        () => continue,
                    };
                    if drawn == triangles.len() {
                        return sent;
                    }
                    next.push((drawn, 1 - parity, b, c));
                }
            }
            next.sort_unstable();
            next.dedup();
            states = next;
        }
        unreachable!()
    }

    proptest! {
        #[test]
        fn is_the_cheapest_over_both_directions(turns in prop::collection::vec(any::<bool>(), 0..7)) {
            // Builds a path of triangles in general position: each has one edge of the previous
            // triangle and a new vertex.
            let mut path = vec![[0, 1, 2_u32]];
            for (i, &left) in turns.iter().enumerate() {
                let [a, b, c] = path[i];
                let w = 3 + i as u32;
                path.push(if left { [c, b, w] } else { [a, c, w] });
            }
            let corners: Vec<u32> = path.iter().flatten().copied().collect();
            let vertex_count = 3 + turns.len();
            let mesh = Mesh::new(vec![[0.0; 3]; vertex_count], Faces::from_triangles(corners).unwrap()).unwrap();
            let prepared = PreparedFaces::new(&mesh, false);
            let graph = DualGraph::new(prepared.faces());
            let mut cover = PathCover::isolated(path.len());
            (0..graph.half_edge_count() as u32).for_each(|h| { cover.join(&graph, HalfEdge(h)); });
            prop_assert_eq!(cover.path_count(), 1);
            let triangulation = Triangulation::fan(&prepared, &graph);
            let strips = emit(&triangulation, &cover);
            let backward: Vec<_> = path.iter().rev().copied().collect();
            prop_assert_eq!(strips.vertices_sent(), cheapest(&path).min(cheapest(&backward)));
            prop_assert_eq!(strips.vertices_sent(), path_cost(&graph, &cover, FaceId(0)));
            prop_assert_eq!(canonical_triangles(strips.triangles()), canonical_triangles(path));
        }
    }
}
