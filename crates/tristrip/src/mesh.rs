//! The mesh: positions, polygon faces and vertex attributes, validated on creation.
//!
//! Faces are stored as one array of corners (vertex indices) with offsets, or without offsets if
//! every face is a triangle. After [`Mesh::new`] every index is in range and every coordinate is
//! finite, so later stages do not check again.
//!
//! # Complexity
//! 12 bytes per vertex and 12 bytes per triangle; polygons take 4 bytes per corner and 4 per face.

mod attribute;
mod faces;
mod near_positions;
mod position_ids;
mod positions;
mod triangle;
mod vertex_subset;
mod welds;

pub(crate) use attribute::select;
pub use attribute::{Attribute, AttributeData};
pub use faces::Faces;
pub(crate) use faces::without_repeats;
pub use near_positions::NearPositions;
pub use position_ids::PositionIds;
pub(crate) use positions::check_positions;
pub use positions::{InterleavedPositions, Positions};
pub(crate) use triangle::{
    canonical_triangle, canonical_triangles, check_corners, check_triangles, is_degenerate, triangle_at,
    triangles_of,
};
pub(crate) use vertex_subset::{SPARSE, VertexSubset, vertex_bound};
pub use welds::VertexWelds;

use std::sync::Arc;

use crate::error::{Error, MeshProblem};
use crate::ids::{check_count, index_out_of_range};

/// A polygon mesh whose indices are in range and whose positions are finite. Clones share positions
/// and attributes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    positions: Arc<Vec<[f32; 3]>>,
    faces: Faces,
    attributes: Arc<Vec<Attribute>>,
}

impl Mesh {
    /// Creates a mesh. Meshes can share positions: pass a `Vec` or an `Arc<Vec>`.
    ///
    /// # Errors
    /// An index is out of range, a coordinate is not finite, or there are too many vertices for
    /// 32-bit indices.
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

    /// Returns a mesh with other faces over the same vertices. The vertices are shared and not
    /// checked again.
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
        if faces.corners().iter().any(|&v| v >= vertex_count) {
            return Err(first_bad_index(&faces, vertex_count).into());
        }
        let (positions, attributes) = (Arc::clone(&self.positions), Arc::clone(&self.attributes));
        Ok(Self { positions, faces, attributes })
    }

    /// Adds a vertex attribute.
    ///
    /// # Errors
    /// The attribute does not have one value per vertex, or it has zero components.
    ///
    /// ```
    /// use tristrip::{Attribute, AttributeData, Faces, Mesh};
    /// let mesh = Mesh::new(vec![[0.0; 3]; 2], Faces::default())?;
    /// let data = AttributeData::U8(vec![10, 11, 20, 21]);
    /// let uv = Attribute { name: "TEXCOORD_0".into(), components: 2, normalized: true, data };
    /// assert_eq!(mesh.clone().with_attribute(uv.clone())?.attributes(), [uv.clone()]);
    /// assert!(mesh.with_attribute(Attribute { components: 4, ..uv }).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn with_attribute(mut self, attribute: Attribute) -> Result<Self, Error> {
        attribute.check(self.vertex_count())?;
        Arc::make_mut(&mut self.attributes).push(attribute);
        Ok(self)
    }

    /// Returns a mesh without faces that contains the given vertices and their attributes, in the
    /// order of `vertices`.
    ///
    /// # Errors
    /// A vertex is out of range, or there are too many vertices for 32-bit indices.
    ///
    /// ```
    /// use tristrip::{Faces, Mesh};
    /// let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let mesh = Mesh::new(positions, Faces::from_triangles(vec![0, 1, 2])?)?;
    /// let some = mesh.select_vertices(&[2, 0])?;
    /// assert_eq!(some.positions(), [[0.0, 1.0, 0.0], [0.0, 0.0, 0.0]]);
    /// assert!(some.faces().iter().len() == 0 && mesh.select_vertices(&[3]).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn select_vertices(&self, vertices: &[u32]) -> Result<Self, Error> {
        check_count("vertices", vertices.len())?;
        let vertex_count = self.vertex_count();
        if let Some(at) = vertices.iter().position(|&v| v as usize >= vertex_count) {
            return Err(index_out_of_range(at, vertices[at], vertex_count));
        }
        let attributes = self.attributes.iter().map(|attribute| attribute.select(vertices));
        Ok(Self {
            positions: Arc::new(select(&self.positions, 1, vertices)),
            faces: Faces::default(),
            attributes: Arc::new(attributes.collect()),
        })
    }

    /// Returns the mesh without the vertices that no face uses, and the old index of each remaining
    /// vertex in ascending order. Nothing is copied if all vertices are used.
    ///
    /// ```
    /// use tristrip::{Faces, Mesh};
    /// let positions = vec![[9.0; 3], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [9.0; 3], [0.0, 1.0, 0.0]];
    /// let mesh = Mesh::new(positions, Faces::from_triangles(vec![1, 2, 4])?)?;
    /// let (smaller, kept) = mesh.without_unused_vertices();
    /// assert_eq!((smaller.faces().corners(), &kept[..]), (&[0, 1, 2][..], &[1, 2, 4][..]));
    /// assert_eq!(smaller.positions()[2], [0.0, 1.0, 0.0]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn without_unused_vertices(&self) -> (Self, Vec<u32>) {
        let used = VertexSubset::of(self.faces.corners());
        if used.len() == self.vertex_count() {
            return (self.clone(), used.into_vertices());
        }
        let faces = self.faces.renamed(used.numbers(self.faces.corners()));
        let attributes = self.attributes.iter().map(|attribute| attribute.select(used.vertices()));
        let mesh = Self {
            positions: Arc::new(select(&self.positions, 1, used.vertices())),
            faces,
            attributes: Arc::new(attributes.collect()),
        };
        (mesh, used.into_vertices())
    }

    /// Returns the position of each vertex, in mesh units.
    ///
    /// ```
    #[doc = include_str!("mesh/example.txt")]
    /// let highest = mesh.positions().iter().map(|position| position[1]).fold(0.0, f32::max);
    /// assert_eq!(highest, 2.0);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// Returns the positions as a shared array, for use in another mesh.
    ///
    /// ```
    #[doc = include_str!("mesh/example.txt")]
    /// let back = Mesh::new(mesh.shared_positions(), Faces::from_triangles(vec![2, 1, 0])?)?;
    /// assert_eq!(back.positions().as_ptr(), mesh.positions().as_ptr());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn shared_positions(&self) -> Arc<Vec<[f32; 3]>> {
        Arc::clone(&self.positions)
    }

    /// Returns whether this mesh shares its positions and attributes with another one. Copies with
    /// equal values are not shared.
    ///
    /// ```
    #[doc = include_str!("mesh/example.txt")]
    /// let copy = Mesh::new(mesh.positions().to_vec(), mesh.faces().clone())?;
    /// assert!(mesh.clone().shares_vertices(&mesh));
    /// assert!(copy == mesh && !copy.shares_vertices(&mesh));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn shares_vertices(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.positions, &other.positions) && Arc::ptr_eq(&self.attributes, &other.attributes)
    }

    /// Counts the vertices, including unused ones.
    ///
    /// ```
    #[doc = include_str!("mesh/example.txt")]
    /// assert_eq!(mesh.with_faces(Faces::from_triangles(vec![0, 1, 2])?)?.vertex_count(), 5);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    /// Returns the faces.
    ///
    /// ```
    #[doc = include_str!("mesh/example.txt")]
    /// let sizes: Vec<usize> = mesh.faces().iter().map(|face| face.len()).collect();
    /// assert_eq!(sizes, [4, 3]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn faces(&self) -> &Faces {
        &self.faces
    }

    /// Returns the vertex attributes other than the position.
    ///
    /// ```
    #[doc = include_str!("mesh/example.txt")]
    /// let data = AttributeData::U8(vec![0, 50, 100, 150, 200]);
    /// let shade = Attribute { name: "shade".into(), components: 1, normalized: true, data };
    /// let mesh = mesh.with_attribute(shade)?;
    /// assert_eq!(mesh.attributes()[0].of_vertices(&[4])?.data, AttributeData::U8(vec![200]));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn attributes(&self) -> &[Attribute] {
        &self.attributes
    }
}

/// Returns the bits of a vertex: its position and all attributes.
pub(crate) fn vertex_bits(mesh: &Mesh, v: usize) -> Vec<u8> {
    let mut key = attribute_bits(mesh, v);
    mesh.positions()[v].iter().for_each(|x| key.extend(x.to_bits().to_le_bytes()));
    key
}

/// Returns the bits of the attributes of a vertex.
pub(crate) fn attribute_bits(mesh: &Mesh, v: usize) -> Vec<u8> {
    let mut key = Vec::new();
    mesh.attributes().iter().for_each(|attribute| attribute.append_bits(v, &mut key));
    key
}

/// Returns the first corner that is out of range. The caller has checked that there is one.
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
    fn refuses_invalid_meshes_with_the_location() {
        let p = vec![[0.0; 3]; 3];
        let message = |r: Result<Mesh, Error>| r.unwrap_err().to_string();
        let faces = Faces::from_triangles(vec![0, 1, 2, 0, 7, 1]).unwrap();
        assert_eq!(
            message(Mesh::new(p, faces)),
            "face 1, corner 1: found vertex index 7, expected less than 3"
        );
        let nan = vec![[0.0; 3], [0.0, f32::NAN, 0.0]];
        assert_eq!(
            message(Mesh::new(nan, Faces::default())),
            "vertex 1: found coordinate NaN, expected a finite number"
        );
    }

    #[test]
    fn other_faces_share_vertices_and_are_checked() {
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
        // An attribute added later belongs only to the mesh it was added to.
        let third = second.with_attribute(attribute("b")).unwrap();
        assert!(!third.shares_vertices(&first));
        assert_eq!((first.attributes().len(), third.attributes().len()), (1, 2));
    }
}
