//! Moves at the ends of the paths of a cover. Each move has an upper limit on its cost increase.
//!
//! ```text
//!   w ┄┄ v ━━ a        *join*: v is also an end: link w–v
//!        ┃             *rotation*: v is inside a path: cut v–a, link w–v; a replaces w as an end
//!        b             *cut*: cut v–a, which lowers the cost if it removes swaps
//!                      *flip*: if v and a belong to one polygon, flip the diagonal between them
//! ```

use super::priced::PricedPaths;

/// The result of a move at the end of a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum EndMove {
    /// Nothing changed.
    Refused,
    /// The end was linked to another end.
    Joined(Join),
    /// A triangle inside a path was cut across `cut` and linked to the end. `end` is the end that
    /// replaces it.
    Rotated { cut: u32, join: Join, end: u32 },
}

/// A join, with the data to undo it before the paths change again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Join {
    link: u32,
    /// The outer ends of the two paths.
    ends: [u32; 2],
}

impl Join {
    /// Joins two ends. Returns the join and the cost increase, or `None` if the join would close a
    /// path.
    #[inline]
    fn make(paths: &mut PricedPaths, link: u32) -> Option<(Self, i32)> {
        let ends = paths.outer_ends(link);
        paths.join(link).map(|rise| (Self { link, ends }, rise))
    }

    /// Undoes the join.
    #[inline]
    pub(crate) fn undo(self, paths: &mut PricedPaths) {
        paths.cut_between(self.link, self.ends);
    }
}

/// Tries a join or a rotation at an end, chosen by the random bits `draw`, unless the cost would
/// rise by more than `highest_rise`. Only the high half of `draw` is used.
#[inline]
pub(crate) fn move_end(paths: &mut PricedPaths, w: u32, draw: u64, highest_rise: i32) -> EndMove {
    let link = 4 * w + free_edge(paths.mask(w), (draw >> 32) as u32 & 0xffff);
    let Some(twin) = paths.twin(link) else { return EndMove::Refused };
    let mask = paths.mask(twin / 4);
    if mask.count_ones() < 2 {
        return join(paths, link, highest_rise).map_or(EndMove::Refused, EndMove::Joined);
    }
    let lowest_edge = mask.trailing_zeros();
    let cut = twin & !3 | if draw >> 63 == 1 { lowest_edge } else { mask.ilog2() };
    rotate(paths, link, cut, highest_rise).unwrap_or(EndMove::Refused)
}

/// Selects one of the edges over which an end is not linked.
#[inline]
fn free_edge(mask: u32, draw: u32) -> u32 {
    let inner = mask.trailing_zeros();
    if inner > 2 { (draw * 3) >> 16 } else { (inner + 1 + (draw & 1)) % 3 }
}

/// Links two ends unless the cost would rise by more than `highest_rise`.
#[inline]
fn join(paths: &mut PricedPaths, link: u32, highest_rise: i32) -> Option<Join> {
    let (join, rise) = Join::make(paths, link)?;
    if rise > highest_rise {
        join.undo(paths);
        return None;
    }
    Some(join)
}

/// Cuts a link unless the cost would rise by more than `highest_rise`, or the ends of its path are
/// too far away.
#[inline]
pub(crate) fn cut(paths: &mut PricedPaths, link: u32, highest_rise: i32) {
    // The cut may also remove the repeat at the start of the path.
    if paths.cut_rise(link) > highest_rise + paths.prices().swap {
        return;
    }
    if paths.try_cut(link).is_some_and(|rise| rise > highest_rise) {
        paths.join(link);
    }
}

/// Cuts `cut`, a link of the triangle on the other side of `link`, then links this triangle to the
/// end over `link`. Does nothing if the cost would rise by more than `highest_rise`, or the ends
/// are too far away.
#[inline]
fn rotate(paths: &mut PricedPaths, link: u32, cut: u32, highest_rise: i32) -> Option<EndMove> {
    let released = paths.across(cut) / 4;
    // Repeats at starts are not counted here. A rotation that would become affordable through them
    // is occasionally refused; walking to the ends for each rotation would more than double the
    // time.
    if released == link / 4 || paths.rotation_rise(link, cut) > highest_rise {
        return None;
    }
    let rise = paths.try_cut(cut)?;
    if let Some((join, more)) = Join::make(paths, link) {
        if rise + more <= highest_rise {
            return Some(EndMove::Rotated { cut, join, end: released });
        }
        join.undo(paths);
    }
    paths.join(cut);
    None
}

/// Flips a diagonal and restores as many of the links around it as possible, unless the cost would
/// rise by more than `highest_rise` or the ends are too far away. The diagonal is linked first or
/// last.
pub(crate) fn flip_diagonal(paths: &mut PricedPaths, diagonal: u32, diagonal_first: bool, highest_rise: i32) {
    let before = paths.cost();
    // Identify the edges around by their other sides, which do not change.
    let [a, b, c, d] = paths.around(diagonal).map(|h| paths.twin(h));
    let links = if diagonal_first { [Some(diagonal), a, b, c, d] } else { [a, b, c, d, Some(diagonal)] };
    let (cut, is_complete) = cut_all(paths, links);
    if !is_complete {
        join_all(paths, cut);
        return;
    }
    paths.flip_diagonal(diagonal);
    // The diagonal may be linked now even if it was not before.
    let mut wanted = cut;
    wanted[if diagonal_first { 0 } else { 4 }] = Some(diagonal);
    let joined = join_all(paths, wanted);
    if paths.cost() - before > i64::from(highest_rise) {
        joined.into_iter().rev().flatten().for_each(|join| join.undo(paths));
        (0..3).for_each(|_| paths.flip_diagonal(diagonal));
        join_all(paths, cut);
    }
}

/// Cuts all half-edges of `links` that are linked. Returns the half-edges cut, and whether all
/// could be cut.
fn cut_all(paths: &mut PricedPaths, links: [Option<u32>; 5]) -> ([Option<u32>; 5], bool) {
    let mut is_complete = true;
    let cut = links.map(|link| {
        let linked = link.filter(|h| is_complete && paths.mask(h / 4) >> (h % 4) & 1 == 1)?;
        is_complete = paths.try_cut(linked).is_some();
        is_complete.then_some(linked)
    });
    (cut, is_complete)
}

/// Joins all half-edges of `links` that can be joined, and returns the joins.
fn join_all(paths: &mut PricedPaths, links: [Option<u32>; 5]) -> [Option<Join>; 5] {
    links.map(|link| {
        let link = link?;
        let is_free = [link, paths.across(link)].iter().all(|h| paths.mask(h / 4).count_ones() < 2);
        if is_free { Join::make(paths, link).map(|(join, _)| join) } else { None }
    })
}
