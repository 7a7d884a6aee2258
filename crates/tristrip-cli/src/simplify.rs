//! `tristrip simplify`: reduces the number of triangles by half-edge collapses.
//!
//! ```text
//! load ─ prepare ─▶ triangles of each part ─ lock shared vertices ─ simplify ─▶ base meshes ─ prove ─ write ─ read back, prove
//! ```

mod parts;

use serde::Serialize;
use tristrip::mesh::Triangulation;
use tristrip::simplify::Simplification;
use tristrip::{Layout, Mesh, Options, Strips};
use tristrip_io::{Drawing, Format, Redrawn};

use crate::batch::{self, InputReport, Outcome};
use crate::console::Console;
use crate::failure::Failure;
use crate::figures::rounded;
use crate::input::meshes;
use crate::output::{self, ModelDrawing};
use crate::stages::{Pool, timed};
use crate::survey::{Loaded, Surveyed};
use crate::task::{Job, Output, SimplifyTask};
use crate::text::{count, counted, table};
pub(crate) use parts::{Compact, Part, diagonal, simplify_all};

/// The maximum number of parts with a note of their own on where they stopped.
const MAX_NAMED_PARTS: usize = 8;

/// The time of each stage in seconds; `null` for a stage that did not run.
#[derive(Debug, Clone, Copy, Default, Serialize)]
struct SimplifySeconds {
    load: Option<f64>,
    dual: Option<f64>,
    simplify: Option<f64>,
    verify: Option<f64>,
    write: Option<f64>,
}

/// The report of one input; the keys are those of the JSON output.
#[derive(Debug, Default, Serialize)]
struct SimplifyReport {
    file: String,
    proven: Option<bool>,
    seconds: SimplifySeconds,
    /// The requested number of triangles; `null` for no limit.
    target_triangles: Option<usize>,
    /// The maximum error in mesh units; `null` for no limit.
    target_error: Option<f32>,
    /// Whether each part has at most its target number of triangles.
    reached: Option<bool>,
    triangles_before: Option<usize>,
    triangles_after: Option<usize>,
    /// Used vertices.
    vertices_before: Option<usize>,
    vertices_after: Option<usize>,
    collapses: Option<usize>,
    /// The greatest error of a collapse, in mesh units.
    surface_error: Option<f32>,
    surface_error_percent: Option<f64>,
    /// The diagonal of the model's bounding box, in mesh units.
    diagonal: Option<f64>,
    locked_vertices: Option<usize>,
    parts: Option<usize>,
    notes: Vec<String>,
    output: Option<String>,
    error: Option<String>,
}

impl InputReport for SimplifyReport {
    fn outcome(&mut self) -> Outcome<'_> {
        Outcome { file: &self.file, proven: Some(&mut self.proven), error: &mut self.error }
    }
}

/// Simplifies all inputs in order; returns whether all succeeded.
pub(crate) fn run(task: &SimplifyTask, pool: &Pool, console: &mut Console) -> bool {
    let new_report = |job: &Job| SimplifyReport { file: job.input.name(), ..SimplifyReport::default() };
    let process = |job: &Job, console: &mut Console, report: &mut SimplifyReport| {
        simplify(job, task, pool, console, report)
    };
    let show = |job: &Job, report: &SimplifyReport, title: &str, console: &mut Console| {
        console.result(&format!("{title}{}", summary(report)), job.output.is_none());
    };
    let reports = batch::process_all(&task.jobs, None, console, new_report, process, show);
    batch::finish(reports, console)
}

fn simplify(
    job: &Job,
    task: &SimplifyTask,
    pool: &Pool,
    console: &mut Console,
    report: &mut SimplifyReport,
) -> Result<(), Failure> {
    // 1. The triangles of each part.
    let loaded = Loaded::new(&job.input, Options::default(), console)?;
    let surveyed = loaded.survey(pool, console);
    let (load, dual) = (surveyed.seconds.load, surveyed.seconds.dual);
    report.seconds = SimplifySeconds { load, dual, ..SimplifySeconds::default() };
    report.notes.clone_from(&surveyed.notes);
    report.parts = Some(surveyed.parts.len());
    let parts = fans(pool, &surveyed)?;
    let before: Vec<usize> = parts.iter().map(Part::triangle_count).collect();
    report.triangles_before = Some(before.iter().sum());
    report.vertices_before = Some(surveyed.mesh.vertices - surveyed.mesh.unreferenced_vertices);
    let diagonal = diagonal(&parts);
    report.diagonal = Some(diagonal);

    // 2. The collapses.
    let shares = task.goal.amount.map_or_else(|| vec![0; parts.len()], |amount| amount.shares(&before));
    let error = task.goal.deviation.map(|deviation| deviation.units(diagonal));
    report.target_triangles = task.goal.amount.map(|_| shares.iter().sum());
    report.target_error = error;
    console.doing("simplify");
    let (done, seconds) = timed(|| simplify_all(pool, &parts, &shares, error));
    let done = done?;
    report.seconds.simplify = Some(seconds);
    report.collapses = Some(done.iter().map(|done| done.sequence.len()).sum());
    report.triangles_after = Some(done.iter().map(|done| done.sequence.triangle_count(0)).sum());
    report.reached = Some(
        done.iter()
            .zip(&shares)
            .all(|(done, &share)| task.goal.amount.is_none() || done.sequence.triangle_count(0) <= share),
    );
    let reached = done.iter().map(|done| done.sequence.error(0)).fold(0.0, f32::max);
    report.surface_error = Some(reached);
    report.surface_error_percent = Some(percent_of(reached, diagonal));
    console.stage("simplify", &line(report), Some(seconds));
    let locked = parts.iter().map(Part::locked_count).sum();
    report.locked_vertices = Some(locked);
    let wanted = task.goal.amount.map(|_| &shares[..]);
    for note in locked_note(locked).into_iter().chain(ends(&done, wanted)) {
        console.note(&note);
        report.notes.push(note);
    }

    // 3. The proof of the collapses.
    if task.verify {
        console.doing("verify");
        let (proof, seconds) = timed(|| prove(pool, &done));
        proof?;
        report.seconds.verify = Some(seconds);
        report.proven = Some(true);
        let what = "proven: replaying the collapses removes exactly these triangles";
        console.stage("verify", what, Some(seconds));
    } else {
        console.stage("verify", "skipped", None);
    }

    // 4. The file.
    let base = |(part, done): (&Part<'_>, &Simplification)| {
        let mut corners = done.sequence.drawn(0).into_flattened();
        part.compact.outward(&mut corners);
        corners
    };
    let triangles = parts.iter().zip(&done).map(base).collect();
    let format = job.output.as_ref().map_or(Format::Ply, |output| output.format);
    let smaller = tristrip_io::with_triangles(&loaded.model, triangles, format);
    let smaller = smaller.map_err(|error| Failure::writing(&error))?;
    report.vertices_after = Some(smaller.used);
    let Some(target) = &job.output else { return Ok(()) };
    write(target, &smaller, task.verify, console, report)
}

/// Returns the triangles of all parts, polygons as fans around their first corner.
fn fans<'a>(pool: &Pool, surveyed: &Surveyed<'a>) -> Result<Vec<Part<'a>>, Failure> {
    let triangles =
        pool.map(&surveyed.parts, |part| Triangulation::fan(&part.surface, &part.graph).triangles().to_vec());
    let meshes = surveyed.parts.iter().map(|part| part.mesh);
    Ok(Part::of_all(meshes.zip(triangles).collect())?)
}

/// Replays the collapses of each part, and compares the triangles that they remove.
fn prove(pool: &Pool, done: &[Simplification]) -> Result<(), Failure> {
    let proofs = pool.map(done, |done| done.sequence.check());
    proofs.into_iter().collect::<Result<(), _>>().map_err(|why| Failure::Unproven(why.to_string()))
}

/// Writes the simplified model.
fn write(
    target: &Output,
    smaller: &Redrawn,
    verify: bool,
    console: &mut Console,
    report: &mut SimplifyReport,
) -> Result<(), Failure> {
    let in_scene = smaller.model.scene.is_some() && target.format == Format::Glb;
    if smaller.kept > 0 && in_scene {
        let kept = counted(smaller.kept, "unused vertex");
        let note = format!("kept {kept}: other parts of the scene may refer to them");
        console.note(&note);
        report.notes.push(note);
    }
    // When a scene is written, parts drawn as faces keep their old indices; one strip per triangle gives them new ones.
    let single_triangles: Vec<Strips> =
        meshes(&smaller.model).iter().filter(|_| in_scene).map(|mesh| one_strip_per_triangle(mesh)).collect();
    let drawings: Vec<Drawing<'_>> = if in_scene {
        single_triangles.iter().map(Drawing::Strips).collect()
    } else {
        smaller.model.parts.iter().map(|_| Drawing::Faces).collect()
    };
    let drawing = ModelDrawing { model: &smaller.model, drawings: &drawings, layout: Layout::List };
    let written = output::write(target, &smaller.model, drawing, verify, console)?;
    written.record(&mut report.seconds.write, &mut report.seconds.verify, &mut report.notes);
    report.output = Some(target.name());
    Ok(())
}

/// Builds one strip per triangle.
fn one_strip_per_triangle(mesh: &Mesh) -> Strips {
    let mut strips = Strips::default();
    mesh.faces().iter().for_each(|triangle| strips.push(triangle));
    strips
}

/// Returns a note on the number of locked vertices, if there are any.
pub(crate) fn locked_note(locked: usize) -> Option<String> {
    (locked > 0).then(|| format!("locked {} at positions that several parts use", counted(locked, "vertex")))
}

/// Returns notes on the parts that stopped before their goal, and why.
pub(crate) fn ends(done: &[Simplification], shares: Option<&[usize]>) -> Vec<String> {
    let Some(shares) = shares else { return Vec::new() };
    let mut notes = Vec::new();
    for (part, (done, &share)) in done.iter().zip(shares).enumerate() {
        if let Some(stopped) = done.stopped.as_ref().filter(|_| done.sequence.triangle_count(0) > share) {
            let name = if shares.len() > 1 { format!("part {part}: ") } else { String::new() };
            notes.push(format!("{name}target {}, {stopped}", count(share)));
        }
    }
    let more = notes.len().saturating_sub(MAX_NAMED_PARTS);
    if more > 0 {
        notes.truncate(MAX_NAMED_PARTS);
        notes.push(format!("{} more stopped before their targets", counted(more, "part")));
    }
    notes
}

/// Returns a distance in percent of a model's diagonal.
pub(crate) fn percent_of(distance: f32, diagonal: f64) -> f64 {
    if diagonal > 0.0 { rounded(100.0 * f64::from(distance) / diagonal) } else { 0.0 }
}

/// Returns a line on the triangles left and the collapses.
fn line(report: &SimplifyReport) -> String {
    let collapses = counted(report.collapses.unwrap_or(0), "collapse");
    format!("{} after {collapses}", counted(report.triangles_after.unwrap_or(0), "triangle"))
}

/// Formats a distance with about four digits.
fn distance(x: f32) -> String {
    if x == 0.0 || (1e-3..1e5).contains(&x) { format!("{x:.4}") } else { format!("{x:.2e}") }
}

/// Returns a table of the sizes before and after.
fn summary(report: &SimplifyReport) -> String {
    let row = |name: &str, before: Option<usize>, after: Option<usize>| {
        let (before, after) = (before.unwrap_or(0), after.unwrap_or(0));
        let share = 100.0 * after as f64 / before.max(1) as f64;
        vec![format!("  {name}"), count(before), count(after), format!("{share:.1} %")]
    };
    let head = vec![String::new(), "before".into(), "after".into(), String::new()];
    let rows = [
        head,
        row("triangles", report.triangles_before, report.triangles_after),
        row("vertices", report.vertices_before, report.vertices_after),
    ];
    let error = report.surface_error.unwrap_or(0.0);
    let percent = report.surface_error_percent.unwrap_or(0.0);
    let error = format!("  error {} mesh units, {percent:.3} % of the diagonal\n", distance(error));
    table(&rows, 1..4) + &error
}
