//! Index buffers of strips in the four layouts that files and graphics APIs support, and the
//! inverse of the joined layout.
//!
//! # References
//! Evans, Skiena, Varshney: *Efficiently Generating Triangle Strips for Fast Rendering*, 1996,
//! section 1 (swaps by repeated vertices); the draft glTF extension `KHR_mesh_primitive_restart`.

use std::ops::Range;

use super::join::StripRun;
use super::{Strips, join, strip_triangles};
use crate::error::Error;
use crate::ids::vertices_of;
use crate::index::Index;
use crate::mesh::check_triangles;
use crate::names::names;
use crate::text::counted;

/// Changed ranges are merged if fewer than this many equal indices lie between them, because each
/// transfer has a fixed cost.
const MIN_EQUAL_RUN: usize = 16;

/// The layout of strips in an index buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Layout {
    /// Strips separated by the restart index.
    Restart,
    /// All strips, joined into one by degenerate triangles. The winding is kept.
    Degenerate,
    /// One draw call, or primitive, per strip.
    Separate,
    /// A triangle list, in strip order.
    List,
}

names! {
    "tristrip::Layout", Layout, "layout",
    Restart => "restart", "Strips separated by the restart index";
    Degenerate => "degenerate", "One strip joined by degenerate triangles, winding kept";
    Separate => "separate", "One primitive per strip";
    List => "list", "A triangle list, in strip order";
}

impl Strips {
    /// Returns the index buffer in a layout, with indices of 8, 16 or 32 bits. With
    /// [`Layout::Separate`] the strips follow each other without separators; use [`Strips::iter`]
    /// for their lengths.
    ///
    /// # Errors
    /// A vertex does not fit the index type, or equals the restart value in a buffer with restarts.
    ///
    /// ```
    /// use tristrip::{Layout, Strips};
    /// let mut strips = Strips::default();
    /// strips.push(&[0, 1, 2]);
    /// strips.push(&[3, 4, 5]);
    /// let buffer: Vec<u16> = strips.to_indices(Layout::Restart)?;
    /// assert_eq!(buffer, [0, 1, 2, 65_535, 3, 4, 5]);
    /// assert_eq!(strips.to_indices::<u8>(Layout::Degenerate)?, [0, 1, 2, 2, 5, 5, 4, 3]);
    /// strips.push(&[6, 7, 255]);
    /// assert!(strips.to_indices::<u8>(Layout::Restart).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn to_indices<I: Index>(&self, layout: Layout) -> Result<Vec<I>, Error> {
        self.check_indices::<I>(layout)?;
        let mut out = Vec::with_capacity(self.vertices_sent() + self.len());
        self.send_indices(layout, |index| out.push(index));
        Ok(out)
    }

    /// Writes the index buffer in a layout to the start of a slice, for example of mapped memory.
    /// Returns the number of indices written. [`Strips::index_count`] returns that number in
    /// advance.
    ///
    /// # Errors
    /// A vertex does not fit the index type or equals the restart value in a buffer with restarts,
    /// or the slice is too short. In these cases, nothing is written.
    ///
    /// ```
    /// use tristrip::{Layout, Strips};
    /// let mut strips = Strips::default();
    /// strips.push(&[0, 1, 2, 3]);
    /// let mut upload = [0_u16; 8];
    /// assert_eq!(strips.write_indices(Layout::List, &mut upload)?, 6);
    /// assert_eq!(upload, [0, 1, 2, 2, 1, 3, 0, 0]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn write_indices<I: Index>(&self, layout: Layout, out: &mut [I]) -> Result<usize, Error> {
        self.check_indices::<I>(layout)?;
        let count = self.index_count(layout);
        let available = out.len();
        let Some(out) = out.get_mut(..count) else {
            let found = format!("a slice of {} ({count} needed)", counted(available, "index"));
            return Err(Error::Parameter { name: "out", found, expected: "room for the index buffer" });
        };
        let mut free = out.iter_mut();
        self.send_indices(layout, |index| {
            if let Some(place) = free.next() {
                *place = index;
            }
        });
        Ok(count)
    }

    /// Updates an index buffer to the indices of a layout. Returns the changed ranges in ascending
    /// order. Only these need to be uploaded. Ranges with fewer than 16 equal indices between them
    /// are merged.
    ///
    /// # Errors
    /// A vertex does not fit the index type, or equals the restart value in a buffer with restarts.
    /// In these cases, the buffer is unchanged.
    ///
    /// ```
    /// use tristrip::{Layout, Strips};
    /// let mut strips = Strips::default();
    /// strips.push(&[0, 1, 2, 3]);
    /// let mut buffer = vec![0_u16, 1, 7, 3, 4];
    /// assert_eq!(strips.update_indices(Layout::Restart, &mut buffer)?, [2..3]);
    /// assert_eq!(buffer, [0, 1, 2, 3]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn update_indices<I: Index>(
        &self,
        layout: Layout,
        buffer: &mut Vec<I>,
    ) -> Result<Vec<Range<usize>>, Error> {
        self.check_indices::<I>(layout)?;
        let mut changed: Vec<Range<usize>> = Vec::new();
        let mut count = 0;
        self.send_indices(layout, |index: I| {
            let place = count;
            count += 1;
            match buffer.get_mut(place) {
                Some(old) if *old == index => return,
                Some(old) => *old = index,
                None => buffer.push(index),
            }
            match changed.last_mut() {
                Some(last) if place < last.end + MIN_EQUAL_RUN => last.end = place + 1,
                _ => changed.push(place..place + 1),
            }
        });
        buffer.truncate(count);
        Ok(changed)
    }

    /// Counts the indices of a layout. For [`Layout::Degenerate`], the strips are joined to count
    /// the indices.
    ///
    /// ```
    /// use tristrip::{Layout, Strips};
    /// let mut strips = Strips::default();
    /// strips.push(&[0, 1, 2, 3]);
    /// strips.push(&[4, 5, 6]);
    /// let counts: Vec<usize> = Layout::ALL.iter().map(|&layout| strips.index_count(layout)).collect();
    /// assert_eq!(counts, [8, 9, 7, 9]);
    /// ```
    pub fn index_count(&self, layout: Layout) -> usize {
        let mut count = 0;
        match layout {
            Layout::Restart => count = self.vertices_sent() + self.len().saturating_sub(1),
            Layout::Separate => count = self.vertices_sent(),
            Layout::List => count = 3 * self.triangles().count(),
            Layout::Degenerate => self.join(|run| count += run.len()),
        }
        count
    }

    /// Reads strips from an index buffer, and omits parts that draw nothing. A buffer joined by
    /// degenerate triangles is split into its strips, with the same winding. A buffer without
    /// separators ([`Layout::Separate`]) is one strip. In a list, each triangle is one strip.
    ///
    /// # Errors
    /// An index needs more than 32 bits, or the length of a list is not a multiple of three.
    ///
    /// ```
    /// use tristrip::{Layout, Strips};
    /// let strips = Strips::from_indices(&[0_u16, 1, 2, 3, 65_535, 4, 5, 6], Layout::Restart)?;
    /// assert_eq!(strips.iter().collect::<Vec<_>>(), [&[0, 1, 2, 3][..], &[4, 5, 6]]);
    /// // The second strip starts at an odd position, so a repeat keeps its winding.
    /// let strips = Strips::from_indices(&[0_u8, 1, 2, 2, 3, 3, 4, 5, 6], Layout::Degenerate)?;
    /// assert_eq!(strips.iter().collect::<Vec<_>>(), [&[0, 1, 2][..], &[3, 3, 4, 5, 6]]);
    /// assert_eq!(strips.triangles().collect::<Vec<_>>(), [[0, 1, 2], [4, 3, 5], [4, 5, 6]]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn from_indices<I: Index>(indices: &[I], layout: Layout) -> Result<Self, Error> {
        let mut strips = Self::default();
        match layout {
            Layout::Restart => {
                for part in indices.split(|&index| index == I::RESTART) {
                    strips.push_drawing(&vertices_of(part)?);
                }
            }
            Layout::Separate => strips.push_drawing(&vertices_of(indices)?),
            Layout::Degenerate => strips.push_joined(&vertices_of(indices)?),
            Layout::List => {
                check_triangles(indices.len())?;
                for triangle in indices.as_chunks::<3>().0 {
                    strips.push_drawing(&vertices_of(triangle)?);
                }
            }
        }
        Ok(strips)
    }

    /// Appends a strip unless it draws nothing.
    fn push_drawing(&mut self, strip: &[u32]) {
        if strip_triangles(strip).next().is_some() {
            self.push(strip);
        }
    }

    /// Appends the strips of a joined buffer. A strip at an odd position is reversed or repeats its
    /// first vertex.
    fn push_joined(&mut self, joined: &[u32]) {
        for (start, strip) in split_with_starts(joined) {
            if start % 2 == 0 {
                self.push(strip);
            } else if strip.len() % 2 == 1 {
                self.push(&strip.iter().rev().copied().collect::<Vec<_>>());
            } else {
                self.push(&[&strip[..1], strip].concat());
            }
        }
    }

    /// Checks that all vertices fit the index type.
    fn check_indices<I: Index>(&self, layout: Layout) -> Result<(), Error> {
        let is_free =
            |vertex| I::from_vertex(vertex).is_some_and(|i| layout != Layout::Restart || i != I::RESTART);
        let Some(&found) = self.vertices.iter().find(|&&vertex| !is_free(vertex)) else { return Ok(()) };
        let highest = I::RESTART.to_vertex().unwrap_or(u32::MAX);
        let limit = u64::from(highest) - u64::from(layout == Layout::Restart);
        Err(Error::LimitExceeded { what: I::DESCRIPTION, found: u64::from(found), limit })
    }

    /// Sends the indices of a layout. The caller has checked that all vertices fit the index type.
    fn send_indices<I: Index>(&self, layout: Layout, mut send: impl FnMut(I)) {
        let index = |vertex| I::from_vertex(vertex).unwrap_or(I::RESTART);
        match layout {
            Layout::Restart => {
                for (number, strip) in self.iter().enumerate() {
                    if number > 0 {
                        send(I::RESTART);
                    }
                    strip.iter().for_each(|&v| send(index(v)));
                }
            }
            Layout::Separate => self.vertices.iter().for_each(|&v| send(index(v))),
            Layout::List => self.triangles().flatten().for_each(|v| send(index(v))),
            Layout::Degenerate => self.join(|run| run.for_each(|v| send(index(v)))),
        }
    }

    /// Sends the strips, joined by degenerate triangles.
    fn join(&self, send: impl FnMut(StripRun<'_>)) {
        let mut joined = join::JoinedStrips::new(send);
        if self.keeps_order {
            join::in_order(self).for_each(|strip| strip.join_to(&mut joined));
        } else {
            join::order(self).into_iter().for_each(|strip| strip.join_to(&mut joined));
        }
    }

    /// Returns the index buffer with `restart` between strips. Does not check `restart` against the
    /// vertices; [`Strips::to_indices`] does.
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

    /// Joins the strips into one by degenerate triangles. Each strip keeps its winding.
    ///
    /// A join repeats the last vertex of a strip and the first vertex of the next. It repeats the
    /// first vertex again if the next strip would start at an odd position. A join costs nothing if
    /// the next strip starts with the vertex that was sent last. Strips are therefore reordered and
    /// reversed to increase the number of such joins, unless their order is
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
        self.join(|run| run.for_each(|v| out.push(v)));
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

/// Iterates over the strips of a joined index buffer. The buffer is cut between equal consecutive
/// vertices, and parts that draw nothing are omitted. A vertex that is repeated at the start of a
/// strip to preserve the winding remains part of the strip.
///
/// A strip that started at an odd position has the opposite winding when it is drawn alone.
///
/// ```
/// use tristrip::split_joined;
/// let strips: Vec<&[u32]> = split_joined(&[0, 1, 2, 3, 3, 4, 4, 5, 6, 5, 7]).collect();
/// assert_eq!(strips, [&[0, 1, 2, 3][..], &[4, 5, 6, 5, 7]]);
/// ```
pub fn split_joined(indices: &[u32]) -> impl Iterator<Item = &[u32]> {
    split_with_starts(indices).map(|(_, strip)| strip)
}

/// Iterates over the strips of [`split_joined`], each with its start position in the buffer.
fn split_with_starts(indices: &[u32]) -> impl Iterator<Item = (usize, &[u32])> {
    let mut end = 0;
    let cut = indices.chunk_by(|a, b| a != b).map(move |part| {
        let start = end;
        end += part.len();
        if start == 1 { (0, &indices[..end]) } else { (start, part) }
    });
    cut.filter(|(_, part)| strip_triangles(part).next().is_some())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::verify::verify_drawing;
    use proptest::prelude::*;

    /// Joins the strips in the usual way: in order, with two repeats between them and three after
    /// an odd number of vertices.
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

    /// Returns the minimum number of trails when strips are edges between vertices with parities.
    /// Each component needs half as many trails as it has nodes of odd degree, but at least one.
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

    #[test]
    fn indices_that_do_not_fit_are_refused() {
        let mut strips = Strips::default();
        strips.push(&[0, 1, 65_535]);
        let message = |result: Result<Vec<u16>, Error>| result.unwrap_err().to_string();
        assert_eq!(
            message(strips.to_indices(Layout::Restart)),
            "16-bit index: found 65535, the limit is 65534"
        );
        assert_eq!(strips.to_indices::<u16>(Layout::List).unwrap(), [0, 1, 65_535]);
        strips.push(&[1, 2, 65_536]);
        assert_eq!(message(strips.to_indices(Layout::List)), "16-bit index: found 65536, the limit is 65535");
        let mut short = [7_u32; 5];
        let error = strips.write_indices(Layout::List, &mut short).unwrap_err().to_string();
        assert_eq!(
            error,
            "parameter `out`: found a slice of 5 indices (6 needed), expected room for the index buffer"
        );
        assert_eq!(short, [7; 5]);
        let error = Strips::from_indices(&[1_u8, 2], Layout::List).unwrap_err().to_string();
        assert_eq!(error, "faces: number of corners: found 2, expected a multiple of 3");
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

        /// Every layout, in every index width, is read back to the same triangles.
        #[test]
        fn buffers_are_read_back(lengths in prop::collection::vec(3..9_usize, 0..12), seed in 0..60_u64) {
            let mut strips = Strips::default();
            let mut random = Random::new(seed);
            for length in lengths {
                strips.push(&(0..length).map(|_| random.below(16) as u32).collect::<Vec<_>>());
            }
            let sorted = |strips: &Strips| {
                let mut triangles: Vec<_> = strips.triangles().map(crate::mesh::canonical_triangle).collect();
                triangles.sort_unstable();
                triangles
            };
            for layout in [Layout::Restart, Layout::Degenerate, Layout::List] {
                let narrow: Vec<u8> = strips.to_indices(layout).unwrap();
                let wide: Vec<usize> = strips.to_indices(layout).unwrap();
                prop_assert_eq!(narrow.len(), strips.index_count(layout));
                let from_narrow = Strips::from_indices(&narrow, layout).unwrap();
                prop_assert_eq!(sorted(&from_narrow), sorted(&strips));
                prop_assert_eq!(&from_narrow, &Strips::from_indices(&wide, layout).unwrap());
                let mut upload = vec![99; narrow.len() + 1];
                prop_assert_eq!(strips.write_indices(layout, &mut upload).unwrap(), narrow.len());
                prop_assert_eq!((&upload[..narrow.len()], upload[narrow.len()]), (&narrow[..], 99));
            }
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
            // Strips with distinct inner vertices and only a few different end vertices.
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
