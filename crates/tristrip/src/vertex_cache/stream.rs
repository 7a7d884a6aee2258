//! What is sent to a buffer, over vertices numbered without large gaps.

use std::borrow::Cow;

use super::{FlushPolicy, VertexCache, VertexCacheSimulator, VertexCacheStatistics};
use crate::mesh::SPARSE;
use crate::strip::Strips;

/// Indices in the order in which they are sent.
#[derive(Debug)]
pub(super) struct VertexStream<'a> {
    pub(super) indices: Cow<'a, [u32]>,
    pub(super) vertex_count: usize,
    /// Real triangles.
    pub(super) triangles: usize,
    /// The strips that divide the indices; a list has none.
    strips: Option<&'a Strips>,
}

impl<'a> VertexStream<'a> {
    pub(super) fn strips(strips: &'a Strips, vertex_count: usize) -> Self {
        let triangles = strips.iter().map(real_triangles).sum();
        let (indices, vertex_count) = numbered(strips.vertices(), vertex_count);
        Self { indices, vertex_count, triangles, strips: Some(strips) }
    }

    pub(super) fn list(list: &'a [u32], vertex_count: usize) -> Self {
        let triangles = list.chunks_exact(3).filter(|t| is_real(t)).count();
        let (indices, vertex_count) = numbered(list, vertex_count);
        Self { indices, vertex_count, triangles, strips: None }
    }

    /// Counts the different vertices.
    pub(super) fn vertices(&self) -> usize {
        let mut used = vec![false; self.vertex_count];
        self.indices.iter().for_each(|&v| used[v as usize] = true);
        used.iter().filter(|&&u| u).count()
    }

    /// Hands over the indices from one flush to the next.
    pub(super) fn runs(&self, between: FlushPolicy, mut run: impl FnMut(&[u32])) {
        match self.strips {
            Some(strips) if between == FlushPolicy::Flush => {
                let mut rest = &*self.indices;
                for strip in strips.iter() {
                    let (now, later) = rest.split_at(strip.len());
                    run(now);
                    rest = later;
                }
            }
            _ => run(&self.indices),
        }
    }

    /// Draws with one buffer.
    pub(super) fn with(&self, buffer: VertexCache, between: FlushPolicy) -> VertexCacheStatistics {
        let misses = self.misses(buffer, between);
        VertexCacheStatistics { misses, triangles: self.triangles, vertices: self.vertices() }
    }

    pub(super) fn misses(&self, buffer: VertexCache, between: FlushPolicy) -> usize {
        let mut queue = VertexCacheSimulator::new(buffer, self.vertex_count);
        self.runs(between, |run| {
            queue.flush();
            queue.send_all(run);
        });
        queue.misses()
    }
}

/// Counts the triangles that a strip draws.
pub(super) fn real_triangles(strip: &[u32]) -> usize {
    strip.windows(3).filter(|w| is_real(w)).count()
}

fn is_real(t: &[u32]) -> bool {
    t[0] != t[1] && t[1] != t[2] && t[0] != t[2]
}

/// Numbers the vertices anew, in their order, where only few of them are in use.
fn numbered(indices: &[u32], vertex_count: usize) -> (Cow<'_, [u32]>, usize) {
    if indices.len() >= vertex_count / SPARSE {
        return (Cow::Borrowed(indices), vertex_count);
    }
    let mut used = indices.to_vec();
    used.sort_unstable();
    used.dedup();
    let place = |v: &u32| used.partition_point(|u| u < v) as u32;
    (Cow::Owned(indices.iter().map(place).collect()), used.len())
}
