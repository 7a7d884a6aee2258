//! Measures progressive streams: bytes by component, times, memory, and the distance of the surface
//! from the full mesh after fractions of the bytes.
//!
//! ```sh
//! cargo run --profile dist -p tristrip-bench --bin streams -- \
//!     ../shared/models/bunny.ply ../shared/models/horse.ply
//! ```
//!
//! Only the first mesh of a file is encoded, without its attributes unless --attributes is given.
//! Each stream is decoded again, and must have the triangles of the input.
//!
//! Strips that are maintained during refinement are proven after each chunk. Their indices are
//! relative to three per triangle, as means over all chunks. The times next to them are the totals
//! of all chunks, beyond decoding. The bits of links estimate the cost of sending the strips of the
//! full mesh instead, from which the levels of progressive strips are built. Distances are root
//! mean squares over both surfaces, in percent of the diagonal.
#![allow(clippy::print_stdout, reason = "a program that prints")]

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Parser;
use tristrip::stream::{Decoder, StreamLimits, StreamOptions};
use tristrip::verify::verify;
use tristrip::{Layout, Mesh, StripifyOptions, stripify};
use tristrip_bench::distance::rms_percent;
use tristrip_bench::failure::Failure;
use tristrip_bench::measure::median;
use tristrip_bench::memory::{CountingAllocator, extra_bytes};
use tristrip_bench::strip_links;
use tristrip_bench::text::Table;
use tristrip_io::read_path;
use tristrip_pipeline::{StreamedMesh, stream_of_mesh};

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

/// Measure progressive streams
#[derive(Debug, Parser)]
#[command(version)]
struct Args {
    /// The models
    #[arg(required = true)]
    models: Vec<PathBuf>,
    /// Compare the surface with the full mesh after these percentages of the bytes
    #[arg(long, value_delimiter = ',', default_value = "10,25,50")]
    shares: Vec<usize>,
    /// The bytes of the file around the stream, which count as sent before it
    #[arg(long, default_value_t = 0)]
    container_bytes: usize,
    /// The number of times the stream is decoded; the median time is printed
    #[arg(long, default_value_t = 9)]
    rounds: usize,
    /// Also encode the vertex attributes
    #[arg(long)]
    attributes: bool,
}

fn main() -> Result<(), Failure> {
    let args = Args::parse();
    let heads = [
        "model",
        "vertices",
        "bytes",
        "bits/vertex",
        "connectivity",
        "positions",
        "base %",
        "encode ms",
        "decode ms",
        "encode MB",
        "per triangle",
        "batches",
    ];
    let mut table = Table::new(1, &heads);
    let mut distances = Table::new(1, &["model", "share %", "bytes", "triangles", "RMS %"]);
    let heads = [
        "model",
        "chunks",
        "vertices sent",
        "restart",
        "degenerate",
        "full: sent",
        "restart",
        "strips ms",
        "longest chunk ms",
        "ns/triangle",
        "links, bits/vertex",
    ];
    let mut strips = Table::new(1, &heads);
    let mut logarithms = 0.0;
    for path in &args.models {
        let measured = Measured::of(path, &args)?;
        logarithms += measured.bits_per_vertex().ln();
        table.push(measured.row(&args));
        strips.push(measured.strips_row(&args)?);
        for share in &args.shares {
            distances.push(measured.distance_row(*share, &args)?);
        }
    }
    println!("{}", table.aligned());
    println!("geometric mean: {:.2} bits per vertex", (logarithms / args.models.len() as f64).exp());
    println!("\n{}", strips.aligned());
    println!("{}", distances.aligned());
    Ok(())
}

/// A model and its stream.
struct Measured {
    name: String,
    mesh: Mesh,
    streamed: StreamedMesh,
    bytes: Vec<u8>,
    full: Decoder,
    encode_seconds: f64,
    encode_bytes: Option<usize>,
    decode_seconds: f64,
}

impl Measured {
    fn of(path: &Path, args: &Args) -> Result<Self, Failure> {
        let model = read_path(path)?;
        let part = model.parts.into_iter().next().ok_or("no mesh")?;
        let mesh = if args.attributes {
            part.mesh
        } else {
            Mesh::new(part.mesh.shared_positions(), part.mesh.faces().clone())?
        };
        let start = Instant::now();
        let (streamed, encode_bytes) = extra_bytes(|| stream_of_mesh(&mesh, 0, &StreamOptions::default()));
        let encode_seconds = start.elapsed().as_secs_f64();
        let streamed = streamed?;
        let bytes = streamed.stream.bytes();
        let times = (0..args.rounds.max(1)).map(|_| {
            let start = Instant::now();
            decoded(&bytes).map(|_| start.elapsed().as_secs_f64())
        });
        let decode_seconds = median(times.collect::<Result<Vec<_>, _>>()?);
        let mut full = Decoder::new(StreamLimits::default()).counting_bits();
        full.update(&bytes).map_err(|error| error.to_string())?;
        let part = full.part(0).ok_or("no base mesh")?;
        if part.triangle_count() != streamed.triangles || part.level() != part.full_level() {
            return Err(format!("{}: {} triangles", path.display(), part.triangle_count()).into());
        }
        let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        Ok(Self { name, mesh, streamed, bytes, full, encode_seconds, encode_bytes, decode_seconds })
    }

    fn vertices(&self) -> f64 {
        self.full.part(0).map_or(0, tristrip::stream::StreamPart::vertex_count) as f64
    }

    fn bits_per_vertex(&self) -> f64 {
        8.0 * self.bytes.len() as f64 / self.vertices()
    }

    fn row(&self, args: &Args) -> Vec<String> {
        let costs = self.full.part(0).and_then(tristrip::stream::StreamPart::costs).unwrap_or_default();
        let per_vertex = |bits: f64| format!("{:.2}", bits / self.vertices());
        let base =
            args.container_bytes + self.streamed.stream.chunks.first().map_or(0, |chunk| chunk.bytes.len());
        let triangles = self.streamed.triangles as f64;
        vec![
            self.name.clone(),
            self.vertices().to_string(),
            (self.bytes.len() + args.container_bytes).to_string(),
            format!("{:.2}", 8.0 * (self.bytes.len() + args.container_bytes) as f64 / self.vertices()),
            per_vertex(costs.connectivity()),
            per_vertex(costs.positions + costs.precision),
            format!("{:.2}", 100.0 * base as f64 / (self.bytes.len() + args.container_bytes) as f64),
            format!("{:.0}", 1e3 * self.encode_seconds),
            format!("{:.1}", 1e3 * self.decode_seconds),
            self.encode_bytes.map_or("-".into(), |bytes| format!("{:.0}", bytes as f64 / 1e6)),
            self.encode_bytes.map_or("-".into(), |bytes| format!("{:.0}", bytes as f64 / triangles)),
            self.streamed.batches.to_string(),
        ]
    }

    /// Proves and counts the strips after each chunk.
    fn strips_row(&self, args: &Args) -> Result<Vec<String>, Failure> {
        let chunks = &self.streamed.stream.chunks;
        let mut decoder = Decoder::new(StreamLimits::default()).keeping_strips();
        let (mut shares, mut longest) = (Vec::new(), 0.0_f64);
        for chunk in chunks {
            let start = Instant::now();
            decoder.update(&chunk.bytes).map_err(|error| error.to_string())?;
            longest = longest.max(start.elapsed().as_secs_f64());
            let part = decoder.part(0).ok_or("no base mesh")?;
            let kept = part.strips().ok_or("no strips")?;
            verify(&part.mesh()?, &kept).map_err(|difference| difference.to_string())?;
            let list = 3.0 * part.triangle_count().max(1) as f64;
            let indices = |layout| kept.to_indices::<u32>(layout).map(|indices| indices.len());
            let counts = [kept.vertices_sent(), indices(Layout::Restart)?, indices(Layout::Degenerate)?];
            shares.push(counts.map(|count| count as f64 / list));
        }
        let times = (0..args.rounds.max(1)).map(|_| {
            let start = Instant::now();
            let mut decoder = Decoder::new(StreamLimits::default()).keeping_strips();
            decoder.update(&self.bytes).map(|_| start.elapsed().as_secs_f64())
        });
        let times: Result<Vec<_>, _> = times.collect();
        let seconds = median(times.map_err(|error| error.to_string())?) - self.decode_seconds;
        let mean = |i: usize| shares.iter().map(|share| share[i]).sum::<f64>() / shares.len().max(1) as f64;
        let last = shares.last().copied().unwrap_or_default();
        let full = self.full.part(0).ok_or("no base mesh")?.mesh()?;
        let links = strip_links::bits(&full, &stripify(&full, &StripifyOptions::default())?);
        Ok(vec![
            self.name.clone(),
            chunks.len().to_string(),
            format!("{:.4}", mean(0)),
            format!("{:.4}", mean(1)),
            format!("{:.4}", mean(2)),
            format!("{:.4}", last[0]),
            format!("{:.4}", last[1]),
            format!("{:.1}", 1e3 * seconds),
            format!("{:.1}", 1e3 * longest),
            format!("{:.0}", 1e9 * seconds / self.streamed.triangles.max(1) as f64),
            format!("{:.2}", links / self.vertices()),
        ])
    }

    /// Compares the mesh that a fraction of the bytes gives with the full mesh.
    fn distance_row(&self, share: usize, args: &Args) -> Result<Vec<String>, Failure> {
        let all = self.bytes.len() + args.container_bytes;
        let sent = (share * all / 100).saturating_sub(args.container_bytes).min(self.bytes.len());
        let level = decoded(&self.bytes[..sent])?;
        let part = level.part(0).ok_or("the base mesh is not complete")?;
        let percent = rms_percent(&self.mesh, &part.positions(), &part.triangles())?;
        Ok(vec![
            self.name.clone(),
            share.to_string(),
            (sent + args.container_bytes).to_string(),
            part.triangle_count().to_string(),
            format!("{percent:.5}"),
        ])
    }
}

fn decoded(bytes: &[u8]) -> Result<Decoder, Failure> {
    let mut decoder = Decoder::new(StreamLimits::default());
    decoder.update(bytes).map_err(|error| error.to_string())?;
    Ok(decoder)
}
