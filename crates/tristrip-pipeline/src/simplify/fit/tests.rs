#![allow(clippy::format_push_string, reason = "small texts")]

use std::collections::HashSet;

use super::surface::tests::LOOKED_AT;
use super::*;
use crate::{Amount, Goal, Ratio, simplify};
use tristrip::random::Random;
use tristrip_io::{Format, Model, read};

/// A sphere of triangles, or its upper half. Each half is a part with its own material.
fn ball(rows: usize, columns: usize, is_half: bool) -> Model {
    let mut text = String::from("v 0 0 1\n");
    let last = if is_half { rows / 2 } else { rows - 1 };
    for row in 1..=last {
        for column in 0..columns {
            let (polar, around) = (
                std::f64::consts::PI * row as f64 / rows as f64,
                std::f64::consts::TAU * column as f64 / columns as f64,
            );
            let [x, y, z] = [polar.sin() * around.cos(), polar.sin() * around.sin(), polar.cos()];
            text += &format!("v {x} {y} {z}\n");
        }
    }
    let at = |row: usize, column: usize| 2 + (row - 1) * columns + column % columns;
    text += "usemtl upper\n";
    for column in 0..columns {
        text += &format!("f 1 {} {}\n", at(1, column), at(1, column + 1));
    }
    for row in 1..last {
        if row == rows / 2 {
            text += "usemtl lower\n";
        }
        for column in 0..columns {
            let [a, b] = [at(row, column), at(row, column + 1)];
            let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
            text += &format!("f {a} {c} {b}\nf {b} {c} {d}\n");
        }
    }
    if !is_half {
        text += "v 0 0 -1\n";
        for column in 0..columns {
            let end = 2 + last * columns;
            text += &format!("f {end} {} {}\n", at(last, column + 1), at(last, column));
        }
    }
    read(text.as_bytes(), Format::Obj).unwrap()
}

/// The positions of the triangles of all parts.
fn triangles(model: &Model) -> Vec<[[u32; 3]; 3]> {
    let of_part = |part: &tristrip_io::Part| {
        let mesh = part.mesh.clone();
        let corners: &[[u32; 3]] = mesh.faces().corners().as_chunks().0;
        corners.iter().map(|t| t.map(|v| bits(mesh.positions()[v as usize]))).collect::<Vec<_>>()
    };
    model.parts.iter().flat_map(of_part).collect()
}

/// Counts the edges of one triangle, by position.
fn open_edges(model: &Model) -> usize {
    let mut edges: HashMap<[[u32; 3]; 2], usize> = HashMap::new();
    for [a, b, c] in triangles(model) {
        for [a, b] in [[a, b], [b, c], [c, a]] {
            *edges.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
    }
    edges.values().filter(|&&triangles| triangles == 1).count()
}

/// The number of positions that both parts have, and how many of them a source does not have.
fn shared(model: &Model, source: &Model) -> [usize; 2] {
    let of = |model: &Model, part: usize| -> HashSet<[u32; 3]> {
        model.parts[part].mesh.positions().iter().map(|&position| bits(position)).collect()
    };
    let [upper, lower, old] = [of(model, 0), of(model, 1), of(source, 0)];
    let shared = || upper.intersection(&lower);
    [shared().count(), shared().filter(|position| !old.contains(*position)).count()]
}

fn simplified(model: &Model, fit: bool) -> simplify::Outcome {
    let goal = Goal { amount: Ratio::new(0.1).map(Amount::Ratio), ..Goal::default() };
    simplify::run(model, &simplify::Options::default().with_goal(goal).with_fit(fit), &()).unwrap()
}

#[test]
fn a_ball_is_closer_and_stays_closed() {
    let model = ball(24, 40, false);
    let [before, after] = [false, true].map(|fit| simplified(&model, fit));
    let change = |done: &simplify::Outcome| done.deviations.unwrap().change;
    assert!(change(&after).rms < 0.6 * change(&before).rms, "{:?} {:?}", after.deviations, before.deviations);
    assert!(change(&after).largest < change(&before).largest);
    let faces = |done: &simplify::Outcome| -> usize {
        done.redrawn.model.parts.iter().map(|part| part.mesh.faces().face_count()).sum()
    };
    assert_eq!((faces(&before), before.moved_positions), (faces(&after), None));
    assert_eq!(open_edges(&before.redrawn.model) + open_edges(&after.redrawn.model), 0);
    // The fitted vertices of a sphere are outside it.
    let radius = |p: &[f32; 3]| p.iter().map(|x| x * x).sum::<f32>().sqrt();
    let positions = after.redrawn.model.parts[0].mesh.positions();
    assert!(positions.iter().filter(|p| radius(p) > 1.001).count() > positions.len() / 2);
    // Both sides of the border between the parts move to the same positions.
    let [[all, _], [still, moved]] = [&before, &after].map(|done| shared(&done.redrawn.model, &model));
    assert!(all == still && moved == all && all > 5, "{all} {still} {moved}");
}

/// A fitted model of two materials, read back from a GLB, is unchanged, and the border between its
/// parts is closed.
#[test]
fn scenes_are_fitted_and_written() {
    let whole =
        simplify::run(&ball(24, 40, false), &simplify::Options::default().with_goal(Goal::default()), &())
            .unwrap();
    let scene = read(&whole.encode(Format::Glb, true, &()).unwrap().bytes, Format::Glb).unwrap();
    let goal = Goal { amount: Ratio::new(0.1).map(Amount::Ratio), ..Goal::default() };
    let options = simplify::Options::default().with_goal(goal).with_fit(true).with_format(Format::Glb);
    let done = simplify::run(&scene, &options, &()).unwrap();
    assert!(done.notes.is_empty() && done.redrawn.kept == 0, "{:?}", done.notes);
    let back = read(&done.encode(Format::Glb, true, &()).unwrap().bytes, Format::Glb).unwrap();
    assert!(scene.scene.is_some() && triangles(&back) == triangles(&done.redrawn.model));
    let [border, moved] = shared(&back, &scene);
    assert!(border > 5 && moved == border && open_edges(&back) == 0, "{border} {moved}");
    let corners: HashSet<[u32; 3]> = triangles(&back).into_flattened().into_iter().collect();
    assert_eq!(done.moved_positions, Some(corners.len()));
    // Values are copied from the source vertices.
    for (part, new) in done.redrawn.model.parts.iter().enumerate() {
        let sources = done.source_vertices(part).unwrap();
        assert_eq!(sources.len(), new.mesh.vertex_count());
        for (&source, new) in sources.iter().zip(new.mesh.positions()) {
            let old = scene.parts[part].mesh.positions()[source as usize];
            assert!((0..3).all(|k| (old[k] - new[k]).abs() < 0.2), "{old:?} {new:?}");
        }
    }
}

/// A sphere over a floor of two triangles, which have most of the area.
fn ball_over_floor(rows: usize, columns: usize) -> Model {
    let mut model = ball(rows, columns, false);
    let floor = "v -900 -900 -2\nv 900 -900 -2\nv 900 900 -2\nv -900 900 -2\nf 1 2 3\nf 1 3 4\n";
    let floor = read(floor.as_bytes(), Format::Obj).unwrap();
    model.parts.extend(floor.parts);
    model
}

/// Returns how many triangles the searches of a fit visit. All searches run on one thread.
fn looked_at(model: &Model, ratio: f64) -> usize {
    let amount = Ratio::new(ratio).map(Amount::Ratio);
    let goal = Goal { amount, deviation: crate::Deviation::Percent(100.0) };
    let options = simplify::Options::default().with_goal(goal).with_fit(true).with_measure(false);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        LOOKED_AT.set(0);
        assert!(simplify::run(model, &options, &()).unwrap().moved_positions > Some(100));
        LOOKED_AT.get()
    })
}

#[test]
fn searches_beside_huge_triangles_look_at_few_triangles() {
    let alone = looked_at(&ball(24, 40, false), 0.2);
    let [small, large] = [1, 2].map(|k| looked_at(&ball_over_floor(24 * k, 40 * k), 0.2));
    assert!(10 * small < 12 * alone, "{small} with a floor, {alone} without");
    assert!(large < 6 * small, "4 times the triangles take {large}, not {small}");
}

/// With a floor, the sphere is fitted as well as alone.
#[test]
fn large_triangles_take_no_points_from_small_ones() {
    let model = ball_over_floor(24, 40);
    let goal =
        Goal { amount: Ratio::new(0.2).map(Amount::Ratio), deviation: crate::Deviation::Percent(100.0) };
    let done =
        simplify::run(&model, &simplify::Options::default().with_goal(goal).with_fit(true), &()).unwrap();
    assert!(done.moved_positions.unwrap() > 100);
    for part in &done.redrawn.model.parts[..2] {
        for p in part.mesh.positions() {
            let radius = p.iter().map(|x| x * x).sum::<f32>().sqrt();
            assert!((0.99..1.06).contains(&radius), "{radius}");
        }
    }
}

/// A prism of many sides. Each end is a fan around one corner.
fn column(sides: i32) -> Model {
    let mut text = String::from("v 0 0 0\nv 0 0 4\n");
    for row in 0..5 {
        for side in 0..sides {
            let around = std::f64::consts::TAU * f64::from(side) / f64::from(sides);
            text += &format!("v {} {} {row}\n", around.cos(), around.sin());
        }
    }
    let at = |row: i32, side: i32| 3 + row * sides + side % sides;
    for side in 0..sides {
        for row in 0..4 {
            let [a, b] = [at(row, side), at(row, side + 1)];
            let [c, d] = [at(row + 1, side), at(row + 1, side + 1)];
            text += &format!("f {a} {b} {c}\nf {b} {d} {c}\n");
        }
        text +=
            &format!("f 1 {} {}\nf 2 {} {}\n", at(0, side + 1), at(0, side), at(4, side), at(4, side + 1));
    }
    read(text.as_bytes(), Format::Obj).unwrap()
}

#[test]
fn no_search_looks_at_all_triangles_of_a_fan() {
    let [few, many] = [1000, 4000].map(|sides| looked_at(&column(sides), 0.5));
    assert!(many < 6 * few, "4 times the triangles take {many}, not {few}");
}

/// For any moves, no triangle rotates by more than the limit.
#[test]
fn no_step_turns_a_triangle() {
    let mut random = Random::new(3);
    let mut number = move || (random.below(2000) as f64 - 1000.0) / 1000.0;
    let mesh = ball(12, 20, false).parts.remove(0).mesh;
    let at: Vec<Point> = mesh.positions().iter().map(|p| p.map(f64::from)).collect();
    for size in [0.01, 0.1, 0.5, 3.0] {
        let mut surface = FitSurface::new(mesh.faces(), at.clone());
        let normals: Vec<Point> = surface.triangles.iter().map(|t| unit_normal(&at, t)).collect();
        let moves = at.iter().map(|_| [size * number(), size * number(), size * number()]).collect();
        step(&mut surface, moves, &normals);
        for (t, normal) in surface.triangles.iter().zip(&normals) {
            assert!(dot(unit_normal(&surface.at, t), *normal) >= MAX_TURN, "{size} {t:?}");
        }
        assert!(size > 0.1 || surface.at != at);
    }
}

/// Spheres with needles. The points of the collapsed triangles must not pull away a vertex at the
/// foot of a needle.
#[test]
fn the_largest_distance_does_not_grow() {
    for seed in 0..12 {
        let mut model = ball(40, 60, false);
        let mut random = Random::new(seed);
        let mut positions = model.parts[0].mesh.positions().to_vec();
        for position in &mut positions {
            let height = if random.below(40) == 0 { 500 } else { 30 };
            let factor = 1.0 + random.below(height) as f32 / 1000.0;
            *position = position.map(|x| x * factor);
        }
        model.parts.truncate(1);
        let faces = model.parts[0].mesh.faces().clone();
        model.parts[0].mesh = Mesh::new(positions, faces).unwrap();
        let of = |fit| {
            let amount = Ratio::new(0.15).map(Amount::Ratio);
            let goal = Goal { amount, deviation: crate::Deviation::Percent(100.0) };
            let done =
                simplify::run(&model, &simplify::Options::default().with_goal(goal).with_fit(fit), &())
                    .unwrap();
            done.deviations.unwrap().change
        };
        let [kept, fitted] = [of(false), of(true)];
        assert!(fitted.largest <= 1.05 * kept.largest, "{fitted:?} {kept:?}");
    }
}

/// An observer that stops a simplification during the fit gets the current result. One that cancels
/// gets an error.
#[test]
fn the_fit_can_be_interrupted() {
    use std::sync::atomic::{AtomicBool, Ordering};

    use crate::{Error, Observer, SimplifyProgress, Stage};

    struct Ends {
        is_ended: AtomicBool,
        cancels: bool,
        at: Stage,
    }
    impl Observer for Ends {
        fn stage(&self, stage: Stage) {
            self.is_ended.fetch_or(stage == self.at, Ordering::Relaxed);
        }
        fn simplifies(&self, _: SimplifyProgress) -> bool {
            !self.is_ended.load(Ordering::Relaxed)
        }
        fn is_cancelled(&self) -> bool {
            self.cancels && self.is_ended.load(Ordering::Relaxed)
        }
    }
    let model = ball(24, 40, false);
    let goal = Goal { amount: Ratio::new(0.1).map(Amount::Ratio), ..Goal::default() };
    for at in [Stage::Fit, Stage::Prove, Stage::Compare] {
        for verify in [true, false] {
            let options = simplify::Options::default().with_goal(goal).with_fit(true).with_verify(verify);
            let run =
                |cancels| simplify::run(&model, &options, &Ends { is_ended: false.into(), cancels, at });
            let is_asked_later = at != Stage::Compare && (verify || at == Stage::Fit);
            let done = run(false).unwrap();
            assert_eq!(done.interrupted, is_asked_later, "{at:?} {verify}");
            assert_eq!(done.deviations.is_some(), !is_asked_later);
            assert_eq!(done.moved_positions.is_some(), at != Stage::Prove || !verify);
            assert_eq!(matches!(run(true), Err(Error::Cancelled)), is_asked_later, "{at:?} {verify}");
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same() {
    let model = ball(24, 40, false);
    let of_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        triangles(&pool.install(|| simplified(&model, true)).redrawn.model)
    };
    assert_eq!(of_threads(1), of_threads(5));
}

#[test]
fn borders_stay() {
    let model = ball(24, 40, true);
    let [before, after] = [false, true].map(|fit| simplified(&model, fit));
    let [before, after] = [&before, &after].map(|done| triangles(&done.redrawn.model).into_flattened());
    let mut moved = 0;
    for (old, new) in before.iter().zip(&after) {
        assert!(f32::from_bits(old[2]) > 1e-6 || old == new, "{old:?} {new:?}");
        moved += usize::from(old != new);
    }
    assert!(moved > 30, "{moved}");
}
