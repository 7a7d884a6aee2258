//! Builds strips and collapses from arbitrary bytes. Every level model draws every level, in
//! rising, falling and jumping order.
#![no_main]

use std::sync::Arc;

use tristrip_fuzz::{Bytes, Model, model, sorted};
use tristrip_lab::baselines::ComparedModel;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let mut bytes = Bytes(data);
    let Some(Model { strips, sequence }) = model(&mut bytes) else { return };
    let oracle: Vec<Vec<[u32; 3]>> =
        (0..=sequence.len()).map(|level| sorted(sequence.drawn(level).unwrap())).collect();
    let last = sequence.len();
    let jumps = data.iter().take(16).map(|&byte| usize::from(byte) % (last + 1));
    let path: Vec<usize> = (0..=last).rev().chain(0..=last).chain(jumps).collect();
    let sequence = Arc::new(sequence);
    for kind in ComparedModel::ALL {
        let Ok(model) = kind.build(&strips, &sequence) else { continue };
        let mut cursor = model.start();
        assert_eq!(sorted(cursor.strips().triangles()), oracle[last], "{kind}");
        for &level in &path {
            cursor.set_level(level).expect("a level of the sequence");
            assert_eq!(sorted(cursor.strips().triangles()), oracle[level], "{kind} at level {level}");
        }
        assert!(cursor.set_level(last + 1).is_err());
    }
});
