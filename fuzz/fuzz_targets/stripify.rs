//! Builds a mesh and options from arbitrary bytes. Every method returns a valid cover, verified
//! strips, and layouts that draw the same triangles. No cost is below its lower bound.
#![no_main]

use tristrip::Effort;
use tristrip::stripify::bound::Bound;
use tristrip::stripify::{Acceptance, Localization, Objective, Start, TunnelOptions, plan};
use tristrip::stripify::{FaceTriangulation, LastTie, Patches, Ties};
use tristrip::verify::verify;
use tristrip::vertex_cache::VertexCache;
use tristrip::{Cost, Metrics, strip_triangles};
use tristrip::{DualGraph, Error, Method, PreparedFaces, StripifyOptions, Strips};
use tristrip_fuzz::{Bytes, mesh, sorted};

const RESTART: u32 = u32::MAX;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let mut bytes = Bytes(data);
    let (weld, seed) = (bytes.next().is_multiple_of(2), bytes.word().into());
    let cutoff = bytes.next().into();
    let mesh = mesh(&mut bytes);
    let surface = PreparedFaces::new(&mesh, weld);
    let graph = DualGraph::new(surface.faces());
    assert_eq!(graph.check(), Ok(()));
    let bound = Bound::of_prepared(&surface, &graph).unwrap();
    let cost = [Cost::Restart, Cost::OpenGl, Cost::Degenerate, Cost::Gl][cutoff as usize % 4];
    for method in methods(cutoff) {
        let level = if method == Method::Cache { 5 } else { u8::from(method == Method::Best) };
        let effort = Effort::new(level).expect("effort 0 to 9");
        let options = StripifyOptions::default().with_method(method).with_weld(weld).with_seed(seed);
        let buffer =
            if cutoff.is_multiple_of(2) { VertexCache::fifo(cutoff) } else { VertexCache::lru(cutoff) };
        let prefer = [Objective::Indices, Objective::Balanced, Objective::Misses][cutoff as usize % 3];
        let options =
            options.with_cost(cost).with_effort(effort).with_vertex_cache(buffer).with_objective(prefer);
        let plan = match plan(&surface, &graph, &options) {
            Ok(plan) => plan,
            Err(Error::Parameter { .. }) => continue,
            Err(error) => panic!("{method:?}: {error}"),
        };
        let triangles = plan.triangulation().graph();
        assert_eq!(triangles.check(), Ok(()), "{method:?}");
        assert_eq!(plan.cover().check(triangles), Ok(()), "{method:?}");
        let strips = plan.strips();
        let metrics = Metrics::of(&strips);
        assert_eq!(plan.indices_restart(), metrics.indices_restart, "{method:?}");
        assert!(bound.strips <= metrics.strips, "{method:?}: {} < {}", metrics.strips, bound.strips);
        for cost in [Cost::Restart, Cost::OpenGl, Cost::Degenerate, Cost::Gl] {
            assert!(bound.of(cost) <= cost.of(&metrics), "{method:?}: {cost:?} below its bound");
        }
        verify(&mesh, &strips).unwrap_or_else(|why| panic!("{method:?}: {why}"));
        layouts_agree(&strips);
    }
});

/// Compares the triangles of every layout with those of the strips. Joined strips may be in another
/// order.
fn layouts_agree(strips: &Strips) {
    let drawn: Vec<[u32; 3]> = strips.triangles().collect();
    let restart = strips.to_restart(RESTART);
    let split = restart.split(|&v| v == RESTART);
    assert_eq!(split.flat_map(strip_triangles).collect::<Vec<_>>(), drawn);
    let degenerate = strips.to_degenerate();
    assert_eq!(sorted(strip_triangles(&degenerate)), sorted(drawn.iter().copied()));
    assert_eq!(strips.to_list(), drawn.as_flattened());
    let metrics = Metrics::of(strips);
    assert_eq!((metrics.triangles, metrics.indices_restart), (drawn.len(), restart.len()));
    assert_eq!(metrics.indices_degenerate, degenerate.len());
}

/// Returns every method with all its variants.
fn methods(cutoff: u32) -> Vec<Method> {
    let mut all = vec![Method::Best, Method::Sequential, Method::Input, Method::STRIPE];
    all.extend(LastTie::ALL.map(|last_tie| Method::Sgi { last_tie }));
    all.extend([Method::QuadRows { cutoff }, Method::Fewest, Method::Cache, Method::Tunnel { length: 5 }]);
    all.extend([Start::Isolated, Start::Sgi, Start::Sequential].map(|start| {
        Method::GuidedTunnels(TunnelOptions::default().with_start(start).with_length(2 * cutoff + 1))
    }));
    for acceptance in Acceptance::ALL {
        let tunnels = TunnelOptions::ETA.with_length(2 * cutoff + 1);
        all.extend(Localization::ALL.map(|localization| Method::Eta { tunnels, acceptance, localization }));
    }
    for triangulation in FaceTriangulation::ALL {
        for ties in Ties::ALL {
            all.push(Method::StripeLocal { triangulation, ties });
        }
    }
    for patches in Patches::ALL {
        for ties in Ties::ALL {
            all.extend([1, cutoff].map(|cutoff| Method::StripeGlobal { patches, cutoff, ties }));
        }
    }
    all
}
