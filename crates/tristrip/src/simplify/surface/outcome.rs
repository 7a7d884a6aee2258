//! Determines how a collapse changes the arrangement of the surface: the collapse preserves the
//! surface, removes the last triangles of a component, or breaks the surface.
//!
//! ```text
//!         u ───── w
//!        ╱ ╲     ╱ ╲
//!       ╱   ╲   ╱   ╲
//!      a ──── b ─────·
//! ```
//! A collapse of the inner point b to a preserves a surface if a and b have exactly two common
//! neighbours, the third corners of their two common triangles. If there is another common
//! neighbour, the three edges between a, b and this neighbour bound no triangle. The collapse would
//! close a tube there: the tube through a, b and the neighbour would become two cones that touch.
//!
//! On a border, the points have one common triangle and one common neighbour. The module
//! `irregular` handles all other points.

use super::irregular::Links;
use super::topology::{LONG_RING, PointKind, Topology};

/// Points with more triangles are not removed, so the time of a price does not depend on the size
/// of the mesh.
pub(crate) const MAX_CORNERS: usize = 256;

/// How a collapse changes the surface around it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum CollapseOutcome {
    /// The arrangement of the surface is preserved.
    Keeps,
    /// The last triangles of a component or of a mesh vanish, or only two back-to-back triangles
    /// remain of it.
    Ends,
    /// A hole or a handle would close.
    Breaks,
    /// A triangle would vanish without a replacement, or the points have too many triangles to
    /// check.
    Loses,
}

/// Determines the outcomes of collapses.
#[derive(Debug)]
pub(crate) struct Outcomes {
    /// The last mark of each point.
    marks: Vec<u32>,
    mark: u32,
    links: Links,
}

impl Outcomes {
    /// Creates the marks of all points.
    pub(crate) fn new(point_count: usize) -> Self {
        Self { marks: vec![0; point_count], mark: 0, links: Links::default() }
    }

    /// Returns how a collapse changes the surface.
    pub(crate) fn of(&mut self, topology: &Topology, point: u32, to: u32) -> CollapseOutcome {
        let ring = topology.opposite(point);
        if is_end(topology, point, to) || topology.ends_mesh(point, to) {
            return CollapseOutcome::Ends;
        }
        let keeps = if topology.kind(point) == PointKind::Irregular {
            topology.ring(to).len() <= MAX_CORNERS && self.links.allow(topology, point, to)
        } else {
            let common = ring.iter().filter(|edge| edge.contains(&to)).count();
            let expected = if topology.kind(point) == PointKind::Border { 1 } else { 2 };
            common == expected
                && (ring.len() > 3 || component_remains(topology, point, to))
                && self.common_neighbours(topology, point, to) == common
        };
        if keeps {
            CollapseOutcome::Keeps
        } else if loses_triangle(topology, point, to) {
            CollapseOutcome::Loses
        } else {
            CollapseOutcome::Breaks
        }
    }

    /// Returns the number of common neighbours of two points.
    fn common_neighbours(&mut self, topology: &Topology, point: u32, to: u32) -> usize {
        if self.mark > u32::MAX - 4 {
            self.marks.fill(0);
            self.mark = 0;
        }
        self.mark += 2;
        let (is_neighbour, is_counted) = (self.mark, self.mark + 1);
        let marks = &mut self.marks;
        let around = |p: u32| topology.opposite(p).iter().flatten().copied();
        let mut count = 0;
        if topology.ring(to).len() <= LONG_RING {
            around(point).for_each(|p| marks[p as usize] = is_neighbour);
            for p in around(to) {
                if marks[p as usize] == is_neighbour {
                    marks[p as usize] = is_counted;
                    count += 1;
                }
            }
        } else {
            for p in around(point) {
                if p == to || std::mem::replace(&mut marks[p as usize], is_neighbour) == is_neighbour {
                    continue;
                }
                let [short, long] =
                    if topology.ring(p).len() < topology.ring(to).len() { [p, to] } else { [to, p] };
                count += usize::from(around(short).any(|q| q == long));
            }
        }
        count
    }
}

/// Returns whether an edge that two edges are merged into would have no triangle.
fn loses_triangle(topology: &Topology, point: u32, to: u32) -> bool {
    let (own, kept) = (topology.opposite(point), topology.opposite(to));
    let has_other = |ring: &[[u32; 2]], third: u32, other: u32| {
        ring.iter().any(|edge| edge.contains(&third) && !edge.contains(&other))
    };
    let third = |&[u, w]: &[u32; 2]| (u == to || w == to).then_some(if u == to { w } else { u });
    kept.len() > MAX_CORNERS
        || own
            .iter()
            .filter_map(third)
            .any(|third| !has_other(own, third, to) && !has_other(kept, third, point))
}

/// Returns whether a collapse leaves nothing of a component, or two back-to-back triangles.
fn is_end(topology: &Topology, point: u32, to: u32) -> bool {
    let (own, kept) = (topology.opposite(point), topology.opposite(to));
    match own.iter().find(|edge| !edge.contains(&to)) {
        None => kept.iter().all(|edge| edge.contains(&point)),
        // A tetrahedron: each of the other triangles has an edge at the kept point.
        Some(&[u, w]) => {
            own.len() == 3
                && kept.len() == 3
                && topology.ring(u).len() == 3
                && topology.triangles_with([to, u, w]) == 1
        }
    }
}

/// Returns whether a point with few triangles can be removed without creating a triangle that
/// exists already or an edge without triangles. The point is not the last one of its component.
fn component_remains(topology: &Topology, point: u32, to: u32) -> bool {
    let ring = topology.opposite(point);
    // Whether the triangle that the opposite edge would form with the kept point exists already.
    let exists = |[u, w]: [u32; 2]| topology.triangles_with([to, u, w]) > 0;
    let other = ring.iter().find(|edge| !edge.contains(&to));
    match (topology.kind(point), other) {
        (PointKind::Inner, Some(&edge)) => ring.len() != 3 || !exists(edge),
        (PointKind::Border, None) => {
            let third = ring.iter().flatten().copied().find(|&p| p != to);
            third.is_some_and(|third| topology.triangles_with([to, third]) > 1)
        }
        (PointKind::Border, Some(_)) => true,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(vertices: &[u32], point: u32, to: u32) -> CollapseOutcome {
        let positions: Vec<[f32; 3]> = (0..9).map(|i| [i as f32, (i * i) as f32, 0.0]).collect();
        let topology = Topology::new(&positions[..], |_| Vec::new(), vertices, false, 0.0);
        let at = |v: u32| (0..topology.point_count() as u32).find(|&p| topology.vertex_of(p) == v).unwrap();
        Outcomes::new(topology.point_count()).of(&topology, at(point), at(to))
    }

    #[test]
    fn outcomes_of_small_surfaces() {
        let tetrahedron = [0, 1, 2, 0, 2, 3, 0, 3, 1, 3, 2, 1];
        assert_eq!(outcome(&tetrahedron, 0, 1), CollapseOutcome::Ends);
        assert_eq!(outcome(&[0, 1, 2, 0, 2, 1], 0, 1), CollapseOutcome::Ends, "two triangles back to back");
        assert_eq!(outcome(&[0, 1, 2], 0, 1), CollapseOutcome::Ends);
        assert_eq!(outcome(&[0, 1, 2, 2, 1, 3], 0, 1), CollapseOutcome::Keeps);
        assert_eq!(outcome(&[0, 1, 2, 2, 1, 3], 2, 1), CollapseOutcome::Ends, "both triangles");
        // The sides of a prism. Its three corners at each end surround a hole.
        let sides = [0, 1, 3, 3, 1, 4, 1, 2, 4, 4, 2, 5, 2, 0, 5, 5, 0, 3];
        assert_eq!(outcome(&sides, 0, 1), CollapseOutcome::Breaks);
        assert_eq!(
            outcome(&[0, 1, 2, 0, 3, 4, 1, 5, 6], 0, 1),
            CollapseOutcome::Loses,
            "three triangles in a row"
        );
    }
}
