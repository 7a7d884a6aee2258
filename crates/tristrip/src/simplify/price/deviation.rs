//! How far the new triangles are from the full mesh, so that an error limit holds for the whole surface.
//!
//! Removed points tell how far the full mesh is from the surface. The other direction is where triangles bridge a valley: the full mesh has
//! no point there. The module `neighbourhood` compares new edges with the triangles that they replace, which may be off already:
//!
//! ```text
//!   ·───────────·  now             The deviation of a triangle is an estimate of its distance from the full mesh from above: the largest of
//!    ╲    ↕    ╱                   those that it replaces, and the distance from these. As long as it is below the error limit, that is
//!     ·───────·    before          all. If not, places on the new triangles are searched in the full mesh, and the deviation is the largest
//!      ╲  ↕  ╱                     distance found there.
//!       ╲___╱      full mesh
//! ```
//! So searches are needed only where the limit is near.
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
    /// Those of the triangles, in units of the frame.
    of_triangles: Vec<f32>,
    /// The triangles of the full mesh.
    full: Vec<[u32; 3]>,
    tree: Option<TriangleBoxTree>,
    /// The deviation after the collapse that was allowed last.
    after: f32,
}

impl TriangleDeviations {
    /// Of a full mesh.
    pub(crate) fn new(triangles: &[[u32; 3]]) -> Self {
        Self { of_triangles: vec![0.0; triangles.len()], full: triangles.to_vec(), tree: None, after: 0.0 }
    }

    /// Checks whether the new triangles of a collapse, of the point of a neighbourhood to another, are within a distance of the full mesh. If
    /// so, it keeps their deviation for [`TriangleDeviations::collapse`].
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

    /// Sets the deviation of the triangles that are left when a point goes to another, in the collapse that was allowed last.
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

    /// Returns the largest distance of places on some triangles from others.
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

    /// The error limit holds for places all over both surfaces, although every collapse is compared with the one before alone.
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
