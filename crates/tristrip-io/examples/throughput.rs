//! Prints the write and read throughput of each format: `cargo run --release --example throughput
//! -- MODEL`.
//!
//! Every file is read back and verified against the model before its times are printed. Times are
//! the best of five runs.
#![allow(clippy::print_stdout, reason = "the example prints results")]

use std::time::Instant;

use tristrip::verify::verify_models;
use tristrip::{Layout, Mesh, Method, StripifyOptions, Strips, stripify};
use tristrip_io::{Drawing, Format, Model, read, read_path, write};

const RUNS: usize = 5;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: throughput MODEL")?;
    let model = read_path(path)?;
    let options = StripifyOptions::default().with_method(Method::Sequential);
    let strips: Vec<Strips> =
        model.parts.iter().map(|part| stripify(&part.mesh, &options)).collect::<Result<_, _>>()?;
    let by_strips: Vec<Drawing> = strips.iter().map(Drawing::Strips).collect();
    let by_faces = vec![Drawing::Faces; model.parts.len()];
    println!("{:6} {:11} {:>12} {:>12} {:>12}", "format", "drawn as", "bytes", "write MB/s", "read MB/s");
    for (format, drawings, layout) in [
        (Format::Ply, &by_faces, Layout::List),
        (Format::Ply, &by_strips, Layout::Restart),
        (Format::Glb, &by_faces, Layout::List),
        (Format::Glb, &by_strips, Layout::Degenerate),
        (Format::Obj, &by_faces, Layout::List),
    ] {
        let (bytes, write_seconds) = shortest(|| write(&model, drawings, format, layout))?;
        let (again, read_seconds) = shortest(|| read(&bytes, format))?;
        verify_models(&meshes(&model), &meshes(&again))??;
        let rate = |seconds: f64| bytes.len() as f64 / seconds / 1e6;
        let how = if layout == Layout::List { "triangles" } else { "strips" };
        let (name, count) = (format.name(), bytes.len());
        println!("{name:6} {how:11} {count:>12} {:>12.0} {:>12.0}", rate(write_seconds), rate(read_seconds));
    }
    Ok(())
}

fn meshes(model: &Model) -> Vec<&Mesh> {
    model.parts.iter().map(|part| &part.mesh).collect()
}

/// Runs several times and returns the last result and the best time in seconds.
fn shortest<T, E>(mut run: impl FnMut() -> Result<T, E>) -> Result<(T, f64), E> {
    let mut shortest = f64::INFINITY;
    for _ in 1..RUNS {
        let start = Instant::now();
        drop(run()?);
        shortest = shortest.min(start.elapsed().as_secs_f64());
    }
    let start = Instant::now();
    let result = run()?;
    Ok((result, shortest.min(start.elapsed().as_secs_f64())))
}
