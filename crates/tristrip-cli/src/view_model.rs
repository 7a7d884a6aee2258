//! Loads a model for views: one mesh, with its vertex tree over the strips of the full mesh.

use std::fs::File;
use std::sync::Arc;
use std::time::Duration;

use tristrip::lod::SkipStrips;
use tristrip::simplify::{MergeOrder, SimplifyOptions, merge_tree};
use tristrip::{CollapseSequence, Mesh, StripifyOptions, Strips};
use tristrip_io::tlod::{self, TlodLimits, TlodModel};
use tristrip_pipeline::text::counted;
use tristrip_pipeline::{Joined, PreparedModel, Search, Stopped, join};

use crate::console::Console;
use crate::failure::Failure;
use crate::job::Input;
use crate::search::SearchWatch;
use crate::stage::{load_timed, timed};

/// How a model of views is built.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ViewModelOptions {
    pub(crate) stripify: StripifyOptions,
    /// The time after which the search for strips is stopped.
    pub(crate) budget: Option<Duration>,
    /// Whether the strips of the full mesh are proven.
    pub(crate) verify: bool,
}

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
pub(crate) fn view_model(
    input: &Input,
    options: ViewModelOptions,
    console: &Console,
    building: &mut Building,
) -> Result<(Mesh, Arc<SkipStrips>), Failure> {
    console.doing("load");
    let (found, seconds) = timed(|| stored(input));
    if let Some(TlodModel { mesh, strips, sequence, .. }) = found? {
        building.load = Some(seconds);
        let what = format!("{}, {}", of_mesh(&mesh), counted(sequence.len(), "collapse"));
        console.stage("load", &what, building.load);
        return build(mesh, &strips, &sequence, console, building);
    }
    let (model, seconds) = load_timed(input, console)?;
    building.load = Some(seconds);
    let Joined { mesh, notes, .. } = join(model)?;
    building.notes = notes;
    console.stage("load", &of_mesh(&mesh), building.load);
    building.notes.iter().for_each(|note| console.note(note));

    console.doing("stripify");
    let watch = SearchWatch::new(console.progress(), options.budget, &options.stripify);
    let (strips, seconds) = timed(|| {
        let prepared = PreparedModel::of_meshes(&[&mesh], options.stripify.weld());
        let strips = prepared.find_strips(&options.stripify, &watch)?;
        if options.verify {
            prepared.prove(&strips)?;
        }
        Ok::<_, tristrip_pipeline::Error>(strips)
    });
    let strips = strips?.pop().unwrap_or_default();
    building.stripify = Some(seconds);
    console.stage(
        "stripify",
        &format!("{} of the full mesh", counted(strips.len(), "strip")),
        building.stripify,
    );
    building.stopped = watch.stopped();
    drop(watch);
    if let Some(stopped) = building.stopped {
        console.note(stopped.note());
        building.notes.push(stopped.note().into());
    }

    console.doing("simplify");
    let (tree, seconds) =
        timed(|| merge_tree(&mesh, strips.to_list(), MergeOrder::Quadric, &SimplifyOptions::default()));
    let tree = tree?;
    building.simplify = Some(seconds);
    let what = format!(
        "{} in {}",
        counted(tree.sequence.len(), "collapse"),
        counted(tree.level_ends.len(), "level")
    );
    console.stage("simplify", &what, building.simplify);

    build(mesh, &strips, &tree.sequence, console, building)
}

/// Counts the faces and vertices of a mesh as text.
fn of_mesh(mesh: &Mesh) -> String {
    let [faces, vertices] = [mesh.faces().face_count(), mesh.vertex_count()];
    format!("{}, {}", counted(faces, "face"), counted(vertices, "vertex"))
}

/// Builds the vertex tree.
fn build(
    mesh: Mesh,
    strips: &Strips,
    sequence: &CollapseSequence,
    console: &Console,
    building: &mut Building,
) -> Result<(Mesh, Arc<SkipStrips>), Failure> {
    console.doing("vertex tree");
    let (model, seconds) = timed(|| SkipStrips::new(strips, sequence, mesh.positions()));
    let model = Arc::new(model?);
    building.build = Some(seconds);
    let base = counted(model.levels().triangle_count(0)?, "triangle");
    console.stage("build", &format!("vertex tree over a base mesh of {base}"), building.build);
    Ok((mesh, model))
}

/// Reads a model that `build-lod` wrote, if the input is a file with this extension. Reading checks that its strips draw the triangles of its collapses.
fn stored(input: &Input) -> Result<Option<TlodModel>, Failure> {
    let Some(path) = input.path.as_ref().filter(|_| input.is_tlod()) else { return Ok(None) };
    let file = File::open(path)
        .map_err(|source| tristrip_io::Error::Io { path: path.display().to_string(), source });
    let model = file.and_then(|file| tlod::read(file, &TlodLimits::default()));
    model.map(Some).map_err(|error| Failure::reading(&input.name(), &error))
}
