//! Corner access for triangles and polygons, and the edge counts that use it.

use crate::csr::Csr;
use crate::mesh::{Faces, vertex_bound};

/// Returns the first corner of each face followed by the end of the last face, and the face of each
/// corner.
pub(super) fn polygon_shape(faces: &Faces) -> (Vec<u32>, Vec<u32>) {
    let mut offsets = Vec::with_capacity(faces.face_count() + 1);
    let mut face_of = Vec::with_capacity(faces.corner_count());
    offsets.push(0);
    for (face, polygon) in faces.iter().enumerate() {
        face_of.resize(face_of.len() + polygon.len(), face as u32);
        offsets.push(face_of.len() as u32);
    }
    (offsets, face_of)
}

/// The corners of faces of one shape. The functions are inlined because they are called for every
/// half-edge.
pub(super) trait FaceCorners: Sync {
    /// Whether faces may have more than three corners.
    const LARGER: bool;
    fn vertices(&self) -> &[u32];
    /// Returns the next corner of the face.
    fn next(&self, corner: usize) -> usize;
    /// Returns the previous corner of the face.
    fn previous(&self, corner: usize) -> usize;
    fn face(&self, corner: usize) -> usize;
}

pub(super) struct TriangleCorners<'a> {
    pub(super) corners: &'a [u32],
}

impl FaceCorners for TriangleCorners<'_> {
    const LARGER: bool = false;
    #[inline]
    fn vertices(&self) -> &[u32] {
        self.corners
    }
    #[inline]
    fn next(&self, corner: usize) -> usize {
        if corner % 3 == 2 { corner - 2 } else { corner + 1 }
    }
    #[inline]
    fn previous(&self, corner: usize) -> usize {
        if corner.is_multiple_of(3) { corner + 2 } else { corner - 1 }
    }
    #[inline]
    fn face(&self, corner: usize) -> usize {
        corner / 3
    }
}

pub(super) struct PolygonCorners<'a> {
    pub(super) corners: &'a [u32],
    pub(super) offsets: &'a [u32],
    pub(super) face_of: &'a [u32],
}

impl FaceCorners for PolygonCorners<'_> {
    const LARGER: bool = true;
    #[inline]
    fn vertices(&self) -> &[u32] {
        self.corners
    }
    #[inline]
    fn next(&self, corner: usize) -> usize {
        let face = self.face_of[corner] as usize;
        if corner + 1 == self.offsets[face + 1] as usize { self.offsets[face] as usize } else { corner + 1 }
    }
    #[inline]
    fn previous(&self, corner: usize) -> usize {
        let face = self.face_of[corner] as usize;
        if corner == self.offsets[face] as usize { self.offsets[face + 1] as usize - 1 } else { corner - 1 }
    }
    #[inline]
    fn face(&self, corner: usize) -> usize {
        self.face_of[corner] as usize
    }
}

/// Counts the half-edges over each edge of the faces. Calls `edge` once per edge, in order of the
/// vertices, with the number of forward half-edges (from the lower vertex to the higher one) and of
/// backward half-edges.
///
/// A counting sort groups the half-edges by their lower vertex. The groups are small and sorted by
/// comparison.
pub(crate) fn for_each_edge(faces: &Faces, edge: impl FnMut(usize, usize)) {
    if faces.as_triangles().is_some() {
        return count_edges(&TriangleCorners { corners: faces.corners() }, edge);
    }
    let (offsets, face_of) = polygon_shape(faces);
    count_edges(&PolygonCorners { corners: faces.corners(), offsets: &offsets, face_of: &face_of }, edge);
}

fn count_edges(corners: &impl FaceCorners, mut edge: impl FnMut(usize, usize)) {
    let vertices = corners.vertices();
    let vertex_count = vertex_bound(vertices);
    let to = |h: usize| vertices[corners.next(h)];
    let lows = vertices.iter().enumerate().map(|(h, &from)| from.min(to(h)));
    let by_low = Csr::group(lows, vertex_count);
    let mut here: Vec<(u32, bool)> = Vec::new();
    for (low, half_edges) in (0_u32..).zip(by_low.rows()) {
        here.clear();
        here.extend(half_edges.iter().filter_map(|&h| {
            let (from, to) = (vertices[h as usize], to(h as usize));
            (from != to).then_some((from.max(to), from == low))
        }));
        here.sort_unstable();
        for group in here.chunk_by(|a, b| a.0 == b.0) {
            let forward = group.iter().filter(|&&(_, forward)| forward).count();
            edge(forward, group.len() - forward);
        }
    }
}
