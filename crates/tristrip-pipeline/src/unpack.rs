//! A level of a progressive GLB, and what its stream costs.
//!
//! # Algorithm
//! Chunks are decoded one by one until the goal is reached. The level is then within the last chunk: the collapses of its mesh are made again down to it. So a level is
//! exact, although only whole chunks are decoded. Levels of several meshes are counted together, in the order of the chunks.
//!
//! # Complexity
//! As of the decoder, for the chunks up to the goal.

mod report;

use std::collections::BTreeSet;
use std::path::Path;

use serde::Serialize;
use tristrip::stream::{Decoder, StreamCosts, StreamPart, chunks};
use tristrip::{Faces, Mesh};
use tristrip_io::Model;
use tristrip_io::gltf::{ProgressiveGlb, StreamMeshes};

pub use self::report::{ComponentBits, StreamReport, UnpackedReport};
use crate::error::Error;
use crate::levels::Level;

/// What selects a level of a stream.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StreamGoal {
    /// The level itself: the collapses undone in all meshes.
    Level(Level),
    /// The finest level with at most this number of triangles in the refined meshes; the base meshes if they have more.
    Triangles(usize),
    /// What the first bytes of the file hold.
    Bytes(usize),
}

/// A level of a progressive GLB.
#[derive(Debug)]
#[non_exhaustive]
pub struct Unpacked {
    /// The scene with the meshes of the level.
    pub model: Model,
    /// The level, and that of the full meshes.
    pub level: usize,
    /// The level of the full meshes.
    pub full_level: usize,
    /// The triangles of the refined meshes at the level.
    pub triangles: usize,
    /// Their triangles in full.
    pub full_triangles: usize,
    /// The largest error of a mesh at the end of the last chunk, in its own units.
    pub error: f32,
    /// The bytes of the file that the level needs.
    pub bytes: usize,
    /// The chunks that the level needs.
    pub chunks: usize,
    /// What ended the stream before the goal was reached: the end of the file, or damage.
    pub problem: Option<String>,
}

/// Decodes a level. A file that is cut off or damaged gives what is before the end or the damage, and [`Unpacked::problem`] says so.
///
/// # Errors
/// The level does not exist, the base meshes are not there, or the document is not valid.
///
/// ```
/// use tristrip_io::gltf::ProgressiveGlb;
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::{PackOptions, StreamGoal, pack, unpack};
/// let row = |y: usize| (0..30).map(move |x| format!("v {x} {y} {}\n", x * y % 3));
/// let square = |i: usize| (i..i + 29).map(|i| format!("f {} {} {} {}\n", i + 1, i + 2, i + 32, i + 31));
/// let obj: String = (0..30).flat_map(row).chain((0..29).flat_map(|y| square(30 * y))).collect();
/// let packed = pack(&read(obj.as_bytes(), Format::Obj)?, &PackOptions::default(), &())?;
/// let glb = ProgressiveGlb::open(packed.bytes)?.ok_or_else(|| "no stream".to_owned()).map_err(tristrip_pipeline::Error::unproven)?;
/// let half = unpack(&glb, StreamGoal::Triangles(800), None)?;
/// assert!((780..=800).contains(&half.triangles) && half.bytes < packed.chunk_start + glb.chunk_bytes());
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn unpack(glb: &ProgressiveGlb, goal: StreamGoal, base_dir: Option<&Path>) -> Result<Unpacked, Error> {
    let mut decoder = Decoder::new(glb.limits());
    let mut progress = Progress { goal, target: None };
    let most = match goal {
        StreamGoal::Bytes(bytes) => bytes.saturating_sub(glb.chunk_start()),
        _ => usize::MAX,
    };
    let all = glb.chunks();
    let mut problem = None;
    let mut last = None;
    let mut is_reached = false;
    let mut streams = BTreeSet::new();
    for chunk in chunks(all) {
        if decoder.offset() as usize + chunk.bytes.len() > most {
            is_reached = true;
            break;
        }
        if let Err(fault) = decoder.update(chunk.bytes) {
            problem = Some(format!("{fault}; what came before it is used"));
            break;
        }
        let stream = chunk.stream as usize;
        streams.insert(stream);
        let has_base = |&stream: &u32| streams.contains(&(stream as usize));
        if glb.streams().iter().all(has_base) && progress.is_reached(&decoder)? {
            is_reached = true;
            last = Some(stream);
            break;
        }
    }
    let used = decoder.offset() as usize;
    if problem.is_none() && !is_reached {
        problem = early_end(glb, &mut decoder);
    }
    if let StreamGoal::Level(Level::Number(found)) = goal
        && let full = decoder.parts().map(StreamPart::full_level).sum()
        && found > full
    {
        return Err(Error::Level { found, last: full });
    }
    let reached = Reached { decoder: &decoder, streams: &streams, target: progress.target };
    let (meshes, level) = reached.meshes(goal, last)?;
    Ok(Unpacked {
        model: glb.model(&meshes, base_dir)?,
        level,
        full_level: decoder.parts().map(StreamPart::full_level).sum(),
        triangles: meshes.values().map(|mesh| mesh.faces().triangle_count()).sum(),
        full_triangles: decoder.parts().map(StreamPart::full_triangle_count).sum(),
        error: decoder.parts().map(StreamPart::error).fold(0.0, f32::max),
        bytes: glb.chunk_start() + used,
        chunks: decoder.chunk_count(),
        problem,
    })
}

/// Says why a stream ends before all its bytes are decoded, if it does: a head that is none, or the end of the file.
fn early_end(glb: &ProgressiveGlb, decoder: &mut Decoder) -> Option<String> {
    let used = decoder.offset() as usize;
    if let Err(fault) = decoder.update(&glb.chunks()[used..]) {
        return Some(fault.to_string());
    }
    let all = glb.chunk_bytes();
    (used < all)
        .then(|| format!("the file ends within its stream: {used} of {all} bytes of chunks are complete"))
}

/// A goal, and the level that it asks for once that is known.
struct Progress {
    goal: StreamGoal,
    target: Option<usize>,
}

impl Progress {
    /// Returns whether the goal lies within or before what is decoded, all base meshes among it.
    fn is_reached(&mut self, decoder: &Decoder) -> Result<bool, Error> {
        let level: usize = decoder.parts().map(StreamPart::level).sum();
        match self.goal {
            StreamGoal::Level(goal) => {
                let target = goal.of(decoder.parts().map(StreamPart::full_level).sum())?;
                self.target = Some(target);
                Ok(level >= target)
            }
            StreamGoal::Triangles(most) => {
                Ok(decoder.parts().map(StreamPart::triangle_count).sum::<usize>() > most)
            }
            StreamGoal::Bytes(_) => Ok(false),
        }
    }
}

/// What is decoded when the goal is reached.
struct Reached<'a> {
    decoder: &'a Decoder,
    streams: &'a BTreeSet<usize>,
    target: Option<usize>,
}

impl Reached<'_> {
    /// Returns the meshes of the level that the goal asks for, and the level; `last` is the mesh whose chunk passed the goal.
    fn meshes(&self, goal: StreamGoal, last: Option<usize>) -> Result<(StreamMeshes, usize), Error> {
        let mut level: usize = self.decoder.parts().map(StreamPart::level).sum();
        let triangles: usize = self.decoder.parts().map(StreamPart::triangle_count).sum();
        let beyond = self.target.map_or(0, |target| level.saturating_sub(target));
        let mut meshes = StreamMeshes::new();
        for &stream in self.streams {
            let Some(part) = self.decoder.part(stream) else { continue };
            let mut mesh = part.mesh()?;
            if last == Some(stream) {
                let sequence = part.sequence()?;
                let own = match goal {
                    StreamGoal::Triangles(most) => {
                        let others = triangles - part.triangle_count();
                        sequence.level_of_triangles(most.saturating_sub(others))
                    }
                    StreamGoal::Level(_) | StreamGoal::Bytes(_) => part.level().saturating_sub(beyond),
                };
                level -= part.level() - own;
                mesh = at_level(&mesh, &sequence.drawn(own)?)?;
            }
            meshes.insert(stream as u32, mesh);
        }
        Ok((meshes, level))
    }
}

fn at_level(mesh: &Mesh, triangles: &[[u32; 3]]) -> Result<Mesh, Error> {
    let faces = Faces::from_triangles(triangles.as_flattened().to_vec())?;
    Ok(mesh.with_faces(faces)?.without_unused_vertices().0)
}

/// A chunk of a stream; the keys are those of the JSON report of `tristrip inspect`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ChunkFigures {
    /// The number of its mesh.
    pub mesh: usize,
    /// The first byte of the file behind it.
    pub end: usize,
    /// The level that it leads to, of all meshes together.
    pub level: usize,
    /// The triangles of all refined meshes then.
    pub triangles: usize,
    /// The largest error of a mesh then, in its own units.
    #[serde(rename = "surface_error")]
    pub error: f32,
}

/// What a stream holds, and what it costs.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct StreamFigures {
    /// The bytes before the first chunk: JSON, base meshes, textures.
    pub chunk_start: usize,
    /// The bytes of all chunks in the whole file.
    pub chunk_bytes: usize,
    /// The chunks that are there.
    pub chunks: Vec<ChunkFigures>,
    /// The meshes that are there.
    pub meshes: usize,
    /// The triangles of the full meshes, as the stream says.
    pub triangles: usize,
    /// The vertices of the full meshes, as the stream says.
    pub vertices: usize,
    /// The level of the full meshes.
    pub full_level: usize,
    /// Bits of a coordinate of a position.
    pub position_bits: u32,
    /// The bits of the components, heads and checksums not included.
    pub costs: StreamCosts,
    /// What ends the stream too early: the end of the file, or damage.
    pub problem: Option<String>,
}

/// Decodes a stream, and returns what its chunks hold and what its components cost. A damaged stream gives the figures of what is before the damage.
///
/// ```
/// use tristrip_io::gltf::ProgressiveGlb;
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::{PackOptions, pack, stream_figures};
/// let row = |y: usize| (0..30).map(move |x| format!("v {x} {y} {}\n", x * y % 3));
/// let square = |i: usize| (i..i + 29).map(|i| format!("f {} {} {} {}\n", i + 1, i + 2, i + 32, i + 31));
/// let obj: String = (0..30).flat_map(row).chain((0..29).flat_map(|y| square(30 * y))).collect();
/// let packed = pack(&read(obj.as_bytes(), Format::Obj)?, &PackOptions::default(), &())?;
/// let glb = ProgressiveGlb::open(packed.bytes)?;
/// let figures = glb.map(|glb| stream_figures(&glb));
/// assert!(figures.is_some_and(|figures| figures.chunks.len() == packed.chunks && figures.vertices == 900));
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn stream_figures(glb: &ProgressiveGlb) -> StreamFigures {
    let mut decoder = Decoder::new(glb.limits()).counting_bits();
    let mut found = Vec::new();
    let mut problem = None;
    for chunk in chunks(glb.chunks()) {
        if let Err(fault) = decoder.update(chunk.bytes) {
            problem = Some(fault.to_string());
            break;
        }
        found.push(ChunkFigures {
            mesh: chunk.stream as usize,
            end: glb.chunk_start() + decoder.offset() as usize,
            level: decoder.parts().map(StreamPart::level).sum(),
            triangles: decoder.parts().map(StreamPart::triangle_count).sum(),
            error: decoder.parts().map(StreamPart::error).fold(0.0, f32::max),
        });
    }
    let problem = problem.or_else(|| early_end(glb, &mut decoder));
    let mut costs = StreamCosts::default();
    decoder.parts().filter_map(StreamPart::costs).for_each(|own| costs.add(&own));
    StreamFigures {
        chunk_start: glb.chunk_start(),
        chunk_bytes: glb.chunk_bytes(),
        chunks: found,
        meshes: decoder.parts().count(),
        triangles: decoder.parts().map(StreamPart::full_triangle_count).sum(),
        vertices: decoder.parts().map(StreamPart::full_vertex_count).sum(),
        full_level: decoder.parts().map(StreamPart::full_level).sum(),
        position_bits: decoder.parts().map(|part| part.position_bits()[1]).max().unwrap_or(0),
        costs,
        problem,
    }
}
