//! Writes results. The bytes are read back and verified before a file is replaced.

use std::fs;

use tristrip::Layout;
use tristrip::verify::verify_models;
use tristrip_io::{Drawing, Model};

use crate::console::Console;
use crate::failure::Failure;
use crate::input::meshes;
use crate::stages::timed;
use crate::task::Output;
use crate::text::{self, counted};
use crate::values::layout_name;

/// The outcome of a write.
pub(crate) struct Written {
    /// Notes on what the format cannot store.
    pub(crate) losses: Vec<String>,
    /// The time to verify the bytes.
    pub(crate) verify_seconds: Option<f64>,
    /// The time to lay out and write the bytes.
    pub(crate) write_seconds: f64,
}

impl Written {
    /// Adds the times and notes to those of a report.
    pub(crate) fn record(self, write: &mut Option<f64>, verify: &mut Option<f64>, notes: &mut Vec<String>) {
        *write = Some(self.write_seconds);
        if let Some(seconds) = self.verify_seconds {
            *verify = Some(verify.unwrap_or(0.0) + seconds);
        }
        notes.extend(self.losses);
    }
}

/// A model, how each part is drawn, and the layout of the strips.
#[derive(Clone, Copy)]
pub(crate) struct ModelDrawing<'a> {
    pub(crate) model: &'a Model,
    pub(crate) drawings: &'a [Drawing<'a>],
    pub(crate) layout: Layout,
}

/// Writes a model: lays out its strips, proves that the bytes draw the source if `verify` is set, and writes them to the output.
pub(crate) fn write(
    output: &Output,
    source: &Model,
    ModelDrawing { model, drawings, layout }: ModelDrawing<'_>,
    verify: bool,
    console: &mut Console,
) -> Result<Written, Failure> {
    console.doing("write");
    let (encoded, encode_seconds) = timed(|| tristrip_io::write(model, drawings, output.format, layout));
    let bytes = encoded.map_err(|error| Failure::writing(&error))?;
    let mut verify_seconds = None;
    if verify {
        console.doing("verify");
        let (proof, seconds) = timed(|| prove(output, source, &bytes));
        let what = format!("proven: the file draws the {}", counted(proof?, "face"));
        console.stage("verify", &what, Some(seconds));
        verify_seconds = Some(seconds);
    }
    let (written, bytes_seconds) = timed(|| write_bytes(output, &bytes, console));
    written?;
    let write_seconds = encode_seconds + bytes_seconds;
    if output.path.is_some() {
        let strips = drawings.iter().any(|drawing| matches!(drawing, Drawing::Strips(_)));
        let how = if strips { layout_name(output.layout) } else { "faces" };
        let what = format!("{}, {}, {how}", output.name(), text::bytes(bytes.len()));
        console.stage("write", &what, Some(write_seconds));
    }
    let losses = tristrip_io::losses(model, drawings, output.format);
    losses.iter().for_each(|loss| console.note(loss));
    Ok(Written { losses, verify_seconds, write_seconds })
}

/// Reads the bytes back, proves that they draw the source, and returns the number of faces.
fn prove(output: &Output, source: &Model, bytes: &[u8]) -> Result<usize, Failure> {
    let unproven = |why: String| Failure::Unproven(format!("{} was not written: {why}", output.name()));
    let again = tristrip_io::read(bytes, output.format).map_err(|error| unproven(error.to_string()))?;
    match verify_models(&meshes(source), &meshes(&again))? {
        Ok(proof) => Ok(proof.faces),
        Err(difference) => Err(unproven(difference.to_string())),
    }
}

fn write_bytes(output: &Output, bytes: &[u8], console: &mut Console) -> Result<(), Failure> {
    let Some(path) = &output.path else {
        console.write_stdout(bytes);
        return Ok(());
    };
    if let Some(directory) = path.parent().filter(|directory| output.in_directory && !directory.exists()) {
        // Create only the directory itself: a missing parent is more likely a typing error.
        fs::create_dir(directory).map_err(|error| Failure::system(directory, &error))?;
    }
    tristrip_io::replace_file(path, bytes).map_err(|error| Failure::writing(&error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::task::Shared;
    use tristrip::Strips;
    use tristrip_io::Format;

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
            layout: Layout::Restart,
        };
        let mut strips = Strips::default();
        strips.push(&[1, 2, 0]);
        let mut write = |strips: &Strips, verify| {
            let drawings = [Drawing::Strips(strips)];
            let drawing = ModelDrawing { model: &model, drawings: &drawings, layout: output.layout };
            write(&output, &model, drawing, verify, &mut console).map(drop)
        };
        let Err(Failure::Unproven(why)) = write(&strips, true) else { panic!("half a square was written") };
        assert!(why.contains("square.ply was not written: triangles missing: 1, extra: 0"), "{why}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        strips.push(&[2, 3, 0]);
        assert!(write(&strips, true).is_ok());
        assert!(fs::read(&path).unwrap().starts_with(b"ply"));
    }
}
