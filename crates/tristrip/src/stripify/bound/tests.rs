use proptest::prelude::*;

use super::frontier::{FrontierNode, least_ends};
use super::neighbours::Neighbours;
use super::strips::{BoundLimits, bound_within};
use super::*;
use crate::mesh::Mesh;
use crate::strip::Metrics;
use crate::stripify::{Method, StripifyOptions, plan};

/// Generates a dual graph: random pairs of half-edges, some half-edges without a twin, and some
/// triangles with two or three common edges. There may be no mesh with this graph.
pub(super) fn graph(triangles: std::ops::Range<usize>) -> impl Strategy<Value = DualGraph> {
    let pairs = (triangles, 0..100_usize, any::<bool>());
    pairs.prop_flat_map(|(n, open, near)| {
        prop::collection::vec(any::<(prop::sample::Index, prop::sample::Index)>(), 3 * n / 2).prop_map(
            move |draws| {
                let mut twins = vec![None; 3 * n];
                for (a, b) in draws {
                    let free: Vec<usize> = (0..3 * n).filter(|&h| twins[h].is_none()).collect();
                    if 100 * free.len() <= 3 * n * open {
                        break;
                    }
                    let a = *a.get(&free);
                    // Pairs of nearby triangles make long graphs with bridges; other pairs make
                    // compact ones.
                    let others: Vec<usize> = free
                        .into_iter()
                        .filter(|&h| h / 3 != a / 3 && (!near || (h / 3).abs_diff(a / 3) < 3))
                        .collect();
                    if !others.is_empty() {
                        let b = *b.get(&others);
                        (twins[a], twins[b]) = (Some(b as u32), Some(a as u32));
                    }
                }
                DualGraph::of_triangle_twins(twins)
            },
        )
    })
}

/// Builds a tree of triangles, each joined to a free edge of an earlier one.
fn tree(parents: &[prop::sample::Index]) -> DualGraph {
    let mut twins = vec![None; 3 * parents.len() + 3];
    for (i, parent) in parents.iter().enumerate() {
        let free: Vec<usize> = (0..3 * i + 3).filter(|&h| twins[h].is_none()).collect();
        let (a, b) = (*parent.get(&free), 3 * i + 3);
        (twins[a], twins[b]) = (Some(b as u32), Some(a as u32));
    }
    DualGraph::of_triangle_twins(twins)
}

/// Returns the arcs of a graph, one per pair of triangles.
fn arcs(graph: &DualGraph) -> Vec<(usize, usize)> {
    let half_edges = 0..graph.half_edge_count() as u32;
    let pairs = half_edges.filter_map(|h| Some((h / 3, graph.twin_of(h).filter(|&twin| h < twin)? / 3)));
    let mut arcs: Vec<_> = pairs.map(|(a, b)| (a as usize, b as usize)).collect();
    arcs.sort_unstable_by_key(|&(a, b)| (a.min(b), a.max(b)));
    arcs.dedup_by_key(|&mut (a, b)| (a.min(b), a.max(b)));
    arcs
}

/// Returns the maximum number of arcs with at most two per triangle, by trying all subsets, with or
/// without cycles.
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

/// Returns the minimum number of strips of each component, by trying all covers, and the same
/// number if cycles were allowed and free.
fn least_strips(graph: &DualGraph) -> Vec<(usize, usize)> {
    let (component, count) = graph.components();
    let arcs = arcs(graph);
    (0..count as u32)
        .map(|c| {
            let here: Vec<_> = arcs.iter().copied().filter(|&(a, _)| component[a] == c).collect();
            let size = component.iter().filter(|&&other| other == c).count();
            let most = |cycles| {
                let n = component.len();
                most_links(&here, &mut vec![2; n], &mut (0..n).collect::<Vec<_>>(), cycles)
            };
            (size - most(false), size - most(true))
        })
        .collect()
}

/// Returns the minimum number of path ends in a subproblem, by trying all links.
fn least_ends_of_all(nodes: &[FrontierNode], arcs: &[(usize, usize)], free: &[u8], path: &[usize]) -> usize {
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
    fn bounds_are_valid_within_any_limits(
        graph in graph(1..14), steps in 0..100_u64, whole in prop_oneof![Just(0), 0..14_usize], at_once in 1..60_usize, states in 0..900_u64,
    ) {
        let limits = BoundLimits { steps, whole, states_at_once: at_once, states };
        let enough = BoundLimits { steps: 10_000, states: 10_000, ..limits };
        for ((few, more), (paths, two_matching)) in
            bound_within(&graph, limits).iter().zip(bound_within(&graph, enough)).zip(least_strips(&graph))
        {
            prop_assert!((1..=paths).contains(&few.strips), "{few:?} > {paths}");
            prop_assert!((two_matching.max(1)..=paths).contains(&more.strips), "{more:?} > {paths}");
            prop_assert!(more.method != BoundMethod::Exact || more.strips == paths);
        }
    }

    #[test]
    fn subproblems_are_solved_exactly(
        graph in graph(1..12),
        nodes in prop::collection::vec((0..3_u8, any::<bool>()), 12),
    ) {
        let mut neighbours = vec![Neighbours::default(); graph.face_count()];
        let arcs = arcs(&graph);
        for &(a, b) in &arcs {
            neighbours[a].insert(b as u32);
            neighbours[b].insert(a as u32);
        }
        let nodes: Vec<FrontierNode> = neighbours
            .into_iter()
            .zip(nodes)
            .map(|(neighbours, (outward, is_taken))| FrontierNode { neighbours, outward, is_taken })
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
    let prepared = PreparedFaces::new(&mesh, false);
    Bound::of_prepared(&prepared, &DualGraph::new(prepared.faces())).unwrap()
}

/// Checks that no method's strips are below the bounds of the mesh or of their own triangulation.
fn check_methods(mesh: &Mesh, methods: &[Method]) -> Result<(), TestCaseError> {
    let prepared = PreparedFaces::new(mesh, false);
    let graph = DualGraph::new(prepared.faces());
    let bound = Bound::of_prepared(&prepared, &graph).unwrap();
    for &method in methods {
        let options = StripifyOptions::default().with_method(method);
        let plan = plan(&prepared, &graph, &options).unwrap();
        let metrics = Metrics::of(&plan.strips());
        prop_assert!(bound.strips <= metrics.strips);
        for cost in [Cost::Restart, Cost::OpenGl, Cost::Degenerate, Cost::Gl] {
            prop_assert!(bound.of(cost) <= cost.of(&metrics), "{method:?} {cost:?}: {bound:?} {metrics:?}");
        }
        let fixed = Bound::of_triangulation(&plan.triangulation);
        prop_assert!(bound.strips <= fixed.strips && bound.vertices_sent <= fixed.vertices_sent);
    }
    Ok(())
}

#[test]
fn an_empty_mesh_needs_no_strip() {
    let bound = bound_of(Vec::new());
    assert_eq!(bound, Bound::default());
    assert_eq!(bound.of(Cost::Restart), 0);
}

#[test]
fn components_that_share_a_vertex_may_be_joined_for_free() {
    let apart = bound_of(vec![0, 1, 2, 3, 4, 5]);
    assert_eq!((apart.strips, apart.of(Cost::OpenGl), apart.of(Cost::Degenerate)), (2, 6, 8));
    let touching = bound_of(vec![0, 1, 2, 2, 3, 4]);
    assert_eq!((touching.of(Cost::Restart), touching.of(Cost::Gl), touching.of(Cost::Degenerate)), (7, 6, 6));
}

/// Regression test: the bound was 10 although 10 indices were sent, because the row of four was
/// joined with the repeat that it needs on its own.
#[test]
fn a_repeat_is_free_at_an_odd_position() {
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
    // A closed fan of four triangles around vertex 0, with a triangle at each rim edge. The cycle
    // has two edges too many, and four triangles contain a strip end.
    let fan = (0..4).flat_map(|i| [0, 1 + i, 1 + (i + 1) % 4]);
    let outer = (0..4).flat_map(|i| [1 + (i + 1) % 4, 1 + i, 5 + i]);
    let bound = bound_of(fan.chain(outer).collect());
    assert_eq!((bound.strips, bound.components[0].method), (2, BoundMethod::Exact));
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
    #[test]
    fn parts_of_a_block_bound_the_whole(graph in graph(10..70), at_once in 1..300_usize) {
        let exact = BoundLimits { steps: 100_000, whole: usize::MAX, states_at_once: 30_000, states: 1_000_000 };
        let in_parts = BoundLimits { whole: 0, states_at_once: at_once, ..exact };
        for (least, found) in bound_within(&graph, exact).iter().zip(bound_within(&graph, in_parts)) {
            prop_assert!(least.method != BoundMethod::Exact || found.strips <= least.strips, "{found:?} > {least:?}");
        }
    }

    #[test]
    fn no_method_is_below_the_bound(corners in prop::collection::vec(prop::array::uniform3(0..9_u32), 0..30), shift in 0..3_u32) {
        // A soup of three components, connected or not.
        let corners: Vec<u32> =
            corners.iter().enumerate().flat_map(|(i, t)| t.map(|v| v + 5 * shift * (i as u32 % 3))).collect();
        let mesh = Mesh::new(vec![[0.0; 3]; 40], Faces::from_triangles(corners).unwrap()).unwrap();
        check_methods(&mesh, &[Method::Best, Method::Sequential, Method::Input, Method::SGI, Method::STRIPE])?;
    }

    #[test]
    fn no_method_is_below_the_bound_on_polygons(polygons in prop::collection::vec((3..7_usize, 0..12_u32, 1..5_u32), 0..20)) {
        let polygons = polygons.into_iter().map(|(n, first, step)| {
            (0..n as u32).map(|i| (first + i * step) % 13).collect::<Vec<_>>()
        });
        let mesh = Mesh::new(vec![[0.0; 3]; 13], Faces::from_polygons(polygons).unwrap()).unwrap();
        check_methods(&mesh, &[Method::Best, Method::Sequential, Method::SGI, Method::STRIPE])?;
    }
}
