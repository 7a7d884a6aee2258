//! Builds strips and collapses from arbitrary bytes. Progressive strips of both encodings and the
//! progressive mesh draw every level through every filter, and return to the same entries.
#![no_main]

use std::sync::Arc;

use tristrip::Strips;
use tristrip::lod::{Encoding, ProgressiveStripsCursor};
use tristrip::lod::{Filter, LevelCursor, ProgressiveMesh, ProgressiveStrips, RESTART};
use tristrip::strip_triangles;
use tristrip_fuzz::{Bytes, Model, model, sorted, triangles_of};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let mut bytes = Bytes(data);
    let Some(Model { strips, sequence }) = model(&mut bytes) else { return };
    let oracle: Vec<Vec<[u32; 3]>> =
        (0..=sequence.len()).map(|level| sorted(sequence.drawn(level).unwrap())).collect();
    for encoding in [Encoding::Naive, Encoding::Offsets] {
        let Ok(model) = ProgressiveStrips::new(&strips, &sequence, encoding) else { continue };
        let mut cursor = Arc::new(model).cursor();
        let mut entries = vec![cursor.entries().to_vec()];
        draws(&mut cursor, &oracle);
        while cursor.coarsen() {
            entries.push(cursor.entries().to_vec());
            draws(&mut cursor, &oracle);
        }
        entries.reverse();
        assert_eq!((cursor.level(), entries.len()), (0, oracle.len()));
        while cursor.refine() {
            assert_eq!(cursor.entries(), entries[cursor.level()]);
        }
        assert_eq!(cursor.level(), sequence.len());
        let middle = data.len() % oracle.len();
        cursor.set_level(middle).expect("a level of the sequence");
        assert_eq!(cursor.entries(), entries[middle]);
        assert!(cursor.set_level(oracle.len()).is_err());
    }

    let mut mesh = Arc::new(ProgressiveMesh::new(&sequence).expect("few triangles")).cursor();
    for (level, expected) in oracle.iter().enumerate() {
        mesh.set_level(level).expect("a level of the sequence");
        assert_eq!(&sorted(triangles_of(mesh.corners())), expected);
    }
});

/// Compares the map of a model's level, and its display strips through every filter, with the
/// oracle.
fn draws(cursor: &mut ProgressiveStripsCursor, oracle: &[Vec<[u32; 3]>]) {
    let (mut map, expected) = (Vec::new(), &oracle[cursor.level()]);
    assert_eq!(&sorted(cursor.strips().triangles()), expected);
    cursor.decode_to(&mut map);
    assert_eq!(&sorted(map.split(|&v| v == RESTART).flat_map(strip_triangles)), expected);
    for filter in Filter::ALL {
        let mut display = Strips::default();
        filter.map_to(&map, &mut display);
        assert_eq!(&sorted(display.triangles()), expected, "{filter:?} at level {}", cursor.level());
        let sent = filter.sent_by_map(&map);
        assert_eq!((sent.vertices, sent.strips), (display.vertices_sent(), display.len()), "{filter:?}");
    }
}
