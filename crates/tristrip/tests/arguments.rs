//! Invalid arguments, per type of the public interface: they give errors or `None`, never a panic. No
//! memory is allocated for counts that only an argument claims.
#![allow(clippy::unwrap_used, reason = "a test")]

use std::sync::Arc;

use tristrip::lod::{
    Encoding, Filter, LevelModel, LevelTable, ProgressiveMesh, ProgressiveStrips, Repair, RepairOptions,
    RepairedStrips, View,
};
use tristrip::stripify::{Acceptance, Localization, Objective, Patches, Start, Ties, TunnelOptions};
use tristrip::verify::{verify, verify_models};
use tristrip::vertex_cache::VertexCache;
use tristrip::{
    CollapseSequence, Cost, Faces, Layout, Mesh, Method, Metrics, Rename, StripifyOptions, Strips,
    VertexOrder, stripify, stripify_indices, stripify_indices_with,
};

const WRONG_LEVELS: [usize; 3] = [2, 1 << 32, usize::MAX];

/// Returns three triangles and a collapse that removes one of them.
fn levels() -> (Strips, CollapseSequence) {
    let mut strips = Strips::default();
    strips.push(&[0, 1, 2, 3, 4]);
    let rename = [Rename { removed: 4, kept: 3 }];
    let sequence = CollapseSequence::from_collapses(5, strips.to_list(), [(&rename[..], 0.5)]).unwrap();
    (strips, sequence)
}

fn grid(size: u32) -> Mesh {
    let at = |i: u32| [(i % (size + 1)) as f32, (i / (size + 1)) as f32, 0.0];
    let quad = |i: u32| [i, i + 1, i + size + 2, i + size + 1];
    let quads = (0..size * size).map(|i| quad(i / size * (size + 1) + i % size));
    let positions: Vec<_> = (0..(size + 1) * (size + 1)).map(at).collect();
    Mesh::new(positions, Faces::from_polygons(quads).unwrap()).unwrap()
}

/// Strips of any vertices, including the empty strip and the highest index.
fn far_strips() -> Strips {
    let mut strips = Strips::default();
    let far =
        [&[][..], &[u32::MAX], &[0, u32::MAX, 7, u32::MAX - 1], &[u32::MAX; 4], &[3, 3, 0, 1, u32::MAX]];
    far.iter().for_each(|strip| strips.push(strip));
    strips
}

#[test]
fn strips() {
    let strips = far_strips();
    let real = strips.triangles().count();
    assert_eq!(Metrics::of(&strips).triangles, real);
    for layout in Layout::ALL {
        assert!(strips.to_indices::<u8>(layout).is_err() && strips.to_indices::<u16>(layout).is_err());
        assert_eq!(strips.to_indices::<u32>(layout).is_err(), layout == Layout::Restart);
        assert!(strips.write_indices::<usize>(layout, &mut []).is_err());
        let back = Strips::from_indices(&strips.to_indices::<usize>(layout).unwrap(), layout).unwrap();
        assert!(layout == Layout::Separate || back.triangles().count() == real, "{layout}");
    }
    assert!(Strips::from_indices(&[usize::MAX], Layout::Separate).is_err());
    for ends in [vec![], vec![2], vec![4, 3], vec![u32::MAX]] {
        assert!(Strips::from_parts(vec![0, 1, 2], ends).is_err());
    }
    assert!(verify(&grid(1), &strips).is_err());
    for filter in Filter::ALL {
        assert!(filter.strips(&strips).triangles().count() <= real + 2, "{filter}");
        filter.map_to(strips.vertices(), &mut Strips::default());
    }
}

#[test]
fn vertex_orders() {
    assert!(VertexOrder::identity(usize::MAX).is_err());
    assert!(VertexOrder::of_strips(7, [&far_strips()]).is_err());
    assert!(VertexOrder::from_new_to_old(&[u32::MAX, 0]).is_err());
    let order = VertexOrder::of_indices(3, [2]).unwrap();
    assert!(order.indices(&[3]).is_err() && order.indices(&[u32::MAX]).is_err());
    assert!(order.strips(&far_strips()).is_err());
    assert!(order.mesh(&grid(3)).is_err() && order.mesh(&Mesh::default()).is_err());
    assert!(order.values(&[0; 7], 2).is_err() && order.values(&[0; 7], usize::MAX).is_err());
    assert_eq!(order.values::<u8>(&[], 0).unwrap(), [0_u8; 0]);
}

#[test]
fn meshes() {
    let faces = || Faces::from_triangles(vec![0, 1, u32::MAX]).unwrap();
    assert!(Mesh::new(vec![[0.0; 3]; 3], faces()).is_err());
    assert!(Mesh::new(vec![[0.0, f32::NAN, 0.0]], Faces::default()).is_err());
    assert!(Mesh::new(vec![[f32::NEG_INFINITY; 3]], Faces::default()).is_err());
    let mesh = grid(2);
    assert!(mesh.with_faces(faces()).is_err());
    assert!(mesh.select_vertices(&[9]).is_err() && mesh.select_vertices(&[u32::MAX]).is_err());
    assert_eq!(mesh.select_vertices(&[]).unwrap().vertex_count(), 0);
    assert!(verify_models(&[&mesh], &[]).unwrap().is_err());
    assert!(verify_models(&[], &[&mesh, &mesh]).unwrap().is_err());
}

#[test]
fn index_buffers() {
    for count in [0, 2, u32::MAX as usize, usize::MAX] {
        let far = [0, 1, u32::MAX - 2, u32::MAX - 2, 1, 7];
        assert_eq!(stripify_indices(&far, count).is_ok(), count > 7, "{count}");
        assert!(stripify_indices(&[0_u32, 1, 2, 3], count).is_err());
        assert!(stripify_indices::<u8>(&[], count).unwrap().is_empty());
    }
    let far = [0, 1, u32::MAX - 2, u32::MAX - 2, 1, 7];
    for method in Method::ALL {
        let options = StripifyOptions::default().with_method(*method);
        let strips = stripify_indices_with(&far, u32::MAX as usize - 1, &options).unwrap();
        assert_eq!(strips.triangles().count(), 2, "{method}");
    }
}

#[test]
fn methods() {
    let mesh = grid(3);
    let tunnels = |length, threshold| TunnelOptions::default().with_length(length).with_threshold(threshold);
    let eta = |tunnels, acceptance, localization| Method::Eta { tunnels, acceptance, localization };
    let all = [0, 1, 2, u32::MAX].into_iter().flat_map(|n| {
        [
            Method::Tunnel { length: n },
            Method::StripeGlobal { patches: Patches::Rows, cutoff: n, ties: Ties::Sequential },
            Method::StripeGlobal { patches: Patches::Full, cutoff: n, ties: Ties::Random },
            Method::QuadRows { cutoff: n },
            Method::GuidedTunnels(tunnels(n, n).with_start(Start::Isolated)),
            Method::GuidedTunnels(tunnels(u32::MAX, n)),
            Method::GuidedTunnels(tunnels(n, u32::MAX)),
            eta(tunnels(n, n).with_start(Start::Isolated), Acceptance::Repeated, Localization::Star),
            eta(tunnels(u32::MAX, n), Acceptance::BreadthFirst, Localization::OnDemand),
            eta(tunnels(n, u32::MAX), Acceptance::DepthFirst, Localization::None),
        ]
    });
    for method in all {
        if let Ok(strips) =
            stripify(&mesh, &StripifyOptions::default().with_method(method).with_seed(u64::MAX))
        {
            assert!(verify(&mesh, &strips).is_ok(), "{method:?}");
        }
    }
    let caches = [0, 1, u32::MAX].into_iter().flat_map(|n| [VertexCache::fifo(n), VertexCache::lru(n)]);
    for cache in caches {
        for objective in Objective::ALL {
            let options = StripifyOptions::default().with_method(Method::Cache).with_cost(Cost::Gl);
            let options = options.with_vertex_cache(cache).with_objective(objective);
            assert!(verify(&mesh, &stripify(&mesh, &options).unwrap()).is_ok(), "{cache} {objective}");
        }
    }
}

#[test]
fn level_models() {
    let (strips, sequence) = levels();
    let repaired = RepairedStrips::new(sequence.clone(), strips.clone(), RepairOptions::default()).unwrap();
    let progressive = |encoding| Arc::new(ProgressiveStrips::new(&strips, &sequence, encoding).unwrap());
    let mesh = Arc::new(ProgressiveMesh::new(&sequence).unwrap());
    let models: [Arc<dyn LevelModel>; 4] =
        [Arc::new(repaired), progressive(Encoding::Naive), progressive(Encoding::Offsets), mesh.clone()];
    for model in models {
        let mut cursor = model.start();
        for level in WRONG_LEVELS {
            assert!(cursor.set_level(level).is_err());
        }
        for error in [f32::NAN, -1.0, f32::NEG_INFINITY] {
            assert!(cursor.set_error(error).is_err());
        }
        assert!(cursor.set_error(f32::INFINITY).is_ok());
        assert!(cursor.set_pixels(f32::NAN, View::parallel(1.0).unwrap()).is_err());
        assert_eq!(cursor.level(), 0);
    }
    for level in WRONG_LEVELS {
        let levels = LevelTable::of(&sequence);
        assert!(levels.triangle_count(level).is_err() && levels.error(level).is_err());
        assert!(Repair::at(sequence.clone(), &strips, level, RepairOptions::default()).is_err());
        assert!(progressive(Encoding::Naive).split(level).is_none() && mesh.splits(level).is_none());
        assert_eq!(progressive(Encoding::Offsets).slot_count(level), 0);
    }
    assert!(Repair::new(sequence.clone(), &far_strips(), RepairOptions::default()).is_err());
    assert!(ProgressiveStrips::new(&far_strips(), &sequence, Encoding::Naive).is_err());
    for wrong in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert!(View::parallel(wrong).is_err() && View::perspective(1.0, wrong, 1.0).is_err());
    }
}
