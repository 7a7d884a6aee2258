//! The edges of a triangle, numbered 0 to 2 in winding order.

/// Returns the next edge of the triangle.
#[inline]
pub(super) fn next(edge: u32) -> u32 {
    if edge == 2 { 0 } else { edge + 1 }
}

/// Returns the previous edge of the triangle.
#[inline]
pub(super) fn previous(edge: u32) -> u32 {
    if edge == 0 { 2 } else { edge - 1 }
}
