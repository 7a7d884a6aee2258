//! Measures what a page can show of a model while its file arrives: the distance from the full mesh against time, next to files that are shown when all of them has arrived.
//!
//! ```sh
//! cargo run --profile dist -p tristrip-bench --bin arrival -- ../shared/models/dragon.ply --whole gltfpack=dragon_cc.glb --docs docs
//! ```
//!
//! A chunk is shown when a network of the given bandwidth has delivered the file up to its end and the chunks so far are decoded, whichever is later. Files that are not progressive are
//! charged for their bytes only, not for decoding. Distances are root mean squares over both surfaces, in percent of the diagonal.
#![allow(clippy::print_stdout, reason = "a program that prints")]

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Parser;
use tristrip::Mesh;
use tristrip::stream::{Decoder, StreamPart, chunks};
use tristrip_bench::distance::rms_percent;
use tristrip_bench::failure::Failure;
use tristrip_bench::text::Table;
use tristrip_io::gltf::{ProgressiveGlb, Scene};
use tristrip_io::read_path;
use tristrip_pipeline::pack;
use tristrip_render::chart::{Axis, Mark, Panel, Scale, Series, svg};

/// The chunks that are compared with the full mesh, about: each takes ten seconds for a million triangles.
const COMPARED: usize = 12;

/// Measure what is shown of a model while its file arrives
#[derive(Debug, Parser)]
#[command(version)]
struct Args {
    /// The model; its first mesh is compared
    model: PathBuf,
    /// A file of the same model that is shown when all of it has arrived, and its name
    #[arg(long, value_name = "NAME=FILE", value_parser = named_file)]
    whole: Vec<(String, PathBuf)>,
    /// The bandwidth in megabits per second
    #[arg(long, default_value_t = 5.0)]
    megabits: f64,
    /// Write arrival.md and arrival.svg into this folder
    #[arg(long)]
    docs: Option<PathBuf>,
}

fn named_file(text: &str) -> Result<(String, PathBuf), String> {
    let (name, path) = text.split_once('=').ok_or("expected NAME=FILE")?;
    Ok((name.to_owned(), path.into()))
}

/// What is shown at a time: bytes of the file, triangles, and the distance in percent.
#[derive(Debug, Clone, Copy)]
struct Shown {
    seconds: f64,
    bytes: usize,
    triangles: usize,
    rms: f64,
}

fn main() -> Result<(), Failure> {
    let args = Args::parse();
    let model = read_path(&args.model)?;
    let mesh = &model.parts.first().ok_or("no mesh")?.mesh;
    let packed = pack::run(&model, &pack::Options::default(), &())?;
    let mut curves = vec![("tristrip".to_owned(), progressive(mesh, packed.bytes, args.megabits)?)];
    for (name, path) in &args.whole {
        curves.push((name.clone(), vec![whole(mesh, path, args.megabits)?]));
    }
    let mut table = Table::new(1, &["file", "seconds", "bytes", "triangles", "RMS %"]);
    for (name, shown) in &curves {
        for Shown { seconds, bytes, triangles, rms } in shown {
            let cells =
                [format!("{seconds:.3}"), bytes.to_string(), triangles.to_string(), format!("{rms:.5}")];
            table.push([name.clone()].into_iter().chain(cells).collect());
        }
    }
    println!("{}", table.aligned());
    if let Some(folder) = &args.docs {
        write_docs(folder, &args, &curves, &table)?;
    }
    Ok(())
}

/// Returns what the progressive file shows after some of its chunks: more of the first ones, as they are closer together.
fn progressive(mesh: &Mesh, glb: Vec<u8>, megabits: f64) -> Result<Vec<Shown>, Failure> {
    let glb = ProgressiveGlb::open(glb)?.ok_or("the file has no stream")?;
    let count = chunks(glb.chunks()).count();
    let mut decoder = Decoder::new(glb.limits());
    let (mut decode, mut bytes, mut shown) = (0.0, glb.chunk_start(), Vec::new());
    let mut next = 1.0_f64;
    for (number, chunk) in chunks(glb.chunks()).enumerate().map(|(i, chunk)| (i + 1, chunk)) {
        let start = Instant::now();
        decoder.update(chunk.bytes).map_err(|error| error.to_string())?;
        decode += start.elapsed().as_secs_f64();
        bytes += chunk.bytes.len();
        if (number as f64) < next.floor() && number < count {
            continue;
        }
        next = (next * (count as f64).powf(1.0 / COMPARED as f64)).max(next + 1.0);
        let part = decoder.part(0).ok_or("no base mesh")?;
        let rms = rms_percent(mesh, &part.positions(), &part.triangles())?;
        let arrived = seconds(bytes, megabits);
        shown.push(Shown {
            seconds: arrived.max(decode),
            bytes,
            triangles: StreamPart::triangle_count(part),
            rms,
        });
    }
    Ok(shown)
}

/// Returns what a file shows when all of it has arrived.
fn whole(mesh: &Mesh, path: &Path, megabits: f64) -> Result<Shown, Failure> {
    let bytes = fs::metadata(path).map_err(|error| format!("{}: {error}", path.display()))?.len() as usize;
    let model = read_path(path)?;
    let part = &model.parts.first().ok_or("no mesh")?.mesh;
    let places = model.scene.as_ref().map(Scene::placements).transpose()?;
    let rows = places.and_then(|places| Some(places.first()?.transform));
    let placed = |p: &[f32; 3]| match rows {
        Some(rows) => {
            rows.map(|row| (0..3).map(|j| row[j] * f64::from(p[j])).sum::<f64>() + row[3]).map(|x| x as f32)
        }
        None => *p,
    };
    let positions: Vec<[f32; 3]> = part.positions().iter().map(placed).collect();
    let triangles = part.faces().fans();
    let rms = rms_percent(mesh, &positions, &triangles)?;
    Ok(Shown { seconds: seconds(bytes, megabits), bytes, triangles: triangles.len() / 3, rms })
}

/// The seconds in which bytes are delivered.
fn seconds(bytes: usize, megabits: f64) -> f64 {
    8.0 * bytes as f64 / (1e6 * megabits)
}

fn write_docs(
    folder: &Path,
    args: &Args,
    curves: &[(String, Vec<Shown>)],
    table: &Table,
) -> Result<(), Failure> {
    let points = |(name, shown): &(String, Vec<Shown>)| {
        (name.clone(), shown.iter().map(|shown| (shown.seconds, shown.rms)).collect())
    };
    let curves: Vec<(String, Vec<(f64, f64)>)> = curves.iter().map(points).collect();
    let name = args.model.file_stem().unwrap_or_default().to_string_lossy();
    let title = format!("{name} at {} Mbit/s", args.megabits);
    fs::write(folder.join("arrival.svg"), draw(&title, &curves)?)?;
    let page = format!(
        "# While a file arrives\n\n\
         What can be shown of the {name} at {} megabits per second: the distance from the full mesh against time. A progressive file shows its base mesh first; other files are shown when \
         all of them has arrived, and are charged for their bytes only, not for decoding. Distances are root mean squares over both surfaces, in percent of the diagonal.\n\n\
         ![Distance against time](arrival.svg)\n\n{}\n\
         Generated by `cargo run --profile dist -p tristrip-bench --bin arrival -- MODEL --whole gltfpack=FILE --docs docs`; FILE is what `gltfpack -cc` makes of the model.\n",
        args.megabits,
        table.markdown()
    );
    fs::write(folder.join("arrival.md"), page)?;
    Ok(())
}

/// Draws the distance of the levels shown from the full mesh against the seconds since the download began: steps for each named
/// file, from its first image on. Distances are in percent of the diagonal; those of 0 are left out.
fn draw(title: &str, curves: &[(String, Vec<(f64, f64)>)]) -> Result<String, tristrip_render::Error> {
    let series = |(name, points): &(String, Vec<(f64, f64)>)| {
        let mark = if points.len() > 1 { Mark::Steps } else { Mark::Points };
        Series::new(name, mark, points.iter().copied().filter(|&(_, rms)| rms > 0.0).collect())
    };
    let panel = Panel::new(
        &format!("Distance against time: {title}"),
        Axis::new("seconds since the download began", Scale::Linear { from_zero: true }),
        Axis::new("RMS distance, % of the diagonal", Scale::Log10),
        curves.iter().map(series).collect(),
    );
    svg(&[panel], 1)
}
