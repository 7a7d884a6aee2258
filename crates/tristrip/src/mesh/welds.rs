//! Welded vertices: vertices replaced by others with the same bits in position and all attributes.
//!
//! A model exported without shared vertices has no shared edges, and every triangle would be a
//! strip of its own. Welding uses one vertex for all equal ones. Strips of a welded mesh draw the
//! same surface as its faces but use other vertices, so the strips store the welds.
//! [`verify`](crate::verify::verify) checks that the vertices are equal and compares the faces
//! after welding.
//!
//! # Complexity
//! O(n) time, where n is the number of corners. 8 bytes per welded vertex, and the bits of each
//! vertex in use while welding.

use std::collections::HashMap;
use std::sync::Arc;

use super::{Mesh, VertexSubset, vertex_bits};
#[cfg(feature = "serde")]
use crate::error::Error;

/// Welded vertices and their replacements. Clones share the data.
///
/// ```
/// use tristrip::{Faces, Mesh, VertexWelds};
/// // Two triangles that touch along an edge but share no vertex: 3 equals 2, and 4 equals 1.
/// let (a, b, c, d) = ([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]);
/// let mesh = Mesh::new(vec![a, b, c, c, b, d], Faces::from_triangles((0..6).collect())?)?;
/// let welds = VertexWelds::of(&mesh);
/// assert_eq!(welds.iter().collect::<Vec<_>>(), [(3, 2), (4, 1)]);
/// assert_eq!((welds.vertex(4), welds.vertex(5)), (1, 5));
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct VertexWelds {
    /// Pairs of a welded vertex and its replacement, sorted by welded vertex. A replacement is
    /// never welded itself.
    pairs: Arc<Vec<(u32, u32)>>,
}

impl VertexWelds {
    /// Finds each vertex in use whose position and attributes have the same bits as an earlier
    /// vertex in use.
    ///
    /// ```
    #[doc = include_str!("welded_example.txt")]
    /// let shades = AttributeData::U8(vec![0, 1, 2, 2, 9, 5]);
    /// let shades = Attribute { name: "shade".into(), components: 1, normalized: true, data: shades };
    /// // Now vertices 1 and 4 have different shades.
    /// assert_eq!(VertexWelds::of(&mesh.with_attribute(shades)?).iter().collect::<Vec<_>>(), [(3, 2)]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn of(mesh: &Mesh) -> Self {
        let used = VertexSubset::of(mesh.faces().corners());
        // A random hash seed protects against files with colliding vertices; the welds do not
        // depend on it.
        let mut first: HashMap<Vec<u8>, u32> = HashMap::new();
        let pairs = used.vertices().iter().filter_map(|&v| {
            let equal = *first.entry(vertex_bits(mesh, v as usize)).or_insert(v);
            (equal != v).then_some((v, equal))
        });
        Self { pairs: Arc::new(pairs.collect()) }
    }

    /// Creates welds from pairs of a welded vertex and its replacement.
    ///
    /// # Errors
    /// The welded vertices are not in ascending order, or a replacement is welded itself.
    #[cfg(feature = "serde")]
    pub(crate) fn from_pairs(pairs: Vec<(u32, u32)>) -> Result<Self, Error> {
        let ascends = pairs.windows(2).all(|pair| pair[0].0 < pair[1].0);
        let welds = Self { pairs: Arc::new(pairs) };
        let wrong = welds.iter().find(|&(_, other)| welds.has(other));
        match wrong {
            None if ascends => Ok(welds),
            wrong => {
                let found = wrong
                    .map_or("vertices that are not ascending".into(), |(a, b)| format!("{a} welded to {b}"));
                let expected = "ascending vertices, each with a replacement that is not welded";
                Err(Error::Parameter { name: "welds", found, expected })
            }
        }
    }

    /// Returns whether a vertex is welded.
    #[cfg(feature = "serde")]
    fn has(&self, vertex: u32) -> bool {
        self.pairs.binary_search_by_key(&vertex, |&(welded, _)| welded).is_ok()
    }

    /// Counts the welded vertices.
    ///
    /// ```
    #[doc = include_str!("welded_example.txt")]
    /// assert_eq!(VertexWelds::of(&mesh).len(), 2);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn len(&self) -> usize {
        self.pairs.len()
    }

    /// Returns whether no vertices are welded.
    ///
    /// ```
    #[doc = include_str!("welded_example.txt")]
    /// let first_triangle = mesh.with_faces(Faces::from_triangles(vec![0, 1, 2])?)?;
    /// assert!(VertexWelds::of(&first_triangle).is_empty() && !VertexWelds::of(&mesh).is_empty());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// Iterates over the welded vertices in ascending order, each with its replacement.
    ///
    /// ```
    #[doc = include_str!("welded_example.txt")]
    /// for (vertex, other) in VertexWelds::of(&mesh).iter() {
    ///     assert_eq!(mesh.positions()[vertex as usize], mesh.positions()[other as usize]);
    /// }
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (u32, u32)> {
        self.pairs.iter().copied()
    }

    /// Returns the replacement of a vertex, or the vertex itself if it is not welded.
    ///
    /// ```
    #[doc = include_str!("welded_example.txt")]
    /// let welds = VertexWelds::of(&mesh);
    /// assert_eq!([3, 4, 5].map(|vertex| welds.vertex(vertex)), [2, 1, 5]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn vertex(&self, vertex: u32) -> u32 {
        let at = self.pairs.binary_search_by_key(&vertex, |&(welded, _)| welded);
        at.map_or(vertex, |at| self.pairs[at].1)
    }

    /// Returns the vertices after welding.
    pub(crate) fn vertices(&self, vertices: &[u32]) -> Vec<u32> {
        vertices.iter().map(|&vertex| self.vertex(vertex)).collect()
    }

    /// Returns the first weld whose vertices are out of range or have different bits.
    pub(crate) fn wrong_weld(&self, mesh: &Mesh) -> Option<(u32, u32)> {
        let equal = |(a, b): (u32, u32)| {
            let exist = a.max(b) < mesh.vertex_count() as u32;
            exist && vertex_bits(mesh, a as usize) == vertex_bits(mesh, b as usize)
        };
        self.iter().find(|&weld| !equal(weld))
    }

    /// Returns the welds whose vertices are both below `vertex_count`.
    pub(crate) fn below(&self, vertex_count: usize) -> Self {
        let exist = |&(a, b): &(u32, u32)| (a.max(b) as usize) < vertex_count;
        if self.pairs.iter().all(exist) {
            self.clone()
        } else {
            Self { pairs: Arc::new(self.iter().filter(exist).collect()) }
        }
    }

    /// Returns the welds with the vertices renumbered.
    pub(crate) fn renumbered<E>(&self, number: impl Fn(u32) -> Result<u32, E>) -> Result<Self, E> {
        let mut pairs: Vec<(u32, u32)> =
            self.iter().map(|(a, b)| Ok((number(a)?, number(b)?))).collect::<Result<_, E>>()?;
        pairs.sort_unstable();
        Ok(Self { pairs: Arc::new(pairs) })
    }
}
