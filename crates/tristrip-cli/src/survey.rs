//! The first stages of every subcommand that builds or bounds strips: load the model, prepare its faces, build the dual graphs, and
//! report on the mesh.

use tristrip::Options;
use tristrip_io::Model;

use crate::console::Console;
use crate::failure::Failure;
use crate::figures::MeshFigures;
use crate::input::{fitted, load, meshes};
use crate::stages::{Pool, Prepared, Seconds, prepare, timed};
use crate::task::Input;
use crate::text::counted;

/// A model, and the options adapted to it.
pub(crate) struct Loaded {
    pub(crate) model: Model,
    pub(crate) options: Options,
    seconds: f64,
}

/// The prepared parts of a model.
pub(crate) struct Surveyed<'a> {
    pub(crate) parts: Vec<Prepared<'a>>,
    pub(crate) mesh: MeshFigures,
    /// Notes on what was dropped, changed or unusual.
    pub(crate) notes: Vec<String>,
    /// The times of loading and of the dual graph.
    pub(crate) seconds: Seconds,
}

impl Loaded {
    /// Loads an input.
    pub(crate) fn new(input: &Input, options: Options, console: &Console) -> Result<Self, Failure> {
        console.doing("load");
        let (model, seconds) = timed(|| load(input));
        let mut model = model?;
        let options = fitted(options, &mut model);
        Ok(Self { model, options, seconds })
    }

    /// Prepares the parts, and reports on the mesh.
    pub(crate) fn survey(&self, pool: &Pool, console: &Console) -> Surveyed<'_> {
        console.doing("dual graph");
        let (parts, dual) = timed(|| prepare(pool, &meshes(&self.model), self.options.weld()));
        let (mesh, mesh_seconds) = timed(|| MeshFigures::of(pool, &parts));
        let faces = counted(mesh.faces, "face");
        let size = format!("{faces}, {}", counted(mesh.vertices, "vertex"));
        let notes = [&self.model.notes[..], &mesh.remarks()].concat();
        console.stage("load", &size, Some(self.seconds));
        console.stage("mesh", &mesh.line(parts.len()), Some(mesh_seconds));
        notes.iter().for_each(|note| console.note(note));
        console.stage("dual", &format!("{faces} joined across shared edges"), Some(dual));
        let seconds = Seconds { load: Some(self.seconds), dual: Some(dual), ..Seconds::default() };
        Surveyed { parts, mesh, notes, seconds }
    }
}
