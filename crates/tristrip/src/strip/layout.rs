//! Index buffers of strips, in the four layouts that files and graphics APIs support; and the inverse of the joined layout.
//!
//! # References
//! Evans, Skiena, Varshney: *Efficiently Generating Triangle Strips for Fast Rendering*, 1996, section 1 (swaps by repeated
//! vertices); the draft glTF extension `KHR_mesh_primitive_restart`.

use super::{Strips, join, strip_triangles};

/// The layout of strips in an index buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Layout {
    /// Strips separated by the restart index.
    Restart,
    /// One strip, joined by degenerate triangles, winding kept.
    Degenerate,
    /// One draw call, or primitive, per strip.
    Separate,
    /// A triangle list, in strip order.
    List,
}

impl Strips {
    /// Returns the index buffer with `restart` between strips.
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

    /// Joins the strips into one by degenerate triangles; each strip keeps its winding.
    ///
    /// A join repeats the last vertex and the next strip's first one, and once more if the next strip would begin at an odd
    /// position; but nothing if the next strip begins with the vertex that was sent last. The strips are therefore drawn in an order
    /// in which this holds for as many as possible, from their first vertex or from their last; or in the present order if it is
    /// [kept](Strips::with_kept_order).
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
        let ways = if self.keeps_order { join::in_order(self).collect() } else { join::order(self) };
        ways.into_iter().for_each(|way| way.join_to(&mut out));
        out
    }

    /// Converts the strips into a triangle list, in drawing order.
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

/// Iterates over the strips that degenerate triangles join: cuts an index buffer between equal consecutive vertices, and omits
/// parts that draw nothing. A vertex that is repeated at the very start, for the winding, stays with its strip.
///
/// Later strips may have begun at an odd position; their winding is then reversed when they are drawn alone.
///
/// ```
/// use tristrip::strip::layout::split_joined;
/// let strips: Vec<&[u32]> = split_joined(&[0, 1, 2, 3, 3, 4, 4, 5, 6, 5, 7]).collect();
/// assert_eq!(strips, [&[0, 1, 2, 3][..], &[4, 5, 6, 5, 7]]);
/// ```
pub fn split_joined(indices: &[u32]) -> impl Iterator<Item = &[u32]> {
    let mut end = 0;
    let cut = indices.chunk_by(|a, b| a != b).map(move |part| {
        let start = end;
        end += part.len();
        if start == 1 { &indices[..end] } else { part }
    });
    cut.filter(|part| strip_triangles(part).next().is_some())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::verify::verify_drawing;
    use proptest::prelude::*;

    /// The usual join: the strips in order, two repeats between them, three after an odd number of vertices.
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

    /// The least number of trails over strips as edges between vertices with parities: in each component the number of pairs of nodes of
    /// odd degree, at least one.
    fn fewest_trails(strips: &Strips) -> usize {
        let node = |vertex: u32, odd: bool| vertex as usize * 2 + usize::from(odd);
        let edges = strips.iter().map(|s| (node(s[0], false), node(s[s.len() - 1], s.len() % 2 == 1)));
        let edges: Vec<(usize, usize)> = edges.collect();
        let mut component: Vec<usize> = (0..200).collect();
        let mut odd = [false; 200];
        for &(a, b) in &edges {
            odd[a] = !odd[a];
            odd[b] = !odd[b];
            let (from, to) = (component[a], component[b]);
            component.iter_mut().filter(|c| **c == from).for_each(|c| *c = to);
        }
        let mut used: Vec<usize> = edges.iter().map(|&(a, _)| component[a]).collect();
        used.sort_unstable();
        used.dedup();
        let ends = |c: usize| (0..200).filter(|&node| component[node] == c && odd[node]).count();
        used.into_iter().map(|c| (ends(c) / 2).max(1)).sum()
    }

    proptest! {
        #[test]
        fn every_layout_draws_the_same(lengths in prop::collection::vec(3..9_usize, 0..12), seed in 0..60_u64) {
            let mut strips = Strips::default();
            let mut random = Random::new(seed);
            for length in lengths {
                let strip: Vec<u32> = (0..length).map(|_| random.below(16) as u32).collect();
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

        #[test]
        fn split_undoes_join(indices in prop::collection::vec(0..5_u32, 0..40)) {
            let count = |strip: &[u32]| strip_triangles(strip).count();
            let parts: Vec<&[u32]> = split_joined(&indices).collect();
            prop_assert_eq!(parts.iter().map(|part| count(part)).sum::<usize>(), count(&indices));
            for (i, part) in parts.iter().enumerate() {
                prop_assert!(count(part) > 0);
                let repeat = part[0] == part[1];
                prop_assert!(part[1..].windows(2).all(|w| w[0] != w[1]) && (i == 0 || !repeat));
            }
            let mut strips = Strips::default();
            parts.iter().for_each(|part| strips.push(part));
            prop_assert_eq!(split_joined(&strips.to_degenerate()).count(), strips.len());
        }

        #[test]
        fn few_indices_separate_strips(
            lengths in prop::collection::vec(4..8_usize, 1..20),
            vertices in prop::collection::vec(0..9_u32, 40),
        ) {
            // Strips whose inner vertices differ and whose ends are few.
            let mut strips = Strips::default();
            for (length, ends) in lengths.into_iter().zip(vertices.chunks_exact(2)) {
                let mut strip: Vec<u32> = (90..90 + length as u32).collect();
                strip[0] = ends[0];
                strip[length - 1] = ends[1];
                strips.push(&strip);
            }
            // Two indices between trails, one at the start, and one where the parity changes.
            let most = strips.vertices_sent() + 2 * (fewest_trails(&strips) - 1) + 2;
            let found = strips.to_degenerate().len();
            prop_assert!(found <= most, "{} {}", found, most);
        }
    }
}
