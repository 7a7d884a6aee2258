//! Moves: what a search changes at the ends of the paths of a cover, each with a limit on the rise of the cost.
//!
//! ```text
//!   w ┄┄ v ━━ a        *join*: v is an end, too: w–v is linked
//!        ┃             *rotation*: v is inside a path: v–a is cut, w–v linked, and a is an end in the place of w
//!        b             *cut*: v–a is cut, which pays where it does away with swaps
//!                      *flip*: where v and a are of one polygon, the diagonal between them is flipped
//! ```

use super::priced::{NONE, Paths};

/// What became of an end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Change {
    /// Nothing.
    Refused,
    /// It was linked to another end over this half-edge.
    Joined(u32),
    /// It was linked over a half-edge to a triangle that was cut off over another, and `end` is an end in its place.
    Grafted { link: u32, cut: u32, end: u32 },
}

/// Tries a join or a graft at an end, as a draw says, unless that raises the cost by more than a limit. The draw's lowest half is not
/// used.
#[inline]
pub(crate) fn change_end(paths: &mut Paths, w: u32, draw: u64, highest_rise: i32) -> Change {
    let link = 4 * w + free_edge(paths.mask(w), (draw >> 32) as u32 & 0xffff);
    let twin = paths.twin(link);
    if twin == NONE {
        return Change::Refused;
    }
    let mask = paths.mask(twin / 4);
    if mask.count_ones() < 2 {
        return if join(paths, link, highest_rise) { Change::Joined(link) } else { Change::Refused };
    }
    let lowest_edge = mask.trailing_zeros();
    let cut = twin & !3 | if draw >> 63 == 1 { lowest_edge } else { mask.ilog2() };
    graft(paths, link, cut, highest_rise).map_or(Change::Refused, |end| Change::Grafted { link, cut, end })
}

/// Picks one of the edges over which an end is not linked.
#[inline]
fn free_edge(mask: u32, draw: u32) -> u32 {
    let inner = mask.trailing_zeros();
    if inner > 2 { (draw * 3) >> 16 } else { (inner + 1 + (draw & 1)) % 3 }
}

/// Links two ends unless that raises the cost by more than a limit.
#[inline]
fn join(paths: &mut Paths, link: u32, highest_rise: i32) -> bool {
    let Some(rise) = paths.join(link) else { return false };
    if rise > highest_rise {
        paths.cut(link);
    }
    rise <= highest_rise
}

/// Cuts a link unless that raises the cost by more than a limit.
#[inline]
pub(crate) fn cut(paths: &mut Paths, link: u32, highest_rise: i32) {
    // The repeat at the start of the path may go, too.
    if paths.cut_rise(link) > highest_rise + paths.prices().swap {
        return;
    }
    if paths.cut(link) > highest_rise {
        paths.join(link);
    }
}

/// Cuts a link of the triangle across `link`, and links it over `link` instead, unless that raises the cost by more than a limit.
/// Returns the new end.
#[inline]
fn graft(paths: &mut Paths, link: u32, cut: u32, highest_rise: i32) -> Option<u32> {
    let released = paths.twin(cut) / 4;
    // Repeats at starts are left out, so that a change is now and then refused that they would have paid for: walking to the ends
    // for each change takes more than twice the time.
    if released == link / 4 || paths.graft_rise(link, cut) > highest_rise {
        return None;
    }
    let rise = paths.cut(cut);
    if let Some(more) = paths.join(link) {
        if rise + more <= highest_rise {
            return Some(released);
        }
        paths.cut(link);
    }
    paths.join(cut);
    None
}

/// Turns a diagonal, and links again what was linked there as far as it can be, unless that raises the cost by more than a limit.
/// The diagonal is linked first or last.
pub(crate) fn turn(paths: &mut Paths, diagonal: u32, diagonal_first: bool, highest_rise: i32) {
    let before = paths.cost();
    // Edges around are known by their other sides, which stay.
    let around = paths.around(diagonal).map(|h| paths.twin(h));
    let links = if diagonal_first {
        [diagonal, around[0], around[1], around[2], around[3]]
    } else {
        [around[0], around[1], around[2], around[3], diagonal]
    };
    let cut = cut_all(paths, links);
    paths.turn_diagonal(diagonal);
    // What is linked now may go over the diagonal for the first time.
    let mut wanted = cut;
    wanted[if diagonal_first { 0 } else { 4 }] = Some(diagonal);
    join_all(paths, wanted);
    if paths.cost() - before > i64::from(highest_rise) {
        cut_all(paths, links);
        (0..3).for_each(|_| paths.turn_diagonal(diagonal));
        join_all(paths, cut);
    }
}

/// Cuts what is linked of some half-edges, and gives that.
fn cut_all(paths: &mut Paths, links: [u32; 5]) -> [Option<u32>; 5] {
    links.map(|h| {
        let is_linked = h != NONE && paths.mask(h / 4) >> (h % 4) & 1 == 1;
        is_linked.then(|| {
            paths.cut(h);
            h
        })
    })
}

/// Joins what can be joined of some half-edges.
fn join_all(paths: &mut Paths, links: [Option<u32>; 5]) {
    for link in links.into_iter().flatten() {
        let twin = paths.twin(link);
        if [link, twin].iter().all(|h| paths.mask(h / 4).count_ones() < 2) {
            paths.join(link);
        }
    }
}
