//! Strips at every level of generated meshes, compared with oracles: triangles drawn, paths, twins,
//! and costs computed from scratch.

use proptest::prelude::*;

use super::{Repair, RepairOptions, RepairedStrips};
use crate::collapse::{CollapseSequence, Rename};
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::effort::Effort;
use crate::ids::HalfEdge;
use crate::lod::samples::{Sample, crowded_samples, samples};
use crate::lod::{LevelCursor, LevelModel};
use crate::mesh::{Faces, Mesh};
use crate::simplify::{self, simplify_triangles};
use crate::strip::{Cost, Strips, path_cost};
use crate::stripify::{Method, stripify};
use crate::verify::verify_drawing;

/// Returns a wavy grid of triangles, simplified to a tenth.
fn waves(side: u32) -> Sample {
    let at = |i: u32| [(i % side) as f32, (i / side) as f32, ((i * i) % 7) as f32 / 9.0];
    let cells = (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| y * side + x));
    let quad = |i: u32| [i, i + 1, i + side, i + side, i + 1, i + side + 1];
    let faces = Faces::from_triangles(cells.flat_map(quad).collect()).unwrap();
    let mesh = Mesh::new((0..side * side).map(at).collect::<Vec<_>>(), faces).unwrap();
    let strips = stripify(&mesh, &crate::StripifyOptions::default().with_method(Method::Sequential)).unwrap();
    let triangles: Vec<u32> = strips.triangles().flatten().collect();
    let options = simplify::SimplifyOptions::default().with_triangles(triangles.len() / 30);
    Sample { sequence: simplify_triangles(&mesh, triangles, &options).unwrap().sequence, strips }
}

/// Checks twins over all pairs of half-edges: they are mutual, and no two half-edges of opposite
/// directions at an edge are both without a twin.
fn check_twins(repair: &Repair) -> Result<(), TestCaseError> {
    let slots = 0..repair.repaired.paths.len() as u32;
    let twins = |t: u32| (4 * t..4 * t + 3).map(|h| repair.repaired.paths.twin(h));
    for t in slots.clone().filter(|&t| !repair.mesh.is_drawn(t)) {
        prop_assert!(twins(t).all(|twin| twin.is_none()));
    }
    let sides: Vec<(u32, [u32; 2])> = slots
        .filter(|&t| repair.mesh.is_drawn(t))
        .flat_map(|t| {
            let [a, b, c] = repair.mesh.triangle(t);
            [(4 * t, [a, b]), (4 * t + 1, [b, c]), (4 * t + 2, [c, a])]
        })
        .collect();
    for &(h, [from, to]) in &sides {
        let twin = repair.repaired.paths.twin(h);
        let across: Vec<u32> =
            sides.iter().filter(|side| side.1 == [to, from]).map(|&(other, _)| other).collect();
        match twin {
            None => prop_assert!(across.iter().all(|&other| repair.repaired.paths.twin(other).is_some())),
            Some(twin) => prop_assert!(across.contains(&twin) && repair.repaired.paths.twin(twin) == Some(h)),
        }
    }
    Ok(())
}

/// Returns the twins of the half-edges of all slots.
fn twins(repair: &Repair) -> Vec<Option<u32>> {
    let half_edges = 0..4 * repair.repaired.paths.len() as u32;
    half_edges.map(|h| if h % 4 < 3 { repair.repaired.paths.twin(h) } else { None }).collect()
}

/// Pairs the half-edges of every edge from scratch: former twins remain twins if they are at the
/// same edge; the others are paired like brackets.
fn paired_from_scratch(repair: &Repair, before: &[Option<u32>]) -> Vec<Option<u32>> {
    let mesh = &repair.mesh;
    let is_opposite = |a: u32, b: u32| {
        let [from, to] = mesh.edge(a);
        mesh.edge(b) == [to, from]
    };
    let drawn = (0..repair.repaired.paths.len() as u32).filter(|&t| mesh.is_drawn(t));
    let mut sides: Vec<(u32, u32, u32)> = drawn
        .flat_map(|t| 4 * t..4 * t + 3)
        .map(|h| (mesh.edge(h)[0].min(mesh.edge(h)[1]), mesh.edge(h)[0].max(mesh.edge(h)[1]), h))
        .collect();
    sides.sort_unstable();
    let mut now = vec![None; before.len()];
    for edge in sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let mut unpaired: Vec<u32> = Vec::new();
        for &(_, _, h) in edge {
            let kept = before[h as usize].filter(|&twin| mesh.is_drawn(twin / 4) && is_opposite(h, twin));
            match kept.or_else(|| unpaired.pop_if(|last| is_opposite(*last, h))) {
                Some(twin) => (now[h as usize], now[twin as usize]) = (Some(twin), Some(h)),
                None => unpaired.push(h),
            }
        }
    }
    now
}

/// Compares a repair with a computation from scratch.
fn check(repair: &Repair) -> Result<(), TestCaseError> {
    let level = repair.level();
    let drawn = repair.sequence.drawn(level).unwrap();
    prop_assert_eq!(repair.triangle_count, drawn.len());
    check_twins(repair)?;
    for t in 0..repair.repaired.paths.len() as u32 {
        let is_end = repair.mesh.is_drawn(t) && repair.repaired.paths.degree(t) < 2;
        prop_assert_eq!(repair.repaired.paths.ends_of(t as usize / 64) >> (t % 64) & 1 == 1, is_end);
    }
    let half_edges = || (0..4 * repair.repaired.paths.len() as u32).filter(|h| h % 4 < 3);
    let by_threes = |h: u32| h / 4 * 3 + h % 4;
    let graph =
        DualGraph::of_triangle_twins(half_edges().map(|h| repair.repaired.paths.twin(h).map(by_threes)));
    let mut cover = PathCover::isolated(repair.repaired.paths.len());
    for h in half_edges() {
        if repair.repaired.paths.mask(h / 4) >> (h % 4) & 1 == 1 {
            prop_assert!(
                cover.is_linked(HalfEdge(by_threes(h))) || cover.link(&graph, HalfEdge(by_threes(h)))
            );
        }
    }
    prop_assert_eq!(cover.check(&graph), Ok(()));
    let costs: usize = cover
        .path_starts(&graph)
        .filter(|start| repair.mesh.is_drawn(start.0))
        .map(|start| path_cost(&graph, &cover, start))
        .sum();
    prop_assert_eq!(repair.vertices_sent(), costs);

    let strips = repair.emit();
    prop_assert_eq!((strips.len(), strips.vertices_sent()), (repair.repaired.paths.strip_count(), costs));
    let faces = Faces::from_triangles(drawn.concat()).unwrap();
    prop_assert!(verify_drawing(&faces, &strips.triangles().collect::<Vec<_>>()).is_ok());
    Ok(())
}

fn options(effort: u8) -> RepairOptions {
    RepairOptions::default().with_effort(Effort::new(effort).unwrap())
}

#[test]
fn a_model_without_triangles_has_one_level() {
    let mut cursor = std::sync::Arc::new(RepairedStrips::default()).start();
    assert_eq!((cursor.levels().collapse_count(), cursor.strips().len()), (0, 0));
    assert!(cursor.set_level(1).is_err());
}

proptest! {
    #[test]
    fn every_level_is_drawn(sample in samples(), seed in any::<u64>(), effort in 0..5_u8, restarts in any::<bool>()) {
        let Sample { strips, sequence } = sample;
        let cost = if restarts { Cost::Restart } else { Cost::OpenGl };
        let options = options(effort).with_seed(seed).with_cost(cost);
        let mut repair = Repair::new(sequence.clone(), &strips, options).unwrap();
        prop_assert_eq!(repair.vertices_sent(), strips.vertices_sent());
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
    fn twins_are_those_of_pairing_from_scratch(sample in crowded_samples()) {
        let Sample { strips, sequence } = sample;
        let mut repair = Repair::new(sequence, &strips, options(0)).unwrap();
        let mut before = twins(&repair);
        while repair.coarsen() {
            let now = twins(&repair);
            prop_assert_eq!(&now, &paired_from_scratch(&repair, &before));
            before = now;
        }
        while repair.refine() {
            let now = twins(&repair);
            prop_assert_eq!(&now, &paired_from_scratch(&repair, &before));
            before = now;
        }
    }

    #[test]
    fn any_way_to_a_level_draws_it(sample in samples(), ways in prop::collection::vec(0..40_usize, 0..12)) {
        let Sample { strips, sequence } = sample;
        let mut repair = Repair::at(sequence.clone(), &strips, sequence.len() / 2, options(1)).unwrap();
        check(&repair)?;
        for level in ways {
            let level = level.min(sequence.len());
            repair.set_level(level).unwrap();
            prop_assert_eq!(repair.level(), level);
            check(&repair)?;
        }
    }

    #[test]
    fn a_level_at_once_is_drawn_and_no_effort_makes_it_dearer(sample in samples()) {
        let Sample { strips, sequence } = sample;
        for level in 0..=sequence.len() {
            let no_search = Repair::at(sequence.clone(), &strips, level, options(0)).unwrap();
            check(&no_search)?;
            for effort in 1..4 {
                let repair = Repair::at(sequence.clone(), &strips, level, options(effort)).unwrap();
                check(&repair)?;
                prop_assert!(repair.vertices_sent() <= no_search.vertices_sent());
            }
        }
    }
}

#[test]
fn the_same_steps_give_the_same_strips() {
    let Sample { strips, sequence } = waves(20);
    let run = |seed| {
        let mut repair = Repair::new(sequence.clone(), &strips, options(5).with_seed(seed)).unwrap();
        [sequence.len() / 2, 0, sequence.len() / 2].map(|level| {
            repair.set_level(level).unwrap();
            repair.strips().clone()
        })
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1), run(2));
}

#[test]
fn strips_of_another_mesh_are_refused() {
    let Sample { mut strips, sequence } = waves(4);
    assert!(Repair::at(sequence.clone(), &strips, sequence.len() + 1, options(5)).is_err());
    strips.push(&[0, 1, 2]);
    let error = Repair::new(sequence.clone(), &strips, options(5)).unwrap_err().to_string();
    assert!(error.contains("19 triangles, not all of the full mesh"), "{error}");
    let mut flipped = Strips::default();
    flipped.push(&[1, 0, 2]);
    let one = CollapseSequence::from_collapses(3, vec![0, 1, 2], []).unwrap();
    assert!(Repair::new(one, &flipped, options(5)).is_err());
}

#[test]
fn a_path_is_led_over_what_is_dropped_and_back() {
    // A strip over two rows. 3 collapses to 1, which drops the second triangle.
    let mut strips = Strips::default();
    strips.push(&[0, 1, 2, 3, 4, 5, 6, 7]);
    let rename = [Rename { removed: 3, kept: 1 }];
    let corners = strips.triangles().flatten().collect();
    let sequence = CollapseSequence::from_collapses(8, corners, [(&rename[..], 0.0)]).unwrap();
    let mut repair = Repair::new(sequence.clone(), &strips, options(0)).unwrap();
    repair.work.near = 0;
    assert!(repair.coarsen());
    assert_eq!((repair.triangle_count, repair.repaired.paths.strip_count()), (5, 1));
    assert!(repair.refine());
    assert_eq!((repair.triangle_count, repair.repaired.paths.strip_count()), (6, 1));
}

#[test]
fn the_search_holds_the_cost_down_at_every_level() {
    let Sample { strips, sequence } = waves(60);
    let mut share = |effort| {
        let mut repair = Repair::new(sequence.clone(), &strips, options(effort)).unwrap();
        let mut sum = [0, 0];
        while repair.coarsen() {
            sum = [sum[0] + repair.vertices_sent(), sum[1] + 3 * repair.triangle_count];
        }
        sum[0] as f64 / sum[1] as f64
    };
    let shares = [0, 3, 5].map(&mut share);
    assert!(shares[0] < 0.45 && shares[1] < 0.41 && shares[2] < shares[1], "{shares:?}");
}
