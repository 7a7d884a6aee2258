//! Processes the inputs of a subcommand in order and reports each one: the outcome of its operation
//! with the stage times, or the error. Progress, errors and the JSON report work the same way in
//! all subcommands.

use std::path::Path;
use std::time::Duration;

use serde::Serialize;
use tristrip_pipeline::UnprovenMetrics;

use crate::clock::{Seconds, SecondsKeys, StageClock};
use crate::console::Console;
use crate::failure::Failure;

/// The report on one input. The field names are the keys of the JSON output. If the input failed,
/// the report contains an error instead of the outcome.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Report<O> {
    /// The input as given; `-` for standard input.
    pub(crate) file: String,
    /// The time per stage, in seconds.
    #[serde(skip_serializing_if = "Seconds::has_no_keys")]
    pub(crate) seconds: Seconds,
    #[serde(flatten)]
    #[cfg_attr(feature = "schema", schemars(with = "O"))]
    pub(crate) outcome: Option<O>,
    #[serde(flatten)]
    #[cfg_attr(feature = "schema", schemars(skip))]
    unproven: Option<Unproven>,
    /// The error message; `null` if everything succeeded.
    pub(crate) error: Option<String>,
}

/// The known data of a result that fails verification.
#[derive(Debug, Serialize)]
struct Unproven {
    proven: bool,
    #[serde(flatten)]
    metrics: Option<Box<UnprovenMetrics>>,
}

impl<O> Report<O> {
    /// Reports a result.
    pub(crate) fn new(file: String, seconds: Seconds, result: Result<O, Failure>) -> Self {
        match result {
            Ok(outcome) => Self { file, seconds, outcome: Some(outcome), unproven: None, error: None },
            Err(failure) => {
                let error = Some(failure.to_string());
                let unproven = match failure {
                    Failure::Unproven { metrics, .. } => Some(Unproven { proven: false, metrics }),
                    _ => None,
                };
                Self { file, seconds, outcome: None, unproven, error }
            }
        }
    }
}

/// The settings that all inputs of a subcommand share.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Batch {
    /// The keys of `seconds`.
    pub(crate) seconds: SecondsKeys,
    /// The number of steps per input that the progress display counts, if known.
    pub(crate) steps: Option<usize>,
    /// The time limit of each search.
    pub(crate) budget: Option<Duration>,
}

impl Batch {
    /// Creates settings with these keys of `seconds`, without a step count and a time budget.
    pub(crate) fn new(seconds: SecondsKeys) -> Self {
        Self { seconds, steps: None, budget: None }
    }

    /// Processes all items in order. A failure is printed and reported; then the next item follows.
    ///
    /// `name` returns the name of an input. `show` prints an outcome; the title is empty if there
    /// is only one item.
    pub(crate) fn process<T, O>(
        self,
        items: &[T],
        console: &mut Console,
        name: impl Fn(&T) -> String,
        process: impl Fn(&T, &mut Console, &StageClock) -> Result<O, Failure>,
        show: impl Fn(&T, &O, &str, &mut Console),
    ) -> Vec<Report<O>> {
        let mut reports = Vec::with_capacity(items.len());
        for item in items {
            let name = name(item);
            console.begin(&name, self.steps);
            let clock = StageClock::new(console, self.budget);
            let result = process(item, console, &clock);
            console.end();
            match &result {
                Ok(outcome) => {
                    let title = if items.len() > 1 { format!("{name}\n") } else { String::new() };
                    show(item, outcome, &title, console);
                }
                Err(failure) => console.error(&format!("{name}: {failure}")),
            }
            reports.push(Report::new(name, clock.into_seconds(self.seconds), result));
        }
        reports
    }
}

/// Writes the chart of all processed inputs and returns whether this succeeded. A failure is
/// reported as an error of all these inputs.
pub(crate) fn write_chart<O>(
    path: &Path,
    chart: Result<String, Failure>,
    reports: &mut [Report<O>],
    console: &Console,
) -> bool {
    let written = chart.and_then(|text| {
        tristrip_io::replace_file(path, text.as_bytes()).map_err(|error| Failure::writing(&error))
    });
    let Err(failure) = written else { return true };
    console.error(&failure.to_string());
    for report in reports {
        report.error.get_or_insert_with(|| failure.to_string());
    }
    false
}

/// Prints the reports as JSON if requested. Returns whether all inputs were processed without an
/// error.
pub(crate) fn finish<O: Serialize>(reports: &[Report<O>], console: &mut Console) -> bool {
    console.json(reports, reports.len() > 1);
    reports.iter().all(|report| report.error.is_none())
}

#[cfg(test)]
mod tests {
    use super::*;
    use tristrip::Strips;
    use tristrip_io::{Format, read};
    use tristrip_pipeline::strip;

    #[test]
    fn the_report_of_an_unproven_result_has_its_metrics() {
        let square = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", Format::Obj).unwrap();
        let mut half = Strips::default();
        half.push(&[0, 1, 2]);
        let result = strip::of_strips(&square, vec![half], None, &strip::Options::default(), &());
        let report = Report::new("a.obj".into(), Seconds::default(), result.map_err(Failure::from));
        let json = serde_json::to_value(&report).unwrap();
        assert_eq!(
            (&json["proven"], &json["triangles"], &json["strips"]),
            (&false.into(), &1.into(), &1.into())
        );
        assert!(json["error"].as_str().unwrap().starts_with("not proven: "), "{json}");
    }

    #[test]
    fn the_report_of_a_failure_has_no_outcome() {
        let failed: Result<strip::Outcome, _> = Err(Failure::Input("not a mesh".into()));
        let json = serde_json::to_string(&Report::new("a".into(), Seconds::default(), failed)).unwrap();
        assert_eq!(json, r#"{"file":"a","error":"not a mesh"}"#);
    }
}
