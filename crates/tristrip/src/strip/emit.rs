//! The emitter: a path cover becomes strips, each path at the least cost that it has.
//!
//! ```text
//!   enter p → q, third vertex w        even place in the strip: sent … p q w, drawn (p, q, w)
//!         w                            the last two are (q, w): leaving across q → w is free,
//!        / \                           leaving across w → p takes a swap: … p q p w
//!       /   \                          odd place: sent … q p w, drawn (p, q, w)
//!      p ──▶ q                         the last two are (p, w): leaving across w → p is free
//! ```
//! A strip begins with the vertex that the first exit leaves behind, so that the first triangle is wound right. Whether the turn
//! after it is free depends on its side: a strip that begins with the wrong turn would need a winding repeat, and a swap at that
//! turn costs the same. Read from its other end the same path may begin well, so that both ends are priced.
//!
//! # References
//! Evans, Skiena, Varshney: *Efficiently Generating Triangle Strips for Fast Rendering*, 1996, section 1 and figure 3.
//!
//! # Complexity
//! O(n); no memory but the strips, one byte a triangle, and one path.

use super::Strips;
use crate::cover::PathCover;
use crate::dual::{DualGraph, FaceId, HalfEdge};
use crate::mesh::Triangulation;

/// Turns each path of a cover into a strip, the strips in order of their lowest triangles.
///
/// ```
/// use tristrip::{DualGraph, Faces, HalfEdge, Mesh, PathCover, Surface, mesh::Triangulation, strip::emit};
/// let faces = Faces::from_triangles(vec![0, 1, 2, 2, 1, 3])?;
/// let mesh = Mesh::new(vec![[0.0; 3]; 4], faces)?;
/// let surface = Surface::new(&mesh, false);
/// let graph = DualGraph::new(surface.faces());
/// let triangulation = Triangulation::fan(&surface, &graph);
/// let mut cover = PathCover::isolated(2);
/// cover.join(&graph, HalfEdge(1));
/// assert_eq!(emit(&triangulation, &cover).vertices(), [0, 1, 2, 3]);
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn emit(triangulation: &Triangulation<'_>, cover: &PathCover) -> Strips {
    let (triangles, graph) = (triangulation.triangles(), triangulation.graph());
    let mut strips = Strips {
        vertices: Vec::with_capacity(cover.len() + cover.len() / 3),
        ends: Vec::with_capacity(cover.path_count()),
    };
    let mut path = Vec::new();
    for start in cover.path_starts(graph) {
        path.clear();
        path.extend(cover.walk(graph, start).filter_map(|(_, _, exit)| exit));
        if path.is_empty() {
            let corner = 3 * start.0 as usize;
            strips.vertices.extend_from_slice(&triangles[corner..corner + 3]);
        } else {
            if swap_count(graph, &path) > reversed_swap_count(graph, &path) {
                reverse(graph, &mut path);
            }
            emit_path(triangles, graph, &path, &mut strips.vertices);
        }
        strips.ends.push(strips.vertices.len() as u32);
    }
    strips
}

/// Tells whether leaving a triangle is free at an even place of the strip; at an odd place the other side is.
#[inline]
fn free_at_even(entry: HalfEdge, exit: HalfEdge) -> bool {
    // Edges of one triangle: the exit follows the entry in the winding.
    let (entry, exit) = (entry.0 % 3, exit.0 % 3);
    exit == if entry == 2 { 0 } else { entry + 1 }
}

/// Walks over the turns of a path of exits: each inner triangle's entry and exit.
fn turns<'a>(
    graph: &'a DualGraph,
    exits: &'a [HalfEdge],
) -> impl DoubleEndedIterator<Item = (HalfEdge, HalfEdge)> + 'a {
    exits.windows(2).filter_map(|w| Some((graph.twin(w[0])?, w[1])))
}

/// Counts the swaps of a strip whose inner triangles turn this way.
fn count_swaps(turns: impl Iterator<Item = (HalfEdge, HalfEdge)>) -> usize {
    let (mut swaps, mut even) = (0, false);
    for (entry, exit) in turns {
        if free_at_even(entry, exit) == even {
            even = !even;
        } else {
            swaps += 1; // the triangle moves to the next place, and its successor to this one's parity
        }
    }
    swaps
}

fn swap_count(graph: &DualGraph, exits: &[HalfEdge]) -> usize {
    count_swaps(turns(graph, exits))
}

fn reversed_swap_count(graph: &DualGraph, exits: &[HalfEdge]) -> usize {
    count_swaps(turns(graph, exits).rev().map(|(entry, exit)| (exit, entry)))
}

/// Turns a path around: its exits become the twins of what they were, in reverse.
fn reverse(graph: &DualGraph, exits: &mut [HalfEdge]) {
    exits.reverse();
    for exit in exits {
        *exit = graph.twin(*exit).unwrap_or(*exit);
    }
}

/// Sends the vertices of one path of at least two triangles.
fn emit_path(triangles: &[u32], graph: &DualGraph, exits: &[HalfEdge], out: &mut Vec<u32>) {
    let corner = |h: HalfEdge, offset: u32| {
        let (base, edge) = (h.0 / 3 * 3, h.0 % 3 + offset);
        triangles[(base + if edge >= 3 { edge - 3 } else { edge }) as usize]
    };
    let Some(&first) = exits.first() else { return };
    out.extend([corner(first, 2), corner(first, 0), corner(first, 1)]);
    let mut even = false;
    for (i, &exit) in exits.iter().enumerate() {
        let Some(entry) = graph.twin(exit) else { return };
        if let Some(&next) = exits.get(i + 1) {
            if free_at_even(entry, next) == even {
                even = !even;
            } else {
                out.push(out[out.len() - 2]);
            }
        }
        out.push(corner(entry, 2));
    }
}

/// Counts the vertices that the path from `start` costs, as [`emit`] will send it: for methods that weigh alternatives.
pub fn path_cost(graph: &DualGraph, cover: &PathCover, start: FaceId) -> usize {
    let path: Vec<_> = cover.walk(graph, start).filter_map(|(_, _, exit)| exit).collect();
    path.len() + 3 + swap_count(graph, &path).min(reversed_swap_count(graph, &path))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Faces, Mesh, Surface};
    use proptest::prelude::*;

    /// The cheapest strip for a path, found by trying every place for repeats: breadth first over (triangle, last two vertices).
    fn cheapest(triangles: &[[u32; 3]]) -> usize {
        let same =
            |t: &[u32; 3], a: u32, b: u32, c: u32| *t == [a, b, c] || *t == [b, c, a] || *t == [c, a, b];
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
                    let degenerate = a == b || b == c || a == c;
                    let (x, y) = if parity == 0 { (a, b) } else { (b, a) };
                    let drawn = match () {
                        () if degenerate => drawn,
                        () if same(&triangles[drawn], x, y, c) => drawn + 1,
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
            // A path of triangles in general position: each takes one edge of the last and a new vertex.
            let mut path = vec![[0, 1, 2_u32]];
            for (i, &left) in turns.iter().enumerate() {
                let [a, b, c] = path[i];
                let w = 3 + i as u32;
                path.push(if left { [c, b, w] } else { [a, c, w] });
            }
            let corners: Vec<u32> = path.iter().flatten().copied().collect();
            let vertex_count = 3 + turns.len();
            let mesh = Mesh::new(vec![[0.0; 3]; vertex_count], Faces::from_triangles(corners).unwrap()).unwrap();
            let surface = Surface::new(&mesh, false);
            let graph = DualGraph::new(surface.faces());
            let mut cover = PathCover::isolated(path.len());
            (0..graph.half_edge_count() as u32).for_each(|h| { cover.join(&graph, HalfEdge(h)); });
            prop_assert_eq!(cover.path_count(), 1);
            let triangulation = Triangulation::fan(&surface, &graph);
            let strips = emit(&triangulation, &cover);
            let backward: Vec<_> = path.iter().rev().copied().collect();
            prop_assert_eq!(strips.vertices_sent(), cheapest(&path).min(cheapest(&backward)));
            prop_assert_eq!(strips.vertices_sent(), path_cost(&graph, &cover, FaceId(0)));
            let mut drawn: Vec<_> = strips.triangles().map(canonical).collect();
            let mut wanted: Vec<_> = path.into_iter().map(canonical).collect();
            drawn.sort_unstable();
            wanted.sort_unstable();
            prop_assert_eq!(drawn, wanted);
        }
    }

    fn canonical(t: [u32; 3]) -> [u32; 3] {
        let mut t = t;
        while t[0] > t[1] || t[0] > t[2] {
            t.rotate_left(1);
        }
        t
    }
}
