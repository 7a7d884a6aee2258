//! Every filter on every model at every kind of level, in every format and layout: written, read
//! back and proven.

#![expect(clippy::unwrap_used, reason = "a test that panics fails")]

use std::fmt::Write as _;
use std::path::PathBuf;

use tristrip::lod::RepairOptions;
use tristrip::{Layout, Method, StripifyOptions};
use tristrip_io::{Format, Model, read, read_path};
use tristrip_pipeline::{encode, levels, levels::DisplayFilter};

const FILES: [(Format, Layout); 6] = [
    (Format::Glb, Layout::Degenerate),
    (Format::Glb, Layout::Restart),
    (Format::Glb, Layout::Separate),
    (Format::Ply, Layout::Restart),
    (Format::Ply, Layout::List),
    (Format::Obj, Layout::List),
];

/// Writes levels of a model with all filters. Every file is proven to draw the level.
fn check(name: &str, model: &Model, files: &[(Format, Layout)]) {
    let stripify = StripifyOptions::default().with_method(Method::Sequential);
    let all = levels::run(model, &levels::Options::default().with_stripify(stripify), &()).unwrap().model;
    let last = all.collapse_count();
    for level in [0, last / 10, last / 2, last] {
        for filter in DisplayFilter::ALL {
            let shown = all.display(level, filter, RepairOptions::default(), &()).unwrap();
            for &(format, layout) in files {
                let options = encode::Options::new(format).with_layout(layout);
                let encoded = all.encode(model, &shown, &options, &());
                let faces = encoded.as_ref().map(|encoded| encoded.faces).map_err(ToString::to_string);
                let triangles = all.triangle_count(level).unwrap();
                assert_eq!(
                    faces,
                    Ok(Some(triangles)),
                    "{name}, level {level}, {filter}, {format:?}, {layout:?}"
                );
            }
        }
    }
}

/// Returns a bumpy tube of `n` × `n` squares as OBJ, with texture coordinates that have a seam, and
/// with unused vertices.
fn tube(n: usize) -> String {
    let mut text = String::new();
    for y in 0..=n {
        for x in 0..n {
            let angle = x as f64 / n as f64 * std::f64::consts::TAU;
            let radius = 1.0 + ((x * 7 + y * 3) % 5) as f64 / 20.0;
            writeln!(text, "v {} {} {y}\nv 9 {x} {y}", radius * angle.cos(), radius * angle.sin()).unwrap();
        }
        (0..=n).for_each(|x| writeln!(text, "vt {x} {y}").unwrap());
    }
    for (x, y) in (0..n).flat_map(|x| (0..n).map(move |y| (x, y))) {
        let corner = |x: usize, y: usize| format!("{}/{}", 2 * (y * n + x % n) + 1, y * (n + 1) + x + 1);
        let corners = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
        writeln!(text, "f {}", corners.join(" ")).unwrap();
    }
    text
}

/// Returns a line of the tube for one of several copies, moved next to the others.
fn moved(line: &str, number: usize) -> String {
    let (keyword, rest) = line.split_once(' ').unwrap();
    let words = rest.split(' ');
    let words: Vec<String> = match keyword {
        "f" => words
            .map(|corner| {
                let (v, t) = corner.split_once('/').unwrap();
                let at = |n: &str, block: usize| n.parse::<usize>().unwrap() + number * block;
                format!("{}/{}", at(v, 2 * 4 * 5), at(t, 5 * 5))
            })
            .collect(),
        "v" => words.map(|x| (x.parse::<f64>().unwrap() + 3.0 * number as f64).to_string()).collect(),
        _ => words.map(str::to_owned).collect(),
    };
    format!("{keyword} {}\n", words.join(" "))
}

#[test]
fn seams_unused_vertices_and_components_that_vanish() {
    check("tube", &read(tube(12).as_bytes(), Format::Obj).unwrap(), &FILES);
    // Many small tubes: the collapses leave vertices that no triangle of the level uses.
    let many: String =
        (0..6).flat_map(|i| tube(4).lines().map(move |line| moved(line, i)).collect::<Vec<_>>()).collect();
    check("tubes", &read(many.as_bytes(), Format::Obj).unwrap(), &FILES);
}

#[test]
fn every_model_of_the_project() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../testdata/models");
    let mut checked = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if Format::from_path(&path).is_some() {
            check(&path.display().to_string(), &read_path(&path).unwrap(), &FILES);
            checked += 1;
        }
    }
    assert!(checked >= 5, "{checked}");
}

/// Textured models and scenes with seams, from the directory of the environment variable
/// `TRISTRIP_MODELS`. Without it, nothing is checked.
#[test]
fn textured_models() {
    let Some(folder) = std::env::var_os("TRISTRIP_MODELS").map(PathBuf::from) else { return };
    let models = [
        "bunny10k_textured.obj",
        "pirate.obj",
        "texturedknot.obj",
        "textured/Duck.glb",
        "textured/CesiumMan.glb",
    ];
    for name in models {
        check(name, &read_path(folder.join(name)).unwrap(), &[FILES[0], FILES[3], FILES[5]]);
    }
}
