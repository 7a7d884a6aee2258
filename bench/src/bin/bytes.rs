//! Measures the size of simplified scenes without images, compared with gltfpack.
//!
//! ```sh
//! cargo run --profile dist -p tristrip-bench --bin bytes -- --gltfpack gltfpack \
//!     ../shared/models/textured ../shared/models/milktruck.glb
//! ```
//!
//! Both programs simplify each scene to 20 % of its triangles, within their default error limits.
//! `compact` is our result with 8-bit weights and 16-bit rotations, which gltfpack also stores.
#![allow(clippy::print_stdout, reason = "a program that prints")]

use std::path::{Path, PathBuf};

use clap::Parser;
use tristrip_bench::failure::Failure;
use tristrip_bench::scenes;
use tristrip_bench::text::Table;
use tristrip_io::gltf::Rounding;
use tristrip_io::{Format, Model, embed_images, read, read_path};
use tristrip_pipeline::{Amount, Goal, Ratio, simplify};

/// Measure the size of simplified scenes without images
#[derive(Debug, Parser)]
#[command(version)]
struct Args {
    /// Scenes, and directories of scenes
    #[arg(default_value = "../shared/models/textured")]
    models: Vec<PathBuf>,
    /// Compare with this gltfpack program
    #[arg(long, value_name = "PATH")]
    gltfpack: PathBuf,
    /// The ratio of triangles that are kept
    #[arg(long, default_value_t = 0.2)]
    share: f64,
}

fn main() -> Result<(), Failure> {
    let args = Args::parse();
    let heads = ["scene", "triangles", "gltfpack's", "bytes", "compact", "gltfpack's", "ratio", "compact"];
    let mut table = Table::new(1, &heads);
    for path in &args.models {
        let sources = if path.is_dir() { scenes::find(path)? } else { vec![path.clone()] };
        for source in &sources {
            table.push(measure(source, &args)?);
        }
    }
    println!("{}", table.aligned());
    Ok(())
}

/// Simplifies a scene with both programs. Returns its row.
fn measure(source: &Path, args: &Args) -> Result<Vec<String>, Failure> {
    let mut model = read_path(source)?;
    embed_images(&mut model, Some(source))?;
    let [default, compact] = [Rounding::Weights, Rounding::WeightsAndRotations]
        .map(|rounding| Measured::of(&simplified(&model, args.share, rounding)?));
    let (default, compact) = (default?, compact?);
    let theirs = Measured::of(&scenes::packed(&args.gltfpack, source, args.share)?)?;
    let ratio = |ours: &Measured| format!("{:.3}", ours.bytes as f64 / theirs.bytes as f64);
    let counts = [default.triangles, theirs.triangles, default.bytes, compact.bytes, theirs.bytes];
    let counts = counts.into_iter().map(|count| count.to_string());
    Ok([scenes::name(source)].into_iter().chain(counts).chain([ratio(&default), ratio(&compact)]).collect())
}

/// Simplifies to a ratio of the triangles. Returns a GLB.
fn simplified(model: &Model, share: f64, rounding: Rounding) -> Result<Vec<u8>, Failure> {
    let ratio = Ratio::new(share).ok_or_else(|| format!("found a share of {share}, expected 0 to 1"))?;
    let goal = Goal { amount: Some(Amount::Ratio(ratio)), ..Goal::default() };
    let options =
        simplify::Options::default().with_goal(goal).with_format(Format::Glb).with_rounding(rounding);
    Ok(simplify::run(model, &options, &())?.encode(Format::Glb, true, &())?.bytes)
}

/// A measured GLB.
struct Measured {
    triangles: usize,
    /// The size in bytes, without images.
    bytes: usize,
}

impl Measured {
    fn of(glb: &[u8]) -> Result<Self, Failure> {
        let model = read(glb, Format::Glb)?;
        let images = match &model.scene {
            None => 0,
            Some(scene) => scene.appearance()?.images.iter().map(|image| image.bytes().len()).sum(),
        };
        let triangles = model.parts.iter().map(|part| part.mesh.faces().face_count()).sum();
        Ok(Self { triangles, bytes: glb.len() - images })
    }
}
