//! The components of a dual graph that are not done, each with a graph and a cover of its own, so that they can be worked on one
//! beside the other.

use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::ids::{FaceId, HalfEdge};

const NONE: u32 = u32::MAX;

/// A component whose triangles are numbered from 0, in the order of their numbers in the whole graph.
#[derive(Debug)]
pub(super) struct Component {
    triangles: Vec<u32>,
    graph: DualGraph,
    cover: PathCover,
    floor: usize,
}

/// Lists the components that have more paths than their floor; `floors` stand in the order of [`DualGraph::components`].
pub(super) fn unfinished(graph: &DualGraph, cover: &PathCover, floors: &[usize]) -> Vec<Component> {
    let (component_of, count) = graph.components();
    let mut end_counts = vec![0; count];
    for (t, &component) in (0..).zip(&component_of) {
        end_counts[component as usize] += 2 - cover.degree(FaceId(t));
    }
    let unfinished: Vec<bool> =
        end_counts.iter().zip(floors).map(|(&ends, &floor)| ends / 2 > floor).collect();
    let mut triangles: Vec<Vec<u32>> = vec![Vec::new(); count];
    // The number of each triangle within its component.
    let mut number = vec![NONE; component_of.len()];
    for (t, &component) in (0..).zip(&component_of) {
        if unfinished[component as usize] {
            let list = &mut triangles[component as usize];
            number[t as usize] = list.len() as u32;
            list.push(t);
        }
    }
    let parts = triangles.into_iter().zip(floors).filter(|(triangles, _)| !triangles.is_empty());
    parts.map(|(triangles, &floor)| Component::new(graph, cover, triangles, &number, floor)).collect()
}

impl Component {
    fn new(graph: &DualGraph, cover: &PathCover, triangles: Vec<u32>, number: &[u32], floor: usize) -> Self {
        let mut twins = Vec::with_capacity(3 * triangles.len());
        for &t in &triangles {
            let around = &graph.twins()[3 * t as usize..3 * t as usize + 3];
            twins.extend(around.iter().map(|&twin| match twin {
                NONE => NONE,
                twin => 3 * number[twin as usize / 3] + twin % 3,
            }));
        }
        let mut own = PathCover::isolated(triangles.len());
        for (n, &t) in (0..).zip(&triangles) {
            for half_edge in cover.edges(FaceId(t)).into_iter().flatten() {
                let half_edge = 3 * n + half_edge.0 % 3;
                if half_edge < twins[half_edge as usize] {
                    own.link_unchecked(half_edge, twins[half_edge as usize]);
                }
            }
        }
        Self { triangles, graph: DualGraph::from_triangle_twins(twins), cover: own, floor }
    }

    pub(super) fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// The first triangle in the whole graph: a name that does not depend on the other components.
    pub(super) fn first_triangle(&self) -> u32 {
        self.triangles[0]
    }

    /// Fewer paths than this there cannot be.
    pub(super) fn floor(&self) -> usize {
        self.floor
    }

    /// The component's own graph and its cover.
    pub(super) fn parts(&mut self) -> (&DualGraph, &mut PathCover) {
        (&self.graph, &mut self.cover)
    }

    /// Puts the component's links in the place of those that the whole graph's cover has there.
    pub(super) fn put_back(&self, graph: &DualGraph, cover: &mut PathCover) {
        for &t in &self.triangles {
            for half_edge in cover.edges(FaceId(t)).into_iter().flatten() {
                cover.cut(graph, half_edge);
            }
        }
        for (n, &t) in (0..).zip(&self.triangles) {
            for half_edge in self.cover.edges(FaceId(n)).into_iter().flatten() {
                // From the other side it is refused.
                cover.link(graph, HalfEdge(3 * t + half_edge.0 % 3));
            }
        }
    }
}
