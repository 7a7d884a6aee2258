//! What strips cost: every figure of the project has its one definition here.

use super::Strips;

/// The figures of a set of strips. Counts are of indices, triangles or strips, as their names say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Metrics {
    /// Real triangles drawn.
    pub triangles: usize,
    /// Strips.
    pub strips: usize,
    /// Strips of one triangle.
    pub isolated: usize,
    /// Vertices repeated inside a strip or at its start, each of which draws a degenerate triangle or two.
    pub swaps: usize,
    /// The sum of the strips' lengths, swaps and winding repeats included (the OpenGL cost).
    pub vertices_sent: usize,
    /// The same with swaps free (the GL cost, one bit each).
    pub gl_cost: usize,
    /// Length of the index buffer with a restart between strips: `vertices_sent + strips − 1`.
    pub indices_restart: usize,
    /// Length of the index buffer with strips joined by degenerate triangles, winding kept.
    pub indices_degenerate: usize,
}

impl Metrics {
    /// Measures strips.
    ///
    /// ```
    /// use tristrip::{Strips, strip::Metrics};
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
            indices_degenerate: strips.to_degenerate().len(),
            ..Self::default()
        };
        for strip in strips.iter() {
            let real = strip.windows(3).filter(|w| w[0] != w[1] && w[1] != w[2] && w[0] != w[2]).count();
            metrics.triangles += real;
            metrics.isolated += usize::from(real == 1);
            metrics.swaps += (strip.len().saturating_sub(2)) - real;
        }
        metrics.gl_cost = metrics.vertices_sent - metrics.swaps;
        metrics
    }

    /// Divides `vertices_sent` by the triangles; 0 where there is none.
    pub fn vertices_per_triangle(&self) -> f64 {
        per(self.vertices_sent, self.triangles)
    }

    /// Divides `indices_restart` by the triangles; 0 where there is none.
    pub fn indices_restart_per_triangle(&self) -> f64 {
        per(self.indices_restart, self.triangles)
    }

    /// Divides `indices_degenerate` by the triangles; 0 where there is none.
    pub fn indices_degenerate_per_triangle(&self) -> f64 {
        per(self.indices_degenerate, self.triangles)
    }
}

fn per(count: usize, triangles: usize) -> f64 {
    if triangles == 0 { 0.0 } else { count as f64 / triangles as f64 }
}
