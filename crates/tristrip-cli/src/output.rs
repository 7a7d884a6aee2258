//! Writes results. The bytes are read back and verified before a file is replaced.

use std::time::Duration;

use tristrip_pipeline::text::counted;
use tristrip_pipeline::{Encoded, Error, Event, Observer};
use tristrip_render::text;

use crate::console::Console;
use crate::failure::Failure;
use crate::job::Output;
use crate::reorder::{self, GroupReport};
use crate::stage::{Stages, timed};

/// The fields of a report that a write fills in.
pub(crate) struct WriteReport<'a> {
    pub(crate) write: &'a mut Option<f64>,
    pub(crate) verify: &'a mut Option<f64>,
    pub(crate) notes: &'a mut Vec<String>,
    pub(crate) vertex_order: Option<&'a mut Option<Vec<GroupReport>>>,
}

/// The search for strips within a write.
pub(crate) struct SearchReport<'a> {
    /// The time after which the search is stopped.
    pub(crate) budget: Option<Duration>,
    /// The time of the search.
    pub(crate) stripify: &'a mut Option<f64>,
}

/// Writes a model: encodes it, which proves that the bytes draw the source unless the user did not want it, and writes them to the
/// output. `strips` states whether any part is drawn as strips.
pub(crate) fn write(
    output: &Output,
    strips: bool,
    console: &mut Console,
    report: WriteReport<'_>,
    encode: impl FnOnce(&dyn Observer) -> Result<Encoded, Error>,
) -> Result<(), Failure> {
    let search = SearchReport { budget: None, stripify: &mut None };
    write_searched(output, strips, console, report, search, encode).map(drop)
}

/// Does the same where the encoding searches for strips, and returns the size of the files in bytes. Times are added to those of the
/// report.
pub(crate) fn write_searched(
    output: &Output,
    strips: bool,
    console: &mut Console,
    report: WriteReport<'_>,
    search: SearchReport<'_>,
    encode: impl FnOnce(&dyn Observer) -> Result<Encoded, Error>,
) -> Result<usize, Failure> {
    let SearchReport { budget, stripify } = search;
    let WriteReport { write, verify, notes, mut vertex_order } = report;
    let mut write_seconds = 0.0;
    let show = |event: Event<'_>, seconds: f64| match event {
        Event::Reordered(groups) => {
            console.stage("reorder", &reorder::line(groups), Some(seconds));
            write_seconds += seconds;
            if let Some(order) = &mut vertex_order {
                **order = Some(groups.iter().map(GroupReport::of).collect());
            }
        }
        Event::Stripified { strips, .. } => {
            console.stage("stripify", &counted(strips, "strip"), Some(seconds));
            *stripify = Some(stripify.unwrap_or(0.0) + seconds);
        }
        Event::Encoded { .. } => write_seconds += seconds,
        Event::ReadBack { faces } => {
            let what = format!("proven: the file draws the {}", counted(faces, "face"));
            console.stage("verify", &what, Some(seconds));
            *verify = Some(verify.unwrap_or(0.0) + seconds);
        }
        Event::Note(note) => notes.push(note.into()),
        Event::Warning(warning) => {
            console.warning(&output.name(), warning);
            notes.push(warning.into());
        }
        _ => (),
    };
    let stages = Stages::new(console, 0.0, show).with_budget(budget);
    let encoded = encode(&stages).map_err(|error| not_written(output, error))?;
    let (written, bytes_seconds) = timed(|| write_files(output, &encoded, console));
    let size = written?;
    write_seconds += bytes_seconds;
    if output.path.is_some() {
        let how = if strips { output.layout.name() } else { "faces" };
        let what = format!("{}, {}, {how}", output.name(), text::bytes(size));
        console.stage("write", &what, Some(write_seconds));
    }
    encoded.losses.iter().for_each(|loss| console.note(loss));
    *write = Some(write.unwrap_or(0.0) + write_seconds);
    notes.extend(encoded.losses);
    Ok(size)
}

/// Names the output in the error of a result that is not proven.
fn not_written(output: &Output, error: Error) -> Failure {
    match error {
        Error::Unproven(why) => Failure::Unproven(format!("{} was not written: {why}", output.name())),
        other => other.into(),
    }
}

/// Writes the file with those beside it, or the document and the buffer of a `.gltf`; returns the size in bytes.
fn write_files(output: &Output, encoded: &Encoded, console: &mut Console) -> Result<usize, Failure> {
    if output.path.is_none() {
        console.write_stdout(&encoded.bytes);
        return Ok(encoded.bytes.len());
    }
    let written = output.target().write(encoded).map_err(|error| not_written(output, error))?;
    written.warnings.iter().for_each(|warning| console.warning(&output.name(), warning));
    written.beside.iter().for_each(|file| console.stage("write", &file.display().to_string(), None));
    Ok(written.bytes)
}

/// Writes the bytes of a single file.
pub(crate) fn write_file(output: &Output, bytes: &[u8], console: &mut Console) -> Result<(), Failure> {
    if let Some(path) = &output.path {
        return Ok(output.target().write_bytes(path, bytes)?);
    }
    console.write_stdout(bytes);
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::task::Shared;
    use tristrip::{Layout, Strips};
    use tristrip_io::{Drawing, Format};
    use tristrip_pipeline::{EncodeOptions, encode_observed};

    #[test]
    fn unproven_results_are_not_written() {
        let square = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";
        let model = tristrip_io::read(square, Format::Obj).unwrap();
        let mut console = Console::new(&Shared { json: false, quiet: true, threads: Some(1) }, false);
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("square.ply");
        fs::write(&path, "old").unwrap();
        let output = Output {
            path: Some(path.clone()),
            in_directory: false,
            format: Format::Ply,
            separate: false,
            layout: Layout::Restart,
        };
        let mut strips = Strips::default();
        strips.push(&[1, 2, 0]);
        let mut write = |strips: &Strips, verify| {
            let drawings = [Drawing::Strips(strips)];
            let options = EncodeOptions::new(Format::Ply).with_verify(verify);
            let (mut seconds, mut proof, mut notes) = (None, None, Vec::new());
            let report = WriteReport {
                write: &mut seconds,
                verify: &mut proof,
                notes: &mut notes,
                vertex_order: None,
            };
            write(&output, true, &mut console, report, |observer| {
                encode_observed(&model, &drawings, &options, observer)
            })
        };
        let Err(Failure::Unproven(why)) = write(&strips, true) else { panic!("half a square was written") };
        assert!(why.contains("square.ply was not written: triangles missing: 1, extra: 0"), "{why}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        strips.push(&[2, 3, 0]);
        assert!(write(&strips, true).is_ok());
        assert!(fs::read(&path).unwrap().starts_with(b"ply"));
    }
}
