//! The default never writes more indices than its input or than a list, in every format. The 20
//! models are flat-shaded: most of their faces have their own vertices.

#![expect(clippy::unwrap_used, reason = "a test that panics fails")]

use std::collections::HashMap;
use std::f64::consts::TAU;

use tristrip::{Faces, Mesh};
use tristrip_io::{Format, Model, Part, StoredStrips, read};
use tristrip_pipeline::{Drawn, DrawnAs, encode, strip};

const MODELS: usize = 20;

/// A surface over a grid of squares, as the position of each grid point.
type Surface = fn([usize; 2], [usize; 2]) -> [f64; 3];

const SURFACES: [Surface; 5] = [
    // A terrain.
    |[x, y], _| [x as f64, y as f64, ((x * 7 + y * 5) % 3) as f64],
    // A tube.
    |[x, y], [columns, _]| [angle(x, columns).cos(), angle(x, columns).sin(), y as f64],
    // A torus.
    |[x, y], [columns, rows]| {
        let (around, across) = (angle(x, columns), angle(y, rows));
        let radius = 3.0 + across.cos();
        [radius * around.cos(), radius * around.sin(), across.sin()]
    },
    // A cone: the squares of the first row have two corners at the apex.
    |[x, y], [columns, _]| {
        let radius = y as f64;
        [radius * angle(x, columns).cos(), radius * angle(x, columns).sin(), -radius]
    },
    // A staircase.
    |[x, y], _| [x.div_ceil(2) as f64, y as f64, (x / 2) as f64],
];

fn angle(step: usize, steps: usize) -> f64 {
    step as f64 / steps as f64 * TAU
}

/// Returns a model of triangles, quadrilaterals or both. Only faces in some smooth rows share
/// vertices.
fn model(seed: usize) -> Model {
    let (surface, size) = (SURFACES[seed % SURFACES.len()], [3 + seed % 7, 2 + seed]);
    let smooth_rows = [None, Some(1), Some(4), Some(9)][seed % 4];
    let (mut positions, mut polygons, mut shared) = (Vec::new(), Vec::new(), HashMap::new());
    for (x, y) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))) {
        let is_smooth = smooth_rows.is_some_and(|every| y % every == 0);
        let square = [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]];
        let is_cut = [true, false, (x + y) % 2 == 0][seed % 3];
        let faces: &[&[usize]] = if is_cut { &[&[0, 1, 2], &[0, 2, 3]] } else { &[&[0, 1, 2, 3]] };
        for face in faces {
            let mut vertex = |&corner: &usize| {
                let mut add = || {
                    positions.push(surface(square[corner], size).map(|x| x as f32));
                    positions.len() as u32 - 1
                };
                if is_smooth { *shared.entry(square[corner]).or_insert_with(add) } else { add() }
            };
            polygons.push(face.iter().map(&mut vertex).collect::<Vec<_>>());
        }
    }
    let mesh = Mesh::new(positions, Faces::from_polygons(polygons).unwrap()).unwrap();
    Model { parts: vec![Part { mesh, ..Part::default() }], ..Model::default() }
}

/// Counts the indices of a model in its file: those of stored strips, or one per corner.
fn written(model: &Model) -> usize {
    let indices =
        |part: &Part| part.stored.as_ref().map_or(part.mesh.faces().corner_count(), StoredStrips::indices);
    model.parts.iter().map(indices).sum()
}

/// Checks a file in one format. Returns how it draws the model.
fn check<'a>(model: &'a Model, found: &'a strip::Outcome, format: Format) -> Drawn<'a> {
    let options = encode::Options::new(format);
    let drawn = found.draw(model, &options);
    let faces = model.parts[0].mesh.faces();
    let list = 3 * faces.triangle_count();
    assert!(drawn.after.indices <= drawn.before.indices.min(list), "{format:?}: {drawn:?}");
    let encoded = found.encode(model, &options, &()).unwrap().encoded;
    assert_eq!(encoded.faces, Some(faces.face_count()), "{format:?}: proven");
    let again = read(&encoded.bytes, format).unwrap();
    // Polygons stay polygons in a PLY; the other formats get triangles.
    let most = if format == Format::Ply { faces.corner_count().min(list) } else { list };
    assert!(
        written(&again) <= most,
        "{format:?}: found {} indices, expected at most {most}",
        written(&again)
    );
    drawn
}

#[test]
fn no_format_gets_more_indices_than_the_input_or_a_list() {
    let (mut lists, mut strips) = (0, 0);
    for seed in 0..MODELS {
        let model = model(seed);
        let found = strip::run(&model, &strip::Options::default(), &()).unwrap();
        for format in [Format::Glb, Format::Ply, Format::Obj] {
            let drawn = check(&model, &found, format);
            if format != Format::Obj {
                lists += usize::from(drawn.drawn_as == [DrawnAs::List]);
                strips += usize::from(drawn.drawn_as == [DrawnAs::Found]);
            }
        }
    }
    assert!(lists >= 10 && strips >= 5, "{lists} lists, {strips} drawn as strips");
}
