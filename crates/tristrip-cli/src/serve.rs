//! `tristrip serve`: serves the models of a directory over HTTP.

use serde::Serialize;
use tristrip_serve::{Content, Server};

use crate::clock::Seconds;
use crate::console::Console;
use crate::failure::Failure;
use crate::logs::Log;
use crate::report::{self, Report};
use crate::task::ServeTask;

/// A listening server. The field names are the keys of the JSON output.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Listening {
    /// The URL of the gallery for a browser on this machine.
    url: String,
    /// The IP address that the server listens on.
    address: String,
    /// The port that the server listens on. With `--port 0`, it is the one that was chosen.
    port: u16,
    /// Whether files are packed on request.
    pack_on_demand: bool,
    /// Human-readable notes.
    notes: Vec<String>,
}

/// Serves until a signal; returns whether the server started and ended without an error.
pub(crate) fn run(task: &ServeTask, console: &mut Console) -> bool {
    let file = task.directory.display().to_string();
    let mut options = task.options.clone();
    options.packing = options.packing.with_threads(console.threads());
    let server = match Server::bind(Content::Folder(task.directory.clone()), &options) {
        Ok(server) => server,
        Err(error) => {
            let failure = Failure::from(error);
            console.error(&failure.to_string());
            let failed = Report::<Listening>::new(file, Seconds::default(), Err(failure));
            return report::finish(&[failed], console);
        }
    };
    console.line(&format!("{}  {file}", server.url()));
    let mut listening = Listening {
        url: server.url(),
        address: server.address().ip().to_string(),
        port: server.address().port(),
        pack_on_demand: task.options.packing.on_demand,
        notes: Vec::new(),
    };
    if !options.address.to_canonical().is_loopback() && server.url().starts_with("http:") {
        let note = "other machines can connect, and connections are not encrypted";
        console.note(note);
        listening.notes.push(note.into());
    }
    if !report::finish(&[Report::new(file, Seconds::default(), Ok(listening))], console) {
        return false;
    }
    let log = (!console.is_quiet()).then(|| Log::start(task.log));
    let ended = until_signal(server, console);
    log.into_iter().for_each(Log::finish);
    ended
}

/// Runs a server until a signal; returns whether it ended without an error.
pub(crate) fn until_signal(server: Server, console: &Console) -> bool {
    match server.run_until_signal() {
        Ok(()) => true,
        Err(error) => {
            console.error(&Failure::from(error).to_string());
            false
        }
    }
}
