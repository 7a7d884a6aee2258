//! The indices sent to a vertex cache, with vertices renumbered if they are sparse.

use std::borrow::Cow;

use super::policy::FlushPolicy;
use crate::mesh::{SPARSE, VertexSubset, is_degenerate};
use crate::strip::{Strips, count_triangles};

/// Indices in sending order.
#[derive(Debug)]
pub(super) struct VertexStream<'a> {
    pub(super) indices: Cow<'a, [u32]>,
    pub(super) vertex_count: usize,
    /// Number of triangles, without degenerate ones.
    pub(super) triangles: usize,
    /// The strips that divide the indices; `None` for a list.
    strips: Option<&'a Strips>,
}

impl<'a> VertexStream<'a> {
    pub(super) fn strips(strips: &'a Strips) -> Self {
        let triangles = strips.iter().map(count_triangles).sum();
        let (indices, vertex_count) = numbered(strips.vertices());
        Self { indices, vertex_count, triangles, strips: Some(strips) }
    }

    pub(super) fn list(list: &'a [[u32; 3]]) -> Self {
        let triangles = list.iter().filter(|&&t| !is_degenerate(t)).count();
        let (indices, vertex_count) = numbered(list.as_flattened());
        Self { indices, vertex_count, triangles, strips: None }
    }

    /// Counts the distinct vertices.
    pub(super) fn vertices(&self) -> usize {
        let mut used = vec![false; self.vertex_count];
        self.indices.iter().for_each(|&v| used[v as usize] = true);
        used.iter().filter(|&&u| u).count()
    }

    /// Calls `run` with the indices between consecutive flushes.
    pub(super) fn runs(&self, flush: FlushPolicy, mut run: impl FnMut(&[u32])) {
        match self.strips {
            Some(strips) if flush == FlushPolicy::Flush => {
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
}

/// Renumbers the vertices in ascending order if the indices use few of the vertices up to the
/// highest one.
fn numbered(indices: &[u32]) -> (Cow<'_, [u32]>, usize) {
    let Some(&highest) = indices.iter().max() else { return (Cow::Borrowed(indices), 0) };
    if indices.len() > highest as usize / SPARSE {
        return (Cow::Borrowed(indices), highest as usize + 1);
    }
    let subset = VertexSubset::of(indices);
    (Cow::Owned(subset.numbers(indices)), subset.len())
}
