//! Moves: what a search changes at the ends of the paths of a cover, each with a limit on the rise of the cost.
//!
//! ```text
//!   w ┄┄ v ━━ a        *join*: v is an end, too: w–v is linked
//!        ┃             *rotation*: v is inside a path: v–a is cut, w–v is linked, and a becomes an end instead of w
//!        b             *cut*: v–a is cut, which pays off if it removes swaps
//!                      *flip*: if v and a belong to one polygon, the diagonal between them is flipped
//! ```

use super::priced::PricedPaths;

/// The result of a move at an end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum EndMove {
    /// Nothing changed.
    Refused,
    /// The end was linked to another end over this half-edge.
    Joined(u32),
    /// The end was linked over `link` to a triangle whose link over `cut` was removed; `end` is the end that replaces it.
    Rotated { link: u32, cut: u32, end: u32 },
}

/// Tries a join or a rotation at an end, chosen by the random bits `draw`, unless it raises the cost by more than a limit. The low half of
/// `draw` is not used.
#[inline]
pub(crate) fn move_end(paths: &mut PricedPaths, w: u32, draw: u64, highest_rise: i32) -> EndMove {
    let link = 4 * w + free_edge(paths.mask(w), (draw >> 32) as u32 & 0xffff);
    let Some(twin) = paths.twin(link) else { return EndMove::Refused };
    let mask = paths.mask(twin / 4);
    if mask.count_ones() < 2 {
        return if join(paths, link, highest_rise) { EndMove::Joined(link) } else { EndMove::Refused };
    }
    let lowest_edge = mask.trailing_zeros();
    let cut = twin & !3 | if draw >> 63 == 1 { lowest_edge } else { mask.ilog2() };
    rotate(paths, link, cut, highest_rise).map_or(EndMove::Refused, |end| EndMove::Rotated { link, cut, end })
}

/// Selects one of the edges over which an end is not linked.
#[inline]
fn free_edge(mask: u32, draw: u32) -> u32 {
    let inner = mask.trailing_zeros();
    if inner > 2 { (draw * 3) >> 16 } else { (inner + 1 + (draw & 1)) % 3 }
}

/// Links two ends unless that raises the cost by more than a limit.
#[inline]
fn join(paths: &mut PricedPaths, link: u32, highest_rise: i32) -> bool {
    let Some(rise) = paths.join(link) else { return false };
    if rise > highest_rise {
        paths.cut(link);
    }
    rise <= highest_rise
}

/// Cuts a link unless that raises the cost by more than a limit.
#[inline]
pub(crate) fn cut(paths: &mut PricedPaths, link: u32, highest_rise: i32) {
    // The repeat at the start of the path may go, too.
    if paths.cut_rise(link) > highest_rise + paths.prices().swap {
        return;
    }
    if paths.cut(link) > highest_rise {
        paths.join(link);
    }
}

/// Cuts a link of the triangle across `link` and links the triangle over `link` instead, unless that raises the cost by more than a
/// limit. Returns the new end.
#[inline]
fn rotate(paths: &mut PricedPaths, link: u32, cut: u32, highest_rise: i32) -> Option<u32> {
    let released = paths.across(cut) / 4;
    // Repeats at starts are not counted, so a rotation is occasionally refused that they would have paid for: walking to the ends
    // for each rotation takes more than twice the time.
    if released == link / 4 || paths.rotation_rise(link, cut) > highest_rise {
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

/// Flips a diagonal and restores as many of the links around it as possible, unless that raises the cost by more than a limit.
/// The diagonal is linked first or last.
pub(crate) fn flip_diagonal(paths: &mut PricedPaths, diagonal: u32, diagonal_first: bool, highest_rise: i32) {
    let before = paths.cost();
    // The edges around are identified by their other sides, which do not change.
    let [a, b, c, d] = paths.around(diagonal).map(|h| paths.twin(h));
    let links = if diagonal_first { [Some(diagonal), a, b, c, d] } else { [a, b, c, d, Some(diagonal)] };
    let cut = cut_all(paths, links);
    paths.flip_diagonal(diagonal);
    // The diagonal may be linked now even if it was not before.
    let mut wanted = cut;
    wanted[if diagonal_first { 0 } else { 4 }] = Some(diagonal);
    join_all(paths, wanted);
    if paths.cost() - before > i64::from(highest_rise) {
        cut_all(paths, links);
        (0..3).for_each(|_| paths.flip_diagonal(diagonal));
        join_all(paths, cut);
    }
}

/// Cuts those of some half-edges that are linked, and returns them.
fn cut_all(paths: &mut PricedPaths, links: [Option<u32>; 5]) -> [Option<u32>; 5] {
    links.map(|link| {
        let linked = link.filter(|h| paths.mask(h / 4) >> (h % 4) & 1 == 1)?;
        paths.cut(linked);
        Some(linked)
    })
}

/// Joins those of some half-edges that can be joined.
fn join_all(paths: &mut PricedPaths, links: [Option<u32>; 5]) {
    for link in links.into_iter().flatten() {
        let twin = paths.across(link);
        if [link, twin].iter().all(|h| paths.mask(h / 4).count_ones() < 2) {
            paths.join(link);
        }
    }
}
