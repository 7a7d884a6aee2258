//! Measures what simplification changes in pictures of textured scenes, compared with gltfpack.
//!
//! ```sh
//! cargo run --release -p tristrip-bench --bin pictures -- --gltfpack gltfpack
//! ```
//!
//! Each scene is simplified to 50 % and to 20 % of its triangles. With gltfpack, ours gets as many triangles as gltfpack's result has. The
//! figures are those of [`compare`]: the share of the pixels of eight views that differ, and the pixels of holes.
#![allow(clippy::print_stdout, reason = "a program that prints")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::Parser;
use tristrip_bench::failure::Failure;
use tristrip_bench::text::Table;
use tristrip_io::{Format, Model, read_path, replace_file};
use tristrip_lab::render::{Differences, Mode, TexturedModel, compare, rows_of_sides};
use tristrip_pipeline::{Amount, Deviation, Goal, Ratio, SimplifyOptions, simplify};

/// The shares of the triangles that are kept.
const SHARES: [f64; 2] = [0.5, 0.2];
/// The modes that are compared.
const MODES: [Mode; 3] = [Mode::Textured, Mode::Normals, Mode::Uv];
/// The width and height of a view in the pictures that are written.
const PICTURE_SIZE: u32 = 256;

/// Measure what simplification changes in pictures of textured scenes
#[derive(Debug, Parser)]
#[command(version)]
struct Args {
    /// The folder of scenes, searched with its subfolders for .glb and .gltf
    #[arg(default_value = "../shared/models/textured")]
    models: PathBuf,
    /// Only this scene; repeatable
    #[arg(long, value_name = "NAME")]
    model: Vec<String>,
    /// Compare with this gltfpack program
    #[arg(long, value_name = "PATH")]
    gltfpack: Option<PathBuf>,
    /// Write pictures into this folder: the scene, ours and gltfpack's below each other
    #[arg(long, value_name = "DIR")]
    pictures: Option<PathBuf>,
}

fn main() -> Result<(), Failure> {
    let args = Args::parse();
    let mut sources = Vec::new();
    find(&args.models, &mut sources)?;
    sources.retain(|source| args.model.is_empty() || args.model.contains(&name(source)));
    if sources.is_empty() {
        return Err(
            format!("{}: found no .glb or .gltf, expected at least one", args.models.display()).into()
        );
    }
    let heads = ["scene", "by", "before", "after", "textured %", "normals %", "uv %", "holes", "grown"];
    let mut table = Table::new(2, &heads);
    for source in &sources {
        for share in SHARES {
            for row in measure(source, share, &args)? {
                table.push(row);
            }
        }
    }
    println!("{}", table.aligned());
    Ok(())
}

/// Lists the scenes of a folder and of its subfolders, by name.
fn find(folder: &Path, sources: &mut Vec<PathBuf>) -> Result<(), Failure> {
    let subject = |error| format!("{}: {error}", folder.display());
    let entries = fs::read_dir(folder).map_err(subject)?.collect::<Result<Vec<_>, _>>().map_err(subject)?;
    let mut paths: Vec<PathBuf> = entries.into_iter().map(|entry| entry.path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            find(&path, sources)?;
        } else if path.extension().is_some_and(|extension| extension == "glb" || extension == "gltf") {
            sources.push(path);
        }
    }
    Ok(())
}

/// Returns the name of a scene.
fn name(source: &Path) -> String {
    source.file_stem().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

/// Simplifies a scene with both programs, and returns a row for each.
fn measure(source: &Path, share: f64, args: &Args) -> Result<Vec<Vec<String>>, Failure> {
    let model = read_path(source)?;
    let before = TexturedModel::new(&model)?;
    before.notes().iter().for_each(|note| println!("{}: {note}", name(source)));
    let theirs = match &args.gltfpack {
        None => None,
        Some(program) => Some(TexturedModel::new(&packed(program, source, share)?)?),
    };
    let ours = match &theirs {
        None => simplified(&model, share)?,
        Some(theirs) => simplified_to(&model, theirs.triangle_count())?,
    };
    let mut rows = Vec::new();
    for (by, after) in [("tristrip", Some(&ours)), ("gltfpack", theirs.as_ref())] {
        let Some(after) = after else { continue };
        let found = MODES.map(|mode| compare(&before, after, mode));
        let [textured, normals, uv] = found;
        rows.push(cells(source, by, [&before, after], [textured?, normals?, uv?]));
    }
    if let Some(folder) = &args.pictures {
        fs::create_dir_all(folder)?;
        let models: Vec<&TexturedModel> = [&before, &ours].into_iter().chain(&theirs).collect();
        for mode in MODES {
            let file = format!("{}-{}-{}.png", name(source), (100.0 * share).round(), mode.name());
            replace_file(folder.join(file), &rows_of_sides(&models, mode, PICTURE_SIZE)?)?;
        }
    }
    Ok(rows)
}

/// Simplifies to a share of the triangles.
fn simplified(model: &Model, share: f64) -> Result<TexturedModel, Failure> {
    let ratio = Ratio::new(share).ok_or_else(|| format!("found a share of {share}, expected 0 to 1"))?;
    let goal = Goal { amount: Some(Amount::Ratio(ratio)), deviation: Deviation::Percent(100.0) };
    let done = simplify(model, &SimplifyOptions::new(goal).with_format(Format::Glb))?;
    Ok(TexturedModel::new(&done.redrawn.model)?)
}

/// Simplifies until a scene shows at most this number of triangles, or as few as possible. A part that is shown twice counts twice, and parts
/// do not lose the same share, so that the share of all triangles is searched.
fn simplified_to(model: &Model, triangles: usize) -> Result<TexturedModel, Failure> {
    let (mut fewer, mut more) = (0.0, 1.0);
    let mut best = simplified(model, fewer)?;
    for _ in 0..12 {
        let share = f64::midpoint(fewer, more);
        let tried = simplified(model, share)?;
        if tried.triangle_count() > triangles {
            more = share;
        } else {
            fewer = share;
            best = tried;
        }
    }
    Ok(best)
}

/// Simplifies with gltfpack, which keeps attributes, materials and nodes as they are.
fn packed(program: &Path, source: &Path, share: f64) -> Result<Model, Failure> {
    let folder = tempfile::tempdir()?;
    let result = folder.path().join("packed.glb");
    let run = Command::new(program)
        .args(["-noq", "-kv", "-km", "-kn", "-si", &share.to_string(), "-i"])
        .arg(source)
        .arg("-o")
        .arg(&result)
        .output()
        .map_err(|error| format!("{}: {error}", program.display()))?;
    if !run.status.success() {
        let message = String::from_utf8_lossy(&run.stderr);
        return Err(format!("{}: {}", program.display(), message.trim()).into());
    }
    Ok(read_path(&result)?)
}

/// Returns the row of a result.
fn cells(
    source: &Path,
    by: &str,
    [before, after]: [&TexturedModel; 2],
    found: [Differences; 3],
) -> Vec<String> {
    let mut cells = vec![name(source), by.to_owned()];
    cells.extend([before, after].map(|model| model.triangle_count().to_string()));
    cells.extend(found.map(|found| format!("{:.2}", 100.0 * found.share())));
    // The same in all modes.
    cells.extend([found[0].holes, found[0].grown].map(|count| count.to_string()));
    cells
}
