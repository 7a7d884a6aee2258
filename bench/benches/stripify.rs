//! The stages of `sequential`, on models of the repository: dual graph, plan, strips, proof. Also
//! the plans of the searches on a small model. Each result is proven first.
#![allow(
    missing_docs,
    clippy::expect_used,
    reason = "criterion's macros; a benchmark that cannot be set up panics"
)]

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use tristrip::Cost;
use tristrip::stripify::plan;
use tristrip::verify::verify;
use tristrip::{DualGraph, Mesh, Method, PreparedFaces, StripifyOptions};
use tristrip_bench::methods::NamedMethod;
use tristrip_bench::models::{Source, load};

const MODELS: [&str; 3] = ["wingnut", "self_intersect_a", "hand"];
const SEARCHED: &str = "wingnut";

fn mesh_of(name: &str) -> Mesh {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../testdata/models");
    let source = Source { name: name.into(), path: folder.join(format!("{name}.ply")) };
    load(&source).expect("a model of the repository").triangles
}

fn stages(criterion: &mut Criterion) {
    let options = StripifyOptions::default().with_method(Method::Sequential);
    for name in MODELS {
        let mesh = mesh_of(name);
        let surface = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(surface.faces());
        let chosen = plan(&surface, &graph, &options).expect("valid options");
        let strips = chosen.strips();
        assert_eq!(graph.check(), Ok(()));
        assert_eq!(chosen.cover().check(chosen.triangulation().graph()), Ok(()));
        assert!(verify(&mesh, &strips).is_ok());

        let mut group = criterion.benchmark_group(name);
        group.throughput(Throughput::Elements(mesh.faces().face_count() as u64));
        group.bench_function("dual graph", |b| b.iter(|| DualGraph::new(black_box(surface.faces()))));
        group.bench_function("plan", |b| b.iter(|| plan(black_box(&surface), &graph, &options)));
        group.bench_function("strips", |b| b.iter(|| black_box(&chosen).strips()));
        group.bench_function("proof", |b| b.iter(|| verify(black_box(&mesh), &strips)));
        group.finish();
    }
}

fn searches(criterion: &mut Criterion) {
    let mesh = mesh_of(SEARCHED);
    let surface = PreparedFaces::new(&mesh, false);
    let graph = DualGraph::new(surface.faces());
    let mut group = criterion.benchmark_group(format!("{SEARCHED}, searches"));
    group.throughput(Throughput::Elements(mesh.faces().face_count() as u64)).sample_size(10);
    for (method, effort) in [(Method::Best, 1), (Method::Fewest, 0)] {
        let NamedMethod { name, options } = NamedMethod::search(method, effort, Cost::Restart);
        let chosen = plan(&surface, &graph, &options).expect("valid options");
        assert!(verify(&mesh, &chosen.strips()).is_ok());
        group.bench_function(name, |b| b.iter(|| plan(black_box(&surface), &graph, &options)));
    }
    group.finish();
}

criterion_group!(benches, stages, searches);
criterion_main!(benches);
