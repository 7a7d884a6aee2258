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
//! 1. Go along each open chain from where no state leads in, then each closed one, twice around.
//! 2. Find for each place the longest *run* up to there that has no triangle twice. If one ever has as many as there are triangles,
//!    it is the strip. The first triangle's entry is not crossed, nor the last one's exit, so that both may be boundaries.
//!
//! The runs also bound the strips that have swaps. At each swap one run ends and the next begins, and each triangle is at least one part
//! in m of a run, if the longest that it is in has m: these parts add up to the least number of runs.
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
//! O(n) time; 13 bytes a triangle, and 16 for each state of the longest chain.

use std::collections::VecDeque;

use super::NONE;
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::ids::HalfEdge;

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
    let run = runs(twins, &vec![0; n], &[n]).pop()?.whole?;
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

/// What the runs of a component are like.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Runs {
    /// One through all of it: one that keeps its winding, if there is any.
    pub(super) whole: Option<Run>,
    /// How many it takes at least to cover it.
    pub(super) least: usize,
}

/// Looks at the runs of each component, by the component of each triangle and the size of each component.
pub(super) fn runs(twins: &[u32], component: &[u32], sizes: &[usize]) -> Vec<Runs> {
    let mut runs = vec![Runs::default(); sizes.len()];
    let mut last = vec![0; component.len()];
    let mut longest = vec![0; component.len()];
    let (mut from, mut position) = (Vec::new(), 0);
    for_each_chain(twins, |chain, starts_odd| {
        let here = component[chain[0] as usize / 3] as usize;
        run_starts(chain, &mut last, &mut position, &mut from);
        note_longest(chain, &from, &mut longest);
        for (end, &start) in from.iter().enumerate() {
            if end + 1 - start as usize == sizes[here] {
                let first = (chain[start as usize], starts_odd ^ (start % 2 == 1));
                let keeps_winding = sizes[here] < 3 || !first.1;
                if keeps_winding || runs[here].whole.is_none() {
                    runs[here].whole = Some(Run { first, keeps_winding });
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

/// A run, in the parts of it that are added up; they are rounded down, by less than a run for all triangles.
const WHOLE: u64 = 1 << 32;

/// Finds for each state of a chain where the longest run that ends there begins. `last` has the position after the one where each
/// triangle was met last, over all chains, and `position` the position of this one.
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

/// Notes for each triangle the longest run that it is in.
fn note_longest(chain: &[u32], from: &[u32], longest: &mut [u32]) {
    // The runs that nothing can be added to and that have not ended, the longest first and none behind a longer later one.
    let mut open: VecDeque<(u32, u32)> = VecDeque::new();
    let is_last = |end: usize| from.get(end + 1).is_none_or(|&start| start > from[end]);
    let mut ends = (0..chain.len()).filter(|&end| is_last(end)).map(|end| (from[end], end as u32)).peekable();
    for (place, &entry) in (0..).zip(chain) {
        while let Some((start, end)) = ends.next_if(|&(start, _)| start <= place) {
            while open.back().is_some_and(|&(s, e)| e - s <= end - start) {
                open.pop_back();
            }
            open.push_back((start, end));
        }
        while open.front().is_some_and(|&(_, end)| end < place) {
            open.pop_front();
        }
        if let Some((start, end)) = open.front() {
            let longest = &mut longest[entry as usize / 3];
            *longest = (*longest).max(end - start + 1);
        }
    }
}

/// Goes over all chains: the entries of the states, a closed chain twice around, and whether the first is at an odd place.
fn for_each_chain(twins: &[u32], mut go: impl FnMut(&[u32], bool)) {
    let mut visited = vec![0_u8; twins.len() / 3];
    let mut visit = |(entry, is_odd): State| {
        let bit = 1 << (entry % 3 * 2 + u32::from(is_odd));
        let visited = &mut visited[entry as usize / 3];
        let is_new = *visited & bit == 0;
        *visited |= bit;
        is_new
    };
    let states = || (0..twins.len() as u32).flat_map(|entry| [(entry, false), (entry, true)]);
    let mut chain = Vec::new();
    // No state leads to an entry without a twin. What is left then is closed.
    for open in [true, false] {
        for start in states().filter(|&(entry, _)| !open || twins[entry as usize] == NONE) {
            chain.clear();
            let mut state = Some(start);
            while let Some(here) = state.filter(|&here| visit(here)) {
                chain.push(here.0);
                state = next(twins, here);
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
