//! Simulated vertex caches on the strips of `sequential`, in indices per second: one cache, eight
//! FIFO caches, all LRU sizes in one pass, and the generalized mesh. The misses of all simulators
//! are first compared.
#![allow(
    missing_docs,
    clippy::expect_used,
    reason = "criterion's macros; a benchmark that cannot be set up panics"
)]

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use tristrip::Metrics;
use tristrip::vertex_cache::{
    FlushPolicy, GeneralizedCost, VertexCache, VertexCacheSimulator, VertexCacheStatistics, lru_profile,
};
use tristrip::{Method, StripifyOptions, Strips, stripify};
use tristrip_bench::models::{default_folder, find, load};

/// Measured if they are in the model directory.
const MODELS: [&str; 3] = ["hand", "bunny", "dragon"];

fn misses(strips: &Strips, cache: VertexCache, vertex_count: usize) -> usize {
    let mut queue = VertexCacheSimulator::new(cache, vertex_count).expect("enough memory");
    queue.send_all(black_box(strips.vertices())).expect("vertices of the mesh");
    queue.misses()
}

fn vertex_caches(criterion: &mut Criterion) {
    let sources = find(&default_folder()).expect("a folder of models");
    for source in sources.iter().filter(|source| MODELS.contains(&source.name.as_str())) {
        let mesh = load(source).expect("a readable model").triangles;
        let options = StripifyOptions::default().with_method(Method::Sequential);
        let strips = stripify(&mesh, &options).expect("valid options");
        let count = mesh.vertex_count();
        let eight = [4, 6, 8, 12, 16, 24, 32, 64];
        let fifo = eight.map(VertexCache::fifo);
        let each = VertexCacheStatistics::of_each(&strips, &fifo, FlushPolicy::Keep);
        let profile = lru_profile(&strips, 64, FlushPolicy::Keep).expect("a size");
        for (i, &places) in eight.iter().enumerate() {
            assert_eq!(each[i].misses, misses(&strips, fifo[i], count));
            assert_eq!(profile[places as usize - 1], misses(&strips, VertexCache::lru(places), count));
        }
        let two = GeneralizedCost::of(&strips, VertexCache::fifo(2), FlushPolicy::Flush);
        assert_eq!(two.transmitted, Metrics::of(&strips).gl_cost);

        let mut group = criterion.benchmark_group(format!("{}, vertex caches", source.name));
        group.throughput(Throughput::Elements(strips.vertices_sent() as u64)).sample_size(20);
        for cache in [
            VertexCache::fifo(16),
            VertexCache::fifo(64),
            VertexCache::lru(16),
            VertexCache::lru(64),
            VertexCache::lru(4096),
        ] {
            group.bench_function(cache.to_string(), |b| b.iter(|| misses(&strips, cache, count)));
        }
        let all = |cache| VertexCacheStatistics::of(&strips, cache, FlushPolicy::Keep);
        group.bench_function("fifo:16 with triangles", |b| b.iter(|| all(VertexCache::fifo(16))));
        group.bench_function("8 fifo", |b| {
            b.iter(|| VertexCacheStatistics::of_each(&strips, &fifo, FlushPolicy::Keep))
        });
        for most in [64, 4096] {
            let name = format!("lru:1..{most}");
            group.bench_function(name, |b| b.iter(|| lru_profile(&strips, most, FlushPolicy::Keep)));
        }
        let generalized = || GeneralizedCost::of(&strips, VertexCache::fifo(16), FlushPolicy::Flush);
        group.bench_function("generalized fifo:16", |b| b.iter(generalized));
        group.finish();
    }
}

criterion_group!(benches, vertex_caches);
criterion_main!(benches);
