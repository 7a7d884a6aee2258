use super::*;
use crate::collapse::CollapseSequence;
use crate::lod::RepairOptions;
use crate::mesh::{Faces, Mesh};
use crate::simplify::simplify;
use crate::strip::Strips;
use crate::stripify::{Acceptance, Localization, Method, StripifyOptions, TunnelOptions, stripify};
use serde::de::DeserializeOwned;

fn round_trip<T: Serialize + DeserializeOwned + PartialEq + std::fmt::Debug>(value: &T) -> String {
    let json = serde_json::to_string(value).unwrap();
    assert_eq!(serde_json::from_str::<T>(&json).unwrap(), *value, "{json}");
    json
}

fn refuses<T: DeserializeOwned + std::fmt::Debug>(json: &str, why: &str) {
    let error = serde_json::from_str::<T>(json).unwrap_err().to_string();
    assert!(error.contains(why), "{json}: {error}");
}

#[test]
fn options_have_the_names_of_the_command() {
    for method in Method::ALL {
        assert_eq!(round_trip(method), format!("\"{method}\""));
    }
    let tunnels = TunnelOptions::default().with_threshold(7).with_start(Start::Sgi);
    assert_eq!(round_trip(&Method::GuidedTunnels(tunnels)), r#""guided-tunnels threshold=7 start=sgi""#);
    let eta = Method::Eta {
        tunnels: TunnelOptions::ETA.with_length(9),
        acceptance: Acceptance::BreadthFirst,
        localization: Localization::None,
    };
    assert_eq!(round_trip(&eta), r#""eta length=9 acceptance=breadth-first localization=none""#);
    assert_eq!(round_trip(&Method::Tunnel { length: 5 }), r#""tunnel length=5""#);
    let global = Method::StripeGlobal { patches: Patches::Full, cutoff: 0, ties: Ties::Random };
    assert_eq!(round_trip(&global), r#""stripe-global patches=full cutoff=0 ties=random""#);
    assert_eq!(round_trip(&Method::QuadRows { cutoff: 9 }), r#""quad-rows cutoff=9""#);
    assert_eq!(round_trip(&Method::Sgi { last_tie: LastTie::First }), r#""sgi last-tie=first""#);
    let local = Method::StripeLocal { triangulation: FaceTriangulation::Partial, ties: Ties::LookAhead };
    assert_eq!(round_trip(&local), r#""stripe-local triangulation=partial ties=look-ahead""#);
    assert_eq!(round_trip(&Layout::Separate), r#""separate""#);
    assert_eq!(round_trip(&VertexCache::lru(24)), r#""lru:24""#);
    assert!(serde_json::to_string(&VertexCache::fifo(0)).is_err());
    let options = StripifyOptions::default().with_method(local).with_weld(true).with_seed(u64::MAX);
    let options = options.with_cost(Cost::Gl).with_objective(Objective::Misses).with_effort(Effort::MAX);
    assert!(round_trip(&options).contains(r#""effort":9"#));
    assert!(round_trip(&StripifyOptions::default()).contains(r#""effort":null"#));
    let usual = StripifyOptions::default().effort_or_default();
    assert!(round_trip(&StripifyOptions::default().with_effort(usual)).contains(r#""effort":2"#));
    round_trip(&RepairOptions::default().with_seed(3).with_cost(Cost::Restart));
    round_trip(&SimplifyOptions::default().with_triangles(7).with_error(0.5).with_locked(vec![true, false]));
    round_trip(
        &SimplifyOptions::default()
            .with_locked_borders(true)
            .with_vanishing(vec![0.5, f32::INFINITY])
            .with_permissive(true)
            .with_weights(AttributeWeights { uv: 0.5, ..AttributeWeights::NONE })
            .with_price(Price::Planes)
            .with_weld_distance(0.25),
    );
    round_trip(&SimplifyOptions::default().with_price(Price::Quadric));
    assert_eq!(serde_json::from_str::<StripifyOptions>("{}").unwrap(), StripifyOptions::default());
}

#[test]
fn wrong_options_are_refused() {
    refuses::<Method>(r#""tunnel length=-1""#, "a parameter of tunnel");
    refuses::<Method>(r#""best length=1""#, "a parameter of best");
    refuses::<Method>(r#""""#, "method");
    refuses::<Effort>("10", "found 10, expected 0 to 9");
    refuses::<VertexCache>(r#""fifo:0""#, "N from 1");
    refuses::<StripifyOptions>(r#"{"methods":"best"}"#, "unknown field");
    refuses::<RepairOptions>(r#"{"cost":"cheap"}"#, "cost");
    refuses::<SimplifyOptions>(r#"{"error":-1.0}"#, "0 or more");
    refuses::<SimplifyOptions>(r#"{"weld_distance":-1.0}"#, "at least 0");
}

#[test]
fn strips_and_collapses_come_back() {
    let at = |i: u32| [(i % 5) as f32, (i / 5) as f32, 0.0];
    let quads = (0..16).map(|i| i / 4 * 5 + i % 4).map(|i| [i, i + 1, i + 6, i + 5]);
    let faces = Faces::from_polygons(quads).unwrap();
    // The two halves share no vertices until they are welded.
    let positions: Vec<_> = (0..50).map(|i| at(i % 25)).collect();
    let corners = faces.corners().iter().enumerate().map(|(i, &v)| if i < 32 { v } else { v + 25 });
    let mesh = Mesh::new(positions, faces.with_corners(corners.collect()).unwrap()).unwrap();
    let strips = stripify(&mesh, &StripifyOptions::default().with_weld(true)).unwrap();
    assert!(!strips.welds().is_empty());
    round_trip(&strips);
    round_trip(&strips.with_kept_order());
    round_trip(&Strips::default());
    let sequence = simplify(&mesh, &SimplifyOptions::default()).unwrap().simplification.sequence;
    assert!(!sequence.is_empty());
    round_trip(&sequence);
    round_trip(&CollapseSequence::default());
}

#[test]
fn wrong_strips_and_collapses_are_refused() {
    let strips = |ends: &str, welds: &str| {
        format!(r#"{{"vertices":[0,1,2],"ends":{ends},"keeps_order":false,"welds":{welds}}}"#)
    };
    assert!(serde_json::from_str::<Strips>(&strips("[3]", "[[4,1]]")).is_ok());
    for ends in ["[2]", "[4]", "[3,2]", "[]"] {
        refuses::<Strips>(&strips(ends, "[]"), "the last of ends that do not decrease");
    }
    for welds in ["[[1,1]]", "[[2,1],[1,0]]", "[[1,0],[2,1]]", "[[1,0],[1,2]]"] {
        refuses::<Strips>(&strips("[3]", welds), "welds");
    }
    let sequence = |count: &str, renames: &str, ends: &str, errors: &str| {
        let rest = format!(r#""renames":{renames},"rename_ends":{ends},"errors":{errors}"#);
        format!(r#"{{"vertex_count":{count},"triangles":[0,1,2,2,1,3],{rest}}}"#)
    };
    assert!(serde_json::from_str::<CollapseSequence>(&sequence("4", "[[3,2]]", "[1]", "[0.5]")).is_ok());
    let wrong = [
        (sequence("3", "[[3,2]]", "[1]", "[0.5]"), "found vertex index 3"),
        (sequence("4", "[[3,2]]", "[2]", "[0.5]"), "1 end up to 2"),
        (sequence("4", "[[3,2]]", "[1]", "[]"), "0 errors"),
        (sequence("4", "[[3,2],[2,0]]", "[2,1]", "[0.5,1]"), "2 ends up to 1"),
        (sequence("4", "[[3,3]]", "[1]", "[0.5]"), "3 renamed to 3"),
        (sequence("4", "[[3,4294967295]]", "[1]", "[0.5]"), "3 renamed to 4294967295"),
        (sequence("4", "[[3,2]]", "[1]", "[-0.5]"), "0 or more"),
        (sequence("4294967295", "[]", "[]", "[]"), "limit"),
    ];
    wrong.iter().for_each(|(json, why)| refuses::<CollapseSequence>(json, why));
}
