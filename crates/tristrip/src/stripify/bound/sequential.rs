//! Tests in linear time whether a triangulation is *sequential*: one strip visits all triangles
//! without a swap.
//!
//! Without swaps the turns alternate, so an entry edge and the side of the next turn determine the
//! whole strip in both directions. These *states*, six per triangle, form open or closed chains:
//!
//! ```text
//!        ╱╲            h ──▶  a strip that enters across h leaves across the next edge of the
//!       ╱  ╲ ──▶              winding if the triangle has an even position, and across the
//!      ╱    ╲                 previous edge if it has an odd one. It enters the neighbour at a
//!     ────────                position of the other parity.
//!        ▲ h
//! ```
//! # Algorithm
//! 1. Follow each open chain from the state without a predecessor, then each closed chain twice
//!    around.
//! 2. Find the longest *run* that ends at each state and contains no triangle twice. A run with all
//!    triangles of the mesh is the strip. The entry of its first triangle and the exit of its last
//!    one are not crossed, so both may be boundary edges.
//!
//! The runs also bound strips with swaps. At each swap a run ends and the next one starts. If the
//! longest run that contains a triangle has m triangles, the triangle accounts for at least 1/m of
//! a run. The sum over all triangles is a lower bound on the number of runs.
//!
//! A strip keeps the winding of its first triangle only if the second triangle is at an odd
//! position; otherwise the strip must repeat its first vertex. Reversing a strip changes the parity
//! if the number of triangles is odd. The chains therefore contain every strip in both directions.
//!
//! # References
//! Arkin, Held, Mitchell, Skiena: *Hamiltonian triangulations for fast rendering*, 1994; Evans,
//! Skiena, Varshney: *Efficiently Generating Triangle Strips for Fast Rendering*, 1996, section 2.
//! These papers require a cycle of the dual graph. A strip needs only a path;
//! [`SequentialStrip::is_closed`] is true if the path is a cycle.
//!
//! # Complexity
//! O(n) time, 13 bytes per triangle, and 16 bytes per state of the longest chain.

use std::collections::VecDeque;

use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::ids::HalfEdge;

/// A strip without swaps through all triangles.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct SequentialStrip {
    /// The strip, as a cover of one path.
    pub cover: PathCover,
    /// Whether the strip has T + 2 vertices for T triangles. Otherwise its first vertex is
    /// repeated.
    pub keeps_winding: bool,
    /// Whether the turns also alternate from the last triangle to the first.
    pub is_closed: bool,
}

/// Finds a strip without swaps through all T triangles of a graph. The strip has T + 2 vertices if
/// possible, otherwise T + 3. Returns `None` if there is no such strip, or if the graph contains
/// polygons.
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
    let n = graph.face_count();
    if !graph.is_of_triangles() {
        return None;
    }
    let run = runs(graph, &vec![0; n], &[n]).pop()?.whole?;
    let mut cover = PathCover::isolated(n);
    let mut state = run.first;
    for _ in 1..n {
        cover.link(graph, HalfEdge(exit(state)));
        state = next(graph, state)?;
    }
    let is_closed = n > 1 && next(graph, state) == Some(run.first);
    Some(SequentialStrip { cover, keeps_winding: run.keeps_winding, is_closed })
}

/// The half-edge across which a triangle is entered, and whether the position is odd.
type EntryState = (u32, bool);

/// Returns the half-edge across which the strip leaves.
fn exit((entry, is_odd): EntryState) -> u32 {
    let first = entry - entry % 3;
    first + (entry % 3 + if is_odd { 2 } else { 1 }) % 3
}

/// Returns the next state of the chain.
fn next(graph: &DualGraph, state: EntryState) -> Option<EntryState> {
    Some((graph.twin_of(exit(state))?, !state.1))
}

/// A run through all triangles of a component.
#[derive(Debug, Clone, Copy)]
pub(super) struct WholeRun {
    first: EntryState,
    pub(super) keeps_winding: bool,
}

/// The runs of a component.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ComponentRuns {
    /// A run through the whole component, if there is one. A run that keeps its winding is
    /// preferred.
    pub(super) whole: Option<WholeRun>,
    /// A lower bound of the number of runs that cover the component.
    pub(super) least: usize,
}

/// Examines the runs of each component. `component` has the component of each triangle, and `sizes`
/// the number of triangles of each component.
pub(super) fn runs(graph: &DualGraph, component: &[u32], sizes: &[usize]) -> Vec<ComponentRuns> {
    let mut runs = vec![ComponentRuns::default(); sizes.len()];
    let mut last = vec![0; component.len()];
    let mut longest = vec![0; component.len()];
    let (mut from, mut position) = (Vec::new(), 0);
    for_each_chain(graph, |chain, starts_odd| {
        let here = component[chain[0] as usize / 3] as usize;
        run_starts(chain, &mut last, &mut position, &mut from);
        update_longest(chain, &from, &mut longest);
        for (end, &start) in from.iter().enumerate() {
            if end + 1 - start as usize == sizes[here] {
                let first = (chain[start as usize], starts_odd ^ (start % 2 == 1));
                let keeps_winding = sizes[here] < 3 || !first.1;
                if keeps_winding || runs[here].whole.is_none() {
                    runs[here].whole = Some(WholeRun { first, keeps_winding });
                }
            }
        }
    });
    let mut parts = vec![0; sizes.len()];
    for (&component, &longest) in component.iter().zip(&longest) {
        parts[component as usize] += WHOLE / u64::from(longest.max(1));
    }
    for (runs, parts) in runs.iter_mut().zip(parts) {
        runs.least = parts.div_ceil(WHOLE) as usize;
    }
    runs
}

/// The fixed-point value of a whole run. The shares of a run are rounded down, which loses less
/// than one run over all triangles.
const WHOLE: u64 = 1 << 32;

/// Finds, for each state of a chain, the start of the longest run that ends there. `last` has the
/// position after the last occurrence of each triangle, counted over all chains. `position` is the
/// position of this chain.
fn run_starts(chain: &[u32], last: &mut [u64], position: &mut u64, from: &mut Vec<u32>) {
    let begin = *position;
    let mut start = 0;
    from.clear();
    for &entry in chain {
        let last = &mut last[entry as usize / 3];
        start = start.max(last.saturating_sub(begin) as u32);
        *position += 1;
        *last = *position;
        from.push(start);
    }
}

/// Updates, for each triangle, the length of the longest run that contains it.
fn update_longest(chain: &[u32], from: &[u32], longest: &mut [u32]) {
    // The maximal runs that have started and not ended, longest first. A run that ends before a
    // longer one is omitted.
    let mut open: VecDeque<(u32, u32)> = VecDeque::new();
    let is_last = |end: usize| from.get(end + 1).is_none_or(|&start| start > from[end]);
    let mut ends = (0..chain.len()).filter(|&end| is_last(end)).map(|end| (from[end], end as u32)).peekable();
    for (position, &entry) in (0..).zip(chain) {
        while let Some((start, end)) = ends.next_if(|&(start, _)| start <= position) {
            while open.back().is_some_and(|&(s, e)| e - s <= end - start) {
                open.pop_back();
            }
            open.push_back((start, end));
        }
        while open.front().is_some_and(|&(_, end)| end < position) {
            open.pop_front();
        }
        if let Some((start, end)) = open.front() {
            let longest = &mut longest[entry as usize / 3];
            *longest = (*longest).max(end - start + 1);
        }
    }
}

/// Calls `go` for each chain, with the entries of its states and whether the first position is odd.
/// Closed chains are passed twice around.
fn for_each_chain(graph: &DualGraph, mut go: impl FnMut(&[u32], bool)) {
    let mut visited = vec![0_u8; graph.face_count()];
    let mut visit = |(entry, is_odd): EntryState| {
        let bit = 1 << (entry % 3 * 2 + u32::from(is_odd));
        let visited = &mut visited[entry as usize / 3];
        let is_new = *visited & bit == 0;
        *visited |= bit;
        is_new
    };
    let states = || (0..graph.half_edge_count() as u32).flat_map(|entry| [(entry, false), (entry, true)]);
    let mut chain = Vec::new();
    // No state leads to an entry without a twin, so open chains start there. The remaining chains
    // are closed.
    for open in [true, false] {
        for start in states().filter(|&(entry, _)| !open || graph.twin_of(entry).is_none()) {
            chain.clear();
            let mut state = Some(start);
            while let Some(here) = state.filter(|&here| visit(here)) {
                chain.push(here.0);
                state = next(graph, here);
            }
            if !open {
                chain.extend_from_within(..);
            }
            if !chain.is_empty() {
                go(&chain, start.1);
            }
        }
    }
}

#[cfg(test)]
mod tests;
