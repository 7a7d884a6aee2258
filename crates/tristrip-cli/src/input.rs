//! Reads inputs: files and standard input.

use std::io::Read;
use std::path::Path;

use tristrip_io::{Format, Model};

use crate::failure::Failure;
use crate::job::Input;

/// Reads an input in the requested format. The default is the format of the extension, or else of
/// the content.
pub(crate) fn load(input: &Input) -> Result<Model, Failure> {
    let name = input.name();
    let failure = |error| Failure::reading(&name, &error);
    match (&input.path, input.format) {
        (Some(path), format) => Ok(tristrip_io::read_file(path, format).map_err(failure)?.model),
        (None, format) => {
            let mut bytes = Vec::new();
            std::io::stdin().lock().read_to_end(&mut bytes).map_err(|source| {
                Failure::reading(&name, &tristrip_io::Error::Io { path: name.clone(), source })
            })?;
            let format = format.unwrap_or_else(|| Format::from_bytes(&bytes));
            tristrip_io::read(&bytes, format).map_err(failure)
        }
    }
}

/// Returns the size of an input in bytes. Returns `None` for standard input and for a `.gltf`,
/// whose buffers may be in other files.
pub(crate) fn file_bytes(input: &Input) -> Option<u64> {
    let path = input.path.as_ref().filter(|path| Format::from_path(path) != Some(Format::Gltf))?;
    Some(std::fs::metadata(path).ok()?.len())
}

/// Returns a file name without its directories, for the legend of a chart.
pub(crate) fn short_name(file: &str) -> String {
    Path::new(file).file_name().map_or_else(|| file.to_owned(), |name| name.to_string_lossy().into_owned())
}
