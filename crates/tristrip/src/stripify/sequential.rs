//! `sequential`: our fast method. Strips are peeled off greedily, each step weighing what it leaves behind, and the ends that
//! remain are then joined by small exchanges.
//!
//! # Algorithm
//! A strip that goes on costs one index a triangle, one more for a swap; a new strip costs three more. So swaps are cheap and ends
//! are dear: a triangle that is left with a single free neighbour will be the end of a strip, half of those three indices.
//!
//! ```text
//!          ╱╲  s   leaving over s takes a swap, over f none
//!         ╱ t╲     go to f, unless then s were left with one free neighbour while f would keep two:
//!   enter ────── f that swap (1) is cheaper than the end (1.5) that s would become
//! ```
//! 1. *Seed*: a triangle with the fewest free neighbours, the last come of them first, so that the free region is peeled
//!    from its rim, next to the last strip; where no triangle has lost a neighbour yet, the first in the input's order.
//! 2. *Run*: a strip's first turn is fixed by its winding, so that each exit of the seed makes one run, which goes on backward over
//!    the edge that needs no swap. Each is tried, and the one of the least cost a triangle is kept.
//! 3. *Exchange*: at every end of a strip, see the module `exchange`. This also folds isolated triangles into their neighbours.
//!
//! On regular meshes, grids above all, a swap at the end of a row saves a strip here to lose one elsewhere, and the order of the
//! input is often the better guide. Such meshes show by their low cost. For them, and for small meshes, where it costs next to
//! nothing, the steps are also done with other seeds and rules for swaps, the cheapest cover is kept, and exchanges that
//! leave the cost as it is are done for a while, since they lead to some that lower it.
//!
//! Departures from the greedy methods of Evans et al. (1996): the tie between neighbours is broken by price, not by rule,
//! and what a run leaves behind is mended by exchanges.
//!
//! # Complexity
//! O(n) time. Beyond the triangles, the dual graph and the cover: 9 bytes a triangle, and 4 for each triangle that loses a
//! neighbour, while it waits.

#[cfg(feature = "rayon")]
mod components;
pub(crate) mod exchange;
mod peel;
mod sheet;
#[cfg(test)]
pub(super) mod tests;

use super::StripPlan;
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::dual::Triangulation;
use crate::prepare::PreparedFaces;
use crate::strip::cover_cost;
use peel::{Peeled, Peeler};
#[cfg(feature = "rayon")]
use rayon::prelude::*;
use sheet::{Polygons, Sheet};

const NONE: u32 = u32::MAX;
/// What a strip costs beyond one index a triangle: two vertices and the restart.
const STRIP: u32 = 3;
/// Regular meshes of more triangles are stripped in the usual manner alone, so that the time for each triangle stays the same.
const LARGE: usize = 1 << 20;
/// Meshes whose strips cost less than so many percent beyond one index a triangle are regular, and stripped likewise. Tuned on the
/// test models: grids and lathed shapes have 0–5, fandisk 15.
const REGULAR_PERCENT: i64 = 6;
/// Least and greatest number of times that the ends of small and regular meshes are gone over again; between them, a quarter of
/// the triangles of a strip on average, so that meshes of few ends get more. Tuned on the same. Past so many triangles it is the
/// least number.
const DRIFTS: (usize, usize) = (8, 64);
const DRIFTS_LIMIT: usize = 1 << 17;

/// Meshes of fewer triangles are stripped by one thread: a manner takes less than a tenth of a millisecond there.
#[cfg(feature = "rayon")]
const WORTH_THREADS: usize = 1024;

/// Which free triangle seeds a strip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Seeds {
    /// One of the fewest free neighbours, the last come.
    Last,
    /// One of the fewest free neighbours, the first come.
    First,
    /// The first in the input's order.
    Input,
}

/// When a run takes a swap.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Swaps {
    /// Where it saves an end, and where there is no other way on.
    Ahead,
    /// Where there is no other way on.
    Blocked,
    /// Never.
    Never,
}

/// When polygons are cut into triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Cuts {
    /// Before.
    Before,
    /// When a strip enters.
    Entering,
}

/// A way to peel strips off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Manner {
    seeds: Seeds,
    swaps: Swaps,
    cuts: Cuts,
    /// Triangles after which a trial run has shown what it costs.
    trial_limit: u32,
}

/// The manner that is best on irregular meshes. Longer trials gain nothing there, and cost time.
const USUAL: Manner =
    Manner { seeds: Seeds::Last, swaps: Swaps::Ahead, cuts: Cuts::Entering, trial_limit: 16 };
/// A longer trial, for regular meshes; it bounds the time, too.
const PATIENT: Manner = Manner { trial_limit: 512, ..USUAL };
/// The others, each of which is the best on some regular or small mesh.
const OTHERS: [Manner; 5] = [
    PATIENT,
    Manner { seeds: Seeds::Input, ..PATIENT },
    Manner { seeds: Seeds::Input, swaps: Swaps::Blocked, ..PATIENT },
    Manner { seeds: Seeds::First, swaps: Swaps::Never, ..PATIENT },
    Manner { seeds: Seeds::Input, swaps: Swaps::Never, ..PATIENT },
];
/// The others for polygons: cut beforehand some quadrilateral grids line up better.
const OTHERS_FOR_POLYGONS: [Manner; 2] =
    [Manner { cuts: Cuts::Before, ..PATIENT }, Manner { seeds: Seeds::Input, cuts: Cuts::Before, ..PATIENT }];

pub(super) fn plan<'a>(surface: &'a PreparedFaces<'_>, graph: &'a DualGraph) -> StripPlan<'a> {
    if let Some(triangulation) = Triangulation::of_triangles(surface, graph) {
        let (_, cover) = cover(|| graph, strip_triangles(graph));
        return StripPlan::new(triangulation, cover);
    }
    let fresh = || Polygons::new(surface.faces(), graph);
    let (polygons, cover) = cover(fresh, strip(fresh(), USUAL));
    StripPlan::new(polygons.into_triangulation(), cover)
}

/// Covers triangles in the usual manner, the components in parallel where that is worth it.
fn strip_triangles(graph: &DualGraph) -> ((&DualGraph, PathCover), i64) {
    #[cfg(feature = "rayon")]
    if let Some((cover, cost)) = components::cover(graph) {
        return ((graph, cover), cost);
    }
    strip(graph, USUAL)
}

/// Covers a sheet in one manner, and gives what the strips cost beyond one index a triangle, but for swaps at their starts.
fn strip<S: Sheet>(sheet: S, manner: Manner) -> ((S, PathCover), i64) {
    let Peeled { mut sheet, mut cover, strip_of, cost } = Peeler::new(sheet, manner).peel();
    let saved = exchange::improve(sheet.graph(), &mut cover, strip_of, 0);
    sheet.settle(&mut cover);
    ((sheet, cover), cost.cast_signed() - saved.cast_signed())
}

/// Covers a sheet, given what the usual manner makes of it.
fn cover<S: Sheet>(fresh: impl Fn() -> S + Sync, (usual, cost): ((S, PathCover), i64)) -> (S, PathCover) {
    let count = usual.1.len();
    let is_regular = 100 * cost < REGULAR_PERCENT * (count as u64).cast_signed();
    if count > S::SMALL && (count > LARGE || !is_regular) {
        return usual;
    }
    // Of each manner the price alone is kept, and the best is done again: time is cheaper here than memory.
    let first = (price(&usual), USUAL);
    drop(usual);
    let for_polygons: &[Manner] = if S::HAS_POLYGONS { &OTHERS_FOR_POLYGONS } else { &[] };
    let others = [&OTHERS, for_polygons].concat();
    let (lowest, manner) = cheapest(first, count, &others, |manner| price(&strip(fresh(), manner).0));
    let ((mut sheet, mut cover), _) = strip(fresh(), manner);
    let most = if count > DRIFTS_LIMIT { DRIFTS.0 } else { DRIFTS.1 };
    let drifts = (count / 4).checked_div(cover.path_count()).unwrap_or(0).clamp(DRIFTS.0, most);
    for _ in 0..ROUNDS {
        let strip_of = cover.renumber(sheet.graph()).path;
        exchange::improve(sheet.graph(), &mut cover, strip_of, (drifts / ROUNDS) as u32);
        sheet.settle(&mut cover);
    }
    let drifted = (sheet, cover);
    if price(&drifted) <= lowest { drifted } else { strip(fresh(), manner).0 }
}

/// Finds the manner of the lowest price, of equals the first; `first` is what is known already.
#[cfg_attr(
    not(feature = "rayon"),
    expect(unused_variables, reason = "the size tells whether threads are worth it")
)]
fn cheapest(
    first: (usize, Manner),
    triangle_count: usize,
    manners: &[Manner],
    price: impl Fn(Manner) -> usize + Sync,
) -> (usize, Manner) {
    let cheaper = |best: (usize, _), other: (usize, _)| if other.0 < best.0 { other } else { best };
    #[cfg(feature = "rayon")]
    if triangle_count >= WORTH_THREADS && rayon::current_num_threads() > 1 {
        // One manner a task.
        let prices: Vec<usize> = manners.par_iter().with_max_len(1).map(|&manner| price(manner)).collect();
        return prices.into_iter().zip(manners.iter().copied()).fold(first, cheaper);
    }
    manners.iter().map(|&manner| (price(manner), manner)).fold(first, cheaper)
}

/// Rounds in which exchanges and the choice of diagonals take turns.
const ROUNDS: usize = 4;

/// Counts what a cover costs in indices.
fn price<S: Sheet>((sheet, cover): &(S, PathCover)) -> usize {
    cover_cost(sheet.graph(), cover)
}

#[inline]
fn next(edge: u32) -> u32 {
    if edge == 2 { 0 } else { edge + 1 }
}

#[inline]
fn previous(edge: u32) -> u32 {
    if edge == 0 { 2 } else { edge - 1 }
}
