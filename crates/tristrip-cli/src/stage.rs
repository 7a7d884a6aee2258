//! The first stages of an input: loads its model and reports its mesh.

use std::time::Instant;

use tristrip_io::Model;
use tristrip_pipeline::text::counted;
use tristrip_pipeline::{MeshProperties, Stage};

use crate::clock::StageClock;
use crate::console::Console;
use crate::failure::Failure;
use crate::figures::mesh_line;
use crate::input::load;
use crate::job::{Input, Job};

/// Calls `work`; returns its result and its time in seconds.
pub(crate) fn timed<R>(work: impl FnOnce() -> R) -> (R, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}

/// Loads an input; prints its parts and faces and the notes of the reader.
pub(crate) fn load_input(input: &Input, console: &Console, clock: &StageClock) -> Result<Model, Failure> {
    let model = clock.timed(Stage::Load, || load(input))?;
    show_loaded(&model, "", console, clock);
    Ok(model)
}

/// Loads the input of a job as [`load_input`] does, with the files that the output needs. A glTF
/// output gets the images that the input has in separate files, unless it is a `.gltf` in the
/// directory of the input: that one refers to them. An output with materials gets the materials of
/// an OBJ and its libraries, and an OBJ output gets the materials of a glTF input.
pub(crate) fn load_job(job: &Job, console: &Console, clock: &StageClock) -> Result<Model, Failure> {
    let Some(output) = &job.output else { return load_input(&job.input, console, clock) };
    let name = job.input.name();
    let (model, images) = clock.timed(Stage::Load, || {
        let mut model = load(&job.input)?;
        let images = output.target().complete(&mut model, job.input.path.as_deref());
        Ok::<_, Failure>((model, images.map_err(|error| Failure::reading(&name, &error))?))
    })?;
    show_loaded(&model, "", console, clock);
    if let Some(first) = images.left.first() {
        let message = format!("images not embedded: {}, such as {first}", images.left.len());
        console.warning(&name, &message);
    }
    Ok(model)
}

/// Prints the number of parts and faces of a model after a prefix, then the notes of the reader.
pub(crate) fn show_loaded(model: &Model, prefix: &str, console: &Console, clock: &StageClock) {
    let faces: usize = model.parts.iter().map(|part| part.mesh.faces().face_count()).sum();
    let what = format!("{prefix}{}, {}", counted(model.parts.len(), "part"), counted(faces, "face"));
    console.stage("load", &what, clock.seconds(&[Stage::Load]));
    model.notes.iter().for_each(|note| console.note(note));
}

/// Prints the counts of the mesh and the notes of an operation. The first `read` notes were printed
/// when the model was loaded.
pub(crate) fn show_mesh(mesh: &MeshProperties, notes: &[String], read: usize, console: &Console) {
    console.stage("mesh", &mesh_line(mesh), None);
    notes.iter().skip(read).for_each(|note| console.note(note));
}

/// Prints that strips are verified, or that verification was skipped.
pub(crate) fn show_proof(proven: bool, mesh: &MeshProperties, console: &Console) {
    if proven {
        let faces = counted(mesh.faces, "face");
        let what = format!("every face exactly once, with its original winding ({faces})");
        console.stage("proven", &what, None);
    } else {
        console.stage("verify", "skipped", None);
    }
}

/// Prints that collapses are verified, or that verification was skipped.
pub(crate) fn show_proof_of_collapses(proven: bool, console: &Console) {
    if proven {
        console.stage("proven", "replaying the collapses removes exactly these triangles", None);
    } else {
        console.stage("verify", "skipped", None);
    }
}
