//! How long the work of a job may take.

use std::time::{Duration, Instant};

use tristrip_pipeline::Observer;

/// When a job is given up.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Deadline(Instant);

impl Deadline {
    /// Returns the deadline of a job that begins now.
    pub(crate) fn after(time: Duration) -> Self {
        let now = Instant::now();
        // A time beyond what the clock can name is none: a century is enough.
        Self(now.checked_add(time).unwrap_or(now + Duration::from_hours(24 * 36500)))
    }

    pub(crate) fn is_over(self) -> bool {
        Instant::now() >= self.0
    }

    /// Returns an error once the deadline is over. The message is replaced by one that names the limit.
    pub(crate) fn check(self) -> Result<(), String> {
        if self.is_over() { Err("too late".into()) } else { Ok(()) }
    }
}

/// Cancels a packing.
impl Observer for Deadline {
    fn is_cancelled(&self) -> bool {
        self.is_over()
    }
}
