//! Arbitrary bytes, read as strips and collapses: progressive strips of both encodings and the progressive mesh draw every level, through
//! every filter, and return to the entries that they had.
#![no_main]

use tristrip::Strips;
use tristrip::lod::progressive::Encoding;
use tristrip::lod::{Filter, ProgressiveMesh, ProgressiveStrips, RESTART};
use tristrip::strip::strip_triangles;
use tristrip_fuzz::{Bytes, Model, model, sorted, triangles_of};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let mut bytes = Bytes(data);
    let Some(Model { strips, sequence }) = model(&mut bytes) else { return };
    let oracle: Vec<Vec<[u32; 3]>> =
        (0..=sequence.len()).map(|level| sorted(sequence.drawn(level))).collect();
    for encoding in [Encoding::Naive, Encoding::Offsets] {
        let Ok(mut model) = ProgressiveStrips::new(&strips, &sequence, encoding) else { continue };
        let mut entries = vec![model.entries().to_vec()];
        draws(&model, &oracle);
        while model.coarsen() {
            entries.push(model.entries().to_vec());
            draws(&model, &oracle);
        }
        entries.reverse();
        assert_eq!((model.level(), entries.len()), (0, oracle.len()));
        while model.refine() {
            assert_eq!(model.entries(), entries[model.level()]);
        }
        assert_eq!(model.level(), sequence.len());
        let middle = data.len() % oracle.len();
        model.go_to(middle);
        assert_eq!(model.entries(), entries[middle]);
    }

    let mut mesh = ProgressiveMesh::new(&sequence).expect("few triangles");
    mesh.go_to(0);
    loop {
        assert_eq!(sorted(triangles_of(mesh.corners())), oracle[mesh.level()]);
        if !mesh.refine() {
            break;
        }
    }
    assert_eq!(mesh.level(), sequence.len());
});

/// Compares the map of a model's level, and its display strips by every filter, with the oracle.
fn draws(model: &ProgressiveStrips, oracle: &[Vec<[u32; 3]>]) {
    let (mut map, expected) = (Vec::new(), &oracle[model.level()]);
    model.decode_to(&mut map);
    assert_eq!(&sorted(map.split(|&v| v == RESTART).flat_map(strip_triangles)), expected);
    for filter in Filter::ALL {
        let mut display = Strips::default();
        filter.map_to(&map, &mut display);
        assert_eq!(&sorted(display.triangles()), expected, "{filter:?} at level {}", model.level());
        let sent = filter.sent_by_map(&map);
        assert_eq!((sent.vertices, sent.strips), (display.vertices_sent(), display.len()), "{filter:?}");
    }
}
