//! Builds strips, collapses and options from arbitrary bytes. Repaired strips draw every level:
//! going down, going up, after a jump, and built directly. The vertex counts match the strips.
#![no_main]

use std::sync::Arc;

use tristrip::Cost;
use tristrip::Effort;
use tristrip::lod::{LevelCursor, Repair, RepairOptions};
use tristrip_fuzz::{Bytes, Model, model, sorted};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let mut bytes = Bytes(data);
    let [effort, cost, seed, jump] = [0; 4].map(|_| bytes.next());
    let Some(Model { strips, sequence }) = model(&mut bytes) else { return };
    let cost = [Cost::Restart, Cost::OpenGl, Cost::Degenerate, Cost::Gl][usize::from(cost) % 4];
    let options = RepairOptions::default().with_effort(Effort::new(effort % 5).expect("effort 0 to 9"));
    let options = options.with_cost(cost).with_seed(seed.into());
    let oracle: Vec<Vec<[u32; 3]>> =
        (0..=sequence.len()).map(|level| sorted(sequence.drawn(level).unwrap())).collect();
    let jump = usize::from(jump) % oracle.len();

    let sequence = Arc::new(sequence);
    let mut repair = Repair::new(Arc::clone(&sequence), &strips, options).expect("strips of the sequence");
    draws(&mut repair, &oracle);
    while repair.coarsen() {
        draws(&mut repair, &oracle);
    }
    assert_eq!(repair.level(), 0);
    while repair.refine() {
        draws(&mut repair, &oracle);
    }
    assert_eq!(repair.level(), sequence.len());
    repair.set_level(jump).expect("a level of the sequence");
    assert_eq!(repair.level(), jump);
    draws(&mut repair, &oracle);
    let mut direct = Repair::at(sequence, &strips, jump, options).expect("a level of the sequence");
    draws(&mut direct, &oracle);
});

/// Compares the strips and counts of a level with the oracle.
fn draws(repair: &mut Repair, oracle: &[Vec<[u32; 3]>]) {
    let (strips, expected) = (repair.strips().clone(), &oracle[repair.level()]);
    assert_eq!(&sorted(strips.triangles()), expected, "level {}", repair.level());
    assert_eq!(repair.vertices_sent(), strips.vertices_sent(), "level {}", repair.level());
}
