//! The log of the web server on standard error: requests, packing jobs and warnings.
//!
//! A separate thread writes the lines, so a blocked terminal or pipe does not stop the server.
//! Lines that do not fit into the queue are dropped.

use std::io::{self, Write};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;
use std::time::Duration;

use tracing_subscriber::filter::LevelFilter;
use tracing_subscriber::fmt;

use crate::args::LogFormat;

/// The maximum number of queued lines.
const MAX_LINES: usize = 4096;
/// The maximum time that the command waits for queued lines before it ends.
const END_TIME: Duration = Duration::from_secs(1);

/// A message to the writer thread.
enum Message {
    Write(Vec<u8>),
    /// Answer once all earlier lines are written.
    Answer(SyncSender<()>),
}

/// A running log.
pub(crate) struct Log {
    sender: SyncSender<Message>,
}

/// Passes lines to the writer thread, one line per call.
struct Lines(SyncSender<Message>);

impl Write for Lines {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        self.0.try_send(Message::Write(line.to_vec())).unwrap_or_default();
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Log {
    /// Starts the log. Only the first log of a process gets lines.
    pub(crate) fn start(format: LogFormat) -> Self {
        let (sender, receiver) = sync_channel(MAX_LINES);
        thread::spawn(move || write_all(&receiver));
        let lines = sender.clone();
        let writer = move || Lines(lines.clone());
        let log =
            fmt().with_writer(writer).with_max_level(LevelFilter::INFO).with_target(false).with_ansi(false);
        match format {
            LogFormat::Text => log.try_init(),
            LogFormat::Json => log.json().flatten_event(true).try_init(),
        }
        .unwrap_or_default();
        Self { sender }
    }

    /// Waits until the queued lines are written, for at most [`END_TIME`].
    pub(crate) fn finish(self) {
        let (answer, answered) = sync_channel(1);
        if self.sender.try_send(Message::Answer(answer)).is_ok() {
            answered.recv_timeout(END_TIME).unwrap_or_default();
        }
    }
}

fn write_all(receiver: &Receiver<Message>) {
    let mut stderr = io::stderr();
    for message in receiver {
        match message {
            // A failure to write to standard error cannot be reported.
            Message::Write(line) => stderr.write_all(&line).unwrap_or_default(),
            Message::Answer(answer) => answer.send(()).unwrap_or_default(),
        }
    }
}
