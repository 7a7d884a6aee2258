//! Triangles as three vertices: degeneracy, and a canonical form that does not depend on the first
//! corner.

use crate::error::{Error, MeshProblem};

/// Returns the triangle rotated to its lowest vertex. Equal triangles with the same winding become
/// equal arrays.
pub(crate) fn canonical_triangle(triangle: [u32; 3]) -> [u32; 3] {
    match triangle {
        [a, b, c] if b < a && b < c => [b, c, a],
        [a, b, c] if c < a && c < b => [c, a, b],
        triangle => triangle,
    }
}

/// Returns whether a triangle contains a vertex more than once and therefore draws nothing.
#[inline]
pub(crate) fn is_degenerate([a, b, c]: [u32; 3]) -> bool {
    a == b || b == c || a == c
}

/// Checks that the number of corners is a multiple of three.
pub(crate) fn check_triangles(corner_count: usize) -> Result<(), Error> {
    if corner_count.is_multiple_of(3) {
        return Ok(());
    }
    let found = corner_count as u64;
    Err(MeshProblem::CornerCount { found, expected: "a multiple of 3".into() }.into())
}

/// Checks that every corner is less than the number of vertices.
pub(crate) fn check_corners(triangles: &[u32], vertex_count: usize) -> Result<(), Error> {
    let Some(corner) = triangles.iter().position(|&v| v as usize >= vertex_count) else { return Ok(()) };
    let (face, found) = ((corner / 3) as u32, triangles[corner]);
    let (corner, vertex_count) = ((corner % 3) as u32, vertex_count as u32);
    Err(MeshProblem::VertexIndex { face, corner, found, vertex_count }.into())
}

/// Returns the triangles that are not degenerate, in canonical form and sorted. Lists that draw the
/// same triangles become equal.
pub(crate) fn canonical_triangles(triangles: impl IntoIterator<Item = [u32; 3]>) -> Vec<[u32; 3]> {
    let real = triangles.into_iter().filter(|&t| !is_degenerate(t));
    let mut all: Vec<_> = real.map(canonical_triangle).collect();
    all.sort_unstable();
    all
}

/// Returns triangle `t` of a triangle list.
///
/// # Panics
/// Panics if the list has no triangle `t`.
#[inline]
pub(crate) fn triangle_at(list: &[u32], t: usize) -> [u32; 3] {
    let corners = &list[3 * t..3 * t + 3];
    [corners[0], corners[1], corners[2]]
}

/// Iterates over the triangles of a triangle list.
#[inline]
pub(crate) fn triangles_of(list: &[u32]) -> impl ExactSizeIterator<Item = [u32; 3]> + Clone {
    list.chunks_exact(3).map(|corners| [corners[0], corners[1], corners[2]])
}
