//! `tristrip-lab pareto`: all methods in one chart, indices against misses.

use std::path::Path;

use serde::Serialize;
use tristrip::StripifyOptions;
use tristrip_lab::pareto::{self, ParetoPoint};
use tristrip_pipeline::PreparedModel;

use crate::args::ParetoArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::input::{check_chart, load, short_name, timed, write_text};

/// The report of one input; the keys are those of the JSON output.
#[derive(Debug, Default, Serialize)]
struct ParetoReport {
    file: String,
    pareto: Option<Vec<ParetoPoint>>,
    plot: Option<String>,
    notes: Vec<String>,
    error: Option<String>,
}

/// Measures all inputs in order, and draws the chart.
pub(crate) fn run(args: &ParetoArgs, console: &Console) -> Result<(), Failure> {
    check_chart("-o", &args.output, args.inputs.len())?;
    let mut failed = false;
    let mut reports = Vec::new();
    for input in &args.inputs {
        let mut report = ParetoReport { file: input.display().to_string(), ..ParetoReport::default() };
        match measure(input, args, console, &mut report) {
            Ok(points) => {
                console.result(&format!("{}\n{}", report.file, pareto::as_text(&points)))?;
                report.pareto = Some(points);
            }
            Err(Failure::Failed(message)) => {
                console.error(&message);
                report.error = Some(message);
                failed = true;
            }
            Err(other) => return Err(other),
        }
        reports.push(report);
    }
    let drawn: Vec<_> = reports
        .iter()
        .filter_map(|report| Some((short_name(Path::new(&report.file)), report.pareto.as_deref()?)))
        .collect();
    if !drawn.is_empty() {
        let chart = pareto::draw(&drawn)?;
        let written = write_text(&args.output, &chart, "plot", console);
        for report in reports.iter_mut().filter(|report| report.error.is_none()) {
            match &written {
                Err(Failure::Failed(message)) => report.error = Some(message.clone()),
                _ => report.plot = Some(args.output.display().to_string()),
            }
        }
        if let Err(Failure::Failed(message)) = written {
            console.error(&message);
            failed = true;
        }
    }
    console.json(&reports)?;
    if failed { Err(Failure::Reported) } else { Ok(()) }
}

/// Measures all methods on one input.
fn measure(
    input: &Path,
    args: &ParetoArgs,
    console: &Console,
    report: &mut ParetoReport,
) -> Result<Vec<ParetoPoint>, Failure> {
    let (model, _) = load(input, console)?;
    let options = StripifyOptions::default().with_weld(args.weld).with_seed(args.seed);
    let mut options = options.with_vertex_cache(args.vertex_cache);
    if let Some(effort) = args.effort {
        options = options.with_effort(effort);
    }
    let prepared = PreparedModel::new(&model, args.weld);
    let (measured, seconds) = timed(|| pareto::measure(&prepared, &options, args.effort, &()));
    let (points, notes) = measured?;
    console.stage("pareto", &pareto::line(&points), Some(seconds));
    notes.iter().for_each(|note| console.note(note));
    report.notes = model.notes.iter().cloned().chain(notes).collect();
    Ok(points)
}
