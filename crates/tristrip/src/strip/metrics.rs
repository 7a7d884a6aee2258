//! The cost of strips. All metrics of the project are defined here.

use super::{Layout, Strips, count_triangles};
use crate::cover::priced::StripPrices;
use crate::names::names;

/// A cost that searches can minimize.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum Cost {
    /// The length of the index buffer with restarts between strips: [`Metrics::indices_restart`].
    #[default]
    Restart,
    /// The vertices sent, including swaps and winding repeats: [`Metrics::vertices_sent`].
    OpenGl,
    /// The index buffer of one strip joined by degenerate triangles:
    /// [`Metrics::indices_degenerate`].
    Degenerate,
    /// The vertices sent, with free swaps: [`Metrics::gl_cost`].
    Gl,
}

names! {
    "tristrip::Cost", Cost, "cost",
    Restart => "restart", "Indices, with a restart between strips";
    OpenGl => "opengl", "Vertices sent, including swaps and winding repeats";
    Degenerate => "degenerate", "Indices of the strips joined by degenerate triangles";
    Gl => "gl", "Vertices sent, with free swaps";
}

impl Cost {
    /// Returns the value of this cost in the metrics.
    ///
    /// ```
    /// use tristrip::{Cost, Metrics, Strips};
    /// let mut strips = Strips::default();
    /// strips.push(&[0, 1, 2, 1, 3]);
    /// let metrics = Metrics::of(&strips);
    /// assert_eq!((Cost::Restart.of(&metrics), Cost::Gl.of(&metrics)), (5, 4));
    /// ```
    pub fn of(self, metrics: &Metrics) -> usize {
        match self {
            Self::Restart => metrics.indices_restart,
            Self::OpenGl => metrics.vertices_sent,
            Self::Degenerate => metrics.indices_degenerate,
            Self::Gl => metrics.gl_cost,
        }
    }

    /// Returns the cost of a strip and of a swap in addition to one index per triangle. In
    /// measurements, a join by degenerate triangles costs one or two indices, because many joined
    /// strips share vertices. Tuned on cow, fandisk, bunny and horse.
    pub(crate) fn prices(self) -> StripPrices {
        match self {
            Self::Restart | Self::Degenerate => StripPrices { strip: 3, swap: 1 },
            Self::OpenGl => StripPrices { strip: 2, swap: 1 },
            Self::Gl => StripPrices { strip: 2, swap: 0 },
        }
    }
}

/// Metrics of a set of strips. All values are counts of indices, triangles or strips.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Metrics {
    /// Number of triangles drawn, without degenerate ones.
    pub triangles: usize,
    /// Number of strips.
    pub strips: usize,
    /// Number of strips of one triangle.
    pub isolated: usize,
    /// Number of vertices repeated inside or at the start of a strip. Each draws one or two
    /// degenerate triangles.
    pub swaps: usize,
    /// Sum of the strip lengths, including swaps and winding repeats (the OpenGL cost).
    pub vertices_sent: usize,
    /// Sum of the strip lengths with free swaps (the GL cost; a swap takes one bit).
    pub gl_cost: usize,
    /// Length of the index buffer with restarts between strips: `vertices_sent + strips − 1`.
    pub indices_restart: usize,
    /// Length of the index buffer with strips joined by degenerate triangles. The winding is kept.
    pub indices_degenerate: usize,
}

impl Metrics {
    /// Computes the metrics of strips.
    ///
    /// ```
    /// use tristrip::{Metrics, Strips};
    /// let mut strips = Strips::default();
    /// strips.push(&[0, 1, 2, 1, 3]); // a swap: triangles 0 1 2 and 2 1 3
    /// strips.push(&[4, 5, 6]);
    /// let m = Metrics::of(&strips);
    /// assert_eq!((m.triangles, m.strips, m.isolated, m.swaps), (3, 2, 1, 1));
    /// assert_eq!((m.vertices_sent, m.gl_cost, m.indices_restart, m.indices_degenerate), (8, 7, 9, 10));
    /// ```
    pub fn of(strips: &Strips) -> Self {
        let mut metrics = Self {
            strips: strips.len(),
            vertices_sent: strips.vertices_sent(),
            indices_restart: strips.vertices_sent() + strips.len().saturating_sub(1),
            indices_degenerate: strips.index_count(Layout::Degenerate),
            ..Self::default()
        };
        for strip in strips.iter() {
            let real = count_triangles(strip);
            metrics.triangles += real;
            metrics.isolated += usize::from(real == 1);
            metrics.swaps += (strip.len().saturating_sub(2)) - real;
        }
        metrics.gl_cost = metrics.vertices_sent - metrics.swaps;
        metrics
    }

    /// Returns `vertices_sent` per triangle, or 0 if there are no triangles.
    ///
    /// ```
    /// use tristrip::{Metrics, Strips};
    /// let strips = Strips::from_parts(vec![0, 1, 2, 3, 4, 5, 6, 7], vec![4, 8])?;
    /// // 8 vertices for 4 triangles; a list has 3 per triangle.
    /// assert_eq!(Metrics::of(&strips).vertices_per_triangle(), 2.0);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn vertices_per_triangle(&self) -> f64 {
        per(self.vertices_sent, self.triangles)
    }

    /// Returns `indices_restart` per triangle, or 0 if there are no triangles.
    ///
    /// ```
    /// use tristrip::{Metrics, Strips};
    /// let strips = Strips::from_parts(vec![0, 1, 2, 3, 4, 5, 6, 7], vec![4, 8])?;
    /// // One restart index between two strips.
    /// assert_eq!(Metrics::of(&strips).indices_restart_per_triangle(), 2.25);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn indices_restart_per_triangle(&self) -> f64 {
        per(self.indices_restart, self.triangles)
    }

    /// Returns `indices_degenerate` per triangle, or 0 if there are no triangles.
    ///
    /// ```
    /// use tristrip::{Metrics, Strips};
    /// let strips = Strips::from_parts(vec![0, 1, 2, 3, 4, 5, 6, 7], vec![4, 8])?;
    /// // Two repeated vertices between two strips.
    /// assert_eq!(Metrics::of(&strips).indices_degenerate_per_triangle(), 2.5);
    /// assert_eq!(Metrics::default().indices_degenerate_per_triangle(), 0.0);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn indices_degenerate_per_triangle(&self) -> f64 {
        per(self.indices_degenerate, self.triangles)
    }
}

/// Adds the metrics of two parts. `indices_restart` of the sum is the length of one index buffer
/// for both, `vertices_sent + strips − 1`. `indices_degenerate` is the sum over one index buffer
/// per part.
///
/// ```
/// use tristrip::{Metrics, Strips};
/// let mut strips = Strips::default();
/// strips.push(&[0, 1, 2]);
/// let part = Metrics::of(&strips);
/// let both: Metrics = [part, part].into_iter().sum();
/// assert_eq!((both.indices_restart, both.indices_degenerate), (7, 6));
/// ```
impl std::ops::Add for Metrics {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let strips = self.strips + other.strips;
        let vertices_sent = self.vertices_sent + other.vertices_sent;
        Self {
            triangles: self.triangles + other.triangles,
            strips,
            isolated: self.isolated + other.isolated,
            swaps: self.swaps + other.swaps,
            vertices_sent,
            gl_cost: self.gl_cost + other.gl_cost,
            indices_restart: vertices_sent + strips.saturating_sub(1),
            indices_degenerate: self.indices_degenerate + other.indices_degenerate,
        }
    }
}

/// Sums the metrics of a model's parts.
impl std::iter::Sum for Metrics {
    fn sum<I: Iterator<Item = Self>>(parts: I) -> Self {
        parts.fold(Self::default(), |sum, part| sum + part)
    }
}

fn per(count: usize, triangles: usize) -> f64 {
    if triangles == 0 { 0.0 } else { count as f64 / triangles as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_add_up_to_one_list_except_for_degenerate_joins() {
        let strips = [&[0, 1, 2][..], &[3, 4, 5, 6], &[7, 8, 9, 8, 10], &[11, 12, 13], &[14, 15, 16, 17]];
        let list = |range: std::ops::Range<usize>| {
            let mut list = Strips::default();
            strips[range].iter().for_each(|strip| list.push(strip));
            Metrics::of(&list)
        };
        for first in 0..=strips.len() {
            for second in first..=strips.len() {
                let parts = [list(0..first), list(first..second), list(second..strips.len())];
                let sum: Metrics = parts.into_iter().sum();
                let indices_degenerate = parts.iter().map(|part| part.indices_degenerate).sum();
                let expected = Metrics { indices_degenerate, ..list(0..strips.len()) };
                assert_eq!(sum, expected, "cut at {first} and {second}");
            }
        }
        assert_eq!([Metrics::default(); 2].into_iter().sum::<Metrics>(), Metrics::default());
    }
}
