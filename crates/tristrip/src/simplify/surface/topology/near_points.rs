//! Joins points at open borders that are near each other.
//!
//! ```text
//!    ·─────a1 b1─────·
//!    │    ╱ │ │ ╲    │
//!    ·───a2 │ │ b2───·
//!      ╲  │ │ │ │  ╱
//! ```
//! The figure shows two sheets whose borders should be one. If the borders are kept apart, each is
//! simplified separately, and a crack opens between them. If they are joined, a1 and b1 are one
//! point with a vertex on each side, as on a seam, and both sides collapse in the same way.
//!
//! Positions are not changed, so a gap keeps its width. Points inside a surface are not joined: two
//! sheets near each other remain separate.
//!
//! # Algorithm
//! The points are processed in the order of their indices. Each point joins the nearest point
//! within the distance that has not joined another one. Ties go to the lowest index. A point does
//! not join if a triangle contains both it and a point that is joined to the same target, so no
//! triangle becomes degenerate.
//!
//! # Complexity
//! O(n) time for n points that are not inner points, with their triangles. Inner points take no
//! time.

use super::{PointKind, Topology};
use crate::mesh::{NearPositions, Positions};

impl Topology {
    /// Returns for each point the point that it joins, or itself; `None` if no point joins another.
    pub(super) fn near_points<P: Positions + ?Sized>(
        &self,
        positions: &P,
        weld_distance: f32,
    ) -> Option<Vec<u32>> {
        let mut grid = NearPositions::new(weld_distance).ok()?;
        let mut joined: Option<Vec<u32>> = None;
        let mut adjacent = Vec::new();
        for point in (0..self.point_count() as u32).filter(|&p| self.kind(p) != PointKind::Inner) {
            let position = positions.position(self.vertex_of(point) as usize).unwrap_or_default();
            let mut near: Vec<(f64, u32)> = grid.near(position).collect();
            if !near.is_empty() {
                // A point does not join points of its own triangles.
                let others = self.opposite(point).iter().flatten();
                adjacent.clear();
                adjacent.extend(others.map(|&p| joined.as_ref().map_or(p, |joined| joined[p as usize])));
                adjacent.sort_unstable();
                near.retain(|(_, other)| adjacent.binary_search(other).is_err());
            }
            match near.into_iter().min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))) {
                Some((_, other)) => {
                    let all = joined.get_or_insert_with(|| (0..self.point_count() as u32).collect());
                    all[point as usize] = other;
                }
                // There are fewer points than 32-bit ids.
                None => grid.insert(point, position).ok()?,
            }
        }
        joined
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::is_degenerate;
    use proptest::prelude::*;

    fn topology(positions: &[[f32; 3]], triangles: &[u32], weld_distance: f32) -> Topology {
        Topology::new(positions, |_| Vec::new(), triangles, false, weld_distance)
    }

    /// Joins points by the definition, comparing each with all others.
    fn joined_by_definition(topology: &Topology, positions: &[[f32; 3]], distance: f64) -> Vec<u32> {
        let mut joined: Vec<u32> = (0..topology.point_count() as u32).collect();
        let at = |p: u32| positions[topology.vertex_of(p) as usize].map(f64::from);
        for point in 0..joined.len() as u32 {
            let mut best: Option<(f64, u32)> = None;
            for other in 0..point {
                let is_first = joined[other as usize] == other;
                let is_apart = topology.triangles.iter().any(|triangle| {
                    triangle.contains(&point)
                        && triangle.iter().any(|&p| p != point && joined[p as usize] == other)
                });
                if [point, other].iter().any(|&p| topology.kind(p) == PointKind::Inner)
                    || !is_first
                    || is_apart
                {
                    continue;
                }
                let square: f64 = (0..3).map(|k| (at(point)[k] - at(other)[k]).powi(2)).sum();
                if square.sqrt() <= distance && best.is_none_or(|(least, _)| square.sqrt() < least) {
                    best = Some((square.sqrt(), other));
                }
            }
            joined[point as usize] = best.map_or(point, |(_, other)| other);
        }
        joined
    }

    proptest! {
        #[test]
        fn points_are_joined_as_defined(
            positions in prop::collection::vec([0..7_i8, 0..7, 0..2].prop_map(|p| p.map(f32::from)), 12),
            triangles in prop::collection::vec([0..12_u32, 0..12, 0..12].prop_filter("drawn", |&t| !is_degenerate(t)), 1..20),
            distance in 1..5_u8,
        ) {
            let distance = f32::from(distance) * 0.7;
            let apart = topology(&positions, triangles.as_flattened(), 0.0);
            let expected = joined_by_definition(&apart, &positions, distance.into());
            let found = apart.near_points(&positions[..], distance).unwrap_or_else(|| (0..expected.len() as u32).collect());
            prop_assert_eq!(&found, &expected);
            // The triangles have the joined points, and no additional triangle has two corners at
            // one point.
            let joined = topology(&positions, triangles.as_flattened(), distance);
            let count = |topology: &Topology| topology.triangles.iter().filter(|&&t| is_degenerate(t)).count();
            prop_assert_eq!(count(&apart), count(&joined));
            let firsts = (0..).zip(&expected).filter(|&(i, &p): &(u32, &u32)| i == p).count();
            prop_assert_eq!(joined.point_count(), firsts);
            for corner in joined.corners() {
                let of_apart = apart.point(corner);
                let first = joined.corners().find(|&c| expected[apart.point(c) as usize] == expected[of_apart as usize]);
                prop_assert_eq!(joined.point(corner), joined.point(first.unwrap()));
            }
        }
    }

    #[test]
    fn borders_are_joined_and_insides_are_not() {
        // Two fans, each around a centre, 0.01 apart: their rims are joined, their centres are not.
        let rim = |i: u32| [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]][i as usize];
        let sheet =
            |z: f32| (0..5).map(move |i| if i == 4 { [0.0, 0.0, z] } else { [rim(i)[0], rim(i)[1], z] });
        let positions: Vec<[f32; 3]> = sheet(0.0).chain(sheet(0.01)).collect();
        let fan = |first: u32| (0..4).flat_map(move |i| [first + 4, first + i, first + (i + 1) % 4]);
        let triangles: Vec<u32> = fan(0).chain(fan(5)).collect();
        assert_eq!(topology(&positions, &triangles, 0.005).point_count(), 10);
        assert_eq!(topology(&positions, &triangles, 0.011).point_count(), 6);
    }
}
