//! The order of first use: vertices numbered as an index buffer meets them, so that they are fetched from memory one after the
//! other.
//!
//! ```text
//! indices          7 2 9 2 4         new_to_old   7 2 9 4   0 1 3 5 6 8
//! after            0 1 2 1 3                      in use    in use by nobody
//! ```
//! The triangles stay as they are, and so does whatever a vertex buffer holds: only the numbers are others. Vertices that no
//! index names come last, in their old order; none is lost, so that every order has an inverse.
//!
//! # Complexity
//! Linear time; 8 bytes a vertex.

use super::Strips;
use crate::error::{Error, MeshProblem};
use crate::mesh::{Attribute, AttributeData, Faces, MAX_COUNT, Mesh};

/// Stands for "no number yet"; no vertex has it, as there are at most [`MAX_COUNT`].
const NONE: u32 = u32::MAX;

/// A new numbering of the vertices of one vertex buffer, and the way back.
///
/// ```
/// use tristrip::{Strips, strip::VertexOrder};
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
    /// Leaves every vertex its number.
    ///
    /// # Errors
    /// There are more vertices than 32-bit ids can name.
    ///
    /// ```
    /// assert_eq!(tristrip::strip::VertexOrder::identity(3)?.new_to_old(), [0, 1, 2]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn identity(vertex_count: usize) -> Result<Self, Error> {
        Self::of_indices(vertex_count, [])
    }

    /// Numbers vertices 0 to `vertex_count` − 1 by their first use in the strips, one strip after the other, as they are drawn. Strips
    /// of several parts over the same vertices share one order.
    ///
    /// # Errors
    /// A strip has a vertex that is not less than `vertex_count`, or there are more vertices than 32-bit ids can name.
    ///
    /// ```
    /// use tristrip::{Strips, strip::VertexOrder};
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

    /// Numbers vertices 0 to `vertex_count` − 1 by their first use in an index buffer, which has no restart index.
    ///
    /// # Errors
    /// An index is not less than `vertex_count`, or there are more vertices than 32-bit ids can name.
    ///
    /// ```
    /// let order = tristrip::strip::VertexOrder::of_indices(4, [2, 2, 3, 0])?;
    /// assert_eq!(order.new_to_old(), [2, 3, 0, 1]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn of_indices(vertex_count: usize, indices: impl IntoIterator<Item = u32>) -> Result<Self, Error> {
        if vertex_count > MAX_COUNT {
            let (what, found) = ("vertices", vertex_count as u64);
            return Err(Error::LimitExceeded { what, found, limit: MAX_COUNT as u64 });
        }
        let mut old_to_new = vec![NONE; vertex_count];
        let mut new_to_old = Vec::with_capacity(vertex_count);
        for (at, vertex) in indices.into_iter().enumerate() {
            let Some(new) = old_to_new.get_mut(vertex as usize) else {
                return Err(out_of_range(at, vertex, vertex_count));
            };
            if *new == NONE {
                *new = new_to_old.len() as u32;
                new_to_old.push(vertex);
            }
        }
        for (vertex, new) in (0..).zip(&mut old_to_new).filter(|(_, new)| **new == NONE) {
            *new = new_to_old.len() as u32;
            new_to_old.push(vertex);
        }
        Ok(Self { new_to_old, old_to_new })
    }

    /// Takes an order from elsewhere: for each new number the old one.
    ///
    /// # Errors
    /// Not every number below the length stands there once, or there are more vertices than 32-bit ids can name.
    ///
    /// ```
    /// use tristrip::strip::VertexOrder;
    /// assert_eq!(VertexOrder::from_new_to_old(&[2, 0, 1])?.old_to_new(), [1, 2, 0]);
    /// assert!(VertexOrder::from_new_to_old(&[2, 0, 2]).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn from_new_to_old(new_to_old: &[u32]) -> Result<Self, Error> {
        let order = Self::of_indices(new_to_old.len(), new_to_old.iter().copied())?;
        if let Some(place) = (0..new_to_old.len()).find(|&i| order.new_to_old[i] != new_to_old[i]) {
            let found = format!("vertex {} a second time, at {place}", new_to_old[place]);
            return Err(Error::Parameter { name: "new_to_old", found, expected: "every vertex once" });
        }
        Ok(order)
    }

    /// Gives for each new number the old one.
    pub fn new_to_old(&self) -> &[u32] {
        &self.new_to_old
    }

    /// Gives for each old number the new one.
    pub fn old_to_new(&self) -> &[u32] {
        &self.old_to_new
    }

    /// Counts the vertices, in use or not.
    pub fn vertex_count(&self) -> usize {
        self.new_to_old.len()
    }

    /// Counts the vertices whose number is another one.
    ///
    /// ```
    /// let order = tristrip::strip::VertexOrder::of_indices(4, [0, 3])?;
    /// assert_eq!(order.moved_count(), 3);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn moved_count(&self) -> usize {
        (0..).zip(&self.new_to_old).filter(|&(new, &old)| new != old).count()
    }

    /// Gives the way back: what one order does, its inverse undoes.
    ///
    /// ```
    /// let order = tristrip::strip::VertexOrder::of_indices(4, [2, 3, 0])?;
    /// let there = order.values(&[10, 11, 12, 13], 1)?;
    /// assert_eq!(order.inverse().values(&there, 1)?, [10, 11, 12, 13]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    #[must_use]
    pub fn inverse(&self) -> Self {
        Self { new_to_old: self.old_to_new.clone(), old_to_new: self.new_to_old.clone() }
    }

    /// Tells whether both directions name every vertex once and undo each other.
    pub fn check(&self) -> bool {
        let undone = |new: u32, old: u32| self.old_to_new.get(old as usize) == Some(&new);
        self.new_to_old.len() == self.old_to_new.len()
            && (0..).zip(&self.new_to_old).all(|(new, &old)| undone(new, old))
    }

    /// Puts values that stand in the old order into the new one, `components` of them for each vertex.
    ///
    /// # Errors
    /// There are not `components` values for each vertex.
    ///
    /// ```
    /// let order = tristrip::strip::VertexOrder::of_indices(3, [2])?;
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
        if components == 1 {
            return Ok(self.new_to_old.iter().map(|&old| values[old as usize]).collect());
        }
        let mut out = Vec::with_capacity(values.len());
        for &old in &self.new_to_old {
            let first = old as usize * components;
            out.extend_from_slice(&values[first..first + components]);
        }
        Ok(out)
    }

    /// Puts the values of an attribute into the new order.
    ///
    /// # Errors
    /// The attribute has not one value for each vertex.
    ///
    /// ```
    /// use tristrip::{Attribute, AttributeData, strip::VertexOrder};
    /// let data = AttributeData::U8(vec![10, 11, 20, 21]);
    /// let uv = Attribute { name: "TEXCOORD_0".into(), components: 2, normalized: true, data };
    /// let moved = VertexOrder::of_indices(2, [1])?.attribute(&uv)?;
    /// assert_eq!(moved.data, AttributeData::U8(vec![20, 21, 10, 11]));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn attribute(&self, attribute: &Attribute) -> Result<Attribute, Error> {
        let n = usize::from(attribute.components.max(1));
        let data = match &attribute.data {
            AttributeData::F32(v) => self.values(v, n).map(AttributeData::F32),
            AttributeData::F64(v) => self.values(v, n).map(AttributeData::F64),
            AttributeData::U8(v) => self.values(v, n).map(AttributeData::U8),
            AttributeData::I8(v) => self.values(v, n).map(AttributeData::I8),
            AttributeData::U16(v) => self.values(v, n).map(AttributeData::U16),
            AttributeData::I16(v) => self.values(v, n).map(AttributeData::I16),
            AttributeData::U32(v) => self.values(v, n).map(AttributeData::U32),
            AttributeData::I32(v) => self.values(v, n).map(AttributeData::I32),
        };
        let data = data.map_err(|error| match error {
            Error::Mesh(MeshProblem::AttributeLength { found, expected, .. }) => {
                let name = attribute.name.clone();
                MeshProblem::AttributeLength { name, found, expected }.into()
            }
            other => other,
        })?;
        Ok(Attribute { data, name: attribute.name.clone(), ..*attribute })
    }

    /// Writes the new number for each index.
    ///
    /// # Errors
    /// An index is not less than the number of vertices.
    ///
    /// ```
    /// let order = tristrip::strip::VertexOrder::of_indices(3, [2])?;
    /// assert_eq!(order.indices(&[2, 2, 0])?, [0, 0, 1]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn indices(&self, indices: &[u32]) -> Result<Vec<u32>, Error> {
        let new = |(at, &vertex): (usize, &u32)| {
            let new = self.old_to_new.get(vertex as usize).copied();
            new.ok_or_else(|| out_of_range(at, vertex, self.vertex_count()))
        };
        indices.iter().enumerate().map(new).collect()
    }

    /// Gives the same strips over the new numbers.
    ///
    /// # Errors
    /// A strip has a vertex that is not less than the number of vertices.
    pub fn strips(&self, strips: &Strips) -> Result<Strips, Error> {
        Ok(Strips { vertices: self.indices(&strips.vertices)?, ..strips.clone() })
    }

    /// Gives the same faces, in their order, over the new numbers.
    ///
    /// # Errors
    /// A face has a vertex that is not less than the number of vertices.
    ///
    /// ```
    /// use tristrip::{Faces, strip::VertexOrder};
    /// let square = Faces::from_polygons([[3, 0, 1, 2]])?;
    /// let order = VertexOrder::of_indices(4, [3, 0])?;
    /// assert_eq!(order.faces(&square)?.face(0), [0, 1, 2, 3]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn faces(&self, faces: &Faces) -> Result<Faces, Error> {
        faces.with_corners(self.indices(faces.corners())?)
    }

    /// Gives the same mesh with positions, attributes and faces in the new order.
    ///
    /// # Errors
    /// The mesh has another number of vertices.
    ///
    /// ```
    /// use tristrip::{Faces, Mesh, strip::VertexOrder};
    /// let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let mesh = Mesh::new(positions, Faces::from_triangles(vec![2, 0, 1])?)?;
    /// let order = VertexOrder::of_indices(3, [2, 0, 1])?;
    /// let ordered = order.mesh(&mesh)?;
    /// assert_eq!(ordered.faces().corners(), [0, 1, 2]);
    /// assert_eq!(order.inverse().mesh(&ordered)?, mesh);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn mesh(&self, mesh: &Mesh) -> Result<Mesh, Error> {
        let positions = self.values(mesh.positions(), 1)?;
        let mut out = Mesh::new(positions, self.faces(mesh.faces())?)?;
        for attribute in mesh.attributes() {
            out = out.with_attribute(self.attribute(attribute)?)?;
        }
        Ok(out)
    }
}

/// Makes the error for an index that names no vertex.
fn out_of_range(at: usize, vertex: u32, vertex_count: usize) -> Error {
    let found = format!("index {vertex} at {at}, over {vertex_count} vertices");
    Error::Parameter { name: "indices", found, expected: "less than the number of vertices" }
}

#[cfg(test)]
mod tests {
    use super::*;
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

    /// The order from a table of first places: used vertices by place, the others after them.
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
        fn numbers_rise_by_first_use(strips in some_strips(40), others in some_strips(40)) {
            let both = [strips.vertices(), others.vertices()].concat();
            let order = VertexOrder::of_strips(40, [&strips, &others]).unwrap();
            prop_assert!(order.check());
            prop_assert_eq!(order.new_to_old(), naive(40, &both));
            // Seen from the new numbers, every first use is the next number.
            let mut next = 0;
            for new in order.indices(&both).unwrap() {
                prop_assert!(new <= next);
                next = next.max(new + 1);
            }
            // The others follow in their old order.
            prop_assert!(order.new_to_old()[next as usize..].is_sorted());
            // And what is in order stays as it is.
            let again = VertexOrder::of_indices(40, order.indices(&both).unwrap()).unwrap();
            prop_assert_eq!(again.moved_count(), 0);
        }

        #[test]
        fn there_and_back_is_the_identity(
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
            let there = order.mesh(&mesh).unwrap();
            prop_assert_eq!(&back.mesh(&there).unwrap(), &mesh);
            for (new, &old) in order.new_to_old().iter().enumerate() {
                prop_assert_eq!(there.positions()[new].map(f32::to_bits), mesh.positions()[old as usize].map(f32::to_bits));
            }
            prop_assert_eq!(VertexOrder::from_new_to_old(order.new_to_old()).unwrap(), order);
        }

        #[test]
        fn what_is_drawn_and_what_it_costs_stay(strips in some_strips(20), places in 3..20_u32) {
            let positions = vec![[0.0; 3]; 20];
            let mesh = Mesh::new(positions, Faces::from_triangles(strips.to_list()).unwrap()).unwrap();
            let order = VertexOrder::of_strips(20, [&strips]).unwrap();
            let (there, ordered) = (order.mesh(&mesh).unwrap(), order.strips(&strips).unwrap());
            prop_assert!(verify(&there, &ordered).is_ok());
            let misses = |strips| VertexCacheStatistics::of(strips, VertexCache::fifo(places), FlushPolicy::Keep, 20);
            prop_assert_eq!(misses(&ordered), misses(&strips));
            let (a, b) = (Metrics::of(&strips), Metrics::of(&ordered));
            prop_assert_eq!((a.vertices_sent, a.swaps, a.indices_restart), (b.vertices_sent, b.swaps, b.indices_restart));
        }
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let order = VertexOrder::of_indices(3, [2]).unwrap();
        let say = |error: Error| error.to_string();
        assert_eq!(
            say(VertexOrder::of_indices(3, [0, 3]).unwrap_err()),
            "parameter `indices`: found index 3 at 1, over 3 vertices, expected less than the number of vertices"
        );
        assert!(
            say(VertexOrder::from_new_to_old(&[1, 1]).unwrap_err()).contains("vertex 1 a second time, at 1")
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
            say(order.attribute(&attribute).unwrap_err()),
            "attribute `id`: found 1 values, expected 3 (one for each vertex)"
        );
        assert!(order.mesh(&Mesh::default()).is_err());
        let wrong = VertexOrder { new_to_old: vec![0, 0], old_to_new: vec![0, 0] };
        assert!(!wrong.check());
        assert_eq!(VertexOrder::identity(0).unwrap(), VertexOrder::default());
        assert!(VertexOrder::identity(MAX_COUNT + 1).is_err());
    }
}
