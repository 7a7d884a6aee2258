//! `tristrip inspect`: chunks, bits and errors of a progressive GLB.

use serde::Serialize;
use tristrip_pipeline::Stage;
use tristrip_pipeline::inspect::{self, ComponentBits};
use tristrip_pipeline::text::count;
use tristrip_pipeline::text::counted;
use tristrip_render::{rate, text};

use crate::clock::{SecondsKeys, StageClock};
use crate::console::Console;
use crate::failure::Failure;
use crate::input::short_name;
use crate::job::Input;
use crate::report::{self, Batch, Report};
use crate::task::InspectTask;
use crate::unpack::open;

/// The stages that count as decoding.
const DECODING: &[Stage] = &[Stage::Load, Stage::Decode];

/// The keys of `seconds`.
pub(crate) const SECONDS: SecondsKeys = &[("decode", DECODING)];

/// The report on one input. The field names are the keys of the JSON output.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Inspected {
    #[serde(flatten)]
    outcome: inspect::Outcome,
    /// The SVG chart that was written; `null` without `--plot`.
    plot: Option<String>,
}

/// Inspects all inputs in order; returns whether all succeeded.
pub(crate) fn run(task: &InspectTask, console: &mut Console) -> bool {
    let show = |_: &Input, inspected: &Inspected, title: &str, console: &mut Console| {
        console.result(&format!("{title}{}", summary(&inspected.outcome, task.chunks)), true);
    };
    let mut reports = Batch::new(SECONDS).process(&task.inputs, console, Input::name, inspect, show);
    if let Some(path) = &task.plot {
        let curves: Vec<_> = reports.iter().filter_map(curve).collect();
        if !curves.is_empty() {
            let chart = rate::draw(&curves).map_err(Failure::from);
            if report::write_chart(path, chart, &mut reports, console) {
                let done = reports.iter_mut().filter_map(|report| report.outcome.as_mut());
                done.for_each(|inspected| inspected.plot = Some(path.display().to_string()));
            }
        }
    }
    report::finish(&reports, console)
}

/// Returns the short name of a decoded input, with the end and the error of each chunk.
fn curve(report: &Report<Inspected>) -> Option<(String, Vec<(usize, f32)>)> {
    let chunks = &report.outcome.as_ref()?.outcome.chunks;
    let points = chunks.iter().map(|chunk| (chunk.end, chunk.surface_error)).collect();
    Some((short_name(&report.file), points))
}

fn inspect(input: &Input, console: &mut Console, clock: &StageClock) -> Result<Inspected, Failure> {
    let glb = clock.timed(Stage::Load, || open(input))?;
    let outcome = clock.observe(|observer| inspect::run(&glb, observer))?;
    let what = counted(outcome.chunks.len(), "chunk");
    console.stage("decode", &what, clock.seconds(DECODING));
    if let Some(problem) = &outcome.problem {
        console.warning(&input.name(), problem);
    }
    Ok(Inspected { outcome, plot: None })
}

/// Returns the tables that describe a stream.
fn summary(stream: &inspect::Outcome, with_chunks: bool) -> String {
    let row = |name: &str, n: usize| vec![format!("  {name}"), count(n)];
    let rows = [
        row("meshes", stream.meshes),
        row("vertices", stream.vertices),
        row("triangles", stream.triangles),
        row("levels", stream.levels),
        row("chunks", stream.chunks.len()),
        row("bytes before the first chunk", stream.base_bytes),
        row("bytes of chunks", stream.chunk_bytes),
    ];
    let mut out = text::table(&rows, 1..2);
    let mut rows = vec![vec!["  component".to_owned(), "bits".to_owned(), "per vertex".to_owned()]];
    for ComponentBits { name, bits, per_vertex, .. } in &stream.components {
        rows.push(vec![format!("  {name}"), format!("{bits:.0}"), format!("{per_vertex:.2}")]);
    }
    let whole = stream.bits_per_vertex;
    rows.push(vec!["  whole file".into(), String::new(), format!("{whole:.2}")]);
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
                format!("{:.3e}", chunk.surface_error),
            ]);
        }
        out.push('\n');
        out += &text::table(&rows, 1..6);
    }
    out
}
