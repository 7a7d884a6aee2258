//! Vertex numbering by first use: vertices are numbered in the order in which an index buffer uses
//! them. Vertex fetches are then sequential.
//!
//! ```text
//! indices          7 2 9 2 4         new_to_old   7 2 9 4   0 1 3 5 6 8
//! after            0 1 2 1 3                      used      unused
//! ```
//! Renumbering changes neither triangles nor vertex-cache hits. Unused vertices come last, in their
//! old order. No vertex is dropped, so every order has an inverse.
//!
//! # Complexity
//! O(n) time and 8 bytes per vertex.

use super::Strips;
use crate::error::{Error, MeshProblem};
use crate::ids::{OptionalId, check_count, index_out_of_range};
use crate::mesh::{Attribute, Faces, Mesh, select};

/// A renumbering of the vertices of one array, in both directions.
///
/// ```
/// use tristrip::{Strips, VertexOrder};
/// let mut strips = Strips::default();
/// strips.push(&[4, 2, 3]);
/// let order = VertexOrder::of_strips(5, [&strips])?;
/// assert_eq!(order.new_to_old(), [4, 2, 3, 0, 1]);
/// assert_eq!(order.old_to_new(), [3, 4, 1, 2, 0]);
/// assert_eq!(order.strips(&strips)?.vertices(), [0, 1, 2]);
/// assert_eq!(order.values(&['a', 'b', 'c', 'd', 'e'], 1)?, ['e', 'c', 'd', 'a', 'b']);
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct VertexOrder {
    new_to_old: Vec<u32>,
    old_to_new: Vec<u32>,
}

impl VertexOrder {
    /// Creates the identity order.
    ///
    /// # Errors
    /// There are too many vertices for 32-bit indices.
    ///
    /// ```
    /// assert_eq!(tristrip::VertexOrder::identity(3)?.new_to_old(), [0, 1, 2]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn identity(vertex_count: usize) -> Result<Self, Error> {
        Self::of_indices(vertex_count, [])
    }

    /// Numbers the vertices 0 to `vertex_count` − 1 by first use in the strips, in drawing order.
    /// The strips of several parts over the same vertices share one order.
    ///
    /// # Errors
    /// A strip refers to a vertex that is out of range, or there are too many vertices for 32-bit
    /// indices.
    ///
    /// ```
    /// use tristrip::{Strips, VertexOrder};
    /// let (mut roof, mut wall) = (Strips::default(), Strips::default());
    /// roof.push(&[5, 4, 3]);
    /// wall.push(&[3, 4, 0]);
    /// assert_eq!(VertexOrder::of_strips(6, [&roof, &wall])?.new_to_old(), [5, 4, 3, 0, 1, 2]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn of_strips<'a>(
        vertex_count: usize,
        strips: impl IntoIterator<Item = &'a Strips>,
    ) -> Result<Self, Error> {
        Self::of_indices(
            vertex_count,
            strips.into_iter().flat_map(|strips| strips.vertices().iter().copied()),
        )
    }

    /// Numbers the vertices 0 to `vertex_count` − 1 by first use in an index buffer without restart
    /// indices.
    ///
    /// # Errors
    /// An index is out of range, or there are too many vertices for 32-bit indices.
    ///
    /// ```
    /// let order = tristrip::VertexOrder::of_indices(4, [2, 2, 3, 0])?;
    /// assert_eq!(order.new_to_old(), [2, 3, 0, 1]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn of_indices(vertex_count: usize, indices: impl IntoIterator<Item = u32>) -> Result<Self, Error> {
        check_count("vertices", vertex_count)?;
        let mut numbers = vec![OptionalId::NONE; vertex_count];
        let mut new_to_old = Vec::with_capacity(vertex_count);
        for (at, vertex) in indices.into_iter().enumerate() {
            let Some(new) = numbers.get_mut(vertex as usize) else {
                return Err(index_out_of_range(at, vertex, vertex_count));
            };
            if new.is_none() {
                *new = OptionalId::some(new_to_old.len() as u32);
                new_to_old.push(vertex);
            }
        }
        let old_to_new = (0..).zip(numbers).map(|(vertex, new)| {
            new.get().unwrap_or_else(|| {
                new_to_old.push(vertex);
                new_to_old.len() as u32 - 1
            })
        });
        let old_to_new = old_to_new.collect();
        Ok(Self { new_to_old, old_to_new })
    }

    /// Creates an order from the old index of each new vertex.
    ///
    /// # Errors
    /// The indices are not a permutation of 0, 1, 2 …, or there are too many vertices for 32-bit
    /// indices.
    ///
    /// ```
    /// use tristrip::VertexOrder;
    /// assert_eq!(VertexOrder::from_new_to_old(&[2, 0, 1])?.old_to_new(), [1, 2, 0]);
    /// assert!(VertexOrder::from_new_to_old(&[2, 0, 2]).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn from_new_to_old(new_to_old: &[u32]) -> Result<Self, Error> {
        let order = Self::of_indices(new_to_old.len(), new_to_old.iter().copied())?;
        if let Some(at) = (0..new_to_old.len()).find(|&i| order.new_to_old[i] != new_to_old[i]) {
            let found = format!("vertex {} again at index {at}", new_to_old[at]);
            return Err(Error::Parameter {
                name: "new_to_old",
                found,
                expected: "every vertex exactly once",
            });
        }
        Ok(order)
    }

    /// Returns the old index of each new vertex.
    ///
    /// ```
    /// let order = tristrip::VertexOrder::of_indices(4, [3, 1, 2])?;
    /// let old = ["a", "b", "c", "d"];
    /// let new: Vec<&str> = order.new_to_old().iter().map(|&vertex| old[vertex as usize]).collect();
    /// assert_eq!(new, ["d", "b", "c", "a"]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn new_to_old(&self) -> &[u32] {
        &self.new_to_old
    }

    /// Returns the new index of each old vertex.
    ///
    /// ```
    /// let order = tristrip::VertexOrder::of_indices(4, [3, 1, 2])?;
    /// // Vertex 3 is used first, vertex 0 never.
    /// assert_eq!(order.old_to_new(), [3, 1, 2, 0]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn old_to_new(&self) -> &[u32] {
        &self.old_to_new
    }

    /// Counts the vertices, including unused ones.
    ///
    /// ```
    /// let order = tristrip::VertexOrder::of_indices(100, [40, 41, 42])?;
    /// assert_eq!(order.vertex_count(), 100);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn vertex_count(&self) -> usize {
        self.new_to_old.len()
    }

    /// Counts the vertices whose index changes.
    ///
    /// ```
    /// let order = tristrip::VertexOrder::of_indices(4, [0, 3])?;
    /// assert_eq!(order.moved_count(), 3);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn moved_count(&self) -> usize {
        (0..).zip(&self.new_to_old).filter(|&(new, &old)| new != old).count()
    }

    /// Returns the inverse order.
    ///
    /// ```
    /// let order = tristrip::VertexOrder::of_indices(4, [2, 3, 0])?;
    /// let ordered = order.values(&[10, 11, 12, 13], 1)?;
    /// assert_eq!(order.inverse().values(&ordered, 1)?, [10, 11, 12, 13]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    #[must_use]
    pub fn inverse(&self) -> Self {
        Self { new_to_old: self.old_to_new.clone(), old_to_new: self.new_to_old.clone() }
    }

    /// Returns whether both directions are permutations and each is the inverse of the other.
    ///
    /// ```
    /// use tristrip::VertexOrder;
    /// let order = VertexOrder::of_indices(4, [2, 2, 0])?;
    /// assert!(order.check() && order.inverse().check());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn check(&self) -> bool {
        let undone = |new: u32, old: u32| self.old_to_new.get(old as usize) == Some(&new);
        self.new_to_old.len() == self.old_to_new.len()
            && (0..).zip(&self.new_to_old).all(|(new, &old)| undone(new, old))
    }

    /// Reorders values from the old vertex order to the new one. `values` has `components` values
    /// per vertex.
    ///
    /// # Errors
    /// The length of `values` is not `components` times the number of vertices.
    ///
    /// ```
    /// let order = tristrip::VertexOrder::of_indices(3, [2])?;
    /// assert_eq!(order.values(&[0, 1, 10, 11, 20, 21], 2)?, [20, 21, 0, 1, 10, 11]);
    /// assert!(order.values(&[0, 1, 10, 11], 2).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn values<T: Copy>(&self, values: &[T], components: usize) -> Result<Vec<T>, Error> {
        if Some(values.len()) != self.vertex_count().checked_mul(components) {
            let found = (values.len() / components.max(1)) as u64;
            let expected = self.vertex_count() as u64;
            return Err(MeshProblem::AttributeLength { name: "values".into(), found, expected }.into());
        }
        Ok(select(values, components, &self.new_to_old))
    }

    /// Reorders the values of an attribute.
    ///
    /// # Errors
    /// The attribute does not have one value per vertex.
    ///
    /// ```
    /// use tristrip::{Attribute, AttributeData, VertexOrder};
    /// let data = AttributeData::U8(vec![10, 11, 20, 21]);
    /// let uv = Attribute { name: "TEXCOORD_0".into(), components: 2, normalized: true, data };
    /// let moved = VertexOrder::of_indices(2, [1])?.attribute(&uv)?;
    /// assert_eq!(moved.data, AttributeData::U8(vec![20, 21, 10, 11]));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn attribute(&self, attribute: &Attribute) -> Result<Attribute, Error> {
        attribute.check(self.vertex_count())?;
        Ok(attribute.select(&self.new_to_old))
    }

    /// Returns the new index of each given index.
    ///
    /// # Errors
    /// An index is out of range.
    ///
    /// ```
    /// let order = tristrip::VertexOrder::of_indices(3, [2])?;
    /// assert_eq!(order.indices(&[2, 2, 0])?, [0, 0, 1]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn indices(&self, indices: &[u32]) -> Result<Vec<u32>, Error> {
        let new = |(at, &vertex): (usize, &u32)| {
            let new = self.old_to_new.get(vertex as usize).copied();
            new.ok_or_else(|| index_out_of_range(at, vertex, self.vertex_count()))
        };
        indices.iter().enumerate().map(new).collect()
    }

    /// Returns the strips with the new vertex indices.
    ///
    /// # Errors
    /// A strip refers to a vertex that is out of range.
    ///
    /// ```
    /// use tristrip::{Strips, VertexOrder};
    /// let strips = Strips::from_parts(vec![7, 3, 9, 9, 3, 4], vec![3, 6])?;
    /// let ordered = VertexOrder::of_strips(10, [&strips])?.strips(&strips)?;
    /// assert_eq!(ordered.iter().collect::<Vec<_>>(), [[0, 1, 2], [2, 1, 3]]);
    /// assert!(VertexOrder::identity(5)?.strips(&strips).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn strips(&self, strips: &Strips) -> Result<Strips, Error> {
        let welds = strips.welds().renumbered(|vertex| self.indices(&[vertex]).map(|new| new[0]))?;
        Ok(Strips { vertices: self.indices(&strips.vertices)?, welds, ..strips.clone() })
    }

    /// Returns the faces in the same order, with the new vertex indices.
    ///
    /// # Errors
    /// A face refers to a vertex that is out of range.
    ///
    /// ```
    /// use tristrip::{Faces, VertexOrder};
    /// let square = Faces::from_polygons([[3, 0, 1, 2]])?;
    /// let order = VertexOrder::of_indices(4, [3, 0])?;
    /// assert_eq!(order.faces(&square)?.get(0), Some(&[0, 1, 2, 3][..]));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn faces(&self, faces: &Faces) -> Result<Faces, Error> {
        faces.with_corners(self.indices(faces.corners())?)
    }

    /// Returns the mesh with positions, attributes and faces in the new vertex order.
    ///
    /// # Errors
    /// The mesh has a different number of vertices.
    ///
    /// ```
    /// use tristrip::{Faces, Mesh, VertexOrder};
    /// let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let mesh = Mesh::new(positions, Faces::from_triangles(vec![2, 0, 1])?)?;
    /// let order = VertexOrder::of_indices(3, [2, 0, 1])?;
    /// let ordered = order.mesh(&mesh)?;
    /// assert_eq!(ordered.faces().corners(), [0, 1, 2]);
    /// assert_eq!(order.inverse().mesh(&ordered)?, mesh);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn mesh(&self, mesh: &Mesh) -> Result<Mesh, Error> {
        if mesh.vertex_count() != self.vertex_count() {
            let (found, expected) = (mesh.vertex_count() as u64, self.vertex_count() as u64);
            return Err(MeshProblem::AttributeLength { name: "positions".into(), found, expected }.into());
        }
        mesh.select_vertices(&self.new_to_old)?.with_faces(self.faces(mesh.faces())?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ids::MAX_COUNT;
    use crate::mesh::AttributeData;
    use crate::strip::Metrics;
    use crate::verify::verify;
    use crate::vertex_cache::{FlushPolicy, VertexCache, VertexCacheStatistics};
    use proptest::prelude::*;
    use std::collections::BTreeMap;

    /// Strips over a few of `vertex_count` vertices.
    fn some_strips(vertex_count: u32) -> impl Strategy<Value = Strips> {
        let strip = prop::collection::vec(0..vertex_count, 0..9);
        prop::collection::vec(strip, 0..12).prop_map(|all| {
            let mut strips = Strips::default();
            all.iter().for_each(|strip| strips.push(strip));
            strips
        })
    }

    /// Computes the order from a table of first positions: used vertices by position, then the
    /// others.
    fn naive(vertex_count: usize, indices: &[u32]) -> Vec<u32> {
        let mut first: BTreeMap<u32, usize> = BTreeMap::new();
        for at in (0..indices.len()).rev() {
            first.insert(indices[at], at);
        }
        let mut all: Vec<u32> = (0..vertex_count as u32).collect();
        all.sort_by_key(|v| first.get(v).copied().unwrap_or(usize::MAX));
        all
    }

    proptest! {
        #[test]
        fn numbers_increase_by_first_use(strips in some_strips(40), others in some_strips(40)) {
            let both = [strips.vertices(), others.vertices()].concat();
            let order = VertexOrder::of_strips(40, [&strips, &others]).unwrap();
            prop_assert!(order.check());
            prop_assert_eq!(order.new_to_old(), naive(40, &both));
            // In the new numbering, each first use is the next index.
            let mut next = 0;
            for new in order.indices(&both).unwrap() {
                prop_assert!(new <= next);
                next = next.max(new + 1);
            }
            // Unused vertices follow in their old order.
            prop_assert!(order.new_to_old()[next as usize..].is_sorted());
            // Indices in order of first use stay the same.
            let again = VertexOrder::of_indices(40, order.indices(&both).unwrap()).unwrap();
            prop_assert_eq!(again.moved_count(), 0);
        }

        #[test]
        fn the_inverse_undoes_an_order(
            strips in some_strips(30),
            values in prop::collection::vec(any::<u16>(), 90),
            corners in prop::collection::vec(0..30_u32, 60),
        ) {
            let order = VertexOrder::of_strips(30, [&strips]).unwrap();
            let back = order.inverse();
            prop_assert!(back.check());
            prop_assert_eq!(&back.inverse(), &order);
            prop_assert_eq!(back.strips(&order.strips(&strips).unwrap()).unwrap(), strips);
            let attribute = Attribute {
                name: "id".into(), components: 3, normalized: true, data: AttributeData::U16(values),
            };
            let positions = (0..30_u8).map(|v| [f32::from(v); 3]).collect::<Vec<_>>();
            let polygons = [&corners[..4], &corners[4..7], &corners[7..7], &corners[7..]];
            let mesh = Mesh::new(positions, Faces::from_polygons(polygons).unwrap()).unwrap();
            let mesh = mesh.with_attribute(attribute).unwrap();
            let ordered = order.mesh(&mesh).unwrap();
            prop_assert_eq!(&back.mesh(&ordered).unwrap(), &mesh);
            for (new, &old) in order.new_to_old().iter().enumerate() {
                prop_assert_eq!(ordered.positions()[new].map(f32::to_bits), mesh.positions()[old as usize].map(f32::to_bits));
            }
            prop_assert_eq!(VertexOrder::from_new_to_old(order.new_to_old()).unwrap(), order);
        }

        #[test]
        fn drawing_and_cost_stay_the_same(strips in some_strips(20), entries in 3..20_u32) {
            let positions = vec![[0.0; 3]; 20];
            let mesh = Mesh::new(positions, Faces::from_triangles(strips.to_list()).unwrap()).unwrap();
            let order = VertexOrder::of_strips(20, [&strips]).unwrap();
            let (ordered_mesh, ordered) = (order.mesh(&mesh).unwrap(), order.strips(&strips).unwrap());
            prop_assert!(verify(&ordered_mesh, &ordered).is_ok());
            let misses = |strips| VertexCacheStatistics::of(strips, VertexCache::fifo(entries), FlushPolicy::Keep);
            prop_assert_eq!(misses(&ordered), misses(&strips));
            let (a, b) = (Metrics::of(&strips), Metrics::of(&ordered));
            prop_assert_eq!((a.vertices_sent, a.swaps, a.indices_restart), (b.vertices_sent, b.swaps, b.indices_restart));
        }
    }

    #[test]
    fn refuses_values_and_indices_that_do_not_match() {
        let order = VertexOrder::of_indices(3, [2]).unwrap();
        let message = |error: Error| error.to_string();
        assert_eq!(
            message(VertexOrder::of_indices(3, [0, 3]).unwrap_err()),
            "parameter `indices`: found index 3 at 1, over 3 vertices, expected less than the number of vertices"
        );
        assert!(
            message(VertexOrder::from_new_to_old(&[1, 1]).unwrap_err()).contains("vertex 1 again at index 1")
        );
        assert!(VertexOrder::from_new_to_old(&[1, 2]).is_err());
        assert!(order.values(&[0; 4], 1).is_err() && order.values(&[0; 3], 0).is_err());
        assert!(order.indices(&[3]).is_err());
        let attribute = Attribute {
            name: "id".into(),
            components: 1,
            normalized: false,
            data: AttributeData::U8(vec![1]),
        };
        assert_eq!(
            message(order.attribute(&attribute).unwrap_err()),
            "attribute `id`: number of values: found 1, expected 3 (one per vertex)"
        );
        assert!(order.mesh(&Mesh::default()).is_err());
        let wrong = VertexOrder { new_to_old: vec![0, 0], old_to_new: vec![0, 0] };
        assert!(!wrong.check());
        assert_eq!(VertexOrder::identity(0).unwrap(), VertexOrder::default());
        assert!(VertexOrder::identity(MAX_COUNT + 1).is_err());
    }
}
