//! Level-of-detail chains. Each level equals a simplification to its size, and every file draws it
//! from a prefix of the vertices.

#![expect(clippy::unwrap_used, reason = "a test that panics fails")]

use std::path::Path;

use tristrip::{Layout, Method, StripifyOptions};
use tristrip_io::{Format, Model, read, read_path};
use tristrip_pipeline::{Amount, Deviation, Error, Goal, chain, encode, simplify, simplify::Normals, verify};

fn model(name: &str) -> Model {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/models");
    read_path(folder.join(name)).unwrap()
}

fn options(format: Format) -> chain::Options {
    chain::Options::new("100%,50%,25%,10%".parse().unwrap(), format)
}

/// Reads the parts of a GLB that draw a level.
fn parts_of_level(again: &Model, meshes: &[usize]) -> usize {
    let mesh_of_parts = again.scene.as_ref().unwrap().mesh_of_parts();
    let parts = again.parts.iter().zip(mesh_of_parts).filter(|(_, mesh)| meshes.contains(mesh));
    parts.map(|(part, _)| part.mesh.faces().triangle_count()).sum()
}

#[test]
fn each_level_is_the_simplification_to_its_size() {
    for name in ["hand.ply", "milktruck.glb", "self_intersect_a.ply"] {
        let source = model(name);
        let any = options(Format::Ply).with_deviation(Deviation::Percent(100.0));
        let all = chain::run(&source, &any, &()).unwrap();
        for (level, figures) in all.levels.iter().enumerate() {
            let goal =
                Goal { amount: Some(Amount::Ratio(figures.ratio)), deviation: Deviation::Percent(100.0) };
            // The levels share their vertices, so normals are kept.
            let kept = simplify::Options::default().with_goal(goal).with_normals(Normals::Keep);
            let simplified = simplify::run(&source, &kept, &()).unwrap();
            assert_eq!(figures.triangles, simplified.collapses.triangles_after, "{name}, level {level}");
            assert_eq!(figures.vertices, simplified.redrawn.used, "{name}, level {level}");
            assert_eq!(figures.reached, simplified.collapses.reached, "{name}, level {level}");
            let error = simplified.collapses.surface_error;
            assert!((figures.surface_error - error).abs() <= 1e-6 * error, "{name}, level {level}");
            let file =
                all.chain.encode_level(&source, level, &encode::Options::new(Format::Ply), &()).unwrap();
            let again = read(&file.bytes, Format::Ply).unwrap();
            assert!(
                verify::run(&simplified.redrawn.model, &again, &()).unwrap().proven,
                "{name}, level {level}"
            );
        }
    }
}

#[test]
fn the_vertices_of_a_level_are_the_first_of_the_finest() {
    let source = model("hand.ply");
    let all = chain::run(&source, &options(Format::Ply), &()).unwrap();
    let positions = |level: usize| {
        let file = all.chain.encode_level(&source, level, &encode::Options::new(Format::Ply), &()).unwrap();
        let again = read(&file.bytes, Format::Ply).unwrap();
        again.parts[0].mesh.positions().iter().map(|p| p.map(f32::to_bits)).collect::<Vec<_>>()
    };
    let finest = positions(0);
    for (level, figures) in all.levels.iter().enumerate().skip(1) {
        let coarser = positions(level);
        assert_eq!(coarser.len(), figures.vertices);
        assert!(finest.starts_with(&coarser), "level {level}");
    }
}

fn check_figures(chain: &chain::Outcome) {
    assert!(chain.levels.is_sorted_by(|a, b| a.triangles >= b.triangles && a.vertices >= b.vertices));
    assert!(chain.levels.is_sorted_by(|a, b| a.surface_error <= b.surface_error));
    assert!(chain.levels.is_sorted_by(|a, b| a.screen_coverage > b.screen_coverage));
    let first = &chain.levels[0];
    assert_eq!(
        (first.triangles, first.surface_error.to_bits(), first.reached),
        (first.target_triangles, 0, true)
    );
}

#[test]
fn one_scene_holds_all_levels_over_no_more_vertices_than_the_source() {
    let source = model("milktruck.glb");
    let all = chain::run(&source, &options(Format::Glb), &()).unwrap();
    check_figures(&all);
    let vertices: usize = source.parts.iter().map(|part| part.mesh.vertex_count()).sum();
    assert!(all.levels[0].vertices <= vertices);
    for layout in Layout::ALL {
        let file =
            all.chain.encode(&source, &encode::Options::new(Format::Glb).with_layout(layout), &()).unwrap();
        let triangles = all.levels.iter().map(|level| level.triangles).sum::<usize>();
        assert_eq!(file.encoded.faces, Some(triangles), "{layout:?}");
        // The error limit stops the two coarsest levels at the same collapse.
        let triangles: Vec<usize> = all.levels.iter().map(|level| level.triangles).collect();
        for (bytes, triangles) in file.level_bytes.windows(2).zip(triangles.windows(2)) {
            assert_eq!(bytes[0] > bytes[1], triangles[0] > triangles[1], "{:?}", file.level_bytes);
        }
        let again = read(&file.encoded.bytes, Format::Glb).unwrap();
        assert_eq!(parts_of_level(&again, &[0, 1]), all.levels[0].triangles);
    }
}

#[test]
fn a_level_beyond_the_error_limit_is_not_reached() {
    let source = model("hand.ply");
    let tight = options(Format::Glb).with_deviation(Deviation::Percent(0.05));
    let all = chain::run(&source, &tight, &()).unwrap();
    check_figures(&all);
    let reached: Vec<bool> = all.levels.iter().map(|level| level.reached).collect();
    assert!(reached.is_sorted_by(|a, b| a >= b) && !reached[3], "{reached:?}");
    assert!(all.levels.iter().all(|level| level.surface_error_percent <= 0.05));
    let warning = all.warning.as_deref().unwrap();
    assert!(warning.contains("not reached: ") && warning.contains("error limit of 0.05 %"), "{warning}");
    // Equal levels share their mesh.
    let file = all.chain.encode(&source, &encode::Options::new(Format::Glb), &()).unwrap();
    assert!(read(&file.encoded.bytes, Format::Glb).unwrap().parts.len() <= 4);
    let any =
        chain::run(&source, &options(Format::Glb).with_deviation(Deviation::Percent(100.0)), &()).unwrap();
    assert_eq!((any.warning, any.levels.iter().all(|level| level.reached)), (None, true));
}

#[test]
fn lists_are_in_the_order_of_a_vertex_cache() {
    let source = model("hand.ply");
    let cached = StripifyOptions::default().with_method(Method::Cache);
    let misses = |chain: &chain::Outcome| {
        let list = encode::Options::new(Format::Glb).with_layout(Layout::List);
        let file = chain.chain.encode(&source, &list, &()).unwrap();
        let again = read(&file.encoded.bytes, Format::Glb).unwrap();
        let lists = again.parts.iter().map(|part| part.mesh.faces().as_triangles().unwrap().to_vec());
        let fifo = tristrip::vertex_cache::VertexCache::fifo(16);
        lists
            .map(|list| {
                tristrip::vertex_cache::VertexCacheStatistics::of_list(list.as_chunks().0, fifo).misses
            })
            .sum::<usize>()
    };
    let by_cache = misses(&chain::run(&source, &options(Format::Glb).with_stripify(cached), &()).unwrap());
    let input = StripifyOptions::default().with_method(Method::Input);
    let by_input = misses(&chain::run(&source, &options(Format::Glb).with_stripify(input), &()).unwrap());
    assert!(by_cache * 10 < by_input * 9, "{by_cache}, {by_input}");
}

#[test]
fn the_bytes_do_not_depend_on_the_threads() {
    let source = model("milktruck.glb");
    let bytes = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let all = chain::run(&source, &options(Format::Glb), &()).unwrap();
            all.chain.encode(&source, &encode::Options::new(Format::Glb), &()).unwrap().encoded.bytes
        })
    };
    assert_eq!(bytes(1), bytes(3));
}

#[test]
fn a_chain_is_written_in_its_format() {
    let source = model("fish_control.ply");
    let all = chain::run(&source, &options(Format::Ply), &()).unwrap();
    assert!(
        all.chain.encode(&source, &encode::Options::new(Format::Ply), &()).is_err(),
        "one level per file"
    );
    assert!(all.chain.encode(&source, &encode::Options::new(Format::Glb), &()).is_err(), "numbered for PLY");
    assert!(matches!(
        all.chain.encode_level(&source, 4, &encode::Options::new(Format::Ply), &()),
        Err(Error::Level { found: 4, last: 3 })
    ));
}

/// A chain of another model must not be proven to draw this one.
#[test]
fn a_level_of_another_model_is_refused() {
    let (fish, bishop) = (model("fish_control.ply"), model("catmark_bishop.ply"));
    let all = chain::run(&fish, &options(Format::Glb), &()).unwrap();
    assert!(all.chain.encode(&bishop, &encode::Options::new(Format::Glb), &()).is_err());
    assert!(all.chain.encode_level(&bishop, 0, &encode::Options::new(Format::Glb), &()).is_err());
}
