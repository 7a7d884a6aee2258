use proptest::prelude::*;

use super::{DrawCost, Filter, RESTART};
use crate::lod::samples::sorted;
use crate::strip::{Strips, strip_triangles};

/// The strips of the figures.
const FIGURE_2E: [u32; 8] = [2, 3, 2, 3, 2, 5, 2, 5];
const FIGURE_8: [u32; 26] = [
    615, 615, 502, 615, 502, 615, 206, 620, 206, 620, 620, 620, 620, 620, 580, 66, 580, 66, 580, 66, 761,
    761, 761, 761, 258, 761,
];

fn filtered(filter: Filter, strip: &[u32]) -> Strips {
    let mut display = Strips::default();
    filter.map_to(strip, &mut display);
    display
}

fn draws_the_same(display: &Strips, strip: &[u32]) -> bool {
    sorted(display.triangles()) == sorted(strip_triangles(strip))
}

#[test]
fn figure_2e() {
    assert_eq!(filtered(Filter::None, &FIGURE_2E).vertices(), FIGURE_2E);
    assert_eq!(filtered(Filter::Stss, &FIGURE_2E).vertices(), [2, 3, 2, 5]);
    // One triangle, at an odd position: {d, c, f}.
    assert_eq!(filtered(Filter::Dtfs, &FIGURE_2E).vertices(), [3, 3, 2, 5]);
    assert_eq!(filtered(Filter::Linked, &FIGURE_2E).vertices(), [2, 3, 5]);
}

#[test]
fn figure_8() {
    let stss = filtered(Filter::Stss, &FIGURE_8);
    assert_eq!(stss.vertices(), [615, 615, 502, 615, 206, 620, 620, 620, 580, 66, 761, 761, 258, 761]);
    let dtfs = filtered(Filter::Dtfs, &FIGURE_8);
    let strips: Vec<&[u32]> = dtfs.iter().collect();
    assert_eq!(strips, [&[502, 615, 206, 620][..], &[620, 620, 580, 66, 761]]);
    let sent = Filter::Dtfs.sent_by_map(&FIGURE_8);
    // The figure shows the strips without the repeat.
    assert_eq!(sent.vertices - sent.winding_repeats, 8);
    let linked = filtered(Filter::Linked, &FIGURE_8);
    let strips: Vec<&[u32]> = linked.iter().collect();
    assert_eq!(strips, [&[502, 615, 206, 620][..], &[620, 66, 580, 761]]);
    // The list that the figure prints for STSS draws a triangle that is not in the strip.
    let printed = [615, 615, 502, 615, 206, 620, 620, 580, 66, 761, 258];
    assert!(strip_triangles(&printed).any(|t| t == [66, 761, 258]));
    assert!(!strip_triangles(&FIGURE_8).any(|t| t.contains(&258)));
}

#[test]
fn cases_of_figure_7() {
    assert_eq!(filtered(Filter::Dtfs, &[0, 1, 2, 1, 2, 3]).vertices(), [0, 1, 2, 3]);
    assert_eq!(filtered(Filter::Dtfs, &[0, 1, 2, 1, 3]).vertices(), [0, 1, 2, 1, 3]);
    let split = filtered(Filter::Dtfs, &[0, 1, 2, 2, 3, 4]);
    assert_eq!(split.iter().collect::<Vec<_>>(), [&[0, 1, 2][..], &[2, 2, 3, 4]]);
}

#[test]
fn triangles_of_one_sense_at_an_edge_are_not_linked() {
    // 0 1 2 and 1 2 3 both have the directed edge 1 → 2, so no strip can draw both without a break.
    let strip = [0, 1, 2, 2, 1, 1, 1, 2, 3];
    for filter in [Filter::Dtfs, Filter::Linked] {
        let display = filtered(filter, &strip);
        assert_eq!(display.iter().collect::<Vec<_>>(), [[0, 1, 2], [1, 2, 3]]);
    }
}

#[test]
fn what_has_no_triangle_sends_nothing() {
    for strip in [&[][..], &[1], &[1, 2], &[1, 1, 1], &[1, 2, 1, 2]] {
        for filter in [Filter::Dtfs, Filter::Linked] {
            assert_eq!(filter.sent_by_map(strip), DrawCost::default());
        }
    }
    assert_eq!(filtered(Filter::Stss, &[1, 2, 1, 2, 1, 3, 4, 5, 4, 5]).vertices(), [1, 2, 1, 3, 4, 5]);
    // A run that begins within a pair is not found.
    assert_eq!(filtered(Filter::Stss, &[3, 1, 2, 1, 2, 4]).vertices(), [3, 1, 2, 1, 2, 4]);
    assert_eq!(Filter::Stss.sent_by_map(&[4; 9]), DrawCost { vertices: 3, strips: 1, winding_repeats: 0 });
    assert_eq!(Filter::None.sent_by_map(&[]), DrawCost::default());
}

#[test]
fn a_swap_at_the_start_is_saved_from_the_other_end() {
    // The strip exits 1 2 3 across 1 3: with a swap, or reversed.
    let strip = [0, 1, 2, 1, 3, 4];
    assert_eq!(filtered(Filter::Linked, &strip).vertices(), [4, 3, 1, 2, 0]);
    assert_eq!(filtered(Filter::Dtfs, &strip).vertices(), strip);
}

/// Returns whether two triangles share an edge with opposite directions.
fn share_an_edge(a: [u32; 3], b: [u32; 3]) -> bool {
    let edges = |[a, b, c]: [u32; 3]| [[a, b], [b, c], [c, a]];
    edges(a).into_iter().any(|[from, to]| edges(b).contains(&[to, from]))
}

/// Returns the minimum number of vertices that draw triangles in this order as one strip: a
/// breadth-first search over the number of triangles drawn, the parity and the last two vertices.
fn cheapest_strip(triangles: &[[u32; 3]]) -> usize {
    let same = |t: &[u32; 3], u: [u32; 3]| *t == u || *t == [u[1], u[2], u[0]] || *t == [u[2], u[0], u[1]];
    let vertices: Vec<u32> = triangles.iter().flatten().copied().collect();
    let pairs = vertices.iter().flat_map(|&a| vertices.iter().map(move |&b| (0, 0, a, b)));
    let mut states: Vec<(usize, usize, u32, u32)> = pairs.collect();
    for sent in 3.. {
        let mut next = Vec::new();
        for &(drawn, parity, a, b) in &states {
            for &c in &vertices {
                let oriented = if parity == 0 { [a, b, c] } else { [b, a, c] };
                let drawn = match () {
                    () if a == b || b == c || a == c => drawn,
                    () if same(&triangles[drawn], oriented) => drawn + 1,
                    () => continue,
                };
                if drawn == triangles.len() {
                    return sent;
                }
                next.push((drawn, 1 - parity, b, c));
            }
        }
        next.sort_unstable();
        next.dedup();
        states = next;
    }
    unreachable!()
}

/// Returns the minimum number of vertices that draw triangles in this order as any number of
/// strips, each in either direction.
fn cheapest(triangles: &[[u32; 3]]) -> usize {
    let mut best = vec![0];
    for end in 1..=triangles.len() {
        // Joining strips by degenerate triangles belongs to the layout, not to a filter.
        let is_linked = |start: &usize| triangles[*start..end].windows(2).all(|t| share_an_edge(t[0], t[1]));
        let from = |start: usize| {
            let strip = &triangles[start..end];
            let back: Vec<_> = strip.iter().rev().copied().collect();
            best[start] + cheapest_strip(strip).min(cheapest_strip(&back))
        };
        best.push((0..end).filter(is_linked).map(from).min().unwrap());
    }
    best[triangles.len()]
}

/// Generates a strip over an oriented triangulated surface, with vertices renamed as by collapses
/// along its edges.
fn simplified() -> impl Strategy<Value = Vec<u32>> {
    let strip = prop::collection::vec((0..4_u32, 0..3_usize), 3..30).prop_map(|steps| {
        let mut strip = vec![0, 1, 2];
        for (i, (turn, _)) in steps.iter().enumerate() {
            if *turn == 0 {
                strip.push(strip[strip.len() - 2]);
            }
            strip.push(3 + i as u32);
        }
        strip
    });
    (strip, prop::collection::vec((0..30_usize, 1..3_usize), 0..20)).prop_map(|(mut strip, collapses)| {
        for (place, offset) in collapses {
            if let (Some(&from), Some(&to)) = (strip.get(place), strip.get(place + offset)) {
                strip.iter_mut().filter(|v| **v == from).for_each(|v| *v = to);
            }
        }
        strip
    })
}

proptest! {
    #[test]
    fn display_strips_draw_the_same(strip in prop::collection::vec(0..5_u32, 0..200), other in simplified()) {
        for (is_surface, strip) in [(false, strip), (true, other)] {
            for filter in Filter::ALL {
                let display = filtered(filter, &strip);
                prop_assert!(draws_the_same(&display, &strip), "{:?} {:?}", filter, display);
                let sent = filter.sent_by_map(&strip);
                prop_assert_eq!((sent.vertices, sent.strips), (display.vertices_sent(), display.len()));
                let triangles = strip_triangles(&strip).count();
                if matches!(filter, Filter::Dtfs | Filter::Linked) {
                    let most = if filter == Filter::Dtfs { 4 } else { 3 };
                    prop_assert!(sent.vertices <= most * triangles);
                    prop_assert!(display.iter().all(|strip| strip.len() >= 3));
                }
            }
            let [none, stss, dtfs, linked] = Filter::ALL.map(|filter| filter.sent_by_map(&strip));
            prop_assert!(stss.vertices <= none.vertices);
            // On other meshes, a triangle can be drawn twice in a row, and an edge used for a link
            // can be needed later.
            prop_assert!(!is_surface || linked.vertices <= dtfs.vertices && linked.strips <= dtfs.strips);
            prop_assert_eq!(none.winding_repeats + stss.winding_repeats + linked.winding_repeats, 0);
        }
    }

    #[test]
    fn linked_is_the_cheapest_in_its_order(strip in simplified()) {
        let strip = &strip[..strip.len().min(9)];
        let triangles: Vec<[u32; 3]> = strip_triangles(strip).collect();
        prop_assert_eq!(Filter::Linked.sent_by_map(strip).vertices, cheapest(&triangles));
    }

    #[test]
    fn a_map_is_filtered_strip_by_strip(strips in prop::collection::vec(prop::collection::vec(0..5_u32, 0..9), 0..40)) {
        let mut all = Strips::default();
        strips.iter().for_each(|strip| all.push(strip));
        let map = strips.join(&RESTART);
        for filter in Filter::ALL {
            let mut display = Strips::default();
            filter.map_to(&map, &mut display);
            prop_assert_eq!(&display, &filter.strips(&all));
            prop_assert_eq!(filter.sent_by_map(&map), strips.iter().map(|strip| filter.sent_by_map(strip)).sum());
        }
    }
}
