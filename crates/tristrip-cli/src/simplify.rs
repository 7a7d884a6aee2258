//! `tristrip simplify`: fewer triangles, by half-edge collapses.
//!
//! ```text
//! load ─ surface ─▶ triangles of each part ─ lock what parts share ─ simplify ─▶ base meshes ─ prove ─ write ─ read again, prove
//! ```

mod goal;
mod parts;

use tristrip::mesh::Triangulation;
use tristrip::simplify::Simplification;
use tristrip::{Layout, Mesh, Options, Strips};
use tristrip_io::{Drawing, Format, Redrawn};

use crate::console::Console;
use crate::failure::Failure;
use crate::figures::rounded;
use crate::input::meshes;
use crate::output::{self, Drawn};
use crate::report::{SimplifyReport, SimplifySeconds};
use crate::stages::{Pool, timed};
use crate::survey::{Loaded, Surveyed};
use crate::task::{Job, Output, SimplifyTask};
use crate::text::{count, counted, table};
pub(crate) use goal::{Amount, Deviation, Goal, Ratio};
pub(crate) use parts::{Compact, Part, diagonal, simplify_all};

/// Parts whose end is told one by one.
const NAMED_PARTS: usize = 8;

/// Simplifies all inputs, one after the other; tells whether all were done.
pub(crate) fn run(task: &SimplifyTask, pool: &Pool, console: &mut Console) -> bool {
    let mut reports = Vec::with_capacity(task.jobs.len());
    for job in &task.jobs {
        let mut report = SimplifyReport { file: job.input.name(), ..SimplifyReport::default() };
        console.begin(&report.file, None);
        let done = simplify(job, task, pool, console, &mut report);
        console.end();
        match done {
            Ok(()) => {
                let title = if task.jobs.len() > 1 { format!("{}\n", report.file) } else { String::new() };
                console.result(&format!("{title}{}", summary(&report)), job.output.is_none());
            }
            Err(failure) => {
                if matches!(failure, Failure::Unproven(_)) {
                    report.proven = Some(false);
                }
                console.error(&format!("{}: {failure}", report.file));
                report.error = Some(failure.to_string());
            }
        }
        reports.push(report);
    }
    console.json(&reports, task.jobs.len() > 1);
    reports.iter().all(|report| report.error.is_none())
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

    // 3. The proof that the collapses are what they say.
    if task.verify {
        console.doing("verify");
        let (proof, seconds) = timed(|| prove(pool, &done));
        proof?;
        report.seconds.verify = Some(seconds);
        report.proven = Some(true);
        let what = "proven: the collapses, done one by one, drop these triangles";
        console.stage("verify", what, Some(seconds));
    } else {
        console.stage("verify", "not asked for", None);
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

/// Gives the triangles of all parts, polygons cut from their first corners.
fn fans<'a>(pool: &Pool, surveyed: &Surveyed<'a>) -> Result<Vec<Part<'a>>, Failure> {
    let triangles =
        pool.map(&surveyed.parts, |part| Triangulation::fan(&part.surface, &part.graph).triangles().to_vec());
    let meshes = surveyed.parts.iter().map(|part| part.mesh);
    Ok(Part::of_all(meshes.zip(triangles).collect())?)
}

/// Does the collapses of each part one by one, and compares what they drop.
fn prove(pool: &Pool, done: &[Simplification]) -> Result<(), Failure> {
    let proofs = pool.map(done, |done| done.sequence.check());
    proofs.into_iter().collect::<Result<(), _>>().map_err(|why| Failure::Unproven(why.to_string()))
}

/// Writes the smaller model.
fn write(
    target: &Output,
    smaller: &Redrawn,
    verify: bool,
    console: &mut Console,
    report: &mut SimplifyReport,
) -> Result<(), Failure> {
    let in_scene = smaller.model.scene.is_some() && target.format == Format::Glb;
    if smaller.kept > 0 && in_scene {
        let what = counted(smaller.kept, "vertex");
        let note =
            format!("{what} left in the file and drawn by nothing: the scene may count on their number");
        console.note(&note);
        report.notes.push(note);
    }
    // A scene leaves lists alone that are drawn as faces; triangles by themselves become new indices.
    let single: Vec<Strips> =
        meshes(&smaller.model).iter().filter(|_| in_scene).map(|mesh| singles(mesh)).collect();
    let drawings: Vec<Drawing<'_>> = if in_scene {
        single.iter().map(Drawing::Strips).collect()
    } else {
        smaller.model.parts.iter().map(|_| Drawing::Faces).collect()
    };
    let drawn = Drawn { model: &smaller.model, drawings: &drawings, layout: Layout::List };
    let written = output::write(target, &smaller.model, drawn, verify, console)?;
    report.seconds.write = Some(written.write_seconds);
    if let (Some(collapses), Some(file)) = (&mut report.seconds.verify, written.verify_seconds) {
        *collapses += file;
    }
    report.notes.extend(written.losses);
    report.output = Some(target.name());
    Ok(())
}

/// Makes each triangle a strip of its own.
fn singles(mesh: &Mesh) -> Strips {
    let mut strips = Strips::default();
    mesh.faces().iter().for_each(|triangle| strips.push(triangle));
    strips
}

/// Says how many vertices parts have in common.
pub(crate) fn locked_note(locked: usize) -> Option<String> {
    (locked > 0).then(|| format!("{} of positions that several parts use stayed", counted(locked, "vertex")))
}

/// Says where parts ended before their goal, and why; the same of several parts once.
pub(crate) fn ends(done: &[Simplification], shares: Option<&[usize]>) -> Vec<String> {
    let Some(shares) = shares else { return Vec::new() };
    let mut notes = Vec::new();
    for (part, (done, &share)) in done.iter().zip(shares).enumerate() {
        if let Some(stopped) = done.stopped.as_ref().filter(|_| done.sequence.triangle_count(0) > share) {
            let name = if shares.len() > 1 { format!("part {part}: ") } else { String::new() };
            notes.push(format!("{name}wanted {}, {stopped}", count(share)));
        }
    }
    let more = notes.len().saturating_sub(NAMED_PARTS);
    if more > 0 {
        notes.truncate(NAMED_PARTS);
        notes.push(format!("{} more ended before their goal", counted(more, "part")));
    }
    notes
}

/// Gives a distance in percent of a model's diagonal.
pub(crate) fn percent_of(distance: f32, diagonal: f64) -> f64 {
    if diagonal > 0.0 { rounded(100.0 * f64::from(distance) / diagonal) } else { 0.0 }
}

/// Says in one line what came of the collapses.
fn line(report: &SimplifyReport) -> String {
    let collapses = counted(report.collapses.unwrap_or(0), "collapse");
    format!("{} by {collapses}", counted(report.triangles_after.unwrap_or(0), "triangle"))
}

/// Writes a distance with three digits or so.
fn distance(x: f32) -> String {
    if x == 0.0 || (1e-3..1e5).contains(&x) { format!("{x:.4}") } else { format!("{x:.2e}") }
}

/// Says what is left of a model.
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
    let error = format!("  error {} in units of the mesh, {percent:.3} % of the diagonal\n", distance(error));
    table(&rows, 1..4) + &error
}
