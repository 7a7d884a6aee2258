//! Normals of simplified models: flat-shaded models have the normals of their remaining faces, in
//! every format.

#![expect(clippy::unwrap_used, reason = "a test that panics fails")]

use std::collections::BTreeSet;

use tristrip::{Attribute, AttributeData, Faces, Mesh};
use tristrip_io::{Format, Model, Part, read};
use tristrip_pipeline::{Amount, Deviation, Goal, simplify, simplify::Normals};

const COLUMNS: usize = 36;
const ROWS: usize = 20;

fn attribute(name: &str, components: u8, values: Vec<f32>) -> Attribute {
    Attribute { name: name.into(), components, normalized: false, data: AttributeData::F32(values) }
}

fn normal_of([a, b, c]: [[f32; 3]; 3]) -> [f32; 3] {
    let [u, v] = [b, c].map(|p| [0, 1, 2].map(|k| f64::from(p[k]) - f64::from(a[k])));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = n.iter().map(|x| x * x).sum::<f64>().sqrt();
    n.map(|x| (x / length) as f32)
}

/// The position, texture coordinates and smooth normal of a corner.
type Corner = ([f32; 3], [f32; 2], [f32; 3]);

/// Returns the triangles of a tube of varying radius around the z axis: positions, texture
/// coordinates, and normals that point away from the axis.
fn triangles(width: impl Fn(usize) -> f64) -> Vec<[Corner; 3]> {
    let at = |column: usize, row: usize| {
        let turn = (column % COLUMNS) as f64 / COLUMNS as f64 * std::f64::consts::TAU;
        let (sin, cos) = turn.sin_cos();
        let position = [cos * width(row), sin * width(row), row as f64 / 4.0].map(|x| x as f32);
        let uv = [column as f32 / COLUMNS as f32, row as f32 / ROWS as f32];
        (position, uv, [cos as f32, sin as f32, 0.0])
    };
    let cells = (0..ROWS).flat_map(|row| (0..COLUMNS).map(move |column| (column, row)));
    let faces = cells.flat_map(|(x, y)| {
        let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
        [[a, b, c], [a, c, d]]
    });
    faces.collect()
}

/// Returns a model in which every triangle has its own vertices. `normal` returns the normal of a
/// corner of a triangle.
fn model(faces: &[[Corner; 3]], normal: impl Fn([[f32; 3]; 3], [f32; 3]) -> [f32; 3]) -> Model {
    let corners = || faces.as_flattened().iter();
    let normals = faces.iter().flat_map(|face| {
        let positions = face.map(|corner| corner.0);
        face.map(|corner| normal(positions, corner.2))
    });
    let faces = Faces::from_triangles((0..3 * faces.len() as u32).collect()).unwrap();
    let mesh = Mesh::new(corners().map(|corner| corner.0).collect::<Vec<_>>(), faces).unwrap();
    let mesh = mesh.with_attribute(attribute("NORMAL", 3, normals.flatten().collect())).unwrap();
    let uv = corners().flat_map(|corner| corner.1).collect();
    let mesh = mesh.with_attribute(attribute("TEXCOORD_0", 2, uv)).unwrap();
    Model { parts: vec![Part { mesh, ..Part::default() }], ..Model::default() }
}

fn wavy(row: usize) -> f64 {
    2.0 + 0.5 * (row as f64 / 3.0).sin()
}

fn simplified(model: &Model, normals: Normals, format: Format) -> simplify::Outcome {
    let amount = Some(Amount::Ratio("20%".parse().unwrap()));
    let goal = Goal { amount, deviation: Deviation::Percent(100.0) };
    simplify::run(
        model,
        &simplify::Options::default().with_goal(goal).with_normals(normals).with_format(format),
        &(),
    )
    .unwrap()
}

/// Calls a check with the positions and the normals of each triangle.
fn for_each_triangle(mesh: &Mesh, mut check: impl FnMut([[f32; 3]; 3], [[f32; 3]; 3])) {
    let normals = mesh.attributes().iter().find(|a| a.name == "NORMAL").unwrap();
    for face in mesh.faces().iter() {
        let corners: [u32; 3] = face.try_into().unwrap();
        let normal = |v: u32| [0, 1, 2].map(|k| normals.float(3 * v as usize + k).unwrap());
        check(corners.map(|v| mesh.positions()[v as usize]), corners.map(normal));
    }
}

#[test]
fn flat_shaded_models_get_the_normals_of_the_faces_left() {
    let source = model(&triangles(wavy), |face, _| normal_of(face));
    let count = source.parts[0].mesh.faces().face_count();
    assert_eq!(count, 1440);
    for format in [Format::Ply, Format::Obj, Format::Glb] {
        let result = simplified(&source, Normals::Auto, format);
        assert!(result.proven && result.collapses.reached && result.normals.flat == 1);
        // The texture does not repeat, so its only seam stays.
        let bytes = result.encode(format, true, &()).unwrap().bytes;
        let again = read(&bytes, format).unwrap();
        let mesh = &again.parts[0].mesh;
        assert_eq!(mesh.faces().face_count(), result.collapses.triangles_after);
        let mut different = BTreeSet::new();
        for_each_triangle(mesh, |positions, normals| {
            assert_eq!(normals, [normal_of(positions); 3], "{format:?}");
            different.insert(normals[0].map(f32::to_bits));
        });
        assert!(different.len() > 200, "{}", different.len());
        assert!(mesh.vertex_count() <= 3 * result.collapses.triangles_after);
    }
    let kept = simplified(&source, Normals::Keep, Format::Ply);
    assert!(kept.collapses.triangles_after > 1000 && kept.normals.kept == 1, "{:?}", kept.collapses);
}

#[test]
fn fitted_faces_have_their_own_normals() {
    let source = model(&triangles(wavy), |face, _| normal_of(face));
    let amount = Some(Amount::Ratio("20%".parse().unwrap()));
    let goal = Goal { amount, deviation: Deviation::Percent(100.0) };
    let result =
        simplify::run(&source, &simplify::Options::default().with_goal(goal).with_fit(true), &()).unwrap();
    assert!(result.moved_positions > Some(100), "{:?}", result.moved_positions);
    for_each_triangle(&result.redrawn.model.parts[0].mesh, |positions, normals| {
        let face = normal_of(positions);
        assert!(normals.iter().all(|normal| (0..3).all(|k| (normal[k] - face[k]).abs() < 1e-6)));
    });
}

/// The default changes nothing if no part is flat-shaded.
#[test]
fn smooth_models_keep_their_normals() {
    let source = model(&triangles(wavy), |_, axis| axis);
    let [auto, keep] = [Normals::Auto, Normals::Keep].map(|normals| {
        simplified(&source, normals, Format::Glb).encode(Format::Glb, true, &()).unwrap().bytes
    });
    assert!(auto == keep);
}

/// A stepped tube: the walls are smooth around the axis, the steps are flat, and the edges between
/// them are hard.
#[test]
fn creased_models_stay_smooth_up_to_the_creases() {
    let step = |row: usize| [2.0, 2.0, 1.5, 1.5, 1.0, 1.0][row % 6];
    let is_step = |face: [[f32; 3]; 3]| normal_of(face)[2].abs() > 0.5;
    let source = model(&triangles(step), |face, axis| if is_step(face) { normal_of(face) } else { axis });
    let result = simplified(&source, Normals::Rebuild, Format::Ply);
    assert_eq!((result.normals.creased, result.normals.flat), (1, 0));
    let kept = simplified(&source, Normals::Keep, Format::Ply);
    assert!(result.collapses.triangles_after <= kept.collapses.triangles_after);
    let (mut smooth, mut all, mut following, mut corners) = (0, 0, 0, 0);
    for_each_triangle(&result.redrawn.model.parts[0].mesh, |positions, normals| {
        let face = normal_of(positions);
        for (position, normal) in positions.iter().zip(normals) {
            let along = (0..3).map(|k| face[k] * normal[k]).sum::<f32>();
            following += usize::from(along > 0.5);
            corners += 1;
            let radius = position[0].hypot(position[1]);
            let radial = (position[0] * normal[0] + position[1] * normal[1]) / radius;
            smooth += usize::from(!is_step(positions) && radial > 0.9);
            all += usize::from(!is_step(positions));
        }
    });
    assert!(10 * smooth > 7 * all, "{smooth} of {all}");
    assert!(100 * following > 95 * corners, "{following} of {corners} normals follow their faces");
}

/// Only one of two parts is flat-shaded. The other one is simplified as if it were alone.
#[test]
fn parts_are_treated_one_by_one() {
    let mut source = model(&triangles(wavy), |face, _| normal_of(face));
    let far = |p: [f32; 3]| [p[0] + 9.0, p[1], p[2]];
    let moved: Vec<_> =
        triangles(wavy).iter().map(|face| face.map(|(p, uv, axis)| (far(p), uv, axis))).collect();
    source.parts.extend(model(&moved, |_, axis| axis).parts);
    // Parts share a triangle budget, but each has its own error limit.
    let goal = Goal { amount: None, deviation: Deviation::Units(0.05) };
    let simplified = |source| {
        simplify::run(source, &simplify::Options::default().with_goal(goal).with_format(Format::Glb), &())
            .unwrap()
    };
    let result = simplified(&source);
    assert_eq!((result.normals.flat, result.normals.kept, result.normals.creased), (1, 1, 0));
    let alone = simplified(&model(&moved, |_, axis| axis));
    assert!(alone.collapses.triangles_after < alone.collapses.triangles_before);
    assert_eq!(result.redrawn.model.parts[1].mesh, alone.redrawn.model.parts[0].mesh);
}

/// Returns a box with rounded edges. Its sides are flat, and the normals change continuously along
/// the edges, without a seam.
fn rounded_box() -> Model {
    const ROUNDED: usize = 4;
    const CELLS: usize = 2 * ROUNDED + 3;
    // Away from the middle of a side, the normal turns by up to 45° toward the next side.
    let turn = |i: usize| match i {
        i if i <= ROUNDED => i as f64 / ROUNDED as f64 - 1.0,
        i if i >= CELLS - ROUNDED => (i + ROUNDED - CELLS) as f64 / ROUNDED as f64,
        _ => 0.0,
    };
    // The box without its edges has size 7. The radius of the edges is 0.5.
    let core = |i: usize| ((i.clamp(ROUNDED, CELLS - ROUNDED) - ROUNDED) as f64 / 3.0 - 0.5) * 7.0;
    let corner = |axis: usize, up: f64, [i, j]: [usize; 2]| {
        let turned = |v: [f64; 3]| -> [f32; 3] { std::array::from_fn(|k| v[(k + axis) % 3] as f32) };
        let direction = [turn(i), turn(j) * up, up];
        let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
        let middle = [core(i), core(j) * up, 3.5 * up];
        let at = [0, 1, 2].map(|k| middle[k] + 0.5 * direction[k] / length);
        (turned(at), [0.0; 2], turned(direction.map(|x| x / length)))
    };
    let mut faces = Vec::new();
    for (axis, up) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
        for (i, j) in (0..CELLS).flat_map(|i| (0..CELLS).map(move |j| (i, j))) {
            let cell = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
            let [a, b, c, d] = cell.map(|at| corner(axis, up, at));
            faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    model(&faces, |_, normal| normal)
}

/// At a low triangle count, the sides of a rounded box end at vertices of its edges.
#[test]
fn normals_that_no_longer_fit_are_repaired() {
    let source = rounded_box();
    let unfit = |mesh: &Mesh| {
        let triangles = mesh.faces().as_triangles().unwrap();
        tristrip::normals::NormalFit::of(mesh, triangles).unwrap().unwrap()
    };
    let before = unfit(&source.parts[0].mesh);
    assert!(before.flat > 0.6 && before.unfit < 0.01, "{before:?}");
    let few = |normals| {
        let goal = Goal { amount: Some(Amount::Triangles(12)), deviation: Deviation::Percent(100.0) };
        simplify::run(&source, &simplify::Options::default().with_goal(goal).with_normals(normals), &())
            .unwrap()
    };
    let (auto, keep) = (few(Normals::Auto), few(Normals::Keep));
    assert_eq!((auto.normals.repaired, auto.normals.kept), (1, 0));
    assert_eq!((keep.normals.repaired, keep.normals.kept), (0, 1));
    // The same triangles at the same positions, with other normals.
    assert_eq!(auto.collapses, keep.collapses);
    let [auto, keep] = [auto, keep].map(|done| done.redrawn.model.parts[0].mesh.clone());
    assert!(unfit(&keep).unfit > 0.1, "{:?}", unfit(&keep));
    assert!(unfit(&auto).unfit < 1e-9 && auto.vertex_count() > keep.vertex_count(), "{:?}", unfit(&auto));
    let positions = |mesh: &Mesh| {
        let mut all = Vec::new();
        for_each_triangle(mesh, |positions, _| all.push(positions.map(|p| p.map(f32::to_bits))));
        all
    };
    assert_eq!(positions(&auto), positions(&keep));
}
