//! Progress of the reproduction of papers.

use tristrip_pipeline::Observer;

/// Receives which model and which recipe is measured, in addition to the events of the pipeline.
pub trait ReproObserver: Observer {
    /// Receives the name of the model that starts, and its index.
    fn model(&self, _name: &str) {}
    /// Receives the flags of the strips that are measured next. Recipes are measured in parallel.
    fn recipe(&self, _flags: &str) {}
    /// Called when the model is measured, or cannot be read.
    fn model_done(&self) {}
}

/// Ignores all events.
impl ReproObserver for () {}
