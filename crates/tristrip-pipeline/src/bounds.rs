//! Lower bounds summed over the parts of a model, and the gap between them and a result.

use serde::Serialize;
use tristrip::Cost;
use tristrip::stripify::bound::Bound;
use tristrip::{Method, StripifyOptions};

use crate::error::Error;
use crate::metrics::StripMetrics;
use crate::parts::{PreparedPart, map};

/// The lower bounds of a model, summed over its parts. The field names are the keys of the JSON
/// report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Bounds {
    /// The lower bound on the number of strips.
    pub strips: usize,
    /// The lower bound on the number of vertices sent.
    pub vertices_sent: usize,
    /// The lower bound on the number of vertices sent with free swaps.
    pub gl_cost: usize,
    /// The lower bound on the indices in layout `restart`, in one index buffer for all parts.
    pub indices_restart: usize,
    /// The lower bound on the indices in layout `degenerate`, in one index buffer per part.
    pub indices_degenerate: usize,
}

/// The gap between the result of a search and its lower bound.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct BoundGap {
    /// The key of the minimized metric.
    pub figure: &'static str,
    /// The value of this metric in the result.
    pub found: usize,
    /// A lower bound on this metric for every stripification of the model.
    pub bound: usize,
    /// The difference between `found` and `bound`.
    pub gap: usize,
    /// Whether the gap is 0.
    pub optimal: bool,
}

impl Bounds {
    /// Sums the lower bounds of all parts of a model.
    ///
    /// # Errors
    /// A dual graph does not belong to its faces.
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

    /// Compares the metric that a method minimizes with its bound. Returns `None` for methods that
    /// do not search.
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
