use proptest::prelude::*;
use std::sync::Arc;

use super::encoded_offset;
use super::{Encoding, ProgressiveMesh, ProgressiveStrips, ProgressiveStripsCursor};
use crate::collapse::{CollapseSequence, Rename};
use crate::lod::samples::{samples, sorted};
use crate::lod::{Filter, LevelCursor, RESTART};
use crate::strip::{Strips, strip_triangles};

const ENCODINGS: [Encoding; 2] = [Encoding::Naive, Encoding::Offsets];

fn strips(strips: &[&[u32]]) -> Strips {
    let mut all = Strips::default();
    strips.iter().for_each(|strip| all.push(strip));
    all
}

fn sequence(strips: &Strips, collapses: &[(u32, u32)]) -> CollapseSequence {
    let renames: Vec<_> = collapses.iter().map(|&(removed, kept)| [Rename { removed, kept }]).collect();
    let count = strips.vertices().iter().max().map_or(0, |&v| v as usize + 1);
    CollapseSequence::from_collapses(count, strips.to_list(), renames.iter().map(|r| (&r[..], 0.0))).unwrap()
}

fn cursor(strips: &Strips, sequence: &CollapseSequence, encoding: Encoding) -> ProgressiveStripsCursor {
    Arc::new(ProgressiveStrips::new(strips, sequence, encoding).unwrap()).cursor()
}

/// Formats the entries as readable text.
fn text(model: &ProgressiveStripsCursor) -> String {
    let entry = |&e: &u32| match encoded_offset(e) {
        Some(offset) => format!("{offset:+}"),
        None if e == RESTART => "R".into(),
        None => e.to_string(),
    };
    model.entries().iter().map(entry).collect::<Vec<_>>().join(" ")
}

fn decoded(model: &ProgressiveStripsCursor) -> Vec<u32> {
    let mut map = vec![77; 3];
    model.decode_to(&mut map);
    map
}

#[test]
fn the_example_of_the_head() {
    let strips = strips(&[&[0, 1, 2, 3, 4], &[3, 2, 5]]);
    let sequence = sequence(&strips, &[(4, 2), (3, 2)]);
    let mut model = cursor(&strips, &sequence, Encoding::Naive);
    assert_eq!(
        (text(&model).as_str(), model.model().slot_count(1), model.model().slot_count(0)),
        ("0 1 2 3 4 R 3 2 5", 1, 2)
    );
    model.coarsen();
    assert_eq!(text(&model), "0 1 2 3 2 R 3 2 5");
    model.coarsen();
    assert_eq!(text(&model), "0 1 2 2 2 R 2 2 5");
}

#[test]
fn followers_of_a_place_need_no_update() {
    let strips = strips(&[&[0, 1, 2, 3, 4, 5]]);
    let sequence = sequence(&strips, &[(4, 3), (3, 2)]);
    let mut model = cursor(&strips, &sequence, Encoding::Offsets);
    assert_eq!([0, 1].map(|level| model.model().slot_count(level)), [1, 1]);
    model.set_level(1).unwrap();
    assert_eq!((text(&model).as_str(), decoded(&model)), ("0 1 2 3 -1 5", vec![0, 1, 2, 3, 3, 5]));
    model.set_level(0).unwrap();
    assert_eq!((text(&model).as_str(), decoded(&model)), ("0 1 2 -1 -1 5", vec![0, 1, 2, 2, 2, 5]));
}

#[test]
fn a_swap_follows_the_vertex_that_it_repeats() {
    let strips = strips(&[&[0, 1, 2, 1, 3]]);
    let sequence = sequence(&strips, &[(1, 3)]);
    let mut model = cursor(&strips, &sequence, Encoding::Offsets);
    assert_eq!(text(&model), "0 1 2 -2 3");
    model.coarsen();
    // The root is three slots from 3. Its follower is adjacent to 3, but is not considered.
    assert_eq!((text(&model).as_str(), decoded(&model)), ("0 3 2 -2 3", vec![0, 3, 2, 3, 3]));
}

#[test]
fn a_closed_vertex_is_encoded_on_one_side_only() {
    // A spiral passes vertex 1 twice; its second slot is adjacent to vertex 5.
    let strips = strips(&[&[0, 1, 2, 3, 4, 1, 5]]);
    let sequence = sequence(&strips, &[(1, 5)]);
    let mut model = cursor(&strips, &sequence, Encoding::Offsets);
    model.coarsen();
    assert_eq!(text(&model), "0 5 2 3 4 +1 5");
}

#[test]
fn symbols_end_at_restarts() {
    let strips = strips(&[&[0, 1, 2], &[3, 1, 4], &[2, 5, 4]]);
    let sequence = sequence(&strips, &[(2, 3), (5, 1)]);
    let mut model = cursor(&strips, &sequence, Encoding::Offsets);
    model.set_level(0).unwrap();
    assert_eq!(text(&model), "0 1 3 R 3 1 4 R 3 1 4");
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let strips = strips(&[&[0, 1, 9]]);
    let small = CollapseSequence::from_collapses(3, vec![0, 1, 2], []).unwrap();
    for encoding in ENCODINGS {
        let error = ProgressiveStrips::new(&strips, &small, encoding).unwrap_err().to_string();
        assert_eq!(error, "strip 0, vertex 2: found vertex index 9, expected less than 3");
    }
}

#[test]
fn a_hostile_sequence_hits_the_limit() {
    // A fan of one strip whose rim collapses along itself: the number of slots over all collapses
    // is quadratic.
    let count = 2000;
    let zigzag: Vec<u32> = (1..count).flat_map(|i| [0, i]).collect();
    let strips = strips(&[&zigzag]);
    let mut collapses: Vec<[Rename; 1]> = Vec::new();
    for removed in 1..count - 1 {
        collapses.push([Rename { removed, kept: removed + 1 }]);
    }
    let list: Vec<u32> = (1..count - 1).flat_map(|i| [0, i, i + 1]).collect();
    let renames = collapses.iter().map(|r| (&r[..], 0.0));
    let sequence = CollapseSequence::from_collapses(count as usize, list, renames).unwrap();
    let error = ProgressiveStrips::new(&strips, &sequence, Encoding::Naive).unwrap_err().to_string();
    assert!(error.starts_with("slots renamed by all collapses: found "), "{error}");
    // The mesh drops triangles with their corners, so only two are renamed at each collapse.
    assert!(ProgressiveMesh::new(&sequence).is_ok());
    let encoded = ProgressiveStrips::new(&strips, &sequence, Encoding::Offsets).unwrap();
    assert!((0..sequence.len()).all(|level| encoded.slot_count(level) == 1));
}

proptest! {
    #[test]
    fn every_level_draws_what_the_oracle_draws(sample in samples()) {
        let (strips, sequence) = (&sample.strips, &sample.sequence);
        let full = strips.to_restart(RESTART);
        let mut mesh = Arc::new(ProgressiveMesh::new(sequence).unwrap()).cursor();
        let mut models = ENCODINGS.map(|e| cursor(strips, sequence, e));
        for level in (0..=sequence.len()).rev() {
            let drawn = sorted(sequence.drawn(level).unwrap());
            let corners = mesh.corners().chunks_exact(3).map(|t| [t[0], t[1], t[2]]);
            prop_assert_eq!(&sorted(corners), &drawn);
            prop_assert_eq!(mesh.levels().triangle_count(level).unwrap(), drawn.len());
            let now = sequence.renaming(level).unwrap();
            let renamed = |&v: &u32| if v == RESTART { v } else { now[v as usize] };
            let expected: Vec<u32> = full.iter().map(renamed).collect();
            for model in &models {
                let map = decoded(model);
                prop_assert_eq!(&map, &expected);
                for filter in Filter::ALL {
                    let mut display = Strips::default();
                    filter.map_to(&map, &mut display);
                    prop_assert_eq!(&sorted(display.triangles()), &drawn);
                }
            }
            mesh.set_level(level.saturating_sub(1)).unwrap();
            for model in &mut models {
                prop_assert_eq!(model.coarsen(), level > 0);
            }
        }
        prop_assert_eq!(sorted(full.split(|&v| v == RESTART).flat_map(strip_triangles)).len(), sequence.triangles().len() / 3);
    }

    #[test]
    fn steps_and_jumps_lead_to_the_same_entries(sample in samples(), jumps in prop::collection::vec(any::<usize>(), 1..9)) {
        for encoding in ENCODINGS {
            let mut model = cursor(&sample.strips, &sample.sequence, encoding);
            let mut levels = vec![model.entries().to_vec()];
            while model.coarsen() {
                levels.push(model.entries().to_vec());
            }
            levels.reverse();
            for &jump in &jumps {
                let level = jump % levels.len();
                model.set_level(level).unwrap();
                prop_assert_eq!((model.level(), model.entries()), (level, &levels[level][..]));
            }
            model.set_level(0).unwrap();
            while model.refine() {
                prop_assert_eq!(model.entries(), &levels[model.level()][..]);
            }
            prop_assert_eq!(model.level(), sample.sequence.len());
        }
        let mut mesh = Arc::new(ProgressiveMesh::new(&sample.sequence).unwrap()).cursor();
        let full = mesh.corners().to_vec();
        let count = sample.sequence.len();
        jumps.iter().for_each(|jump| mesh.set_level(jump % (count + 1)).unwrap());
        mesh.set_level(count).unwrap();
        prop_assert_eq!(mesh.corners(), &full[..]);
    }

    #[test]
    fn a_split_writes_its_vertex_where_it_stands(sample in samples()) {
        let [naive, encoded] = ENCODINGS.map(|e| cursor(&sample.strips, &sample.sequence, e));
        for level in 0..sample.sequence.len() {
            let removed: Vec<u32> = sample.sequence.collapse_to(level).renames.iter().map(|r| r.removed).collect();
            for model in [&naive, &encoded] {
                let split = || model.model().split(level).unwrap();
                prop_assert_eq!(split().map(|update| update.vertex).collect::<Vec<_>>(), &removed[..]);
                prop_assert!(split().all(|update| update.slots.is_sorted()));
            }
            prop_assert!(encoded.model().slot_count(level) <= naive.model().slot_count(level));
            let mut at = naive.clone();
            at.set_level(level + 1).unwrap();
            for update in naive.model().split(level).unwrap() {
                let slots = (0..at.entries().len() as u32).filter(|&p| at.entries()[p as usize] == update.vertex);
                prop_assert_eq!(slots.collect::<Vec<_>>(), update.slots);
            }
        }
    }
}

#[test]
fn wings_of_a_grid() {
    // Two quads. The middle of the upper edge collapses to that of the lower one, then to a corner.
    //  3──4──5
    //  │╲ │╲ │
    //  0──1──2
    let triangles = vec![0, 1, 3, 1, 4, 3, 1, 2, 4, 2, 5, 4];
    let renames = [[Rename { removed: 4, kept: 1 }], [Rename { removed: 1, kept: 0 }]];
    let renames = renames.iter().map(|r| (&r[..], 0.0));
    let sequence = CollapseSequence::from_collapses(6, triangles, renames).unwrap();
    let model = ProgressiveMesh::new(&sequence).unwrap();
    let wings = |level| model.splits(level).unwrap().map(|s| (s.kept, s.vertex, s.wings)).collect::<Vec<_>>();
    assert_eq!(wings(1), [(1, 4, [Some(3), Some(2)])]);
    assert_eq!(wings(0), [(0, 1, [Some(3), None])]);
}
