use super::*;

fn fan() -> CollapseSequence {
    // A hexagon around vertex 6. Its corners 0, 1 and 2 collapse one after the other to the next
    // corner.
    let triangles = (0..6).flat_map(|i| [i, (i + 1) % 6, 6]).collect();
    let renames = [
        [Rename { removed: 0, kept: 1 }],
        [Rename { removed: 1, kept: 2 }],
        [Rename { removed: 2, kept: 3 }],
    ];
    let collapses = renames.iter().zip([1.0, 3.0, 2.0]).map(|(r, error)| (&r[..], error));
    CollapseSequence::from_collapses(7, triangles, collapses).unwrap()
}

#[test]
fn the_memory_counts_the_largest_errors() {
    let rename = [Rename { removed: 3, kept: 2 }];
    let build = |collapses: &[(&[Rename], f32)]| {
        CollapseSequence::from_collapses(4, vec![0, 1, 2, 2, 1, 3], collapses.iter().copied())
            .unwrap()
            .memory()
    };
    // A rename, its end, a dropped triangle, its end, the error, and the largest error so far.
    assert_eq!(build(&[(&rename, 0.5)]) - build(&[]), 8 + 4 + 4 + 4 + 4 + 4);
}

#[test]
fn levels_of_a_fan() {
    let fan = fan();
    assert_eq!(fan.len(), 3);
    assert_eq!([0, 1, 2, 3].map(|level| fan.triangles_at(level)), [3, 4, 5, 6]);
    assert_eq!([0, 1, 2, 3].map(|level| fan.drawn(level).unwrap().len()), [3, 4, 5, 6]);
    assert_eq!(fan.drawn(0).unwrap(), [[3, 4, 6], [4, 5, 6], [5, 3, 6]]);
    assert_eq!(
        [0, 1, 2, 3].map(|level| fan.error_at(level).to_bits()),
        [3_f32, 3.0, 1.0, 0.0].map(f32::to_bits)
    );
    assert_eq!([9, 6, 5, 3, 2, 0].map(|count| fan.level_of_triangles(count)), [3, 3, 2, 0, 0, 0]);
    assert_eq!([0.0, 1.0, 2.5, 3.0].map(|error| fan.level_of_error(error)), [3, 2, 2, 0]);
    fan.check().unwrap();
}

#[test]
fn wrong_dropped_triangles_are_detected() {
    let mut fan = fan();
    fan.dropped.swap(0, 1);
    assert!(fan.check().unwrap_err().to_string().contains("other triangles dropped by collapse 0"));
}

#[test]
fn collapses_of_missing_vertices_are_refused() {
    let collapse = |removed, kept| {
        let renames = [[Rename { removed: 3, kept: 2 }], [Rename { removed, kept }]];
        let collapses = renames.iter().map(|r| (&r[..], 0.0));
        CollapseSequence::from_collapses(5, vec![0, 1, 2, 2, 1, 3], collapses)
    };
    assert!(collapse(0, 1).is_ok());
    for (removed, kept) in [(3, 0), (0, 3), (0, 0), (0, 5), (7, 0), (4, 0), (0, 4)] {
        let error = collapse(removed, kept).unwrap_err().to_string();
        assert!(error.contains(&format!("{removed} renamed to {kept} by collapse 1")), "{error}");
    }
    for error in [f32::NAN, -1.0] {
        let rename = [Rename { removed: 3, kept: 2 }];
        let collapses = [(&rename[..], error)];
        assert!(CollapseSequence::from_collapses(4, vec![0, 1, 2, 2, 1, 3], collapses).is_err());
    }
    assert!(CollapseSequence::from_collapses(2, vec![0, 1], []).is_err());
    assert!(CollapseSequence::from_collapses(2, vec![0, 1, 2], []).is_err());
}

#[test]
fn both_sides_of_a_seam_are_renamed_together() {
    // Vertices 1 and 4 are at one position, 2 and 5 at another.
    let renames = [Rename { removed: 1, kept: 2 }, Rename { removed: 4, kept: 5 }];
    let sequence =
        CollapseSequence::from_collapses(7, vec![0, 1, 2, 4, 3, 5, 3, 4, 6], [(&renames[..], 0.0)]).unwrap();
    assert_eq!(sequence.collapse_to(0).dropped, [0, 1]);
    assert_eq!(sequence.drawn(0).unwrap(), [[3, 5, 6]]);
}

#[test]
fn wrong_levels_and_counts_are_refused() {
    let fan = fan();
    for level in [4, usize::MAX] {
        let message =
            format!("parameter `level`: found {level} of 3, expected at most the level of the full mesh");
        assert_eq!(fan.triangle_count(level).unwrap_err().to_string(), message);
        assert_eq!(fan.error(level).unwrap_err().to_string(), message);
        assert_eq!(fan.renaming(level).unwrap_err().to_string(), message);
        assert_eq!(fan.drawn(level).unwrap_err().to_string(), message);
    }
    assert!(fan.collapse(2).is_ok() && fan.collapse(3).is_err() && fan.collapse(usize::MAX).is_err());
    assert!(CollapseSequence::default().collapse(0).is_err());
    assert_eq!((fan.level_of_triangles(usize::MAX), fan.level_of_error(f32::INFINITY)), (3, 0));
    assert!(CollapseSequence::from_collapses(usize::MAX, vec![], []).is_err());
    assert!(CollapseSequence::from_collapses(3, vec![0, 1, u32::MAX], []).is_err());
}

#[test]
fn few_of_many_vertices_take_little_memory() {
    let many = u32::MAX as usize - 1;
    let far = |v: u32| 1_000_000_000 * v;
    let rename = [Rename { removed: far(3), kept: far(2) }];
    let triangles = [0, 1, 2, 2, 1, 3].map(far);
    let of = |rename: &[Rename]| CollapseSequence::from_collapses(many, triangles.to_vec(), [(rename, 0.5)]);
    let sequence = of(&rename[..]).unwrap();
    assert_eq!(sequence.drawn(0).unwrap(), [[0, far(1), far(2)]]);
    assert_eq!(sequence.drawn(1).unwrap().len(), 2);
    sequence.check().unwrap();
    for (removed, kept) in [(far(3) + 1, far(2)), (far(3), u32::MAX), (far(3), far(3))] {
        assert!(of(&[Rename { removed, kept }]).is_err());
    }
}

#[test]
fn long_chains_of_collapses_are_checked_in_little_time() {
    // A fan around vertex 0, which moves along its rim one vertex at a time: the hub of n corners
    // is renamed n times.
    let n = 100_000;
    let triangles: Vec<u32> = (1..n).flat_map(|i| [0, i, i + 1]).collect();
    let renames: Vec<_> = (0..n - 1).map(|v| [Rename { removed: v, kept: v + 1 }]).collect();
    let collapses = renames.iter().map(|renames| (&renames[..], 0.0));
    let sequence = CollapseSequence::from_collapses(n as usize + 1, triangles, collapses).unwrap();
    assert_eq!(sequence.triangle_count(0).unwrap(), 0);
    sequence.check().unwrap();
    // One collapse with many renames.
    let renames: Vec<_> = (1..n).map(|v| Rename { removed: v, kept: n }).collect();
    let triangles: Vec<u32> = (1..n).flat_map(|i| [0, i, i + 1]).collect();
    let sequence =
        CollapseSequence::from_collapses(n as usize + 1, triangles, [(&renames[..], 0.0)]).unwrap();
    assert_eq!(sequence.triangle_count(0).unwrap(), 0);
}
