//! A tree of boxes around the triangles of the full mesh, for testing whether a position is near a
//! triangle.
//!
//! The triangles are sorted along a Morton curve. Every four consecutive triangles have a box,
//! every four of these boxes have a box, and so on. The tree consists only of its boxes, in one
//! array per level, lowest level first.
//!
//! ```text
//!   level 1   [───────────────────────]
//!   level 0   [────][────][────][─────]
//! ```
//! A search descends into the boxes within the query distance, nearest first, and ends at the first
//! triangle within this distance. Where the boxes of very many triangles overlap, the search stops
//! without a result.
//!
//! # Complexity
//! O(n log n) time to build; 14 bytes per triangle. A search takes O(log n) time if triangles are
//! of similar size, and visits at most [`MAX_GROUPS`] groups of boxes.

use wide::f32x4;

use crate::simplify::surface::curve::order_along_curve;
use crate::vector::{Point, to_triangle};

/// The number of boxes, or triangles, in a box.
const ARITY: usize = 4;
/// The maximum number of groups of boxes that a search visits.
const MAX_GROUPS: usize = 1024;
/// Boxes are enlarged by this share of the longest side of the frame, which exceeds the rounding of
/// 32-bit floats.
const MARGIN: f64 = 1e-6;

/// Four boxes, as minimum and maximum coordinates.
#[derive(Debug, Clone, Copy)]
struct BoxGroup {
    low: [f32x4; 3],
    high: [f32x4; 3],
}

impl BoxGroup {
    /// Creates a group of up to four boxes. Unused lanes are empty boxes.
    fn new(boxes: &[BoxBounds]) -> Self {
        let lanes = |end: usize, k: usize, none: f32| {
            let lane = |i: usize| boxes.get(i).map_or(none, |bounds| bounds[end][k]);
            f32x4::from([0, 1, 2, 3].map(lane))
        };
        let low = [0, 1, 2].map(|k| lanes(0, k, f32::INFINITY));
        Self { low, high: [0, 1, 2].map(|k| lanes(1, k, f32::NEG_INFINITY)) }
    }

    /// Returns the squared distances of a position from the boxes.
    fn squares(&self, place: [f32x4; 3]) -> [f32; ARITY] {
        let outside = |k: usize| {
            let outside: f32x4 = (self.low[k] - place[k]).fast_max(place[k] - self.high[k]);
            outside.fast_max(f32x4::ZERO)
        };
        let [x, y, z] = [0, 1, 2].map(outside);
        (x * x + y * y + z * z).to_array()
    }
}

/// The minimum and maximum coordinates of a box.
type BoxBounds = [[f32; 3]; 2];

/// The boxes around triangles.
#[derive(Debug)]
pub(crate) struct TriangleBoxTree {
    /// The triangles in the order of the tree.
    triangles: Vec<u32>,
    /// The boxes of each level, lowest level first. The highest level has one group.
    levels: Vec<Vec<BoxGroup>>,
}

impl TriangleBoxTree {
    /// Builds the boxes around triangles, given as indices into the positions, in a frame with
    /// sides of at most 1.
    pub(crate) fn new(positions: &[Point], triangles: &[[u32; 3]]) -> Self {
        let first = |triangle: &[u32; 3]| positions[triangle[0] as usize].map(|x| x as f32);
        let order = order_along_curve(triangles.iter().map(first));
        let corners = |t: &u32| triangles[*t as usize].map(|p| positions[p as usize]);
        let ends = |p: Point| [p.map(|x| (x - MARGIN) as f32), p.map(|x| (x + MARGIN) as f32)];
        let of_triangles = |group: &[u32]| around(group.iter().flat_map(corners).map(ends));
        let mut boxes: Vec<BoxBounds> = order.chunks(ARITY).map(of_triangles).collect();
        let mut levels = Vec::new();
        while boxes.len() > ARITY {
            levels.push(boxes.chunks(ARITY).map(BoxGroup::new).collect());
            boxes = boxes.chunks(ARITY).map(|group| around(group.iter().copied())).collect();
        }
        levels.push(vec![BoxGroup::new(&boxes)]);
        Self { triangles: order, levels }
    }

    /// Returns the squared distance of a position from a triangle that is near enough, not
    /// necessarily the nearest. Returns `None` if there is none or the search reaches its limit.
    pub(crate) fn within(
        &self,
        positions: &[Point],
        triangles: &[[u32; 3]],
        place: Point,
        most_square: f64,
    ) -> Option<f64> {
        let lanes = place.map(|x| f32x4::splat(x as f32));
        let mut search =
            NearestSearch { tree: self, positions, triangles, place, lanes, most_square, left: MAX_GROUPS };
        search.group(self.levels.len() - 1, 0)
    }
}

/// A search for a triangle near a position.
struct NearestSearch<'a> {
    tree: &'a TriangleBoxTree,
    positions: &'a [Point],
    triangles: &'a [[u32; 3]],
    place: Point,
    /// The position, repeated for each of four boxes.
    lanes: [f32x4; 3],
    most_square: f64,
    /// The number of groups that may still be visited.
    left: usize,
}

impl NearestSearch<'_> {
    /// Searches the boxes of a group that are near enough, nearest first.
    fn group(&mut self, level: usize, group: usize) -> Option<f64> {
        self.left = self.left.checked_sub(1)?;
        let mut squares = self.tree.levels[level][group].squares(self.lanes);
        loop {
            let (nearest, square) = (0..ARITY).zip(squares).min_by(|a, b| a.1.total_cmp(&b.1))?;
            if f64::from(square) > self.most_square {
                return None;
            }
            squares[nearest] = f32::INFINITY;
            let below = ARITY * group + nearest;
            let found = match level.checked_sub(1) {
                Some(level) => self.group(level, below),
                None => self.triangles(below),
            };
            if found.is_some() {
                return found;
            }
        }
    }

    /// Searches the triangles of a box.
    fn triangles(&self, group: usize) -> Option<f64> {
        let of_group = self.tree.triangles.iter().skip(ARITY * group).take(ARITY);
        let corners = of_group.map(|&t| self.triangles[t as usize].map(|p| self.positions[p as usize]));
        let mut squares = corners.map(|corners| to_triangle(self.place, corners, f64::INFINITY));
        squares.find(|&square| square <= self.most_square)
    }
}

/// Returns the bounding box of boxes.
fn around(boxes: impl Iterator<Item = BoxBounds>) -> BoxBounds {
    boxes.fold([[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]], |[low, high], [other_low, other_high]| {
        [
            [0, 1, 2].map(|k| f32::min(low[k], other_low[k])),
            [0, 1, 2].map(|k| f32::max(high[k], other_high[k])),
        ]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn a_search_finds_a_triangle_if_any_is_near_enough() {
        let mut random = Random::new(5);
        for count in [1_u32, 3, 4, 5, 17, 300] {
            let mut number = |n: usize| random.below(n) as f64 / n as f64;
            let positions: Vec<Point> =
                (0..3 * count).map(|_| [number(1000), number(1000), number(3)]).collect();
            // Small triangles, and some that are large or have no area.
            let last = positions.len() as u32 - 1;
            let triangles: Vec<[u32; 3]> =
                (0..count).map(|t| [3 * t, (3 * t + 1 + t % 7 / 6).min(last), 3 * t + t % 3]).collect();
            let tree = TriangleBoxTree::new(&positions, &triangles);
            for _ in 0..100 {
                let (place, most) = ([number(1000), number(1000), number(1000)], 0.1 * number(100));
                let corners = triangles.iter().map(|t| t.map(|p| positions[p as usize]));
                let least =
                    corners.fold(f64::INFINITY, |least, triangle| to_triangle(place, triangle, least));
                let found = tree.within(&positions, &triangles, place, most);
                assert_eq!(found.is_some(), least <= most);
                assert!(found.is_none_or(|found| (least..=most).contains(&found)), "{found:?} {least}");
            }
        }
    }

    /// Many triangles that extend through the whole box, none near the position: the search reaches
    /// its limit.
    #[test]
    fn a_search_visits_a_bounded_number_of_boxes() {
        let count = 30_000_u32;
        let positions: Vec<Point> =
            (0..=count).map(|i| [f64::from(i % 2), f64::from(i % 2), f64::from(i) * 1e-9]).collect();
        let triangles: Vec<[u32; 3]> = (0..count - 1).map(|t| [t, t + 1, t + 2]).collect();
        let tree = TriangleBoxTree::new(&positions, &triangles);
        assert_eq!(tree.within(&positions, &triangles, [0.9, 0.1, 0.0], 0.1), None);
        assert!(tree.within(&positions, &triangles, [1.0, 1.0, 0.0], 0.1).is_some());
    }
}
