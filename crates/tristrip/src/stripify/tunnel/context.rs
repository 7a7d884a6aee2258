//! The data that a tunnel search reads: the graph, the cover and its tags, as red and black edges.

use super::path_tags::{PathTags, TunnelStep};
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::ids::{FaceId, HalfEdge, OptionalId};

/// The graph with its red and black edges.
#[derive(Clone, Copy)]
pub(in crate::stripify) struct SearchContext<'a> {
    pub(in crate::stripify) graph: &'a DualGraph,
    pub(in crate::stripify) cover: &'a PathCover,
    pub(in crate::stripify) tags: &'a PathTags,
}

/// An edge of the dual graph, seen from one of its triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::stripify) struct DualArc {
    pub(in crate::stripify) half_edge: u32,
    pub(in crate::stripify) twin: u32,
}

impl DualArc {
    /// Returns the triangle that the edge leads to.
    #[inline]
    pub(in crate::stripify) fn target(self) -> u32 {
        self.twin / 3
    }
}

impl SearchContext<'_> {
    /// Returns whether a triangle is the end of a strip or isolated.
    #[inline]
    pub(in crate::stripify) fn is_terminal(&self, triangle: u32) -> bool {
        self.cover.degree(FaceId(triangle)) < 2
    }

    /// Returns the triangle on the other side of a half-edge, or `None` at a boundary.
    #[inline]
    pub(in crate::stripify) fn across(&self, half_edge: u32) -> Option<u32> {
        self.graph.twin_of(half_edge).map(|twin| twin / 3)
    }

    /// Iterates over the red edges of a triangle.
    #[inline]
    pub(in crate::stripify) fn red_edges(&self, triangle: u32) -> impl Iterator<Item = DualArc> {
        (3 * triangle..3 * triangle + 3).filter_map(|half_edge| {
            let twin = self.graph.twin_of(half_edge)?;
            (!self.cover.is_linked(HalfEdge(half_edge))).then_some(DualArc { half_edge, twin })
        })
    }

    /// Iterates over the black edges of a triangle.
    #[inline]
    pub(in crate::stripify) fn black_edges(&self, triangle: u32) -> impl Iterator<Item = DualArc> {
        self.cover.edges(FaceId(triangle)).into_iter().flatten().filter_map(|HalfEdge(half_edge)| {
            let twin = self.graph.twin_of(half_edge)?;
            Some(DualArc { half_edge, twin })
        })
    }

    /// Calls `visit` for every step from a triangle over edges that the tunnel does not contain
    /// yet, with the triangle that the step leads to. The triangle is `None` for a step that ends
    /// the tunnel at a terminal.
    #[inline]
    pub(in crate::stripify) fn for_each_step(
        &self,
        tunnel: &[TunnelStep],
        from: u32,
        mut visit: impl FnMut(TunnelStep, Option<u32>),
    ) {
        for red in self.red_edges(from) {
            if tunnel.iter().any(|step| step.red == red.half_edge || step.red == red.twin) {
                continue;
            }
            for black in self.black_edges(red.target()) {
                let step = TunnelStep { red: red.half_edge, black: OptionalId::some(black.half_edge) };
                visit(step, Some(black.target()));
            }
            if self.is_terminal(red.target()) {
                visit(TunnelStep { red: red.half_edge, black: OptionalId::NONE }, None);
            }
        }
    }
}
