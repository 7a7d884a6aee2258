//! Attribute quadrics: how far the values at a vertex are from the values of the full mesh at the
//! same position.
//!
//! ```text
//!         ╱ value of a triangle: gradient · p + offset
//!       ╱       ┬
//!     ╱         │ deviation
//!   b ───────── a      b collapses to a: its triangles get the position and values of a
//! ```
//! Every value is linear over each triangle of the full mesh. The quadric of a vertex is the
//! area-weighted sum of the squared deviations from all triangles that it represents, as a
//! polynomial in the position and the values. A collapse adds the quadrics, so errors of earlier
//! collapses are included.
//!
//! Each vertex of a seam has its own quadric for the triangles on its side. Vertices with the same
//! attributes share a quadric.
//!
//! # References
//! Hoppe: *New Quadric Metric for Simplifying Meshes with Appearance Attributes*, 1999, section 3.
//! There the quadric includes the distance from the planes. Here the planes have a separate quadric
//! per point, because the vertices of a seam share it.
//!
//! # Complexity
//! 88 bytes per vertex, and 32 more per value. Constant time per value and vertex.

use super::attributes::PricedAttributes;
use crate::collapse::Rename;
use crate::simplify::surface::topology::{CornerId, Topology};
use crate::vector::{Point, cross, dot, normal_of, sub};

/// The minimum squared double area, in units of the frame, of a triangle with a gradient.
const MIN_SQUARE: f64 = 1e-24;
/// The coefficients of a quadric before those of the values: weight, gradient × gradient (6),
/// gradient × offset (3), offset².
const SHARED: usize = 11;
/// The coefficients per value: gradient (3), offset.
const PER_VALUE: usize = 4;

/// The quadrics of the vertices, and their values.
#[derive(Debug)]
pub(crate) struct AttributeQuadrics {
    values: PricedAttributes,
    /// For each vertex, the first vertex of the same point with the same attributes.
    first_equal: Vec<u32>,
    quadrics: Vec<f64>,
}

impl AttributeQuadrics {
    /// Sums the quadrics of the triangles around each vertex.
    pub(crate) fn new(topology: &Topology, positions: &[Point], values: PricedAttributes) -> Self {
        let vertex_count = values.vertex_count();
        let size = SHARED + PER_VALUE * values.width();
        let first_equal = (0..vertex_count as u32).map(|v| topology.first_equal(v)).collect();
        let mut all = Self { values, first_equal, quadrics: vec![0.0; size * vertex_count] };
        let mut quadric = vec![0.0; size];
        for (t, triangle) in topology.triangles.iter().enumerate() {
            let vertices = [0, 1, 2].map(|k| topology.wedge(CornerId::new(t, k)));
            let corners = triangle.map(|p| positions[p as usize]);
            if !set_triangle(&mut quadric, corners, vertices.map(|v| all.values.of(v))) {
                continue;
            }
            for v in vertices {
                let at = all.first_equal[v as usize] as usize * size;
                all.quadrics[at..at + size].iter_mut().zip(&quadric).for_each(|(sum, x)| *sum += x);
            }
        }
        all
    }

    /// Returns the area-weighted sum of the squared deviations after renaming vertices, at the
    /// position of the kept point.
    pub(crate) fn change(&self, renames: &[Rename], kept: Point) -> f64 {
        let first = |rename: &Rename| self.first_equal[rename.removed as usize];
        let mut sum = 0.0;
        for (i, rename) in renames.iter().enumerate() {
            let removed = first(rename);
            if renames[..i].iter().all(|earlier| first(earlier) != removed) {
                sum += deviation(self.of(removed), kept, self.values.of(rename.kept));
            }
        }
        sum
    }

    /// Returns the squared difference of the values of two vertices.
    pub(crate) fn difference(&self, a: u32, b: u32) -> f64 {
        let pairs = self.values.of(a).iter().zip(self.values.of(b));
        pairs.map(|(&a, &b)| (f64::from(a) - f64::from(b)).powi(2)).sum()
    }

    /// Adds the quadrics of removed vertices to those of the vertices that replace them.
    pub(crate) fn merge(&mut self, renames: &[Rename]) {
        let size = self.size();
        for rename in renames {
            let [removed, kept] =
                [rename.removed, rename.kept].map(|v| self.first_equal[v as usize] as usize * size);
            for k in 0..size {
                // Equal vertices share one quadric, which is added once.
                let moved = std::mem::take(&mut self.quadrics[removed + k]);
                self.quadrics[kept + k] += moved;
            }
        }
    }

    fn size(&self) -> usize {
        SHARED + PER_VALUE * self.values.width()
    }

    fn of(&self, vertex: u32) -> &[f64] {
        &self.quadrics[vertex as usize * self.size()..][..self.size()]
    }
}

/// Evaluates a quadric at a position and values. A sum that becomes negative by rounding counts as
/// zero.
fn deviation(quadric: &[f64], [x, y, z]: Point, values: &[f32]) -> f64 {
    let (shared, of_values) = quadric.split_at(SHARED);
    let &[weight, xx, yy, zz, xy, xz, yz, xd, yd, zd, dd] = shared else { return 0.0 };
    let mut sum = x * (xx * x + 2.0 * (xy * y + xz * z + xd))
        + y * (yy * y + 2.0 * (yz * z + yd))
        + z * (zz * z + 2.0 * zd)
        + dd;
    for (&value, [gx, gy, gz, offset]) in values.iter().zip(of_values.as_chunks().0) {
        let value = f64::from(value);
        sum += value * (weight * value - 2.0 * (gx * x + gy * y + gz * z + offset));
    }
    sum.max(0.0)
}

/// Sets a quadric to that of a triangle with values at its corners. Returns whether the triangle
/// has a gradient.
fn set_triangle(quadric: &mut [f64], corners: [Point; 3], values: [&[f32]; 3]) -> bool {
    let normal = normal_of(corners);
    let square = dot(normal, normal);
    if square < MIN_SQUARE {
        return false;
    }
    let [a, b, c] = corners;
    // The gradients of the barycentric coordinates of b and c.
    let of_b = cross(sub(c, a), normal).map(|x| x / square);
    let of_c = cross(normal, sub(b, a)).map(|x| x / square);
    let weight = square.sqrt();
    let (shared, of_values) = quadric.split_at_mut(SHARED);
    shared.fill(0.0);
    shared[0] = weight;
    for (k, slot) in of_values.as_chunks_mut::<PER_VALUE>().0.iter_mut().enumerate() {
        let [at_a, at_b, at_c] = values.map(|values| f64::from(values[k]));
        let [x, y, z] = [0, 1, 2].map(|i| (at_b - at_a) * of_b[i] + (at_c - at_a) * of_c[i]);
        let d = at_a - dot([x, y, z], a);
        let products = [x * x, y * y, z * z, x * y, x * z, y * z, x * d, y * d, z * d, d * d];
        shared[1..].iter_mut().zip(products).for_each(|(sum, product)| *sum += weight * product);
        *slot = [x, y, z, d].map(|x| weight * x);
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::nearest_in_triangle;
    use proptest::array::uniform3;
    use proptest::prelude::*;

    fn quadric_of(corners: [Point; 3], values: [[f32; 2]; 3]) -> Option<Vec<f64>> {
        let mut quadric = vec![0.0; SHARED + 2 * PER_VALUE];
        set_triangle(&mut quadric, corners, [&values[0], &values[1], &values[2]]).then_some(quadric)
    }

    proptest! {
        /// Inside a triangle, the deviation from the interpolated values is multiplied by twice the
        /// area.
        #[test]
        fn is_the_deviation_from_interpolated_values(
            corners in uniform3(uniform3(0.0..1.0)),
            values in uniform3((-1.0_f32..1.0, -1.0_f32..1.0)),
            towards in uniform3(0.0..1.0),
            own in (-1.0_f32..1.0, -1.0_f32..1.0),
        ) {
            let normal = normal_of(corners);
            let area = dot(normal, normal).sqrt();
            prop_assume!(area > 0.05);
            let values = values.map(|(u, v)| [u, v]);
            let shares = nearest_in_triangle(towards, corners);
            let mixed = |of: [f64; 3]| (0..3).map(|i| shares[i] * of[i]).sum::<f64>();
            let at = [0, 1, 2].map(|k| mixed(corners.map(|corner| corner[k])));
            let own = [own.0, own.1];
            let expected: f64 = [0, 1]
                .map(|k| (mixed(values.map(|v| v[k].into())) - f64::from(own[k])).powi(2) * area)
                .iter()
                .sum();
            let quadric = quadric_of(corners, values).unwrap();
            prop_assert!((deviation(&quadric, at, &own) - expected).abs() < 1e-6);
        }
    }

    #[test]
    fn triangles_without_area_have_no_gradient() {
        let line = [[0.0; 3], [0.5; 3], [1.0; 3]];
        assert!(quadric_of(line, [[0.0; 2], [9.0; 2], [f32::MAX; 2]]).is_none());
        let sliver = [[0.0; 3], [1.0, 0.0, 0.0], [0.5, 1e-11, 0.0]];
        let quadric = quadric_of(sliver, [[f32::MAX; 2], [-f32::MAX; 2], [0.0; 2]]).unwrap();
        assert!(deviation(&quadric, [0.0, 1.0, 0.0], &[f32::MAX; 2]).is_finite());
    }
}
