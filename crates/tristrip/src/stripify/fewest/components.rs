//! The components of a dual graph that are above their lower bound. Each has its own graph and
//! cover, so they can be searched in parallel.

use crate::cover::PathCover;
use crate::csr::Csr;
use crate::dual::DualGraph;
use crate::ids::{FaceId, HalfEdge};

/// A component whose triangles are numbered from 0, in the order of the whole graph.
#[derive(Debug)]
pub(super) struct UnfinishedComponent {
    triangles: Vec<u32>,
    graph: DualGraph,
    cover: PathCover,
    lower_bound: usize,
}

/// Returns the components that have more paths than their lower bound. `lower_bounds` is in the
/// order of [`DualGraph::components`].
pub(super) fn unfinished(
    graph: &DualGraph,
    cover: &PathCover,
    lower_bounds: &[usize],
) -> Vec<UnfinishedComponent> {
    let (component_of, count) = graph.components();
    let by_component = Csr::group(component_of.iter().copied(), count);
    // The index of each triangle within its component.
    let mut number = vec![0; component_of.len()];
    by_component.rows().for_each(|row| row.iter().zip(0..).for_each(|(&t, n)| number[t as usize] = n));
    let end_count = |row: &[u32]| row.iter().map(|&t| 2 - cover.degree(FaceId(t))).sum::<usize>();
    let rows = by_component.rows().zip(lower_bounds);
    rows.filter(|&(row, &lower_bound)| end_count(row) / 2 > lower_bound)
        .map(|(row, &lower_bound)| UnfinishedComponent::new(graph, cover, row, &number, lower_bound))
        .collect()
}

impl UnfinishedComponent {
    fn new(
        graph: &DualGraph,
        cover: &PathCover,
        triangles: &[u32],
        number: &[u32],
        lower_bound: usize,
    ) -> Self {
        let renumber = |half_edge: u32| 3 * number[half_edge as usize / 3] + half_edge % 3;
        let graph = graph.subgraph(triangles.iter().copied(), renumber);
        let mut own_cover = PathCover::isolated(triangles.len());
        for (n, &t) in (0..).zip(triangles) {
            for half_edge in cover.edges(FaceId(t)).into_iter().flatten() {
                let half_edge = 3 * n + half_edge.0 % 3;
                if let Some(twin) = graph.twin_of(half_edge).filter(|&twin| half_edge < twin) {
                    own_cover.link_unchecked(half_edge, twin);
                }
            }
        }
        Self { triangles: triangles.to_vec(), graph, cover: own_cover, lower_bound }
    }

    pub(super) fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// Returns the first triangle of the component in the whole graph. It identifies the component
    /// independently of the others.
    pub(super) fn first_triangle(&self) -> u32 {
        self.triangles[0]
    }

    /// Returns a lower bound on the number of paths.
    pub(super) fn lower_bound(&self) -> usize {
        self.lower_bound
    }

    /// Returns the component's own graph and cover.
    pub(super) fn graph_and_cover(&mut self) -> (&DualGraph, &mut PathCover) {
        (&self.graph, &mut self.cover)
    }

    /// Replaces the links of the component's triangles in the cover of the whole graph by its own.
    pub(super) fn write_back(&self, graph: &DualGraph, cover: &mut PathCover) {
        for &t in &self.triangles {
            for half_edge in cover.edges(FaceId(t)).into_iter().flatten() {
                cover.cut(graph, half_edge);
            }
        }
        for (n, &t) in (0..).zip(&self.triangles) {
            for half_edge in self.cover.edges(FaceId(n)).into_iter().flatten() {
                // The call from the other side returns `false`.
                cover.link(graph, HalfEdge(3 * t + half_edge.0 % 3));
            }
        }
    }
}
