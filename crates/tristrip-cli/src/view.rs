//! `tristrip view`: packs models in memory and shows them in the browser.

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;
use std::thread;

use serde::Serialize;
use tristrip_io::Format;
use tristrip_io::gltf::ProgressiveGlb;
use tristrip_pipeline::pack;
use tristrip_pipeline::text::counted;
use tristrip_serve::{Content, MemoryFile, Server};

use crate::clock::StageClock;
use crate::console::{Console, Lines};
use crate::failure::Failure;
use crate::job::Job;
use crate::report::{self, Batch, Report};
use crate::serve::until_signal;
use crate::stage::load_job;
use crate::task::ViewTask;

/// A model that the viewer shows. The field names are the keys of the JSON output.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Shown {
    /// Whether the packed file has exactly the triangles of the model, at positions rounded to the
    /// grid; `null` for a progressive GLB, which is served unchanged.
    proven: Option<bool>,
    /// The URL of the model for a browser on this machine; `null` if the server could not start.
    url: Option<String>,
    /// The number of bytes that are served.
    bytes: usize,
    /// Human-readable notes. One says where a progressive GLB is truncated.
    notes: Vec<String>,
    /// What is served.
    #[serde(skip)]
    content: Option<MemoryFile>,
}

/// Packs all models and serves them until a signal; returns whether all succeeded.
pub(crate) fn run(task: &ViewTask, console: &mut Console) -> bool {
    let show = |_: &Job, _: &Shown, _: &str, _: &mut Console| ();
    let mut reports = Batch::new(&[]).process(&task.jobs, console, |job| job.input.name(), pack_job, show);
    let mut names = HashSet::new();
    let mut files: Vec<MemoryFile> = reports
        .iter_mut()
        .filter_map(|report| report.outcome.as_mut())
        .filter_map(|shown| shown.content.take())
        .collect();
    if files.len() < reports.len() {
        return report::finish(&reports, console);
    }
    files.iter_mut().for_each(|file| make_distinct(&mut file.name, &mut names));
    let names: Vec<String> = files.iter().map(|file| file.name.clone()).collect();
    let server = match Server::bind(Content::Files(files), &task.options) {
        Ok(server) => server,
        Err(error) => {
            let failure = Failure::from(error);
            console.error(&failure.to_string());
            reports
                .iter_mut()
                .for_each(|report: &mut Report<Shown>| report.error = Some(failure.to_string()));
            return report::finish(&reports, console);
        }
    };
    let url_of = |name: &str| format!("{}#model=files/{}", server.url(), tristrip_serve::url_path(name));
    for (shown, name) in reports.iter_mut().filter_map(|report| report.outcome.as_mut()).zip(&names) {
        shown.url = Some(url_of(name));
    }
    let url = match &names[..] {
        [one] => url_of(one),
        _ => server.url(),
    };
    console.line(&url);
    if !report::finish(&reports, console) {
        return false;
    }
    if task.opens {
        open_browser(url, console.lines());
    }
    until_signal(server, console)
}

/// Opens a browser on a separate thread: a browser in the terminal does not return before the
/// server has answered it.
fn open_browser(url: String, lines: Lines) {
    thread::spawn(move || {
        if webbrowser::open(&url).is_err() {
            lines.note("cannot open a browser; open the address above in one");
        }
    });
}

fn pack_job(job: &Job, console: &mut Console, clock: &StageClock) -> Result<Shown, Failure> {
    let name = file_name(job.input.path.as_deref());
    if let Some((bytes, cut_off)) = progressive(job) {
        cut_off.iter().for_each(|note| console.note(note));
        let notes = cut_off.into_iter().collect();
        return Ok(Shown::new(MemoryFile { name, bytes }, None, notes));
    }
    let model = load_job(job, console, clock)?;
    let packed =
        clock.observe_and_print(|observer| pack::run(&model, &pack::Options::default(), observer))?;
    let what = format!("{} of {}", counted(packed.chunks, "chunk"), counted(packed.meshes, "mesh"));
    console.stage("result", &what, None);
    packed.notes.iter().skip(model.notes.len()).for_each(|note| console.note(note));
    let is_glb = name.to_ascii_lowercase().ends_with(".glb");
    let name = if is_glb { name } else { format!("{name}.glb") };
    let proven = packed.proven.map(|_| true);
    Ok(Shown::new(MemoryFile { name, bytes: packed.bytes }, proven, packed.notes))
}

impl Shown {
    fn new(content: MemoryFile, proven: Option<bool>, notes: Vec<String>) -> Self {
        Self { proven, url: None, bytes: content.bytes.len(), notes, content: Some(content) }
    }
}

/// Reads a file that is already a progressive GLB, with a note if it is truncated. The viewer shows
/// the complete chunks.
fn progressive(job: &Job) -> Option<(Vec<u8>, Option<String>)> {
    let path = job.input.path.as_ref().filter(|path| Format::from_path(path) == Some(Format::Glb))?;
    let bytes = Arc::new(std::fs::read(path).ok()?);
    let glb = ProgressiveGlb::open(Arc::clone(&bytes)).ok()??;
    let (present, all) = (glb.chunks().len(), counted(glb.chunk_bytes(), "byte"));
    let note = format!("the file is truncated: it contains {present} of {all} of its chunks");
    let note = (!glb.is_complete()).then_some(note);
    drop(glb);
    Some((Arc::unwrap_or_clone(bytes), note))
}

/// Returns the name under which a file is served, without characters that a URL path cannot
/// contain.
fn file_name(path: Option<&Path>) -> String {
    let name = path.and_then(Path::file_name).unwrap_or_default().to_string_lossy();
    let kept = |c: char| if c.is_alphanumeric() || matches!(c, '.' | '-' | '_' | ' ') { c } else { '_' };
    let name: String = name.trim_start_matches('.').chars().map(kept).collect();
    let name = name.trim_end_matches(['.', ' ']);
    if name.is_empty() { "model".to_owned() } else { name.to_owned() }
}

/// Puts a number in front of a name that is already used.
fn make_distinct(name: &mut String, names: &mut HashSet<String>) {
    let first = name.clone();
    let mut number = 1;
    while !names.insert(name.clone()) {
        number += 1;
        *name = format!("{number}-{first}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_files_and_distinct() {
        let name = |path: &str| file_name(Some(Path::new(path)));
        assert_eq!(name("a/bunny.ply"), "bunny.ply");
        assert_eq!(name(".hidden.ply"), "hidden.ply");
        assert_eq!(name("a:b?.ply"), "a_b_.ply");
        assert_eq!(file_name(None), "model");
        let mut names = HashSet::new();
        let distinct = ["a.glb", "a.glb", "a.glb"].map(|name| {
            let mut name = name.to_owned();
            make_distinct(&mut name, &mut names);
            name
        });
        assert_eq!(distinct, ["a.glb", "2-a.glb", "3-a.glb"]);
    }
}
