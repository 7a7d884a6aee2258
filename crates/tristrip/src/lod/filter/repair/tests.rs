//! Strips at every level of generated meshes, held to the oracle: drawn right, paths whole, edges and costs as found anew.

use proptest::prelude::*;

use super::{NONE, Options, Repair};
use crate::cover::PathCover;
use crate::dual::{DualGraph, HalfEdge};
use crate::mesh::{Faces, Mesh};
use crate::simplify::{CollapseSequence, Rename};
use crate::strip::{Cost, Strips, path_cost, verify_drawing};
use crate::stripify::random::Random;
use crate::stripify::{Effort, Method, stripify};

/// A grid, closed or not, as triangles, some with their diagonal the other way.
fn grid(width: u32, height: u32, is_closed: bool, cut: u64) -> Vec<u32> {
    let (columns, rows) = if is_closed { (width, height) } else { (width + 1, height + 1) };
    let v = |x, y| y % rows * columns + x % columns;
    let cells = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    cells
        .flat_map(|(x, y)| {
            let [a, b, c, d] = [v(x, y), v(x + 1, y), v(x + 1, y + 1), v(x, y + 1)];
            if cut >> ((x + 5 * y) % 64) & 1 == 1 { [a, b, c, a, c, d] } else { [a, b, d, b, c, d] }
        })
        .collect()
}

/// Triangles of a grid or of no order, some with two equal corners.
fn triangles() -> impl Strategy<Value = Vec<u32>> {
    let corner = prop::collection::vec(prop::array::uniform3(0..12_u32), 0..40);
    prop_oneof![
        (1..7_u32, 1..7_u32, any::<bool>(), any::<u64>())
            .prop_map(|(w, h, closed, cut)| grid(w, h, closed, cut)),
        corner.prop_map(|corners| corners.into_iter().flatten().collect()),
    ]
}

/// Collapses edges at random, mostly one at a time, as long as there are some: also those that make edges of many sides.
fn sequence(triangles: &[u32], seed: u64) -> CollapseSequence {
    let vertex_count = triangles.iter().max().map_or(0, |&v| v as usize + 1);
    let (mut random, mut now) = (Random::new(seed), triangles.to_vec());
    let mut collapses: Vec<Vec<Rename>> = Vec::new();
    for _ in 0..vertex_count {
        let mut renames: Vec<Rename> = Vec::new();
        for _ in 0..=random.below(4) / 3 {
            let edges: Vec<[u32; 2]> = now
                .chunks_exact(3)
                .flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]])
                .filter(|[a, b]| a != b)
                .filter(|edge| edge.iter().all(|v| renames.iter().all(|r| r.removed != *v && r.kept != *v)))
                .collect();
            if !edges.is_empty() {
                let [removed, kept] = edges[random.below(edges.len())];
                renames.push(Rename { removed, kept });
                now.iter_mut().filter(|v| **v == removed).for_each(|v| *v = kept);
            }
        }
        if renames.is_empty() {
            break;
        }
        collapses.push(renames);
    }
    let collapses = collapses.iter().map(|renames| (&renames[..], 0.0));
    CollapseSequence::from_collapses(vertex_count, triangles.to_vec(), collapses).unwrap()
}

fn strips_of(sequence: &CollapseSequence) -> Strips {
    let faces = Faces::from_triangles(sequence.triangles().to_vec()).unwrap();
    let mesh = Mesh::new(vec![[0.0; 3]; sequence.vertex_count()], faces).unwrap();
    stripify(&mesh, &crate::Options::default().with_method(Method::Sequential)).unwrap()
}

/// The other side of each half-edge of a level, by looking at all pairs, numbered by fours; dropped triangles have none.
fn naive_twins(repair: &Repair<'_>) -> Vec<u32> {
    let drawn = (0..repair.paths.len() as u32).filter(|&t| repair.surface.is_drawn(t));
    let sides: Vec<(u32, [u32; 2])> = drawn
        .flat_map(|t| {
            let [a, b, c] = repair.surface.triangle(t);
            [(4 * t, [a, b]), (4 * t + 1, [b, c]), (4 * t + 2, [c, a])]
        })
        .collect();
    let mut twins = vec![NONE; 4 * repair.paths.len()];
    for (i, &(h, [from, to])) in sides.iter().enumerate() {
        let mut earlier = sides[..i].iter().rev().filter(|side| side.1 == [to, from]);
        if let Some(&(other, _)) = earlier.find(|side| twins[side.0 as usize] == NONE) {
            (twins[h as usize], twins[other as usize]) = (other, h);
        }
    }
    twins
}

/// Tells whether an edge has more than two sides.
fn has_fins(corners: &[u32]) -> bool {
    let drawn = corners.chunks_exact(3).filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
    let edges = drawn.flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]);
    let mut edges: Vec<[u32; 2]> = edges.map(|[a, b]| [a.min(b), a.max(b)]).collect();
    edges.sort_unstable();
    edges.windows(3).any(|w| w[0] == w[2])
}

/// Holds a repair to what can be found anew.
fn check(repair: &Repair<'_>) -> Result<(), TestCaseError> {
    let level = repair.level();
    let drawn = repair.sequence.drawn(level);
    prop_assert_eq!(repair.triangle_count(), drawn.len());
    let twins = naive_twins(repair);
    for t in 0..repair.paths.len() as u32 {
        let found = [0, 1, 2].map(|e| repair.paths.twin(4 * t + e));
        prop_assert_eq!(
            found,
            [0, 1, 2].map(|e| twins[4 * t as usize + e]),
            "triangle {} at level {}",
            t,
            level
        );
        let is_end = repair.surface.is_drawn(t) && repair.paths.degree(t) < 2;
        prop_assert_eq!(repair.paths.ends_of(t as usize / 64) >> (t % 64) & 1 == 1, is_end);
    }
    let by_threes = |h: u32| if h == NONE { NONE } else { h / 4 * 3 + h % 4 };
    let slots = (0..twins.len() as u32).filter(|h| h % 4 < 3);
    let graph = DualGraph::from_triangle_twins(slots.map(|h| by_threes(twins[h as usize])).collect());
    let mut cover = PathCover::isolated(repair.paths.len());
    for h in (0..twins.len() as u32).filter(|h| h % 4 < 3) {
        if repair.paths.mask(h / 4) >> (h % 4) & 1 == 1 {
            prop_assert!(
                cover.is_linked(HalfEdge(by_threes(h))) || cover.link(&graph, HalfEdge(by_threes(h)))
            );
        }
    }
    prop_assert_eq!(cover.check(&graph), Ok(()));
    let costs: usize = cover
        .path_starts(&graph)
        .filter(|start| repair.surface.is_drawn(start.0))
        .map(|start| path_cost(&graph, &cover, start))
        .sum();
    prop_assert_eq!(repair.vertices_sent(), costs);

    let strips = repair.strips();
    prop_assert_eq!((strips.len(), strips.vertices_sent()), (repair.strip_count(), costs));
    let faces = Faces::from_triangles(drawn.concat()).unwrap();
    prop_assert!(verify_drawing(&faces, &strips.triangles().collect::<Vec<_>>()).is_ok());
    Ok(())
}

fn options(effort: u8) -> Options {
    Options::default().with_effort(Effort::new(effort).unwrap())
}

proptest! {
    #[test]
    fn every_level_is_drawn(corners in triangles(), seed in any::<u64>(), effort in 0..5_u8, restarts in any::<bool>()) {
        let sequence = sequence(&corners, seed);
        let strips = strips_of(&sequence);
        let cost = if restarts { Cost::Restart } else { Cost::OpenGl };
        let options = options(effort).with_seed(seed).with_cost(cost);
        let mut repair = Repair::new(&sequence, &strips, options).unwrap();
        if !has_fins(&corners) {
            prop_assert_eq!(repair.vertices_sent(), strips.vertices_sent());
        }
        check(&repair)?;
        while repair.coarsen() {
            check(&repair)?;
        }
        prop_assert_eq!(repair.level(), 0);
        while repair.refine() {
            check(&repair)?;
        }
        prop_assert_eq!(repair.level(), sequence.len());
    }

    #[test]
    fn any_way_to_a_level_draws_it(corners in triangles(), seed in any::<u64>(), ways in prop::collection::vec(0..40_usize, 0..12)) {
        let sequence = sequence(&corners, seed);
        let strips = strips_of(&sequence);
        let mut repair = Repair::at(&sequence, &strips, sequence.len() / 2, options(1)).unwrap();
        check(&repair)?;
        for level in ways {
            repair.go_to(level);
            prop_assert_eq!(repair.level(), level.min(sequence.len()));
            check(&repair)?;
        }
    }

    #[test]
    fn a_level_at_once_is_drawn_and_no_effort_makes_it_dearer(corners in triangles(), seed in any::<u64>()) {
        let sequence = sequence(&corners, seed);
        let strips = strips_of(&sequence);
        for level in 0..=sequence.len() {
            let dearest = Repair::at(&sequence, &strips, level, options(0)).unwrap();
            check(&dearest)?;
            for effort in 1..4 {
                let repair = Repair::at(&sequence, &strips, level, options(effort)).unwrap();
                check(&repair)?;
                prop_assert!(repair.vertices_sent() <= dearest.vertices_sent());
            }
        }
    }
}

#[test]
fn the_same_steps_give_the_same_strips() {
    let sequence = sequence(&grid(12, 12, true, 0x1234_5678_9abc), 7);
    let strips = strips_of(&sequence);
    let half = sequence.len() / 2;
    let run = |seed| {
        let mut repair = Repair::new(&sequence, &strips, options(5).with_seed(seed)).unwrap();
        [half, 0, half].map(|level| {
            repair.go_to(level);
            repair.strips()
        })
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1), run(2));
}

#[test]
fn strips_of_another_mesh_are_refused() {
    let sequence = sequence(&grid(3, 3, false, 0), 1);
    let mut strips = strips_of(&sequence);
    assert!(Repair::at(&sequence, &strips, sequence.len() + 1, options(5)).is_err());
    strips.push(&[0, 1, 2]);
    let error = Repair::new(&sequence, &strips, options(5)).unwrap_err().to_string();
    assert!(error.contains("19 triangles, not all of the full mesh"), "{error}");
    let mut flipped = Strips::default();
    flipped.push(&[1, 0, 2]);
    let one = CollapseSequence::from_collapses(3, vec![0, 1, 2], []).unwrap();
    assert!(Repair::new(&one, &flipped, options(5)).is_err());
}

#[test]
fn a_path_is_led_over_what_is_dropped_and_back() {
    // A strip over two rows; 3 collapses to 1, which drops two triangles inside it.
    let mut strips = Strips::default();
    strips.push(&[0, 1, 2, 3, 4, 5, 6, 7]);
    let rename = [Rename { removed: 3, kept: 1 }];
    let corners = strips.triangles().flatten().collect();
    let sequence = CollapseSequence::from_collapses(8, corners, [(&rename[..], 0.0)]).unwrap();
    let mut repair = Repair::new(&sequence, &strips, options(0)).unwrap();
    repair.work.near = 0;
    assert!(repair.coarsen());
    assert_eq!((repair.triangle_count(), repair.strip_count()), (5, 1));
    assert!(repair.refine());
    assert_eq!((repair.triangle_count(), repair.strip_count()), (6, 1));
}

#[test]
fn a_search_near_changes_holds_the_cost_down() {
    let sequence = sequence(&grid(40, 40, true, 0), 3);
    let strips = strips_of(&sequence);
    let mut sent = [0, 5].map(|effort| {
        let mut repair = Repair::new(&sequence, &strips, options(effort)).unwrap();
        repair.work.near *= usize::from(effort > 0);
        repair.go_to(sequence.len() / 2);
        repair.vertices_sent()
    });
    sent[1] += sent[1] / 8;
    assert!(sent[1] < sent[0], "{sent:?}");
}
