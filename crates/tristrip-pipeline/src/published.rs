//! A mesh as paper 001 transmits it: progressive strips, and a record of 12 + 2 u bytes for each vertex that is added (`tristrip::stream::paper`).

use tristrip::stream::paper::Decoder;
use tristrip::verify::verify_models;
use tristrip::{Faces, Mesh};
use tristrip_io::{Model, Part};

use crate::error::Error;
use crate::levels::{LevelsOptions, levels_observed};
use crate::observer::{Observer, Stage, begin};
use crate::pack::{PackedReport, bits_per_vertex};
use crate::stream::used_vertices;
use crate::unpack::{StreamGoal, Unpacked};

/// The first bytes of every such file.
const SIGNATURE: [u8; 3] = [0x89, b'P', b'S'];

/// A mesh as paper 001 transmits it.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Published {
    /// The file.
    pub bytes: Vec<u8>,
    /// The bytes before the first record.
    pub base_bytes: usize,
    /// The levels above the base mesh.
    pub levels: usize,
    /// The triangles of the full mesh.
    pub triangles: usize,
    /// The triangles of the base mesh.
    pub base_triangles: usize,
    /// The vertices that the full mesh uses.
    pub vertices: usize,
    /// The number of triangles that the bytes are proven to draw; `None` if they were not proven.
    pub proven: Option<usize>,
}

impl Published {
    /// Returns the counts for a report.
    pub fn report(&self) -> PackedReport {
        PackedReport {
            meshes: Some(1),
            vertices: Some(self.vertices),
            triangles: Some(self.triangles),
            base_triangles: Some(self.base_triangles),
            bytes: Some(self.bytes.len()),
            base_bytes: Some(self.base_bytes),
            bits_per_vertex: bits_per_vertex(self.bytes.len(), self.vertices),
            ..PackedReport::default()
        }
    }
}

/// Encodes a mesh as paper 001 transmits it, with the four symbols of its section 3.
///
/// # Errors
/// The mesh is not valid, a number is too large for the bytes, the bytes are not proven, or the observer cancelled.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::{LevelsOptions, StreamGoal, pack_as_published, unpack_published};
/// let corners = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0\n";
/// let model = read([corners, "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"].concat().as_bytes(), Format::Obj)?;
/// let packed = pack_as_published(&model.parts[0].mesh, &LevelsOptions::default(), &())?;
/// assert_eq!((packed.triangles, packed.proven), (4, Some(4)));
/// let base = unpack_published(&packed.bytes, StreamGoal::Triangles(0))?;
/// assert_eq!((base.level, base.triangles), (0, packed.base_triangles));
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn pack_as_published(
    mesh: &Mesh,
    options: &LevelsOptions,
    observer: &dyn Observer,
) -> Result<Published, Error> {
    let model = Model { parts: vec![Part { mesh: mesh.clone(), ..Part::default() }], ..Model::default() };
    let levels = levels_observed(&model, options, observer)?;
    let Some(part) = levels.parts.first() else {
        return Err(Error::unproven("found no strips, expected those of one mesh"));
    };
    begin(observer, Stage::Encode)?;
    let encoded = part.encode_as_published(mesh.positions(), tristrip::lod::Encoding::Offsets)?;
    let sequence = part.sequence();
    let mut published = Published {
        base_bytes: encoded.bytes.len() - encoded.sizes.record_bytes as usize,
        bytes: encoded.bytes,
        levels: sequence.len(),
        triangles: sequence.triangle_count(sequence.len())?,
        base_triangles: sequence.triangle_count(0)?,
        vertices: used_vertices(sequence.triangles()),
        proven: None,
    };
    if options.verify {
        begin(observer, Stage::ReadBack)?;
        let full = unpack_published(&published.bytes, StreamGoal::Triangles(usize::MAX))?;
        let again = &full.model.parts[0].mesh;
        match verify_models(&[mesh], &[again])? {
            Ok(proof) => published.proven = Some(proof.triangles),
            Err(difference) => return Err(Error::unproven(difference.to_string())),
        }
    }
    Ok(published)
}

/// Checks whether bytes begin as those of [`pack_as_published`] do.
///
/// ```
/// assert!(!tristrip_pipeline::is_published(b"glTF"));
/// ```
pub fn is_published(bytes: &[u8]) -> bool {
    bytes.starts_with(&SIGNATURE)
}

/// Decodes a level. A file that is cut off gives what is before the end. The levels have no errors: the bytes do not hold any.
///
/// # Errors
/// The bytes are not valid, the level does not exist, or the base mesh is not complete.
pub fn unpack_published(bytes: &[u8], goal: StreamGoal) -> Result<Unpacked, Error> {
    let mut decoder = Decoder::default();
    let used = match goal {
        StreamGoal::Bytes(most) => &bytes[..most.min(bytes.len())],
        StreamGoal::Level(_) | StreamGoal::Triangles(_) => bytes,
    };
    decoder.update(used)?;
    let Some(header) = decoder.header().filter(|_| decoder.level().is_some()) else {
        let found = format!("the end of the file after {} bytes", used.len());
        return Err(tristrip_io::Error::Format {
            at: "file".into(),
            found,
            expected: "a whole base mesh".into(),
        }
        .into());
    };
    let full_level = header.split_count as usize;
    let arrived = decoder.level_count() - 1;
    let level = match goal {
        StreamGoal::Level(level) => level.of(full_level)?.min(arrived),
        StreamGoal::Bytes(_) => arrived,
        StreamGoal::Triangles(most) => finest(&mut decoder, arrived, most)?,
    };
    decoder.set_level(level)?;
    let problem = (used.len() == bytes.len() && !decoder.is_complete())
        .then(|| format!("the file ends after {arrived} of {full_level} records"));
    let faces = Faces::from_triangles(decoder.strips().to_list())?;
    let triangles = faces.triangle_count();
    let (mesh, _) = Mesh::new(decoder.positions().to_vec(), faces)?.without_unused_vertices();
    decoder.set_level(arrived)?;
    let full_triangles = decoder.strips().to_list().len() / 3;
    Ok(Unpacked {
        model: Model { parts: vec![Part { mesh, ..Part::default() }], ..Model::default() },
        level,
        full_level,
        triangles,
        full_triangles,
        error: 0.0,
        bytes: used.len(),
        chunks: 0,
        problem,
    })
}

/// Finds the finest level with at most so many triangles: each level has more than the ones below.
fn finest(decoder: &mut Decoder, arrived: usize, most: usize) -> Result<usize, Error> {
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
