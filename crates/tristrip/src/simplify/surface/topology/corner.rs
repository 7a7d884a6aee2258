//! Corners of triangles, as packed ids.

/// A corner of a triangle: the triangle in the upper bits, the index within the triangle in the
/// lowest two. Extracting them needs no division.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(crate) struct CornerId(u32);

/// The indices of the next and of the previous corner.
const NEXT: [usize; 4] = [1, 2, 0, 0];
const PREVIOUS: [usize; 4] = [2, 0, 1, 0];

impl CornerId {
    pub(crate) fn new(triangle: usize, k: usize) -> Self {
        Self((triangle << 2 | k) as u32)
    }

    #[inline]
    pub(crate) fn triangle(self) -> usize {
        (self.0 >> 2) as usize
    }

    /// Returns the index within the triangle.
    #[inline]
    pub(super) fn within(self) -> usize {
        (self.0 & 3) as usize
    }

    pub(crate) fn next(self) -> Self {
        Self::new(self.triangle(), NEXT[self.within()])
    }

    pub(crate) fn previous(self) -> Self {
        Self::new(self.triangle(), PREVIOUS[self.within()])
    }

    /// Returns the index of this corner among all corners, counted triangle by triangle.
    pub(super) fn index(self) -> usize {
        3 * self.triangle() + self.within()
    }

    /// Returns the points of the two other corners of the triangle, in winding order.
    #[inline]
    pub(super) fn others(self, triangles: &[[u32; 3]]) -> [u32; 2] {
        let triangle = &triangles[self.triangle()];
        [triangle[NEXT[self.within()]], triangle[PREVIOUS[self.within()]]]
    }
}

/// Iterates over all corners of this many triangles.
pub(super) fn corners(triangle_count: usize) -> impl Iterator<Item = CornerId> {
    (0..triangle_count).flat_map(|t| (0..3).map(move |k| CornerId::new(t, k)))
}
