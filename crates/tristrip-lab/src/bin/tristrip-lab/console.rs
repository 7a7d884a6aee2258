//! Output: stages and notes on standard error, results on standard output.

use std::io::{self, Write};

use serde::Serialize;
use tristrip_render::text;

use crate::failure::Failure;

/// The two output streams and their settings.
#[derive(Debug)]
pub(crate) struct Console {
    quiet: bool,
    json: bool,
}

impl Console {
    pub(crate) fn new(quiet: bool, json: bool) -> Self {
        Self { quiet, json }
    }

    /// Prints a line on standard error.
    pub(crate) fn line(&self, line: &str) {
        if !self.quiet {
            write_stderr(line);
        }
    }

    /// Prints a line on a finished stage: name, result and time.
    pub(crate) fn stage(&self, name: &str, what: &str, seconds: Option<f64>) {
        let time = seconds.map(text::duration).unwrap_or_default();
        self.line(format!("  {name:<9} {what:<68} {time:>8}").trim_end());
    }

    /// Prints a note on an input.
    pub(crate) fn note(&self, note: &str) {
        self.line(&format!("  {:<9} {note}", "note"));
    }

    /// Prints an error, also in quiet mode.
    #[expect(clippy::unused_self, reason = "all output goes through the console")]
    pub(crate) fn error(&self, message: &str) {
        write_stderr(&format!("tristrip-lab: {message}"));
    }

    /// Prints a result as text, unless results are JSON.
    pub(crate) fn result(&self, text: &str) -> Result<(), Failure> {
        if self.json { Ok(()) } else { write_stdout(text) }
    }

    /// Prints results as JSON if requested: one object for one input, an array for several.
    pub(crate) fn json<T: Serialize>(&self, results: &[T]) -> Result<(), Failure> {
        if !self.json {
            return Ok(());
        }
        let text = match results {
            [one] => serde_json::to_string_pretty(one),
            all => serde_json::to_string_pretty(all),
        };
        let text = text.map_err(|error| Failure::Failed(error.to_string()))?;
        write_stdout(&format!("{text}\n"))
    }
}

/// Writes to standard output. It is not an error if the reader closes the pipe early.
fn write_stdout(text: &str) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::Failed(format!("standard output: {error}")))
        }
        _ => Ok(()),
    }
}

fn write_stderr(line: &str) {
    // A failure to write to standard error cannot be reported.
    writeln!(io::stderr().lock(), "{line}").unwrap_or_default();
}
