//! Orders the triangles in a buffer to keep uploads small: triangles that change together are
//! stored together.
//!
//! ```text
//! levels of a key     ├───────────────┤          triangles that change on both sides of the middle
//!                     ├───────┼───────┤          on one side, but on both sides of its quarter
//!                     ├───┼───┼───┼───┤          within one quarter
//! ```
//! A collapse changes a few triangles anywhere in the strips, so without this order a level change
//! would write slots in all parts of the buffer. Here the levels of a key are divided into
//! intervals by repeated halving. A triangle belongs to the smallest interval that contains all its
//! changes, or to no interval if it never changes. The buffer stores the triangles of each interval
//! together. A level change uploads the intervals that contain it.
//!
//! # Algorithm
//! Strips are split into pieces of one interval each. A triangle may also be put into a larger
//! interval, which is uploaded more often. A triangle that never changes may be put into any
//! interval. The chosen pieces minimize the vertices added by cuts plus the uploaded slots times a
//! price. They are found by dynamic programming over the triangles of a strip and the intervals
//! that contain them.
//!
//! # Complexity
//! For each triangle, one step per pair of an interval that contains it and an interval that
//! contains the previous triangle. At most ten intervals contain a triangle. Long strips are
//! processed in segments of [`SEGMENT`] triangles, each at minimum cost, to limit memory.

use crate::lod::level::index_map::RESTART;
use crate::mesh::is_degenerate;

/// The cost of a cut: two repeated vertices and a restart.
const CUT: f32 = 3.0;

/// The price of a slot that every level change uploads.
const UPLOAD: f32 = 6.0;

/// The number of triangles after one that never changes that are searched for one that does.
const LOOK_AHEAD: usize = 16;

/// The number of triangles processed at once.
const SEGMENT: usize = 1 << 12;

/// The maximum number of halvings.
const MAX_DEPTH: u32 = 9;

/// An interval of levels: the number of halvings, and the index of the part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Interval {
    depth: u32,
    number: u32,
}

/// The interval of a piece; `None` if it never changes.
type Label = Option<Interval>;

impl Interval {
    fn parent(self) -> Option<Self> {
        let depth = self.depth.checked_sub(1)?;
        Some(Self { depth, number: self.number / 2 })
    }

    /// Returns the position of the interval in the buffer order, which is that of its middle.
    fn place(self) -> u32 {
        (2 * self.number + 1) << (MAX_DEPTH - self.depth)
    }
}

/// For each slot of a buffer, the first and the last collapse that changes it, counted from the
/// key.
#[derive(Debug)]
pub(super) struct SlotChanges {
    spans: Vec<Option<[u32; 2]>>,
    collapse_count: u32,
    depth: u32,
}

impl SlotChanges {
    /// Creates the state of slots that never change. Levels are halved until a part has at most
    /// `smallest` collapses.
    pub(super) fn new(slot_count: usize, collapse_count: usize, smallest: usize) -> Self {
        let depth = (0..MAX_DEPTH).find(|depth| collapse_count >> depth <= smallest).unwrap_or(MAX_DEPTH);
        Self { spans: vec![None; slot_count], collapse_count: collapse_count as u32, depth }
    }

    /// Records that a collapse changes a slot. Call it in the order of the collapses.
    pub(super) fn add(&mut self, slot: u32, collapse: u32) {
        let span = &mut self.spans[slot as usize];
        *span = Some([span.map_or(collapse, |[first, _]| first), collapse]);
    }

    /// Returns the smallest interval that contains all changes of three slots.
    fn label(&self, first: usize) -> Label {
        let spans = self.spans[first..first + 3].iter().flatten();
        let [first, last] = spans.copied().reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])?;
        // The index of the part that contains a collapse, at the maximum depth.
        let part =
            |collapse: u32| (u64::from(collapse) << self.depth) / u64::from(self.collapse_count.max(1));
        let (mut a, mut b, mut depth) = (part(first) as u32, part(last) as u32, self.depth);
        while a != b {
            (a, b, depth) = (a / 2, b / 2, depth - 1);
        }
        Some(Interval { depth, number: a })
    }
}

/// Returns the strips of an index map, split into pieces in the order of their intervals.
pub(super) fn ordered(entries: &[u32], changes: &SlotChanges) -> Vec<u32> {
    let mut pieces: Vec<(u32, usize, usize, bool)> = Vec::new();
    let mut start = 0;
    for strip in entries.split(|&entry| entry == RESTART) {
        let triangle_count = strip.len().saturating_sub(2);
        let labels: Vec<Label> = (start..start + triangle_count).map(|first| changes.label(first)).collect();
        let chosen: Vec<Label> = labels.chunks(SEGMENT).flat_map(cheapest).collect();
        let mut begin = 0;
        for piece in chosen.chunk_by(|a, b| a == b) {
            let is_drawn = |i: &usize| !is_degenerate([strip[*i], strip[i + 1], strip[i + 2]]);
            let mut drawn = (begin..begin + piece.len()).filter(is_drawn);
            if let Some(first) = drawn.next() {
                let last = drawn.next_back().unwrap_or(first);
                let place = piece[0].map_or(u32::MAX, Interval::place);
                pieces.push((place, start + first, start + last + 3, first % 2 == 1));
            }
            begin += piece.len();
        }
        start += strip.len() + 1;
    }
    pieces.sort_unstable();
    let mut ordered = Vec::with_capacity(entries.len());
    for (i, (_, first, end, is_odd)) in pieces.into_iter().enumerate() {
        if i > 0 {
            ordered.push(RESTART);
        }
        // Repeating the first vertex preserves the winding of the piece.
        ordered.extend(is_odd.then_some(entries[first]));
        ordered.extend_from_slice(&entries[first..end]);
    }
    ordered
}

/// A label of a triangle, and the cost of the strip up to it.
#[derive(Debug, Clone, Copy)]
struct LabelChoice {
    label: Label,
    cost: f32,
    /// The choice of the previous triangle.
    before: u8,
}

/// Returns for each triangle of a strip the label that minimizes the cost of the strip.
fn cheapest(labels: &[Label]) -> Vec<Label> {
    let mut choices: Vec<Vec<LabelChoice>> = Vec::with_capacity(labels.len());
    for (i, &label) in labels.iter().enumerate() {
        // 1. The labels that contain the changes of the triangle.
        let mut allowed: Vec<Label> = containing(label).collect();
        if label.is_none() {
            // Also the labels of its neighbours.
            if let Some(before) = choices.last() {
                allowed.extend(before.iter().map(|choice| choice.label));
            }
            let next = labels[i..].iter().take(LOOK_AHEAD).find(|label| label.is_some());
            allowed.extend(next.into_iter().flat_map(|&next| containing(next)));
            allowed.sort_unstable();
            allowed.dedup();
        }
        // 2. Each label continues the same label or follows a cut.
        let of_triangle = allowed.into_iter().map(|label| {
            let price = label.map_or(0.0, |interval| UPLOAD / (1_u32 << interval.depth) as f32);
            let Some(all_before) = choices.last() else {
                return LabelChoice { label, cost: price, before: 0 };
            };
            let costs = all_before.iter().zip(0..).map(|(choice, before)| {
                let cut = if choice.label == label { 0.0 } else { CUT };
                (choice.cost + cut, before)
            });
            let (cost, before) = costs.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default();
            LabelChoice { label, cost: cost + price, before }
        });
        let of_triangle = of_triangle.collect();
        choices.push(of_triangle);
    }
    // 3. Trace back from the cheapest end.
    let ends = choices.last().into_iter().flatten().enumerate();
    let mut at = ends.min_by(|a, b| a.1.cost.total_cmp(&b.1.cost)).map_or(0, |(i, _)| i);
    let mut chosen = Vec::with_capacity(labels.len());
    for of_triangle in choices.iter().rev() {
        let choice = of_triangle[at];
        chosen.push(choice.label);
        at = choice.before.into();
    }
    chosen.reverse();
    chosen
}

/// Returns the intervals that contain an interval, including itself. For `None`, returns only
/// `None`.
fn containing(label: Label) -> impl Iterator<Item = Label> {
    let ancestors = std::iter::successors(label, |interval| interval.parent()).map(Some);
    ancestors.chain(label.is_none().then_some(None))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::lod::samples::sorted;
    use crate::strip::Strips;

    /// Generates an interval of at most two halvings, or none.
    fn labels() -> impl Strategy<Value = Label> {
        prop_oneof![
            Just(None),
            (0..3_u32, 0..4_u32)
                .prop_map(|(depth, number)| Some(Interval { depth, number: number >> (2 - depth) })),
        ]
    }

    /// Returns the cost of a strip with one label per triangle; `None` if a label does not contain
    /// the changes of its triangle.
    fn cost(labels: &[Label], chosen: &[Label]) -> Option<f32> {
        let contains = labels.iter().zip(chosen).all(|(&label, chosen)| {
            label.is_none() || containing(label).any(|containing| containing == *chosen)
        });
        let price = |label: &Label| label.map_or(0.0, |interval| UPLOAD / (1_u32 << interval.depth) as f32);
        let cuts = chosen.windows(2).filter(|pair| pair[0] != pair[1]).count();
        contains.then(|| chosen.iter().map(price).sum::<f32>() + CUT * cuts as f32)
    }

    proptest! {
        /// The oracle is an exhaustive search over all labels of all triangles.
        #[test]
        fn the_chosen_labels_cost_the_least(labels in prop::collection::vec(labels(), 1..6)) {
            let all: Vec<Label> = (0..3_u32)
                .flat_map(|depth| (0..1 << depth).map(move |number| Some(Interval { depth, number })))
                .chain([None])
                .collect();
            let mut least = f32::INFINITY;
            for mut code in 0..all.len().pow(labels.len() as u32) {
                let mut chosen = Vec::new();
                for _ in 0..labels.len() {
                    chosen.push(all[code % all.len()]);
                    code /= all.len();
                }
                least = least.min(cost(&labels, &chosen).unwrap_or(f32::INFINITY));
            }
            prop_assert_eq!(cost(&labels, &cheapest(&labels)), Some(least));
        }

        #[test]
        fn pieces_draw_what_the_strips_draw(
            strips in prop::collection::vec(prop::collection::vec(0..9_u32, 0..12), 0..4),
            writes in prop::collection::vec((any::<prop::sample::Index>(), 0..8_u32), 0..20),
        ) {
            let mut built = Strips::default();
            strips.iter().for_each(|strip| built.push(strip));
            let map = built.to_restart(RESTART);
            let mut changes = SlotChanges::new(map.len().max(1), 8, 1);
            let mut writes: Vec<(u32, u32)> =
                writes.iter().map(|(slot, at)| (*at, slot.index(map.len().max(1)) as u32)).collect();
            writes.sort_unstable();
            writes.iter().for_each(|&(at, slot)| changes.add(slot, at));
            let ordered = ordered(&map, &changes);
            let drawn = ordered.split(|&entry| entry == RESTART).flat_map(crate::strip::strip_triangles);
            prop_assert_eq!(sorted(drawn), sorted(built.triangles()));
        }
    }

    #[test]
    fn triangles_lie_in_the_order_of_their_changes() {
        // Two separate fans. The first changes late, the second early, and one triangle never.
        let map = [0, 1, 2, 3, 4, RESTART, 5, 6, 7, 8, 9, RESTART, 10, 11, 12];
        let mut changes = SlotChanges::new(map.len(), 16, 1);
        (6..11).for_each(|slot| changes.add(slot, 1));
        (0..5).for_each(|slot| changes.add(slot, 14));
        assert_eq!(ordered(&map, &changes), [5, 6, 7, 8, 9, RESTART, 0, 1, 2, 3, 4, RESTART, 10, 11, 12]);
    }
}
