//! What people and programs see: stages, notes and progress on standard error, results on standard output.
//!
//! A reader that closes the pipe early is not an error: from then on nothing is written. Progress is drawn on a terminal only.

use std::io::{self, IsTerminal, Write};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use crate::task::Shared;
use crate::text;

/// The two streams, and what may be said on them.
pub(crate) struct Console {
    quiet: bool,
    results: Results,
    /// A second thread may keep the progress moving.
    ticking: bool,
    bar: ProgressBar,
    stdout: Stream,
}

/// How results are printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Results {
    Text,
    /// A mesh is written to standard output, so that the text goes to standard error.
    TextBesideMesh,
    Json,
}

/// How writing to standard output went so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stream {
    Open,
    /// Nobody reads any more.
    Closed,
    Failed,
}

impl Console {
    pub(crate) fn new(shared: &Shared, output_is_stdout: bool) -> Self {
        Self {
            quiet: shared.quiet,
            results: match (shared.json, output_is_stdout) {
                (true, _) => Results::Json,
                (false, true) => Results::TextBesideMesh,
                (false, false) => Results::Text,
            },
            ticking: shared.threads != Some(1),
            bar: ProgressBar::hidden(),
            stdout: Stream::Open,
        }
    }

    /// Begins an input: prints its name and shows that work is going on; `steps` is their number where it is known.
    pub(crate) fn begin(&mut self, name: &str, steps: Option<usize>) {
        self.say(name);
        if self.quiet || !io::stderr().is_terminal() {
            return;
        }
        let (bar, template) = match steps {
            Some(steps) => (ProgressBar::new(steps as u64), "  {bar:30} {pos}/{len} {msg}"),
            None => (ProgressBar::new_spinner(), "  {spinner} {msg} {elapsed}"),
        };
        self.bar = match ProgressStyle::with_template(template) {
            Ok(style) => bar.with_style(style),
            Err(_) => bar,
        };
        if self.ticking {
            self.bar.enable_steady_tick(Duration::from_millis(100));
        }
    }

    /// Gives a hold on the progress that is shown, for what runs on other threads.
    pub(crate) fn progress(&self) -> ProgressBar {
        self.bar.clone()
    }

    /// Shows what is being done now.
    pub(crate) fn doing(&self, what: &str) {
        self.bar.set_message(what.to_owned());
    }

    /// Counts one step of those that were announced.
    pub(crate) fn step(&self) {
        self.bar.inc(1);
    }

    /// Ends what [`Console::begin`] began.
    pub(crate) fn end(&mut self) {
        std::mem::replace(&mut self.bar, ProgressBar::hidden()).finish_and_clear();
    }

    /// Prints the line of a finished stage: its name, what came of it, and its time.
    pub(crate) fn stage(&self, name: &str, what: &str, seconds: Option<f64>) {
        let time = seconds.map(text::duration).unwrap_or_default();
        self.say(format!("  {name:<9} {what:<62} {time:>8}").trim_end());
    }

    /// Prints something that a user should know of an input.
    pub(crate) fn note(&self, note: &str) {
        self.say(&format!("  {:<9} {note}", "note"));
    }

    /// Prints an error, also when quiet.
    pub(crate) fn error(&self, message: &str) {
        self.write_stderr(&format!("tristrip: {message}"));
    }

    /// Prints a result for people: to standard output, or beside it where a mesh goes there.
    ///
    /// When quiet, only results that were `asked_for` are printed: those that come with a file are not.
    pub(crate) fn result(&mut self, text: &str, asked_for: bool) {
        match self.results {
            _ if self.quiet && !asked_for => (),
            Results::Text => self.write_stdout(text.as_bytes()),
            Results::TextBesideMesh => self.write_stderr(text.trim_end()),
            Results::Json => (),
        }
    }

    /// Prints results for programs: one object for one input, an array for many.
    pub(crate) fn json<T: Serialize>(&mut self, results: &[T], many: bool) {
        if self.results != Results::Json {
            return;
        }
        let printed = match results {
            [one] if !many => serde_json::to_string_pretty(one),
            all => serde_json::to_string_pretty(all),
        };
        match printed {
            Ok(text) => self.write_stdout(format!("{text}\n").as_bytes()),
            Err(error) => {
                self.error(&error.to_string());
                self.stdout = Stream::Failed;
            }
        }
    }

    /// Writes bytes to standard output as they are.
    pub(crate) fn write_stdout(&mut self, bytes: &[u8]) {
        if self.stdout != Stream::Open {
            return;
        }
        let written = self.bar.suspend(|| {
            let mut stdout = io::stdout().lock();
            stdout.write_all(bytes).and_then(|()| stdout.flush())
        });
        match written {
            Ok(()) => (),
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => self.stdout = Stream::Closed,
            Err(error) => {
                self.error(&format!("standard output: {error}"));
                self.stdout = Stream::Failed;
            }
        }
    }

    /// Tells whether everything that was meant for standard output could be written there.
    pub(crate) fn finish(&self) -> bool {
        self.stdout != Stream::Failed
    }

    fn say(&self, line: &str) {
        if !self.quiet {
            self.write_stderr(line);
        }
    }

    fn write_stderr(&self, line: &str) {
        // There is nowhere to say that standard error is gone.
        self.bar.suspend(|| writeln!(io::stderr().lock(), "{line}").ok());
    }
}
