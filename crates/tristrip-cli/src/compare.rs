//! `tristrip compare`: all methods on the same model side by side, each result proven.

use serde::Serialize;
use tristrip::StripifyOptions;
use tristrip_pipeline::text::{counted, grouped};
use tristrip_pipeline::{
    Event, Figures, MeshFigures, MethodReport, PreparedModel, Search, Survey, compared_methods,
};
use tristrip_render::text::{markdown, table};

use crate::batch::{self, InputReport, Outcome};
use crate::console::Console;
use crate::failure::Failure;
use crate::job::Input;
use crate::search::{SearchWatch, interrupted};
use crate::stage::{Seconds, Stages, load_timed, timed};
use crate::task::CompareTask;

/// The report of one input; the keys are those of the JSON output.
#[derive(Debug, Serialize)]
struct CompareReport {
    file: String,
    seconds: Seconds,
    mesh: Option<MeshFigures>,
    parts: Option<usize>,
    notes: Vec<String>,
    methods: Vec<MethodRow>,
    error: Option<String>,
}

/// The result of one method.
type MethodRow = tristrip_pipeline::MethodRow<Seconds>;

impl InputReport for CompareReport {
    fn outcome(&mut self) -> Outcome<'_> {
        Outcome { file: &self.file, proven: None, error: &mut self.error }
    }
}

/// A column of the table: head, format, and figure, of which less is better.
type FigureColumn = (&'static str, fn(f64) -> String, fn(&MethodRow, &Figures) -> Option<f64>);

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

/// Compares the methods on all inputs in order; returns whether all results are proven.
pub(crate) fn run(task: &CompareTask, console: &mut Console) -> bool {
    let methods = compared_methods(task.options, task.effort, task.every_variant);
    let new_report = |input: &Input| CompareReport {
        file: input.name(),
        seconds: Seconds::default(),
        mesh: None,
        parts: None,
        notes: Vec::new(),
        methods: Vec::new(),
        error: None,
    };
    let process = |input: &Input, console: &mut Console, report: &mut CompareReport| {
        let result = compare(input, task, &methods, console, report);
        for row in report.methods.iter().filter(|row| !row.proven) {
            let why = row.error.as_deref().unwrap_or("not proven");
            console.error(&format!("{}: {}: {why}", report.file, row.method.label()));
        }
        result
    };
    let show = |_: &Input, report: &CompareReport, _: &str, console: &mut Console| {
        console.result(&as_text(report, task.markdown), true);
    };
    let reports = batch::process_all(&task.inputs, Some(methods.len()), console, new_report, process, show);
    let proven = reports.iter().flat_map(|report| &report.methods).all(|row| row.proven);
    batch::finish(reports, console) && proven
}

fn compare(
    input: &Input,
    task: &CompareTask,
    methods: &[StripifyOptions],
    console: &Console,
    report: &mut CompareReport,
) -> Result<(), Failure> {
    let (model, load) = load_timed(input, console)?;
    report.seconds.load = Some(load);
    let show = |event: Event<'_>, seconds: f64| {
        if let Event::Prepared = event {
            report.seconds.dual = Some(seconds);
        }
    };
    let survey = Survey::new(&model, task.options, &Stages::new(console, load, show))?;
    report.notes = survey.notes;
    (report.parts, report.mesh) = (Some(survey.prepared.parts().len()), Some(survey.mesh));
    for options in methods {
        if interrupted() {
            return Err(Failure::Input("not processed: interrupted".into()));
        }
        let options = options.with_weld(survey.options.weld);
        console.doing(&MethodReport::of(&options).label());
        let watch = SearchWatch::new(console.progress(), task.budget, &options);
        report.methods.push(row(&survey.prepared, &options, &watch));
        console.step();
    }
    Ok(())
}

/// Runs one method; its row has figures only if the result is proven.
fn row(prepared: &PreparedModel<'_>, options: &StripifyOptions, watch: &SearchWatch) -> MethodRow {
    let mut times = Seconds::default();
    let (found, seconds) = timed(|| prepared.find_strips(options, watch));
    times.stripify = Some(seconds);
    let figures = found.and_then(|strips| {
        let (proof, seconds) = timed(|| prepared.prove(&strips));
        times.verify = Some(seconds);
        proof?;
        prepared.figures(&strips, options)
    });
    let figures = figures.map_err(|error| Failure::from(error).to_string());
    MethodRow::new(options, times, watch.stopped(), figures)
}

/// Returns the table of one model; the best figure of each column is marked.
fn as_text(report: &CompareReport, as_markdown: bool) -> String {
    let mut head = vec!["method".to_owned()];
    head.extend(COLUMNS.iter().map(|(name, ..)| (*name).to_owned()));
    let mut rows = vec![head];
    let figure = |row: &MethodRow, column: &FigureColumn| row.figures.as_ref().and_then(|f| column.2(row, f));
    let best = COLUMNS.map(|column| {
        let figures = report.methods.iter().filter_map(|row| figure(row, &column));
        figures.min_by(f64::total_cmp)
    });
    for row in &report.methods {
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
        if row.figures.is_none() {
            cells.push("NOT PROVEN".into());
        }
        rows.push(cells);
    }
    let triangles = report.mesh.as_ref().map_or(0, |mesh| mesh.triangles);
    let title = format!("{}: {}", report.file, counted(triangles, "triangle"));
    let dual = report.seconds.dual.map_or(0.0, |s| 1e3 * s);
    if as_markdown {
        let table = markdown(&rows, 1..1 + COLUMNS.len());
        return format!(
            "### {title}\n\n{table}\nms: without the dual graph, which takes {dual:.2} ms once.\n\n"
        );
    }
    let legend = format!(
        "* best of its column; /T: per triangle; ms: without the dual graph, which takes {dual:.2} ms once"
    );
    format!("{title}\n{}{legend}\n\n", table(&rows, 1..1 + COLUMNS.len()))
}
