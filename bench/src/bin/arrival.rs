//! Measures what a page can show of a model while its file loads, compared with files that are
//! shown after they have fully loaded.
//!
//! ```sh
//! gltfpack -cc -i dragon.obj -o dragon_cc.glb && zstd -19 dragon_cc.glb
//! cargo run --profile dist -p tristrip-bench --bin arrival -- ../shared/models/dragon.ply \
//!     --whole "gltfpack -cc=dragon_cc.glb" --whole "gltfpack -cc, zstd=dragon_cc.glb,dragon_cc.glb.zst" \
//!     --docs docs
//! ```
//!
//! A chunk is shown when the network has delivered the file up to its end and the chunks so far are
//! decoded, whichever is later. For other files only the transfer of the served bytes counts, not
//! decompression or decoding. Distances are root mean squares over both surfaces, in percent of the
//! diagonal.
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

/// The approximate number of chunks that are compared with the full mesh. Each comparison takes ten
/// seconds for a million triangles.
const COMPARED: usize = 12;

/// Measure what is shown of a model while its file loads
#[derive(Debug, Parser)]
#[command(version)]
struct Args {
    /// The model; only its first mesh is compared
    model: PathBuf,
    /// A file of the same model that is shown after it has fully loaded: its name, the file, and
    /// the compressed copy that is served
    #[arg(long, value_name = "NAME=FILE[,SERVED]", value_parser = named_file)]
    whole: Vec<WholeFile>,
    /// The bandwidths in Mbit/s
    #[arg(long, value_delimiter = ',', default_values_t = [1.0, 5.0, 20.0])]
    megabits: Vec<f64>,
    /// Write arrival.md and arrival.svg to this directory
    #[arg(long)]
    docs: Option<PathBuf>,
}

/// A file that is shown after it has fully loaded.
#[derive(Debug, Clone)]
struct WholeFile {
    name: String,
    path: PathBuf,
    /// The file whose bytes are transferred.
    served: PathBuf,
}

fn named_file(text: &str) -> Result<WholeFile, String> {
    let (name, paths) = text.split_once('=').ok_or("expected NAME=FILE or NAME=FILE,SERVED")?;
    let (path, served) = paths.split_once(',').unwrap_or((paths, paths));
    Ok(WholeFile { name: name.to_owned(), path: path.into(), served: served.into() })
}

/// An image of the model: the bytes that it needs, and its geometry.
#[derive(Debug, Clone, Copy)]
struct Shown {
    bytes: usize,
    /// The decoding time in seconds; 0 if it does not count.
    decode: f64,
    triangles: usize,
    /// The distance from the full mesh, in percent of the diagonal.
    rms: f64,
}

impl Shown {
    /// Returns the time from the start of the download to this image, in seconds.
    fn seconds(&self, megabits: f64) -> f64 {
        (8.0 * self.bytes as f64 / (1e6 * megabits)).max(self.decode)
    }
}

/// The images of a file, in order.
type Arrival = (String, Vec<Shown>);

fn main() -> Result<(), Failure> {
    let args = Args::parse();
    let model = read_path(&args.model)?;
    let mesh = &model.parts.first().ok_or("no mesh")?.mesh;
    let packed = pack::run(&model, &pack::Options::default(), &())?;
    let mut arrivals = vec![("tristrip pack".to_owned(), progressive(mesh, packed.bytes)?)];
    for file in &args.whole {
        arrivals.push((file.name.clone(), vec![whole(mesh, file)?]));
    }
    let (files, images) =
        (file_table(&arrivals, &args.megabits), image_table(&arrivals[0].1, &args.megabits));
    println!("{}\n{}", files.aligned(), images.aligned());
    if let Some(folder) = &args.docs {
        write_docs(folder, &args, &arrivals, [&files, &images])?;
    }
    Ok(())
}

/// Builds the table of the first and the complete image of each file.
fn file_table(arrivals: &[Arrival], megabits: &[f64]) -> Table {
    let heads = ["first image", "complete"];
    let times =
        heads.iter().flat_map(|head| megabits.iter().map(move |rate| format!("{head}, {rate} Mbit/s")));
    let columns: Vec<String> =
        ["file".into(), "bytes served".into()].into_iter().chain(times).chain(["RMS %".into()]).collect();
    let mut table = Table::new(1, &columns);
    for (name, shown) in arrivals {
        let (Some(first), Some(last)) = (shown.first(), shown.last()) else { continue };
        let times = [first, last]
            .into_iter()
            .flat_map(|image| megabits.iter().map(|&rate| format!("{:.2} s", image.seconds(rate))));
        let cells = [name.clone(), last.bytes.to_string()].into_iter().chain(times);
        table.push(cells.chain([format!("{:.5}", last.rms)]).collect());
    }
    table
}

/// Builds the table of the images of the progressive file.
fn image_table(shown: &[Shown], megabits: &[f64]) -> Table {
    let times = megabits.iter().map(|rate| format!("{rate} Mbit/s"));
    let columns: Vec<String> =
        ["bytes".into(), "triangles".into(), "RMS %".into()].into_iter().chain(times).collect();
    let mut table = Table::new(0, &columns);
    for image in shown {
        let cells = [image.bytes.to_string(), image.triangles.to_string(), format!("{:.5}", image.rms)];
        let times = megabits.iter().map(|&rate| format!("{:.3} s", image.seconds(rate)));
        table.push(cells.into_iter().chain(times).collect());
    }
    table
}

/// Returns the images after some of the chunks of the progressive file. The first chunks are
/// sampled more densely.
fn progressive(mesh: &Mesh, glb: Vec<u8>) -> Result<Vec<Shown>, Failure> {
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
        shown.push(Shown { bytes, decode, triangles: StreamPart::triangle_count(part), rms });
    }
    Ok(shown)
}

/// Returns the image of a file that has fully loaded.
fn whole(mesh: &Mesh, WholeFile { path, served, .. }: &WholeFile) -> Result<Shown, Failure> {
    let bytes =
        fs::metadata(served).map_err(|error| format!("{}: {error}", served.display()))?.len() as usize;
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
    Ok(Shown { bytes, decode: 0.0, triangles: triangles.len() / 3, rms })
}

fn write_docs(folder: &Path, args: &Args, arrivals: &[Arrival], tables: [&Table; 2]) -> Result<(), Failure> {
    let name = args.model.file_stem().unwrap_or_default().to_string_lossy();
    let panels = args.megabits.iter().map(|&rate| panel(&format!("{name} at {rate} Mbit/s"), arrivals, rate));
    fs::write(folder.join("arrival.svg"), svg(&panels.collect::<Vec<_>>(), 1)?)?;
    let [files, images] = tables.map(Table::markdown);
    let page = format!(
        "# First image and complete model\n\n\
         How long a page waits for the {name}. A progressive file shows its base mesh first and \
         refines it. Other files are shown when they are complete, and are charged for the bytes that \
         are served only, not for decompression and decoding. The times of `tristrip pack` include \
         decoding. Distances are root mean squares over both surfaces, in percent of the diagonal.\n\n\
         {files}\n\
         `tristrip pack` is slower than the smallest complete file to its last triangle; it shows an \
         image long before.\n\n\
         ![Distance against time](arrival.svg)\n\n\
         ## Images of the progressive file\n\n{images}\n\
         Generated by `cargo run --profile dist -p tristrip-bench --bin arrival -- MODEL --whole \
         NAME=FILE,SERVED … --docs docs`. SERVED is FILE as `gzip -9` or `zstd -19` compresses it. \
         Draco is `gltf-transform draco --quantize-position 14`, level 10.\n"
    );
    fs::write(folder.join("arrival.md"), page)?;
    Ok(())
}

/// Draws the distances of the images from the full mesh over the time since the start of the
/// download. Each file is a step curve that starts at its first image. Distances of 0 are skipped.
fn panel(title: &str, arrivals: &[Arrival], megabits: f64) -> Panel {
    let series = |(name, shown): &Arrival| {
        let mark = if shown.len() > 1 { Mark::Steps } else { Mark::Points };
        let points = shown.iter().map(|image| (image.seconds(megabits), image.rms));
        Series::new(name, mark, points.filter(|&(_, rms)| rms > 0.0).collect())
    };
    Panel::new(
        &format!("Distance against time: {title}"),
        Axis::new("seconds since the download began", Scale::Linear { from_zero: true }),
        Axis::new("RMS distance, % of the diagonal", Scale::Log10),
        arrivals.iter().map(series).collect(),
    )
}
