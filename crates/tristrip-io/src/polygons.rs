//! Collects the faces of a file corner by corner. A list of triangles needs no offsets.

use tristrip::Faces;

use crate::error::Error;

/// Faces under construction.
#[derive(Debug, Default)]
pub(crate) struct Polygons {
    corners: Vec<u32>,
    face_count: usize,
    /// As in [`Faces`]; created at the end of the first face that is not a triangle.
    offsets: Option<Vec<u32>>,
}

impl Polygons {
    /// Reserves capacity for corners. The caller has checked that the file can contain them.
    pub(crate) fn with_capacity(corner_count: usize) -> Self {
        Self { corners: Vec::with_capacity(corner_count), ..Self::default() }
    }

    /// Reserves capacity for more corners. The caller has checked that the file can contain them.
    pub(crate) fn reserve(&mut self, corner_count: usize) {
        self.corners.reserve(corner_count);
    }

    /// Adds a corner to the current face.
    pub(crate) fn push(&mut self, vertex: u32) {
        self.corners.push(vertex);
    }

    /// Adds corners to the current face.
    pub(crate) fn extend(&mut self, vertices: impl Iterator<Item = u32>) {
        self.corners.extend(vertices);
    }

    /// Ends the current face.
    pub(crate) fn end_face(&mut self) {
        let end = self.corners.len();
        self.face_count += 1;
        if self.offsets.is_none() && end != 3 * self.face_count {
            self.offsets = Some((0..self.face_count).map(|face| (3 * face) as u32).collect());
        }
        if let Some(offsets) = &mut self.offsets {
            offsets.push(end as u32);
        }
    }

    /// Adds a face.
    pub(crate) fn push_face(&mut self, face: &[u32]) {
        self.corners.extend_from_slice(face);
        self.end_face();
    }

    /// Adds triangles.
    pub(crate) fn push_triangles(&mut self, triangles: impl ExactSizeIterator<Item = [u32; 3]>) {
        if self.offsets.is_some() {
            return triangles.for_each(|triangle| self.push_face(&triangle));
        }
        self.corners.reserve(3 * triangles.len());
        self.face_count += triangles.len();
        triangles.for_each(|triangle| self.corners.extend_from_slice(&triangle));
    }

    /// Returns the number of faces.
    pub(crate) fn face_count(&self) -> usize {
        self.face_count
    }

    /// Returns the range of a face's corners.
    pub(crate) fn range(&self, face: usize) -> std::ops::Range<usize> {
        match &self.offsets {
            Some(offsets) => offsets[face] as usize..offsets[face + 1] as usize,
            None => 3 * face..3 * face + 3,
        }
    }

    /// Returns the vertex of every corner.
    pub(crate) fn corners(&self) -> &[u32] {
        &self.corners
    }

    /// Returns the faces.
    pub(crate) fn finish(self) -> Result<Faces, Error> {
        Ok(match self.offsets {
            Some(offsets) => Faces::from_offsets(offsets, self.corners)?,
            None => Faces::from_triangles(self.corners)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_polygon_builds_the_offsets() {
        let mut polygons = Polygons::default();
        polygons.push_face(&[0, 1, 2]);
        polygons.push_face(&[2, 1, 3]);
        assert!(polygons.offsets.is_none());
        polygons.push_face(&[0, 1]);
        polygons.push_face(&[0, 1, 2, 3]);
        assert_eq!(polygons.range(2), 6..8);
        polygons.push_triangles([[4, 5, 6], [6, 5, 7]].into_iter());
        let faces = polygons.finish().unwrap();
        let sizes: Vec<usize> = faces.iter().map(<[u32]>::len).collect();
        assert_eq!(sizes, [3, 3, 2, 4, 3, 3]);
        let mut triangles = Polygons::default();
        triangles.push_triangles([[0, 1, 2], [2, 1, 3]].into_iter());
        triangles.push_face(&[3, 1, 4]);
        assert_eq!(triangles.finish().unwrap().as_triangles(), Some(&[0, 1, 2, 2, 1, 3, 3, 1, 4][..]));
        assert_eq!(Polygons::default().finish().unwrap().face_count(), 0);
    }
}
