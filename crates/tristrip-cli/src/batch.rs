//! Processes the inputs of a subcommand in order: progress, errors, results, and the JSON report are the same for all subcommands.

use std::path::Path;

use serde::Serialize;

use crate::console::Console;
use crate::failure::Failure;

/// The report of one input.
pub(crate) trait InputReport: Serialize {
    /// Returns the fields that all reports have.
    fn outcome(&mut self) -> Outcome<'_>;

    /// Returns whether the input was processed without an error.
    fn is_done(&mut self) -> bool {
        self.outcome().error.is_none()
    }
}

/// The fields that all reports have.
pub(crate) struct Outcome<'a> {
    pub(crate) file: &'a str,
    /// `None` for subcommands that prove nothing.
    pub(crate) proven: Option<&'a mut Option<bool>>,
    pub(crate) error: &'a mut Option<String>,
}

/// Processes all items in order. A failure is printed and recorded in the report of its item, and the next item follows.
///
/// `process` fills in the report; `show` prints the result, below the given title if there are several items. `steps` is the number of
/// steps per item, if known.
pub(crate) fn process_all<T, R: InputReport>(
    items: &[T],
    steps: Option<usize>,
    console: &mut Console,
    new_report: impl Fn(&T) -> R,
    process: impl Fn(&T, &mut Console, &mut R) -> Result<(), Failure>,
    show: impl Fn(&T, &R, &str, &mut Console),
) -> Vec<R> {
    let mut reports = Vec::with_capacity(items.len());
    for item in items {
        let mut report = new_report(item);
        console.begin(report.outcome().file, steps);
        let result = process(item, console, &mut report);
        console.end();
        match result {
            Ok(()) => {
                let title =
                    if items.len() > 1 { format!("{}\n", report.outcome().file) } else { String::new() };
                show(item, &report, &title, console);
            }
            Err(failure) => {
                console.error(&format!("{}: {failure}", report.outcome().file));
                record(&mut report, &failure);
            }
        }
        reports.push(report);
    }
    reports
}

fn record(report: &mut impl InputReport, failure: &Failure) {
    let outcome = report.outcome();
    if let (Some(proven), Failure::Unproven { .. }) = (outcome.proven, failure) {
        *proven = Some(false);
    }
    *outcome.error = Some(failure.to_string());
}

/// Writes the chart of all inputs that were processed, and returns whether it was written. A failure is an error of all these inputs.
pub(crate) fn write_chart<R: InputReport>(
    path: &Path,
    chart: Result<String, Failure>,
    reports: &mut [R],
    console: &Console,
) -> bool {
    let written = chart.and_then(|text| {
        tristrip_io::replace_file(path, text.as_bytes()).map_err(|error| Failure::writing(&error))
    });
    let Err(failure) = written else { return true };
    console.error(&failure.to_string());
    for report in reports {
        report.outcome().error.get_or_insert_with(|| failure.to_string());
    }
    false
}

/// Prints the reports as JSON if requested, and returns whether all inputs were processed without an error.
pub(crate) fn finish<R: InputReport>(mut reports: Vec<R>, console: &mut Console) -> bool {
    console.json(&reports, reports.len() > 1);
    reports.iter_mut().all(InputReport::is_done)
}
