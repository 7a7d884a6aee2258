//! The output of the command. Stages, notes and progress go to standard error, results to standard
//! output.
//!
//! If the reader closes the pipe early, output stops without an error. Progress is shown only on a
//! terminal.

use std::io::{self, IsTerminal, Write};
use std::time::Duration;

use anstream::{AutoStream, ColorChoice};
use clap::builder::styling::{AnsiColor, Style};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use tristrip_render::text;

use crate::task::Shared;

/// The two output streams and their settings.
pub(crate) struct Console {
    lines: Lines,
    #[cfg(feature = "serve")]
    threads: Option<usize>,
    results: Results,
    /// Whether a second thread may animate the progress display.
    ticking: bool,
    stdout: Stream,
    /// Whether standard error shows colours: it is a terminal, and `NO_COLOR` is not set.
    colours: bool,
}

/// Prints lines on standard error, above the progress display. Clones share the display between
/// threads.
#[derive(Debug, Clone)]
pub(crate) struct Lines {
    quiet: bool,
    bar: ProgressBar,
}

impl Lines {
    /// Creates lines without a progress display. With `quiet`, stages and notes are not printed.
    pub(crate) fn new(quiet: bool) -> Self {
        Self { quiet, bar: ProgressBar::hidden() }
    }

    /// Returns the progress display.
    pub(crate) fn progress(&self) -> ProgressBar {
        self.bar.clone()
    }

    /// Prints a line about a finished stage or a result: name, text and time.
    pub(crate) fn stage(&self, name: &str, what: &str, seconds: Option<f64>) {
        let time = seconds.map(text::duration).unwrap_or_default();
        self.print(format!("  {name:<9} {what:<68} {time:>8}").trim_end());
    }

    /// Prints a note.
    pub(crate) fn note(&self, note: &str) {
        self.print(&format!("  {:<9} {note}", "note"));
    }

    fn print(&self, line: &str) {
        if !self.quiet {
            self.write_stderr(line);
        }
    }

    fn write_stderr(&self, line: &str) {
        // A failure to write to standard error cannot be reported.
        self.bar.suspend(|| writeln!(io::stderr().lock(), "{line}").ok());
    }
}

/// The style of the name before an error.
const ERROR: Style = AnsiColor::Red.on_default().bold();
/// The style of the word before a warning.
const WARNING: Style = AnsiColor::Yellow.on_default().bold();

/// Prints help or version to standard output, or a usage error to standard error.
pub(crate) fn print_usage(message: &clap::Error) {
    // A failure to print is ignored: the reader may have closed the pipe early.
    message.print().unwrap_or_default();
}

/// How results are printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Results {
    Text,
    /// Text on standard error, because a mesh is written to standard output.
    TextBesideMesh,
    Json,
}

/// The state of standard output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stream {
    Open,
    /// The reader closed the pipe.
    Closed,
    Failed,
}

impl Console {
    pub(crate) fn new(shared: &Shared, output_is_stdout: bool) -> Self {
        Self {
            lines: Lines::new(shared.quiet),
            #[cfg(feature = "serve")]
            threads: shared.threads,
            results: match (shared.json, output_is_stdout) {
                (true, _) => Results::Json,
                (false, true) => Results::TextBesideMesh,
                (false, false) => Results::Text,
            },
            ticking: shared.threads != Some(1),
            stdout: Stream::Open,
            colours: AutoStream::choice(&io::stderr()) != ColorChoice::Never,
        }
    }

    /// Begins an input: prints its name and starts the progress display. `steps` is the number of
    /// steps, if known.
    pub(crate) fn begin(&mut self, name: &str, steps: Option<usize>) {
        self.lines.print(name);
        if self.lines.quiet || !io::stderr().is_terminal() {
            return;
        }
        let (bar, template) = match steps {
            Some(steps) => (ProgressBar::new(steps as u64), "  {bar:30} {pos}/{len} {msg}"),
            None => (ProgressBar::new_spinner(), "  {spinner} {msg} {elapsed}"),
        };
        self.lines.bar = match ProgressStyle::with_template(template) {
            Ok(style) => bar.with_style(style),
            Err(_) => bar,
        };
        if self.ticking {
            self.lines.bar.enable_steady_tick(Duration::from_millis(100));
        }
    }

    /// Returns a handle that prints lines, for the observer of an operation.
    pub(crate) fn lines(&self) -> Lines {
        self.lines.clone()
    }

    /// Shows the current activity in the progress display.
    pub(crate) fn doing(&self, what: &str) {
        self.lines.bar.set_message(what.to_owned());
    }

    /// Advances the progress display by one step.
    pub(crate) fn step(&self) {
        self.lines.bar.inc(1);
    }

    /// Removes the progress display that [`Console::begin`] started.
    pub(crate) fn end(&mut self) {
        std::mem::replace(&mut self.lines.bar, ProgressBar::hidden()).finish_and_clear();
    }

    /// Returns whether only errors and requested results are printed.
    #[cfg(feature = "serve")]
    pub(crate) fn is_quiet(&self) -> bool {
        self.lines.quiet
    }

    /// Returns the number of threads, if the user chose one.
    #[cfg(feature = "serve")]
    pub(crate) fn threads(&self) -> Option<usize> {
        self.threads
    }

    /// Prints a line on standard error.
    #[cfg(feature = "serve")]
    pub(crate) fn line(&self, line: &str) {
        self.lines.print(line);
    }

    /// Prints a line about a finished stage or a result: name, text and time.
    pub(crate) fn stage(&self, name: &str, what: &str, seconds: Option<f64>) {
        self.lines.stage(name, what, seconds);
    }

    /// Prints a note about an input.
    pub(crate) fn note(&self, note: &str) {
        self.lines.note(note);
    }

    /// Prints a warning about an input, even in quiet mode.
    pub(crate) fn warning(&self, name: &str, message: &str) {
        let word = if self.colours { format!("{WARNING}warning:{WARNING:#}") } else { "warning:".into() };
        self.lines.write_stderr(&format!("{word} {name}: {message}"));
    }

    /// Prints an error, even in quiet mode.
    pub(crate) fn error(&self, message: &str) {
        let name = if self.colours { format!("{ERROR}tristrip:{ERROR:#}") } else { "tristrip:".into() };
        self.lines.write_stderr(&format!("{name} {message}"));
    }

    /// Prints a text result to standard output, or to standard error if a mesh is written to
    /// standard output.
    ///
    /// In quiet mode, only `requested` results are printed, not those that accompany a written
    /// file.
    pub(crate) fn result(&mut self, text: &str, requested: bool) {
        match self.results {
            _ if self.lines.quiet && !requested => (),
            Results::Text => self.write_stdout(text.as_bytes()),
            Results::TextBesideMesh => self.lines.write_stderr(text.trim_end()),
            Results::Json => (),
        }
    }

    /// Prints results as JSON if requested: one object for one input, an array for several.
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

    /// Writes bytes to standard output unchanged.
    pub(crate) fn write_stdout(&mut self, bytes: &[u8]) {
        if self.stdout != Stream::Open {
            return;
        }
        let written = self.lines.bar.suspend(|| {
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

    /// Returns whether all output to standard output was written.
    pub(crate) fn finish(&self) -> bool {
        self.stdout != Stream::Failed
    }
}
