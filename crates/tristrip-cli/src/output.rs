//! Writing results: the bytes are proven by reading them again before they reach a file.

use std::fs;

use tristrip::Layout;
use tristrip::strip::verify_models;
use tristrip_io::{Drawing, Model};

use crate::console::Console;
use crate::failure::Failure;
use crate::input::meshes;
use crate::stages::timed;
use crate::task::{Output, layout_name};
use crate::text::{self, counted};

/// What was written.
pub(crate) struct Written {
    /// What the format could not hold.
    pub(crate) losses: Vec<String>,
    /// Time to prove what a reader will see.
    pub(crate) verify_seconds: Option<f64>,
    /// Time to lay out and write the bytes.
    pub(crate) write_seconds: f64,
}

/// What is to be written.
#[derive(Clone, Copy)]
pub(crate) struct Drawn<'a> {
    pub(crate) model: &'a Model,
    pub(crate) drawings: &'a [Drawing<'a>],
    pub(crate) layout: Layout,
}

/// Writes a model's drawings: lays them out, proves of the bytes that they draw the source, if asked to, and puts them into their place.
pub(crate) fn write(
    output: &Output,
    source: &Model,
    Drawn { model, drawings, layout }: Drawn<'_>,
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
        let what = format!("proven: read again, it draws the {}", counted(proof?, "face"));
        console.stage("verify", &what, Some(seconds));
        verify_seconds = Some(seconds);
    }
    let (put, put_seconds) = timed(|| put(output, &bytes, console));
    put?;
    let write_seconds = encode_seconds + put_seconds;
    if output.path.is_some() {
        let strips = drawings.iter().any(|drawing| matches!(drawing, Drawing::Strips(_)));
        let how = if strips { layout_name(output.layout) } else { "faces" };
        let what = format!("{}, {}, {how}", output.name(), text::bytes(bytes.len()));
        console.stage("write", &what, Some(write_seconds));
    }
    let losses = tristrip_io::losses(model, output.format);
    losses.iter().for_each(|loss| console.note(loss));
    Ok(Written { losses, verify_seconds, write_seconds })
}

/// Reads the bytes as anyone would, and holds what they draw to the source; gives the number of faces.
fn prove(output: &Output, source: &Model, bytes: &[u8]) -> Result<usize, Failure> {
    let unproven = |why: String| Failure::Unproven(format!("{} was not written: {why}", output.name()));
    let again = tristrip_io::read(bytes, output.format).map_err(|error| unproven(error.to_string()))?;
    match verify_models(&meshes(source), &meshes(&again))? {
        Ok(proof) => Ok(proof.faces),
        Err(difference) => Err(unproven(difference.to_string())),
    }
}

fn put(output: &Output, bytes: &[u8], console: &mut Console) -> Result<(), Failure> {
    let Some(path) = &output.path else {
        console.write_stdout(bytes);
        return Ok(());
    };
    if let Some(directory) = path.parent().filter(|directory| output.in_directory && !directory.exists()) {
        // Only the directory that was named: a missing one above it is more likely a slip.
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
    fn what_is_not_proven_is_not_written() {
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
            let drawn = Drawn { model: &model, drawings: &drawings, layout: output.layout };
            write(&output, &model, drawn, verify, &mut console).map(drop)
        };
        let Err(Failure::Unproven(why)) = write(&strips, true) else { panic!("half a square was written") };
        assert!(why.contains("square.ply was not written: triangles missing: 1, extra: 0"), "{why}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        strips.push(&[2, 3, 0]);
        assert!(write(&strips, true).is_ok());
        assert!(fs::read(&path).unwrap().starts_with(b"ply"));
    }
}
