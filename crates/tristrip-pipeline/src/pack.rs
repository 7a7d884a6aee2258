//! Packs a model as a progressive GLB: base meshes that every viewer draws, and a stream that
//! refines them to the full meshes.
//!
//! ```text
//! Model ─ scene ─▶ parts ─ groups ─▶ mesh per group ─ stream_of_mesh ─┬▶ base triangles ─▶ GLB
//!                                                                     └▶ chunks, appended to it,
//!                                                                        largest error first
//! ```
//!
//! # Algorithm
//! 1. A model that is not glTF gets a scene in memory. The nodes, materials, textures, skins and
//!    animations of a scene are kept.
//! 2. Parts with the same node transforms and the same attributes form a group. A group is one mesh
//!    of the stream, and each vertex has the index of its part. Borders between these parts are
//!    then seams, and stay closed at every level. Vertices that touch another group, or an
//!    unrefined part, stay in the base mesh with all bits of their positions.
//! 3. Parts with morph targets or unread attributes are not refined. A group is also not refined if
//!    its stream would not make the file smaller.
//! 4. Errors are weighted uniformly, or by their apparent size from a viewpoint
//!    ([`Options::with_eye`]). Distant and back-facing parts are then refined later.
//! 5. The base mesh of the stream is drawn before the first chunk. If it is large compared with the
//!    chunks, a separate simplification is drawn instead.
//! 6. Chunks of several meshes are interleaved. The next chunk always belongs to the mesh with the
//!    largest error in the scene.
//!
//! # Complexity
//! One run of `tristrip::stream::encode` per group.

mod eye;
mod group;
mod order;

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::Arc;

use serde::{Serialize, Serializer};
use tristrip::simplify::{Price, SimplifyOptions, simplify_triangles};
use tristrip::stream::StreamOptions;
use tristrip::verify::verify_models;
use tristrip::{Mesh, StripifyOptions, Strips, stripify};
use tristrip_io::gltf::{StreamedPart, WrittenGlb, read_base, with_scene, write_progressive};
use tristrip_io::{Drawing, Format, Model, Part};

use self::eye::error_factors;
use self::group::{Group, groups, touching_vertices};
use self::order::{Queue, in_order};
use crate::encode::kept_vertices;
use crate::error::Error;
use crate::metrics::rounded;
use crate::observer::{Observer, Stage, begin};
use crate::parts::{map, meshes};
use crate::places::Places;
use crate::stream::{StreamedMesh, drawn_triangles, stream_with, used_vertices};
use crate::text::counted;

/// Limits for the triangles that are drawn before the first chunk: their maximum size in percent of
/// the stream, and a number of triangles that is always allowed.
const BASE_PERCENT: usize = 2;
const MIN_BASE_TRIANGLES: usize = 256;
/// The maximum number of triangles of a mesh for which that simplification measures distances.
const MAX_BY_DISTANCE: usize = 200_000;

/// Options for packing a model.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Options {
    /// How meshes are encoded.
    pub stream: StreamOptions,
    /// The viewpoint for weighting errors, in scene coordinates. Errors are divided by the
    /// distance, and halved on back faces. `None` for uniform weights.
    pub eye: Option<[f32; 3]>,
    /// Whether the bytes are read back and verified.
    pub verify: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { stream: StreamOptions::default(), eye: None, verify: true }
    }
}

impl Options {
    tristrip::setters! {
        /// Sets how meshes are encoded.
        with_stream(stream: StreamOptions);

        /// Sets the viewpoint for weighting errors, in scene coordinates.
        with_eye(eye: Option<[f32; 3]>);

        /// Sets whether the bytes are read back and verified.
        with_verify(verify: bool);
    }
}

/// A progressive GLB. The field names are the keys of the JSON report.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Outcome {
    /// The file.
    #[serde(skip)]
    pub bytes: Vec<u8>,
    /// Whether the file contains exactly the triangles of the model when it is read back, at
    /// positions rounded to the grid; `None` if verification was disabled. A report contains
    /// `true`, and in Rust the value is the number of triangles.
    #[serde(serialize_with = "is_some_or_null")]
    #[cfg_attr(feature = "schema", schemars(with = "Option<bool>"))]
    pub proven: Option<usize>,
    /// The number of parts: glTF primitives or OBJ materials.
    pub parts: usize,
    /// The number of meshes of the stream.
    pub meshes: usize,
    /// The number of chunks of all meshes.
    pub chunks: usize,
    /// The number of vertices that triangles use; equal vertices are counted once.
    pub vertices: usize,
    /// The number of triangles of the full model.
    pub triangles: usize,
    /// The number of triangles that are drawn before the first chunk: in coarse meshes, and in
    /// parts that are not refined.
    pub base_triangles: usize,
    /// The size of the file in bytes.
    #[serde(rename = "bytes")]
    pub file_bytes: usize,
    /// The number of bytes before the first chunk.
    pub base_bytes: usize,
    /// The size of the file in bits, including textures, divided by `vertices`; `None` if there are
    /// no vertices.
    pub bits_per_vertex: Option<f64>,
    /// The maximum distance between a position and its original, in the units of the scene.
    pub position_error: f64,
    /// Human-readable notes on data that was read, was dropped or cannot be stored, and on parts
    /// that are not refined.
    pub notes: Vec<String>,
}

/// Serializes whether a number is present, as `true` or `null`.
#[expect(clippy::ref_option, reason = "the signature that serde calls")]
fn is_some_or_null<S: Serializer>(number: &Option<usize>, serializer: S) -> Result<S::Ok, S::Error> {
    number.map(|_| true).serialize(serializer)
}

/// Packs a model as a progressive GLB.
///
/// # Errors
/// The model cannot be written as a GLB, the bytes fail verification, or the observer cancelled the
/// operation.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::pack;
/// let row = |y: usize| (0..30).map(move |x| format!("v {x} {y} {}\n", x * y % 3));
/// let square = |i: usize| (i..i + 29).map(|i| format!("f {} {} {} {}\n", i + 1, i + 2, i + 32, i + 31));
/// let obj: String = (0..30).flat_map(row).chain((0..29).flat_map(|y| square(30 * y))).collect();
/// let packed = pack::run(&read(obj.as_bytes(), Format::Obj)?, &pack::Options::default(), &())?;
/// assert_eq!((packed.triangles, packed.proven), (29 * 29 * 2, Some(29 * 29 * 2)));
/// assert!(packed.base_triangles < packed.triangles / 2);
/// assert_eq!(read(&packed.bytes, Format::Glb)?.parts[0].mesh.faces().triangle_count(), packed.triangles);
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn run(model: &Model, options: &Options, observer: &dyn Observer) -> Result<Outcome, Error> {
    begin(observer, Stage::Simplify)?;
    let losses = tristrip_io::losses(model, &vec![Drawing::Faces; model.parts.len()], Format::Glb);
    let mut notes = model.notes.clone();
    let model = with_scene(model)?;
    if let Cow::Owned(built) = &model {
        notes.extend_from_slice(&built.notes);
    }
    let model = &*model;
    let places = Places::of(model);
    notes.extend(places.note());
    let (groups, whole) = groups(model, &places, &mut notes)?;
    let locked = touching_vertices(&groups, (model, &whole), &places);
    let lockable: Vec<(&Group, &Vec<bool>)> = groups.iter().zip(&locked).collect();
    let streamed = map(&lockable, |&(group, locked)| {
        if observer.is_cancelled() {
            return Err(Error::Cancelled);
        }
        let streamed = stream_of_group(group, locked, &places, options)?;
        let coarse = drawn_base(group, &streamed, locked)?;
        Ok((streamed, coarse))
    });
    let mut assembly = Assembly::new(model, notes, options.verify);
    for (group, streamed) in groups.iter().zip(streamed) {
        match streamed {
            Ok((streamed, coarse)) => assembly.add(group, streamed, &coarse)?,
            // Values that cannot be encoded, such as normals that are NaN.
            Err(Error::Input(error @ tristrip::Error::Parameter { .. })) => {
                assembly.notes.push(format!("{} not refined: {error}", counted(group.parts.len(), "part")));
            }
            Err(error) => return Err(error),
        }
    }
    assembly.finish(losses, observer)
}

/// Encodes the mesh of a group.
fn stream_of_group(
    group: &Group,
    locked: &[bool],
    places: &Places,
    options: &Options,
) -> Result<StreamedMesh, Error> {
    let stream = group.bounds.map_or(options.stream, |bounds| options.stream.with_bounds(bounds));
    // Vertices near the eye need more bits than the mean error of a level justifies.
    let stream = stream.with_exact_positions(locked.contains(&true) || options.eye.is_some());
    let mut simplify = SimplifyOptions::default().with_locked(locked.to_vec());
    if let Some(eye) = options.eye {
        simplify = simplify.with_error_factors(error_factors(&group.mesh, &places.lists[group.list], eye));
    }
    stream_with(&group.mesh, &simplify, 0, &stream)
}

/// The contents of the file.
struct Assembly<'a> {
    model: &'a Model,
    /// For each part, the triangles that are drawn before the first chunk, and its refinement, if
    /// it has one.
    drawn: Vec<Vec<u32>>,
    sources: Vec<Option<StreamedPart>>,
    queues: Vec<Queue>,
    /// The expected mesh of each refined part, for verification; `None` if nothing is verified.
    expected: Option<HashMap<usize, Mesh>>,
    /// The number of parts whose stream would not be smaller, and of triangles with two corners at
    /// one position.
    larger: usize,
    dropped: usize,
    /// The counts of the refined parts.
    triangles: usize,
    vertices: usize,
    position_error: f64,
    notes: Vec<String>,
}

impl<'a> Assembly<'a> {
    fn new(model: &'a Model, notes: Vec<String>, proves: bool) -> Self {
        let triangles = |part: &Part| part.mesh.faces().fans().into_owned();
        Self {
            model,
            drawn: model.parts.iter().map(triangles).collect(),
            sources: vec![None; model.parts.len()],
            queues: Vec::new(),
            expected: proves.then(HashMap::new),
            larger: 0,
            dropped: 0,
            triangles: 0,
            vertices: 0,
            position_error: 0.0,
            notes,
        }
    }

    /// Adds a group with its stream and the triangles that are drawn before it, unless the stream
    /// would not make the file smaller.
    fn add(&mut self, group: &Group, streamed: StreamedMesh, coarse: &[u32]) -> Result<(), Error> {
        if !pays(group, &streamed, coarse) {
            self.larger += group.parts.len();
            return Ok(());
        }
        let (stream, scale) = (self.queues.len() as u32, group.scale);
        for (number, (part, list)) in (0..).zip(group.split(coarse)) {
            self.drawn[part] = list;
            let part_number = (group.parts.len() > 1).then_some(number);
            self.sources[part] = Some(StreamedPart { stream, part: part_number });
        }
        if let Some(expected) = &mut self.expected {
            expected.extend(group.expected(&streamed.stream)?);
        }
        self.dropped += streamed.dropped_triangles;
        self.triangles += streamed.triangles;
        self.vertices += streamed.vertices;
        self.position_error = self.position_error.max(f64::from(streamed.stream.position_error) * scale);
        self.queues.push(Queue { chunks: streamed.stream.chunks, scale });
        Ok(())
    }

    /// Writes the file and verifies it.
    fn finish(mut self, losses: Vec<String>, observer: &dyn Observer) -> Result<Outcome, Error> {
        let mut note = |count: usize, noun: &str, what: &str| {
            if count > 0 {
                self.notes.push(format!("{} {what}", counted(count, noun)));
            }
        };
        note(self.larger, "part", "not refined: streams would not be smaller");
        note(self.dropped, "triangle", "with two corners at one position dropped");
        if self.queues.is_empty() {
            self.notes.push("no stream: the file is a plain GLB".into());
        }
        begin(observer, Stage::Encode)?;
        let base_triangles = self.drawn.iter().map(|list| list.len() / 3).sum();
        for (list, _) in self.drawn.iter().zip(&self.sources).filter(|(_, source)| source.is_none()) {
            self.triangles += list.len() / 3;
            self.vertices += used_vertices(list);
        }
        let coarse = tristrip_io::with_triangles(self.model, self.drawn, Format::Glb)?;
        self.notes.extend(kept_vertices(&coarse));
        let strips = shorter_strips(&coarse.model)?;
        let drawings = strips.iter().map(|strips| strips.as_ref().map_or(Drawing::Faces, Drawing::Strips));
        let drawings: Vec<Drawing<'_>> = drawings.collect();
        let chunks = in_order(&self.queues);
        let WrittenGlb { bytes, chunk_start, .. } =
            write_progressive(&coarse.model, &drawings, &self.sources, &chunks)?;
        // The models that are read back share the bytes.
        let bytes = Arc::new(bytes);
        let mut proven = None;
        if let Some(expected) = &self.expected {
            begin(observer, Stage::ReadBack)?;
            if !chunks.is_empty() {
                prove_base(&coarse.model, &bytes)?;
            }
            proven = Some(prove(self.model, &bytes, expected)?);
        }
        self.notes.extend(losses);
        let (file_bytes, vertices) = (bytes.len(), self.vertices);
        Ok(Outcome {
            bytes: Arc::unwrap_or_clone(bytes),
            proven,
            parts: self.model.parts.len(),
            meshes: self.queues.len(),
            chunks: self.queues.iter().map(|queue| queue.chunks.len()).sum(),
            vertices,
            triangles: self.triangles,
            base_triangles,
            file_bytes,
            base_bytes: chunk_start,
            bits_per_vertex: (vertices > 0).then(|| rounded(8.0 * file_bytes as f64 / vertices as f64)),
            position_error: self.position_error,
            notes: self.notes,
        })
    }
}

/// Returns strips of each part that is drawn with fewer indices as strips than as faces.
fn shorter_strips(model: &Model) -> Result<Vec<Option<Strips>>, Error> {
    let found = map(&model.parts, |part| {
        let strips = stripify(&part.mesh, &StripifyOptions::default())?;
        let is_shorter = strips.to_degenerate().len() < part.mesh.faces().corner_count();
        Ok(is_shorter.then_some(strips))
    });
    found.into_iter().collect()
}

/// Returns the triangles that are drawn before the first chunk. These are the base mesh of the
/// stream or, if it takes more than a small share of the file, a separate simplification. Streams
/// cannot undo every collapse, but this simplification does not have to be undone.
fn drawn_base(group: &Group, streamed: &StreamedMesh, locked: &[bool]) -> Result<Vec<u32>, Error> {
    let base = &streamed.stream.base;
    let chunk_bytes: usize = streamed.stream.chunks.iter().map(|chunk| chunk.bytes.len()).sum();
    // About one vertex per two triangles, and three bytes of strips per triangle.
    let most = chunk_bytes * BASE_PERCENT / 100 / (group.vertex_bytes() / 2 + 3);
    let most = most.max(MIN_BASE_TRIANGLES);
    if base.len() / 3 <= most {
        return Ok(base.clone());
    }
    let (triangles, _) = drawn_triangles(&group.mesh);
    // Planes alone take a third of the time.
    let price = if triangles.len() / 3 > MAX_BY_DISTANCE { Price::Planes } else { Price::Distance };
    let options = SimplifyOptions::default().with_triangles(most).with_locked(locked.to_vec());
    let coarse = simplify_triangles(&group.mesh, triangles, &options.with_price(price))?;
    Ok(coarse.sequence.drawn(0)?.into_flattened())
}

/// Returns whether a stream takes fewer bytes than the data that it replaces.
fn pays(group: &Group, streamed: &StreamedMesh, coarse: &[u32]) -> bool {
    let vertices = streamed.vertices.saturating_sub(used_vertices(coarse));
    let triangles = streamed.triangles.saturating_sub(coarse.len() / 3);
    let index = if streamed.vertices < 1 << 16 { 2 } else { 4 };
    let left_out = vertices * group.vertex_bytes() + triangles * 3 * index;
    streamed.stream.chunks.iter().map(|chunk| chunk.bytes.len()).sum::<usize>() < left_out
}

/// Reads the base meshes back, and verifies that they draw exactly the expected triangles.
fn prove_base(coarse: &Model, bytes: &Arc<Vec<u8>>) -> Result<(), Error> {
    let again = read_base(bytes).map_err(unproven)?;
    match verify_models(&meshes(coarse), &meshes(&again))? {
        Ok(_) => Ok(()),
        Err(difference) => Err(Error::unproven(format!("base meshes: {difference}"))),
    }
}

/// Reads the full meshes back, and verifies that each part has exactly the triangles of the model,
/// at the positions that the stream stores.
fn prove(model: &Model, bytes: &Arc<Vec<u8>>, expected: &HashMap<usize, Mesh>) -> Result<usize, Error> {
    let again = tristrip_io::read_shared(bytes, Format::Glb).map_err(unproven)?;
    if again.parts.len() != model.parts.len() {
        let (found, expected) = (again.parts.len(), model.parts.len());
        return Err(Error::unproven(format!(
            "found {}, expected {expected}",
            tristrip::text::counted(found, "part")
        )));
    }
    let mut triangles = 0;
    for (number, part) in model.parts.iter().enumerate() {
        let source = expected.get(&number).unwrap_or(&part.mesh);
        match verify_models(&[source], &[&again.parts[number].mesh])? {
            Ok(proof) => triangles += proof.triangles,
            Err(difference) => return Err(Error::unproven(format!("part {number}: {difference}"))),
        }
    }
    Ok(triangles)
}

#[allow(clippy::needless_pass_by_value, reason = "called by map_err")]
fn unproven(error: tristrip_io::Error) -> Error {
    Error::unproven(error.to_string())
}
