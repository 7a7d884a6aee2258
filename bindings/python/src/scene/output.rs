//! Writes results to files and bytes, by the same rules as in the command.

use std::path::Path;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use tristrip::Layout;
use tristrip_io::Format;
use tristrip_pipeline::{Target, WRITTEN_FORMATS, WrittenFiles, encode, format_to_write, layout_to_write};

use crate::errors::Failure;
use crate::strips::layout_of;

/// An output destination and its layout.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Destination<'a> {
    pub(crate) target: Target<'a>,
    pub(crate) layout: Layout,
    /// Whether the user chose the layout.
    pub(crate) is_chosen: bool,
}

impl<'a> Destination<'a> {
    /// Selects a file. Without a format, the extension determines it.
    pub(crate) fn file(path: &'a Path, format: Option<&str>, layout: Option<&str>) -> Result<Self, Failure> {
        let format = format_to_write(path, format.map(written_format).transpose()?);
        Self::new(Some(path), format.map_err(|text| Failure::Parameter(in_arguments(&text)))?, layout)
    }

    /// Chooses bytes in memory.
    pub(crate) fn memory(format: &str, layout: Option<&str>) -> Result<Self, Failure> {
        let format = written_format(format)?;
        if format == Format::Gltf {
            let expected = "'glb', 'ply' or 'obj'; use `save` for .gltf, which is two files";
            return Err(Failure::option("format", "'gltf'", expected));
        }
        Self::new(None, format, layout)
    }

    fn new(path: Option<&'a Path>, format: Format, layout: Option<&str>) -> Result<Self, Failure> {
        let chosen = layout.map(layout_of).transpose()?;
        let target = Target::new(path, format);
        let layout = layout_to_write(target.format, chosen);
        let layout = layout.map_err(|text| Failure::Parameter(in_arguments(&text)))?;
        Ok(Self { target, layout, is_chosen: chosen.is_some() })
    }

    /// Writes a result. If verification fails, the error names the file.
    pub(crate) fn write(&self, encoded: &encode::Outcome) -> Result<WrittenFiles, Failure> {
        self.target.write(encoded).map_err(|error| self.unproven(error.into()))
    }

    /// Adds the file name to the error of a failed verification.
    pub(crate) fn unproven(&self, failure: Failure) -> Failure {
        match (failure, self.target.path) {
            (Failure::Unproven(why), Some(path)) => {
                Failure::Unproven(format!("{} was not written: {why}", path.display()))
            }
            (failure, _) => failure,
        }
    }
}

/// Parses the name of a format, with or without a leading dot.
pub(crate) fn format_of(name: &str) -> Result<Format, Failure> {
    let extension = name.strip_prefix('.').unwrap_or(name);
    let known = Format::ALL.into_iter().find(|format| extension.eq_ignore_ascii_case(format.extension()));
    known.ok_or_else(|| Failure::option("format", format!("{name:?}"), "obj, ply, off, stl, gltf or glb"))
}

fn written_format(name: &str) -> Result<Format, Failure> {
    let format = format_of(name)?;
    if WRITTEN_FORMATS.contains(&format) {
        return Ok(format);
    }
    Err(Failure::option("format", format!("{name:?}"), "an output format: glb, gltf, ply or obj"))
}

/// Rewrites a message about flags for keyword arguments.
fn in_arguments(text: &str) -> String {
    text.replace(", or --to", "").replace("--layout list", "layout \"list\"")
}

/// Builds the report on a written file, with the keys of the command's JSON.
pub(crate) fn file_report<'py>(
    py: Python<'py>,
    destination: &Destination<'_>,
    encoded: &encode::Outcome,
    written: &WrittenFiles,
    notes: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let found = PyDict::new(py);
    let path = destination.target.path.map(|path| path.display().to_string());
    found.set_item("output", path)?;
    found.set_item("proven", encoded.faces.map(|_| true))?;
    found.set_item("faces", encoded.faces)?;
    found.set_item("bytes", written.bytes)?;
    let beside: Vec<String> = written.beside.iter().map(|path| path.display().to_string()).collect();
    found.set_item("beside", beside)?;
    found.set_item("layout", destination.layout.name())?;
    let notes = notes.into_iter().chain(encoded.all_notes()).chain(written.warnings.iter().cloned());
    let notes: Vec<String> = notes.collect();
    found.set_item("notes", notes)?;
    Ok(found)
}
