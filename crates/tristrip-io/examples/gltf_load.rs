//! Measures time and memory for loading a GLB of a million triangles.
//!
//! ```text
//! cargo run --release -p tristrip-io --example gltf_load
//! ```
#![allow(clippy::print_stdout, reason = "the example prints measurements")]

use std::time::Instant;

use tristrip::{Attribute, AttributeData, Faces, Layout, Mesh};
use tristrip_io::{Drawing, Error, Format, Model, Part, gltf, write};

/// Vertices along each side of the grid: 2 × 707² triangles are about a million.
const SIDE: u32 = 708;

fn grid() -> Result<Mesh, Error> {
    let point = |i: u32| [(i % SIDE) as f32, (i / SIDE) as f32, (i % 7) as f32];
    let positions: Vec<[f32; 3]> = (0..SIDE * SIDE).map(point).collect();
    let mut corners = Vec::new();
    for v in (0..SIDE * (SIDE - 1)).filter(|v| v % SIDE != SIDE - 1) {
        corners.extend([v, v + 1, v + SIDE, v + SIDE, v + 1, v + SIDE + 1]);
    }
    let normals = [0.0, 0.0, 1.0].repeat(positions.len());
    let mesh = Mesh::new(positions, Faces::from_triangles(corners)?)?;
    let data = AttributeData::F32(normals);
    Ok(mesh.with_attribute(Attribute { name: "NORMAL".into(), components: 3, normalized: false, data })?)
}

/// Reads a line of `/proc/self/status` in MiB.
fn memory(line: &str) -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let found = status
        .lines()
        .find_map(|l| l.strip_prefix(line)?.trim_matches([':', ' ', '\t', 'k', 'B']).parse().ok());
    found.map_or(f64::NAN, |kib: f64| kib / 1024.0)
}

fn main() -> Result<(), Error> {
    let path = std::env::temp_dir().join("tristrip_gltf_load.glb");
    let io = |source| Error::Io { path: path.display().to_string(), source };
    if std::env::args().nth(1).as_deref() != Some("load") {
        let model = Model { parts: vec![Part { mesh: grid()?, ..Part::default() }], ..Model::default() };
        let start = Instant::now();
        let glb = write(&model, &[Drawing::Faces], Format::Glb, Layout::List)?;
        println!(
            "write      {:8.1} ms, {:.1} MB",
            start.elapsed().as_secs_f64() * 1e3,
            glb.len() as f64 / 1e6
        );
        std::fs::write(&path, glb).map_err(io)?;
        // A separate process, to measure its memory.
        let program = std::env::current_exe().map_err(io)?;
        std::process::Command::new(program).arg("load").status().map_err(io)?;
        return std::fs::remove_file(&path).map_err(io);
    }
    let before = memory("VmHWM");
    let start = Instant::now();
    let bytes = std::fs::read(&path).map_err(io)?;
    let read = start.elapsed();
    let model = gltf::read(bytes, path.parent())?;
    let total = start.elapsed();
    let mesh = &model.parts[0].mesh;
    let arrays = (24 * mesh.vertex_count() + 4 * mesh.faces().corner_count()) as f64 / f64::from(1 << 20);
    let peak = memory("VmHWM") - before;
    println!("triangles  {:8}", mesh.faces().face_count());
    println!(
        "load       {:8.1} ms, {:.1} of them for the file",
        total.as_secs_f64() * 1e3,
        read.as_secs_f64() * 1e3
    );
    println!("arrays     {arrays:8.1} MiB");
    println!("peak       {peak:8.1} MiB, {:.2} times the arrays", peak / arrays);
    Ok(())
}
