//! Measures the deviation of new triangles from the full mesh, to enforce an error limit on the
//! whole surface.
//!
//! The distances of removed points measure how far the full mesh is from the surface. They can miss
//! triangles that bridge a valley without points, so the distance from the surface to the full mesh
//! is measured, too. The module `neighbourhood` compares new edges with the triangles that they
//! replace, but these can already deviate from the full mesh:
//!
//! ```text
//!   ·───────────·  now
//!    ╲    ↕    ╱
//!     ·───────·    before
//!      ╲  ↕  ╱
//!       ╲___╱      full mesh
//! ```
//! The deviation of a triangle is an upper estimate of its distance from the full mesh: the maximum
//! deviation of the triangles that it replaces, plus its distance from them. If the estimate is
//! within the error limit, no search is needed. Otherwise a search finds the distances of sample
//! positions on the new triangles from the full mesh, and the deviation is the maximum of these
//! distances. Searches are therefore needed only near the limit.
//!
//! # Complexity
//! 16 bytes per triangle, and 14 more for the tree of the module `box_tree` once it is needed.

use super::box_tree::TriangleBoxTree;
use super::neighbourhood::Neighbourhood;
use crate::simplify::price::best_collapse::finite;
use crate::simplify::surface::topology::Topology;
use crate::vector::Point;

/// The deviation of each triangle, and the full mesh.
#[derive(Debug)]
pub(crate) struct TriangleDeviations {
    /// The deviations of the triangles, in units of the frame.
    of_triangles: Vec<f32>,
    /// The triangles of the full mesh.
    full: Vec<[u32; 3]>,
    tree: Option<TriangleBoxTree>,
    /// The deviation after the last allowed collapse.
    after: f32,
}

impl TriangleDeviations {
    /// Creates the deviations of a full mesh, all 0.
    pub(crate) fn new(triangles: &[[u32; 3]]) -> Self {
        Self { of_triangles: vec![0.0; triangles.len()], full: triangles.to_vec(), tree: None, after: 0.0 }
    }

    /// Returns whether the new triangles of a collapse are within a distance of the full mesh.
    /// `point` is the point of the neighbourhood, `to` the kept one. If so, stores their deviation
    /// for [`TriangleDeviations::collapse`].
    pub(crate) fn allow(
        &mut self,
        topology: &Topology,
        positions: &[Point],
        (around, point, to): (&mut Neighbourhood, u32, u32),
        limit: f64,
    ) -> bool {
        let kept = positions[to as usize];
        let around_point = topology.ring(point).iter().map(|corner| self.of_triangles[corner.triangle()]);
        let bound =
            f64::from(around_point.fold(0.0, f32::max)) + around.bridge(to, kept, limit * limit).sqrt();
        let deviation = if bound <= limit {
            Some(bound)
        } else {
            let tree = self.tree.get_or_insert_with(|| TriangleBoxTree::new(positions, &self.full));
            let found = |place| tree.within(positions, &self.full, place, limit * limit);
            let mut places = around.new_places(to, kept);
            places.try_fold(0.0, |largest, place| Some(f64::max(largest, found(place)?))).map(f64::sqrt)
        };
        self.after = finite(deviation.unwrap_or(limit));
        deviation.is_some()
    }

    /// Sets the deviation of the triangles that remain after the last allowed collapse.
    pub(crate) fn collapse(&mut self, topology: &Topology, point: u32, to: u32) {
        for (corner, edge) in topology.ring(point).iter().zip(topology.opposite(point)) {
            if !edge.contains(&to) {
                self.of_triangles[corner.triangle()] = self.after;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::mesh::{Faces, Mesh};
    use crate::simplify::tests::grid;
    use crate::simplify::{SimplifyOptions, simplify_triangles};
    use crate::vector::{Point, to_triangle};

    /// Returns the maximum distance of sample positions on triangles from other triangles.
    fn farthest(from: &[[Point; 3]], to: &[[Point; 3]]) -> f64 {
        let shares =
            (0..=4).flat_map(|i| (0..=4 - i).map(move |j| [i, j, 4 - i - j].map(|n| f64::from(n) / 4.0)));
        let places = from.iter().flat_map(|corners| {
            let at = |shares: [f64; 3]| [0, 1, 2].map(|k| (0..3).map(|i| shares[i] * corners[i][k]).sum());
            shares.clone().map(at)
        });
        let square = |place: Point| {
            to.iter().fold(f64::INFINITY, |least, &triangle| to_triangle(place, triangle, least))
        };
        places.map(square).fold(0.0, f64::max).sqrt()
    }

    /// The error limit holds all over both surfaces, although each collapse is compared only with
    /// the previous state.
    #[test]
    fn both_surfaces_are_within_the_error_limit() {
        for (size, limit) in [([24, 24], 0.3_f32), ([24, 24], 0.08), ([24, 24], 0.02), ([9, 6], 0.4)] {
            let (positions, triangles) = grid(size[0], size[1], [true, true]);
            let mesh = Mesh::new(positions, Faces::default()).unwrap();
            let options = SimplifyOptions::default().with_error(limit);
            let simple = simplify_triangles(&mesh, triangles, &options).unwrap().sequence;
            let place = |triangle: &[u32; 3]| triangle.map(|v| mesh.positions()[v as usize].map(f64::from));
            let [full, base] = [simple.len(), 0]
                .map(|level| simple.drawn(level).unwrap().iter().map(place).collect::<Vec<_>>());
            assert!(base.len() < full.len(), "{limit}");
            let found = [farthest(&full, &base), farthest(&base, &full)].map(|far| far / f64::from(limit));
            assert!(found.iter().all(|&share| share < 1.1), "{limit}: {found:?}");
        }
    }
}
