//! Lower bounds: the minimum number of strips, vertices and indices that any method needs for a
//! mesh.
//!
//! A result that meets its bound is optimal. Otherwise the bound limits the distance from the
//! optimum. A bound holds for all path covers of the given dual graph. At edges of more than two
//! faces, another pairing of the faces may allow fewer strips.
//!
//! # Algorithm
//! A cover of T triangles by S paths has T − S links. The links are a *2-matching*: no triangle has
//! more than two. Therefore T minus the size of a maximum 2-matching is a lower bound on S. This
//! bound is computed by a maximum matching among the triangles with three neighbours. Links of a
//! 2-matching may close cycles, so the bound is improved further:
//! 1. *Bridges* (`blocks`): bridges connect the blocks of the dual graph to form trees. From the
//!    leaves to the root, the algorithm decides for each bridge whether the best cover uses it.
//!    Each block needs a strip or a bridge.
//! 2. *Matching* (`matching`, `strips`): each block gets its own bound.
//! 3. *Subproblems* (`subproblems`, `frontier`): small blocks are solved exactly. In larger blocks,
//!    the neighbourhoods that force path ends are solved exactly.
//!
//! A strip of t triangles has t + 2 vertices, and one more per swap. The number of swaps follows
//! from the number of swap-free runs that cover the triangles (`sequential`). The other bounds
//! follow from these.
//!
//! Faces of more than three corners have several triangulations, and a bound must hold for all of
//! them: see [`Bound::of_prepared`].
//!
//! # References
//! Edmonds, Johnson: *Matching: a well-solved class of integer linear programs*, 1970
//! (2-matchings); Evans, Skiena, Varshney: *Efficiently Generating Triangle Strips for Fast
//! Rendering*, 1996, section 1 (vertices of a strip).
//!
//! # Complexity
//! O(n) time, because all searches are limited to a number of steps per triangle: about one second
//! for a scan of 870,000 triangles, about 10 s in the worst case. 60 bytes per triangle.

mod blocks;
mod frontier;
mod matching;
mod method;
mod neighbours;
mod sequential;
mod strips;
mod subproblems;

use crate::dual::{DualGraph, Triangulation};
use crate::error::Error;
use crate::ids::FaceId;
use crate::mesh::Faces;
use crate::prepare::PreparedFaces;
use crate::strip::Cost;
use crate::union_find::UnionFind;
use strips::ComponentStrips;

pub use method::BoundMethod;
pub use sequential::{SequentialStrip, sequential_strip};

/// Lower bounds for a mesh. No path cover of its dual graph costs less.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Bound {
    /// Number of strips.
    pub strips: usize,
    /// Sum of the strip lengths, including swaps and winding repeats.
    pub vertices_sent: usize,
    /// Sum of the strip lengths with free swaps.
    pub gl_cost: usize,
    /// Length of the index buffer with restarts between strips.
    pub indices_restart: usize,
    /// Length of the index buffer with strips joined by degenerate triangles. The winding is kept.
    pub indices_degenerate: usize,
    /// The bounds of each connected component, in the order of their first faces.
    pub components: Vec<ComponentBound>,
}

/// Lower bounds for a connected component of the dual graph.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct ComponentBound {
    /// Number of triangles of the component's triangulated faces.
    pub triangles: usize,
    /// Number of strips.
    pub strips: usize,
    /// Sum of the strip lengths, including swaps and winding repeats.
    pub vertices_sent: usize,
    /// How the bound on strips was proven.
    pub method: BoundMethod,
}

impl Bound {
    /// Computes the bounds over all covers of a triangulation.
    pub(crate) fn of_triangulation(triangulation: &Triangulation<'_>) -> Self {
        let found = strips::bound(triangulation.graph());
        let runs = runs(triangulation.graph(), &found);
        let mut repeats = 0;
        let components = found.into_iter().zip(runs).map(|(found, runs)| {
            // A strip has two vertices before its first run, one more per further run, and one more
            // if it repeats its first vertex.
            let least_runs = runs.least.max(found.strips).max(if runs.whole.is_some() { 1 } else { 2 });
            let repeat = usize::from(least_runs == 1 && runs.whole.is_some_and(|run| !run.keeps_winding));
            repeats += repeat;
            ComponentBound {
                triangles: found.triangles,
                strips: found.strips,
                vertices_sent: found.triangles + found.strips + least_runs + repeat,
                method: found.method,
            }
        });
        let components = components.collect();
        Self::sum(components, repeats, vertex_groups(triangulation.triangles().chunks_exact(3)))
    }

    /// Computes the bounds over all covers of all triangulations of a mesh.
    ///
    /// If all faces are triangles there is only one triangulation, and the bound is tighter. A face
    /// of k corners counts as k − 2 triangles, and a strip may pass through it several times. Only
    /// faces with at most one neighbour must contain strip ends: one end if there is a neighbour,
    /// otherwise two.
    ///
    /// # Errors
    /// The graph is not the dual graph of the faces.
    ///
    /// ```
    /// use tristrip::{DualGraph, Faces, Mesh, PreparedFaces, stripify::bound::Bound};
    /// // A quadrilateral with another one on each side.
    /// let quads = [[0, 1, 2, 3], [1, 0, 4, 5], [2, 1, 6, 7], [3, 2, 8, 9], [0, 3, 10, 11]];
    /// let mesh = Mesh::new(vec![[0.0; 3]; 12], Faces::from_polygons(quads)?)?;
    /// let prepared = PreparedFaces::new(&mesh, false);
    /// let bound = Bound::of_prepared(&prepared, &DualGraph::new(prepared.faces()))?;
    /// assert_eq!((bound.strips, bound.vertices_sent), (2, 14));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn of_prepared(prepared: &PreparedFaces<'_>, graph: &DualGraph) -> Result<Self, Error> {
        graph.check_faces(prepared.faces())?;
        Ok(match Triangulation::of_triangles(prepared, graph) {
            Some(triangulation) => Self::of_triangulation(&triangulation),
            None => {
                Self::sum(of_polygons(prepared.faces(), graph), 0, vertex_groups(prepared.faces().iter()))
            }
        })
    }

    /// Returns the bound on a cost.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// # let mesh = Mesh::new(vec![[0.0; 3]; 289], Faces::from_triangles(grid)?)?;
    /// # let prepared = PreparedFaces::new(&mesh, false);
    /// # let graph = DualGraph::new(prepared.faces());
    /// let metrics = Metrics::of(&plan(&prepared, &graph, &StripifyOptions::default())?.strips());
    /// let bound = bound::Bound::of_prepared(&prepared, &graph)?;
    /// for cost in Cost::ALL {
    ///     assert!(bound.of(cost) <= cost.of(&metrics), "{cost}");
    /// }
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn of(&self, cost: Cost) -> usize {
        match cost {
            Cost::Restart => self.indices_restart,
            Cost::OpenGl => self.vertices_sent,
            Cost::Degenerate => self.indices_degenerate,
            Cost::Gl => self.gl_cost,
        }
    }

    /// Adds up the bounds of the components. `repeats` is the number of components whose only strip
    /// must repeat its first vertex. `groups` is the number of groups of components that share no
    /// vertex.
    fn sum(components: Vec<ComponentBound>, repeats: usize, groups: usize) -> Self {
        let strips: usize = components.iter().map(|component| component.strips).sum();
        let triangles: usize = components.iter().map(|component| component.triangles).sum();
        let vertices_sent = components.iter().map(|component| component.vertices_sent).sum();
        Self {
            strips,
            vertices_sent,
            gl_cost: triangles + 2 * strips,
            indices_restart: vertices_sent + strips.saturating_sub(1),
            // A join sends nothing if the next strip starts with the vertex sent last, otherwise at
            // least two indices. A strip other than the first needs no repeat if it starts at an
            // odd position.
            indices_degenerate: vertices_sent + 2 * groups.saturating_sub(1)
                - repeats.min(components.len().saturating_sub(1)),
            components,
        }
    }
}

/// Examines the swap-free runs of each component.
fn runs(graph: &DualGraph, found: &[ComponentStrips]) -> Vec<sequential::ComponentRuns> {
    let sizes: Vec<usize> = found.iter().map(|component| component.triangles).collect();
    sequential::runs(graph, &graph.components().0, &sizes)
}

/// Computes the bounds of the components of a mesh of polygons.
///
/// Consider the links over a face's diagonals plus half of the links over its edges. They number at
/// most one less than the triangles of the face if at least two edges are linked, half a link fewer
/// with one linked edge, and one fewer with none. The difference is what the face adds to the
/// strips.
fn of_polygons(faces: &Faces, graph: &DualGraph) -> Vec<ComponentBound> {
    let (component, count) = graph.components();
    let mut sums = vec![(0, 0); count];
    for (face, polygon) in faces.iter().enumerate() {
        let (triangles, ends) = &mut sums[component[face] as usize];
        *triangles += polygon.len() - 2;
        *ends += 2 - graph.neighbours(FaceId(face as u32)).take(2).count();
    }
    sums.into_iter()
        .map(|(triangles, ends)| {
            let strips = ends.div_ceil(2).max(1);
            let method = if strips > 1 { BoundMethod::Leaves } else { BoundMethod::OneStrip };
            ComponentBound { triangles, strips, vertices_sent: triangles + 2 * strips, method }
        })
        .collect()
}

/// Returns the lower bound on strips of each component, in the order of their first triangles.
pub(super) fn strip_lower_bounds(graph: &DualGraph) -> Vec<usize> {
    strips::bound(graph).into_iter().map(|found| found.strips).collect()
}

/// Counts the groups of faces that are not connected by a shared vertex.
fn vertex_groups<'a>(faces: impl Iterator<Item = &'a [u32]> + Clone) -> usize {
    let vertex_count = faces.clone().flatten().max().map_or(0, |&vertex| vertex as usize + 1);
    let mut sets = UnionFind::new(vertex_count);
    let mut is_used = vec![false; vertex_count];
    let mut groups = 0;
    for face in faces {
        for &vertex in face {
            groups += usize::from(!std::mem::replace(&mut is_used[vertex as usize], true));
            if sets.find(face[0]) != sets.find(vertex) {
                sets.unite(face[0], vertex);
                groups -= 1;
            }
        }
    }
    groups
}

#[cfg(test)]
mod tests;
