//! Decodes a level of a progressive GLB.
//!
//! # Algorithm
//! Chunks are decoded one by one until the goal is reached. If the level lies within the last
//! chunk, the mesh of this chunk is collapsed again down to the level. A level is therefore exact,
//! although only whole chunks are decoded. The levels of several meshes are counted together, in
//! the order of the chunks.
//!
//! # Complexity
//! Decodes the chunks up to the goal.

use std::collections::BTreeSet;
use std::path::PathBuf;

use serde::Serialize;
use tristrip::stream::{Decoder, StreamPart, chunks};
use tristrip::{Faces, Mesh};
use tristrip_io::Model;
use tristrip_io::gltf::{ProgressiveGlb, StreamMeshes};

use crate::error::Error;
use crate::levels::Level;
use crate::observer::{Observer, Stage, begin};

/// A criterion that selects a level of a stream.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StreamGoal {
    /// An explicit level: the number of collapses undone in all meshes.
    Level(Level),
    /// The finest level with at most this number of triangles in the refined meshes, or the base
    /// meshes if they have more.
    Triangles(usize),
    /// The level that the first bytes of the file contain.
    Bytes(usize),
}

impl Default for StreamGoal {
    fn default() -> Self {
        Self::Level(Level::Percent(100.0))
    }
}

/// Options for decoding. By default the full meshes are decoded.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Options {
    /// The criterion that selects the level.
    pub goal: StreamGoal,
    /// The directory of external files of the document; `None` if they are not read.
    pub base_dir: Option<PathBuf>,
}

impl Options {
    tristrip::setters! {
        /// Sets the criterion that selects the level.
        with_goal(goal: StreamGoal);

        /// Sets the directory of external files of the document.
        with_base_dir(base_dir: Option<PathBuf>);
    }
}

/// A level of a progressive GLB. The field names are the keys of the JSON report.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Outcome {
    /// The scene with the meshes of the level.
    #[serde(skip)]
    pub model: Model,
    /// The number of parts: glTF primitives.
    pub parts: usize,
    /// The level: the number of collapses that are undone.
    pub level: usize,
    /// The number of collapses. It is also the level of the full meshes.
    pub levels: usize,
    /// The number of triangles of the refined meshes at the level.
    pub triangles: usize,
    /// The number of triangles of the full refined meshes.
    pub triangles_full: usize,
    /// The maximum error of a mesh after the last chunk that was used, in the units of this mesh.
    pub surface_error: f32,
    /// The number of bytes of the file that the level needs.
    pub bytes: usize,
    /// The number of chunks that the level needs.
    pub chunks: usize,
    /// Whether the file is truncated or damaged before the requested level. The level is then the
    /// last one before that point, and a note gives the reason.
    pub ended_early: bool,
    /// Why the stream ended early: the file is truncated or damaged. `None` if it did not.
    #[serde(skip)]
    pub problem: Option<String>,
    /// Human-readable notes of the reader, and the reason why the stream ended before the requested
    /// level.
    pub notes: Vec<String>,
}

/// Decodes a level. A truncated or damaged file is decoded up to the damage, and
/// [`Outcome::problem`] states the reason.
///
/// # Errors
/// The level does not exist, the base meshes are missing, the document is invalid, or the observer
/// cancelled the operation.
///
/// ```
/// use tristrip_io::gltf::ProgressiveGlb;
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::{unpack::StreamGoal, pack, unpack};
/// let row = |y: usize| (0..30).map(move |x| format!("v {x} {y} {}\n", x * y % 3));
/// let square = |i: usize| (i..i + 29).map(|i| format!("f {} {} {} {}\n", i + 1, i + 2, i + 32, i + 31));
/// let obj: String = (0..30).flat_map(row).chain((0..29).flat_map(|y| square(30 * y))).collect();
/// let packed = pack::run(&read(obj.as_bytes(), Format::Obj)?, &pack::Options::default(), &())?;
/// let glb = ProgressiveGlb::open(packed.bytes)?.ok_or_else(|| "no stream".to_owned()).map_err(tristrip_pipeline::Error::unproven)?;
/// let options = unpack::Options::default().with_goal(StreamGoal::Triangles(800));
/// let half = unpack::run(&glb, &options, &())?;
/// assert!((780..=800).contains(&half.triangles) && half.bytes < packed.base_bytes + glb.chunk_bytes());
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn run(glb: &ProgressiveGlb, options: &Options, observer: &dyn Observer) -> Result<Outcome, Error> {
    begin(observer, Stage::Decode)?;
    let goal = options.goal;
    let mut decoder = Decoder::new(glb.limits());
    let mut progress = GoalProgress { goal, target: None };
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
            problem = Some(format!("{fault}; the data before it is used"));
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
    let model = glb.model(&meshes, options.base_dir.as_deref())?;
    let mut notes = model.notes.clone();
    notes.extend(problem.clone());
    Ok(Outcome {
        parts: model.parts.len(),
        model,
        level,
        levels: decoder.parts().map(StreamPart::full_level).sum(),
        triangles: meshes.values().map(|mesh| mesh.faces().triangle_count()).sum(),
        triangles_full: decoder.parts().map(StreamPart::full_triangle_count).sum(),
        surface_error: decoder.parts().map(StreamPart::error).fold(0.0, f32::max),
        bytes: glb.chunk_start() + used,
        chunks: decoder.chunk_count(),
        ended_early: problem.is_some(),
        problem,
        notes,
    })
}

/// Returns why a stream ends before all its bytes are decoded, if it does: an invalid chunk header,
/// or the end of the file.
pub(crate) fn early_end(glb: &ProgressiveGlb, decoder: &mut Decoder) -> Option<String> {
    let used = decoder.offset() as usize;
    if let Err(fault) = decoder.update(&glb.chunks()[used..]) {
        return Some(fault.to_string());
    }
    let all = glb.chunk_bytes();
    (used < all)
        .then(|| format!("the file ends within its stream: {used} of {all} bytes of chunks are complete"))
}

/// A goal, and its level once it is known.
struct GoalProgress {
    goal: StreamGoal,
    target: Option<usize>,
}

impl GoalProgress {
    /// Returns whether the decoded chunks, including all base meshes, reach the goal.
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

/// The state of the decoder when the goal is reached.
struct Reached<'a> {
    decoder: &'a Decoder,
    streams: &'a BTreeSet<usize>,
    target: Option<usize>,
}

impl Reached<'_> {
    /// Returns the meshes of the selected level, and the level. `last` is the mesh whose chunk
    /// passed the goal.
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
