//! Input files, output files, and the time that a stage takes.

use std::path::Path;
use std::time::Instant;

use tristrip_io::Model;
use tristrip_pipeline::text::counted;

use crate::console::Console;
use crate::failure::Failure;

/// Runs a stage and returns its result with the time in seconds.
pub(crate) fn timed<T>(stage: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = stage();
    (result, start.elapsed().as_secs_f64())
}

/// Reads a model; returns it with the time in seconds.
pub(crate) fn load(path: &Path, console: &Console) -> Result<(Model, f64), Failure> {
    console.line(&path.display().to_string());
    let (model, seconds) = timed(|| tristrip_io::read_path(path));
    let model = model?;
    console.stage("load", &counted(model.parts.len(), "part"), Some(seconds));
    model.notes.iter().for_each(|note| console.note(note));
    Ok((model, seconds))
}

/// Returns the name of a file without its directory.
pub(crate) fn short_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Writes a text file.
pub(crate) fn write_text(path: &Path, contents: &str, stage: &str, console: &Console) -> Result<(), Failure> {
    tristrip_io::replace_file(path, contents.as_bytes())?;
    let bytes = tristrip_render::text::bytes(contents.len());
    console.stage(stage, &format!("{}, {bytes}", path.display()), None);
    Ok(())
}

/// Checks that a chart of this number of inputs can be written to this file.
pub(crate) fn check_chart(flag: &str, path: &Path, input_count: usize) -> Result<(), Failure> {
    /// The maximum number of inputs in a chart. The curves of more inputs are hard to distinguish.
    const MAX_PLOTTED_INPUTS: usize = 3;
    if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("svg")) {
        let path = path.display();
        return Err(Failure::Usage(format!("{path}: {flag} writes SVG; use the extension .svg")));
    }
    if input_count > MAX_PLOTTED_INPUTS {
        return Err(Failure::Usage(format!("{flag} takes at most {MAX_PLOTTED_INPUTS} inputs")));
    }
    Ok(())
}
