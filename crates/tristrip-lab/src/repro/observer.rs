//! What a caller learns while papers are reproduced.

use tristrip_pipeline::Observer;

/// Learns which model and which recipe is measured, in addition to the events of the pipeline.
pub trait ReproObserver: Observer {
    /// Receives the name of the model that begins, with its number.
    fn model(&self, _name: &str) {}
    /// Receives the flags of the strips that are measured next. Recipes are measured in parallel.
    fn recipe(&self, _flags: &str) {}
    /// The model is measured, or cannot be read.
    fn model_done(&self) {}
}

/// Ignores all events.
impl ReproObserver for () {}
