//! Lower bounds: how few strips, vertices and indices a mesh can be sent in at best, whatever the method.
//!
//! A search that meets a bound is done, and one that does not can say how far from the best it is at most. Every bound holds for all
//! path covers of the given dual graph; where more than two faces meet at an edge, another pairing may allow fewer strips.
//!
//! # Algorithm
//! A cover of T triangles by S paths links T − S pairs of them. The links are a *2-matching*: no triangle has more than
//! two. So T less the size of a maximum 2-matching bounds S from below, and it is found by a maximum matching among the triangles of
//! three neighbours. What a 2-matching does not know is that links must not close a cycle. So:
//! 1. *Bridges* (`blocks`): the dual graph falls apart into blocks that bridges join to trees. From the leaves on it is settled
//!    for each bridge whether the best cover uses it, and each block needs a strip or a bridge.
//! 2. *Matching* (`matching`, `strips`): each block by itself.
//! 3. *Pieces* (`pieces`, `frontier`): small blocks are solved exactly, and of larger ones the neighbourhoods where ends are forced.
//!
//! A strip of t triangles has t + 2 vertices and one more for each swap, of which there are as many as it takes to cover the triangles by
//! runs without a swap (`sequential`). From these the other bounds follow.
//!
//! Faces of more than three corners may be cut in many ways, and a bound must hold for all of them: see [`Bound::of_surface`].
//!
//! # References
//! Edmonds, Johnson: *Matching: a well-solved class of integer linear programs*, 1970 (2-matchings); Evans, Skiena,
//! Varshney: *Efficiently Generating Triangle Strips for Fast Rendering*, 1996, section 1 (vertices of a strip).
//!
//! # Complexity
//! O(n), as all searches are limited by a number of steps for each triangle: about a second for 870,000 triangles of a scan, some 10 s at worst.
//! 60 bytes a triangle.

mod blocks;
mod frontier;
mod matching;
mod pieces;
mod sequential;
mod strips;

use crate::dual::DualGraph;
use crate::dual::Triangulation;
use crate::ids::FaceId;
use crate::mesh::Faces;
use crate::prepare::PreparedFaces;
use crate::strip::Cost;

pub use sequential::{SequentialStrip, sequential_strip};

/// Marks what is not there inside the packed arrays.
const NONE: u32 = u32::MAX;

/// Lower bounds for a mesh. No cover of its dual graph has less of any of them.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Bound {
    /// Strips.
    pub strips: usize,
    /// The sum of the strips' lengths, swaps and winding repeats included.
    pub vertices_sent: usize,
    /// The same with swaps free.
    pub gl_cost: usize,
    /// Length of the index buffer with a restart between strips.
    pub indices_restart: usize,
    /// Length of the index buffer with strips joined by degenerate triangles, winding kept.
    pub indices_degenerate: usize,
    /// What each connected component adds, in order of their first faces.
    pub components: Vec<ComponentBound>,
}

/// Lower bounds for a connected component of the dual graph.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct ComponentBound {
    /// Triangles that its faces make.
    pub triangles: usize,
    /// Strips.
    pub strips: usize,
    /// The sum of the strips' lengths, swaps and winding repeats included.
    pub vertices_sent: usize,
    /// How the bound on strips was found.
    pub proof: Proof,
}

/// How a bound on strips was found, from the plainest means to the best.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Proof {
    /// What is drawn at all takes a strip.
    OneStrip,
    /// Polygons with at most one neighbour each hold an end of a strip.
    Leaves,
    /// A maximum matching in each block, and the best use of the bridges between them.
    Matching,
    /// The same, and pieces of a block that were solved exactly show that it needs more.
    Pieces,
    /// Every block was solved exactly: there is a cover with so many strips.
    Exact,
}

impl Bound {
    /// Bounds all covers of a triangulation.
    ///
    /// ```
    /// use tristrip::{DualGraph, Faces, Mesh, PreparedFaces, dual::Triangulation, stripify::bound::Bound};
    /// // A triangle with a neighbour at each of its edges, and one by itself.
    /// let corners = vec![0, 1, 2, 1, 0, 3, 2, 1, 4, 0, 2, 5, 6, 7, 8];
    /// let mesh = Mesh::new(vec![[0.0; 3]; 9], Faces::from_triangles(corners)?)?;
    /// let surface = PreparedFaces::new(&mesh, false);
    /// let graph = DualGraph::new(surface.faces());
    /// let bound = Bound::of_triangulation(&Triangulation::fan(&surface, &graph));
    /// assert_eq!((bound.strips, bound.vertices_sent, bound.indices_restart), (3, 11, 13));
    /// assert_eq!(bound.components[0].strips, 2);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn of_triangulation(triangulation: &Triangulation<'_>) -> Self {
        let found = strips::bound(triangulation.graph());
        let runs = runs(triangulation.graph(), &found);
        let mut repeats = 0;
        let components = found.into_iter().zip(runs).map(|(found, runs)| {
            // Each strip has two vertices before its first run and one for each more run, or repeat at its start.
            let least_runs = runs.least.max(found.strips).max(if runs.whole.is_some() { 1 } else { 2 });
            let repeat = usize::from(least_runs == 1 && runs.whole.is_some_and(|run| !run.keeps_winding));
            repeats += repeat;
            ComponentBound {
                triangles: found.triangles,
                strips: found.strips,
                vertices_sent: found.triangles + found.strips + least_runs + repeat,
                proof: found.proof,
            }
        });
        let components = components.collect();
        Self::sum(components, repeats, vertex_groups(triangulation.triangles().chunks_exact(3)))
    }

    /// Bounds all covers of all triangulations of a surface.
    ///
    /// Where all faces are triangles there is only one triangulation, and this is [`Bound::of_triangulation`]. A face of k
    /// corners counts as k − 2 triangles; a strip may pass it several times, so that only faces with at most one neighbour are
    /// sure to hold an end of a strip, or two.
    ///
    /// ```
    /// use tristrip::{DualGraph, Faces, Mesh, PreparedFaces, stripify::bound::Bound};
    /// // A quadrilateral with another at each side.
    /// let quads = [[0, 1, 2, 3], [1, 0, 4, 5], [2, 1, 6, 7], [3, 2, 8, 9], [0, 3, 10, 11]];
    /// let mesh = Mesh::new(vec![[0.0; 3]; 12], Faces::from_polygons(quads)?)?;
    /// let surface = PreparedFaces::new(&mesh, false);
    /// let bound = Bound::of_surface(&surface, &DualGraph::new(surface.faces()));
    /// assert_eq!((bound.strips, bound.vertices_sent), (2, 14));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn of_surface(surface: &PreparedFaces<'_>, graph: &DualGraph) -> Self {
        match Triangulation::of_triangles(surface, graph) {
            Some(triangulation) => Self::of_triangulation(&triangulation),
            None => Self::sum(of_polygons(surface.faces(), graph), 0, vertex_groups(surface.faces().iter())),
        }
    }

    /// Picks the bound for a cost.
    pub fn of(&self, cost: Cost) -> usize {
        match cost {
            Cost::Restart => self.indices_restart,
            Cost::OpenGl => self.vertices_sent,
            Cost::Degenerate => self.indices_degenerate,
            Cost::Gl => self.gl_cost,
        }
    }

    /// Adds up what the components need; `repeats` counts those of which the only strip must repeat its first vertex, and `groups`
    /// those sets of them that share no vertex.
    fn sum(components: Vec<ComponentBound>, repeats: usize, groups: usize) -> Self {
        let strips: usize = components.iter().map(|component| component.strips).sum();
        let triangles: usize = components.iter().map(|component| component.triangles).sum();
        let vertices_sent = components.iter().map(|component| component.vertices_sent).sum();
        Self {
            strips,
            vertices_sent,
            gl_cost: triangles + 2 * strips,
            indices_restart: vertices_sent + strips.saturating_sub(1),
            // A join sends nothing where the next strip begins with the vertex sent last, else two indices at least. A strip other
            // than the first needs no repeat where it comes to an odd place.
            indices_degenerate: vertices_sent + 2 * groups.saturating_sub(1)
                - repeats.min(components.len().saturating_sub(1)),
            components,
        }
    }
}

/// Looks at the runs without a swap of each component.
fn runs(graph: &DualGraph, found: &[strips::Component]) -> Vec<sequential::Runs> {
    let sizes: Vec<usize> = found.iter().map(|component| component.triangles).collect();
    sequential::runs(graph.twins(), &graph.components().0, &sizes)
}

/// Bounds the components of a surface of polygons.
///
/// The links in a face's own diagonals and half of those over its edges are at most one less than its triangles where two edges
/// or more are linked, half a link fewer at one, one fewer at none; the difference is what the face adds to the strips.
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
            let proof = if strips > 1 { Proof::Leaves } else { Proof::OneStrip };
            ComponentBound { triangles, strips, vertices_sent: triangles + 2 * strips, proof }
        })
        .collect()
}

/// Finds the least number of strips of each component, in order of their first triangles.
pub(super) fn strip_lower_bounds(graph: &DualGraph) -> Vec<usize> {
    strips::bound(graph).into_iter().map(|found| found.strips).collect()
}

/// Counts the sets of faces that no shared vertex joins.
fn vertex_groups<'a>(faces: impl Iterator<Item = &'a [u32]> + Clone) -> usize {
    let vertex_count = faces.clone().flatten().max().map_or(0, |&vertex| vertex as usize + 1);
    let mut above = vec![NONE; vertex_count];
    let mut groups = 0;
    for face in faces {
        let mut joined = None;
        for &vertex in face {
            if above[vertex as usize] == NONE {
                above[vertex as usize] = vertex;
                groups += 1;
            }
            let top = topmost(&mut above, vertex);
            let other = *joined.get_or_insert(top);
            if top != other {
                above[top.max(other) as usize] = top.min(other);
                joined = Some(top.min(other));
                groups -= 1;
            }
        }
    }
    groups
}

/// Follows a union's links to its name, halving the way.
fn topmost(above: &mut [u32], node: u32) -> u32 {
    let mut node = node as usize;
    while above[node] as usize != node {
        above[node] = above[above[node] as usize];
        node = above[node] as usize;
    }
    node as u32
}

#[cfg(test)]
mod tests;
