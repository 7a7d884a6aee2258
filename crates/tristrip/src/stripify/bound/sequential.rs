//! Tests in linear time whether a triangulation is *sequential*: whether one strip passes through all triangles without a swap.
//!
//! Without swaps the turns alternate, so that an entry and the side of the next turn fix all that comes after and all that came
//! before. These *states*, six for each triangle, fall into chains, open or closed:
//!
//! ```text
//!        ╱╲            h ──▶  entered across h at an even place, the walk leaves across the next edge of the
//!       ╱  ╲ ──▶              winding, at an odd place across the previous one, and enters the neighbour
//!      ╱    ╲                 at the other kind of place
//!     ────────
//!        ▲ h
//! ```
//! # Algorithm
//! 1. Follow each open chain from where no state leads in, then each closed one, twice around.
//! 2. Keep the longest run of states up to here that has no triangle twice. If it ever has as many as there are triangles, it
//!    is the strip. The first triangle's entry is not crossed, nor the last one's exit, so that both may be boundaries.
//!
//! A strip begins with the winding of its first triangle, so that its second one stands at an odd place; where that does not fit,
//! the strip has to repeat its first vertex. From the other end an odd number of triangles fits if it did not from this one,
//! an even number does not. Both are chains here.
//!
//! # References
//! Arkin, Held, Mitchell, Skiena: *Hamiltonian triangulations for fast rendering*, 1994; Evans, Skiena, Varshney:
//! *Efficiently Generating Triangle Strips for Fast Rendering*, 1996, section 2. They speak of a cycle of the dual graph; a strip needs
//! a path only, and [`SequentialStrip::is_closed`] tells whether it is a cycle.
//!
//! # Complexity
//! O(n) time; 17 bytes a triangle.

use super::NONE;
use crate::cover::PathCover;
use crate::dual::{DualGraph, HalfEdge};

/// One strip through all triangles, without a swap.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct SequentialStrip {
    /// The strip, as a cover of one path.
    pub cover: PathCover,
    /// Whether it can be sent in T + 2 vertices; if not, its first vertex has to come twice.
    pub keeps_winding: bool,
    /// Whether its turns go on alternating from the last triangle to the first.
    pub is_closed: bool,
}

/// Finds one strip through all triangles of a graph that has no swap, if there is any: in T + 2 vertices if it can be, else in
/// T + 3.
///
/// ```
/// use tristrip::{DualGraph, Faces, stripify::bound::sequential_strip};
/// let row = DualGraph::new(&Faces::from_triangles(vec![0, 1, 2, 2, 1, 3, 2, 3, 4, 4, 3, 5])?);
/// assert!(sequential_strip(&row).is_some_and(|strip| strip.cover.path_count() == 1));
/// let fan = DualGraph::new(&Faces::from_triangles(vec![0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5])?);
/// assert_eq!(sequential_strip(&fan), None);
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn sequential_strip(graph: &DualGraph) -> Option<SequentialStrip> {
    let n = graph.half_edge_count() / 3;
    let twins = triangle_twins(graph)?;
    let run = runs(twins, &vec![0; n], &[n]).pop().flatten()?;
    let mut cover = PathCover::isolated(n);
    let mut state = run.first;
    for _ in 1..n {
        cover.link(graph, HalfEdge(exit(state)));
        state = next(twins, state)?;
    }
    let is_closed = n > 1 && next(twins, state) == Some(run.first);
    Some(SequentialStrip { cover, keeps_winding: run.keeps_winding, is_closed })
}

/// The packed twins of a graph of triangles; `None` for one of polygons.
fn triangle_twins(graph: &DualGraph) -> Option<&[u32]> {
    (graph.half_edge_count() == 3 * graph.face_count()).then(|| graph.twins())
}

/// An entry into a triangle, and whether at an odd place: twice the half-edge and one bit.
type State = (u32, bool);

/// The half-edge across which a walk goes on.
fn exit((entry, is_odd): State) -> u32 {
    let first = entry - entry % 3;
    first + (entry % 3 + if is_odd { 2 } else { 1 }) % 3
}

fn next(twins: &[u32], state: State) -> Option<State> {
    let twin = twins[exit(state) as usize];
    (twin != NONE).then_some((twin, !state.1))
}

/// All triangles of a component in a row, without a swap.
#[derive(Debug, Clone, Copy)]
pub(super) struct Run {
    first: State,
    pub(super) keeps_winding: bool,
}

/// Finds for each component of so many triangles, or none where that is `usize::MAX`, a run through all of it, one that keeps its winding if there is any.
pub(super) fn runs(twins: &[u32], component: &[u32], sizes: &[usize]) -> Vec<Option<Run>> {
    let mut search = Search {
        twins,
        component,
        sizes,
        found: vec![None; sizes.len()],
        visited: vec![0; component.len()],
        last: vec![0; component.len()],
        position: 0,
    };
    for entry in 0..twins.len() as u32 {
        for is_odd in [false, true] {
            // No state leads to an entry without a twin.
            if twins[entry as usize] == NONE && search.size(entry) < usize::MAX {
                search.follow((entry, is_odd), usize::MAX);
            }
        }
    }
    for entry in 0..twins.len() as u32 {
        for is_odd in [false, true] {
            if search.size(entry) < usize::MAX {
                search.follow_closed((entry, is_odd));
            }
        }
    }
    search.found
}

struct Search<'a> {
    twins: &'a [u32],
    component: &'a [u32],
    sizes: &'a [usize],
    found: Vec<Option<Run>>,
    /// The states visited, a bit for each of six.
    visited: Vec<u8>,
    /// The position after the one where each triangle was met last.
    last: Vec<u64>,
    /// The states followed so far, over all chains.
    position: u64,
}

impl Search<'_> {
    /// Gives the size of the component that an entry is in.
    fn size(&self, entry: u32) -> usize {
        self.sizes[self.component[entry as usize / 3] as usize]
    }

    /// Marks a state, and tells whether it was marked already.
    fn visit(&mut self, (entry, is_odd): State) -> bool {
        let bit = 1 << (entry % 3 * 2 + u32::from(is_odd));
        let visited = &mut self.visited[entry as usize / 3];
        let before = *visited;
        *visited |= bit;
        before & bit != 0
    }

    /// Follows a closed chain that was not visited yet, far enough to begin anywhere on it.
    fn follow_closed(&mut self, start: State) {
        let mut length = 0;
        let mut state = start;
        while !self.visit(state) {
            length += 1;
            let Some(after) = next(self.twins, state) else { return };
            state = after;
        }
        let size = self.size(start.0);
        if length >= size {
            self.follow(start, length + size - 1);
        }
    }

    /// Follows a chain for at most so many states and notes a run through the whole component.
    fn follow(&mut self, start: State, at_most: usize) {
        let component = self.component[start.0 as usize / 3] as usize;
        let size = self.sizes[component] as u64;
        // The first state of the longest run without a triangle twice that ends here, and its position.
        let (mut first, mut from) = (start, self.position);
        let mut state = start;
        for _ in 0..at_most {
            self.visit(state);
            let triangle = state.0 as usize / 3;
            while from < self.last[triangle] {
                from += 1;
                first = next(self.twins, first).unwrap_or(first);
            }
            self.position += 1;
            self.last[triangle] = self.position;
            if self.position - from == size {
                let keeps_winding = size < 3 || !first.1;
                if keeps_winding || self.found[component].is_none() {
                    self.found[component] = Some(Run { first, keeps_winding });
                }
            }
            let Some(after) = next(self.twins, state) else { return };
            state = after;
        }
    }
}

#[cfg(test)]
mod tests;
