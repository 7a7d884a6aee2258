//! Any bytes, read as a mesh and options: every method gives a cover that holds, strips that are proven, and layouts that draw
//! the same triangles; none is below a lower bound.
#![no_main]

use tristrip::strip::{Cost, Metrics, strip_triangles};
use tristrip::verify::verify;
use tristrip::vertex_cache::VertexCache;
use tristrip::stripify::bound::Bound;
use tristrip::stripify::{Effort, EtaOptions, Objective, Start, plan};
use tristrip::{DualGraph, Error, FaceTriangulation, Faces, Mesh, Method, Patches, PreparedFaces, StripifyOptions, Strips, Ties};

const RESTART: u32 = u32::MAX;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let mut bytes = Bytes(data);
    let (weld, seed) = (bytes.next().is_multiple_of(2), bytes.word().into());
    let cutoff = bytes.next().into();
    let mesh = mesh(&mut bytes);
    let surface = PreparedFaces::new(&mesh, weld);
    let graph = DualGraph::new(surface.faces());
    assert_eq!(graph.check(), Ok(()));
    // Welded vertices have the same bits, so that strips over them are held to the faces with the same names for them.
    let asked = Mesh::new(mesh.shared_positions(), surface.faces().clone()).expect("indices in range");
    let bound = Bound::of_surface(&surface, &graph);
    let cost = [Cost::Restart, Cost::OpenGl, Cost::Degenerate, Cost::Gl][cutoff as usize % 4];
    for method in methods(cutoff) {
        let level = if method == Method::Cache { 5 } else { u8::from(method == Method::Best) };
        let effort = Effort::new(level).expect("a level");
        let options = StripifyOptions::default().with_method(method).with_weld(weld).with_seed(seed);
        let buffer = if cutoff.is_multiple_of(2) { VertexCache::fifo(cutoff) } else { VertexCache::lru(cutoff) };
        let prefer = [Objective::Indices, Objective::Balanced, Objective::Misses][cutoff as usize % 3];
        let options = options.with_cost(cost).with_effort(effort).with_vertex_cache(buffer).with_objective(prefer);
        let plan = match plan(&surface, &graph, &options) {
            Ok(plan) => plan,
            Err(Error::Parameter { .. }) => continue,
            Err(error) => panic!("{method:?}: {error}"),
        };
        let triangles = plan.triangulation.graph();
        assert_eq!(triangles.check(), Ok(()), "{method:?}");
        assert_eq!(plan.cover.check(triangles), Ok(()), "{method:?}");
        let strips = plan.strips();
        let metrics = Metrics::of(&strips);
        assert_eq!(plan.indices_restart(), metrics.indices_restart, "{method:?}");
        assert!(bound.strips <= metrics.strips, "{method:?}: {} < {}", metrics.strips, bound.strips);
        for cost in [Cost::Restart, Cost::OpenGl, Cost::Degenerate, Cost::Gl] {
            assert!(bound.of(cost) <= cost.of(&metrics), "{method:?}: {cost:?} below its bound");
        }
        verify(&asked, &strips).unwrap_or_else(|why| panic!("{method:?}: {why}"));
        if !weld {
            verify(&mesh, &strips).unwrap_or_else(|why| panic!("{method:?}: {why}"));
        }
        layouts_agree(&strips);
    }
});

/// Triangles from their lowest vertex on, sorted.
fn sorted(triangles: impl Iterator<Item = [u32; 3]>) -> Vec<[u32; 3]> {
    let canonical_triangle = |mut t: [u32; 3]| {
        let lowest = (0..3).min_by_key(|&i| t[i]).unwrap_or(0);
        t.rotate_left(lowest);
        t
    };
    let mut all: Vec<_> = triangles.map(canonical_triangle).collect();
    all.sort_unstable();
    all
}

/// Holds every layout to the triangles that the strips draw, in their order; strips that are joined come in another.
fn layouts_agree(strips: &Strips) {
    let drawn: Vec<[u32; 3]> = strips.triangles().collect();
    let restart = strips.to_restart(RESTART);
    let parts = restart.split(|&v| v == RESTART);
    assert_eq!(parts.flat_map(strip_triangles).collect::<Vec<_>>(), drawn);
    let degenerate = strips.to_degenerate();
    assert_eq!(sorted(strip_triangles(&degenerate)), sorted(drawn.iter().copied()));
    assert_eq!(strips.to_list(), drawn.as_flattened());
    let metrics = Metrics::of(strips);
    assert_eq!((metrics.triangles, metrics.indices_restart), (drawn.len(), restart.len()));
    assert_eq!(metrics.indices_degenerate, degenerate.len());
}

/// Every method, with every choice that it has.
fn methods(cutoff: u32) -> Vec<Method> {
    let mut all = vec![Method::Auto, Method::Sequential, Method::Input, Method::Sgi, Method::STRIPE];
    all.extend([Method::Best, Method::Fewest, Method::Cache, Method::Tunnel { length: 5 }]);
    all.extend(
        [Start::Isolated, Start::Sgi, Start::Sequential]
            .map(|start| Method::Eta(EtaOptions::default().with_start(start).with_length(2 * cutoff + 1))),
    );
    for triangulation in [FaceTriangulation::Static, FaceTriangulation::Whole, FaceTriangulation::Partial] {
        for ties in [Ties::Arbitrary, Ties::LookAhead, Ties::Alternate, Ties::Random, Ties::Sequential] {
            all.push(Method::StripeLocal { triangulation, ties });
        }
    }
    for patches in [Patches::Rows, Patches::Full] {
        for cutoff in [1, cutoff] {
            all.push(Method::StripeGlobal { patches, cutoff });
        }
    }
    all
}

/// Reads a mesh: positions first, of a few manners, then polygons until the bytes end.
fn mesh(bytes: &mut Bytes) -> Mesh {
    let vertex_count = match bytes.next() {
        small @ 0..=199 => u32::from(small) % 40 + 1,
        large => u32::from(large) * 4 + u32::from(bytes.next()),
    };
    let manner = bytes.next();
    let positions: Vec<[f32; 3]> = (0..vertex_count).map(|v| position(v, manner, bytes)).collect();
    let mut polygons: Vec<Vec<u32>> = Vec::new();
    let mut corners = 0;
    while !bytes.0.is_empty() && corners < 600 {
        let polygon = polygon(vertex_count, &polygons, bytes);
        corners += polygon.len();
        polygons.push(polygon);
    }
    let faces = Faces::from_polygons(polygons).expect("few corners");
    Mesh::new(positions, faces).expect("indices in range")
}

fn position(v: u32, manner: u8, bytes: &mut Bytes) -> [f32; 3] {
    let (x, y) = ((v % 8) as f32, (v / 8) as f32);
    let finite = |bits: u32| Some(f32::from_bits(bits)).filter(|x| x.is_finite()).unwrap_or(0.0);
    match manner % 6 {
        0 => [x, y, 0.0],
        1 => [(v as f32).cos(), (v as f32).sin(), 0.0],
        2 => [0.0; 3],
        3 => [0; 3].map(|_| f32::from(bytes.next() as i8)),
        4 => [0; 3].map(|_| finite(bytes.word())),
        _ => [
            x / 8.0 * f32::MAX,
            -y * f32::MIN_POSITIVE,
            if v.is_multiple_of(2) { f32::MAX } else { f32::MIN },
        ],
    }
}

/// Reads a polygon of any size: corner by corner, as a run of vertices, or as an earlier polygon turned or reversed.
fn polygon(vertex_count: u32, earlier: &[Vec<u32>], bytes: &mut Bytes) -> Vec<u32> {
    let size = bytes.next();
    match size {
        0..=99 => (0..size / 10).map(|_| u32::from(bytes.next()) % vertex_count).collect(),
        100..=179 => (0..3 + size % 2).map(|_| u32::from(bytes.next()) % vertex_count).collect(),
        180..=219 => {
            // A square of a grid of eight columns, so that patches arise.
            let v = u32::from(bytes.next());
            let square = [v, v + 1, v + 9, v + 8].map(|v| v % vertex_count);
            if size < 210 { square.to_vec() } else { square.into_iter().rev().collect() }
        }
        220..=239 => {
            let [first, step, count] = [0; 3].map(|_| u32::from(bytes.next()));
            (0..count).map(|i| (first + i * step) % vertex_count).collect()
        }
        _ => {
            let mut copy = match earlier.len() {
                0 => Vec::new(),
                n => earlier[usize::from(bytes.next()) % n].clone(),
            };
            if size.is_multiple_of(2) {
                copy.reverse();
            }
            let turn = usize::from(size) % copy.len().max(1);
            copy.rotate_left(turn);
            copy
        }
    }
}

/// The bytes that are left; zeros when there are none.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn next(&mut self) -> u8 {
        let Some((&first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        first
    }

    fn word(&mut self) -> u32 {
        u32::from_le_bytes([0; 4].map(|_| self.next()))
    }
}
