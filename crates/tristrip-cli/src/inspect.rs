//! `tristrip inspect`: what a progressive GLB holds, and what it costs.

use serde::Serialize;
use tristrip_lab::{rate, text};
use tristrip_pipeline::text::count;
use tristrip_pipeline::{ChunkFigures, StreamFigures, rounded, stream_figures};

use crate::batch::{self, InputReport, Outcome};
use crate::console::Console;
use crate::failure::Failure;
use crate::input::short_name;
use crate::job::Input;
use crate::stage::timed;
use crate::task::InspectTask;
use crate::unpack::open;

/// The bits of a component, and those per vertex of the full meshes.
#[derive(Debug, Clone, Serialize)]
struct Component {
    name: &'static str,
    bits: f64,
    per_vertex: f64,
}

/// A chunk; the keys are those of the JSON output.
#[derive(Debug, Clone, Serialize)]
struct Chunk {
    mesh: usize,
    end: usize,
    level: usize,
    triangles: usize,
    surface_error: f32,
}

impl Chunk {
    fn new(figures: &ChunkFigures) -> Self {
        let ChunkFigures { mesh, end, level, triangles, error, .. } = *figures;
        Self { mesh, end, level, triangles, surface_error: error }
    }
}

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
    meshes: Option<usize>,
    vertices: Option<usize>,
    triangles: Option<usize>,
    levels: Option<usize>,
    position_bits: Option<u32>,
    /// The bytes before the first chunk, and those of all chunks in the whole file.
    base_bytes: Option<usize>,
    chunk_bytes: Option<usize>,
    bits_per_vertex: Option<f64>,
    components: Vec<Component>,
    chunks: Vec<Chunk>,
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
                let points = report.chunks.iter().map(|chunk| (chunk.end, chunk.surface_error)).collect();
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
    let per_vertex = |bits: f64| rounded(bits / figures.vertices.max(1) as f64);
    let costs = figures.costs;
    let base_bits = 8.0 * figures.chunk_start as f64;
    let parts = [
        ("file before the chunks", base_bits),
        ("base meshes", costs.base),
        ("marks", costs.marks),
        ("corners", costs.corners),
        ("positions", costs.positions),
        ("precision", costs.precision),
        ("attributes", costs.attributes),
    ];
    let decoded = figures.chunks.last().map_or(0, |chunk| chunk.end.saturating_sub(figures.chunk_start));
    let rest = 8.0 * decoded as f64 - parts[1..].iter().map(|(_, bits)| bits).sum::<f64>();
    let components = parts.into_iter().chain([("heads and rounding", rest)]);
    report.components = components
        .map(|(name, bits)| Component { name, bits: bits.round(), per_vertex: per_vertex(bits) })
        .collect();
    report.seconds.decode = Some(seconds);
    report.meshes = Some(figures.meshes);
    report.vertices = Some(figures.vertices);
    report.triangles = Some(figures.triangles);
    report.levels = Some(figures.full_level);
    report.position_bits = Some(figures.position_bits);
    report.base_bytes = Some(figures.chunk_start);
    report.chunk_bytes = Some(figures.chunk_bytes);
    report.bits_per_vertex = Some(per_vertex(8.0 * (figures.chunk_start + figures.chunk_bytes) as f64));
    report.chunks = figures.chunks.iter().map(Chunk::new).collect();
    console.stage("decode", &format!("{} chunks", count(figures.chunks.len())), Some(seconds));
    if let Some(problem) = figures.problem {
        console.warning(&report.file, &problem);
        report.notes.push(problem);
    }
    Ok(())
}

/// Returns the tables of a report.
fn summary(report: &InspectReport, with_chunks: bool) -> String {
    let row = |name: &str, n: Option<usize>| vec![format!("  {name}"), count(n.unwrap_or(0))];
    let rows = [
        row("meshes", report.meshes),
        row("vertices", report.vertices),
        row("triangles", report.triangles),
        row("levels", report.levels),
        row("chunks", Some(report.chunks.len())),
        row("bytes before the first chunk", report.base_bytes),
        row("bytes of chunks", report.chunk_bytes),
    ];
    let mut out = text::table(&rows, 1..2);
    let mut rows = vec![vec!["  component".to_owned(), "bits".to_owned(), "per vertex".to_owned()]];
    for Component { name, bits, per_vertex } in &report.components {
        rows.push(vec![format!("  {name}"), format!("{bits:.0}"), format!("{per_vertex:.2}")]);
    }
    let whole = report.bits_per_vertex.unwrap_or(0.0);
    rows.push(vec!["  the whole file".into(), String::new(), format!("{whole:.2}")]);
    out.push('\n');
    out += &text::table(&rows, 1..3);
    if with_chunks {
        let names = ["  chunk", "mesh", "ends at byte", "level", "triangles", "error"];
        let mut rows = vec![names.map(str::to_owned).to_vec()];
        for (number, chunk) in report.chunks.iter().enumerate() {
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
