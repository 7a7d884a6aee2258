//! Triangle strips, stored as one vertex array and the end of each strip.
//!
//! Triangle i of a strip consists of the vertices i, i + 1 and i + 2. For odd i, the first two are
//! exchanged. A triangle with two equal vertices is degenerate and draws nothing. A *swap* repeats
//! a vertex inside a strip; a *winding repeat* repeats the first vertex at the start.

mod emit;
mod join;
pub(crate) mod layout;
mod metrics;
mod vertex_order;

#[cfg(test)]
pub(crate) use emit::path_cost;
pub(crate) use emit::{OPEN, Step, cover_cost, emit, emit_in_order, path_steps, send_path};
pub use layout::{Layout, split_joined};
pub use metrics::{Cost, Metrics};
pub use vertex_order::VertexOrder;

use crate::error::{Error, MeshProblem};
use crate::mesh::{VertexWelds, is_degenerate};

/// Triangle strips over the vertices of one mesh.
///
/// ```
/// let mut strips = tristrip::Strips::default();
/// strips.push(&[0, 1, 2, 3]);
/// strips.push(&[4, 5, 6]);
/// assert_eq!((strips.len(), strips.vertices_sent()), (2, 7));
/// assert_eq!(strips.triangles().collect::<Vec<_>>(), [[0, 1, 2], [2, 1, 3], [4, 5, 6]]);
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Strips {
    vertices: Vec<u32>,
    /// End of each strip within `vertices`.
    ends: Vec<u32>,
    /// Whether the caller chose the order of the strips: see [`Strips::with_kept_order`].
    keeps_order: bool,
    welds: VertexWelds,
}

impl Strips {
    /// Creates strips from an array with the vertices of all strips and the end of each strip in
    /// this array.
    ///
    /// # Errors
    /// The ends decrease, or the last end is not the number of vertices.
    ///
    /// ```
    /// use tristrip::Strips;
    /// let strips = Strips::from_parts(vec![0, 1, 2, 3, 4, 5, 6], vec![4, 7])?;
    /// assert_eq!(strips.iter().collect::<Vec<_>>(), [&[0, 1, 2, 3][..], &[4, 5, 6]]);
    /// // The last vertex belongs to no strip.
    /// assert!(Strips::from_parts(vec![0, 1, 2, 3], vec![3]).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn from_parts(vertices: Vec<u32>, ends: Vec<u32>) -> Result<Self, Error> {
        let last = ends.last().copied().unwrap_or(0);
        if !ends.is_sorted() || last as usize != vertices.len() {
            return Err(MeshProblem::CornerCount {
                found: vertices.len() as u64,
                expected: format!("{last}, the last of ends that do not decrease"),
            }
            .into());
        }
        Ok(Self { vertices, ends, ..Self::default() })
    }

    /// Marks the order and direction of the strips as final, for example after ordering them for a
    /// vertex cache. Joining the strips then changes neither.
    ///
    /// ```
    /// let mut strips = tristrip::Strips::default();
    /// strips.push(&[0, 1, 2, 3]);
    /// strips.push(&[4, 5, 6]);
    /// strips.push(&[7, 8, 4, 3]);
    /// let joined = strips.with_kept_order().to_degenerate();
    /// assert_eq!(joined, [0, 1, 2, 3, 3, 4, 4, 5, 6, 6, 7, 7, 7, 8, 4, 3]);
    /// ```
    #[must_use]
    pub fn with_kept_order(mut self) -> Self {
        self.keeps_order = true;
        self
    }

    /// Adds the welded vertices of the mesh. [`verify`](crate::verify::verify) needs these welds to
    /// compare the strips with the mesh.
    #[must_use]
    pub(crate) fn with_welds(mut self, welds: VertexWelds) -> Self {
        self.welds = welds;
        self
    }

    /// Returns the vertices of the mesh that the strips replace by another vertex with the same
    /// bits. The result is empty unless
    /// [`StripifyOptions::with_weld`](crate::StripifyOptions::with_weld) was set.
    ///
    /// ```
    /// use tristrip::{Faces, Mesh, StripifyOptions, stripify, verify::verify};
    /// // Two triangles that touch along an edge but share no vertex.
    /// let (a, b, c, d) = ([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]);
    /// let mesh = Mesh::new(vec![a, b, c, c, b, d], Faces::from_triangles((0..6).collect())?)?;
    /// let strips = stripify(&mesh, &StripifyOptions::default().with_weld(true))?;
    /// assert_eq!((strips.len(), strips.vertices_sent()), (1, 4));
    /// assert_eq!(strips.welds().iter().collect::<Vec<_>>(), [(3, 2), (4, 1)]);
    /// assert!(verify(&mesh, &strips).is_ok());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn welds(&self) -> &VertexWelds {
        &self.welds
    }

    /// Returns the strips without the welds of vertices whose index is at least `vertex_count`, for
    /// a mesh whose last vertices were removed.
    ///
    /// ```
    /// use tristrip::{Faces, Mesh, StripifyOptions, stripify};
    /// // Two triangles that touch along an edge but share no vertex.
    /// let corners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 1., 0.], [1., 0., 0.], [1., 1., 0.]];
    /// let mesh = Mesh::new(corners.to_vec(), Faces::from_triangles((0..6).collect())?)?;
    /// let strips = stripify(&mesh, &StripifyOptions::default().with_weld(true))?;
    /// assert_eq!((strips.welds().len(), strips.with_welds_below(4).welds().len()), (2, 1));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    #[must_use]
    pub fn with_welds_below(mut self, vertex_count: usize) -> Self {
        self.welds = self.welds.below(vertex_count);
        self
    }

    /// Replaces every vertex by `new(vertex)`. The strips must have no welds.
    pub(crate) fn map_vertices(mut self, new: impl Fn(u32) -> u32) -> Self {
        self.vertices.iter_mut().for_each(|vertex| *vertex = new(*vertex));
        self
    }

    /// Returns whether joins keep the order of the strips.
    #[cfg(feature = "serde")]
    pub(crate) fn keeps_order(&self) -> bool {
        self.keeps_order
    }

    /// Creates an empty list with capacity for vertices and strips.
    pub(crate) fn with_capacity(vertex_count: usize, strip_count: usize) -> Self {
        Self {
            vertices: Vec::with_capacity(vertex_count),
            ends: Vec::with_capacity(strip_count),
            ..Self::default()
        }
    }

    /// Appends a strip.
    ///
    /// ```
    /// let mut strips = tristrip::Strips::default();
    /// strips.push(&[0, 1, 2]);
    /// // A repeated first vertex moves the triangle to an odd position, which reverses its
    /// // winding.
    /// strips.push(&[3, 3, 4, 5]);
    /// assert_eq!(strips.triangles().collect::<Vec<_>>(), [[0, 1, 2], [4, 3, 5]]);
    /// ```
    pub fn push(&mut self, strip: &[u32]) {
        self.vertices.extend_from_slice(strip);
        self.ends.push(self.vertices.len() as u32);
    }

    /// Removes all strips and welds but keeps the allocated memory.
    ///
    /// ```
    /// let mut strips = tristrip::Strips::default();
    /// strips.push(&[0, 1, 2]);
    /// strips.clear();
    /// assert!(strips.is_empty() && strips.vertices().is_empty());
    /// ```
    pub fn clear(&mut self) {
        self.vertices.clear();
        self.ends.clear();
        self.welds = VertexWelds::default();
    }

    /// Appends a vertex to the open strip.
    pub(crate) fn send_vertex(&mut self, vertex: u32) {
        self.vertices.push(vertex);
    }

    /// Appends a block of vertices with strip ends at the given positions, counted from the start
    /// of the block.
    pub(crate) fn send_block_of(&mut self, vertices: &[u32], ends: impl IntoIterator<Item = u32>) {
        let sent = self.vertices.len() as u32;
        self.vertices.extend_from_slice(vertices);
        self.ends.extend(ends.into_iter().map(|end| sent + end));
    }

    /// Removes the last vertex.
    pub(crate) fn drop_last_vertex(&mut self) {
        self.vertices.pop();
    }

    /// Returns the vertices of the open strip.
    pub(crate) fn open_strip(&mut self) -> &mut [u32] {
        let start = self.ends.last().copied().unwrap_or(0);
        &mut self.vertices[start as usize..]
    }

    /// Ends the open strip.
    pub(crate) fn end_strip(&mut self) {
        self.ends.push(self.vertices.len() as u32);
    }

    /// Returns the size of the strips in memory, in bytes.
    ///
    /// ```
    /// let mut strips = tristrip::Strips::default();
    /// strips.push(&[0, 1, 2, 3]);
    /// assert_eq!(strips.memory(), 20);
    /// ```
    pub fn memory(&self) -> usize {
        size_of_val(&self.vertices[..]) + size_of_val(&self.ends[..]) + 8 * self.welds.len()
    }

    /// Counts the strips.
    ///
    /// ```
    /// // A quadrilateral of two triangles, and a triangle that touches it only at a corner.
    /// let strips = tristrip::stripify_indices(&[0_u8, 1, 2, 2, 1, 3, 3, 4, 5], 6)?;
    /// assert_eq!(strips.len(), 2);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Returns whether there are no strips.
    ///
    /// ```
    /// // A triangle with a repeated vertex draws nothing.
    /// assert!(tristrip::stripify_indices(&[0_u8, 1, 1], 2)?.is_empty());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Counts the vertices of all strips, including swaps and winding repeats (the `OpenGL` cost).
    ///
    /// ```
    /// let mut strips = tristrip::Strips::default();
    /// strips.push(&[0, 1, 2, 1, 3, 4]); // a swap: vertex 1 is sent twice
    /// assert_eq!((strips.vertices_sent(), strips.to_list().len()), (6, 9));
    /// ```
    pub fn vertices_sent(&self) -> usize {
        self.vertices.len()
    }

    /// Returns the vertices of all strips, in drawing order.
    ///
    /// ```
    /// let mut strips = tristrip::Strips::default();
    /// strips.push(&[0, 1, 2, 3]);
    /// strips.push(&[3, 2, 4]);
    /// assert_eq!(strips.vertices(), [0, 1, 2, 3, 3, 2, 4]);
    /// ```
    pub fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    /// Iterates over the strips in drawing order.
    ///
    /// ```
    /// let mut strips = tristrip::Strips::default();
    /// strips.push(&[0, 1, 2]);
    /// strips.push(&[3, 4, 5, 6, 7]);
    /// assert_eq!(strips.iter().map(|strip| strip.len()).max(), Some(5));
    /// ```
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        (0..self.ends.len()).map(|i| self.strip(i))
    }

    /// Returns a strip in constant time, or `None` if the index is out of range.
    ///
    /// ```
    /// let mut strips = tristrip::Strips::default();
    /// strips.push(&[0, 1, 2]);
    /// strips.push(&[3, 4, 5, 6, 7]);
    /// assert_eq!((strips.get(1), strips.get(2)), (Some(&[3, 4, 5, 6, 7][..]), None));
    /// ```
    pub fn get(&self, index: usize) -> Option<&[u32]> {
        (index < self.ends.len()).then(|| self.strip(index))
    }

    fn strip(&self, index: usize) -> &[u32] {
        let start = if index == 0 { 0 } else { self.ends[index - 1] as usize };
        &self.vertices[start..self.ends[index] as usize]
    }

    /// Checks that every vertex is less than `vertex_count`.
    ///
    /// # Errors
    /// A strip refers to a vertex that is out of range. The error contains the index of the strip
    /// and the position within the strip.
    ///
    /// ```
    /// let mut strips = tristrip::Strips::default();
    /// strips.push(&[0, 1, 2]);
    /// strips.push(&[2, 1, 7]);
    /// assert!(strips.check_vertices(8).is_ok());
    /// let error = strips.check_vertices(7).unwrap_err().to_string();
    /// assert_eq!(error, "strip 1, vertex 2: found vertex index 7, expected less than 7");
    /// ```
    pub fn check_vertices(&self, vertex_count: usize) -> Result<(), Error> {
        let Some(at) = self.vertices.iter().position(|&v| v as usize >= vertex_count) else { return Ok(()) };
        let strip = self.ends.partition_point(|&end| end as usize <= at);
        let start = if strip == 0 { 0 } else { self.ends[strip - 1] as usize };
        let (strip, position) = (strip as u32, (at - start) as u32);
        let (found, vertex_count) = (self.vertices[at], vertex_count as u32);
        Err(MeshProblem::StripVertex { strip, position, found, vertex_count }.into())
    }

    /// Iterates over the triangles in drawing order, with the winding of their faces. Degenerate
    /// triangles are omitted.
    ///
    /// ```
    /// let mut strips = tristrip::Strips::default();
    /// strips.push(&[0, 1, 2, 1, 3]); // 2 1 1 draws nothing
    /// assert_eq!(strips.triangles().collect::<Vec<_>>(), [[0, 1, 2], [2, 1, 3]]);
    /// ```
    pub fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        self.iter().flat_map(strip_triangles)
    }
}

/// Iterates over the triangles of one strip, with the winding of their faces. Degenerate triangles
/// are omitted.
///
/// ```
/// use tristrip::strip_triangles;
/// assert_eq!(strip_triangles(&[5, 6, 7, 8, 9]).collect::<Vec<_>>(), [[5, 6, 7], [7, 6, 8], [7, 8, 9]]);
/// assert_eq!(strip_triangles(&[5, 6]).count(), 0);
/// ```
pub fn strip_triangles(strip: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    strip.windows(3).enumerate().filter_map(|(i, w)| {
        let triangle = if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] };
        (!is_degenerate(triangle)).then_some(triangle)
    })
}

/// Counts the triangles of one strip. Degenerate triangles are not counted.
pub(crate) fn count_triangles(strip: &[u32]) -> usize {
    strip.windows(3).filter(|w| !is_degenerate([w[0], w[1], w[2]])).count()
}
