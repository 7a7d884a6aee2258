//! A mesh of a stream: what its chunks so far have built.

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

/// A mesh that a stream has built so far.
#[derive(Debug, Clone)]
pub struct StreamPart {
    head: Head,
    refiner: Refiner,
    error: f32,
    /// The bytes of its chunks, without their heads.
    payload_bytes: usize,
    /// The error before and the levels after each chunk.
    errors: Vec<(f32, u32)>,
    /// The levels so far, once they have been asked for.
    pub(super) model: OnceLock<Arc<RepairedStrips>>,
}

/// Streams have about two triangles in three bytes, more where surfaces are flat. For so many there is room before they come.
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

    /// Decodes a refinement.
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
        // Room for all that follows, unless so few bytes cannot be expected to build it.
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

    /// Keeps strips of the triangles: called after each chunk.
    pub(super) fn keep_strips(&mut self) {
        match &mut self.refiner.strips {
            Some(strips) => strips.follow_chunk(),
            none => *none = Some(KeptStrips::new(&self.refiner.surface)),
        }
    }

    /// Returns strips of the triangles so far, if they are [kept](super::Decoder::keeping_strips): each triangle once, with its winding. Takes time in proportion to the
    /// mesh.
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

    /// Counts the vertices of the strips, swaps and winding repeats included, in O(1) time, if they are [kept](super::Decoder::keeping_strips).
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

    /// The corners around the vertices that were visited, which decoding takes time in proportion to.
    pub(super) fn corner_count(&self) -> u64 {
        self.refiner.corner_count
    }

    /// Returns the level so far: the number of collapses that are undone.
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

    /// Returns the level of the full mesh, as the stream says.
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

    /// Counts the triangles so far.
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

    /// Counts the triangles of the full mesh, as the stream says.
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

    /// Returns the error of the level in mesh units, that of the positions included.
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

    /// Returns the bits of each component so far, if they are [counted](super::Decoder::counting_bits).
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

    /// Returns the bits of a coordinate that are known so far, and those of the full mesh.
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

    /// Counts the vertices of the full mesh, as the stream says.
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

    /// Counts the vertices so far.
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

    /// Returns the vertices of the triangles so far.
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

    /// Returns the positions of the vertices so far.
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

    /// Returns a checksum of the mesh so far: the CRC-32 of the vertices of the triangles, then the grid positions of the vertices, then the integers of each attribute,
    /// all as 32-bit numbers with the lowest byte first. Decoders that agree return the same after each chunk.
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

    /// Returns the mesh so far, with its attributes.
    ///
    /// # Errors
    /// The head of the stream has two attributes of one name, or one whose values no mesh may have; none where the stream was encoded.
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

    /// Returns the collapses that lead from the mesh so far to the base mesh, over its vertices.
    ///
    /// # Errors
    /// The splits are none of collapses, or the errors are negative; none where the stream was encoded.
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

    /// Returns the bytes of the triangles and vertices so far, and of their strips.
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

    /// Returns the paths of the strips, for the tests.
    #[cfg(test)]
    pub(super) fn paths(&self) -> Option<&PricedPaths> {
        self.refiner.strips.as_ref().map(KeptStrips::paths)
    }

    /// Returns the triangles with their neighbours.
    pub(super) fn surface(&self) -> &StreamSurface {
        &self.refiner.surface
    }
}
