//! Levels of detail over the strips of STRIPE, with a base mesh of 5 % of the triangles. Measures
//! filters in entries per second over 21 levels, vertex splits per second from the base mesh to the
//! full mesh, and the traffic of all levels. The triangles of each level are first compared with
//! the oracle.
#![allow(
    missing_docs,
    clippy::expect_used,
    reason = "criterion's macros; a benchmark that cannot be set up panics"
)]

use std::hint::black_box;
use std::sync::Arc;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use tristrip::lod::Filter;
use tristrip::lod::LevelCursor;
use tristrip::lod::{Encoding, ProgressiveStrips, ProgressiveStripsCursor};
use tristrip::simplify::{self, simplify_triangles};
use tristrip::verify::verify_drawing;
use tristrip::{CollapseSequence, Faces, Method, StripifyOptions, Strips, stripify};
use tristrip_bench::models::{default_folder, find, load};
use tristrip_lab::traffic;

/// Measured if they are in the model directory.
const MODELS: [&str; 3] = ["cow", "hand", "bunny"];

const LEVELS: usize = 20;

/// Returns the decoded index maps of levels over the whole sequence. Checks first that every filter
/// draws the same triangles as the oracle.
fn proven_maps(strips: &Strips, sequence: &CollapseSequence) -> Vec<Vec<u32>> {
    let model = ProgressiveStrips::new(strips, sequence, Encoding::Offsets).expect("a model of strips");
    let mut cursor = Arc::new(model).cursor();
    let map_of = |step: usize| {
        cursor.set_level(sequence.len() * step / LEVELS).expect("a level");
        let drawn = Faces::from_triangles(sequence.drawn(cursor.level()).expect("a level").concat())
            .expect("triangles");
        let (mut map, mut display) = (Vec::new(), Strips::default());
        cursor.decode_to(&mut map);
        for filter in Filter::ALL {
            display.clear();
            filter.map_to(&map, &mut display);
            let triangles: Vec<_> = display.triangles().collect();
            assert!(verify_drawing(&drawn, &triangles).is_ok());
        }
        map
    };
    (0..=LEVELS).map(map_of).collect()
}

fn levels(criterion: &mut Criterion) {
    let sources = find(&default_folder()).expect("a folder of models");
    for source in sources.iter().filter(|source| MODELS.contains(&source.name.as_str())) {
        let fed = load(source).expect("a readable model");
        let mesh = fed.polygons.unwrap_or(fed.triangles);
        let options = StripifyOptions::default().with_method(Method::STRIPE);
        let strips = stripify(&mesh, &options).expect("valid options");
        let list = strips.to_list();
        let goal = simplify::SimplifyOptions::default().with_triangles(list.len() / 60);
        let sequence =
            simplify_triangles(&mesh, list, &goal).expect("a mesh that can be simplified").sequence;
        let maps = proven_maps(&strips, &sequence);

        let mut group = criterion.benchmark_group(format!("{}, filters", source.name));
        let entries: usize = maps.iter().map(Vec::len).sum();
        group.throughput(Throughput::Elements(entries as u64)).sample_size(20);
        let mut display = Strips::default();
        for filter in Filter::ALL {
            group.bench_function(format!("{filter:?}"), |b| {
                b.iter(|| {
                    for map in &maps {
                        display.clear();
                        filter.map_to(black_box(map), &mut display);
                    }
                });
            });
            group.bench_function(format!("{filter:?}, counted"), |b| {
                b.iter(|| maps.iter().map(|map| filter.sent_by_map(black_box(map)).vertices).sum::<usize>());
            });
        }
        group.finish();

        let mut group = criterion.benchmark_group(format!("{}, splits", source.name));
        group.throughput(Throughput::Elements(sequence.len() as u64)).sample_size(20);
        for encoding in [Encoding::Naive, Encoding::Offsets] {
            let model = ProgressiveStrips::new(&strips, &sequence, encoding).expect("a model of strips");
            let mut base = Arc::new(model).cursor();
            base.set_level(0).expect("the base mesh");
            group.bench_function(format!("{encoding:?}"), |b| {
                let refine = |mut cursor: ProgressiveStripsCursor| {
                    while cursor.refine() {}
                    cursor
                };
                b.iter_batched(|| base.clone(), refine, BatchSize::LargeInput);
            });
        }
        group.bench_function("traffic of all levels", |b| {
            b.iter(|| traffic::walk(&strips, &sequence, |_| ()).expect("a model of strips"));
        });
        group.finish();
    }
}

criterion_group!(benches, levels);
criterion_main!(benches);
