//! `tristrip bound`: lower bounds on strips, vertices and indices, and how they were computed.

use tristrip_pipeline::text::{count, counted};
use tristrip_pipeline::{BoundGap, Stage, bound};
use tristrip_render::text::table;

use crate::clock::{SecondsKeys, StageClock};
use crate::console::Console;
use crate::failure::Failure;
use crate::job::Input;
use crate::report::{self, Batch};
use crate::stage::{load_input, show_mesh};
use crate::task::BoundTask;

/// The keys of `seconds`.
pub(crate) const SECONDS: SecondsKeys =
    &[("load", &[Stage::Load]), ("dual", &[Stage::Prepare]), ("bound", &[Stage::Bound])];

/// Returns a line that reports the gap to a bound.
pub(crate) fn gap_line(gap: &BoundGap) -> String {
    let noun = match gap.figure {
        "strips" => "strip",
        "vertices_sent" | "gl_cost" => "vertex",
        _ => "index",
    };
    let (found, bound) = (counted(gap.found, noun), count(gap.bound));
    if gap.optimal {
        return format!("optimal: {found}, no cover of the dual graph has fewer");
    }
    let percent = 100.0 * gap.gap as f64 / gap.bound.max(1) as f64;
    format!("{found}, lower bound {bound}: gap {} ({percent:.1} %)", count(gap.gap))
}

/// Bounds all inputs in order; returns whether all succeeded.
pub(crate) fn run(task: &BoundTask, console: &mut Console) -> bool {
    let process =
        |input: &Input, console: &mut Console, clock: &StageClock| bound(input, task, console, clock);
    let show = |input: &Input, bound: &bound::Outcome, _: &str, console: &mut Console| {
        console.result(&as_text(&input.name(), bound), true);
    };
    let reports = Batch::new(SECONDS).process(&task.inputs, console, Input::name, process, show);
    report::finish(&reports, console)
}

fn bound(
    input: &Input,
    task: &BoundTask,
    console: &Console,
    clock: &StageClock,
) -> Result<bound::Outcome, Failure> {
    let model = load_input(input, console, clock)?;
    let options = bound::Options::default().with_weld(task.options.weld);
    let found = clock.observe_and_print(|observer| bound::run(&model, &options, observer))?;
    show_mesh(&found.mesh, &found.notes, model.notes.len(), console);
    Ok(found)
}

/// Returns how a bound was computed.
fn proof_text(proof: &str) -> &'static str {
    match proof {
        "leaves" => "faces with at most one neighbour are strip ends",
        "matching" => "maximum matching in each block, and bridges between blocks",
        "subproblems" => "maximum matching, with small subproblems solved exactly",
        "exact" => "solved exactly: the bound can be reached",
        _ => "at least one strip",
    }
}

fn as_text(file: &str, found: &bound::Outcome) -> String {
    let bound = &found.bound;
    let row = |name: &str, n: usize| vec![format!("  {name}"), count(n)];
    let rows = [
        vec![file.to_owned(), "lower bound".into()],
        row("strips", bound.strips),
        row("vertices sent (OpenGL)", bound.vertices_sent),
        row("with free swaps (GL)", bound.gl_cost),
        row("indices, restart", bound.indices_restart),
        row("indices, degenerate", bound.indices_degenerate),
    ];
    let proofs =
        ["exact", "subproblems", "matching", "leaves", "one-strip"].into_iter().filter_map(|proof| {
            let proven_so = || found.components.iter().filter(|component| component.proof == proof);
            let components = proven_so().count();
            let strips = counted(proven_so().map(|component| component.strips).sum(), "strip");
            let components = (components > 0).then(|| counted(components, "component"))?;
            Some(format!("  {components}, {strips}: {}\n", proof_text(proof)))
        });
    let sequential = !found.sequential.is_empty() && found.sequential.iter().all(|&sequential| sequential);
    let sequential = sequential.then(|| "  sequential: one strip without swaps draws the model\n".to_owned());
    table(&rows, 1..2) + &proofs.chain(sequential).collect::<String>()
}
