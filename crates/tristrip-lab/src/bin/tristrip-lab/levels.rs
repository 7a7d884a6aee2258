//! `tristrip-lab levels`: filters and level models on the levels of detail of meshes.

use std::path::Path;

use serde::Serialize;
use tristrip::lod::RepairOptions;
use tristrip_lab::recovery::{self, ModelRecovery, Sweep};
use tristrip_lab::traffic::{
    self, FilterTotal, LevelRow, TrafficModel, measure_levels, totals, totals_as_text,
};
use tristrip_pipeline::text::counted;
use tristrip_pipeline::{MethodDescription, levels, levels::ModelLevels};

use crate::args::LevelsArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::input::{check_chart, load, short_name, timed, write_text};

/// The number of steps of a table and of a curve of the chart, from the base mesh to the full mesh.
const TABLE_STEPS: usize = 20;
const CURVE_STEPS: usize = 100;

/// The number of rounds whose median is the time of a recovery.
const ROUNDS: usize = 3;

/// The time of each stage in seconds; `null` for a stage that did not run.
#[derive(Debug, Clone, Copy, Default, Serialize)]
struct LevelsSeconds {
    load: Option<f64>,
    build: Option<f64>,
}

/// The report of one input; the keys are those of the JSON output.
#[derive(Debug, Default, Serialize)]
struct LevelsReport {
    file: String,
    #[serde(flatten)]
    method: MethodDescription,
    /// The effort of the filter `repair`.
    filter_effort: u8,
    seconds: LevelsSeconds,
    /// The number of collapses, which is the highest level.
    levels: Option<usize>,
    triangles_base: Option<usize>,
    triangles_full: Option<usize>,
    table: Option<Vec<LevelRow>>,
    /// Sums over all levels.
    compare: Option<Vec<FilterTotal>>,
    /// The time and the memory of every level model.
    recovery: Option<Vec<ModelRecovery>>,
    /// The rows of the chart.
    #[serde(skip)]
    rows: Vec<LevelRow>,
    plot: Option<String>,
    notes: Vec<String>,
    error: Option<String>,
}

/// Measures all inputs in order.
pub(crate) fn run(args: &LevelsArgs, console: &Console) -> Result<(), Failure> {
    if let Some(path) = &args.plot {
        check_chart("--plot", path, args.inputs.len())?;
    }
    let mut failed = false;
    let mut reports = Vec::new();
    for input in &args.inputs {
        let mut report = LevelsReport {
            file: input.display().to_string(),
            method: MethodDescription::of(&args.method.options),
            filter_effort: args.filter_effort.level(),
            ..LevelsReport::default()
        };
        match measure(input, args, console, &mut report) {
            Ok(()) => console.result(&format!("{}\n{}", report.file, summary(&report, args)))?,
            Err(Failure::Failed(message)) => {
                console.error(&message);
                report.error = Some(message);
                failed = true;
            }
            Err(other) => return Err(other),
        }
        reports.push(report);
    }
    if let Some(path) = &args.plot {
        failed |= !plot(path, args, console, &mut reports)?;
    }
    console.json(&reports)?;
    if failed { Err(Failure::Reported) } else { Ok(()) }
}

/// Builds the levels of one input, and measures what was requested.
fn measure(
    input: &Path,
    args: &LevelsArgs,
    console: &Console,
    report: &mut LevelsReport,
) -> Result<(), Failure> {
    let (model, seconds) = load(input, console)?;
    report.seconds.load = Some(seconds);
    let options = levels::Options::default().with_stripify(args.method.options).with_base(args.base);
    let options = options.with_price(args.price).with_verify(!args.no_verify);
    let (built, seconds) = timed(|| levels::run(&model, &options, &()));
    let built = built?;
    let levels = &built.model;
    report.seconds.build = Some(seconds);
    let base = counted(levels.collapses.triangles_after, "triangle");
    let what = format!("{} to a base mesh of {base}", counted(levels.collapse_count(), "collapse"));
    console.stage("build", &what, Some(seconds));
    report.levels = Some(levels.collapse_count());
    report.triangles_full = Some(levels.collapses.triangles_before);
    report.triangles_base = Some(levels.collapses.triangles_after);
    report.notes.clone_from(&built.notes);
    tables(levels, args, console, report)
}

/// Measures the requested tables.
fn tables(
    levels: &ModelLevels,
    args: &LevelsArgs,
    console: &Console,
    report: &mut LevelsReport,
) -> Result<(), Failure> {
    let repair = RepairOptions::default().with_effort(args.filter_effort);
    if args.table || args.plot.is_some() && args.sweep.is_empty() {
        let steps = if args.plot.is_some() { CURVE_STEPS } else { TABLE_STEPS };
        let at = levels.order.evenly(steps);
        let traffic = TrafficModel::new(levels);
        let (measured, seconds) = timed(|| measure_levels(&traffic, &at, repair, !args.no_verify));
        report.rows = measured?;
        console.stage("table", &format!("{}, all filters", counted(at.len(), "level")), Some(seconds));
        if args.table {
            let in_table = levels.order.evenly(TABLE_STEPS);
            let rows = report.rows.iter().filter(|row| in_table.contains(&row.level));
            report.table = Some(rows.cloned().collect());
        }
    }
    if args.compare {
        let (all, seconds) = timed(|| totals(levels, repair));
        let what = format!("{}, all filters", counted(levels.collapse_count() + 1, "level"));
        console.stage("compare", &what, Some(seconds));
        report.compare = Some(all?);
    }
    if !args.sweep.is_empty() {
        let sweeps: Vec<Sweep> = Sweep::ALL.into_iter().filter(|sweep| args.sweep.contains(sweep)).collect();
        let (measured, seconds) = timed(|| recovery::measure(levels, &sweeps, ROUNDS));
        let measured = measured?;
        console.stage("recovery", &counted(measured.len(), "model"), Some(seconds));
        report.recovery = Some(measured);
    }
    Ok(())
}

/// Draws the chart of the measured inputs. Returns whether a requested chart was written.
fn plot(
    path: &Path,
    args: &LevelsArgs,
    console: &Console,
    reports: &mut [LevelsReport],
) -> Result<bool, Failure> {
    let done: Vec<&LevelsReport> = reports.iter().filter(|report| report.error.is_none()).collect();
    if done.is_empty() {
        return Ok(true);
    }
    let name = |report: &LevelsReport| short_name(Path::new(&report.file));
    let chart = if args.sweep.is_empty() {
        traffic::draw(&done.iter().map(|report| (name(report), &report.rows[..])).collect::<Vec<_>>())?
    } else {
        let of = |report: &&LevelsReport| name(report);
        let measured = done.iter().map(|report| (of(report), report.recovery.as_deref().unwrap_or_default()));
        recovery::draw(&measured.collect::<Vec<_>>())?
    };
    let written = write_text(path, &chart, "plot", console);
    for report in reports.iter_mut().filter(|report| report.error.is_none()) {
        match &written {
            Ok(()) => report.plot = Some(path.display().to_string()),
            Err(Failure::Failed(message)) => report.error = Some(message.clone()),
            Err(_) => (),
        }
    }
    if let Err(Failure::Failed(message)) = &written {
        console.error(message);
    }
    Ok(written.is_ok())
}

/// Formats the requested tables.
fn summary(report: &LevelsReport, args: &LevelsArgs) -> String {
    let table = if args.table { report.table.as_deref().map(traffic::as_text) } else { None };
    let totals = report.compare.as_deref().map(totals_as_text);
    let recovery = report.recovery.as_deref().map(recovery::as_text);
    [table, totals, recovery].into_iter().flatten().collect()
}
