//! The command's observer of the pipeline. It measures the time of each stage of an input, prints a
//! line when a stage ends, shows the progress and watches searches.

use std::collections::BTreeMap;
use std::ops::Deref;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use tristrip::StripifyOptions;
use tristrip_pipeline::{Observer, Search, Stage};

use crate::console::{Console, Lines};
use crate::search::SearchWatch;

/// The keys of `seconds` in a report. The value of a key is the sum of the times of its stages.
pub(crate) type SecondsKeys = &'static [(&'static str, &'static [Stage])];

/// The keys of commands that build or read strips.
pub(crate) const STRIP_SECONDS: SecondsKeys = &[
    ("load", &[Stage::Load]),
    ("dual", &[Stage::Prepare]),
    ("stripify", &[Stage::Stripify]),
    ("verify", &[Stage::Prove, Stage::ReadBack]),
    ("write", &[Stage::Reorder, Stage::Encode, Stage::Write]),
];

/// The stages that count as packing a model.
pub(crate) const PACKING: &[Stage] = &[Stage::Simplify, Stage::Encode, Stage::ReadBack];

/// Returns the name of a stage and a description, for its line.
fn stage_text(stage: Stage) -> (&'static str, &'static str) {
    match stage {
        Stage::Prepare => ("dual", "faces joined across shared edges"),
        Stage::Survey => ("mesh", "edges, vertices and components counted"),
        Stage::Stripify => ("stripify", "strips built"),
        Stage::Measure => ("measure", "indices counted and vertex caches simulated"),
        Stage::Bound => ("bound", "lower bounds computed"),
        Stage::Prove => ("verify", "result proven"),
        Stage::Simplify => ("simplify", "half-edges collapsed"),
        Stage::Fit => ("fit", "vertices moved closer to the original"),
        Stage::Rebuild => ("rebuild", "model rebuilt without unused vertices"),
        Stage::Compare => ("compare", "distances to the original measured"),
        Stage::Reorder => ("reorder", "vertices reordered by first use"),
        Stage::Encode => ("encode", "result encoded"),
        Stage::ReadBack => ("verify", "bytes read back and proven"),
        // The command prints the lines of the other stages with their results.
        _ => ("stage", ""),
    }
}

/// The time of each stage in seconds; serialized as a map with the keys of its command, `null` for
/// stages that did not run.
#[derive(Debug, Clone, Default)]
pub(crate) struct Seconds {
    keys: SecondsKeys,
    times: BTreeMap<Stage, f64>,
}

impl Seconds {
    /// Returns whether the command reports no times.
    pub(crate) fn has_no_keys(&self) -> bool {
        self.keys.is_empty()
    }

    /// Returns the sum of the times of stages; `None` if none of them ran.
    fn of(&self, stages: &[Stage]) -> Option<f64> {
        stages.iter().filter_map(|stage| self.times.get(stage)).copied().reduce(|a, b| a + b)
    }
}

impl Serialize for Seconds {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.keys.len()))?;
        for (key, stages) in self.keys {
            map.serialize_entry(key, &self.of(stages))?;
        }
        map.end()
    }
}

/// Describes an object whose keys depend on the command; [`crate::report_schemas`] adds them.
#[cfg(feature = "schema")]
impl schemars::JsonSchema for Seconds {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Seconds".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({ "type": "object", "properties": {} })
    }
}

/// Measures the stages of an input. A stage ends when the next stage starts or the operation ends.
pub(crate) struct StageClock {
    lines: Lines,
    budget: Option<Duration>,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    current: Option<(Stage, Instant)>,
    times: BTreeMap<Stage, f64>,
    /// Whether a line is printed when a stage ends.
    prints: bool,
}

impl State {
    /// Ends the current stage; returns it with its time.
    fn end(&mut self) -> Option<(Stage, f64)> {
        let (stage, started) = self.current.take()?;
        let seconds = started.elapsed().as_secs_f64();
        *self.times.entry(stage).or_default() += seconds;
        Some((stage, seconds))
    }
}

impl StageClock {
    /// Creates a clock that shows stages in the progress display and stops each search after the
    /// budget.
    pub(crate) fn new(console: &Console, budget: Option<Duration>) -> Self {
        Self { lines: console.lines(), budget, state: Mutex::default() }
    }

    /// Creates a clock without times, for work that is reported separately.
    pub(crate) fn without_times(&self) -> Self {
        Self { lines: self.lines.clone(), budget: self.budget, state: Mutex::default() }
    }

    /// Creates a clock for a part of the work. Its times are added to this clock when it is
    /// dropped, even if the part fails.
    pub(crate) fn part(&self) -> PartClock<'_> {
        PartClock { clock: self.without_times(), whole: self }
    }

    /// Calls an operation with this observer and ends its last stage.
    pub(crate) fn observe<R>(&self, operation: impl FnOnce(&dyn Observer) -> R) -> R {
        let result = operation(self);
        self.end();
        result
    }

    /// Calls an operation with this observer and prints a line when a stage ends without an error.
    pub(crate) fn observe_and_print<R, E>(
        &self,
        operation: impl FnOnce(&dyn Observer) -> Result<R, E>,
    ) -> Result<R, E> {
        self.state().prints = true;
        let result = operation(self);
        self.state().prints = result.is_ok();
        self.end();
        self.state().prints = false;
        result
    }

    /// Ends the current stage, if there is one.
    pub(crate) fn end(&self) {
        let mut state = self.state();
        let Some((stage, seconds)) = state.end() else { return };
        if state.prints {
            let (name, what) = stage_text(stage);
            self.lines.stage(name, what, Some(seconds));
        }
    }

    /// Calls `work` as a stage.
    pub(crate) fn timed<R>(&self, stage: Stage, work: impl FnOnce() -> R) -> R {
        self.observe(|observer| {
            observer.stage(stage);
            work()
        })
    }

    /// Adds the time of a stage that was measured elsewhere.
    pub(crate) fn add_seconds(&self, stage: Stage, seconds: f64) {
        *self.state().times.entry(stage).or_default() += seconds;
    }

    /// Adds the times of another clock.
    pub(crate) fn add(&self, other: &Self) {
        for (&stage, &seconds) in &other.state().times {
            self.add_seconds(stage, seconds);
        }
    }

    /// Returns the sum of the times of some stages so far; `None` if none of them ran.
    pub(crate) fn seconds(&self, stages: &[Stage]) -> Option<f64> {
        let times = self.state().times.clone();
        Seconds { keys: &[], times }.of(stages)
    }

    /// Returns the times for a report with these keys.
    pub(crate) fn into_seconds(self, keys: SecondsKeys) -> Seconds {
        let mut state = self.state.into_inner().unwrap_or_else(PoisonError::into_inner);
        // The time of a failed stage counts, too.
        state.end();
        Seconds { keys, times: state.times }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The clock of a part of the work: see [`StageClock::part`].
pub(crate) struct PartClock<'a> {
    clock: StageClock,
    whole: &'a StageClock,
}

impl Deref for PartClock<'_> {
    type Target = StageClock;

    fn deref(&self) -> &StageClock {
        &self.clock
    }
}

impl Drop for PartClock<'_> {
    fn drop(&mut self) {
        self.clock.end();
        self.whole.add(&self.clock);
    }
}

impl Observer for StageClock {
    fn stage(&self, stage: Stage) {
        // Set before the line of the previous stage is printed: the progress display is redrawn
        // below that line.
        self.lines.progress().set_message(stage.to_string());
        self.end();
        self.state().current = Some((stage, Instant::now()));
    }

    fn search(&self, options: &StripifyOptions) -> Box<dyn Search + '_> {
        Box::new(SearchWatch::new(self.lines.progress(), self.budget, options))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_are_sums_of_stages_and_null_for_those_that_did_not_run() {
        let clock = StageClock { lines: Lines::new(true), budget: None, state: Mutex::default() };
        clock.observe(|observer| {
            [Stage::Prepare, Stage::Survey, Stage::Prove].map(|stage| observer.stage(stage))
        });
        for (stage, seconds) in [(Stage::Load, 1.0), (Stage::Encode, 2.0), (Stage::Write, 4.0)] {
            clock.add_seconds(stage, seconds);
        }
        // A part that fails is dropped with its last stage running.
        let file = clock.part();
        file.add_seconds(Stage::Write, 8.0);
        file.stage(Stage::ReadBack);
        drop(file);
        assert_eq!(clock.seconds(&[Stage::Write]), Some(12.0));
        assert!(clock.seconds(&[Stage::ReadBack]).is_some());
        assert_eq!(clock.seconds(&[Stage::Fit, Stage::Stripify]), None);
        let seconds = serde_json::to_value(clock.into_seconds(STRIP_SECONDS)).unwrap();
        let keys: Vec<_> = seconds.as_object().unwrap().keys().collect();
        assert_eq!(keys, ["load", "dual", "stripify", "verify", "write"]);
        assert_eq!((seconds["load"].as_f64(), seconds["write"].as_f64()), (Some(1.0), Some(14.0)));
        assert!(
            seconds["dual"].is_number() && seconds["verify"].is_number() && seconds["stripify"].is_null()
        );
    }
}
