//! `tristrip verify`: proves that a file from any source draws exactly the faces of another.

use serde::Serialize;
use tristrip::verify::Difference;
use tristrip_pipeline::text::counted;
use tristrip_pipeline::{DifferenceReport, verify};

use crate::console::Console;
use crate::failure::Failure;
use crate::stage::{Seconds, load_timed, timed};
use crate::task::VerifyTask;

/// The report; the keys are those of the JSON output.
#[derive(Debug, Serialize)]
struct VerifyReport {
    source: String,
    result: String,
    /// `null` if a file could not be read.
    proven: Option<bool>,
    seconds: Seconds,
    /// The faces of the source.
    faces: Option<usize>,
    /// The triangles of the result.
    triangles: Option<usize>,
    difference: Option<DifferenceReport>,
    notes: Vec<String>,
    error: Option<String>,
}

/// Compares both files; returns whether the result is proven.
pub(crate) fn run(task: &VerifyTask, console: &mut Console) -> bool {
    let mut report = VerifyReport {
        source: task.source.name(),
        result: task.result.name(),
        proven: None,
        seconds: Seconds::default(),
        faces: None,
        triangles: None,
        difference: None,
        notes: Vec::new(),
        error: None,
    };
    console.begin(&format!("{} against {}", report.result, report.source), None);
    let compared = compare(task, console, &mut report);
    console.end();
    match compared {
        Ok(Ok(faces)) => {
            report.proven = Some(true);
            let faces = counted(faces, "face");
            let (source, result) = (&report.source, &report.result);
            let verdict = format!(
                "proven: {result} draws exactly the {faces} of {source}, each once, with its winding\n"
            );
            console.result(&verdict, false);
        }
        Ok(Err(difference)) => {
            report.proven = Some(false);
            report.difference = Some(DifferenceReport::of(&difference));
            console.error(&format!("{}: not proven: {difference}", report.result));
        }
        Err(failure) => {
            console.error(&failure);
            report.error = Some(failure);
        }
    }
    let proven = report.proven == Some(true);
    console.json(&[report], false);
    proven
}

/// Reads both files and compares them. Returns the number of faces proven, or the difference.
///
/// # Errors
/// A file could not be read or used.
fn compare(
    task: &VerifyTask,
    console: &Console,
    report: &mut VerifyReport,
) -> Result<Result<usize, Difference>, String> {
    let named = |name: String| move |failure: Failure| format!("{name}: {failure}");
    let (source, source_seconds) = load_timed(&task.source, console).map_err(named(task.source.name()))?;
    let (result, result_seconds) = load_timed(&task.result, console).map_err(named(task.result.name()))?;
    report.seconds.load = Some(source_seconds + result_seconds);
    for (name, model, seconds) in
        [(&report.source, &source, source_seconds), (&report.result, &result, result_seconds)]
    {
        let faces: usize = model.parts.iter().map(|part| part.mesh.faces().face_count()).sum();
        let what = format!("{name}: {}, {}", counted(model.parts.len(), "part"), counted(faces, "face"));
        console.stage("load", &what, Some(seconds));
        let notes: Vec<String> = model.notes.iter().map(|note| format!("{name}: {note}")).collect();
        notes.iter().for_each(|note| console.note(note));
        report.notes.extend(notes);
    }
    console.doing("verify");
    let (verdict, seconds) = timed(|| verify(&source, &result));
    report.seconds.verify = Some(seconds);
    report.faces = Some(source.parts.iter().map(|part| part.mesh.faces().face_count()).sum());
    report.triangles = Some(result.parts.iter().map(|part| part.mesh.faces().triangle_count()).sum());
    let verdict = verdict.map_err(|error| error.to_string())?;
    let outcome = if verdict.is_ok() { "the same faces" } else { "not the same faces" };
    console.stage("verify", outcome, Some(seconds));
    Ok(verdict.map(|proof| proof.faces))
}
