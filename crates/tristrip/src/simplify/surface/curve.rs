//! Triangles in the order of a space-filling curve, for memory locality.
//!
//! Points are numbered in the order in which the triangles use them. If the triangles of a file are
//! in random order, or in an order with large jumps, the points around a triangle are scattered in
//! memory. Every collapse then causes cache misses. In this case the triangles are sorted by the
//! cell that contains their first corner. There are 1024³ cells along a Morton curve: x, y and z
//! bit by bit.
//!
//! # References
//! Morton: *A Computer Oriented Geodetic Data Base and a New Technique in File Sequencing*, IBM,
//! 1966.

use crate::mesh::{Positions, triangles_of};

/// The maximum difference of the indices of a triangle's points that counts as near in memory.
const FAR: u32 = 1024;
/// All triangles are sorted if more than one in this many has points that are far apart.
const FEW: usize = 8;
const CELL_BITS: u32 = 10;

/// Returns the triangles in the order of a curve, or `None` if the points of most are already near
/// each other in memory. `points` are those of the corners, numbered in the order of their first
/// use.
pub(crate) fn along_curve<P: Positions + ?Sized>(
    positions: &P,
    vertices: &[u32],
    points: &[u32],
) -> Option<Vec<u32>> {
    let is_far = |[a, b, c]: &[u32; 3]| a.abs_diff(*b).max(b.abs_diff(*c)) > FAR;
    if triangles_of(points).filter(is_far).count() <= points.len() / 3 / FEW {
        return None;
    }
    let first = |[v, ..]: [u32; 3]| positions.position(v as usize).unwrap_or_default();
    Some(order_along_curve(triangles_of(vertices).map(first)))
}

/// Returns the indices of positions in the order of the curve through their bounding box. Those in
/// the same cell keep their order.
pub(crate) fn order_along_curve(places: impl Iterator<Item = [f32; 3]> + Clone) -> Vec<u32> {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for p in places.clone() {
        for k in 0..3 {
            low[k] = low[k].min(p[k]);
            high[k] = high[k].max(p[k]);
        }
    }
    let side = (0..3).map(|k| f64::from(high[k]) - f64::from(low[k])).fold(0.0, f64::max);
    let scale = if side > 0.0 { f64::from((1 << CELL_BITS) - 1) / side } else { 0.0 };
    let along = |x: f32, low: f32| spread((((f64::from(x) - f64::from(low)) * scale) as i32).unsigned_abs());
    let cell = |[x, y, z]: [f32; 3]| along(x, low[0]) | along(y, low[1]) << 1 | along(z, low[2]) << 2;
    let mut cells: Vec<(u32, u32)> = places.map(cell).zip(0..).collect();
    cells.sort_unstable();
    cells.into_iter().map(|(_, place)| place).collect()
}

/// Returns the ten lowest bits, with two zeros after each.
fn spread(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_spread_by_two() {
        for x in 0..1024_u32 {
            let expected = (0..10).map(|bit| (x >> bit & 1) << (3 * bit)).sum::<u32>();
            assert_eq!(spread(x), expected, "{x}");
        }
    }

    #[test]
    fn triangles_far_apart_are_sorted_and_others_left() {
        // Separate triangles on a line, in an order that jumps.
        let count = 4096_u32;
        let jump = |t: u32| t * 1031 % count;
        let vertices: Vec<u32> = (0..count).map(jump).flat_map(|t| [t, t + 1, t + 2]).collect();
        let positions: Vec<[f32; 3]> = (0..count + 2).map(|i| [i as f32, 0.0, 0.0]).collect();
        let order = along_curve(&positions[..], &vertices, &vertices);
        assert_eq!(order, None, "the numbers themselves lie together");
        let mut numbers = std::collections::HashMap::new();
        let points: Vec<u32> = vertices
            .iter()
            .map(|&v| {
                let next = numbers.len() as u32;
                *numbers.entry(v).or_insert(next)
            })
            .collect();
        let order = along_curve(&positions[..], &vertices, &points).unwrap();
        let firsts: Vec<u32> = order.iter().map(|&t| jump(t)).collect();
        // Four positions share a cell and keep their order.
        assert!(firsts.windows(2).all(|pair| pair[0] < pair[1] + 5), "along the line");
        let mut sorted = order;
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..count));
    }
}
