//! Errors of charts and images.

/// The reason why a chart or an image could not be drawn.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A model could not be processed.
    #[error(transparent)]
    Pipeline(#[from] tristrip_pipeline::Error),
    /// A chart could not be drawn.
    #[error("chart: {0}")]
    Chart(String),
    /// An image cannot be drawn as requested.
    #[error("image: {0}")]
    Image(String),
}

impl From<tristrip::Error> for Error {
    fn from(error: tristrip::Error) -> Self {
        Self::Pipeline(error.into())
    }
}
