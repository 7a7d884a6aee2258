//! Triangle strips: the vertices that are sent, strip after strip.
//!
//! Triangle i of a strip is its vertices i, i + 1, i + 2, in that order for even i and with the first two exchanged for odd i;
//! one in which two vertices are equal draws nothing. A *swap* repeats one vertex inside a strip; a winding repeat does so at
//! its start.

pub mod emit;
mod join;
pub mod layout;
pub mod metrics;
pub mod vertex_order;

pub(crate) use emit::{OPEN, Step, cover_cost, path_steps, send_path};
pub use emit::{emit, emit_in_order, path_cost};
pub use layout::Layout;
pub use metrics::{Cost, Metrics};
pub use vertex_order::VertexOrder;

use crate::error::{Error, MeshProblem};

/// Strips over the vertices of one mesh.
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
    /// Whether the strips are worth something in this order: see [`Strips::with_kept_order`].
    keeps_order: bool,
}

impl Strips {
    /// Makes strips from all their vertices and the end of each strip.
    ///
    /// # Errors
    /// The ends do not rise to the number of vertices.
    pub fn from_parts(vertices: Vec<u32>, ends: Vec<u32>) -> Result<Self, Error> {
        let last = ends.last().copied().unwrap_or(0);
        if !ends.is_sorted() || last as usize != vertices.len() {
            return Err(MeshProblem::CornerCount {
                found: vertices.len() as u64,
                expected: format!("{last}, by ends that never fall"),
            }
            .into());
        }
        Ok(Self { vertices, ends, keeps_order: false })
    }

    /// Says that order and direction of the strips are chosen, as for a vertex buffer, so that joining them keeps both.
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

    /// Makes room for vertices and strips.
    pub(crate) fn with_capacity(vertex_count: usize, strip_count: usize) -> Self {
        Self {
            vertices: Vec::with_capacity(vertex_count),
            ends: Vec::with_capacity(strip_count),
            keeps_order: false,
        }
    }

    /// Adds a strip at the end.
    pub fn push(&mut self, strip: &[u32]) {
        self.vertices.extend_from_slice(strip);
        self.ends.push(self.vertices.len() as u32);
    }

    /// Drops all strips and keeps the memory that they took.
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
    }

    /// Adds a vertex to the strip that is not ended yet.
    pub(crate) fn send_vertex(&mut self, vertex: u32) {
        self.vertices.push(vertex);
    }

    /// Adds vertices, and ends strips at these places among them.
    pub(crate) fn send_block_of(&mut self, vertices: &[u32], ends: impl IntoIterator<Item = u32>) {
        let sent = self.vertices.len() as u32;
        self.vertices.extend_from_slice(vertices);
        self.ends.extend(ends.into_iter().map(|end| sent + end));
    }

    /// Takes back the vertex sent last.
    pub(crate) fn drop_last_vertex(&mut self) {
        self.vertices.pop();
    }

    /// Gives the vertices sent since a strip was last ended.
    pub(crate) fn open_strip(&mut self) -> &mut [u32] {
        let start = self.ends.last().copied().unwrap_or(0);
        &mut self.vertices[start as usize..]
    }

    /// Ends the strip of the vertices sent since the last one.
    pub(crate) fn end_strip(&mut self) {
        self.ends.push(self.vertices.len() as u32);
    }

    /// Counts the strips.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Tells whether there is no strip.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Counts the vertices of all strips, swaps and winding repeats included: the `OpenGL` cost.
    pub fn vertices_sent(&self) -> usize {
        self.vertices.len()
    }

    /// Gives the vertices of all strips, one strip after the other.
    pub fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    /// Walks over the strips in the order in which they are drawn.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        (0..self.ends.len()).map(|i| {
            let start = if i == 0 { 0 } else { self.ends[i - 1] as usize };
            &self.vertices[start..self.ends[i] as usize]
        })
    }

    /// Walks over the triangles drawn, wound as their faces are; degenerate ones are left out.
    pub fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        self.iter().flat_map(strip_triangles)
    }
}

/// Walks over the triangles that one strip draws, wound as their faces are; degenerate ones are left out.
pub fn strip_triangles(strip: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    strip.windows(3).enumerate().filter_map(|(i, w)| {
        let real = w[0] != w[1] && w[1] != w[2] && w[0] != w[2];
        real.then(|| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] })
    })
}
