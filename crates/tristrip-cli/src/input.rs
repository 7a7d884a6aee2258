//! Reading inputs: files, and standard input.

use std::io::Read;
use std::path::Path;

use tristrip::{Mesh, Options};
use tristrip_io::{Format, Model};

use crate::failure::Failure;
use crate::task::Input;

/// Reads an input in the requested format, else in the format of its extension, else of its content.
pub(crate) fn load(input: &Input) -> Result<Model, Failure> {
    let name = input.name();
    let failure = |error| Failure::reading(&name, &error);
    match (&input.path, input.format) {
        (Some(path), None) => tristrip_io::read_path(path).map_err(failure),
        (Some(path), Some(format)) if Format::from_path(path) == Some(format) => {
            tristrip_io::read_path(path).map_err(failure)
        }
        (Some(path), Some(format)) => {
            let bytes = std::fs::read(path).map_err(|source| {
                Failure::reading(&name, &tristrip_io::Error::Io { path: name.clone(), source })
            })?;
            tristrip_io::read(&bytes, format).map_err(failure)
        }
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

/// Returns the options adapted to a model: welding is disabled, with a note, if vertices may differ in values that were not read.
pub(crate) fn fitted(options: Options, model: &mut Model) -> Options {
    if options.weld() && tristrip_io::gltf::has_unread_vertex_values(model) {
        let why = "vertices may differ in morph targets or in attributes that were not decoded";
        model.notes.push(format!("not welded: {why}"));
        return options.with_weld(false);
    }
    options
}

/// Returns a file name without its directories, for charts.
pub(crate) fn short_name(file: &str) -> String {
    Path::new(file).file_name().map_or_else(|| file.to_owned(), |name| name.to_string_lossy().into_owned())
}

/// Returns the meshes of a model's parts, in order.
pub(crate) fn meshes(model: &Model) -> Vec<&Mesh> {
    model.parts.iter().map(|part| &part.mesh).collect()
}
