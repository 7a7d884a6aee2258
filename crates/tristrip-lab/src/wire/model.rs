//! A whole mesh in the format of paper 001, and a level of the received data.

use serde::Serialize;
use tristrip::lod::Encoding;
use tristrip::text::counted;
use tristrip::verify::verify_models;
use tristrip::{Faces, Mesh};
use tristrip_io::{Model, Part};
use tristrip_pipeline::{levels, levels::LevelPart, rounded, unpack::StreamGoal};

use super::{Encoded, WireDecoder, encode};
use crate::error::Error;

/// A mesh in the format of paper 001; the keys are those of the JSON report.
#[derive(Debug, Clone, Serialize)]
pub struct Published {
    /// The bytes of the file.
    #[serde(skip)]
    pub file: Vec<u8>,
    /// The number of levels above the base mesh.
    #[serde(skip)]
    pub levels: usize,
    /// The number of triangles that the bytes are proven to draw; `None` if they were not proven.
    #[serde(skip)]
    pub proven: Option<usize>,
    /// The number of vertices that the full mesh uses.
    pub vertices: usize,
    /// The number of triangles of the full mesh.
    pub triangles: usize,
    /// The number of triangles of the base mesh.
    pub base_triangles: usize,
    /// The size of the file in bytes.
    pub bytes: usize,
    /// The number of bytes before the first record.
    pub base_bytes: usize,
    /// The size of the file in bits per vertex; `None` without vertices.
    pub bits_per_vertex: Option<f64>,
}

/// A level of a file; the keys are those of the JSON report. Levels have no errors, because the
/// file does not store any.
#[derive(Debug, Clone, Serialize)]
pub struct Level {
    /// The mesh of the level.
    #[serde(skip)]
    pub model: Model,
    /// The level.
    pub level: usize,
    /// The level of the full mesh.
    pub levels: usize,
    /// The number of triangles of the level.
    pub triangles: usize,
    /// The number of triangles of the highest level that has arrived.
    pub triangles_full: usize,
    /// The number of bytes that were read.
    pub bytes: usize,
    /// Whether the file ends before the full mesh.
    pub ended_early: bool,
}

/// Encodes part of the levels of a model, with the positions of the part.
///
/// # Errors
/// The positions do not belong to the part, a position is not finite, or a number is too large for
/// the format.
pub(crate) fn encode_part(
    part: &LevelPart,
    positions: &[[f32; 3]],
    encoding: Encoding,
) -> Result<Encoded, Error> {
    let positions = part.positions_of_collapses(positions)?;
    Ok(encode(part.strips(), part.sequence(), &positions, encoding)?)
}

/// Encodes a mesh in the format of paper 001, with the four symbols of its section 3.
///
/// # Errors
/// The mesh is invalid, a number is too large for the format, or the bytes are not proven.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_lab::wire::{pack, unpack};
/// use tristrip_pipeline::{unpack::StreamGoal, levels};
/// let corners = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0\n";
/// let model = read([corners, "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"].concat().as_bytes(), Format::Obj)?;
/// let packed = pack(&model.parts[0].mesh, &levels::Options::default())?;
/// assert_eq!((packed.triangles, packed.proven), (4, Some(4)));
/// let base = unpack(&packed.file, StreamGoal::Triangles(0))?;
/// assert_eq!((base.level, base.triangles), (0, packed.base_triangles));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn pack(mesh: &Mesh, options: &levels::Options) -> Result<Published, Error> {
    let model = Model { parts: vec![Part { mesh: mesh.clone(), ..Part::default() }], ..Model::default() };
    let levels = levels::run(&model, options, &())?.model;
    let Some(part) = levels.parts.first() else {
        return Err(unproven("found no strips, expected those of one mesh"));
    };
    let encoded = encode_part(part, mesh.positions(), Encoding::Offsets)?;
    let sequence = part.sequence();
    let (bytes, vertices) = (encoded.bytes.len(), used_vertices(sequence.triangles()));
    let mut published = Published {
        base_bytes: bytes - encoded.sizes.record_bytes as usize,
        file: encoded.bytes,
        levels: sequence.len(),
        proven: None,
        vertices,
        triangles: sequence.triangle_count(sequence.len())?,
        base_triangles: sequence.triangle_count(0)?,
        bytes,
        bits_per_vertex: (vertices > 0).then(|| rounded(8.0 * bytes as f64 / vertices as f64)),
    };
    if options.verify {
        let full = unpack(&published.file, StreamGoal::Triangles(usize::MAX))?;
        match verify_models(&[mesh], &[&full.model.parts[0].mesh])? {
            Ok(proof) => published.proven = Some(proof.triangles),
            Err(difference) => return Err(unproven(&difference.to_string())),
        }
    }
    Ok(published)
}

/// Decodes a level. A truncated file is decoded up to its end.
///
/// # Errors
/// The bytes are invalid, the level does not exist, or the base mesh is incomplete.
pub fn unpack(bytes: &[u8], goal: StreamGoal) -> Result<Level, Error> {
    let mut decoder = WireDecoder::default();
    let used = match goal {
        StreamGoal::Bytes(most) => &bytes[..most.min(bytes.len())],
        StreamGoal::Level(_) | StreamGoal::Triangles(_) => bytes,
    };
    decoder.update(used)?;
    let Some(header) = decoder.header().filter(|_| decoder.level().is_some()) else {
        let found = format!("the end of the file after {}", counted(used.len(), "byte"));
        return Err(Error::Data(format!("file: found {found}, expected a whole base mesh")));
    };
    let full_level = header.split_count as usize;
    let arrived = decoder.level_count() - 1;
    let level = match goal {
        StreamGoal::Level(level) => level.of(full_level)?.min(arrived),
        StreamGoal::Bytes(_) => arrived,
        StreamGoal::Triangles(most) => finest(&mut decoder, arrived, most)?,
    };
    decoder.set_level(level)?;
    let ended_early = used.len() == bytes.len() && !decoder.is_complete();
    let faces = Faces::from_triangles(decoder.strips().to_list())?;
    let triangles = faces.triangle_count();
    let (mesh, _) = Mesh::new(decoder.positions().to_vec(), faces)?.without_unused_vertices();
    decoder.set_level(arrived)?;
    let triangles_full = decoder.strips().to_list().len() / 3;
    let model = Model { parts: vec![Part { mesh, ..Part::default() }], ..Model::default() };
    let (levels, bytes) = (full_level, used.len());
    Ok(Level { model, level, levels, triangles, triangles_full, bytes, ended_early })
}

/// Finds the finest level with at most this number of triangles. Each level has more triangles than
/// the levels below.
fn finest(decoder: &mut WireDecoder, arrived: usize, most: usize) -> Result<usize, Error> {
    let (mut low, mut high) = (0, arrived);
    while low < high {
        let middle = low + (high - low).div_ceil(2);
        decoder.set_level(middle)?;
        if decoder.strips().to_list().len() / 3 <= most {
            low = middle;
        } else {
            high = middle - 1;
        }
    }
    Ok(low)
}

/// Counts the vertices that triangles use.
fn used_vertices(triangles: &[u32]) -> usize {
    let mut used = triangles.to_vec();
    used.sort_unstable();
    used.dedup();
    used.len()
}

fn unproven(why: &str) -> Error {
    tristrip_pipeline::Error::unproven(why).into()
}
