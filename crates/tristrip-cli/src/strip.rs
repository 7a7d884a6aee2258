//! `tristrip strip`: builds strips, verifies them, writes them, and reports their metrics.

use std::path::Path;

use serde::Serialize;
use tristrip_io::Model;
use tristrip_pipeline::text::{count, counted};
use tristrip_pipeline::{
    BoundGap, DrawnAs, DrawnParts, EncodeOptions, Event, Figures, FileFigures, MeshFigures, MethodReport,
    Stopped, StripOptions, Stripped, encode_observed, strip_observed,
};
use tristrip_render::images::{self, RenderOptions};
use tristrip_render::text as render_text;

use crate::batch::{self, InputReport, Outcome};
use crate::bound::gap_line;
use crate::console::Console;
use crate::failure::Failure;
use crate::figures::summary;
use crate::input::file_bytes;
use crate::job::{Job, Output};
use crate::output::{self, WriteReport};
use crate::reorder::GroupReport;
use crate::search::interrupted;
use crate::stage::{Seconds, Stages, load_job, show_search, timed};
use crate::task::StripTask;

/// The report of one input; the keys are those of the JSON output.
#[derive(Debug, Serialize)]
struct StripReport {
    file: String,
    #[serde(flatten)]
    method: MethodReport,
    /// `null` if the proof was not requested or not reached.
    proven: Option<bool>,
    seconds: Seconds,
    #[serde(flatten)]
    figures: Option<Figures>,
    /// Why the search was stopped early, if it was.
    stopped: Option<Stopped>,
    /// The gap between the result of a search and its lower bound; `null` for methods that do not search.
    bound: Option<BoundGap>,
    mesh: Option<MeshFigures>,
    parts: Option<usize>,
    notes: Vec<String>,
    output: Option<String>,
    layout: Option<&'static str>,
    /// What the parts are drawn as in the file that was written.
    drawn: Option<DrawnParts>,
    /// The input as it was read; `null` unless a file was written.
    before: Option<FileFigures>,
    /// The file that was written.
    after: Option<FileFigures>,
    /// The new vertex order; `null` unless requested.
    vertex_order: Option<Vec<GroupReport>>,
    /// The picture of the strips, if it was requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    picture: Option<String>,
    error: Option<String>,
}

/// Returns the row of a file in a table.
fn file_row(name: &str, figures: &FileFigures) -> Vec<String> {
    let bytes = figures.bytes.map_or_else(|| "unknown".into(), |bytes| render_text::bytes(bytes as usize));
    vec![format!("  {name}"), count(figures.indices), format!("{:.3}", figures.acmr_fifo_16), bytes]
}

/// Returns a table of the input and the file that was written; nothing if none was.
fn before_and_after(report: &StripReport) -> String {
    let (Some(before), Some(after)) = (&report.before, &report.after) else { return String::new() };
    let head = ["", "indices", "ACMR, FIFO 16", "file"].map(str::to_owned).to_vec();
    render_text::table(&[head, file_row("before", before), file_row("after", after)], 1..4)
}

impl InputReport for StripReport {
    fn outcome(&mut self) -> Outcome<'_> {
        Outcome { file: &self.file, proven: Some(&mut self.proven), error: &mut self.error }
    }
}

/// Processes all inputs in order; returns whether all succeeded.
pub(crate) fn run(task: &StripTask, console: &mut Console) -> bool {
    let new_report = |job: &Job| StripReport {
        file: job.input.name(),
        method: MethodReport::of(&task.options),
        proven: None,
        seconds: Seconds::default(),
        figures: None,
        stopped: None,
        bound: None,
        mesh: None,
        parts: None,
        notes: Vec::new(),
        output: None,
        layout: None,
        drawn: None,
        before: None,
        after: None,
        vertex_order: None,
        picture: None,
        error: None,
    };
    let show = |job: &Job, report: &StripReport, title: &str, console: &mut Console| {
        let figures = report.figures.as_ref().map(summary).unwrap_or_default();
        let files = before_and_after(report);
        console.result(&format!("{title}{figures}{files}"), job.output.is_none());
    };
    let process =
        |job: &Job, console: &mut Console, report: &mut StripReport| strip(job, task, console, report);
    let reports = batch::process_all(&task.jobs, None, console, new_report, process, show);
    batch::finish(reports, console)
}

/// Takes one input through all stages; the report holds the stages reached.
fn strip(
    job: &Job,
    task: &StripTask,
    console: &mut Console,
    report: &mut StripReport,
) -> Result<(), Failure> {
    if interrupted() {
        return Err(Failure::Input("not processed: interrupted".into()));
    }
    let (model, load) = load_job(job, console)?;
    report.seconds.load = Some(load);
    let options = StripOptions::default().with_stripify(task.options).with_verify(task.verify);
    let show = |event: Event<'_>, seconds: f64| show(event, seconds, console, report);
    let stages = Stages::new(console, load, show).with_budget(task.budget);
    let stripped = strip_observed(&model, &options, &stages)?;
    if !task.verify {
        console.stage("verify", "skipped", None);
    }
    if let Some(target) = &job.output {
        write(job, target, task, &model, &stripped, console, report)?;
    }
    if let Some(path) = &task.picture {
        draw(path, &model, &stripped, console)?;
        report.picture = Some(path.display().to_string());
    }
    Ok(())
}

/// Prints and reports an event.
fn show(event: Event<'_>, seconds: f64, console: &Console, report: &mut StripReport) {
    match event {
        Event::Prepared => report.seconds.dual = Some(seconds),
        Event::Surveyed { parts, mesh, notes } => {
            (report.parts, report.mesh) = (Some(parts), Some(mesh.clone()));
            report.notes = notes.to_vec();
        }
        Event::Stripified { strips, stopped } => {
            (report.seconds.stripify, report.stopped) = (Some(seconds), stopped);
            let what = format!("{} ({})", counted(strips, "strip"), report.method.description());
            show_search(&what, seconds, stopped, console, &mut report.notes);
        }
        Event::Measured(figures) => report.figures = Some(figures.clone()),
        Event::Bounded(gap) => {
            if let Some(gap) = gap {
                console.stage("bound", &gap_line(gap), Some(seconds));
            }
            report.bound = gap.cloned();
        }
        Event::Proven { faces } => {
            (report.seconds.verify, report.proven) = (Some(seconds), Some(true));
            console.stage("verify", &proven(faces), Some(seconds));
        }
        _ => (),
    }
}

/// Writes each part as strips or as a list, whichever has fewer indices, with the vertices in order of first use if requested.
fn write(
    job: &Job,
    target: &Output,
    task: &StripTask,
    model: &Model,
    stripped: &Stripped,
    console: &mut Console,
    report: &mut StripReport,
) -> Result<(), Failure> {
    let options = EncodeOptions::new(target.format).with_layout(target.layout).with_list(task.list);
    let options = options.with_reorder(task.reorder).with_verify(task.verify);
    let drawn = stripped.draw(model, &options);
    for note in drawn.parts().notes() {
        console.note(&note);
        report.notes.push(note);
    }
    let mut bytes = None;
    let fields = WriteReport {
        write: &mut report.seconds.write,
        verify: &mut report.seconds.verify,
        notes: &mut report.notes,
        vertex_order: Some(&mut report.vertex_order),
    };
    let any_strips = drawn.drawn_as.iter().any(|&kind| kind != DrawnAs::List);
    output::write(target, any_strips, console, fields, |observer| {
        let encoded = encode_observed(model, &drawn.drawings, &options, observer)?;
        // As of an input, the size of a .gltf is not that of one file.
        bytes = (!target.separate).then_some(encoded.bytes.len() as u64);
        Ok(encoded)
    })?;
    report.drawn = Some(drawn.parts());
    report.before = Some(FileFigures::of(&drawn.before, file_bytes(&job.input)));
    report.after = Some(FileFigures::of(&drawn.after, bytes));
    report.output = Some(target.name());
    report.layout = Some(target.layout.name());
    Ok(())
}

/// Draws the strips, and writes the picture.
fn draw(path: &Path, model: &Model, stripped: &Stripped, console: &Console) -> Result<(), Failure> {
    console.doing("picture");
    let options = RenderOptions::default();
    let positions = model.parts.iter().map(|part| part.mesh.positions());
    let parts: Vec<_> = positions.zip(&stripped.strips).collect();
    let (picture, seconds) = timed(|| images::strips(&parts, &options));
    tristrip_io::replace_file(path, &picture?).map_err(|error| Failure::writing(&error))?;
    let what = format!("{}, {} × {} pixels", path.display(), options.width, options.height);
    console.stage("picture", &what, Some(seconds));
    Ok(())
}

/// Returns a line on what was proven.
fn proven(faces: usize) -> String {
    match faces {
        0 => "proven: draws no faces, as the source".into(),
        1 => "proven: draws exactly the one face, with its winding".into(),
        _ => format!("proven: draws exactly the {}, each once, with its winding", counted(faces, "face")),
    }
}
