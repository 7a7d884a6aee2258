//! Numbers the vertices of several meshes by position, to compare what two files draw.
//!
//! Vertices get the same number if their positions have the same bits; −0.0 equals 0.0. Other
//! attributes are ignored.
//!
//! # Complexity
//! O(n) time, where n is the number of corners. About 40 bytes per position in use, and 4 bytes per
//! vertex unless the faces use few of them. Positions that several meshes share are numbered once.

use std::collections::HashMap;

use super::vertex_subset::SPARSE;
use super::{Faces, Mesh, Positions};
use crate::error::Error;
use crate::ids::{OptionalId, check_count};

/// Numbers of positions, in order of first occurrence. The numbers do not depend on the hash
/// function, whose random seed protects against files with colliding positions.
///
/// ```
/// use tristrip::{Faces, Mesh, PositionIds};
/// let triangle = Faces::from_triangles(vec![0, 1, 2])?;
/// let a = Mesh::new(vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], triangle.clone())?;
/// let b = Mesh::new(vec![[0.0, 1.0, 0.0], [-0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], triangle)?;
/// let mut ids = PositionIds::default();
/// assert_eq!(ids.faces(&[&a])?.corners(), [0, 1, 2]);
/// assert_eq!(ids.faces(&[&b])?.corners(), [2, 0, 1]);
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Default)]
pub struct PositionIds {
    id_of: HashMap<[u32; 3], u32>,
    positions: Vec<[f32; 3]>,
}

impl PositionIds {
    /// Returns the faces of all meshes, in order, with position numbers as vertices.
    ///
    /// # Errors
    /// The meshes together have too many corners, faces or positions for 32-bit indices.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// // Vertex 4 of another mesh has the position of vertex 0 of this one.
    /// let last = Mesh::new(vec![mesh.positions()[0]; 5], Faces::from_polygons([[4]])?)?;
    /// let faces = PositionIds::default().faces(&[&mesh, &last])?;
    /// assert_eq!(faces.iter().collect::<Vec<_>>(), [&[0, 1, 2, 3][..], &[3, 2, 4], &[0]]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn faces(&mut self, meshes: &[&Mesh]) -> Result<Faces, Error> {
        // The numbers of the vertices used so far, by the address of the positions.
        let mut known: HashMap<usize, Vec<OptionalId>> = HashMap::new();
        let corner_count = meshes.iter().map(|m| m.faces().corner_count()).sum();
        let mut corners = Vec::with_capacity(corner_count);
        for mesh in meshes {
            let positions = mesh.positions();
            let (address, vertex_count) = (positions.as_ptr().addr(), mesh.vertex_count());
            let known = known.entry(address).or_insert_with(|| unknown_numbers(vertex_count, corner_count));
            let all = mesh.faces().corners().iter();
            corners.extend(all.map(|&v| self.number_of_vertex(positions, v, known)));
            check_count("positions", self.positions.len())?;
        }
        if meshes.iter().all(|m| m.faces().as_triangles().is_some()) {
            return Faces::from_triangles(corners);
        }
        check_count("corners", corners.len())?;
        let mut end = 0;
        let sizes = meshes.iter().flat_map(|m| m.faces().iter().map(<[u32]>::len));
        let ends = sizes.map(|size| {
            end += size as u32;
            end
        });
        let offsets = std::iter::once(0).chain(ends).collect();
        Faces::from_offsets(offsets, corners)
    }

    /// Returns the position with this number in mesh units, or `None` if there is no such number.
    ///
    /// ```
    /// assert_eq!(tristrip::PositionIds::default().position(0), None);
    /// ```
    pub fn position(&self, id: u32) -> Option<[f32; 3]> {
        self.positions.get(id as usize).copied()
    }

    /// Returns the position with this number. The number must exist.
    pub(crate) fn position_of(&self, id: u32) -> [f32; 3] {
        self.positions[id as usize]
    }

    /// Returns the number of the position of each corner. The corners must be vertices of
    /// `positions`.
    pub(crate) fn numbers<P: Positions + ?Sized>(&mut self, positions: &P, corners: &[u32]) -> Vec<u32> {
        let mut known = unknown_numbers(positions.vertex_count(), corners.len());
        // A surface has about half as many points as triangles.
        self.id_of.reserve(positions.vertex_count().min(corners.len() / 6));
        corners.iter().map(|&v| self.number_of_vertex(positions, v, &mut known)).collect()
    }

    /// Returns the number of a vertex's position. Uses `known` unless it is empty.
    #[inline]
    fn number_of_vertex<P: Positions + ?Sized>(
        &mut self,
        positions: &P,
        v: u32,
        known: &mut [OptionalId],
    ) -> u32 {
        let slot = known.get_mut(v as usize);
        if let Some(number) = slot.as_ref().and_then(|slot| slot.get()) {
            return number;
        }
        let number = self.number(positions.position(v as usize).unwrap_or_default());
        if let Some(slot) = slot {
            *slot = OptionalId::some(number);
        }
        number
    }

    fn number(&mut self, position: [f32; 3]) -> u32 {
        // Adding 0.0 turns −0.0 into 0.0 and does not change any other finite number.
        let position = position.map(|x| x + 0.0);
        let next = self.positions.len() as u32;
        let id = *self.id_of.entry(position.map(f32::to_bits)).or_insert(next);
        if id == next {
            self.positions.push(position);
        }
        id
    }
}

/// Returns a list for the numbers of all vertices, or an empty one if the corners use few of the
/// vertices.
fn unknown_numbers(vertex_count: usize, corner_count: usize) -> Vec<OptionalId> {
    if vertex_count / SPARSE > corner_count { Vec::new() } else { vec![OptionalId::NONE; vertex_count] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    #[test]
    fn concatenates_faces_of_any_size_over_shared_positions() {
        let square = Arc::new(vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
        let quad = Mesh::new(Arc::clone(&square), Faces::from_polygons([[0, 1, 2, 3]]).unwrap()).unwrap();
        let triangle = Mesh::new(Arc::clone(&square), Faces::from_triangles(vec![3, 2, 1]).unwrap()).unwrap();
        let far = Mesh::new(vec![[9.0; 3]; 3], Faces::from_triangles(vec![0, 1, 2]).unwrap()).unwrap();
        let mut ids = PositionIds::default();
        let faces = ids.faces(&[&quad, &far, &triangle]).unwrap();
        assert_eq!(faces.iter().collect::<Vec<_>>(), [&[0, 1, 2, 3][..], &[4, 4, 4], &[3, 2, 1]]);
        assert_eq!(ids.position_of(4).map(f32::to_bits), [9.0_f32.to_bits(); 3]);
        assert_eq!(ids.faces(&[]).unwrap().face_count(), 0);
    }

    #[test]
    fn wrong_numbers_have_no_position() {
        let mut ids = PositionIds::default();
        assert_eq!(ids.position(0), None);
        ids.faces(&[&Mesh::new(vec![[9.0; 3]; 3], Faces::from_triangles(vec![0, 1, 2]).unwrap()).unwrap()])
            .unwrap();
        assert!(ids.position(0).is_some());
        assert_eq!([1, u32::MAX].map(|id| ids.position(id)), [None; 2]);
    }
}
