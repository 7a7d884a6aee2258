//! Writes results. The bytes are read back and verified before a file is replaced.

use tristrip_pipeline::text::counted;
use tristrip_pipeline::{Error, Observer, Stage, encode};
use tristrip_render::text;

use crate::clock::StageClock;
use crate::console::Console;
use crate::failure::Failure;
use crate::job::Output;
use crate::reorder;

/// Encodes a result for an output; the clock measures the stages.
///
/// # Errors
/// The result cannot be encoded or fails verification; the error names the output.
pub(crate) fn encode<R>(
    output: &Output,
    clock: &StageClock,
    encode: impl FnOnce(&dyn Observer) -> Result<R, Error>,
) -> Result<R, Failure> {
    clock.observe(encode).map_err(|error| not_written(output, error))
}

/// Writes an encoded result to its output, prints what was verified and written, and adds its notes
/// and warnings to `notes`. `how` states how the parts are drawn; `clock` is the clock that
/// measured the encoding. Returns the size of the files in bytes.
pub(crate) fn write(
    output: &Output,
    how: &str,
    encoded: &encode::Outcome,
    notes: &mut Vec<String>,
    clock: &StageClock,
    console: &mut Console,
) -> Result<usize, Failure> {
    if let Some(groups) = &encoded.groups {
        console.stage("reorder", &reorder::line(groups), clock.seconds(&[Stage::Reorder]));
    }
    if let Some(faces) = encoded.faces {
        let what = format!("proven: the file draws exactly {}", counted(faces, "face"));
        console.stage("verify", &what, clock.seconds(&[Stage::ReadBack]));
    }
    let size = clock.timed(Stage::Write, || write_files(output, encoded, notes, console))?;
    if output.path.is_some() {
        let what = format!("{}, {}, {how}", output.name(), text::bytes(size));
        console.stage("write", &what, clock.seconds(&[Stage::Reorder, Stage::Encode, Stage::Write]));
    }
    encoded.notes.iter().for_each(|note| console.note(note));
    encoded.warnings.iter().for_each(|warning| console.warning(&output.name(), warning));
    notes.extend(encoded.all_notes());
    Ok(size)
}

/// Returns how the parts of a file are drawn, as text.
pub(crate) fn drawn_as(output: &Output, any_strips: bool) -> &'static str {
    if any_strips { output.layout.name() } else { "faces" }
}

/// Names the output in the error of a result that fails verification.
fn not_written(output: &Output, error: Error) -> Failure {
    match error {
        Error::Unproven { why, metrics, .. } => {
            Failure::Unproven { why: format!("{} was not written: {why}", output.name()), metrics }
        }
        other => other.into(),
    }
}

/// Writes the file and its side files, or the document and the buffer of a `.gltf`. Adds warnings
/// to `notes`. Returns the size in bytes.
fn write_files(
    output: &Output,
    encoded: &encode::Outcome,
    notes: &mut Vec<String>,
    console: &mut Console,
) -> Result<usize, Failure> {
    if output.path.is_none() {
        console.write_stdout(&encoded.bytes);
        return Ok(encoded.bytes.len());
    }
    let written = output.target().write(encoded).map_err(|error| not_written(output, error))?;
    written.warnings.iter().for_each(|warning| console.warning(&output.name(), warning));
    notes.extend(written.warnings);
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
    use tristrip_pipeline::encode;

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
        let mut write = |strips: &Strips| {
            let (drawings, options) = ([Drawing::Strips(strips)], encode::Options::new(Format::Ply));
            let clock = StageClock::new(&console, None);
            let encoded =
                encode(&output, &clock, |observer| encode::run(&model, &drawings, &options, observer))?;
            write(&output, "restart", &encoded, &mut Vec::new(), &clock, &mut console)
        };
        let Err(Failure::Unproven { why, .. }) = write(&strips) else { panic!("half a square was written") };
        assert!(why.contains("square.ply was not written: triangles missing: 1, extra: 0"), "{why}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        strips.push(&[2, 3, 0]);
        assert!(write(&strips).is_ok());
        assert!(fs::read(&path).unwrap().starts_with(b"ply"));
    }
}
