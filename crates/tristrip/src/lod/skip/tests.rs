use std::collections::HashSet;
use std::sync::Arc;

use proptest::prelude::*;

use super::*;
use crate::collapse::Rename;
use crate::lod::filter::Filter;
use crate::lod::samples::{Sample, samples, sorted};
use crate::mesh::{canonical_triangle, canonical_triangles};
use crate::random::Random;

/// Returns scattered positions, reproducible by seed.
fn positions(count: usize, seed: u64) -> Vec<[f32; 3]> {
    let mut random = Random::new(seed);
    (0..count).map(|i| [(i % 6) as f32, random.below(100) as f32 / 100.0, (i / 6) as f32]).collect()
}

/// Returns a model of the collapses of a sample, with random errors and positions.
pub(super) fn model(sample: &Sample, seed: u64) -> Arc<SkipStrips> {
    let mut random = Random::new(seed);
    let collapses: Vec<_> =
        sample.sequence.iter().map(|c| (c.renames, random.below(100) as f32 / 1000.0)).collect();
    let (count, list) = (sample.sequence.vertex_count(), sample.sequence.triangles().to_vec());
    let sequence = CollapseSequence::from_collapses(count, list, collapses).unwrap();
    Arc::new(SkipStrips::new(&sample.strips, &sequence, &positions(count, seed)[..]).unwrap())
}

/// Returns a random camera around the grid.
pub(super) fn camera(random: &mut Random) -> Camera {
    let mut at = |size: usize| random.below(1000) as f32 / 1000.0 * size as f32;
    let eye = [at(30) - 12.0, at(12) - 4.0, at(30) - 12.0];
    let look_at = [at(6), at(1), at(6)];
    let camera = Camera::new(eye, look_at).unwrap();
    camera.with_field_of_view(10.0 + at(90)).unwrap().with_image(160, 90).unwrap()
}

/// Returns a random foveation.
fn foveation(random: &mut Random) -> Foveation {
    let growth = [0.0, 1e-30, 0.01, 0.1, 0.5, 3.0][random.below(6)];
    let attention = [0; 2].map(|_| random.below(101) as f32 / 100.0);
    Foveation::new(growth).unwrap().with_attention(attention).unwrap()
}

/// Returns criteria, some of them disabled at random.
pub(super) fn criteria(random: &mut Random) -> ViewCriteria {
    let criteria = ViewCriteria::default().with_pixels(random.below(300) as f32 / 100.0);
    let criteria = criteria.with_frustum(random.coin()).with_back_faces(random.coin());
    let criteria = criteria.with_silhouettes(random.coin());
    let criteria = if random.coin() { criteria.with_foveation(foveation(random)) } else { criteria };
    if random.coin() { criteria.with_light([1.0, 2.0, 0.5]) } else { criteria }
}

/// Checks that a view draws its renamed triangles, and that the dependencies of each applied
/// collapse are applied.
fn check(view: &SkipView) -> Result<(), TestCaseError> {
    let oracle = sorted(view.renamed_triangles());
    prop_assert_eq!(view.triangle_count(), oracle.len());
    prop_assert_eq!(sorted(view.display_strips().triangles()), oracle);
    let model = view.model();
    for collapse_id in model
        .order
        .iter()
        .filter_map(|collapse_id| collapse_id.get())
        .filter(|&collapse_id| view.is_collapsed(collapse_id))
    {
        prop_assert!(model.dependencies.needed(collapse_id).all(|needed| view.is_collapsed(needed)));
    }
    let active = (0..model.tree.len() as u32).filter(|&node| !view.is_collapsed(node)).count();
    prop_assert_eq!(view.active_vertex_count(), active);
    Ok(())
}

proptest! {
    #[test]
    fn views_draw_what_they_say(sample in samples(), seed in any::<u64>(), filter in 0..4_usize) {
        let model = model(&sample, seed);
        let mut random = Random::new(seed ^ 1);
        let mut view = model.view_by(Filter::ALL[filter]);
        check(&view)?;
        let criteria = criteria(&mut random);
        let mut buffer = view.indices().to_vec();
        for _ in 0..6 {
            let update = view.update(&camera(&mut random), &criteria).unwrap();
            prop_assert!(update.is_complete);
            check(&view)?;
            let simplified = view.simplified_strips();
            let drawn = canonical_triangles(simplified.triangles());
            prop_assert_eq!(drawn, canonical_triangles(view.renamed_triangles()));
            buffer.resize(view.indices().len(), 0);
            for range in update.changed {
                buffer[range.clone()].copy_from_slice(&view.indices()[range]);
            }
            prop_assert_eq!(&buffer, view.indices());
        }
        for _ in 0..3 {
            view.update(&camera(&mut random), &criteria).unwrap();
            let level = random.below(sample.sequence.len() + 1);
            view.set_level(level).unwrap();
            check(&view)?;
            prop_assert_eq!(sorted(view.renamed_triangles()), sorted(sample.sequence.drawn(level).unwrap()));
        }
    }

    /// The naive view evaluates every collapse in every frame.
    #[test]
    fn what_is_not_looked_at_would_not_change(sample in samples(), seed in any::<u64>(), steps in 1..40_usize) {
        let model = model(&sample, seed);
        let mut random = Random::new(seed ^ 2);
        let (mut view, mut naive) = (model.view(), model.view());
        let criteria = criteria(&mut random);
        let (from, to) = (camera(&mut random), camera(&mut random));
        for step in 0..=steps {
            let mix = |a: [f32; 3], b: [f32; 3]| {
                [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * step as f32 / steps as f32)
            };
            let Ok(camera) = Camera::new(mix(from.eye(), to.eye()), mix(from.look_at(), to.look_at())) else {
                continue;
            };
            view.update(&camera, &criteria).unwrap();
            naive.forget_schedule();
            naive.update(&camera, &criteria).unwrap();
            prop_assert!(view.collapses_done().eq(naive.collapses_done()), "step {}", step);
        }
    }

    /// The eye does not move. The gaze moves, and the camera turns for half of the seeds.
    #[test]
    fn what_is_not_looked_at_would_not_change_while_the_attention_moves(
        sample in samples(),
        seed in any::<u64>(),
        steps in 1..40_usize,
    ) {
        let model = model(&sample, seed);
        let mut random = Random::new(seed ^ 6);
        let (mut view, mut naive) = (model.view(), model.view());
        let criteria = criteria(&mut random);
        let [from, to] = [(); 2].map(|()| (camera(&mut random), foveation(&mut random)));
        let growth = 0.01 + random.below(100) as f32 / 100.0;
        for step in 0..=steps {
            let mix = |a: f32, b: f32| a + (b - a) * step as f32 / steps as f32;
            let attention = [0, 1].map(|k| mix(from.1.attention()[k], to.1.attention()[k]).clamp(0.0, 1.0));
            let look_at = [0, 1, 2].map(|k| mix(from.0.look_at()[k], to.0.look_at()[k]));
            let look_at = if seed % 2 == 0 { look_at } else { from.0.look_at() };
            let Ok(camera) = Camera::new(from.0.eye(), look_at) else { continue };
            let foveation = Foveation::new(growth).unwrap().with_attention(attention).unwrap();
            let criteria = criteria.with_foveation(foveation);
            view.update(&camera, &criteria).unwrap();
            naive.forget_schedule();
            naive.update(&camera, &criteria).unwrap();
            prop_assert!(view.collapses_done().eq(naive.collapses_done()), "step {}", step);
        }
    }

    /// A larger growth never needs more detail: each collapse that is allowed remains allowed.
    #[test]
    fn foveation_is_monotone(sample in samples(), seed in any::<u64>()) {
        let model = model(&sample, seed);
        let mut random = Random::new(seed ^ 7);
        let (camera, criteria) = (camera(&mut random), criteria(&mut random));
        let attention = foveation(&mut random).attention();
        let mut before: Option<HashSet<usize>> = None;
        for growth in [0.0, 0.05, 0.3, 2.0, 50.0] {
            let foveation = Foveation::new(growth).unwrap().with_attention(attention).unwrap();
            let mut view = model.view();
            view.update(&camera, &criteria.with_foveation(foveation)).unwrap();
            let done: HashSet<usize> = view.collapses_done().collect();
            prop_assert!(before.is_none_or(|before| before.is_subset(&done)), "growth {}", growth);
            before = Some(done);
        }
    }

    /// Dependencies: each triangle of a view exists at some level, so a view has no foldover that
    /// the simplification does not have.
    #[test]
    fn every_triangle_of_a_view_is_one_of_a_level(sample in samples(), seed in any::<u64>()) {
        let model = model(&sample, seed);
        let levels = (0..=sample.sequence.len()).flat_map(|level| sample.sequence.drawn(level).unwrap());
        let known: HashSet<[u32; 3]> = levels.map(canonical_triangle).collect();
        let mut random = Random::new(seed ^ 3);
        let mut view = model.view();
        for _ in 0..8 {
            view.update(&camera(&mut random), &criteria(&mut random)).unwrap();
            prop_assert!(view.renamed_triangles().into_iter().all(|t| known.contains(&canonical_triangle(t))));
        }
    }

    #[test]
    fn repaired_views_draw_what_they_say(sample in samples(), seed in any::<u64>()) {
        let model = model(&sample, seed);
        let options = crate::lod::RepairOptions::default();
        let mut view = RepairedView::new(&model, &sample.strips, sample.sequence.clone(), options).unwrap();
        let mut random = Random::new(seed ^ 5);
        for _ in 0..6 {
            view.update(&camera(&mut random), &criteria(&mut random)).unwrap();
            let oracle = sorted(view.view().renamed_triangles());
            prop_assert_eq!(sorted(view.strips().triangles()), oracle);
        }
    }

    #[test]
    fn budgets_and_steps_are_kept(sample in samples(), seed in any::<u64>(), budget in 0..60_usize, steps in 1..9_usize) {
        let model = model(&sample, seed);
        let mut random = Random::new(seed ^ 4);
        let (mut view, mut sliced) = (model.view(), model.view());
        let base = view.triangle_count();
        for _ in 0..5 {
            let (camera, criteria) = (camera(&mut random), criteria(&mut random));
            view.update(&camera, &criteria.with_budget(budget)).unwrap();
            prop_assert!(view.triangle_count() <= budget.max(base));
            check(&view)?;
            let mut updates = 0;
            while !sliced.update(&camera, &criteria.with_steps(steps)).unwrap().is_complete {
                check(&sliced)?;
                updates += 1;
                prop_assert!(updates < 1000);
            }
        }
    }
}

/// Returns the mesh of figure 12: two strips of ten vertices. Strip b lies below the drawn strip
/// and shares the vertices 2, 4, 6, 8 and 10 with it.
///
/// ```text
///  1 ── 3 ── 5 ── 7 ── 9
///  │ ╱  │ ╱  │ ╱  │ ╱  │
///  2 ── 4 ── 6 ── 8 ── 10
/// ```
fn figure() -> (Strips, CollapseSequence) {
    let mut strips = Strips::default();
    strips.push(&[1, 2, 3, 4, 5, 6, 7, 8, 9, 10]);
    strips.push(&[2, 11, 4, 12, 6, 13, 8, 14, 10, 15]);
    let renames = [(6, 5), (8, 7), (4, 3), (7, 5), (3, 5)].map(|(removed, kept)| [Rename { removed, kept }]);
    let collapses = renames.iter().map(|renames| (&renames[..], 0.0));
    let sequence = CollapseSequence::from_collapses(16, strips.to_list(), collapses).unwrap();
    (strips, sequence)
}

#[test]
fn figures_13_and_14() {
    let (strips, sequence) = figure();
    let (tree, numbers) = VertexTree::new(&sequence).unwrap();
    let node = |v: u32| numbers.of(v);
    // Pointers to the ancestors 1, 2 … steps up: 4 collapses to 3 and 3 to 5, so 4 has a pointer
    // that skips 3.
    assert_eq!((tree.ancestor(node(4), 0), tree.ancestor(node(4), 1)), (Some(node(3)), Some(node(5))));
    assert_eq!((tree.ancestor(node(6), 0), tree.ancestor(node(6), 1)), (Some(node(5)), None));
    let mut state = state::ViewState::full(&tree);
    assert!((1..16).all(|v| !state.is_collapsed(node(v))), "at full detail no parent pointer is active");
    let dependencies = Dependencies::new(&sequence, &tree, &numbers);
    for (v, into) in [(6, 5), (8, 7)] {
        assert!(state.can_collapse(node(v), &dependencies));
        state.collapse(node(v), &tree);
        assert_eq!(state.active_child(node(into)), Some(node(v)));
    }
    let done: Vec<u32> = (1..16).filter(|&v| state.is_collapsed(node(v))).collect();
    assert_eq!(done, [6, 8], "the parent pointers of 6 and 8 are active");
    let name = |state: &mut state::ViewState, v: u32| tree.vertex(state.representative(node(v), &tree));
    assert_eq!([5, 6, 7, 8, 9].map(|v| name(&mut state, v)), [5, 5, 7, 7, 9]);
    // 3 depends on 4, and 7 on 8: their neighbourhoods must be those at the time of the collapse.
    assert!(!state.can_collapse(node(3), &dependencies));
    for v in [4, 7, 3] {
        state.collapse(node(v), &tree);
    }
    assert_eq!([3, 4, 7, 8].map(|v| name(&mut state, v)), [5; 4]);
    assert_eq!(state.hops(node(4), &tree)[..2], [2, 2]);
    state.split(node(3), &tree);
    assert_eq!((name(&mut state, 4), state.active_child(node(5))), (3, Some(node(7))));
    let model = Arc::new(SkipStrips::of_levels(&strips, &sequence).unwrap());
    assert_eq!(model.view().triangle_count(), sequence.triangle_count(0).unwrap());
}

/// Figure 11: 2 collapses to 1, 4 to 3, and 3 to 1.
#[test]
fn figure_11() {
    let renames = [(2, 1), (4, 3), (3, 1)].map(|(removed, kept)| [Rename { removed, kept }]);
    let collapses = renames.iter().map(|renames| (&renames[..], 0.0));
    let triangles = vec![0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 1];
    let sequence = CollapseSequence::from_collapses(5, triangles, collapses).unwrap();
    let (tree, numbers) = VertexTree::new(&sequence).unwrap();
    let node = |v: u32| numbers.of(v);
    assert_eq!([2, 3, 4].map(|v| tree.parent(node(v))), [Some(node(1)), Some(node(1)), Some(node(3))]);
    assert_eq!(tree.parent(node(1)), None);
    // The children of 1, last first: 3, then 2.
    assert_eq!(tree.last_child(node(1)).get(), Some(node(3)));
    assert_eq!(tree.child_before(node(1), node(3)).get(), Some(node(2)));
    assert_eq!(tree.child_before(node(1), node(2)).get(), None);
    assert_eq!((tree.depth(), tree.end(node(1)) - node(1)), (2, 4));
}

/// Returns a terrain of n × n squares with hills, and its merge tree.
fn terrain(n: u32) -> (Vec<[f32; 3]>, Strips, CollapseSequence) {
    let height = |x: f32, z: f32| 3.0 * (x / 5.0).sin() * (z / 7.0).cos() + (x * z / 9.0).sin() / 4.0;
    let point = |i: u32| [(i % (n + 1)) as f32, (i / (n + 1)) as f32];
    let positions: Vec<[f32; 3]> =
        (0..(n + 1) * (n + 1)).map(point).map(|[x, z]| [x, height(x, z), z]).collect();
    let mut strips = Strips::default();
    for row in 0..n {
        let pair = |x: u32| [row * (n + 1) + x, (row + 1) * (n + 1) + x];
        strips.push(&(0..=n).flat_map(pair).collect::<Vec<_>>());
    }
    let faces = crate::Faces::from_triangles(strips.to_list()).unwrap();
    let mesh = crate::Mesh::new(positions.clone(), faces).unwrap();
    let options = crate::simplify::SimplifyOptions::default();
    let order = crate::simplify::MergeOrder::Quadric;
    let tree = crate::simplify::merge_tree(&mesh, strips.to_list(), order, &options).unwrap();
    (positions, strips, tree.sequence)
}

/// Returns a model of hills.
pub(super) fn hills(n: u32) -> Arc<SkipStrips> {
    let (positions, strips, sequence) = terrain(n);
    Arc::new(SkipStrips::new(&strips, &sequence, &positions[..]).unwrap())
}

#[test]
fn a_flight_over_a_terrain_is_exact_and_looks_at_little() {
    let model = hills(60);
    for filter in Filter::ALL {
        let mut view = model.view_by(filter);
        let criteria = ViewCriteria::default().with_pixels(4.0);
        let (mut looked_at, mut moved, mut segments) = (0, 0, 0);
        for frame in 0..60 {
            let x = frame as f32 / 4.0;
            let camera = Camera::new([x, 6.0, x], [x + 20.0, 0.0, x + 15.0]).unwrap();
            let update = view.update(&camera, &criteria).unwrap();
            check(&view).unwrap();
            if frame > 0 {
                looked_at += update.looked_at;
                moved += update.collapses + update.splits;
                segments += update.segments;
            }
        }
        assert!(moved > 500, "{moved}");
        assert!(looked_at < 59 * view.active_vertex_count() / 3, "{looked_at} looked at, {moved} moved");
        assert!(filter == Filter::Linked || segments < 30 * 120, "{segments} segments");
    }
}

/// A view has full detail near the gaze point and less elsewhere. Few collapses are evaluated while
/// the gaze moves.
#[test]
fn detail_is_where_somebody_looks() {
    let (positions, strips, sequence) = terrain(60);
    let model = Arc::new(SkipStrips::new(&strips, &sequence, &positions[..]).unwrap());
    // From above, with x to the right: the image is 41.4 units wide.
    let camera =
        Camera::new([30.0, 50.0, 30.0], [30.0, 0.0, 30.0]).unwrap().with_up([0.0, 0.0, -1.0]).unwrap();
    let camera = camera.with_image(1000, 1000).unwrap();
    let criteria = ViewCriteria::default().with_pixels(1.0).with_silhouettes(false);
    let mut sharp = model.view();
    sharp.update(&camera, &criteria).unwrap();
    let mut view = model.view();
    let near = |view: &SkipView, x: f32| {
        let is_near = |v: u32| {
            let [px, _, pz] = positions[v as usize];
            (px - x).abs().max((pz - 30.0).abs()) < 3.0
        };
        view.renamed_triangles().into_iter().filter(|triangle| triangle.iter().all(|&v| is_near(v))).count()
    };
    let (mut looked_at, frames) = (0, 100);
    for frame in 0..=frames {
        let x = 0.25 + 0.5 * frame as f32 / frames as f32;
        let foveation = Foveation::new(0.3).unwrap().with_attention([x, 0.5]).unwrap();
        let update = view.update(&camera, &criteria.with_foveation(foveation)).unwrap();
        looked_at += if frame > 0 { update.looked_at } else { 0 };
    }
    check(&view).unwrap();
    assert!(view.triangle_count() < sharp.triangle_count() / 2, "{}", view.triangle_count());
    assert!(looked_at < frames * view.active_vertex_count() / 2, "{looked_at}");
    // The gaze point is now at three quarters of the width.
    let [there, elsewhere] = [40.35, 19.65].map(|x| [near(&view, x), near(&sharp, x)]);
    assert!(there[0] * 10 > there[1] * 8 && elsewhere[0] * 3 < elsewhere[1], "{there:?} {elsewhere:?}");
}

#[test]
fn views_of_two_threads_are_those_of_one() {
    let model = hills(40);
    let fly = |model: &Arc<SkipStrips>, seed: u64| {
        let (mut view, mut random) = (model.view(), Random::new(seed));
        let mut buffers = Vec::new();
        for _ in 0..20 {
            view.update(&camera(&mut random), &ViewCriteria::default().with_pixels(2.0)).unwrap();
            buffers.push(view.indices().to_vec());
        }
        buffers
    };
    let alone = [1, 2].map(|seed| fly(&model, seed));
    let together = std::thread::scope(|scope| {
        let (fly, model) = (&fly, &model);
        let threads = [1, 2].map(|seed| scope.spawn(move || fly(model, seed)));
        threads.map(|thread| thread.join().unwrap())
    });
    assert_eq!(alone, together);
}

#[test]
fn views_from_anywhere_are_valid() {
    let (positions, strips, sequence) = terrain(12);
    let model = Arc::new(SkipStrips::new(&strips, &sequence, &positions[..]).unwrap());
    let mut view = model.view();
    let eyes = [[6.0, 0.5, 6.0], [1e30, 1e30, -1e30], [f32::MAX, 0.0, 0.0], [0.0, 1e-30, 0.0], positions[80]];
    for eye in eyes {
        for pixels in [0.0, 1.0, f32::INFINITY] {
            let camera = Camera::new(eye, [3.0, 0.0, 4.0]).unwrap();
            for up in [[0.0, 1.0, 0.0], [1e-38, 0.0, 0.0], [3.0, 1e30, 0.0]] {
                let camera = camera.with_up(up).unwrap().with_field_of_view(179.9).unwrap();
                let criteria = ViewCriteria::default().with_pixels(pixels);
                for growth in [0.0, f32::from_bits(1), f32::MAX] {
                    let criteria = criteria.with_foveation(Foveation::new(growth).unwrap());
                    view.update(&camera, &criteria).unwrap();
                    check(&view).unwrap();
                }
            }
        }
    }
    // Small steps after long travels, to which they could not be added without rounding errors.
    for step in 0..40 {
        let camera = Camera::new([6.0, 9.0 - step as f32 / 5.0, 6.0], [6.0, 0.0, 6.1]).unwrap();
        view.update(&camera, &ViewCriteria::default()).unwrap();
        let mut naive = view.clone();
        naive.forget_schedule();
        naive.update(&camera, &ViewCriteria::default()).unwrap();
        assert!(view.collapses_done().eq(naive.collapses_done()), "step {step}");
    }
    // With no error allowed the full mesh is drawn, except where it is flat or not visible.
    let all = ViewCriteria::default().with_pixels(0.0).with_frustum(false);
    view.update(&Camera::new([6.0, 9.0, 6.0], [6.0, 0.0, 6.1]).unwrap(), &all).unwrap();
    assert!(view.triangle_count() > 280, "{}", view.triangle_count());
    view.update(&Camera::new([6.0, 9.0, 6.0], [6.0, 20.0, 6.1]).unwrap(), &ViewCriteria::default()).unwrap();
    // Spheres of large collapses still reach into the image.
    assert!(view.triangle_count() < 60, "{}", view.triangle_count());
}

/// Flies through the hills and back, then stops. Returns the triangle counts of the frames after
/// the stop.
fn triangles_after_a_dive(pixels: f32, budget: usize) -> Vec<usize> {
    let mut view = hills(60).view();
    let criteria = ViewCriteria::default().with_pixels(pixels).with_budget(budget);
    let away = [30.0, 20.0, 90.0];
    let heights = (0..40).map(|frame| 30.0 - (frame as f32 - 20.0).abs());
    for x in heights {
        let eye = [x, 0.2, 30.0];
        view.update(&Camera::new(eye, [60.0, 0.0, 30.0]).unwrap(), &criteria).unwrap();
        assert!(view.triangle_count() <= budget);
    }
    let camera = Camera::new(away, [30.0, 0.0, 30.0]).unwrap();
    (0..30).map(|_| (view.update(&camera, &criteria).unwrap(), view.triangle_count()).1).collect()
}

#[test]
fn a_budget_is_used_again_after_the_eye_was_within_the_surface() {
    for budget in [300, 1500] {
        let counts = triangles_after_a_dive(0.01, budget);
        assert!(counts[20..].iter().all(|&count| 10 * count >= 8 * budget), "{budget}: {counts:?}");
    }
}

#[test]
fn without_an_allowed_error_a_budget_goes_where_the_errors_are_largest() {
    let model = hills(60);
    let least = ViewCriteria::default().with_pixels(0.0).with_budget(800);
    let cameras =
        [[-20.0, 15.0, 30.0], [80.0, 15.0, 30.0]].map(|eye| Camera::new(eye, [30.0, 0.0, 30.0]).unwrap());
    let drawn = |first: usize, then: usize| {
        let mut view = model.view();
        view.update(&cameras[first], &least).unwrap();
        for _ in 0..40 {
            view.update(&cameras[then], &least).unwrap();
        }
        (view.triangle_count(), view.collapses_done().collect::<HashSet<usize>>())
    };
    let [(count, there), (_, moved), (_, here)] = [drawn(1, 1), drawn(0, 1), drawn(0, 0)];
    assert!((640..=800).contains(&count), "{count}");
    // A view that came from another camera is closer to one that has always been here than to its
    // earlier state.
    let differ = |a: &HashSet<usize>, b: &HashSet<usize>| a.symmetric_difference(b).count();
    assert!(
        2 * differ(&moved, &there) < differ(&moved, &here),
        "{} {}",
        differ(&moved, &there),
        differ(&moved, &here)
    );
}

#[test]
fn a_larger_budget_is_used_by_the_next_update() {
    let model = hills(60);
    let camera = Camera::new([30.0, 20.0, 90.0], [30.0, 0.0, 30.0]).unwrap();
    let least = ViewCriteria::default().with_pixels(0.01);
    let new_view = |budget: usize| {
        let mut view = model.view();
        view.update(&camera, &least.with_budget(budget)).unwrap();
        view.triangle_count()
    };
    let mut view = model.view();
    let mut before = usize::MAX;
    for budget in [2000, 300, 700, 1500, 1500, 3000, 400, 5000] {
        view.update(&camera, &least.with_budget(budget)).unwrap();
        check(&view).unwrap();
        let found = view.triangle_count();
        assert!(found <= budget);
        if budget > before {
            let expected = new_view(budget);
            assert!(100 * found >= 95 * expected, "{budget}: {found}, a new view has {expected}");
        }
        before = budget;
    }
}
