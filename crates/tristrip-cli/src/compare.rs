//! `tristrip compare`: all methods on the same model, with every result verified.

use std::sync::{Mutex, PoisonError};

use tristrip::StripifyOptions;
use tristrip_pipeline::text::{counted, grouped};
use tristrip_pipeline::{MethodDescription, Observer, Search, Stage, StripMetrics, compare};
use tristrip_render::text::{markdown, table};

use crate::clock::{SecondsKeys, StageClock};
use crate::console::Console;
use crate::failure::Failure;
use crate::job::Input;
use crate::report::{self, Batch};
use crate::search::check_interrupt;
use crate::stage::{load_input, show_mesh};
use crate::task::CompareTask;

/// The keys of `seconds`. Each method has its own times in addition.
pub(crate) const SECONDS: SecondsKeys = &[("load", &[Stage::Load]), ("dual", &[Stage::Prepare])];

/// A column of the table: heading, format and metric. Lower is better.
type FigureColumn = (&'static str, fn(f64) -> String, fn(&compare::Row, &StripMetrics) -> Option<f64>);

const COLUMNS: [FigureColumn; 10] = [
    ("strips", whole, |_, f| Some(f.strips as f64)),
    ("isolated", whole, |_, f| Some(f.isolated as f64)),
    ("swaps", whole, |_, f| Some(f.swaps as f64)),
    ("vertices/T", ratio, |_, f| Some(f.vertices_per_triangle)),
    ("GL cost/T", ratio, |_, f| (f.triangles > 0).then(|| f.gl_cost as f64 / f.triangles as f64)),
    ("restart/T", ratio, |_, f| Some(f.indices_restart_per_triangle)),
    ("degenerate/T", ratio, |_, f| Some(f.indices_degenerate_per_triangle)),
    ("ACMR 16", ratio, |_, f| Some(f.acmr_fifo_16)),
    ("ACMR 32", ratio, |_, f| Some(f.acmr_fifo_32)),
    ("ms", |ms| format!("{ms:.2}"), |row, _| row.seconds.stripify.map(|s| 1e3 * s)),
];

fn whole(n: f64) -> String {
    grouped(&format!("{n:.0}"))
}

fn ratio(x: f64) -> String {
    format!("{x:.3}")
}

/// Compares the methods on all inputs in order. Returns whether all inputs were processed and all
/// results are verified.
pub(crate) fn run(task: &CompareTask, console: &mut Console) -> bool {
    let options = compare::Options::default()
        .with_stripify(task.options)
        .with_effort(task.effort)
        .with_every_variant(task.every_variant);
    let method_count = options.methods().len();
    let process = |input: &Input, console: &mut Console, clock: &StageClock| {
        let compared = compare(input, &options, console, clock)?;
        let dual = clock.seconds(&[Stage::Prepare]).unwrap_or_default();
        console.result(&as_text(&input.name(), &compared, dual, task.markdown), true);
        Ok(compared)
    };
    let batch = Batch { steps: Some(method_count), budget: task.budget, ..Batch::new(SECONDS) };
    let mut reports = batch.process(&task.inputs, console, Input::name, process, |_, _, _, _| ());
    let mut proven = true;
    for report in &mut reports {
        let Some(compared) = &report.outcome else { continue };
        proven &= compared.methods.iter().all(|row| row.proven);
        if compared.methods.len() < method_count {
            let all = counted(method_count, "method");
            let error = format!("interrupted: compared {} of {all}", compared.methods.len());
            console.error(&format!("{}: {error}", report.file));
            report.error = Some(error);
        }
    }
    report::finish(&reports, console) && proven
}

fn compare(
    input: &Input,
    options: &compare::Options,
    console: &Console,
    clock: &StageClock,
) -> Result<compare::Outcome, Failure> {
    check_interrupt()?;
    let model = load_input(input, console, clock)?;
    let methods = MethodClocks { clock, console, of_methods: Mutex::default() };
    let mut compared = clock.observe_and_print(|_| compare::run(&model, options, &methods))?;
    show_mesh(&compared.mesh, &compared.notes, model.notes.len(), console);
    let clocks = methods.of_methods.into_inner().unwrap_or_else(PoisonError::into_inner);
    for (row, clock) in compared.methods.iter_mut().zip(clocks) {
        row.seconds.stripify = clock.seconds(&[Stage::Stripify]);
        row.seconds.verify = clock.seconds(&[Stage::Prove]);
        if !row.proven {
            let why = row.error.as_deref().unwrap_or("not proven");
            console.error(&format!("{}: {}: {why}", input.name(), row.method.label()));
        }
    }
    Ok(compared)
}

/// Measures the stages before the methods with one clock, and the stages of each method with a
/// separate clock.
struct MethodClocks<'a> {
    clock: &'a StageClock,
    console: &'a Console,
    of_methods: Mutex<Vec<StageClock>>,
}

impl Observer for MethodClocks<'_> {
    fn stage(&self, stage: Stage) {
        let mut clocks = self.of_methods.lock().unwrap_or_else(PoisonError::into_inner);
        if stage == Stage::Stripify {
            clocks.last().inspect(|before| before.end());
            self.clock.end();
            clocks.push(self.clock.without_times());
            self.console.step();
        }
        clocks.last().unwrap_or(self.clock).stage(stage);
    }

    fn search(&self, options: &StripifyOptions) -> Box<dyn Search + '_> {
        self.console.doing(&MethodDescription::of(options).label());
        self.clock.search(options)
    }
}

/// Returns the table of one model. The best value in each column is marked.
fn as_text(file: &str, compared: &compare::Outcome, dual: f64, as_markdown: bool) -> String {
    let mut head = vec!["method".to_owned()];
    head.extend(COLUMNS.iter().map(|(name, ..)| (*name).to_owned()));
    let mut rows = vec![head];
    let figure =
        |row: &compare::Row, column: &FigureColumn| row.metrics.as_ref().and_then(|f| column.2(row, f));
    let best = COLUMNS.map(|column| {
        let figures = compared.methods.iter().filter_map(|row| figure(row, &column));
        figures.min_by(f64::total_cmp)
    });
    for row in &compared.methods {
        let mut cells = vec![row.method.label()];
        for (column, best) in COLUMNS.iter().zip(best) {
            let cell = figure(row, column).map(|x| (column.1(x), Some(column.1(x)) == best.map(column.1)));
            cells.push(match cell {
                None => "–".into(),
                Some((text, true)) if as_markdown => format!("**{text}**"),
                Some((text, true)) => format!("*{text}"),
                Some((text, false)) => text,
            });
        }
        if row.metrics.is_none() {
            cells.push("NOT PROVEN".into());
        }
        rows.push(cells);
    }
    let title = format!("{file}: {}", counted(compared.mesh.triangles, "triangle"));
    let dual = 1e3 * dual;
    if as_markdown {
        let table = markdown(&rows, 1..1 + COLUMNS.len());
        return format!(
            "### {title}\n\n{table}\nms: without the dual graph, which is built once in {dual:.2} ms.\n\n"
        );
    }
    let legend = format!(
        "* best in its column; /T: per triangle; ms: without the dual graph, which is built once in {dual:.2} ms"
    );
    format!("{title}\n{}{legend}\n\n", table(&rows, 1..1 + COLUMNS.len()))
}
