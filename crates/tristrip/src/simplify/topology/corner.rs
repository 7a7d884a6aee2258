//! Corners of triangles, by number.

/// A corner of a triangle: the triangle in the upper bits, the place in the lowest two, so that both come without a division.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(in crate::simplify) struct Corner(u32);

/// Places one and two further on.
pub(super) const NEXT: [usize; 4] = [1, 2, 0, 0];
pub(super) const LAST: [usize; 4] = [2, 0, 1, 0];

impl Corner {
    pub(in crate::simplify) fn new(triangle: usize, place: usize) -> Self {
        Self((triangle << 2 | place) as u32)
    }

    #[inline]
    pub(in crate::simplify) fn triangle(self) -> usize {
        (self.0 >> 2) as usize
    }

    #[inline]
    pub(in crate::simplify) fn place(self) -> usize {
        (self.0 & 3) as usize
    }

    pub(super) fn next(self) -> Self {
        Self::new(self.triangle(), NEXT[self.place()])
    }

    pub(super) fn last(self) -> Self {
        Self::new(self.triangle(), LAST[self.place()])
    }

    /// Where this corner stands among all, counted triangle by triangle.
    pub(super) fn index(self) -> usize {
        3 * self.triangle() + self.place()
    }
}

/// Gives all corners of so many triangles.
pub(super) fn corners(triangle_count: usize) -> impl Iterator<Item = Corner> {
    (0..triangle_count).flat_map(|t| (0..3).map(move |k| Corner::new(t, k)))
}
