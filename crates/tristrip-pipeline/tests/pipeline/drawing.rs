//! Files never have more indices than their source: flat-shaded models, stored strips, scenes.

#![expect(clippy::unwrap_used, reason = "a test that panics fails")]

use std::fmt::Write as _;
use std::path::PathBuf;

use tristrip::{Layout, Method, StripifyOptions};
use tristrip_io::{Format, Model, read, read_path};
use tristrip_pipeline::{DrawnAs, analyze, convert, encode, strip, verify};

/// Returns a grid of `n` × `n` squares as OBJ, triangulated. One of `shared` triangles shares its
/// vertices with the next; 0 for none.
fn flat_shaded(n: usize, shared: usize) -> Model {
    let mut text = String::new();
    let mut vertex_count = 0;
    for square in 0..n * n {
        let (x, y) = (square % n, square / n);
        let corners = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)];
        let joined = shared > 0 && square % shared == 0;
        let lists: &[&[usize]] = if joined { &[&[0, 1, 2, 3]] } else { &[&[0, 1, 2], &[0, 2, 3]] };
        for list in lists {
            for &corner in *list {
                let (x, y) = corners[corner];
                writeln!(text, "v {x} {y} {}", (x * 7 + y * 5) % 3).unwrap();
            }
            let first = vertex_count + 1;
            for i in 2..list.len() {
                writeln!(text, "f {first} {} {}", first + i - 1, first + i).unwrap();
            }
            vertex_count += list.len();
        }
    }
    read(text.as_bytes(), Format::Obj).unwrap()
}

/// Strips a model by a method.
fn stripped(model: &Model, method: Method) -> strip::Outcome {
    strip::run(
        model,
        &strip::Options::default().with_stripify(StripifyOptions::default().with_method(method)),
        &(),
    )
    .unwrap()
}

/// Checks that each written file is proven, has the reported number of indices, and has no more
/// indices than its source.
fn check(model: &Model, method: Method) {
    let found = stripped(model, method);
    for format in [Format::Glb, Format::Ply] {
        for reorder in [false, true] {
            let options = encode::Options::new(format).with_reorder(reorder);
            let drawn = found.draw(model, &options);
            // The source may have fewer restarts than a GLB has joins.
            let restarts =
                model.parts.iter().filter_map(|part| Some(part.stored.as_ref()?.restarts)).sum::<usize>();
            if format == Format::Ply || restarts == 0 {
                assert!(drawn.after.indices <= drawn.before.indices, "{drawn:?}");
            }
            let encoded = found.encode(model, &options, &()).unwrap().encoded;
            let again = read(&encoded.bytes, format).unwrap();
            assert!(verify::run(model, &again, &()).unwrap().proven);
            let analysis = analyze::run(&again, &analyze::Options::default(), &()).unwrap();
            // The parts of a PLY are joined, and so are their rows of strips.
            let joins = if format == Format::Ply { model.parts.len() - 1 } else { 0 };
            assert!(analysis.stored.indices.abs_diff(drawn.after.indices) <= joins);
            assert_eq!(analysis.stored.triangles, drawn.after.triangles);
        }
    }
}

#[test]
fn flat_shaded_models_stay_lists() {
    for seed in 0..20 {
        let model = flat_shaded(2 + seed, [0, 0, 5, 3][seed % 4]);
        check(&model, Method::Best);
        let found = stripped(&model, Method::Sequential);
        let drawn = found.draw(&model, &encode::Options::new(Format::Glb));
        assert_eq!(drawn.drawn_as, [DrawnAs::List]);
        assert_eq!(drawn.after, drawn.before, "the faces are written as they are");
        let explicit = encode::Options::new(Format::Glb).with_layout(Layout::Degenerate);
        let strips = found.draw(&model, &explicit);
        assert_eq!(strips.drawn_as, [DrawnAs::Found], "a layout excludes the list");
        assert!(strips.after.indices > strips.before.indices);
    }
}

#[test]
fn quads_of_their_own_stay_polygons_in_a_ply() {
    let mut text = String::new();
    for i in 0..6 {
        for (x, y) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
            writeln!(text, "v {} {y} 0", x + 2 * i).unwrap();
        }
        writeln!(text, "f {} {} {} {}", 4 * i + 1, 4 * i + 2, 4 * i + 3, 4 * i + 4).unwrap();
    }
    let model = read(text.as_bytes(), Format::Obj).unwrap();
    let found = stripped(&model, Method::Best);
    assert_eq!(found.draw(&model, &encode::Options::new(Format::Ply)).after.indices, 24, "corners");
    let encoded = found.encode(&model, &encode::Options::new(Format::Ply), &()).unwrap().encoded;
    let again = read(&encoded.bytes, Format::Ply).unwrap();
    assert_eq!(again.parts[0].mesh.faces().iter().map(<[u32]>::len).collect::<Vec<_>>(), [4; 6]);
}

#[test]
fn stored_strips_win_over_worse_ones() {
    // The faces of a grid in random order. Strips in stored order are short.
    let grid = {
        let mut text = String::new();
        (0..100).for_each(|i| writeln!(text, "v {} {} 0", i % 10, i / 10).unwrap());
        for i in 0..81 {
            let at = (i * 37 % 81) / 9 * 10 + (i * 37 % 81) % 9 + 1;
            writeln!(text, "f {at} {} {}\nf {at} {} {}", at + 1, at + 11, at + 11, at + 10).unwrap();
        }
        read(text.as_bytes(), Format::Obj).unwrap()
    };
    let best = stripped(&grid, Method::Best);
    for (format, layout) in [(Format::Glb, Layout::Degenerate), (Format::Ply, Layout::Restart)] {
        let options = encode::Options::new(format).with_layout(layout);
        let source = read(&best.encode(&grid, &options, &()).unwrap().encoded.bytes, format).unwrap();
        check(&source, Method::Best);
        let mut stored = 0;
        for &method in Method::ALL.iter().filter(|&&method| method != Method::Cache) {
            let found = stripped(&source, method);
            let drawn = found.draw(&source, &options);
            let restart = layout == Layout::Restart;
            let figures = &found.metrics;
            let indices = if restart { figures.indices_restart } else { figures.indices_degenerate };
            assert_eq!(drawn.after.indices, indices.min(drawn.before.indices));
            assert_eq!(drawn.drawn_as[0] == DrawnAs::Stored, drawn.before.indices < indices);
            stored += usize::from(drawn.drawn_as[0] == DrawnAs::Stored);
        }
        assert!(stored >= 2, "{stored} methods are worse than the stored strips");
        check(&source, Method::SGI);
    }
}

#[test]
fn strips_for_a_vertex_cache_are_drawn_as_they_are() {
    let model = flat_shaded(4, 0);
    let found = stripped(&model, Method::Cache);
    assert_eq!(found.draw(&model, &encode::Options::new(Format::Glb)).drawn_as, [DrawnAs::Found]);
}

/// Also checks the textured scenes in the directory of the environment variable `TRISTRIP_MODELS`.
#[test]
fn scenes_and_models_never_grow() {
    let own = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../testdata/models");
    let textured = std::env::var_os("TRISTRIP_MODELS").map(|folder| PathBuf::from(folder).join("textured"));
    let mut folders: Vec<PathBuf> = textured.into_iter().chain([own]).collect();
    let mut checked = 0;
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if Format::from_path(&path).is_some() {
                check(&read_path(&path).unwrap(), Method::Sequential);
                checked += 1;
            }
        }
    }
    assert!(checked >= 5, "{checked}");
}

#[test]
fn a_glb_with_restarts_has_a_note() {
    let model = flat_shaded(3, 0);
    let found = stripped(&model, Method::Sequential);
    let notes = |format, layout| {
        found.encode(&model, &encode::Options::new(format).with_layout(layout), &()).unwrap().encoded.notes
    };
    assert!(notes(Format::Glb, Layout::Restart)[0].contains("KHR_mesh_primitive_restart"));
    assert!(
        notes(Format::Glb, Layout::Degenerate).is_empty() && notes(Format::Ply, Layout::Restart).is_empty()
    );
    let converted =
        convert::run(&model, &convert::Options::new(Format::Glb).with_layout(Layout::Restart), &()).unwrap();
    assert!(converted.encoded.notes[0].contains("three.js"));
}
