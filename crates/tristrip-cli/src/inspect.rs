//! `tristrip inspect`: what a progressive GLB holds, and what it costs.

use serde::Serialize;
use tristrip_pipeline::text::count;
use tristrip_pipeline::{ComponentBits, StreamFigures, StreamReport, stream_figures};
use tristrip_render::{rate, text};

use crate::batch::{self, InputReport, Outcome};
use crate::console::Console;
use crate::failure::Failure;
use crate::input::short_name;
use crate::job::Input;
use crate::stage::timed;
use crate::task::InspectTask;
use crate::unpack::open;

/// The time of each stage in seconds; `null` for a stage that did not run.
#[derive(Debug, Clone, Copy, Default, Serialize)]
struct InspectSeconds {
    decode: Option<f64>,
}

/// The report of one input; the keys are those of the JSON output.
#[derive(Debug, Default, Serialize)]
struct InspectReport {
    file: String,
    seconds: InspectSeconds,
    #[serde(flatten)]
    stream: StreamReport,
    notes: Vec<String>,
    plot: Option<String>,
    error: Option<String>,
}

impl InputReport for InspectReport {
    fn outcome(&mut self) -> Outcome<'_> {
        Outcome { file: &self.file, proven: None, error: &mut self.error }
    }
}

/// Inspects all inputs in order; returns whether all succeeded.
pub(crate) fn run(task: &InspectTask, console: &mut Console) -> bool {
    let new_report = |input: &Input| InspectReport { file: input.name(), ..InspectReport::default() };
    let process =
        |input: &Input, console: &mut Console, report: &mut InspectReport| inspect(input, console, report);
    let show = |_: &Input, report: &InspectReport, title: &str, console: &mut Console| {
        console.result(&format!("{title}{}", summary(report, task.chunks)), true);
    };
    let mut reports = batch::process_all(&task.inputs, None, console, new_report, process, show);
    if let Some(path) = &task.plot {
        let done: Vec<&InspectReport> = reports.iter().filter(|report| report.error.is_none()).collect();
        if !done.is_empty() {
            let curve = |report: &&InspectReport| {
                let points = report.stream.chunks.iter().map(|chunk| (chunk.end, chunk.error)).collect();
                (short_name(&report.file), points)
            };
            let chart = rate::draw(&done.iter().map(curve).collect::<Vec<_>>()).map_err(Failure::from);
            if batch::write_chart(path, chart, &mut reports, console) {
                let done = reports.iter_mut().filter(|report| report.error.is_none());
                done.for_each(|report| report.plot = Some(path.display().to_string()));
            }
        }
    }
    batch::finish(reports, console)
}

fn inspect(input: &Input, console: &mut Console, report: &mut InspectReport) -> Result<(), Failure> {
    console.doing("decode");
    let (figures, seconds) = timed(|| Ok::<_, Failure>(stream_figures(&open(input)?)));
    let figures: StreamFigures = figures?;
    report.seconds.decode = Some(seconds);
    report.stream = figures.report();
    console.stage("decode", &format!("{} chunks", count(figures.chunks.len())), Some(seconds));
    if let Some(problem) = figures.problem {
        console.warning(&report.file, &problem);
        report.notes.push(problem);
    }
    Ok(())
}

/// Returns the tables of a report.
fn summary(report: &InspectReport, with_chunks: bool) -> String {
    let stream = &report.stream;
    let row = |name: &str, n: Option<usize>| vec![format!("  {name}"), count(n.unwrap_or(0))];
    let rows = [
        row("meshes", stream.meshes),
        row("vertices", stream.vertices),
        row("triangles", stream.triangles),
        row("levels", stream.levels),
        row("chunks", Some(stream.chunks.len())),
        row("bytes before the first chunk", stream.base_bytes),
        row("bytes of chunks", stream.chunk_bytes),
    ];
    let mut out = text::table(&rows, 1..2);
    let mut rows = vec![vec!["  component".to_owned(), "bits".to_owned(), "per vertex".to_owned()]];
    for ComponentBits { name, bits, per_vertex, .. } in &stream.components {
        rows.push(vec![format!("  {name}"), format!("{bits:.0}"), format!("{per_vertex:.2}")]);
    }
    let whole = stream.bits_per_vertex.unwrap_or(0.0);
    rows.push(vec!["  the whole file".into(), String::new(), format!("{whole:.2}")]);
    out.push('\n');
    out += &text::table(&rows, 1..3);
    if with_chunks {
        let names = ["  chunk", "mesh", "ends at byte", "level", "triangles", "error"];
        let mut rows = vec![names.map(str::to_owned).to_vec()];
        for (number, chunk) in stream.chunks.iter().enumerate() {
            rows.push(vec![
                format!("  {number}"),
                chunk.mesh.to_string(),
                count(chunk.end),
                count(chunk.level),
                count(chunk.triangles),
                format!("{:.3e}", chunk.error),
            ]);
        }
        out.push('\n');
        out += &text::table(&rows, 1..6);
    }
    out
}
