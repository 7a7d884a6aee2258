//! `tristrip verify`: verifies that a file draws exactly the faces of another.

use serde::Serialize;
use tristrip_io::Model;
use tristrip_pipeline::text::counted;
use tristrip_pipeline::{Stage, verify};

use crate::clock::{Seconds, SecondsKeys, StageClock};
use crate::console::Console;
use crate::input::load;
use crate::job::Input;
use crate::stage::show_loaded;
use crate::task::VerifyTask;

/// The keys of `seconds`.
pub(crate) const SECONDS: SecondsKeys = &[("load", &[Stage::Load]), ("verify", &[Stage::Prove])];

/// The report on both files. The field names are the keys of the JSON output.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Verified {
    /// The source as given; `-` for standard input.
    source: String,
    /// The result as given; `-` for standard input.
    result: String,
    /// The time per stage, in seconds.
    seconds: Seconds,
    #[serde(flatten)]
    #[cfg_attr(feature = "schema", schemars(with = "verify::Outcome"))]
    outcome: Option<verify::Outcome>,
    /// Human-readable notes of the reader on both files.
    notes: Vec<String>,
    /// Why the files were not compared; `null` if they were.
    error: Option<String>,
}

/// Compares both files; returns whether the result is verified.
pub(crate) fn run(task: &VerifyTask, console: &mut Console) -> bool {
    let (source, result) = (task.source.name(), task.result.name());
    console.begin(&format!("{result} against {source}"), None);
    let clock = StageClock::new(console, None);
    let mut notes = Vec::new();
    let compared = compare(task, console, &clock, &mut notes);
    console.end();
    let (outcome, error) = match compared {
        Ok(outcome) => (Some(outcome), None),
        Err(error) => (None, Some(error)),
    };
    if let Some(error) = &error {
        console.error(error);
    }
    if let Some(outcome) = &outcome {
        if let Some(difference) = &outcome.difference {
            console.error(&format!("{result}: not proven: {}", difference.text));
        } else {
            let faces = counted(outcome.faces, "face");
            let verdict = format!(
                "proven: {result} draws every face of {source} exactly once, with its original winding ({faces})\n"
            );
            console.result(&verdict, false);
        }
    }
    let proven = outcome.as_ref().is_some_and(|outcome| outcome.proven);
    let seconds = clock.into_seconds(SECONDS);
    console.json(&[Verified { source, result, seconds, outcome, notes, error }], false);
    proven
}

/// Reads both files and compares them.
///
/// # Errors
/// A file cannot be read or used.
fn compare(
    task: &VerifyTask,
    console: &Console,
    clock: &StageClock,
    notes: &mut Vec<String>,
) -> Result<verify::Outcome, String> {
    let source = load_named(&task.source, console, clock)?;
    let result = load_named(&task.result, console, clock)?;
    for (input, model) in [(&task.source, &source), (&task.result, &result)] {
        notes.extend(model.notes.iter().map(|note| format!("{}: {note}", input.name())));
    }
    let outcome = clock.observe(|observer| verify::run(&source, &result, observer));
    let outcome = outcome.map_err(|error| error.to_string())?;
    let verdict = if outcome.proven { "the same faces" } else { "not the same faces" };
    console.stage("verify", verdict, clock.seconds(&[Stage::Prove]));
    Ok(outcome)
}

/// Reads a file; prints its parts, faces and notes after its name.
fn load_named(input: &Input, console: &Console, clock: &StageClock) -> Result<Model, String> {
    let (name, loading) = (input.name(), clock.part());
    let loaded = loading.timed(Stage::Load, || load(input));
    let model = loaded.map_err(|failure| format!("{name}: {failure}"))?;
    show_loaded(&model, &format!("{name}: "), console, &loading);
    Ok(model)
}
