//! Whole models from memory to bytes: several parts, observers, cancellation, and invalid
//! arguments.

#![expect(clippy::unwrap_used, reason = "a test that panics fails")]

use std::fmt::Write as _;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use tristrip::Effort;
use tristrip::lod::{Camera, RepairOptions, SkipView, ViewCriteria};
use tristrip::stripify::{Progress, Watch};
use tristrip::{Layout, Mesh, Method, StripifyOptions, Strips};
use tristrip_io::{Drawing, Format, Model, read};
use tristrip_pipeline::{
    Amount, Deviation, Error, Goal, Observer, PreparedModel, Search, SearchStop, Stage, bound, convert,
    encode, levels, levels::DisplayFilter, levels::ModelLevels, simplify, strip, verify, view_model,
};

/// Returns a grid of squares in two parts, left and right of the middle. They share the vertices
/// between them.
fn two_parts() -> Model {
    let mut text = String::new();
    for y in 0..9 {
        (0..9).for_each(|x| writeln!(text, "v {x} {y} {}", (x * y) % 3).unwrap());
    }
    for (material, columns) in [("left", 0..4), ("right", 4..8)] {
        writeln!(text, "usemtl {material}").unwrap();
        for (x, y) in columns.flat_map(|x| (0..8).map(move |y| (x, y))) {
            let at = 9 * y + x + 1;
            writeln!(text, "f {} {} {} {}", at, at + 1, at + 10, at + 9).unwrap();
        }
    }
    read(text.as_bytes(), Format::Obj).unwrap()
}

#[test]
fn strips_of_all_parts_are_written_and_proven_in_every_format() {
    let model = two_parts();
    let stripped = strip::run(&model, &strip::Options::default(), &()).unwrap();
    assert_eq!((stripped.strips.len(), stripped.mesh.faces, stripped.proven), (2, 64, true));
    for format in [Format::Glb, Format::Ply, Format::Obj] {
        for reorder in [false, true] {
            let encoded =
                stripped.encode(&model, &encode::Options::new(format).with_reorder(reorder), &()).unwrap();
            let encoded = encoded.encoded;
            assert_eq!((encoded.faces, encoded.groups.is_some()), (Some(64), reorder));
            let again = read(&encoded.bytes, format).unwrap();
            let verified = verify::run(&model, &again, &()).unwrap();
            assert_eq!((verified.proven, verified.faces), (true, 64));
        }
    }
    let faces = [Drawing::Faces, Drawing::Faces];
    let reordered = encode::run(&model, &faces, &encode::Options::new(Format::Ply).with_reorder(true), &());
    assert_eq!(reordered.unwrap().faces, Some(64), "faces are numbered by first use, too");
}

#[test]
fn no_strips_are_better_than_the_bound() {
    let model = two_parts();
    let bounded = bound::run(&model, &bound::Options::default(), &()).unwrap();
    assert_eq!(bounded.parts, 2);
    for method in [Method::Fewest, Method::Best, Method::Input] {
        let options = strip::Options::default().with_stripify(StripifyOptions::default().with_method(method));
        let figures = strip::run(&model, &options, &()).unwrap().metrics;
        assert!(figures.strips >= bounded.bound.strips);
        assert!(figures.indices_restart >= bounded.bound.indices_restart);
    }
}

/// Returns the heights of the used vertices on the line between the two parts.
fn border(mesh: &Mesh, corners: &[u32]) -> Vec<u32> {
    let drawn = corners.iter().map(|&v| mesh.positions()[v as usize]);
    let mut border: Vec<u32> =
        drawn.filter(|p| p[0].to_bits() == 4.0_f32.to_bits()).map(|p| p[1].to_bits()).collect();
    border.sort_unstable();
    border.dedup();
    border
}

#[test]
fn both_sides_of_a_shared_border_are_simplified_together() {
    let model = two_parts();
    let (amount, deviation) = (Some(Amount::Triangles(20)), Deviation::Percent(100.0));
    let goal = Goal { amount, deviation };
    let simplified = simplify::run(&model, &simplify::Options::default().with_goal(goal), &()).unwrap();
    assert_eq!((simplified.collapses.locked_vertices, simplified.collapses.reached), (0, true));
    let borders: Vec<Vec<u32>> = simplified
        .redrawn
        .model
        .parts
        .iter()
        .map(|part| border(&part.mesh, part.mesh.faces().corners()))
        .collect();
    assert!(borders[0] == borders[1] && borders[0].len() < 9, "{borders:?}");
    assert_eq!(
        simplified.encode(Format::Ply, true, &()).unwrap().faces,
        Some(simplified.collapses.triangles_after)
    );
    // Every level of detail is closed, too.
    let all = levels::run(&model, &levels::Options::default(), &()).unwrap().model;
    for level in 0..=all.collapse_count() {
        let of_parts = all.order.of_parts(level).unwrap();
        let of_part = |i: usize| border(&model.parts[i].mesh, &all.parts[i].triangles(of_parts[i]).unwrap());
        assert_eq!(of_part(0), of_part(1), "level {level}");
    }
}

#[test]
fn every_level_and_filter_is_proven_and_can_be_written() {
    let model = two_parts();
    let all = levels::run(&model, &levels::Options::default().with_base("10%".parse().unwrap()), &())
        .unwrap()
        .model;
    let last = all.collapse_count();
    assert!(last > 20, "{last}");
    for level in [0, 1, last / 2, last] {
        for filter in DisplayFilter::ALL {
            let displayed = all.display(level, filter, RepairOptions::default(), &()).unwrap();
            assert_eq!(
                (displayed.metrics.triangles, displayed.proven),
                (all.triangle_count(level).unwrap(), true)
            );
            let encoded = all.encode(&model, &displayed, &encode::Options::new(Format::Glb), &()).unwrap();
            assert_eq!(encoded.faces, Some(displayed.metrics.triangles));
        }
    }
    let above = all.display(last + 1, DisplayFilter::Linked, RepairOptions::default(), &());
    assert!(matches!(above, Err(Error::Level { .. })));
}

#[test]
fn strips_of_another_model_are_refused() {
    let (model, mut strips) = (two_parts(), Strips::default());
    strips.push(&[0, 1, 1000]);
    let prepared = PreparedModel::new(&model, false);
    let both = [strips.clone(), strips.clone()];
    assert!(matches!(prepared.prove(&both), Err(Error::Unproven { .. })));
    assert!(matches!(prepared.prove(&both[..1]), Err(Error::Unproven { .. })));
    assert!(prepared.metrics(&both, &StripifyOptions::default()).is_err());
    assert!(ModelLevels::from_strips(&prepared, &both, &levels::Options::default(), &()).is_err());
    assert!(ModelLevels::from_strips(&prepared, &both[..1], &levels::Options::default(), &()).is_err());
    let all = levels::run(&model, &levels::Options::default(), &()).unwrap().model;
    assert!(all.parts[0].outward(&strips).is_err());
}

#[test]
fn converted_strips_stay_strips_and_faces_stay_faces() {
    let model = two_parts();
    let faces = convert::run(&model, &convert::Options::new(Format::Ply), &()).unwrap();
    assert!(faces.strips.is_none());
    let strips =
        convert::run(&model, &convert::Options::new(Format::Glb).with_layout(Layout::Degenerate), &())
            .unwrap();
    assert!(strips.drawn.iter().all(Option::is_some));
    let again = read(&strips.encoded.bytes, Format::Glb).unwrap();
    let kept = convert::run(&again, &convert::Options::new(Format::Ply), &()).unwrap();
    assert!(kept.drawn.iter().all(Option::is_some));
    let as_list = convert::run(&again, &convert::Options::new(Format::Obj), &()).unwrap();
    assert!(as_list.strips.is_none());
}

/// Cancels at the stage with an index, and stops searches at once.
struct Stopping {
    cancel_at: usize,
    stages: Mutex<Vec<Stage>>,
    searches: AtomicUsize,
}

impl Stopping {
    fn new(cancel_at: usize) -> Self {
        Self { cancel_at, stages: Mutex::default(), searches: AtomicUsize::new(0) }
    }
}

struct AtOnce<'a>(&'a AtomicUsize);

impl Watch for AtOnce<'_> {
    fn go_on(&self, _: Progress) -> bool {
        self.0.fetch_add(1, Ordering::Relaxed);
        false
    }
}

impl Search for AtOnce<'_> {
    fn stopped(&self) -> Option<SearchStop> {
        (self.0.load(Ordering::Relaxed) > 0).then_some(SearchStop::Interrupt)
    }
}

impl Observer for Stopping {
    fn stage(&self, stage: Stage) {
        self.stages.lock().unwrap().push(stage);
    }

    fn search(&self, _: &StripifyOptions) -> Box<dyn Search + '_> {
        Box::new(AtOnce(&self.searches))
    }

    fn is_cancelled(&self) -> bool {
        self.stages.lock().unwrap().len() >= self.cancel_at
    }
}

#[test]
fn an_observer_cancels_at_each_stage_and_stops_searches() {
    let model = two_parts();
    let best = StripifyOptions::default().with_method(Method::Best).with_effort(Effort::new(9).unwrap());
    let options = strip::Options::default().with_stripify(best);
    let run = |cancel_at| {
        let observer = Stopping::new(cancel_at);
        let result = strip::run(&model, &options, &observer);
        (result, observer.stages.into_inner().unwrap())
    };
    let (stopped, stages) = run(usize::MAX);
    let stopped = stopped.unwrap();
    assert_eq!((stopped.stopped, stopped.proven), (Some(SearchStop::Interrupt), true));
    let expected =
        [Stage::Prepare, Stage::Survey, Stage::Stripify, Stage::Measure, Stage::Bound, Stage::Prove];
    assert_eq!(stages, expected);
    for count in 0..expected.len() {
        let (result, stages) = run(count);
        assert!(matches!(result, Err(Error::Cancelled)));
        assert_eq!(stages, expected[..count]);
    }
}

#[test]
fn a_view_whose_budget_rises_again_has_the_triangles_of_a_new_view_at_once() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../testdata/models/hand.ply");
    let model = read(&std::fs::read(path).unwrap(), Format::Ply).unwrap();
    let built = view_model::run(model, &view_model::Options::default(), &()).unwrap();
    let tree = Arc::new(built.model.vertex_tree().unwrap());
    let camera = Camera::new([0.0, 0.0, 1.0], [0.0; 3]).unwrap();
    let criteria = ViewCriteria::default().with_pixels(0.01).with_frustum(false);
    let mut view = tree.view();
    for budget in [1278, 7192, 15_982] {
        let mut new = tree.view();
        for view in [&mut view, &mut new] {
            view.update(&camera, &criteria.with_budget(budget)).unwrap();
        }
        let [found, expected] = [&view, &new].map(SkipView::triangle_count);
        assert!(found == expected && found <= budget, "{budget}: {found}, a new view has {expected}");
        assert!(100 * found >= 98 * budget, "{budget}: {found}");
    }
}
