//! Builds a mesh with attributes and options from arbitrary bytes. Simplification keeps locked
//! vertices, reports why it stopped, and every level equals the result of its collapses, applied
//! one by one.
#![no_main]

use tristrip::simplify::{SimplifyOptions, Stopped};
use tristrip_fuzz::{Bytes, apply, mesh, simplified, sorted, triangles_of, with_attributes};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let mut bytes = Bytes(data);
    let [attributes, goal, allowed, locked] = [0; 4].map(|_| bytes.next());
    let mesh = with_attributes(mesh(&mut bytes), attributes);
    // Every polygon as a fan, including degenerate and duplicate triangles.
    let fan =
        |face: &[u32]| (2..face.len()).flat_map(|i| [face[0], face[i - 1], face[i]]).collect::<Vec<_>>();
    let triangles: Vec<u32> = mesh.faces().iter().flat_map(fan).collect();
    // More values than vertices are an error, which the library's own tests cover.
    let locked_count = (u32::from(locked) % 32).min(u32::try_from(mesh.vertex_count()).unwrap());
    let locked: Vec<bool> = (0..locked_count).map(|v| u32::from(locked).rotate_left(v) & 1 == 1).collect();
    let mut options = SimplifyOptions::default().with_triangles(goal.into()).with_locked(locked.clone());
    let most = f32::from(allowed) / 8.0;
    if allowed < 128 {
        options = options.with_error(most);
    }
    let simplification = simplified(&mesh, triangles.clone(), &options);
    let (sequence, stopped) = (&simplification.sequence, simplification.stopped);
    assert_eq!(sequence.triangles(), triangles);

    let mut now = triangles;
    let is_real = |t: &[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[0] != t[2];
    for level in (0..=sequence.len()).rev() {
        let drawn = sequence.drawn(level).unwrap();
        assert_eq!(sequence.triangle_count(level).unwrap(), drawn.len());
        assert_eq!(sorted(drawn), sorted(triangles_of(&now).filter(is_real)), "level {level}");
        if level > 0 {
            let collapse = sequence.collapse(level - 1).unwrap();
            for rename in collapse.renames {
                assert!(!locked.get(rename.removed as usize).is_some_and(|&is| is), "{rename:?} is locked");
                apply(&mut now, *rename);
            }
            assert!(allowed >= 128 || collapse.error <= most, "{} > {most}", collapse.error);
            assert!(sequence.error(level).unwrap() <= sequence.error(level - 1).unwrap());
        }
    }
    assert_eq!(stopped.is_some(), sequence.triangle_count(0).unwrap() > goal.into());
    if let Some(Stopped { triangle_count, .. }) = stopped {
        assert_eq!(triangle_count, sequence.triangle_count(0).unwrap());
    }
});
