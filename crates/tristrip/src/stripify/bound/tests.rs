use proptest::prelude::*;

use super::frontier::{Node, least_ends};
use super::strips::{Limits, bound_within};
use super::*;
use crate::mesh::Mesh;
use crate::strip::Metrics;
use crate::stripify::{Method, StripifyOptions, plan};

/// Draws a dual graph of up to so many triangles: half-edges paired at random, some of them not, and some triangles with two or
/// three edges in common. It need not come from any mesh.
pub(super) fn graph(triangles: std::ops::Range<usize>) -> impl Strategy<Value = DualGraph> {
    let pairs = (triangles, 0..100_usize, any::<bool>());
    pairs.prop_flat_map(|(n, open, near)| {
        prop::collection::vec(any::<(prop::sample::Index, prop::sample::Index)>(), 3 * n / 2).prop_map(
            move |draws| {
                let mut twins = vec![NONE; 3 * n];
                for (a, b) in draws {
                    let free: Vec<usize> = (0..3 * n).filter(|&h| twins[h] == NONE).collect();
                    if 100 * free.len() <= 3 * n * open {
                        break;
                    }
                    let a = *a.get(&free);
                    // Near ones make long graphs with bridges, others make round ones.
                    let others: Vec<usize> = free
                        .into_iter()
                        .filter(|&h| h / 3 != a / 3 && (!near || (h / 3).abs_diff(a / 3) < 3))
                        .collect();
                    if !others.is_empty() {
                        let b = *b.get(&others);
                        (twins[a], twins[b]) = (b as u32, a as u32);
                    }
                }
                DualGraph::from_triangle_twins(twins)
            },
        )
    })
}

/// Makes a tree of triangles, each joined to a free edge of those before.
fn tree(parents: &[prop::sample::Index]) -> DualGraph {
    let mut twins = vec![NONE; 3 * parents.len() + 3];
    for (i, parent) in parents.iter().enumerate() {
        let free: Vec<usize> = (0..3 * i + 3).filter(|&h| twins[h] == NONE).collect();
        let (a, b) = (*parent.get(&free), 3 * i + 3);
        (twins[a], twins[b]) = (b as u32, a as u32);
    }
    DualGraph::from_triangle_twins(twins)
}

/// The arcs of a graph, each once.
pub(super) fn arcs(graph: &DualGraph) -> Vec<(usize, usize)> {
    let twins = graph.twins().iter().enumerate();
    twins.filter(|&(h, &t)| t != NONE && h < t as usize).map(|(h, &t)| (h / 3, t as usize / 3)).collect()
}

/// The most arcs that leave no triangle more than two, found by trying all; without cycles where asked.
fn most_links(arcs: &[(usize, usize)], free: &mut [u8], path: &mut [usize], cycles: bool) -> usize {
    let Some((&(a, b), rest)) = arcs.split_first() else { return 0 };
    let mut most = 0;
    if free[a] > 0 && free[b] > 0 && (cycles || path[a] != path[b]) {
        let before = path.to_vec();
        path.iter_mut().filter(|p| **p == before[a]).for_each(|p| *p = before[b]);
        free[a] -= 1;
        free[b] -= 1;
        most = 1 + most_links(rest, free, path, cycles);
        free[a] += 1;
        free[b] += 1;
        path.copy_from_slice(&before);
        if most == arcs.len() {
            return most;
        }
    }
    most.max(most_links(rest, free, path, cycles))
}

/// The least strips of each component, found by trying all covers, and the same if cycles were strips of nothing.
pub(super) fn least_strips(graph: &DualGraph) -> Vec<(usize, usize)> {
    let (component, count) = graph.components();
    let mut simple = arcs(graph);
    simple.sort_unstable_by_key(|&(a, b)| (a.min(b), a.max(b)));
    simple.dedup_by_key(|&mut (a, b)| (a.min(b), a.max(b)));
    (0..count as u32)
        .map(|c| {
            let here: Vec<_> = simple.iter().copied().filter(|&(a, _)| component[a] == c).collect();
            let size = component.iter().filter(|&&other| other == c).count();
            let most = |cycles| {
                let n = component.len();
                most_links(&here, &mut vec![2; n], &mut (0..n).collect::<Vec<_>>(), cycles)
            };
            (size - most(false), size - most(true))
        })
        .collect()
}

/// The least ends of paths in a piece, found by trying all links.
fn least_ends_of_all(nodes: &[Node], arcs: &[(usize, usize)], free: &[u8], path: &[usize]) -> usize {
    let Some((&(a, b), rest)) = arcs.split_first() else {
        return nodes
            .iter()
            .zip(free)
            .map(|(node, &free)| usize::from(free.saturating_sub(node.outward)))
            .sum();
    };
    let without = least_ends_of_all(nodes, rest, free, path);
    if free[a] == 0 || free[b] == 0 || path[a] == path[b] {
        return without;
    }
    let mut free = free.to_vec();
    free[a] -= 1;
    free[b] -= 1;
    let path: Vec<usize> = path.iter().map(|&p| if p == path[a] { path[b] } else { p }).collect();
    without.min(least_ends_of_all(nodes, rest, &free, &path))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn no_cover_has_fewer_strips(graph in graph(1..13)) {
        let found = strips::bound(&graph);
        let least = least_strips(&graph);
        prop_assert_eq!(found.len(), least.len());
        for (found, (paths, two_matching)) in found.iter().zip(least) {
            prop_assert!(found.strips <= paths, "{} > {paths}", found.strips);
            prop_assert!(found.strips >= two_matching.max(1));
        }
    }

    #[test]
    fn no_limit_gives_a_bound_that_is_too_high(
        graph in graph(1..14), steps in 0..100_u64, whole in prop_oneof![Just(0), 0..14_usize], at_once in 1..60_usize, states in 0..900_u64,
    ) {
        let limits = Limits { steps, whole, states_at_once: at_once, states };
        let enough = Limits { steps: 10_000, states: 10_000, ..limits };
        for ((few, more), (paths, two_matching)) in
            bound_within(&graph, limits).iter().zip(bound_within(&graph, enough)).zip(least_strips(&graph))
        {
            prop_assert!((1..=paths).contains(&few.strips), "{few:?} > {paths}");
            prop_assert!((two_matching.max(1)..=paths).contains(&more.strips), "{more:?} > {paths}");
            prop_assert!(more.proof != Proof::Exact || more.strips == paths);
        }
    }

    #[test]
    fn pieces_are_solved_exactly(
        graph in graph(1..12),
        nodes in prop::collection::vec((0..3_u8, any::<bool>()), 12),
    ) {
        let mut neighbours = vec![[NONE; 3]; graph.face_count()];
        let mut arcs = arcs(&graph);
        arcs.sort_unstable_by_key(|&(a, b)| (a.min(b), a.max(b)));
        arcs.dedup_by_key(|&mut (a, b)| (a.min(b), a.max(b)));
        for &(a, b) in &arcs {
            for (a, b) in [(a, b), (b, a)] {
                let place = neighbours[a].iter().position(|&n| n == NONE).unwrap();
                neighbours[a][place] = b as u32;
            }
        }
        let nodes: Vec<Node> = neighbours
            .into_iter()
            .zip(nodes)
            .map(|(neighbours, (outward, is_taken))| Node { neighbours, outward, is_taken })
            .collect();
        let free: Vec<u8> = nodes.iter().map(|node| 2 - u8::from(node.is_taken)).collect();
        let expected = least_ends_of_all(&nodes, &arcs, &free, &(0..nodes.len()).collect::<Vec<_>>());
        prop_assert_eq!(least_ends(&nodes, usize::MAX, &mut u64::MAX.clone()), Some(expected));
    }

    #[test]
    fn trees_are_bounded_exactly(parents in prop::collection::vec(any::<prop::sample::Index>(), 0..18)) {
        let graph = tree(&parents);
        prop_assert_eq!(strips::bound(&graph)[0].strips, least_strips(&graph)[0].0);
    }
}

fn bound_of(corners: Vec<u32>) -> Bound {
    let vertex_count = corners.iter().max().map_or(0, |&v| v as usize + 1);
    let mesh = Mesh::new(vec![[0.0; 3]; vertex_count], Faces::from_triangles(corners).unwrap()).unwrap();
    let surface = PreparedFaces::new(&mesh, false);
    Bound::of_surface(&surface, &DualGraph::new(surface.faces()))
}

#[test]
fn nothing_needs_nothing() {
    let bound = bound_of(Vec::new());
    assert_eq!(bound, Bound::default());
    assert_eq!(bound.of(Cost::Restart), 0);
}

#[test]
fn components_that_share_a_vertex_may_be_joined_for_nothing() {
    let apart = bound_of(vec![0, 1, 2, 3, 4, 5]);
    assert_eq!((apart.strips, apart.of(Cost::OpenGl), apart.of(Cost::Degenerate)), (2, 6, 8));
    let touching = bound_of(vec![0, 1, 2, 2, 3, 4]);
    assert_eq!((touching.of(Cost::Restart), touching.of(Cost::Gl), touching.of(Cost::Degenerate)), (7, 6, 6));
}

/// The bound was 10, and so many were sent, since the row of four was joined with the repeat that it needs by itself.
#[test]
fn a_repeat_is_for_nothing_at_an_odd_place() {
    let corners = vec![1, 0, 2, 1, 2, 3, 3, 2, 4, 3, 4, 5, 7, 8, 0];
    assert_eq!(bound_of(corners[..12].to_vec()).of(Cost::Degenerate), 7);
    let bound = bound_of(corners);
    assert_eq!((bound.of(Cost::OpenGl), bound.of(Cost::Degenerate)), (10, 9));
    let mut strips = crate::Strips::default();
    strips.push(&[0, 0, 1, 2, 3, 4, 5]);
    strips.push(&[7, 8, 0]);
    assert_eq!(strips.to_degenerate(), [7, 8, 0, 0, 1, 2, 3, 4, 5]);
}

#[test]
fn a_cycle_behind_a_bridge_needs_an_end() {
    // A fan of four triangles closed around vertex 0, with a triangle at each rim edge: two edges too many on the cycle, and
    // four triangles at which a strip ends.
    let fan = (0..4).flat_map(|i| [0, 1 + i, 1 + (i + 1) % 4]);
    let outer = (0..4).flat_map(|i| [1 + (i + 1) % 4, 1 + i, 5 + i]);
    let bound = bound_of(fan.chain(outer).collect());
    assert_eq!((bound.strips, bound.components[0].proof), (2, Proof::Exact));
}

#[test]
fn a_fan_needs_a_vertex_more_than_a_row() {
    let row = (0..5).flat_map(|i| if i % 2 == 0 { [i, i + 1, i + 2] } else { [i + 1, i, i + 2] });
    assert_eq!(bound_of(row.collect()).vertices_sent, 7);
    let fan = (1..6).flat_map(|i| [0, i, i + 1]);
    let bound = bound_of(fan.collect());
    assert_eq!((bound.strips, bound.vertices_sent, bound.gl_cost), (1, 8, 7));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn parts_of_a_block_bound_the_whole(graph in graph(10..70), at_once in 1..300_usize) {
        let exact = Limits { steps: 100_000, whole: usize::MAX, states_at_once: 30_000, states: 1_000_000 };
        let in_parts = Limits { whole: 0, states_at_once: at_once, ..exact };
        for (least, found) in bound_within(&graph, exact).iter().zip(bound_within(&graph, in_parts)) {
            prop_assert!(least.proof != Proof::Exact || found.strips <= least.strips, "{found:?} > {least:?}");
        }
    }

    #[test]
    fn no_method_does_better(corners in prop::collection::vec(prop::array::uniform3(0..9_u32), 0..30), shift in 0..3_u32) {
        // Three sheets of a soup, apart or not.
        let corners: Vec<u32> =
            corners.iter().enumerate().flat_map(|(i, t)| t.map(|v| v + 5 * shift * (i as u32 % 3))).collect();
        let mesh = Mesh::new(vec![[0.0; 3]; 40], Faces::from_triangles(corners).unwrap()).unwrap();
        let surface = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(surface.faces());
        let bound = Bound::of_surface(&surface, &graph);
        for method in [Method::Auto, Method::Sequential, Method::Input, Method::Sgi, Method::STRIPE] {
            let options = StripifyOptions::default().with_method(method);
            let plan = plan(&surface, &graph, &options).unwrap();
            let metrics = Metrics::of(&plan.strips());
            prop_assert!(bound.strips <= metrics.strips);
            for cost in [Cost::Restart, Cost::OpenGl, Cost::Degenerate, Cost::Gl] {
                prop_assert!(bound.of(cost) <= cost.of(&metrics), "{method:?} {cost:?}: {bound:?} {metrics:?}");
            }
        }
    }

    #[test]
    fn no_method_does_better_on_polygons(polygons in prop::collection::vec((3..7_usize, 0..12_u32, 1..5_u32), 0..20)) {
        let polygons = polygons.into_iter().map(|(n, first, step)| {
            (0..n as u32).map(|i| (first + i * step) % 13).collect::<Vec<_>>()
        });
        let mesh = Mesh::new(vec![[0.0; 3]; 13], Faces::from_polygons(polygons).unwrap()).unwrap();
        let surface = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(surface.faces());
        let bound = Bound::of_surface(&surface, &graph);
        for method in [Method::Auto, Method::Sequential, Method::Sgi, Method::STRIPE] {
            let options = StripifyOptions::default().with_method(method);
            let plan = plan(&surface, &graph, &options).unwrap();
            let metrics = Metrics::of(&plan.strips());
            prop_assert!(bound.strips <= metrics.strips);
            for cost in [Cost::Restart, Cost::OpenGl, Cost::Degenerate, Cost::Gl] {
                prop_assert!(bound.of(cost) <= cost.of(&metrics), "{method:?} {cost:?}: {bound:?} {metrics:?}");
            }
            let fixed = Bound::of_triangulation(&plan.triangulation);
            prop_assert!(bound.strips <= fixed.strips && bound.vertices_sent <= fixed.vertices_sent);
        }
    }
}
