//! A simulated vertex buffer of a graphics processor: how many vertices it must transform while strips are drawn.
//!
//! A vertex that is in the buffer when it is sent is a hit and costs nothing; another is a miss and enters the buffer. Misses per
//! real triangle are the ACMR, at best near 0.5 and 3 at worst; misses per vertex in use are the ATVR, at best 1.
//!
//! # Algorithm
//! First in, first out: each vertex remembers which miss brought it in. It has left again when as many misses as the buffer has
//! places came after that one. Strips are sent in order, swaps and winding repeats included, and the buffer is kept from one strip
//! to the next. Restarts and the degenerate triangles between strips send nothing here.
//!
//! # Complexity
//! O(1) an index; 8 bytes a vertex.

use super::Strips;
use crate::mesh::SPARSE;

/// Which vertex leaves a full buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum Replacement {
    /// The one that came in first.
    #[default]
    Fifo,
}

/// A vertex buffer with a number of places.
///
/// ```
/// use tristrip::strip::{Replacement, VertexBuffer};
/// let mut buffer = VertexBuffer::new(Replacement::Fifo, 2, 3);
/// let hits: Vec<bool> = [0, 1, 0, 2, 0].into_iter().map(|v| buffer.send(v)).collect();
/// assert_eq!(hits, [false, false, true, false, false]);
/// assert_eq!(buffer.misses(), 4);
/// ```
#[derive(Debug, Clone)]
pub struct VertexBuffer {
    replacement: Replacement,
    places: u64,
    /// For each vertex the number of the miss that brought it in, counted from 1; 0 for one that was never in.
    entered: Vec<u64>,
    misses: u64,
}

impl VertexBuffer {
    /// Makes an empty buffer of some `places` for vertices 0 to `vertex_count` − 1.
    pub fn new(replacement: Replacement, places: usize, vertex_count: usize) -> Self {
        Self { replacement, places: places as u64, entered: vec![0; vertex_count], misses: 0 }
    }

    /// Sends a vertex; tells whether it was in the buffer.
    ///
    /// # Panics
    /// The vertex is not less than the number of vertices.
    pub fn send(&mut self, vertex: u32) -> bool {
        let entered = &mut self.entered[vertex as usize];
        let hit = match self.replacement {
            Replacement::Fifo => *entered > 0 && self.misses - *entered < self.places,
        };
        if !hit {
            self.misses += 1;
            *entered = self.misses;
        }
        hit
    }

    /// Counts the vertices that were not in the buffer when they were sent.
    pub fn misses(&self) -> usize {
        self.misses as usize
    }
}

/// What drawing strips costs with one vertex buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BufferUse {
    /// Vertices that were not in the buffer when they were sent.
    pub misses: usize,
    /// Real triangles drawn.
    pub triangles: usize,
    /// Different vertices that were sent.
    pub vertices: usize,
}

impl BufferUse {
    /// Draws strips over vertices 0 to `vertex_count` − 1 with an empty buffer, kept from one strip to the next.
    ///
    /// # Panics
    /// A strip has a vertex that is not less than `vertex_count`.
    ///
    /// ```
    /// use tristrip::{Strips, strip::{BufferUse, Replacement}};
    /// let mut strips = Strips::default();
    /// strips.push(&[0, 1, 2, 3]);
    /// strips.push(&[2, 3, 4]);
    /// let used = BufferUse::of(&strips, Replacement::Fifo, 16, 5);
    /// assert_eq!((used.misses, used.triangles, used.vertices), (5, 3, 5));
    /// assert_eq!((used.acmr(), used.atvr()), (5.0 / 3.0, 1.0));
    /// ```
    pub fn of(strips: &Strips, replacement: Replacement, places: usize, vertex_count: usize) -> Self {
        let mut used: Vec<u32> = Vec::new();
        let few = strips.vertices_sent() < vertex_count / SPARSE;
        if few {
            used.extend_from_slice(strips.vertices());
            used.sort_unstable();
            used.dedup();
        }
        let mut buffer = VertexBuffer::new(replacement, places, if few { used.len() } else { vertex_count });
        for &vertex in strips.vertices() {
            let place = if few { used.partition_point(|&v| v < vertex) as u32 } else { vertex };
            buffer.send(place);
        }
        Self {
            misses: buffer.misses(),
            triangles: strips.triangles().count(),
            vertices: buffer.entered.iter().filter(|&&entered| entered > 0).count(),
        }
    }

    /// Divides the misses by the real triangles (the ACMR); 0 where there is none.
    pub fn acmr(&self) -> f64 {
        if self.triangles == 0 { 0.0 } else { self.misses as f64 / self.triangles as f64 }
    }

    /// Divides the misses by the vertices in use (the ATVR); 0 where there is none.
    pub fn atvr(&self) -> f64 {
        if self.vertices == 0 { 0.0 } else { self.misses as f64 / self.vertices as f64 }
    }
}

/// Sums what parts with vertices of their own cost.
impl std::iter::Sum for BufferUse {
    fn sum<I: Iterator<Item = Self>>(parts: I) -> Self {
        parts.fold(Self::default(), |a, b| Self {
            misses: a.misses + b.misses,
            triangles: a.triangles + b.triangles,
            vertices: a.vertices + b.vertices,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::VecDeque;

    /// The buffer as a queue of its vertices, searched from end to end.
    fn misses_of_a_queue(indices: &[u32], places: usize) -> usize {
        let (mut queue, mut misses) = (VecDeque::new(), 0);
        for v in indices {
            if !queue.contains(v) {
                misses += 1;
                queue.push_back(*v);
                if queue.len() > places {
                    queue.pop_front();
                }
            }
        }
        misses
    }

    proptest! {
        #[test]
        fn misses_are_those_of_a_queue(
            indices in prop::collection::vec(0..40_u32, 0..300),
            places in 0..50_usize,
        ) {
            let mut buffer = VertexBuffer::new(Replacement::Fifo, places, 40);
            indices.iter().for_each(|&v| { buffer.send(v); });
            prop_assert_eq!(buffer.misses(), misses_of_a_queue(&indices, places));
        }
    }

    #[test]
    fn a_swap_is_a_hit_and_no_triangle() {
        let mut strips = Strips::default();
        strips.push(&[0, 1, 2, 1, 3]);
        let used = BufferUse::of(&strips, Replacement::Fifo, 3, 9);
        assert_eq!(used, BufferUse { misses: 4, triangles: 2, vertices: 4 });
        assert_eq!(used, BufferUse::of(&strips, Replacement::Fifo, 3, 9000));
        assert!(BufferUse::default().acmr() + BufferUse::default().atvr() < f64::MIN_POSITIVE);
    }
}
