//! The errors of the pipeline, grouped by who can act on them.

use serde::Serialize;

use crate::collapses::Collapses;
use crate::metrics::StripMetrics;

/// Why a model could not be processed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The model is invalid, or an option does not fit it.
    #[error(transparent)]
    Input(#[from] tristrip::Error),
    /// A result cannot be stored in the requested format.
    #[error(transparent)]
    Format(#[from] tristrip_io::Error),
    /// A result does not draw exactly the expected faces; it is not returned.
    #[error("not proven: {why}")]
    #[non_exhaustive]
    Unproven {
        /// The first difference from the expected result.
        why: String,
        /// The metrics of the unproven result, for a report; `None` if it was not measured.
        metrics: Option<Box<UnprovenMetrics>>,
    },
    /// The requested level of detail does not exist.
    #[error("level: found {found}, expected at most {last}")]
    Level {
        /// The requested level.
        found: usize,
        /// The highest level. It equals the number of collapses.
        last: usize,
    },
    /// The observer cancelled the operation.
    #[error("cancelled")]
    Cancelled,
}

/// The metrics of a result that fails verification.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
#[non_exhaustive]
pub enum UnprovenMetrics {
    /// The metrics of strips.
    Strips(StripMetrics),
    /// The results of a simplification.
    Simplified(Collapses),
}

impl Error {
    /// Returns the error for a result that fails verification, without metrics.
    pub fn unproven(why: impl Into<String>) -> Self {
        Self::Unproven { why: why.into(), metrics: None }
    }

    /// Adds the metrics of the result to [`Error::Unproven`]. Other errors are returned unchanged.
    pub(crate) fn with_metrics(self, measured: impl FnOnce() -> UnprovenMetrics) -> Self {
        match self {
            Self::Unproven { why, metrics: None } => {
                Self::Unproven { why, metrics: Some(Box::new(measured())) }
            }
            other => other,
        }
    }
}
