//! Loads a model for views: one mesh, with its vertex tree over the strips of the full mesh.

use std::fs::File;
use std::sync::Arc;
use std::time::Duration;

use tristrip::Mesh;
use tristrip::lod::SkipStrips;
use tristrip_io::tlod::{self, TlodLimits, TlodModel};
use tristrip_pipeline::text::counted;
use tristrip_pipeline::{Event, Stopped, ViewModel, ViewModelOptions, view_model};

use crate::console::Console;
use crate::failure::Failure;
use crate::job::Input;
use crate::stage::{Stages, load_timed, show_search, timed};

/// The times of the stages in seconds, and what is to be said.
#[derive(Debug, Default)]
pub(crate) struct Building {
    pub(crate) load: Option<f64>,
    pub(crate) stripify: Option<f64>,
    pub(crate) simplify: Option<f64>,
    pub(crate) build: Option<f64>,
    pub(crate) stopped: Option<Stopped>,
    pub(crate) notes: Vec<String>,
}

/// Loads an input as one mesh, and builds its model of views. A `.tlod` file has strips and collapses of its own.
pub(crate) fn load_view_model(
    input: &Input,
    options: &ViewModelOptions,
    budget: Option<Duration>,
    console: &Console,
    building: &mut Building,
) -> Result<(ViewModel, Arc<SkipStrips>), Failure> {
    console.doing("load");
    let (found, seconds) = timed(|| stored(input));
    let model = match found? {
        Some(model) => {
            building.load = Some(seconds);
            let what = format!("{}, {}", of_mesh(&model.mesh), counted(model.sequence.len(), "collapse"));
            console.stage("load", &what, building.load);
            model.into()
        }
        None => built(input, options, budget, console, building)?,
    };
    console.doing("vertex tree");
    let (tree, seconds) = timed(|| model.vertex_tree());
    let tree = Arc::new(tree?);
    building.build = Some(seconds);
    let base = counted(tree.levels().triangle_count(0)?, "triangle");
    console.stage("build", &format!("vertex tree over a base mesh of {base}"), building.build);
    Ok((model, tree))
}

/// Loads a mesh, and builds its strips and collapses.
fn built(
    input: &Input,
    options: &ViewModelOptions,
    budget: Option<Duration>,
    console: &Console,
    building: &mut Building,
) -> Result<ViewModel, Failure> {
    let (model, load) = load_timed(input, console)?;
    building.load = Some(load);
    let show = |event: Event<'_>, seconds: f64| match event {
        Event::Surveyed { notes, .. } => building.notes = notes.to_vec(),
        Event::Stripified { strips, stopped } => {
            (building.stripify, building.stopped) = (Some(seconds), stopped);
            let what = format!("{} of the full mesh", counted(strips, "strip"));
            show_search(&what, seconds, stopped, console, &mut building.notes);
        }
        Event::Merged { collapses, levels } => {
            building.simplify = Some(seconds);
            let what = format!("{} in {}", counted(collapses, "collapse"), counted(levels, "level"));
            console.stage("simplify", &what, Some(seconds));
        }
        _ => (),
    };
    let stages = Stages::new(console, load, show).with_budget(budget);
    Ok(view_model(model, options, &stages)?)
}

/// Counts the faces and vertices of a mesh as text.
fn of_mesh(mesh: &Mesh) -> String {
    let [faces, vertices] = [mesh.faces().face_count(), mesh.vertex_count()];
    format!("{}, {}", counted(faces, "face"), counted(vertices, "vertex"))
}

/// Reads a model that `build-lod` wrote, if the input is a file with this extension. Reading checks that its strips draw the triangles of its collapses.
fn stored(input: &Input) -> Result<Option<TlodModel>, Failure> {
    let Some(path) = input.path.as_ref().filter(|_| input.is_tlod()) else { return Ok(None) };
    let file = File::open(path)
        .map_err(|source| tristrip_io::Error::Io { path: path.display().to_string(), source });
    let model = file.and_then(|file| tlod::read(file, &TlodLimits::default()));
    model.map(Some).map_err(|error| Failure::reading(&input.name(), &error))
}
