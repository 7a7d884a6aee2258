//! Polygon faces of any size, with compact storage for triangles.

use std::borrow::Cow;

use super::triangle::{check_triangles, triangle_at};
use super::vertex_subset::{SPARSE, VertexSubset, vertex_bound};
use crate::error::{Error, MeshProblem};
use crate::ids::check_count;

/// Faces of any size. The order of the corners is the winding of a face.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Faces {
    corners: Vec<u32>,
    /// `face_count + 1` entries; `None` if every face is a triangle.
    offsets: Option<Vec<u32>>,
}

impl Faces {
    /// Creates triangles from a list of vertex indices, three per triangle.
    ///
    /// # Errors
    /// The number of indices is not a multiple of three, or there are too many for 32-bit indices.
    ///
    /// ```
    /// let faces = tristrip::Faces::from_triangles(vec![0, 1, 2, 2, 1, 3])?;
    /// assert_eq!(faces.face_count(), 2);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn from_triangles(corners: Vec<u32>) -> Result<Self, Error> {
        check_count("corners", corners.len())?;
        check_triangles(corners.len())?;
        Ok(Self { corners, offsets: None })
    }

    /// Creates polygons from all corners and the offset of each face's first corner. `offsets` has
    /// `face_count + 1` entries: it starts at 0, never decreases, and ends at the number of
    /// corners. Faces may have any size, including 0.
    ///
    /// # Errors
    /// The offsets do not match the corners, or the faces or their triangles have too many corners
    /// for 32-bit indices.
    ///
    /// ```
    /// let quad_and_triangle = tristrip::Faces::from_offsets(vec![0, 4, 7], vec![0, 1, 2, 3, 3, 2, 4])?;
    /// assert_eq!(quad_and_triangle.get(1), Some(&[3, 2, 4][..]));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn from_offsets(offsets: Vec<u32>, corners: Vec<u32>) -> Result<Self, Error> {
        check_count("corners", corners.len())?;
        check_count("faces", offsets.len())?;
        let good = offsets.first() == Some(&0)
            && offsets.last().is_some_and(|&end| end as usize == corners.len())
            && offsets.is_sorted();
        if !good {
            let expected = match offsets.last() {
                Some(end) => format!("{end}, the last of offsets that start at 0 and do not decrease"),
                None => "offsets that start at 0".into(),
            };
            return Err(MeshProblem::CornerCount { found: corners.len() as u64, expected }.into());
        }
        let faces = Self::from_valid_offsets(offsets, corners);
        // The triangles of a large polygon have up to three times as many corners as the polygon.
        check_count("corners of the triangles of the faces", faces.triangle_count().saturating_mul(3))?;
        Ok(faces)
    }

    /// Creates polygons like [`Faces::from_offsets`]. The offsets must match the corners.
    pub(crate) fn from_valid_offsets(offsets: Vec<u32>, corners: Vec<u32>) -> Self {
        let all_triangles = offsets.windows(2).all(|w| w[1] - w[0] == 3);
        Self { corners, offsets: (!all_triangles).then_some(offsets) }
    }

    /// Creates faces from a list of polygons.
    ///
    /// # Errors
    /// There are too many corners for 32-bit indices.
    ///
    /// ```
    /// let faces = tristrip::Faces::from_polygons([vec![0, 1, 2, 3], vec![3, 2, 4]])?;
    /// assert_eq!(faces.corner_count(), 7);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn from_polygons<P: AsRef<[u32]>>(polygons: impl IntoIterator<Item = P>) -> Result<Self, Error> {
        let mut offsets = vec![0];
        let mut corners = Vec::new();
        for polygon in polygons {
            corners.extend_from_slice(polygon.as_ref());
            check_count("corners", corners.len())?;
            offsets.push(corners.len() as u32);
        }
        Self::from_offsets(offsets, corners)
    }

    /// Counts the faces.
    ///
    /// ```
    /// let triangle_and_quad = tristrip::Faces::from_offsets(vec![0, 3, 7], vec![0, 1, 2, 2, 1, 3, 4])?;
    /// assert_eq!(triangle_and_quad.face_count(), 2);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn face_count(&self) -> usize {
        self.offsets.as_ref().map_or(self.corners.len() / 3, |offsets| offsets.len() - 1)
    }

    /// Counts the corners of all faces.
    ///
    /// ```
    /// let cube = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
    /// assert_eq!(tristrip::Faces::from_polygons(cube)?.corner_count(), 24);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn corner_count(&self) -> usize {
        self.corners.len()
    }

    /// Returns the vertex of every corner, face by face.
    ///
    /// ```
    /// let faces = tristrip::Faces::from_polygons([vec![0, 1, 2, 3], vec![3, 2, 4]])?;
    /// assert_eq!(faces.corners(), [0, 1, 2, 3, 3, 2, 4]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn corners(&self) -> &[u32] {
        &self.corners
    }

    /// Returns the range of a face's corners within [`Faces::corners`]. The face must exist.
    pub(crate) fn range(&self, face: usize) -> std::ops::Range<usize> {
        match &self.offsets {
            Some(offsets) => offsets[face] as usize..offsets[face + 1] as usize,
            None => 3 * face..3 * face + 3,
        }
    }

    /// Returns the vertices of a face in winding order, or `None` if there is no such face.
    ///
    /// ```
    /// let quad_and_triangle = tristrip::Faces::from_polygons([vec![0, 1, 2, 3], vec![3, 2, 4]])?;
    /// assert_eq!(quad_and_triangle.get(1), Some(&[3, 2, 4][..]));
    /// assert_eq!(quad_and_triangle.get(2), None);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn get(&self, face: usize) -> Option<&[u32]> {
        (face < self.face_count()).then(|| self.face(face))
    }

    /// Returns the vertices of a face in winding order. The face must exist.
    pub(crate) fn face(&self, face: usize) -> &[u32] {
        &self.corners[self.range(face)]
    }

    /// Returns the offset of each face's first corner and the end of the last face, or `None` if
    /// every face is a triangle.
    pub(crate) fn offsets(&self) -> Option<&[u32]> {
        self.offsets.as_deref()
    }

    /// Iterates over the faces in order.
    ///
    /// ```
    /// let faces = tristrip::Faces::from_polygons([vec![0, 1, 2, 3], vec![3, 2, 4]])?;
    /// assert_eq!(faces.iter().map(|face| face[0]).collect::<Vec<_>>(), [0, 3]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[u32]> + Clone {
        (0..self.face_count()).map(|face| self.face(face))
    }

    /// Returns the index buffer if every face is a triangle, otherwise `None`.
    ///
    /// ```
    /// use tristrip::Faces;
    /// let triangles = Faces::from_polygons([[0, 1, 2], [2, 1, 3]])?;
    /// assert_eq!(triangles.as_triangles(), Some(&[0, 1, 2, 2, 1, 3][..]));
    /// assert_eq!(Faces::from_polygons([[0, 1, 2, 3]])?.as_triangles(), None);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn as_triangles(&self) -> Option<&[u32]> {
        self.offsets.is_none().then_some(&self.corners)
    }

    /// Returns the triangles of the faces, three vertices each. A larger face becomes a fan around
    /// its first corner.
    ///
    /// ```
    /// let quad_and_triangle = tristrip::Faces::from_polygons([vec![0, 1, 2, 3], vec![3, 2, 4]])?;
    /// assert_eq!(*quad_and_triangle.fans(), [0, 1, 2, 0, 2, 3, 3, 2, 4]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn fans(&self) -> Cow<'_, [u32]> {
        if let Some(corners) = self.as_triangles() {
            return Cow::Borrowed(corners);
        }
        let fan = |face| (2..<[u32]>::len(face)).flat_map(move |i| [face[0], face[i - 1], face[i]]);
        self.iter().flat_map(fan).collect()
    }

    /// Returns faces of the same sizes with other vertices.
    ///
    /// # Errors
    /// The number of vertices differs from the number of corners.
    ///
    /// ```
    /// let faces = tristrip::Faces::from_polygons([vec![0, 1, 2, 3], vec![3, 2, 4]])?;
    /// let renamed = faces.with_corners(vec![4, 3, 2, 1, 1, 2, 0])?;
    /// assert_eq!(renamed.get(1), Some(&[1, 2, 0][..]));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn with_corners(&self, corners: Vec<u32>) -> Result<Self, Error> {
        if corners.len() != self.corners.len() {
            let (found, expected) = (corners.len() as u64, self.corners.len().to_string());
            return Err(MeshProblem::CornerCount { found, expected }.into());
        }
        Ok(self.renamed(corners))
    }

    /// Returns faces of the same sizes with other vertices. The number of corners must be the same.
    pub(crate) fn renamed(&self, corners: Vec<u32>) -> Self {
        debug_assert_eq!(corners.len(), self.corners.len());
        Self { corners, offsets: self.offsets.clone() }
    }

    /// Renumbers the vertices by a [`VertexSubset`] if the faces use few of the vertices up to the
    /// highest one; otherwise borrows the faces. The order of the faces stays the same. Later
    /// stages then need memory proportional to the corners instead of the highest vertex.
    pub(crate) fn compact(&self) -> Cow<'_, Self> {
        if vertex_bound(&self.corners).saturating_sub(1) / SPARSE < self.corners.len() {
            return Cow::Borrowed(self);
        }
        Cow::Owned(self.renamed(VertexSubset::of(&self.corners).numbers(&self.corners)))
    }

    /// Returns the same faces with the vertices numbered by first use, which places the vertices of
    /// nearby faces close together in memory. Allocates 4 bytes per vertex up to the highest one.
    pub(crate) fn in_order_of_use(&self) -> Self {
        let mut number = vec![0_u32; vertex_bound(&self.corners)]; // counted from 1
        let mut count = 0;
        let renumber = |&v: &u32| {
            let number = &mut number[v as usize];
            if *number == 0 {
                count += 1;
                *number = count;
            }
            *number - 1
        };
        Self { corners: self.corners.iter().map(renumber).collect(), offsets: self.offsets.clone() }
    }

    /// Returns the faces in another order: `order` contains their indices.
    pub(crate) fn in_order(&self, order: &[u32]) -> Self {
        let corners = match &self.offsets {
            None => order.iter().flat_map(|&face| triangle_at(&self.corners, face as usize)).collect(),
            Some(offsets) => {
                let range = |face: u32| offsets[face as usize] as usize..offsets[face as usize + 1] as usize;
                order.iter().flat_map(|&face| &self.corners[range(face)]).copied().collect()
            }
        };
        let offsets = self.offsets.as_ref().map(|offsets| {
            let mut end = 0;
            let size = |&face: &u32| offsets[face as usize + 1] - offsets[face as usize];
            let ends = order.iter().map(size).map(|size| {
                end += size;
                end
            });
            std::iter::once(0).chain(ends).collect()
        });
        Self { corners, offsets }
    }

    /// Counts the triangles of the faces. A face of k corners has k − 2 triangles.
    ///
    /// ```
    /// // An edge draws nothing.
    /// let faces = tristrip::Faces::from_polygons([vec![0, 1, 2, 3, 4], vec![4, 3, 5], vec![5, 6]])?;
    /// assert_eq!(faces.triangle_count(), 4);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn triangle_count(&self) -> usize {
        match &self.offsets {
            Some(offsets) => offsets.windows(2).map(|w| ((w[1] - w[0]) as usize).saturating_sub(2)).sum(),
            None => self.face_count(),
        }
    }
}

/// Copies a polygon without corners that repeat the previous one, cyclically.
pub(crate) fn without_repeats(face: &[u32], polygon: &mut Vec<u32>) {
    polygon.clear();
    polygon.extend_from_slice(face);
    polygon.dedup();
    while polygon.len() > 1 && polygon.first() == polygon.last() {
        polygon.pop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_given_as_polygons_are_triangles() {
        let faces = Faces::from_polygons([[0, 1, 2], [2, 1, 3]]).unwrap();
        assert_eq!(faces.as_triangles(), Some(&[0, 1, 2, 2, 1, 3][..]));
        let mixed = Faces::from_polygons([vec![0, 1], vec![0, 1, 2, 3, 4]]).unwrap();
        assert_eq!((mixed.triangle_count(), mixed.face_count()), (3, 2));
    }

    #[test]
    fn refuses_wrong_numbers_of_corners() {
        assert!(Faces::from_triangles(vec![0, 1]).is_err());
        assert!(Faces::from_offsets(vec![0, 4, 3], vec![0, 1, 2]).is_err());
        assert!(Faces::from_offsets(vec![], vec![]).is_err());
    }

    #[test]
    fn sparse_vertices_are_renumbered_in_order() {
        let sparse = Faces::from_polygons([vec![1000, 7, 900_000, 8], vec![8, 7, 1000]]).unwrap();
        let expected = Faces::from_polygons([vec![2, 0, 3, 1], vec![1, 0, 2]]).unwrap();
        assert_eq!(*sparse.compact(), expected);
        let dense = Faces::from_triangles(vec![0, 1, 47]).unwrap();
        assert!(matches!(dense.compact(), Cow::Borrowed(_)));
        assert!(matches!(Faces::from_triangles(vec![0, 1, 48]).unwrap().compact(), Cow::Owned(_)));
        assert_eq!(*Faces::default().compact(), Faces::default());
    }

    #[test]
    fn wrong_faces_and_corners_are_refused() {
        let triangles = Faces::from_triangles(vec![0, 1, u32::MAX]).unwrap();
        let mixed = Faces::from_polygons([vec![], vec![7], vec![0, 1, 2, u32::MAX]]).unwrap();
        for (faces, count) in [(&triangles, 1), (&mixed, 3), (&Faces::default(), 0)] {
            assert!((0..count).all(|face| faces.get(face).is_some()));
            assert_eq!([count, usize::MAX / 3, usize::MAX].map(|face| faces.get(face)), [None; 3]);
            assert!(faces.with_corners(vec![0; faces.corner_count() + 1]).is_err());
        }
        assert_eq!(*mixed.fans(), [0, 1, 2, 0, 2, u32::MAX]);
        assert!(Faces::from_offsets(vec![0, u32::MAX], vec![0, 1, 2]).is_err());
    }
}
