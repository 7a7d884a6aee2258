//! A mesh of a stream, as decoded so far.

use std::sync::{Arc, OnceLock};

use super::base::{BaseFault, code_triangles};
use super::chunk::{ChunkHead, ChunkReader};
use super::costs::StreamCosts;
use super::fault::ChunkFault;
use super::head::{Head, code_weights};
use super::places::USUAL_WEIGHTS;
use super::refiner::{FOLLOWS, Refiner};
use super::strips::KeptStrips;
use super::surface::{NONE, StreamSurface};
use crate::collapse::{CollapseSequence, Rename};
#[cfg(test)]
use crate::cover::priced::PricedPaths;
use crate::entropy::range_coder::{BitCoder, RangeDecoder};
use crate::error::Error;
use crate::lod::RepairedStrips;
use crate::mesh::{Faces, Mesh};
use crate::strip::Strips;
use crate::text::counted;

/// A mesh of a stream, as decoded so far.
#[derive(Debug, Clone)]
pub struct StreamPart {
    head: Head,
    refiner: Refiner,
    error: f32,
    /// The bytes of its chunks, without their headers.
    payload_bytes: usize,
    /// For each refinement chunk, the error before it and the level after it.
    errors: Vec<(f32, u32)>,
    /// The levels decoded so far, built on first use.
    pub(super) model: OnceLock<Arc<RepairedStrips>>,
}

/// Triangles to reserve memory for, per byte received. Streams have about two triangles per three
/// bytes, and more where surfaces are flat.
const TRIANGLES_PER_BYTE: usize = 64;

impl StreamPart {
    /// Decodes the base mesh.
    pub(super) fn new(chunk: &ChunkHead, payload: &[u8], counts_bits: bool) -> Result<Self, ChunkFault> {
        let mut reader = ChunkReader { bytes: payload };
        let head = Head::read(&mut reader).map_err(|fault| ChunkFault::new(fault.found, fault.expected))?;
        if !(chunk.error >= 0.0 && chunk.error.is_finite()) {
            let found = format!("an error of {}", chunk.error);
            return Err(ChunkFault::new(found, "a finite number of at least 0"));
        }
        if head.base_triangles != chunk.triangles || chunk.visits != 0 || chunk.level != 0 {
            let found = format!(
                "a base mesh of {} at level {}",
                counted(head.base_triangles, "triangle"),
                chunk.level
            );
            return Err(ChunkFault::new(found, format!("{} at level 0", chunk.triangles)));
        }
        let mut coder = RangeDecoder::new(reader.bytes);
        let weights = code_weights(&mut coder, &USUAL_WEIGHTS);
        let mut refiner = Refiner::new(&weights, head.channel_models());
        refiner.know_bits(head.position_bits - head.unknown_bits, head.unknown_bits);
        let faults = |fault: BaseFault| match fault {
            BaseFault::NoSuchEdge => {
                ChunkFault::new("an edge of two triangles twice", "edges of at most two triangles")
            }
            BaseFault::TooShort => {
                ChunkFault::new("the end of the chunk", counted(head.base_triangles, "triangle"))
            }
        };
        let (opposite, _) = code_triangles(&mut coder, head.base_triangles as usize, &[]).map_err(faults)?;
        refiner.surface = StreamSurface::new(&opposite);
        if !refiner.surface.has_distinct_fans() {
            return Err(ChunkFault::new(
                "a triangle with two corners in one fan",
                "triangles of three points",
            ));
        }
        refiner.code_base(&mut coder, None);
        if coder.is_past_end() {
            return Err(ChunkFault::new("the end of the chunk", "all vertices of the base mesh"));
        }
        let base = 8.0 * payload.len() as f64;
        refiner.costs = counts_bits.then(|| (StreamCosts { base, ..StreamCosts::default() }, 0.0));
        let payload_bytes = payload.len();
        Ok(Self {
            head,
            refiner,
            error: chunk.error,
            payload_bytes,
            errors: Vec::new(),
            model: OnceLock::new(),
        })
    }

    /// Decodes a refinement chunk.
    pub(super) fn refine(
        &mut self,
        chunk: &ChunkHead,
        payload: &[u8],
        (most_triangles, most_corners): (usize, u64),
    ) -> Result<(), ChunkFault> {
        if !(chunk.error >= 0.0 && chunk.error.is_finite()) {
            let found = format!("an error of {}", chunk.error);
            return Err(ChunkFault::new(found, "a finite number of at least 0"));
        }
        self.model = OnceLock::new();
        let mut coder = RangeDecoder::new(payload);
        let refiner = &mut self.refiner;
        refiner.most_triangles = chunk.triangles as usize;
        // Reserve memory for the full mesh, limited to what this many bytes can be expected to
        // build.
        self.payload_bytes += payload.len();
        let expected =
            TRIANGLES_PER_BYTE.saturating_mul(self.payload_bytes).min(self.head.triangles as usize);
        refiner.reserve(expected.min(most_triangles));
        refiner.account(&coder, |_| None);
        for _ in 0..chunk.visits {
            if refiner.next == NONE {
                refiner.begin_batch(&mut coder, 0, 0, |_| [0; 3]);
            }
            if refiner.next == NONE {
                return Err(ChunkFault::new("a refinement of nothing", "a base mesh with triangles"));
            }
            refiner.visit(&mut coder, &[]);
            if refiner.corner_count > most_corners {
                return Err(ChunkFault::corners(refiner.corner_count, most_corners));
            }
            if coder.is_past_end() || refiner.surface.triangle_count() > chunk.triangles as usize {
                break;
            }
        }
        let found = (refiner.group_count, refiner.surface.triangle_count() as u32);
        if coder.is_past_end() || found != (chunk.level, chunk.triangles) {
            let words = |(level, triangles): (u32, u32)| {
                format!("level {level} of {}", counted(triangles, "triangle"))
            };
            return Err(ChunkFault::new(words(found), words((chunk.level, chunk.triangles))));
        }
        self.errors.push((self.error, refiner.group_count));
        self.error = chunk.error;
        Ok(())
    }

    /// Updates the strips of the triangles. Called after each chunk.
    pub(super) fn keep_strips(&mut self) {
        match &mut self.refiner.strips {
            Some(strips) => strips.follow_chunk(),
            none => *none = Some(KeptStrips::new(&self.refiner.surface)),
        }
    }

    /// Returns strips of the triangles decoded so far, if the decoder [maintains
    /// them](super::Decoder::keeping_strips). Every triangle is drawn exactly once, with its
    /// winding. Takes time proportional to the mesh.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// use tristrip::verify::verify;
    /// let mut decoder = Decoder::new(StreamLimits::default()).keeping_strips();
    /// for chunk in &stream.chunks {
    ///     decoder.update(&chunk.bytes)?;
    ///     let part = decoder.part(0).ok_or("no base mesh")?;
    ///     let strips = part.strips().ok_or("no strips")?;
    ///     verify(&part.mesh()?, &strips)?;
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn strips(&self) -> Option<Strips> {
        self.refiner.strips.as_ref().map(|strips| self.emit(strips))
    }

    pub(super) fn emit(&self, strips: &KeptStrips) -> Strips {
        strips.emit(|corner| self.refiner.vertices[self.refiner.surface.fan(corner) as usize])
    }

    /// Returns the number of vertices of the strips, including swaps and winding repeats, if the
    /// decoder [maintains strips](super::Decoder::keeping_strips). Takes O(1) time.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// let mut decoder = Decoder::new(StreamLimits::default()).keeping_strips();
    /// decoder.update(&stream.bytes())?;
    /// let part = decoder.part(0).ok_or("no base mesh")?;
    /// assert_eq!(part.vertices_sent(), part.strips().map(|strips| strips.vertices_sent()));
    /// assert!(part.vertices_sent() < Some(3 * part.triangle_count()));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn vertices_sent(&self) -> Option<usize> {
        self.refiner.strips.as_ref().map(KeptStrips::vertices_sent)
    }

    /// Returns the number of corners visited so far. Decoding time is proportional to it.
    pub(super) fn corner_count(&self) -> u64 {
        self.refiner.corner_count
    }

    /// Returns the current level: the number of collapses undone so far.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// let mut decoder = Decoder::new(StreamLimits::default());
    /// decoder.update(&stream.bytes())?;
    /// let part = decoder.part(0).ok_or("no base mesh")?;
    /// assert_eq!(part.level(), part.full_level());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn level(&self) -> usize {
        self.refiner.group_count as usize
    }

    /// Returns the level of the full mesh, as declared by the stream.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// let mut decoder = Decoder::new(StreamLimits::default());
    /// decoder.update(&stream.chunks[0].bytes)?;
    /// let part = decoder.part(0).ok_or("no base mesh")?;
    /// assert_eq!((part.level(), part.full_level()), (0, batches.sequence.len()));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn full_level(&self) -> usize {
        self.head.levels as usize
    }

    /// Returns the number of triangles decoded so far.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// let mut decoder = Decoder::new(StreamLimits::default());
    /// decoder.update(&stream.chunks[0].bytes)?;
    /// let part = decoder.part(0).ok_or("no base mesh")?;
    /// assert_eq!(part.triangle_count(), stream.chunks[0].triangles as usize);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn triangle_count(&self) -> usize {
        self.refiner.surface.triangle_count()
    }

    /// Returns the number of triangles of the full mesh, as declared by the stream.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// let mut decoder = Decoder::new(StreamLimits::default());
    /// decoder.update(&stream.chunks[0].bytes)?;
    /// let part = decoder.part(0).ok_or("no base mesh")?;
    /// assert_eq!(part.full_triangle_count(), 128);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn full_triangle_count(&self) -> usize {
        self.head.triangles as usize
    }

    /// Returns the error of the current level in mesh units, including the error of quantized
    /// positions.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// let mut decoder = Decoder::new(StreamLimits::default());
    /// decoder.update(&stream.bytes())?;
    /// let part = decoder.part(0).ok_or("no base mesh")?;
    /// assert!(part.error() <= stream.position_error);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn error(&self) -> f32 {
        self.error
    }

    /// Returns the bits spent so far on each component, if the decoder [counts
    /// them](super::Decoder::counting_bits).
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// let decoder = Decoder::new(StreamLimits::default());
    /// let mut decoder = decoder.counting_bits();
    /// decoder.update(&stream.chunks[0].bytes)?;
    /// let part = decoder.part(0).ok_or("no base mesh")?;
    /// assert!(part.costs().is_some_and(|costs| costs.base > 0.0 && costs.marks == 0.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn costs(&self) -> Option<StreamCosts> {
        self.refiner.costs.map(|(costs, _)| costs)
    }

    /// Returns the bits per position coordinate decoded so far, and the bits per coordinate of the
    /// full mesh.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// let mut decoder = Decoder::new(StreamLimits::default());
    /// decoder.update(&stream.bytes())?;
    /// let part = decoder.part(0).ok_or("no base mesh")?;
    /// assert_eq!(part.position_bits(), [14, 14]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn position_bits(&self) -> [u32; 2] {
        [self.head.position_bits - self.refiner.unknown_bits, self.head.position_bits]
    }

    /// Returns the names of the attributes.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// let mut decoder = Decoder::new(StreamLimits::default());
    /// decoder.update(&stream.chunks[0].bytes)?;
    /// let part = decoder.part(0).ok_or("no base mesh")?;
    /// assert_eq!(part.attribute_names().count(), 0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn attribute_names(&self) -> impl Iterator<Item = &str> {
        self.head.channels.iter().map(|channel| channel.name.as_str())
    }

    /// Returns the number of vertices of the full mesh, as declared by the stream.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// let mut decoder = Decoder::new(StreamLimits::default());
    /// decoder.update(&stream.chunks[0].bytes)?;
    /// let part = decoder.part(0).ok_or("no base mesh")?;
    /// assert_eq!(part.full_vertex_count(), 81);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn full_vertex_count(&self) -> usize {
        self.head.vertices as usize
    }

    /// Returns the number of vertices decoded so far.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// let mut decoder = Decoder::new(StreamLimits::default());
    /// decoder.update(&stream.bytes())?;
    /// let part = decoder.part(0).ok_or("no base mesh")?;
    /// assert_eq!(part.vertex_count(), part.full_vertex_count());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn vertex_count(&self) -> usize {
        self.refiner.vertex_count as usize
    }

    /// Returns the triangles decoded so far, three vertex indices each.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// let mut decoder = Decoder::new(StreamLimits::default());
    /// decoder.update(&stream.bytes())?;
    /// let part = decoder.part(0).ok_or("no base mesh")?;
    /// assert_eq!(part.triangles().len(), 3 * 128);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn triangles(&self) -> Vec<u32> {
        let surface = &self.refiner.surface;
        surface.corners().map(|corner| self.refiner.vertices[surface.fan(corner) as usize]).collect()
    }

    /// Returns the positions of the vertices decoded so far, in mesh units.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// let mut decoder = Decoder::new(StreamLimits::default());
    /// decoder.update(&stream.bytes())?;
    /// let part = decoder.part(0).ok_or("no base mesh")?;
    /// assert_eq!(part.positions().len(), 81);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn positions(&self) -> Vec<[f32; 3]> {
        let mut positions = vec![[0.0; 3]; self.vertex_count()];
        for (&vertex, fan) in self.refiner.vertices.iter().zip(&self.refiner.fans) {
            positions[vertex as usize] = self.head.grid.position(fan.place(), self.refiner.unknown_bits);
        }
        positions
    }

    /// Returns a checksum of the mesh decoded so far. It is the CRC-32 of the vertex indices of the
    /// triangles, the grid positions of the vertices, and the integers of each attribute, in this
    /// order, all as little-endian 32-bit numbers. Decoders that agree return the same value after
    /// each chunk.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// let mut decoder = Decoder::new(StreamLimits::default());
    /// let mut other = decoder.clone();
    /// decoder.update(&stream.bytes())?;
    /// for bytes in stream.bytes().chunks(7) {
    ///     other.update(bytes)?;
    /// }
    /// let fingerprint = |decoder: &Decoder| decoder.part(0).map(|part| part.fingerprint());
    /// assert_eq!(fingerprint(&decoder), fingerprint(&other));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn fingerprint(&self) -> u32 {
        let mut hasher = crc32fast::Hasher::new();
        let mut add = |number: u32| hasher.update(&number.to_le_bytes());
        self.triangles().into_iter().for_each(&mut add);
        let mut places = vec![[0; 3]; self.vertex_count()];
        for (&vertex, fan) in self.refiner.vertices.iter().zip(&self.refiner.fans) {
            places[vertex as usize] = fan.place();
        }
        places.into_iter().flatten().for_each(|x: i32| add(x.cast_unsigned()));
        self.refiner.values.iter().flatten().for_each(|&x| add(x.cast_unsigned()));
        hasher.finalize()
    }

    /// Returns the mesh decoded so far, with its attributes.
    ///
    /// # Errors
    /// The head of the stream has two attributes with the same name, or an attribute whose values
    /// are invalid in a mesh. This does not happen for streams written by the encoder.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// let mut decoder = Decoder::new(StreamLimits::default());
    /// decoder.update(&stream.bytes())?;
    /// let part = decoder.part(0).ok_or("no base mesh")?;
    /// assert_eq!(part.mesh()?.faces().iter().len(), 128);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn mesh(&self) -> Result<Mesh, Error> {
        let mesh = Mesh::new(self.positions(), Faces::from_triangles(self.triangles())?)?;
        let channels = self.head.channels.iter().zip(&self.refiner.values);
        channels
            .into_iter()
            .try_fold(mesh, |mesh, (channel, values)| mesh.with_attribute(channel.attribute(values)))
    }

    /// Returns the collapses from the mesh decoded so far to its base mesh, over its vertices.
    ///
    /// # Errors
    /// The splits are not the inverse of valid collapses, or an error is negative. This does not
    /// happen for streams written by the encoder.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// let mut decoder = Decoder::new(StreamLimits::default());
    /// decoder.update(&stream.bytes())?;
    /// let part = decoder.part(0).ok_or("no base mesh")?;
    /// let sequence = part.sequence()?;
    /// assert_eq!(sequence.len(), part.level());
    /// assert_eq!(sequence.triangle_count(0)?, stream.chunks[0].triangles as usize);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn sequence(&self) -> Result<CollapseSequence, Error> {
        let refiner = &self.refiner;
        let vertex = |fan: u32| refiner.vertices[fan as usize];
        let mut renames: Vec<Vec<Rename>> = Vec::new();
        let base_fans = (refiner.fans.len() - refiner.record.len()) as u32;
        for (removed, &kept) in (base_fans..).zip(&refiner.record) {
            let rename = Rename { removed: vertex(removed), kept: vertex(kept & !FOLLOWS) };
            match renames.last_mut().filter(|_| kept & FOLLOWS != 0) {
                Some(group) if group.contains(&rename) => (),
                Some(group) => group.push(rename),
                None => renames.push(vec![rename]),
            }
        }
        let error_of = |level: usize| {
            let chunk = self.errors.partition_point(|&(_, end)| end as usize <= level);
            self.errors.get(chunk).map_or(self.error, |&(error, _)| error)
        };
        let collapses = renames.iter().enumerate().rev().map(|(level, group)| (&group[..], error_of(level)));
        CollapseSequence::from_collapses(self.vertex_count(), self.triangles(), collapses)
    }

    /// Returns the memory of the triangles, vertices and strips in bytes.
    pub(super) fn mesh_bytes(&self) -> usize {
        let refiner = &self.refiner;
        let values: usize = refiner.values.iter().map(|values| size_of_val(&values[..])).sum();
        refiner.surface.memory()
            + size_of_val(&refiner.fans[..])
            + size_of_val(&refiner.vertices[..])
            + size_of_val(&refiner.record[..])
            + values
            + refiner.strips.as_ref().map_or(0, KeptStrips::memory)
    }

    /// Returns the paths of the strips, for tests.
    #[cfg(test)]
    pub(super) fn paths(&self) -> Option<&PricedPaths> {
        self.refiner.strips.as_ref().map(KeptStrips::paths)
    }

    /// Returns the triangles with their adjacency.
    pub(super) fn surface(&self) -> &StreamSurface {
        &self.refiner.surface
    }
}
