//! The error of the benchmarks.

/// Any error that stops a benchmark. The message names its subject.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;
