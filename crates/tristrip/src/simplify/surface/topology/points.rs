//! The vertices of each point, and which of them have the same attributes.

use std::collections::HashMap;

use crate::ids::OptionalId;
use crate::mesh::{triangle_at, vertex_bound};

/// Returns the corners of the given triangles, in their order.
pub(super) fn picked(corners: &[u32], triangles: &[u32]) -> Vec<u32> {
    triangles.iter().flat_map(|&t| triangle_at(corners, t as usize)).collect()
}

/// Numbers points in the order of their first use.
pub(super) fn by_first_use(mut points: Vec<u32>) -> Vec<u32> {
    let mut numbers = vec![OptionalId::NONE; vertex_bound(&points)];
    let mut count = 0;
    for point in &mut points {
        let number = &mut numbers[*point as usize];
        *point = number.get().unwrap_or(count);
        if *point == count {
            *number = OptionalId::some(count);
            count += 1;
        }
    }
    points
}

/// Returns the lowest vertex of each point. Points must be numbered in the order in which corners
/// first use them.
pub(super) fn lowest_vertices(vertices: &[u32], points: &[u32]) -> Vec<u32> {
    let mut lowest: Vec<u32> = Vec::new();
    for (&v, &point) in vertices.iter().zip(points) {
        match lowest.get_mut(point as usize) {
            Some(lowest) => *lowest = v.min(*lowest),
            None => lowest.push(v),
        }
    }
    lowest
}

/// Returns for each vertex on a seam the first vertex of its point with the same attributes.
pub(super) fn equal_vertices(
    attribute_bits: impl Fn(u32) -> Vec<u8>,
    vertices: &[u32],
    points: &[u32],
    on_seam: &[bool],
) -> HashMap<u32, u32> {
    let (mut equal, mut first) = (HashMap::new(), HashMap::new());
    let is_on_seam = |&(_, &p): &(&u32, &u32)| on_seam.get(p as usize) == Some(&true);
    for (&v, &p) in vertices.iter().zip(points).filter(is_on_seam) {
        equal.entry(v).or_insert_with(|| *first.entry((p, attribute_bits(v))).or_insert(v));
    }
    equal
}
