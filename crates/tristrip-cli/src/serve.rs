//! `tristrip serve`: the models of a directory over HTTP.

use serde::Serialize;
use tristrip_serve::{Content, Server};

use crate::batch::{self, InputReport, Outcome};
use crate::console::Console;
use crate::failure::Failure;
use crate::logs::Log;
use crate::task::ServeTask;

/// The report, once the server listens; the keys are those of the JSON output.
#[derive(Debug, Default, Serialize)]
struct ServeReport {
    file: String,
    url: Option<String>,
    address: Option<String>,
    port: Option<u16>,
    pack_on_demand: bool,
    notes: Vec<String>,
    error: Option<String>,
}

impl InputReport for ServeReport {
    fn outcome(&mut self) -> Outcome<'_> {
        Outcome { file: &self.file, proven: None, error: &mut self.error }
    }
}

/// Serves until a signal; returns whether the server could start.
pub(crate) fn run(task: &ServeTask, console: &mut Console) -> bool {
    let mut report = ServeReport {
        file: task.directory.display().to_string(),
        pack_on_demand: task.options.packing.on_demand,
        ..ServeReport::default()
    };
    let mut options = task.options.clone();
    options.packing = options.packing.with_threads(console.threads());
    let server = match Server::bind(Content::Folder(task.directory.clone()), &options) {
        Ok(server) => server,
        Err(error) => {
            let failure = Failure::from(error);
            console.error(&failure.to_string());
            report.error = Some(failure.to_string());
            return batch::finish(vec![report], console);
        }
    };
    report.url = Some(server.url());
    report.address = Some(server.address().ip().to_string());
    report.port = Some(server.address().port());
    console.line(&format!("{}  {}", server.url(), report.file));
    if !options.address.to_canonical().is_loopback() && server.url().starts_with("http:") {
        console.note("other machines can connect, without encryption");
        report.notes.push("other machines can connect, without encryption".into());
    }
    if !batch::finish(vec![report], console) {
        return false;
    }
    let log = (!console.is_quiet()).then(|| Log::start(task.log));
    let ended = until_signal(server, console);
    log.into_iter().for_each(Log::finish);
    ended
}

/// Runs a server until a signal; returns whether it ended as it should.
pub(crate) fn until_signal(server: Server, console: &Console) -> bool {
    match server.run_until_signal() {
        Ok(()) => true,
        Err(error) => {
            console.error(&Failure::from(error).to_string());
            false
        }
    }
}
