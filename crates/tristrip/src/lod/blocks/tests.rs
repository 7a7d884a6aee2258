use proptest::prelude::*;

use super::*;
use crate::collapse::Rename;
use crate::lod::samples::{crowded_samples, samples, sorted};

proptest! {
    /// The oracle of the ranges compares both buffers. The oracle of the strips is in the tests of
    /// all models.
    #[test]
    fn changed_ranges_contain_every_change(
        sample in prop_oneof![samples(), crowded_samples()],
        jumps in prop::collection::vec(any::<usize>(), 1..9),
        most in 0..4_usize,
        memory in 0..60_u32,
        small_uploads in any::<bool>(),
    ) {
        let options = BlockOptions::default().with_memory(memory).with_small_uploads(small_uploads);
        let model = Blocks::new(&sample.strips, sample.sequence.clone(), &options).unwrap();
        let mut cursor = Arc::new(model).cursor().unwrap();
        let mut uploaded: Vec<u8> = Vec::new();
        for jump in jumps {
            let level = jump % (sample.sequence.len() + 1);
            cursor.set_level(level).unwrap();
            prop_assert_eq!(sorted(cursor.strips().triangles()), sorted(sample.sequence.drawn(level).unwrap()));
            if jump % 3 == 0 {
                // Several level changes between two calls, also to other keys and back.
                continue;
            }
            let changed = cursor.take_changed(most);
            prop_assert!(changed.len() <= most.max(1));
            prop_assert!(changed.iter().all(|range| !range.is_empty()));
            prop_assert!(changed.windows(2).all(|pair| pair[0].end < pair[1].start));
            uploaded.resize(cursor.indices().len(), u8::RESTART - 1);
            for range in changed {
                uploaded[range.clone()].copy_from_slice(&cursor.indices()[range]);
            }
            prop_assert_eq!(&uploaded[..], cursor.indices());
            prop_assert!(cursor.take_changed(most).is_empty());
        }
    }

    /// The order of level changes does not matter: each level has one buffer.
    #[test]
    fn a_level_has_the_same_buffer_from_both_sides(sample in samples(), memory in 0..60_u32) {
        let options = BlockOptions::default().with_memory(memory);
        let last = sample.sequence.len();
        let model = Arc::new(Blocks::new(&sample.strips, sample.sequence, &options).unwrap());
        let mut cursor = model.cursor::<u16>().unwrap();
        let mut down = Vec::new();
        for level in (0..=last).rev() {
            cursor.set_level(level).unwrap();
            down.push(cursor.indices().to_vec());
        }
        for level in 0..=last {
            cursor.set_level(level).unwrap();
            prop_assert_eq!(&down[last - level], cursor.indices());
        }
    }
}

/// Returns the buffers after each collapse of one strip, without keys.
fn buffers_of(strip: &[u32], renames: &[[u32; 2]]) -> Vec<Vec<u32>> {
    let mut buffer = LiveBuffer::new(strip.to_vec(), 32);
    let of_rename = |&[removed, kept]: &[u32; 2]| {
        buffer.collapse(&[Rename { removed, kept }]);
        buffer.entries().to_vec()
    };
    renames.iter().map(of_rename).collect()
}

const R: u32 = RESTART;

#[test]
fn ends_without_triangles_become_restarts() {
    assert_eq!(
        buffers_of(&[0, 1, 2, 3, 4, 5], &[[0, 2], [5, 3], [2, 3]]),
        // The first remaining triangle has reversed winding, so the slot before it is kept.
        [[2, 1, 2, 3, 4, 5], [2, 1, 2, 3, 4, R], [R; 6]]
    );
}

#[test]
fn slots_between_two_triangles_become_restarts() {
    let strip = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9];
    // Two degenerate triangles share all their slots with their neighbours; four have two slots of
    // their own.
    assert_eq!(
        buffers_of(&strip, &[[3, 4], [5, 4], [6, 4]]),
        [[0, 1, 2, 4, 4, 5, 6, 7, 8, 9], [0, 1, 2, 4, 4, 4, 6, 7, 8, 9], [0, 1, 2, 4, R, R, 4, 7, 8, 9]]
    );
}

/// Builds the model of one strip, moves over all levels and checks that each is drawn.
fn check_levels(strips: &Strips, sequence: &CollapseSequence) {
    for small_uploads in [false, true] {
        let options = BlockOptions::default().with_small_uploads(small_uploads);
        let mut cursor = Arc::new(Blocks::new(strips, sequence.clone(), &options).unwrap()).start();
        let last = sequence.len();
        for level in (0..=last).rev().chain(0..=last) {
            cursor.set_level(level).unwrap();
            assert_eq!(sorted(cursor.strips().triangles()), sorted(sequence.drawn(level).unwrap()));
        }
    }
}

fn sequence_of(vertex_count: usize, triangles: Vec<u32>, renames: &[[u32; 2]]) -> CollapseSequence {
    let renames: Vec<[Rename; 1]> =
        renames.iter().map(|&[removed, kept]| [Rename { removed, kept }]).collect();
    let collapses = renames.iter().map(|renames| (&renames[..], 0.5));
    CollapseSequence::from_collapses(vertex_count, triangles, collapses).unwrap()
}

#[test]
fn collapses_may_rename_what_is_not_drawn() {
    let mut strips = Strips::default();
    strips.push(&[0, 1, 2]);
    check_levels(&strips, &sequence_of(3, vec![0, 1, 2], &[[2, 1], [1, 0]]));
    // The kept vertex is not in any strip.
    check_levels(&strips, &sequence_of(10, vec![0, 1, 2, 9, 9, 9], &[[2, 9]]));
    check_levels(&Strips::default(), &sequence_of(3, vec![0, 0, 1], &[[0, 1]]));
    strips.push(&[3, 4, 5]);
    check_levels(&strips, &sequence_of(6, vec![0, 1, 2, 3, 4, 5], &[[0, 1], [1, 2], [4, 5]]));
}

#[test]
fn without_triangles_there_are_no_more_keys() {
    let mut strips = Strips::default();
    strips.push(&[0, 1, 2]);
    let renames: Vec<[u32; 2]> = (0..500).map(|i| [i, i + 1]).collect();
    let sequence =
        sequence_of(501, [vec![0, 1, 2], (2..501).flat_map(|v| [v; 3]).collect()].concat(), &renames);
    let model = Blocks::new(&strips, sequence, &BlockOptions::default()).unwrap();
    assert!(model.keys().len() <= 2, "{:?}", model.keys().collect::<Vec<_>>());
}

#[test]
fn strips_of_another_mesh_are_refused() {
    let mut strips = Strips::default();
    strips.push(&[0, 1, 2]);
    for renames in [&[][..], &[[3, 2]]] {
        let sequence = sequence_of(4, vec![0, 1, 2, 2, 1, 3], renames);
        assert!(Blocks::new(&strips, sequence, &BlockOptions::default()).is_err());
    }
}

#[test]
fn vertices_must_fit_the_type_of_the_indices() {
    let mut strips = Strips::default();
    strips.push(&[0, 1, 255]);
    let sequence = CollapseSequence::from_collapses(256, strips.to_list(), []).unwrap();
    let model = Arc::new(Blocks::new(&strips, sequence, &BlockOptions::default()).unwrap());
    let error = model.cursor::<u8>().unwrap_err();
    assert_eq!(error.to_string(), "8-bit index: found 255, the limit is 254");
    assert_eq!(model.cursor::<u16>().unwrap().indices(), [0, 1, 255]);
}

#[test]
fn more_vertices_than_16_bits_hold_take_32() {
    let mut strips = Strips::default();
    strips.push(&[0, 1, 70_000, 2]);
    let rename = [Rename { removed: 70_000, kept: 1 }];
    let collapses = [(&rename[..], 0.5)];
    let sequence = CollapseSequence::from_collapses(70_001, strips.to_list(), collapses).unwrap();
    let model = Arc::new(Blocks::new(&strips, sequence, &BlockOptions::default()).unwrap());
    assert!(model.cursor::<u16>().is_err());
    assert_eq!(model.cursor::<u32>().unwrap().indices(), [0, 1, 70_000, 2]);
    let mut cursor = model.start();
    assert_eq!(cursor.strips().vertices(), [0, 1, 70_000, 2]);
    cursor.set_level(0).unwrap();
    assert!(cursor.strips().is_empty());
}

#[test]
fn without_triangles_there_is_an_empty_drawing() {
    let sequence = CollapseSequence::from_collapses(0, Vec::new(), []).unwrap();
    let model = Arc::new(Blocks::new(&Strips::default(), sequence, &BlockOptions::default()).unwrap());
    let mut cursor = model.cursor::<usize>().unwrap();
    assert_eq!(cursor.indices(), [usize::RESTART]);
    assert!(cursor.strips().is_empty() && cursor.set_level(1).is_err());
}

#[test]
fn more_memory_than_256_bytes_per_triangle_changes_nothing() {
    let strips = Strips::from_parts((0..40).collect(), vec![40]).unwrap();
    let renames: Vec<[Rename; 1]> = (2..39).map(|i| [Rename { removed: i + 1, kept: i }]).rev().collect();
    let collapses = renames.iter().map(|renames| (&renames[..], 1.0));
    let sequence = CollapseSequence::from_collapses(40, strips.to_list(), collapses).unwrap();
    let memory = |bytes| {
        let options = BlockOptions::default().with_memory(bytes);
        Blocks::new(&strips, sequence.clone(), &options).unwrap().memory()
    };
    assert_eq!(memory(256), memory(999));
}
