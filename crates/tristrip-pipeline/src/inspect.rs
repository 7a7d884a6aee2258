//! The contents of a progressive GLB stream, and its size per kind of data.

use serde::Serialize;
use tristrip::stream::{Decoder, StreamCosts, StreamPart, chunks};
use tristrip_io::gltf::ProgressiveGlb;

use crate::error::Error;
use crate::metrics::rounded;
use crate::observer::{Observer, Stage, begin};
use crate::unpack::early_end;

/// The contents of a stream. The field names are the keys of the JSON report.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Outcome {
    /// The number of meshes of the stream.
    pub meshes: usize,
    /// The number of vertices of the full meshes, as the stream states it.
    pub vertices: usize,
    /// The number of triangles of the full meshes, as the stream states it.
    pub triangles: usize,
    /// The number of collapses. It is also the level of the full meshes.
    pub levels: usize,
    /// The number of bits per coordinate of a position.
    pub position_bits: u32,
    /// The number of bytes before the first chunk: JSON, base meshes and textures.
    pub base_bytes: usize,
    /// The number of bytes of all chunks of the complete file.
    pub chunk_bytes: usize,
    /// The size of the file in bits divided by `vertices`.
    pub bits_per_vertex: f64,
    /// The size of each component, such as positions or attributes.
    pub components: Vec<ComponentBits>,
    /// The chunks in the file, in their order.
    pub chunks: Vec<Chunk>,
    /// Why the stream ends early: the file is truncated or damaged. `None` if it is complete.
    #[serde(skip)]
    pub problem: Option<String>,
    /// Notes that describe why the stream ends early; empty if it is complete.
    pub notes: Vec<String>,
}

/// The size of a component of a stream in bits, in total and per vertex of the full meshes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ComponentBits {
    /// What is stored: `file before the chunks`, `base meshes`, `marks` (which vertices are split),
    /// `corners` (which triangles move), `positions`, `precision` (further bits of known
    /// positions), `attributes`, or `heads and rounding` (heads with checksums, and rounding to
    /// bytes).
    pub name: &'static str,
    /// The number of bits in the whole file.
    pub bits: f64,
    /// `bits` divided by `vertices`.
    pub per_vertex: f64,
}

/// A chunk of a stream. The field names are the keys of the JSON report.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Chunk {
    /// The index of its mesh, from 0.
    pub mesh: usize,
    /// The offset of the end of the chunk in the file, in bytes.
    pub end: usize,
    /// The level after the chunk: the number of collapses undone so far in all meshes.
    pub level: usize,
    /// The number of triangles of all meshes after the chunk.
    pub triangles: usize,
    /// The maximum error of a mesh after the chunk, in the units of this mesh.
    pub surface_error: f32,
}

/// Decodes a stream. A truncated or damaged stream is decoded up to the damage, and
/// [`Outcome::problem`] states the reason.
///
/// # Errors
/// The observer cancelled the operation.
///
/// ```
/// use tristrip_io::gltf::ProgressiveGlb;
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::{inspect, pack};
/// let row = |y: usize| (0..30).map(move |x| format!("v {x} {y} {}\n", x * y % 3));
/// let square = |i: usize| (i..i + 29).map(|i| format!("f {} {} {} {}\n", i + 1, i + 2, i + 32, i + 31));
/// let obj: String = (0..30).flat_map(row).chain((0..29).flat_map(|y| square(30 * y))).collect();
/// let packed = pack::run(&read(obj.as_bytes(), Format::Obj)?, &pack::Options::default(), &())?;
/// let glb = ProgressiveGlb::open(packed.bytes)?.ok_or_else(|| tristrip_pipeline::Error::unproven("no stream"))?;
/// let found = inspect::run(&glb, &())?;
/// assert_eq!((found.chunks.len(), found.vertices), (packed.chunks, 900));
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn run(glb: &ProgressiveGlb, observer: &dyn Observer) -> Result<Outcome, Error> {
    begin(observer, Stage::Decode)?;
    let mut decoder = Decoder::new(glb.limits()).counting_bits();
    let mut found = Vec::new();
    let mut problem = None;
    for chunk in chunks(glb.chunks()) {
        if let Err(fault) = decoder.update(chunk.bytes) {
            problem = Some(fault.to_string());
            break;
        }
        found.push(Chunk {
            mesh: chunk.stream as usize,
            end: glb.chunk_start() + decoder.offset() as usize,
            level: decoder.parts().map(StreamPart::level).sum(),
            triangles: decoder.parts().map(StreamPart::triangle_count).sum(),
            surface_error: decoder.parts().map(StreamPart::error).fold(0.0, f32::max),
        });
    }
    let problem = problem.or_else(|| early_end(glb, &mut decoder));
    let mut costs = StreamCosts::default();
    decoder.parts().filter_map(StreamPart::costs).for_each(|own| costs.add(&own));
    let vertices = decoder.parts().map(StreamPart::full_vertex_count).sum();
    let (base_bytes, chunk_bytes) = (glb.chunk_start(), glb.chunk_bytes());
    let decoded = found.last().map_or(0, |chunk| chunk.end.saturating_sub(base_bytes));
    Ok(Outcome {
        meshes: decoder.parts().count(),
        vertices,
        triangles: decoder.parts().map(StreamPart::full_triangle_count).sum(),
        levels: decoder.parts().map(StreamPart::full_level).sum(),
        position_bits: decoder.parts().map(|part| part.position_bits()[1]).max().unwrap_or(0),
        base_bytes,
        chunk_bytes,
        bits_per_vertex: per_vertex(8.0 * (base_bytes + chunk_bytes) as f64, vertices),
        components: components(costs, base_bytes, decoded, vertices),
        chunks: found,
        notes: problem.iter().cloned().collect(),
        problem,
    })
}

fn per_vertex(bits: f64, vertices: usize) -> f64 {
    rounded(bits / vertices.max(1) as f64)
}

/// Returns the bits per component: those before the chunks, and those in the decoded part of the
/// chunks.
fn components(
    costs: StreamCosts,
    base_bytes: usize,
    decoded_bytes: usize,
    vertices: usize,
) -> Vec<ComponentBits> {
    let parts = [
        ("file before the chunks", 8.0 * base_bytes as f64),
        ("base meshes", costs.base),
        ("marks", costs.marks),
        ("corners", costs.corners),
        ("positions", costs.positions),
        ("precision", costs.precision),
        ("attributes", costs.attributes),
    ];
    let rest = 8.0 * decoded_bytes as f64 - parts[1..].iter().map(|(_, bits)| bits).sum::<f64>();
    let component = |(name, bits): (_, f64)| ComponentBits {
        name,
        bits: bits.round(),
        per_vertex: per_vertex(bits, vertices),
    };
    parts.into_iter().chain([("heads and rounding", rest)]).map(component).collect()
}
