//! Measures how simplification changes images of textured scenes, compared with gltfpack.
//!
//! ```sh
//! cargo run --profile dist -p tristrip-bench --bin pictures -- --gltfpack gltfpack
//! ```
//!
//! Each scene is simplified to 50 % and 20 % of its triangles. With gltfpack, our result gets as
//! many triangles as gltfpack's result draws. Its parts share this number, or each part gets the
//! same number as gltfpack's part with `--by-part`: gltfpack stops at its error limit, in some
//! parts earlier than in others. The metrics are those of [`compare`]: the fraction of pixels of
//! eight views that differ, and the pixels of holes. The last rows are the sums over all scenes,
//! and our sums divided by gltfpack's.
#![allow(clippy::print_stdout, reason = "a program that prints")]

use std::fs;
use std::path::{Path, PathBuf};

use clap::Parser;
use tristrip::simplify::AttributeWeights;
use tristrip_bench::failure::Failure;
use tristrip_bench::scenes::{self, name, packed};
use tristrip_bench::text::Table;
use tristrip_io::{Format, Model, read, read_path, replace_file};
use tristrip_pipeline::{
    Amount, Deviation, Goal, Ratio, simplify, simplify::CollapseRules, simplify::Normals,
};
use tristrip_render::images::{Differences, Mode, TexturedModel, compare, rows_of_sides};

/// The ratios of triangles that are kept.
const SHARES: [f64; 2] = [0.5, 0.2];
/// The compared modes.
const MODES: [Mode; 3] = [Mode::Textured, Mode::Normals, Mode::Uv];
/// The names of the programs in the table.
const PROGRAMS: [&str; 2] = ["tristrip", "gltfpack"];
/// The width and height of a view in the written images.
const PICTURE_SIZE: u32 = 256;

/// Measure how simplification changes images of textured scenes
#[derive(Debug, Parser)]
#[command(version)]
struct Args {
    /// The directory of scenes, searched recursively for .glb and .gltf
    #[arg(default_value = "../shared/models/textured")]
    models: PathBuf,
    /// Measure only this scene; repeatable
    #[arg(long, value_name = "NAME")]
    model: Vec<String>,
    /// Compare with this gltfpack program
    #[arg(long, value_name = "PATH")]
    gltfpack: Option<PathBuf>,
    /// Give each part as many triangles as gltfpack does
    #[arg(long, requires = "gltfpack")]
    by_part: bool,
    /// The treatment of normals: auto, keep or rebuild
    #[arg(long, value_name = "MODE", default_value_t)]
    normals: Normals,
    /// The weights of attributes, such as normal=2,uv=0.5
    #[arg(long, value_name = "WEIGHTS", default_value = "", hide_default_value = true)]
    weight: AttributeWeights,
    /// Write images to this directory: the scene, our result and gltfpack's, one below the other
    #[arg(long, value_name = "DIR")]
    pictures: Option<PathBuf>,
}

fn main() -> Result<(), Failure> {
    let args = Args::parse();
    let mut sources = scenes::find(&args.models)?;
    sources.retain(|source| args.model.is_empty() || args.model.contains(&name(source)));
    if sources.is_empty() {
        return Err(
            format!("{}: found no .glb or .gltf, expected at least one", args.models.display()).into()
        );
    }
    let heads = ["scene", "by", "before", "after", "textured %", "normals %", "uv %", "holes", "grown"];
    let mut table = Table::new(2, &heads);
    let mut sums = [ComparedPictures::default(); 2];
    for source in &sources {
        for share in SHARES {
            let found = measure(source, share, &args)?;
            for ((by, figures), sum) in PROGRAMS.iter().zip(&found).zip(&mut sums) {
                table.push(figures.cells(&name(source), by));
                sum.add(figures);
            }
            if let [ours, theirs] = &found[..] {
                table.push(ours.ratios(&name(source), theirs));
            }
        }
    }
    for (by, sum) in PROGRAMS.iter().zip(&sums).filter(|(_, sum)| sum.before > 0) {
        table.push(sum.cells("all", by));
    }
    if sums[1].before > 0 {
        table.push(sums[0].ratios("all", &sums[1]));
    }
    println!("{}", table.aligned());
    Ok(())
}

/// The triangles of one or all scenes, and the pixels that differ.
#[derive(Debug, Clone, Copy, Default)]
struct ComparedPictures {
    before: usize,
    after: usize,
    found: [Differences; 3],
}

impl ComparedPictures {
    fn new(before: &TexturedModel, after: &TexturedModel) -> Result<Self, Failure> {
        let found = MODES.map(|mode| compare(before, after, mode));
        let [textured, normals, uv] = found;
        Ok(Self {
            before: before.triangle_count(),
            after: after.triangle_count(),
            found: [textured?, normals?, uv?],
        })
    }

    fn add(&mut self, other: &Self) {
        self.before += other.before;
        self.after += other.after;
        for (sum, found) in self.found.iter_mut().zip(&other.found) {
            sum.shown += found.shown;
            sum.different += found.different;
            sum.holes += found.holes;
            sum.grown += found.grown;
        }
    }

    /// Returns a row of metrics.
    fn cells(&self, scene: &str, by: &str) -> Vec<String> {
        let mut cells = vec![scene.to_owned(), by.to_owned()];
        cells.extend([self.before, self.after].map(|count| count.to_string()));
        cells.extend(self.found.map(|found| format!("{:.2}", 100.0 * found.share())));
        // These are equal in all modes.
        cells.extend([self.found[0].holes, self.found[0].grown].map(|count| count.to_string()));
        cells
    }

    /// Returns a row of the numbers of pixels that differ, relative to another result.
    fn ratios(&self, scene: &str, other: &Self) -> Vec<String> {
        let mut cells = vec![scene.to_owned(), "ratio".to_owned(), String::new(), String::new()];
        let pairs = self.found.iter().zip(&other.found);
        cells.extend(pairs.map(|(a, b)| format!("{:.2}", a.different as f64 / b.different.max(1) as f64)));
        cells.extend([String::new(), String::new()]);
        cells
    }
}

/// Simplifies a scene with both programs. Returns the metrics of each.
fn measure(source: &Path, share: f64, args: &Args) -> Result<Vec<ComparedPictures>, Failure> {
    let model = read_path(source)?;
    let before = TexturedModel::new(&model)?;
    before.notes().iter().for_each(|note| println!("{}: {note}", name(source)));
    let packed = args
        .gltfpack
        .as_ref()
        .map(|program| Ok::<_, Failure>(read(&packed(program, source, share)?, Format::Glb)?))
        .transpose()?;
    let theirs = packed.as_ref().map(TexturedModel::new).transpose()?;
    let ours = match (&packed, &theirs) {
        (Some(packed), _) if args.by_part => {
            let triangles = packed.parts.iter().map(|part| part.mesh.faces().triangle_count());
            let done =
                simplify::run_parts(&model, &triangles.collect::<Vec<_>>(), &options(args, None), &())?;
            TexturedModel::new(&done.redrawn.model)?
        }
        (_, Some(theirs)) => simplified_to(&model, theirs.triangle_count(), args)?,
        (_, None) => simplified(&model, share, args)?,
    };
    let shown = || [&ours].into_iter().chain(&theirs);
    if let Some(folder) = &args.pictures {
        fs::create_dir_all(folder)?;
        let models: Vec<&TexturedModel> = [&before].into_iter().chain(shown()).collect();
        for mode in MODES {
            let file = format!("{}-{}-{}.png", name(source), (100.0 * share).round(), mode.name());
            replace_file(folder.join(file), &rows_of_sides(&models, mode, PICTURE_SIZE)?)?;
        }
    }
    shown().map(|after| ComparedPictures::new(&before, after)).collect()
}

/// Returns the options of a simplification without an error limit.
fn options(args: &Args, amount: Option<Amount>) -> simplify::Options {
    let options =
        simplify::Options::default().with_goal(Goal { amount, deviation: Deviation::Percent(100.0) });
    let rules = CollapseRules { weights: args.weight, ..CollapseRules::default() };
    options.with_normals(args.normals).with_rules(rules).with_format(Format::Glb)
}

/// Simplifies to a ratio of the triangles.
fn simplified(model: &Model, share: f64, args: &Args) -> Result<TexturedModel, Failure> {
    let ratio = Ratio::new(share).ok_or_else(|| format!("found a share of {share}, expected 0 to 1"))?;
    let done = simplify::run(model, &options(args, Some(Amount::Ratio(ratio))), &())?;
    Ok(TexturedModel::new(&done.redrawn.model)?)
}

/// Simplifies until a scene draws at most this number of triangles, or as few as possible. A part
/// with two instances counts twice, and parts do not lose the same fraction, so the ratio of all
/// triangles is found by a search.
fn simplified_to(model: &Model, triangles: usize, args: &Args) -> Result<TexturedModel, Failure> {
    let (mut fewer, mut more) = (0.0, 1.0);
    let mut best = simplified(model, fewer, args)?;
    for _ in 0..12 {
        let share = f64::midpoint(fewer, more);
        let tried = simplified(model, share, args)?;
        if tried.triangle_count() > triangles {
            more = share;
        } else {
            fewer = share;
            best = tried;
        }
    }
    Ok(best)
}
