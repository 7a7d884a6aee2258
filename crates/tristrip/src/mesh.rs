//! The mesh: positions, polygon faces and vertex attributes, checked once when it is made.
//!
//! Faces are stored as one array of corners (vertex indices) with offsets, or without offsets where every face is a
//! triangle. After [`Mesh::new`] every index is in range and every coordinate is finite, so that no later stage checks again.
//!
//! # Complexity
//! 12 bytes a vertex and 12 bytes a triangle; polygons take 4 bytes a corner and 4 a face.

mod position_ids;
mod triangle;

pub use position_ids::PositionIds;
pub use triangle::{canonical_triangle, is_degenerate};
pub(crate) use triangle::{triangle_at, triangles_of};

use std::borrow::Cow;
use std::sync::Arc;

use crate::error::{Error, MeshProblem};

/// The largest number of vertices, faces or corners: ids are 32 bits wide, and the highest one stays free.
pub const MAX_COUNT: usize = (u32::MAX - 1) as usize;

/// Vertices for each corner from which on the used ones are numbered anew before arrays are made for them: thousands of
/// parts may share one long list of vertices.
pub(crate) const SPARSE: usize = 16;

/// Faces of any size, as corners in order; a face's winding is the order of its corners.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Faces {
    corners: Vec<u32>,
    /// `face_count + 1` entries; `None` where every face is a triangle.
    offsets: Option<Vec<u32>>,
}

impl Faces {
    /// Makes triangles from three indices each.
    ///
    /// # Errors
    /// The number of indices is not a multiple of three, or too large for 32-bit ids.
    ///
    /// ```
    /// let faces = tristrip::Faces::from_triangles(vec![0, 1, 2, 2, 1, 3])?;
    /// assert_eq!(faces.face_count(), 2);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn from_triangles(corners: Vec<u32>) -> Result<Self, Error> {
        check_count("corners", corners.len())?;
        if !corners.len().is_multiple_of(3) {
            let found = corners.len() as u64;
            return Err(MeshProblem::CornerCount { found, expected: "a multiple of 3".into() }.into());
        }
        Ok(Self { corners, offsets: None })
    }

    /// Makes polygons from all corners and the offset of each face's first one; `offsets` has one entry more than there are
    /// faces, starts at 0, never falls and ends at the number of corners. Faces may have any size, also 0.
    ///
    /// # Errors
    /// The offsets do not describe the corners, or these or those of the triangles that they make are too many for 32-bit ids.
    ///
    /// ```
    /// let quad_and_triangle = tristrip::Faces::from_offsets(vec![0, 4, 7], vec![0, 1, 2, 3, 3, 2, 4])?;
    /// assert_eq!(quad_and_triangle.face(1), [3, 2, 4]);
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
                Some(end) => format!("{end}, by offsets that start at 0 and never fall"),
                None => "offsets that start at 0".into(),
            };
            return Err(MeshProblem::CornerCount { found: corners.len() as u64, expected }.into());
        }
        let all_triangles = offsets.windows(2).all(|w| w[1] - w[0] == 3);
        let faces = Self { corners, offsets: (!all_triangles).then_some(offsets) };
        // Large polygons have up to three times their own corners once they are cut.
        check_count(
            "corners of the triangles that the faces make",
            faces.triangle_count().saturating_mul(3),
        )?;
        Ok(faces)
    }

    /// Makes polygons from a list of them.
    ///
    /// # Errors
    /// There are more corners than 32-bit ids can name.
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
    pub fn face_count(&self) -> usize {
        self.offsets.as_ref().map_or(self.corners.len() / 3, |offsets| offsets.len() - 1)
    }

    /// Counts the corners of all faces.
    pub fn corner_count(&self) -> usize {
        self.corners.len()
    }

    /// Gives the vertex of every corner, face after face.
    pub fn corners(&self) -> &[u32] {
        &self.corners
    }

    /// Gives the range of a face's corners within [`Faces::corners`].
    ///
    /// # Panics
    /// `face` is not less than [`Faces::face_count`].
    pub fn range(&self, face: usize) -> std::ops::Range<usize> {
        match &self.offsets {
            Some(offsets) => offsets[face] as usize..offsets[face + 1] as usize,
            None => 3 * face..3 * face + 3,
        }
    }

    /// Gives the vertices of a face in its winding.
    ///
    /// # Panics
    /// `face` is not less than [`Faces::face_count`].
    pub fn face(&self, face: usize) -> &[u32] {
        &self.corners[self.range(face)]
    }

    /// Walks over the faces in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[u32]> + Clone {
        (0..self.face_count()).map(|face| self.face(face))
    }

    /// Gives the index buffer where every face is a triangle.
    pub fn as_triangles(&self) -> Option<&[u32]> {
        self.offsets.is_none().then_some(&self.corners)
    }

    /// Gives faces of the same sizes with other corners.
    ///
    /// # Errors
    /// There is not the same number of corners.
    ///
    /// ```
    /// let faces = tristrip::Faces::from_polygons([vec![0, 1, 2, 3], vec![3, 2, 4]])?;
    /// let turned = faces.with_corners(vec![4, 3, 2, 1, 1, 2, 0])?;
    /// assert_eq!(turned.face(1), [1, 2, 0]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn with_corners(&self, corners: Vec<u32>) -> Result<Self, Error> {
        if corners.len() != self.corners.len() {
            let (found, expected) = (corners.len() as u64, self.corners.len().to_string());
            return Err(MeshProblem::CornerCount { found, expected }.into());
        }
        Ok(self.renamed(corners))
    }

    /// Returns faces of the same sizes with as many other corners.
    pub(crate) fn renamed(&self, corners: Vec<u32>) -> Self {
        debug_assert_eq!(corners.len(), self.corners.len());
        Self { corners, offsets: self.offsets.clone() }
    }

    /// Gives the same faces over the vertices that they use, in the same order, where those are few among the numbers up
    /// to the highest; else the faces as they are. So what takes memory by the highest vertex takes it by the corners.
    pub(crate) fn compact(&self) -> Cow<'_, Self> {
        let highest = self.corners.iter().max().map_or(0, |&v| v as usize);
        if highest / SPARSE < self.corners.len() {
            return Cow::Borrowed(self);
        }
        let mut used = self.corners.clone();
        used.sort_unstable();
        used.dedup();
        let place = |&v: &u32| used.partition_point(|&u| u < v) as u32;
        Cow::Owned(Self { corners: self.corners.iter().map(place).collect(), offsets: self.offsets.clone() })
    }

    /// Gives the same faces with vertices numbered in the order in which the corners first use them: what is near in the faces
    /// is then near in memory. Takes memory by the highest vertex.
    pub(crate) fn in_order_of_use(&self) -> Self {
        let highest = self.corners.iter().max().map_or(0, |&v| v as usize);
        let mut number = vec![0_u32; highest + 1]; // counted from 1
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

    /// Counts the triangles that the faces make: a face of k corners makes k − 2.
    pub fn triangle_count(&self) -> usize {
        match &self.offsets {
            Some(offsets) => offsets.windows(2).map(|w| ((w[1] - w[0]) as usize).saturating_sub(2)).sum(),
            None => self.face_count(),
        }
    }
}

/// Values of one vertex attribute, `components` of them for each vertex.
#[derive(Debug, Clone, PartialEq)]
pub enum AttributeData {
    /// 32-bit floats.
    F32(Vec<f32>),
    /// 64-bit floats.
    F64(Vec<f64>),
    /// Unsigned bytes.
    U8(Vec<u8>),
    /// Signed bytes.
    I8(Vec<i8>),
    /// Unsigned 16-bit integers.
    U16(Vec<u16>),
    /// Signed 16-bit integers.
    I16(Vec<i16>),
    /// Unsigned 32-bit integers.
    U32(Vec<u32>),
    /// Signed 32-bit integers.
    I32(Vec<i32>),
}

impl AttributeData {
    /// Counts the values, over all vertices and components.
    pub fn len(&self) -> usize {
        match self {
            Self::F32(v) => v.len(),
            Self::F64(v) => v.len(),
            Self::U8(v) => v.len(),
            Self::I8(v) => v.len(),
            Self::U16(v) => v.len(),
            Self::I16(v) => v.len(),
            Self::U32(v) => v.len(),
            Self::I32(v) => v.len(),
        }
    }

    /// Tells whether there is no value.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// One value, of one or more components, for each vertex.
#[derive(Debug, Clone, PartialEq)]
pub struct Attribute {
    /// The name in glTF's words where it has one there (`NORMAL`, `TEXCOORD_0`, `COLOR_0`), else as the file has it.
    pub name: String,
    /// Values for each vertex, at least 1.
    pub components: u8,
    /// Whether integers stand for fractions of their range.
    pub normalized: bool,
    /// The values, vertex after vertex.
    pub data: AttributeData,
}

impl Attribute {
    /// Gives the values of some vertices, in their order.
    ///
    /// # Panics
    /// There is no such vertex.
    ///
    /// ```
    /// use tristrip::{Attribute, AttributeData};
    /// let data = AttributeData::U8(vec![0, 1, 10, 11, 20, 21]);
    /// let pairs = Attribute { name: "pairs".into(), components: 2, normalized: false, data };
    /// assert_eq!(pairs.of_vertices(&[2, 0]).data, AttributeData::U8(vec![20, 21, 0, 1]));
    /// ```
    #[must_use]
    pub fn of_vertices(&self, vertices: &[u32]) -> Self {
        let n = usize::from(self.components.max(1));
        let data = match &self.data {
            AttributeData::F32(values) => AttributeData::F32(taken(values, n, vertices)),
            AttributeData::F64(values) => AttributeData::F64(taken(values, n, vertices)),
            AttributeData::U8(values) => AttributeData::U8(taken(values, n, vertices)),
            AttributeData::I8(values) => AttributeData::I8(taken(values, n, vertices)),
            AttributeData::U16(values) => AttributeData::U16(taken(values, n, vertices)),
            AttributeData::I16(values) => AttributeData::I16(taken(values, n, vertices)),
            AttributeData::U32(values) => AttributeData::U32(taken(values, n, vertices)),
            AttributeData::I32(values) => AttributeData::I32(taken(values, n, vertices)),
        };
        Self { name: self.name.clone(), data, ..*self }
    }
}

/// Gives the values of some vertices, `components` each.
fn taken<T: Copy>(values: &[T], components: usize, vertices: &[u32]) -> Vec<T> {
    let of = |&v: &u32| values[v as usize * components..][..components].iter().copied();
    vertices.iter().flat_map(of).collect()
}

/// Gives the bits of a vertex: its position and all attributes.
pub(crate) fn vertex_bits(mesh: &Mesh, v: usize) -> Vec<u8> {
    let mut key = Vec::new();
    mesh.positions()[v].iter().for_each(|x| key.extend(x.to_bits().to_le_bytes()));
    for attribute in mesh.attributes() {
        let n = usize::from(attribute.components.max(1));
        let range = v * n..(v + 1) * n;
        match &attribute.data {
            AttributeData::F32(d) => d[range].iter().for_each(|x| key.extend(x.to_bits().to_le_bytes())),
            AttributeData::F64(d) => d[range].iter().for_each(|x| key.extend(x.to_bits().to_le_bytes())),
            AttributeData::U8(d) => key.extend(&d[range]),
            AttributeData::I8(d) => d[range].iter().for_each(|x| key.extend(x.to_le_bytes())),
            AttributeData::U16(d) => d[range].iter().for_each(|x| key.extend(x.to_le_bytes())),
            AttributeData::I16(d) => d[range].iter().for_each(|x| key.extend(x.to_le_bytes())),
            AttributeData::U32(d) => d[range].iter().for_each(|x| key.extend(x.to_le_bytes())),
            AttributeData::I32(d) => d[range].iter().for_each(|x| key.extend(x.to_le_bytes())),
        }
    }
    key
}

/// A polygon mesh whose indices are in range and whose positions are finite. Clones share positions and attributes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    positions: Arc<Vec<[f32; 3]>>,
    faces: Faces,
    attributes: Arc<Vec<Attribute>>,
}

impl Mesh {
    /// Makes a mesh. Positions may be shared between meshes: pass a `Vec`, or an `Arc` of one.
    ///
    /// # Errors
    /// An index is out of range, a coordinate is not finite, or there are too many vertices for 32-bit ids.
    ///
    /// ```
    /// use tristrip::{Faces, Mesh};
    /// let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let mesh = Mesh::new(positions, Faces::from_triangles(vec![0, 1, 2])?)?;
    /// assert_eq!((mesh.vertex_count(), mesh.faces().face_count()), (3, 1));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn new(positions: impl Into<Arc<Vec<[f32; 3]>>>, faces: Faces) -> Result<Self, Error> {
        let positions = positions.into();
        check_count("vertices", positions.len())?;
        if let Some((vertex, p)) =
            positions.iter().enumerate().find(|(_, p)| !p.iter().all(|x| x.is_finite()))
        {
            let found = p.iter().copied().find(|x| !x.is_finite()).unwrap_or(f32::NAN);
            return Err(MeshProblem::NotFinite { vertex: vertex as u32, found }.into());
        }
        Self { positions, faces: Faces::default(), attributes: Arc::default() }.with_faces(faces)
    }

    /// Makes a mesh of other faces over the same vertices, which are shared and not checked again.
    ///
    /// # Errors
    /// An index is out of range.
    ///
    /// ```
    /// use tristrip::{Faces, Mesh};
    /// let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let front = Mesh::new(positions, Faces::from_triangles(vec![0, 1, 2])?)?;
    /// let back = front.with_faces(Faces::from_triangles(vec![2, 1, 0])?)?;
    /// assert!(back.shares_vertices(&front));
    /// assert!(front.with_faces(Faces::from_triangles(vec![2, 1, 3])?).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn with_faces(&self, faces: Faces) -> Result<Self, Error> {
        let vertex_count = self.positions.len() as u32;
        if faces.corners.iter().any(|&v| v >= vertex_count) {
            return Err(first_bad_index(&faces, vertex_count).into());
        }
        let (positions, attributes) = (Arc::clone(&self.positions), Arc::clone(&self.attributes));
        Ok(Self { positions, faces, attributes })
    }

    /// Adds a vertex attribute.
    ///
    /// # Errors
    /// The attribute has not one value for each vertex.
    pub fn with_attribute(mut self, attribute: Attribute) -> Result<Self, Error> {
        let components = usize::from(attribute.components.max(1));
        let expected = self.positions.len() * components;
        if attribute.data.len() != expected {
            return Err(MeshProblem::AttributeLength {
                name: attribute.name,
                found: (attribute.data.len() / components) as u64,
                expected: self.positions.len() as u64,
            }
            .into());
        }
        Arc::make_mut(&mut self.attributes).push(attribute);
        Ok(self)
    }

    /// Gives the position of each vertex, in mesh units.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// Gives the positions for sharing with another mesh.
    pub fn shared_positions(&self) -> Arc<Vec<[f32; 3]>> {
        Arc::clone(&self.positions)
    }

    /// Tells whether positions and attributes are the very ones of another mesh, not only equal to them.
    pub fn shares_vertices(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.positions, &other.positions) && Arc::ptr_eq(&self.attributes, &other.attributes)
    }

    /// Counts the vertices, used by a face or not.
    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    /// Gives the faces.
    pub fn faces(&self) -> &Faces {
        &self.faces
    }

    /// Gives the vertex attributes other than the position.
    pub fn attributes(&self) -> &[Attribute] {
        &self.attributes
    }
}

fn check_count(what: &'static str, found: usize) -> Result<(), Error> {
    if found > MAX_COUNT {
        return Err(Error::LimitExceeded { what, found: found as u64, limit: MAX_COUNT as u64 });
    }
    Ok(())
}

/// Names the first corner that is out of range; the caller has seen that there is one.
fn first_bad_index(faces: &Faces, vertex_count: u32) -> MeshProblem {
    let (mut face, mut corner, mut found) = (0, 0, u32::MAX);
    'search: for (f, polygon) in faces.iter().enumerate() {
        for (c, &v) in polygon.iter().enumerate() {
            if v >= vertex_count {
                (face, corner, found) = (f as u32, c as u32, v);
                break 'search;
            }
        }
    }
    MeshProblem::VertexIndex { face, corner, found, vertex_count }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_bad_meshes_and_says_where() {
        let p = vec![[0.0; 3]; 3];
        let say = |r: Result<Mesh, Error>| r.unwrap_err().to_string();
        let faces = Faces::from_triangles(vec![0, 1, 2, 0, 7, 1]).unwrap();
        assert_eq!(say(Mesh::new(p, faces)), "face 1, corner 1: found vertex index 7, expected less than 3");
        let nan = vec![[0.0; 3], [0.0, f32::NAN, 0.0]];
        assert_eq!(
            say(Mesh::new(nan, Faces::default())),
            "vertex 1: found coordinate NaN, expected a finite number"
        );
        assert!(Faces::from_triangles(vec![0, 1]).is_err());
        assert!(Faces::from_offsets(vec![0, 4, 3], vec![0, 1, 2]).is_err());
        assert!(Faces::from_offsets(vec![], vec![]).is_err());
    }

    #[test]
    fn triangles_given_as_polygons_are_triangles() {
        let faces = Faces::from_polygons([[0, 1, 2], [2, 1, 3]]).unwrap();
        assert_eq!(faces.as_triangles(), Some(&[0, 1, 2, 2, 1, 3][..]));
        let mixed = Faces::from_polygons([vec![0, 1], vec![0, 1, 2, 3, 4]]).unwrap();
        assert_eq!((mixed.triangle_count(), mixed.face_count()), (3, 2));
    }

    #[test]
    fn other_faces_share_vertices_and_have_their_own_check() {
        let attribute = |name: &str| Attribute {
            name: name.into(),
            components: 1,
            normalized: false,
            data: AttributeData::U8(vec![7; 3]),
        };
        let first = Mesh::new(vec![[0.0; 3]; 3], Faces::from_triangles(vec![0, 1, 2]).unwrap()).unwrap();
        let first = first.with_attribute(attribute("a")).unwrap();
        let second = first.with_faces(Faces::from_triangles(vec![2, 1, 0]).unwrap()).unwrap();
        assert!(std::ptr::eq(first.positions(), second.positions()));
        assert!(std::ptr::eq(first.attributes(), second.attributes()));
        let wrong = first.with_faces(Faces::from_triangles(vec![0, 1, 3]).unwrap()).unwrap_err();
        assert_eq!(wrong.to_string(), "face 0, corner 2: found vertex index 3, expected less than 3");
        // An attribute more is this mesh's own.
        let third = second.with_attribute(attribute("b")).unwrap();
        assert!(!third.shares_vertices(&first));
        assert_eq!((first.attributes().len(), third.attributes().len()), (1, 2));
    }

    #[test]
    fn few_vertices_of_many_are_numbered_anew_in_order() {
        let sparse = Faces::from_polygons([vec![1000, 7, 900_000, 8], vec![8, 7, 1000]]).unwrap();
        let expected = Faces::from_polygons([vec![2, 0, 3, 1], vec![1, 0, 2]]).unwrap();
        assert_eq!(*sparse.compact(), expected);
        let dense = Faces::from_triangles(vec![0, 1, 47]).unwrap();
        assert!(matches!(dense.compact(), Cow::Borrowed(_)));
        assert!(matches!(Faces::from_triangles(vec![0, 1, 48]).unwrap().compact(), Cow::Owned(_)));
        assert_eq!(*Faces::default().compact(), Faces::default());
    }
}
