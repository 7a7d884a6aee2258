//! `tristrip verify`: proves that a file from any source draws exactly the faces of another.

use serde::Serialize;
use tristrip::strip::{Difference, verify_models};

use crate::console::Console;
use crate::failure::Failure;
use crate::input::{load, meshes};
use crate::stages::{Seconds, timed};
use crate::task::VerifyTask;
use crate::text::counted;

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

/// How a result differs from its source.
#[derive(Debug, Default, Serialize)]
struct DifferenceReport {
    /// `triangles`, `outside`, `count` or `boundary`.
    kind: &'static str,
    missing: Option<usize>,
    extra: Option<usize>,
    flipped: Option<usize>,
    /// The face of the source, counted from 0 over all parts.
    face: Option<u32>,
    /// The positions of the first difference.
    first: Vec<[f32; 3]>,
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
    console.doing("load");
    let named = |name: String| move |failure: Failure| format!("{name}: {failure}");
    let (source, source_seconds) = timed(|| load(&task.source).map_err(named(task.source.name())));
    let source = source?;
    let (result, result_seconds) = timed(|| load(&task.result).map_err(named(task.result.name())));
    let result = result?;
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
    let (verdict, seconds) = timed(|| verify_models(&meshes(&source), &meshes(&result)));
    report.seconds.verify = Some(seconds);
    report.faces = Some(source.parts.iter().map(|part| part.mesh.faces().face_count()).sum());
    report.triangles = Some(result.parts.iter().map(|part| part.mesh.faces().triangle_count()).sum());
    let verdict = verdict.map_err(|error| error.to_string())?;
    let outcome = if verdict.is_ok() { "the same faces" } else { "not the same faces" };
    console.stage("verify", outcome, Some(seconds));
    Ok(verdict.map(|proof| proof.faces))
}

impl DifferenceReport {
    fn of(difference: &Difference) -> Self {
        match *difference {
            Difference::Triangles { missing, extra, flipped, first } => Self {
                kind: "triangles",
                missing: Some(missing),
                extra: Some(extra),
                flipped: Some(flipped),
                first: first.to_vec(),
                ..Self::default()
            },
            Difference::Outside { triangle } => {
                Self { kind: "outside", first: triangle.to_vec(), ..Self::default() }
            }
            Difference::Count { face, position, found, expected } => Self {
                kind: "count",
                missing: Some(expected.saturating_sub(found)),
                extra: Some(found.saturating_sub(expected)),
                face: Some(face),
                first: vec![position],
                ..Self::default()
            },
            Difference::Boundary { face, edge } => {
                Self { kind: "boundary", face: Some(face), first: edge.to_vec(), ..Self::default() }
            }
            _ => Self { kind: "other", ..Self::default() },
        }
    }
}
