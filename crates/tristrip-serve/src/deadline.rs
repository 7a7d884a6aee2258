//! The time limit of a job.

use std::time::{Duration, Instant};

use tristrip_pipeline::Observer;

/// The time at which a job is cancelled.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Deadline(Instant);

impl Deadline {
    /// Returns the deadline of a job that starts now.
    pub(crate) fn after(time: Duration) -> Self {
        let now = Instant::now();
        // If the clock cannot represent the time, a century from now is late enough.
        Self(now.checked_add(time).unwrap_or(now + Duration::from_hours(24 * 36500)))
    }

    pub(crate) fn is_over(self) -> bool {
        Instant::now() >= self.0
    }

    /// Returns an error after the deadline. The caller replaces its message by one that names the
    /// limit.
    pub(crate) fn check(self) -> Result<(), String> {
        if self.is_over() { Err("the deadline has passed".into()) } else { Ok(()) }
    }
}

/// Cancels a packing job.
impl Observer for Deadline {
    fn is_cancelled(&self) -> bool {
        self.is_over()
    }
}
