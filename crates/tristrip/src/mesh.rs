//! The mesh: positions, polygon faces and vertex attributes, validated once at creation.
//!
//! Faces are stored as one array of corners (vertex indices) with offsets, or without offsets if every face is a
//! triangle. After [`Mesh::new`] every index is in range and every coordinate is finite, so no later stage checks again.
//!
//! # Complexity
//! 12 bytes per vertex and 12 bytes per triangle; polygons take 4 bytes per corner and 4 per face.

mod attribute;
mod faces;
mod position_ids;
mod triangle;
mod vertex_subset;

pub use crate::ids::MAX_COUNT;
pub(crate) use attribute::select;
pub use attribute::{Attribute, AttributeData};
pub use faces::Faces;
pub(crate) use faces::without_repeats;
pub use position_ids::PositionIds;
pub use triangle::{canonical_triangle, is_degenerate};
pub(crate) use triangle::{canonical_triangles, triangle_at, triangles_of};
pub(crate) use vertex_subset::{SPARSE, VertexSubset, vertex_bound};

use std::sync::Arc;

use crate::error::{Error, MeshProblem};
use crate::ids::check_count;

/// A polygon mesh whose indices are in range and whose positions are finite. Clones share positions and attributes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    positions: Arc<Vec<[f32; 3]>>,
    faces: Faces,
    attributes: Arc<Vec<Attribute>>,
}

impl Mesh {
    /// Creates a mesh. Positions may be shared between meshes: pass a `Vec`, or an `Arc` of one.
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

    /// Creates a mesh of other faces over the same vertices, which are shared and not checked again.
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
    /// The attribute does not have one value per vertex.
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

    /// Returns the position of each vertex, in mesh units.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// Returns the positions for sharing with another mesh.
    pub fn shared_positions(&self) -> Arc<Vec<[f32; 3]>> {
        Arc::clone(&self.positions)
    }

    /// Returns whether positions and attributes are shared with another mesh, not only equal to its own.
    pub fn shares_vertices(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.positions, &other.positions) && Arc::ptr_eq(&self.attributes, &other.attributes)
    }

    /// Counts the vertices, whether or not a face uses them.
    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    /// Returns the faces.
    pub fn faces(&self) -> &Faces {
        &self.faces
    }

    /// Returns the vertex attributes other than the position.
    pub fn attributes(&self) -> &[Attribute] {
        &self.attributes
    }
}

/// Returns the bits of a vertex: its position and all attributes.
pub(crate) fn vertex_bits(mesh: &Mesh, v: usize) -> Vec<u8> {
    let mut key = Vec::new();
    mesh.positions()[v].iter().for_each(|x| key.extend(x.to_bits().to_le_bytes()));
    mesh.attributes().iter().for_each(|attribute| attribute.append_bits(v, &mut key));
    key
}

/// Returns the first corner that is out of range; the caller has checked that there is one.
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
        // An additional attribute belongs to this mesh only.
        let third = second.with_attribute(attribute("b")).unwrap();
        assert!(!third.shares_vertices(&first));
        assert_eq!((first.attributes().len(), third.attributes().len()), (1, 2));
    }
}
