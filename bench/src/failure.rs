//! The error of the benchmarks.

/// Any error that stops a benchmark, with its subject in the message.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;
