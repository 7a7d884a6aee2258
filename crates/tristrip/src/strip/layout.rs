//! Index buffers from strips, in the four layouts that files and graphics interfaces know.
//!
//! # References
//! Evans, Skiena, Varshney: *Efficiently Generating Triangle Strips for Fast Rendering*, 1996, section 1 (swaps by repeated
//! vertices); the draft glTF extension `KHR_mesh_primitive_restart`.

use super::{Strips, strip_triangles};

/// How strips are laid out in an index buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Layout {
    /// Strips separated by the restart index.
    Restart,
    /// One strip, joined by degenerate triangles, winding kept.
    Degenerate,
    /// One draw call, or primitive, a strip.
    Separate,
    /// A triangle list, in strip order.
    List,
}

impl Strips {
    /// Lays the strips out with `restart` between them.
    ///
    /// ```
    /// let mut strips = tristrip::Strips::default();
    /// strips.push(&[0, 1, 2]);
    /// strips.push(&[3, 4, 5]);
    /// assert_eq!(strips.to_restart(u32::MAX), [0, 1, 2, u32::MAX, 3, 4, 5]);
    /// ```
    pub fn to_restart(&self, restart: u32) -> Vec<u32> {
        let mut out = Vec::with_capacity(self.vertices_sent() + self.len());
        for strip in self.iter() {
            if !out.is_empty() {
                out.push(restart);
            }
            out.extend_from_slice(strip);
        }
        out
    }

    /// Joins the strips into one by degenerate triangles, each strip keeping its winding.
    ///
    /// A join repeats the last vertex and the next strip's first one, and once more where the next strip would begin at an odd
    /// place; but nothing where the next strip begins with the vertex that was sent last. So the strips are taken in an order
    /// in which many do, from their first vertex or from their last, and else in their own.
    ///
    /// ```
    /// let mut strips = tristrip::Strips::default();
    /// strips.push(&[0, 1, 2, 3]);
    /// strips.push(&[4, 5, 6]);
    /// strips.push(&[7, 8, 4, 3]);
    /// assert_eq!(strips.to_degenerate(), [0, 1, 2, 3, 3, 4, 8, 7, 7, 4, 4, 5, 6]);
    /// ```
    pub fn to_degenerate(&self) -> Vec<u32> {
        let mut out: Vec<u32> = Vec::with_capacity(self.vertices_sent() + 3 * self.len());
        let mut joiner = Joiner::new(self);
        while let Some(way) = joiner.next_after(&out) {
            if let Some(&last) = out.last() {
                let between = way.joining(last, out.len());
                out.resize(out.len() + between.repeats, last);
                out.extend(between.first);
            }
            out.extend(way.vertices());
        }
        out
    }

    /// Unrolls the strips into a triangle list, in the order in which they are drawn.
    ///
    /// ```
    /// let mut strips = tristrip::Strips::default();
    /// strips.push(&[0, 1, 2, 3]);
    /// assert_eq!(strips.to_list(), [0, 1, 2, 2, 1, 3]);
    /// ```
    pub fn to_list(&self) -> Vec<u32> {
        self.iter().flat_map(strip_triangles).flatten().collect()
    }
}

/// Chooses the order of strips that are joined into one.
struct Joiner<'a> {
    strips: Vec<&'a [u32]>,
    used: Vec<bool>,
    /// Strips before this one are used.
    first: usize,
    /// The vertices that strips can begin with, each with its strip, sorted.
    starts: Vec<(u32, u32)>,
}

/// A way to send a strip: from its first vertex or from its last; a triangle alone also from each of its vertices.
#[derive(Debug, Clone, Copy)]
struct Way<'a> {
    strip: &'a [u32],
    rotation: usize,
    reversed: bool,
}

/// What stands between two strips: repeats of the last vertex, and the next strip's first one where it is another.
struct Between {
    repeats: usize,
    first: Option<u32>,
}

impl<'a> Way<'a> {
    fn all(strip: &'a [u32]) -> impl Iterator<Item = Self> {
        let rotations = if strip.len() == 3 { 3 } else { 1 };
        (0..rotations)
            .flat_map(move |rotation| [false, true].map(|reversed| Self { strip, rotation, reversed }))
    }

    fn vertices(self) -> impl Iterator<Item = u32> {
        let n = self.strip.len();
        (0..n).map(move |i| self.strip[(if self.reversed { n - 1 - i } else { i } + self.rotation) % n])
    }

    /// Tells whether the strip keeps its winding at an odd place, rather than at an even one.
    fn is_for_odd_place(self) -> bool {
        self.reversed && self.strip.len() % 2 == 1
    }

    /// Finds what must stand between the vertex that was sent last and this strip; `sent` vertices stand before.
    fn joining(self, last: u32, sent: usize) -> Between {
        let first = self.vertices().next().filter(|&first| first != last);
        let misplaced = usize::from((sent % 2 == 1) != self.is_for_odd_place());
        Between { repeats: misplaced + usize::from(first.is_some()), first }
    }
}

impl<'a> Joiner<'a> {
    /// How many strips at a vertex are looked at.
    const CANDIDATES: usize = 16;

    fn new(strips: &'a Strips) -> Self {
        let strips: Vec<&[u32]> = strips.iter().filter(|strip| strip.len() >= 3).collect();
        let mut starts = Vec::with_capacity(2 * strips.len());
        for (i, strip) in (0..).zip(&strips) {
            match **strip {
                [a, b, c] => starts.extend([(a, i), (b, i), (c, i)]),
                [a, .., z] => starts.extend([(a, i), (z, i)]),
                _ => (),
            }
        }
        starts.sort_unstable();
        Self { used: vec![false; strips.len()], strips, first: 0, starts }
    }

    /// Takes the strip, and the way of it, that follows most cheaply on what was sent.
    fn next_after(&mut self, out: &[u32]) -> Option<Way<'a>> {
        self.first += self.used.get(self.first..)?.iter().position(|used| !used)?;
        let Some(&last) = out.last() else {
            self.used[self.first] = true;
            return Some(Way { strip: self.strips[self.first], rotation: 0, reversed: false });
        };
        let from = self.starts.partition_point(|&(vertex, _)| vertex < last);
        let sharing =
            self.starts[from..].iter().take_while(|&&(vertex, _)| vertex == last).take(Self::CANDIDATES);
        let free = sharing.map(|&(_, i)| i as usize).filter(|&i| !self.used[i]);
        let ways = free.chain([self.first]).flat_map(|i| Way::all(self.strips[i]).map(move |way| (i, way)));
        let (i, way) = ways.min_by_key(|(_, way)| {
            let between = way.joining(last, out.len());
            between.repeats + usize::from(between.first.is_some())
        })?;
        self.used[i] = true;
        Some(way)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strip::verify_drawing;
    use proptest::prelude::*;

    /// The join as it is usually done: the strips in order, two repeats between them, three after an odd number of vertices.
    fn plain_join(strips: &Strips) -> Vec<u32> {
        let mut out: Vec<u32> = Vec::new();
        for strip in strips.iter() {
            if let Some(&last) = out.last() {
                out.resize(out.len() + 1 + out.len() % 2, last);
                out.push(strip[0]);
            }
            out.extend(strip);
        }
        out
    }

    proptest! {
        #[test]
        fn every_layout_draws_the_same(lengths in prop::collection::vec(3..9_usize, 0..12), seed in 1..60_u32) {
            let mut strips = Strips::default();
            let mut x = seed;
            for length in lengths {
                let strip: Vec<u32> = (0..length).map(|_| {
                    x = x.wrapping_mul(1_103_515_245).wrapping_add(12_345);
                    x >> 16 & 15
                }).collect();
                strips.push(&strip);
            }
            let faces = crate::Faces::from_triangles(strips.to_list()).unwrap();
            let joined = strips.to_degenerate();
            let drawn: Vec<_> = strip_triangles(&joined).collect();
            prop_assert!(verify_drawing(&faces, &drawn).is_ok());
            prop_assert!(joined.len() <= plain_join(&strips).len());
            let restart = strips.to_restart(99);
            let drawn: Vec<_> = restart.split(|&v| v == 99).flat_map(strip_triangles).collect();
            prop_assert!(verify_drawing(&faces, &drawn).is_ok());
        }
    }
}
