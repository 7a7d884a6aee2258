//! Loads a file several times and prints the best time and the size of the resulting arrays.
//!
//! Run with `cargo run --release -p tristrip-io --example load_time -- model.ply`. Without a file,
//! the example writes a grid of a million triangles to the temporary directory as PLY and OBJ, and
//! loads these.
#![allow(clippy::print_stdout, reason = "the example prints results")]

use std::path::{Path, PathBuf};
use std::time::Instant;

use tristrip::{Faces, Layout, Mesh};
use tristrip_io::{Drawing, Model, Part, read_path, write_path};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let files: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    if !files.is_empty() {
        return files.iter().try_for_each(|file| report(file));
    }
    let model = Model { parts: vec![Part { mesh: grid(707)?, ..Part::default() }], ..Model::default() };
    for name in ["tristrip_grid.ply", "tristrip_grid.obj"] {
        let path = std::env::temp_dir().join(name);
        let start = Instant::now();
        write_path(&path, &model, &[Drawing::Faces], Layout::List)?;
        println!("{name}: written in {:.3} s", start.elapsed().as_secs_f64());
        report(&path)?;
    }
    Ok(())
}

/// Builds a grid of `n` by `n` squares with two triangles each.
fn grid(n: u32) -> Result<Mesh, tristrip::Error> {
    let row = n + 1;
    let positions: Vec<[f32; 3]> = (0..row * row)
        .map(|i| [(i % row) as f32 / n as f32, (i / row) as f32 / n as f32, (i as f32).sin()])
        .collect();
    let corners = (0..n * n).flat_map(|i| {
        let v = i / n * row + i % n;
        [v, v + 1, v + row, v + row, v + 1, v + row + 1]
    });
    Mesh::new(positions, Faces::from_triangles(corners.collect())?)
}

fn report(path: &Path) -> Result<(), Box<dyn std::error::Error>> {
    const REPEATS: u32 = 5;
    let mut best = f64::INFINITY;
    let mut bytes = 0;
    let mut triangles = 0;
    for _ in 0..REPEATS {
        let start = Instant::now();
        let model = read_path(path)?;
        best = best.min(start.elapsed().as_secs_f64());
        let size = |mesh: &Mesh| 12 * mesh.vertex_count() + 4 * mesh.faces().corner_count();
        bytes = model.parts.iter().map(|part| size(&part.mesh)).sum();
        triangles = model.parts.iter().map(|part| part.mesh.faces().triangle_count()).sum::<usize>();
    }
    println!("{}: {triangles} triangles in {best:.4} s, arrays of {bytes} bytes", path.display());
    Ok(())
}
