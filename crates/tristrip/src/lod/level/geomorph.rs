//! Geomorphs: smooth transitions between two levels.
//!
//! Switching levels is visible because vertices jump. A geomorph draws the strips of the finer
//! level and moves each vertex that the coarser level lacks toward the vertex it collapses to.
//! Weight 0 draws the finer level. At weight 1, the triangles that the coarser level drops are
//! degenerate, and the surface is the same as at the coarser level. The index buffer can then be
//! switched without a visible change.
//!
//! [`SkipView::geomorphs`](crate::lod::SkipView::geomorphs) computes geomorphs between two states
//! of a view.
//!
//! ```text
//! finer level           weight ½             coarser level
//!   kept ──── removed     kept ── ◦            kept
//! ```
//! # References
//! Hoppe: *Progressive Meshes*, 1996, section 4.1.

use crate::collapse::CollapseSequence;
use crate::error::Error;
use crate::text::counted;

/// A vertex that moves between two levels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transit {
    /// The vertex that moves, which exists only at the finer level.
    pub vertex: u32,
    /// The vertex of the coarser level to which `vertex` collapses.
    pub target: u32,
}

/// The vertices that move between two levels.
///
/// ```
#[doc = include_str!("../example.txt")]
/// let geomorph = Geomorph::between(&sequence, 2, 0)?;
/// assert_eq!(geomorph.transits(), [Transit { vertex: 3, target: 2 }, Transit { vertex: 4, target: 2 }]);
/// // One value per vertex; weight 0.5.
/// let heights = [0.0, 1.0, 2.0, 3.0, 4.0];
/// let mut drawn = heights;
/// geomorph.blend(0.5, 1, &heights, &mut drawn)?;
/// assert_eq!(drawn, [0.0, 1.0, 2.0, 2.5, 3.0]);
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Geomorph {
    transits: Vec<Transit>,
    vertex_count: usize,
}

impl Geomorph {
    /// Creates a geomorph from transits sorted by vertex, for a mesh of `vertex_count` vertices.
    pub(crate) fn new(transits: Vec<Transit>, vertex_count: usize) -> Self {
        Self { transits, vertex_count }
    }

    /// Finds the vertices that move between two levels, given in any order. O(n) time for n
    /// vertices.
    ///
    /// # Errors
    /// `a` or `b` is greater than the level of the full mesh.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// assert_eq!(Geomorph::between(&sequence, 1, 2)?, Geomorph::between(&sequence, 2, 1)?);
    /// assert!(Geomorph::between(&sequence, 1, 1)?.transits().is_empty());
    /// assert!(Geomorph::between(&sequence, 1, 3).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn between(sequence: &CollapseSequence, a: usize, b: usize) -> Result<Self, Error> {
        let [fine, coarse] = [a.max(b), a.min(b)].map(|level| sequence.renaming(level));
        let both = (0..).zip(fine?.into_iter().zip(coarse?));
        let between = both.filter(|&(vertex, (fine, coarse))| fine == vertex && coarse != vertex);
        let transits = between.map(|(vertex, (_, target))| Transit { vertex, target }).collect();
        Ok(Self::new(transits, sequence.vertex_count()))
    }

    /// Returns the vertices that move, in ascending order.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// assert_eq!(Geomorph::between(&sequence, 1, 0)?.transits(), [Transit { vertex: 3, target: 2 }]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn transits(&self) -> &[Transit] {
        &self.transits
    }

    /// Writes the interpolated values of the moving vertices; all other values in `drawn` are left
    /// unchanged. The weight runs from 0 (the finer level) to 1 (the coarser level).
    ///
    /// `values` and `drawn` contain `components` numbers per vertex: positions, texture
    /// coordinates, or normals, which must be normalized afterwards. At weights 0 and 1 the results
    /// are exactly the values of the vertex and of its target.
    ///
    /// # Errors
    /// The weight is not between 0 and 1, or a slice does not contain `components` numbers per
    /// vertex.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let geomorph = Geomorph::between(&sequence, 2, 1)?;
    /// let points = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [0.0, 2.0]];
    /// let mut drawn = points;
    /// geomorph.blend(0.25, 2, points.as_flattened(), drawn.as_flattened_mut())?;
    /// assert_eq!(drawn[4], [0.25, 1.75]);
    /// assert!(geomorph.blend(2.0, 2, points.as_flattened(), drawn.as_flattened_mut()).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn blend(
        &self,
        weight: f32,
        components: usize,
        values: &[f32],
        drawn: &mut [f32],
    ) -> Result<(), Error> {
        if !(0.0..=1.0).contains(&weight) {
            return Err(Error::Parameter { name: "weight", found: weight.to_string(), expected: "0 to 1" });
        }
        for (name, len) in [("values", values.len()), ("drawn", drawn.len())] {
            if Some(len) != self.vertex_count.checked_mul(components) {
                let found = format!(
                    "{} for {} with {components} components",
                    counted(len, "number"),
                    counted(self.vertex_count, "vertex")
                );
                return Err(Error::Parameter {
                    name,
                    found,
                    expected: "one number per vertex and component",
                });
            }
        }
        for transit in &self.transits {
            let [from, to] = [transit.vertex, transit.target].map(|v| v as usize * components);
            for i in 0..components {
                // This form is exact at both ends.
                drawn[from + i] = (1.0 - weight) * values[from + i] + weight * values[to + i];
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::lod::samples::{samples, sorted};

    proptest! {
        /// At weight 1 the non-degenerate triangles of the finer level equal the triangles of the
        /// coarser level.
        #[test]
        #[allow(clippy::cast_sign_loss, reason = "numbers of vertices")]
        fn both_ends_are_those_of_the_levels(sample in samples(), levels in any::<[usize; 2]>()) {
            let sequence = &sample.sequence;
            let [a, b] = levels.map(|level| level % (sequence.len() + 1));
            let geomorph = Geomorph::between(sequence, a, b).unwrap();
            let numbers: Vec<f32> = (0..sequence.vertex_count()).map(|v| v as f32).collect();
            let at = |weight: f32| {
                let mut drawn = numbers.clone();
                geomorph.blend(weight, 1, &numbers, &mut drawn).unwrap();
                let fine = sequence.drawn(a.max(b)).unwrap();
                let moved = fine.into_iter().map(|t| t.map(|v| drawn[v as usize] as u32));
                sorted(moved.filter(|[a, b, c]| a != b && b != c && a != c))
            };
            prop_assert_eq!(at(0.0), sorted(sequence.drawn(a.max(b)).unwrap()));
            prop_assert_eq!(at(1.0), sorted(sequence.drawn(a.min(b)).unwrap()));
        }
    }

    #[test]
    fn wrong_sizes_are_refused() {
        let sequence = CollapseSequence::from_collapses(3, vec![0, 1, 2], []).unwrap();
        let geomorph = Geomorph::between(&sequence, 0, 0).unwrap();
        assert!(geomorph.blend(0.0, 1, &[0.0; 3], &mut [0.0; 3]).is_ok());
        assert!(geomorph.blend(0.0, 1, &[0.0; 2], &mut [0.0; 3]).is_err());
        assert!(geomorph.blend(0.0, 1, &[0.0; 3], &mut [0.0; 4]).is_err());
        assert!(geomorph.blend(0.0, usize::MAX, &[0.0; 3], &mut [0.0; 3]).is_err());
        assert!(geomorph.blend(f32::NAN, 1, &[0.0; 3], &mut [0.0; 3]).is_err());
    }
}
