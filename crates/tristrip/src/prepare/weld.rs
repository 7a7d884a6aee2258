//! Welding: vertices with the same bits in position and all attributes are replaced by the first of them.

use rustc_hash::FxHashMap;

use crate::mesh::{Mesh, VertexSubset, vertex_bits};

/// The corners of a mesh's faces after welding.
pub(super) struct Welded {
    pub(super) corners: Vec<u32>,
    /// Number of vertices in use that were replaced by another one.
    pub(super) count: usize,
}

/// Replaces the vertex of each corner by the first vertex in use with the same bits.
pub(super) fn weld_corners(mesh: &Mesh) -> Welded {
    let corners = mesh.faces().corners();
    let subset = VertexSubset::of(corners);
    let mut first: FxHashMap<Vec<u8>, u32> = FxHashMap::default();
    let used = subset.vertices();
    let replacement: Vec<u32> =
        used.iter().map(|&v| *first.entry(vertex_bits(mesh, v as usize)).or_insert(v)).collect();
    let count = used.iter().zip(&replacement).filter(|(v, first)| v != first).count();
    let welded = corners.iter().map(|&v| replacement[subset.number(v) as usize]);
    Welded { corners: welded.collect(), count }
}
