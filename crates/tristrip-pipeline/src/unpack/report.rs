//! What a level of a stream, and a stream, are reported as.

use serde::Serialize;

use super::{ChunkFigures, StreamFigures, Unpacked};
use crate::metrics::rounded;

/// The counts of a level; the keys are those of the JSON report of `tristrip unpack`. All are `None` before it is decoded.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct UnpackedReport {
    /// The parts of the model.
    pub parts: Option<usize>,
    /// The level.
    pub level: Option<usize>,
    /// The level of the full meshes.
    pub levels: Option<usize>,
    /// The triangles of the refined meshes.
    pub triangles: Option<usize>,
    /// Their triangles in full.
    pub triangles_full: Option<usize>,
    /// The largest error of a mesh at the end of the last chunk, in its own units.
    pub surface_error: Option<f32>,
    /// The bytes of the file that the level needs.
    pub bytes: Option<usize>,
    /// The chunks that the level needs.
    pub chunks: Option<usize>,
    /// Whether the stream ended before the level that was asked for.
    pub ended_early: Option<bool>,
}

impl Unpacked {
    /// Returns the counts for a report.
    pub fn report(&self) -> UnpackedReport {
        UnpackedReport {
            parts: Some(self.model.parts.len()),
            level: Some(self.level),
            levels: Some(self.full_level),
            triangles: Some(self.triangles),
            triangles_full: Some(self.full_triangles),
            surface_error: Some(self.error),
            bytes: Some(self.bytes),
            chunks: Some(self.chunks),
            ended_early: Some(self.problem.is_some()),
        }
    }
}

/// The bits of a component of a stream, and those per vertex of the full meshes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ComponentBits {
    /// What is stored.
    pub name: &'static str,
    /// The bits of all chunks.
    pub bits: f64,
    /// The same per vertex.
    pub per_vertex: f64,
}

/// What a stream holds; the keys are those of the JSON report of `tristrip inspect`. Counts are `None` before it is decoded.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct StreamReport {
    /// The meshes that are there.
    pub meshes: Option<usize>,
    /// The vertices of the full meshes.
    pub vertices: Option<usize>,
    /// The triangles of the full meshes.
    pub triangles: Option<usize>,
    /// The level of the full meshes.
    pub levels: Option<usize>,
    /// Bits of a coordinate of a position.
    pub position_bits: Option<u32>,
    /// The bytes before the first chunk.
    pub base_bytes: Option<usize>,
    /// The bytes of all chunks in the whole file.
    pub chunk_bytes: Option<usize>,
    /// The bits of the file per vertex.
    pub bits_per_vertex: Option<f64>,
    /// What the bits are spent on.
    pub components: Vec<ComponentBits>,
    /// The chunks that are there.
    pub chunks: Vec<ChunkFigures>,
}

impl StreamFigures {
    /// Returns what the stream holds for a report.
    pub fn report(&self) -> StreamReport {
        let per_vertex = |bits: f64| rounded(bits / self.vertices.max(1) as f64);
        let costs = self.costs;
        let parts = [
            ("file before the chunks", 8.0 * self.chunk_start as f64),
            ("base meshes", costs.base),
            ("marks", costs.marks),
            ("corners", costs.corners),
            ("positions", costs.positions),
            ("precision", costs.precision),
            ("attributes", costs.attributes),
        ];
        let decoded = self.chunks.last().map_or(0, |chunk| chunk.end.saturating_sub(self.chunk_start));
        let rest = 8.0 * decoded as f64 - parts[1..].iter().map(|(_, bits)| bits).sum::<f64>();
        let components = parts.into_iter().chain([("heads and rounding", rest)]);
        let component =
            |(name, bits): (_, f64)| ComponentBits { name, bits: bits.round(), per_vertex: per_vertex(bits) };
        StreamReport {
            meshes: Some(self.meshes),
            vertices: Some(self.vertices),
            triangles: Some(self.triangles),
            levels: Some(self.full_level),
            position_bits: Some(self.position_bits),
            base_bytes: Some(self.chunk_start),
            chunk_bytes: Some(self.chunk_bytes),
            bits_per_vertex: Some(per_vertex(8.0 * (self.chunk_start + self.chunk_bytes) as f64)),
            components: components.map(component).collect(),
            chunks: self.chunks.clone(),
        }
    }
}
