//! The first stages of an input: its model is loaded, and the mesh is shown.

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

/// Calls `work`, and returns its result and its time in seconds.
pub(crate) fn timed<R>(work: impl FnOnce() -> R) -> (R, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}

/// Loads an input, and returns it with the time in seconds.
pub(crate) fn load_timed(input: &Input, console: &Console) -> Result<(Model, f64), Failure> {
    console.doing("load");
    let (model, seconds) = timed(|| load(input));
    Ok((model?, seconds))
}

/// Loads the input of a job as [`load_timed`] does; a result in glTF gets the images that the input has in separate files. They stay
/// where they are for a `.gltf` in the folder of the input. A result with materials gets those of an OBJ and its libraries, and an OBJ those of glTF.
pub(crate) fn load_job(job: &Job, console: &Console) -> Result<(Model, f64), Failure> {
    let (mut model, seconds) = load_timed(&job.input, console)?;
    let Some(output) = &job.output else { return Ok((model, seconds)) };
    let (images, image_seconds) = timed(|| output.target().complete(&mut model, job.input.path.as_deref()));
    let images = images.map_err(|error| Failure::reading(&job.input.name(), &error))?;
    if let Some(first) = images.left.first() {
        let message = format!("images that the file only refers to: {}, such as {first}", images.left.len());
        console.warning(&job.input.name(), &message);
    }
    Ok((model, seconds + image_seconds))
}

/// Prints what was loaded and its notes: the first lines of operations that build or bound strips.
pub(crate) fn show_mesh(
    mesh: &MeshProperties,
    parts: usize,
    notes: &[String],
    clock: &StageClock,
    console: &Console,
) {
    let faces = counted(mesh.faces, "face");
    let size = format!("{faces}, {}", counted(mesh.vertices, "vertex"));
    console.stage("load", &size, clock.seconds(&[Stage::Load]));
    console.stage("mesh", &mesh_line(mesh, parts), clock.seconds(&[Stage::Survey]));
    notes.iter().for_each(|note| console.note(note));
    console.stage("dual", &format!("{faces} joined across shared edges"), clock.seconds(&[Stage::Prepare]));
}
