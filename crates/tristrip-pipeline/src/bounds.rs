//! Lower bounds summed over the parts of a model, and the gap between them and a result.

use serde::Serialize;
use tristrip::Cost;
use tristrip::stripify::bound::Bound;
use tristrip::{Method, StripifyOptions};

use crate::error::Error;
use crate::metrics::StripMetrics;
use crate::parts::{PreparedPart, map};

/// The lower bounds of a model, summed over its parts; the keys are those of the JSON report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[non_exhaustive]
pub struct Bounds {
    /// Strips.
    pub strips: usize,
    /// Vertices sent.
    pub vertices_sent: usize,
    /// Vertices sent with free swaps.
    pub gl_cost: usize,
    /// Indices with a restart between strips. The parts share one index buffer, as in [`StripMetrics`].
    pub indices_restart: usize,
    /// Indices of the strips joined by degenerate triangles.
    pub indices_degenerate: usize,
}

/// The gap between the result of a search and its lower bound.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct BoundGap {
    /// The key of the minimized figure.
    pub figure: &'static str,
    /// The figure of the result.
    pub found: usize,
    /// No cover has a lower figure.
    pub bound: usize,
    /// The difference.
    pub gap: usize,
    /// Whether the result meets the bound.
    pub optimal: bool,
}

impl Bounds {
    /// Bounds all parts of a model.
    ///
    /// # Errors
    /// A graph is not the one of its faces.
    pub(crate) fn of(parts: &[PreparedPart<'_>]) -> Result<Self, Error> {
        let bounds = map(parts, |part| Bound::of_prepared(&part.surface, &part.graph));
        Ok(Self::sum(&bounds.into_iter().collect::<Result<Vec<_>, _>>()?))
    }

    /// Sums the bounds of parts.
    pub(crate) fn sum<'a>(bounds: impl IntoIterator<Item = &'a Bound>) -> Self {
        let mut sum = Self::default();
        for bound in bounds {
            sum.strips += bound.strips;
            sum.vertices_sent += bound.vertices_sent;
            sum.gl_cost += bound.gl_cost;
            sum.indices_degenerate += bound.indices_degenerate;
        }
        sum.indices_restart = sum.vertices_sent + sum.strips.saturating_sub(1);
        sum
    }

    /// Compares the figure that a method minimizes with its bound; returns `None` for methods that do not search.
    pub(crate) fn gap(&self, options: &StripifyOptions, figures: &StripMetrics) -> Option<BoundGap> {
        let (figure, found, bound) = match (options.method, options.cost) {
            (Method::Fewest, _) => ("strips", figures.strips, self.strips),
            (Method::Best, Cost::Restart) => {
                ("indices_restart", figures.indices_restart, self.indices_restart)
            }
            (Method::Best, Cost::OpenGl) => ("vertices_sent", figures.vertices_sent, self.vertices_sent),
            (Method::Best, Cost::Degenerate) => {
                ("indices_degenerate", figures.indices_degenerate, self.indices_degenerate)
            }
            (Method::Best, Cost::Gl) => ("gl_cost", figures.gl_cost, self.gl_cost),
            _ => return None,
        };
        Some(BoundGap { figure, found, bound, gap: found.saturating_sub(bound), optimal: found <= bound })
    }
}
