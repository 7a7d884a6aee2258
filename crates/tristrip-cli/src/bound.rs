//! `tristrip bound`: lower bounds on strips, vertices and indices, and how they were found.

use serde::Serialize;
use tristrip_pipeline::text::{count, counted};
use tristrip_pipeline::{BoundGap, Bounds, ComponentReport, Event, MeshFigures, bound_observed};
use tristrip_render::text::table;

use crate::batch::{self, InputReport, Outcome};
use crate::console::Console;
use crate::failure::Failure;
use crate::job::Input;
use crate::stage::{Seconds, Stages, load_timed};
use crate::task::BoundTask;

/// Returns a line on the gap.
pub(crate) fn gap_line(gap: &BoundGap) -> String {
    let (one, many) = match gap.figure {
        "strips" => ("strip", "strips"),
        "vertices_sent" | "gl_cost" => ("vertex", "vertices"),
        _ => ("index", "indices"),
    };
    let (found, bound) = (count(gap.found), count(gap.bound));
    let what = if gap.found == 1 { one } else { many };
    if gap.optimal {
        return format!("optimal: {found} {what}, no cover of the dual graph has fewer");
    }
    let percent = 100.0 * gap.gap as f64 / gap.bound.max(1) as f64;
    format!("{found} {what}, lower bound {bound}: gap {} ({percent:.1} %)", count(gap.gap))
}

/// The report of one input; the keys are those of the JSON output.
#[derive(Debug, Default, Serialize)]
struct BoundReport {
    file: String,
    seconds: Seconds,
    mesh: Option<MeshFigures>,
    parts: Option<usize>,
    bound: Option<Bounds>,
    /// For each part, whether one strip without swaps draws it completely.
    sequential: Vec<bool>,
    components: Vec<ComponentReport>,
    notes: Vec<String>,
    error: Option<String>,
}

impl InputReport for BoundReport {
    fn outcome(&mut self) -> Outcome<'_> {
        Outcome { file: &self.file, proven: None, error: &mut self.error }
    }
}

/// Bounds all inputs in order; returns whether all succeeded.
pub(crate) fn run(task: &BoundTask, console: &mut Console) -> bool {
    let new_report = |input: &Input| BoundReport { file: input.name(), ..BoundReport::default() };
    let process =
        |input: &Input, console: &mut Console, report: &mut BoundReport| bound(input, task, console, report);
    let show = |_: &Input, report: &BoundReport, _: &str, console: &mut Console| {
        console.result(&report.as_text(), true);
    };
    let reports = batch::process_all(&task.inputs, None, console, new_report, process, show);
    batch::finish(reports, console)
}

fn bound(
    input: &Input,
    task: &BoundTask,
    console: &Console,
    report: &mut BoundReport,
) -> Result<(), Failure> {
    let (model, load) = load_timed(input, console)?;
    report.seconds.load = Some(load);
    let show = |event: Event<'_>, seconds: f64| match event {
        Event::Prepared => report.seconds.dual = Some(seconds),
        Event::Surveyed { parts, mesh, notes } => {
            (report.parts, report.mesh) = (Some(parts), Some(mesh.clone()));
            report.notes = notes.to_vec();
        }
        Event::Bounded(_) => report.seconds.stripify = Some(seconds),
        _ => (),
    };
    let bounded = bound_observed(&model, task.options.weld, &Stages::new(console, load, show))?;
    report.components = bounded.components();
    console.stage("bound", &counted(report.components.len(), "component"), report.seconds.stripify);
    report.bound = Some(bounded.bounds);
    report.sequential = bounded.parts.iter().map(|part| part.sequential).collect();
    Ok(())
}

/// Returns a line on how a bound was found.
fn proof_text(proof: &str) -> &'static str {
    match proof {
        "leaves" => "faces with at most one neighbour are ends of strips",
        "matching" => "maximum matching in each block, and the bridges between blocks",
        "subproblems" => "matching, and small subproblems solved exactly",
        "exact" => "solved exactly: the bound can be reached",
        _ => "at least one strip",
    }
}

impl BoundReport {
    fn as_text(&self) -> String {
        let Some(bound) = self.bound else { return String::new() };
        let row = |name: &str, n: usize| vec![format!("  {name}"), count(n)];
        let rows = [
            vec![self.file.clone(), "lower bound".into()],
            row("strips", bound.strips),
            row("vertices sent (OpenGL)", bound.vertices_sent),
            row("with free swaps (GL)", bound.gl_cost),
            row("indices, restart", bound.indices_restart),
            row("indices, degenerate", bound.indices_degenerate),
        ];
        let proofs =
            ["exact", "subproblems", "matching", "leaves", "one-strip"].into_iter().filter_map(|proof| {
                let proven_so = || self.components.iter().filter(|component| component.proof == proof);
                let components = proven_so().count();
                let strips = counted(proven_so().map(|component| component.strips).sum(), "strip");
                let components = (components > 0).then(|| counted(components, "component"))?;
                Some(format!("  {components}, {strips}: {}\n", proof_text(proof)))
            });
        let sequential = !self.sequential.is_empty() && self.sequential.iter().all(|&sequential| sequential);
        let sequential =
            sequential.then(|| "  sequential: one strip without swaps draws the model\n".to_owned());
        table(&rows, 1..2) + &proofs.chain(sequential).collect::<String>()
    }
}
