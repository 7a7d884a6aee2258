//! Simplifies the parts of a model toward one goal. The triangle budget applies to the whole model,
//! and each part keeps the triangles that it needs.
//!
//! Parts that are simplified as one surface are a *group*. In a scene with a dense and a coarse
//! group, the best result comes from always applying the cheapest collapse of the scene. The dense
//! group then loses most of the triangles, and both groups end with about the same error.
//!
//! ```text
//! cost  │      ╱ coarse group    every group is simplified to the cost c, the least at
//!   c ┄┄┼┄┄┄┄╱┄┄┄┄┄┄┄┄╱┄┄┄┄      which all groups together have few enough triangles
//!       │  ╱       ╱  dense group
//!       └───────────────────▶ triangles dropped
//! ```
//! # Algorithm
//! Within a group, collapses are ordered by a cost that includes attributes. It is converted to
//! scene units at the largest scale of the group. The cost of a step of a group is the maximum cost
//! up to this step.
//! 1. In each round, take the groups with the lowest costs that together have half of the
//!    triangles, and remove 1/16 of the triangles of each group. Repeat until the total is low
//!    enough, or no collapse is left.
//! 2. The total is now too low if some groups are ahead of others. Find the common cost c from the
//!    triangles that each group dropped per round. Groups that are behind continue to c.
//! 3. Merge the steps of all groups by cost, with ties by group index ([`LevelOrder`]), and cut off
//!    where the goal is reached.
//!
//! No group is simplified much further than necessary. A model with one group, or without a
//! triangle goal, needs no rounds.
//!
//! # Complexity
//! One simplification per group, with about 1/16 more work than necessary. All groups are in memory
//! at once, with 260 bytes per triangle.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use rayon::prelude::*;
use tristrip::simplify::{self, AttributeWeights, JoinedSimplification, Price, Stopped, SurfaceSimplifier};
use tristrip::{CollapseSequence, Error as MeshError, Mesh};

use super::order::{LevelOrder, PartCollapses};
use super::parts::{Part, diagonal};
use super::vanishing::Vanishing;
use crate::collapses::{Collapses, KeptVertices, percent_of};
use crate::error::Error;
use crate::goal::Deviation;
use crate::observer::{Observer, SimplifyProgress};
use crate::parts::map;
use crate::places::SAME_SCALE;

/// The fraction of its triangles that a group drops in a round, as a divisor, and the minimum
/// number.
const ROUND: (usize, usize) = (16, 4);
/// The same values for the interval between progress calls, for a group that needs no rounds.
const WATCHED_ROUND: (usize, usize) = (16, 1000);

/// The constraints on collapses, and their cost function.
///
/// ```
/// use tristrip_pipeline::{simplify::CollapseRules, simplify};
/// let tiles = CollapseRules { lock_borders: true, ..CollapseRules::default() };
/// assert!(!tiles.permissive && simplify::Options::default().with_rules(tiles).rules == tiles);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CollapseRules {
    /// The weights of vertex attributes.
    pub weights: AttributeWeights,
    /// The cost function of collapses.
    pub price: Price,
    /// Whether holes may close, handles may vanish, and seams may merge. Use this for very small
    /// results.
    pub permissive: bool,
    /// Whether border vertices are kept, for example to keep terrain tiles aligned.
    pub lock_borders: bool,
    /// The maximum distance, in the scene, between two sides of a border that collapse together; 0
    /// requires equal positions. Errors may be larger by this distance.
    pub weld_distance: Deviation,
}

impl Default for CollapseRules {
    /// Welds sides that differ by rounding: one millionth of the diagonal.
    fn default() -> Self {
        Self {
            weights: AttributeWeights::default(),
            price: Price::default(),
            permissive: false,
            lock_borders: false,
            weld_distance: Deviation::Percent(1e-4),
        }
    }
}

/// The number of triangles to keep.
#[derive(Debug, Clone, Copy)]
pub(crate) enum TriangleGoal<'a> {
    /// As few as the error limit allows.
    Fewest,
    /// A number for the whole model.
    OfModel(usize),
    /// A number for each part. The numbers of parts that are simplified as one surface are added.
    OfParts(&'a [usize]),
}

/// The collapses of all parts of a model.
pub(crate) struct AllCollapses {
    /// The collapses of each part, in the order of the parts.
    pub(crate) parts: Vec<PartCollapses>,
    /// Why more triangles than requested remain; `None` if they do not.
    pub(crate) stopped: Option<Stopped>,
    /// The number of removed components.
    vanished: usize,
    /// The requested number of triangles.
    goal: Option<usize>,
    /// The maximum allowed error, in the scene.
    error: Option<f32>,
    /// Whether the observer stopped the collapses before the goal was reached.
    pub(crate) interrupted: bool,
}

/// Reports progress to the observer, and records whether it stops the collapses.
struct Watched<'a> {
    observer: &'a dyn Observer,
    before: usize,
    goal: usize,
    left: AtomicUsize,
    is_interrupted: AtomicBool,
}

impl Watched<'_> {
    /// Counts triangles that a group has dropped. Returns whether the collapses continue.
    fn goes_on(&self, dropped: usize) -> bool {
        let left = self.left.fetch_sub(dropped, Ordering::Relaxed) - dropped;
        let progress = SimplifyProgress { before: self.before, left, goal: self.goal };
        if left > self.goal && !self.observer.simplifies(progress) {
            self.is_interrupted.store(true, Ordering::Relaxed);
        }
        !self.is_interrupted()
    }

    fn is_interrupted(&self) -> bool {
        self.is_interrupted.load(Ordering::Relaxed)
    }
}

/// Simplifies all parts until they have at most the requested number of triangles together. Stops
/// earlier if the error in the scene would exceed the maximum, or if the observer stops it. With a
/// maximum error, small components may be removed.
pub(crate) fn simplify_all(
    parts: &[Part<'_>],
    goal: TriangleGoal<'_>,
    error: Option<f32>,
    rules: CollapseRules,
    observer: &dyn Observer,
) -> Result<AllCollapses, Error> {
    let members = groups_of(parts);
    let requested = match goal {
        TriangleGoal::Fewest => None,
        TriangleGoal::OfModel(count) => Some(count),
        TriangleGoal::OfParts(counts) => Some(counts.iter().sum()),
    };
    let before = parts.iter().map(Part::triangle_count).sum();
    let watched = Watched {
        observer,
        before,
        goal: requested.unwrap_or(0),
        left: before.into(),
        is_interrupted: false.into(),
    };
    // 1. Each group, to its own goal or to the common cost.
    let shared = match goal {
        TriangleGoal::OfModel(count) if count > 0 && members.len() > 1 => Some(count),
        _ => None,
    };
    let done: Vec<Result<FinishedGroup, MeshError>> = if let Some(count) = shared {
        let groups = map(&members, |members| SurfaceGroup::new(parts, members, error, rules));
        let mut groups = groups.into_iter().collect::<Result<Vec<_>, _>>()?;
        share(&mut groups, count, &watched);
        let is_reached = triangle_count(&groups) <= count || watched.is_interrupted();
        groups.into_par_iter().map(|group| group.finish(parts, 0, is_reached)).collect()
    } else {
        map(&members, |members| {
            let mut group = SurfaceGroup::new(parts, members, error, rules)?;
            let count = match goal {
                TriangleGoal::Fewest => 0,
                TriangleGoal::OfModel(count) => count,
                TriangleGoal::OfParts(counts) => members.iter().map(|&part| counts[part]).sum(),
            };
            let is_reached = group.simplify_to(count, &watched) || matches!(goal, TriangleGoal::Fewest);
            group.finish(parts, count, is_reached)
        })
    };
    // 2. In the order of the parts.
    let mut all: Vec<Option<PartCollapses>> = vec![None; parts.len()];
    let (mut small, mut stopped) = (Vec::with_capacity(members.len()), None);
    for (members, done) in members.iter().zip(done) {
        let done = done?;
        members.iter().zip(done.parts).for_each(|(&part, done)| all[part] = Some(done));
        small.push(done.small);
        stopped = sum(stopped, done.stopped);
    }
    let mut done: Vec<PartCollapses> = all.into_iter().flatten().collect();
    // 3. Undo the excess collapses.
    if let Some(count) = shared {
        let order = LevelOrder::new(&done);
        let levels = order.of_parts(order.level_of_triangles(&done, count)?)?;
        done = done
            .into_iter()
            .zip(levels)
            .map(|(done, level)| done.with_base(level))
            .collect::<Result<_, _>>()?;
    }
    let mut vanished = 0;
    for (members, small) in members.iter().zip(small) {
        vanished += small.count(members.iter().map(|&part| &done[part].sequence))?;
    }
    let interrupted = watched.is_interrupted();
    Ok(AllCollapses { parts: done, stopped, vanished, goal: requested, error, interrupted })
}

/// Returns the parts of each group. Groups and parts are in ascending order.
pub(super) fn groups_of(parts: &[Part<'_>]) -> Vec<Vec<usize>> {
    let mut members: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    parts.iter().enumerate().for_each(|(number, part)| members.entry(part.group()).or_default().push(number));
    members.into_values().collect()
}

/// Simplifies groups until they have at most this number of triangles together. All groups end at
/// about the same cost, and none is simplified further than needed.
fn share(groups: &mut [SurfaceGroup<'_>], count: usize, watched: &Watched<'_>) {
    // 1. In rounds, the groups with the lowest costs.
    while triangle_count(groups) > count {
        let mut open: Vec<usize> = (0..groups.len()).filter(|&group| !groups[group].is_done).collect();
        if open.is_empty() {
            return;
        }
        open.sort_by(|&a, &b| groups[a].cost().total_cmp(&groups[b].cost()));
        let half = open.iter().map(|&group| groups[group].surface.triangle_count()).sum::<usize>() / 2;
        let mut before = 0;
        for group in open {
            groups[group].is_next = before <= half;
            before += groups[group].surface.triangle_count();
        }
        groups.par_iter_mut().filter(|group| group.is_next).for_each(|group| group.go_on(watched));
        if watched.is_interrupted() {
            return;
        }
    }
    // 2. The common cost, and the groups that are behind it.
    let mut rounds: Vec<(f64, usize)> =
        groups.iter().flat_map(|group| group.rounds.iter().copied()).collect();
    rounds.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut left: usize = groups.iter().map(|group| group.full_count).sum();
    let enough = rounds.iter().find(|&&(_, dropped)| {
        left -= dropped;
        left <= count
    });
    if let Some(&(cost, _)) = enough {
        groups.par_iter_mut().for_each(|group| {
            while !group.is_done && group.cost() < cost && !watched.is_interrupted() {
                group.go_on(watched);
            }
        });
    }
}

/// Returns the number of triangles after a round that drops a fraction of them, but at least a
/// minimum.
fn after_round(triangles: usize, (share, least): (usize, usize)) -> usize {
    triangles.saturating_sub((triangles / share).max(least))
}

/// Returns the total number of triangles of all groups.
fn triangle_count(groups: &[SurfaceGroup<'_>]) -> usize {
    groups.iter().map(|group| group.surface.triangle_count()).sum()
}

/// Parts that are simplified as one surface.
struct SurfaceGroup<'a> {
    members: &'a [usize],
    surface: SurfaceSimplifier<'a>,
    small: Vanishing,
    /// The scene cost that corresponds to a group cost of 1.
    cost_unit: f64,
    full_count: usize,
    /// The cost after each round, and the number of triangles dropped in it.
    rounds: Vec<(f64, usize)>,
    /// Whether the group takes part in this round.
    is_next: bool,
    /// Whether no collapse is left.
    is_done: bool,
}

/// The collapses of a group.
struct FinishedGroup {
    parts: Vec<PartCollapses>,
    small: Vanishing,
    stopped: Option<Stopped>,
}

impl<'a> SurfaceGroup<'a> {
    fn new(
        parts: &'a [Part<'_>],
        members: &'a [usize],
        error: Option<f32>,
        rules: CollapseRules,
    ) -> Result<Self, MeshError> {
        let of_group = || members.iter().map(|&part| &parts[part]);
        let (first, mut small) = (&parts[members[0]], Vanishing::default());
        let mut options = simplify::SimplifyOptions::default()
            .with_weights(rules.weights)
            .with_price(rules.price)
            .with_permissive(rules.permissive)
            .with_locked_borders(rules.lock_borders)
            .with_weld_distance(first.weld_distance())
            .with_locked(locked(of_group()));
        if let Some(error) = error {
            let error = first.own_error(error);
            let surfaces: Vec<(&Mesh, &[u32])> =
                of_group().map(|part| (&*part.compact.mesh, part.triangles())).collect();
            small = Vanishing::new(&surfaces, error.into())?;
            options = options.with_error(error).with_vanishing(small.errors.clone());
        }
        let surfaces = of_group().map(|part| (part.seen(), part.triangles())).collect();
        let surface = SurfaceSimplifier::new(surfaces, &options)?;
        let (scale, full_count) = (first.scale(), surface.triangle_count());
        Ok(Self {
            members,
            surface,
            small,
            cost_unit: rules.price.cost_unit(scale),
            full_count,
            rounds: Vec::new(),
            is_next: false,
            is_done: false,
        })
    }

    /// Returns the maximum cost so far, in the scene.
    fn cost(&self) -> f64 {
        self.surface.cost() * self.cost_unit
    }

    /// Runs one round.
    fn go_on(&mut self, watched: &Watched<'_>) {
        let before = self.surface.triangle_count();
        let goal = after_round(before, ROUND);
        self.is_done = !self.surface.simplify_to(goal) || goal == 0;
        let dropped = before - self.surface.triangle_count();
        (self.rounds).push((self.cost(), dropped));
        self.is_next = false;
        watched.goes_on(dropped);
    }

    /// Simplifies the group until it has at most `count` triangles, no collapse is possible, or the
    /// observer stops it. Returns `false` only if no collapse was possible before the count was
    /// reached.
    fn simplify_to(&mut self, count: usize, watched: &Watched<'_>) -> bool {
        loop {
            let before = self.surface.triangle_count();
            let goal = after_round(before, WATCHED_ROUND).max(count);
            let goes_on = self.surface.simplify_to(goal);
            let after = self.surface.triangle_count();
            if !watched.goes_on(before - after) {
                return true;
            }
            if !goes_on || after <= count {
                return after <= count;
            }
        }
    }

    /// Returns the collapses of each part, cut off at this total number of triangles. If the goal
    /// of the model is not reached, also returns the reasons.
    fn finish(
        mut self,
        parts: &[Part<'_>],
        triangle_count: usize,
        is_reached: bool,
    ) -> Result<FinishedGroup, MeshError> {
        let stopped = (!is_reached).then(|| self.surface.stopped());
        let JoinedSimplification { sequences, steps, costs, .. } = self.surface.finish(triangle_count)?;
        let of_part = |((&part, sequence), steps): ((&usize, CollapseSequence), Vec<u32>)| {
            let costs = steps.iter().map(|&step| costs[step as usize] * self.cost_unit).collect();
            let scale = parts[part].scale();
            let is_scaled = (scale - 1.0).abs() >= SAME_SCALE;
            let sequence = if is_scaled { sequence.with_scaled_errors(scale)? } else { sequence };
            Ok::<_, MeshError>(PartCollapses { sequence, group: parts[part].group(), steps, costs })
        };
        let parts = self.members.iter().zip(sequences).zip(steps).map(of_part).collect::<Result<_, _>>()?;
        Ok(FinishedGroup { parts, small: self.small, stopped })
    }
}

/// Returns which vertices of some parts are locked, concatenated in the order of the parts; empty
/// if none are.
fn locked<'a>(parts: impl Iterator<Item = &'a Part<'a>> + Clone) -> Vec<bool> {
    let mut all = Vec::new();
    if parts.clone().any(|part| !part.locked().is_empty()) {
        for part in parts {
            let end = all.len() + part.compact.mesh.vertex_count();
            all.extend_from_slice(part.locked());
            all.resize(end, false);
        }
    }
    all
}

/// Adds the reasons of two groups.
fn sum(a: Option<Stopped>, b: Option<Stopped>) -> Option<Stopped> {
    let (Some(mut sum), Some(b)) = (a, b) else { return a.or(b) };
    sum.triangle_count += b.triangle_count;
    sum.locked += b.locked;
    sum.non_manifold += b.non_manifold;
    sum.seam += b.seam;
    sum.topology += b.topology;
    sum.fold_over += b.fold_over;
    sum.error += b.error;
    Some(sum)
}

impl AllCollapses {
    /// Returns the summary of the collapses of all parts.
    pub(crate) fn summary(&self, parts: &[Part<'_>]) -> Result<Collapses, Error> {
        let after = self.parts.iter().map(|done| done.sequence.triangle_count(0));
        let errors = self.parts.iter().map(|done| done.sequence.error(0));
        let surface_error = errors.collect::<Result<Vec<f32>, _>>()?.into_iter().fold(0.0, f32::max);
        let diagonal = diagonal(parts);
        Ok(Collapses {
            collapse_count: self.step_count(),
            triangles_before: parts.iter().map(Part::triangle_count).sum(),
            triangles_after: after.sum::<Result<usize, _>>()?,
            target_triangles: self.goal,
            target_error: self.error,
            reached: self.stopped.is_none() && !self.interrupted,
            vertices_kept: self.stopped.map(KeptVertices::from),
            surface_error,
            surface_error_percent: percent_of(surface_error.into(), diagonal),
            diagonal,
            vanished_components: self.vanished,
            locked_vertices: parts.iter().map(Part::locked_count).sum(),
        })
    }

    /// Counts the collapses of all groups. Collapses of different parts that close a border
    /// together count once.
    fn step_count(&self) -> usize {
        let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
        for part in &self.parts {
            let count = counts.entry(part.group).or_default();
            *count = part.steps.last().map_or(0, |&step| step as usize + 1).max(*count);
        }
        counts.into_values().sum()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::places::{Place, Places};
    use tristrip::{Attribute, AttributeData, Faces};

    /// Returns a grid of width × width squares over the unit square, with a height function.
    fn grid(width: u32, height: impl Fn(f64, f64) -> f64) -> (Mesh, Vec<u32>) {
        let at = |i: u32| [i % (width + 1), i / (width + 1)].map(|x| f64::from(x) / f64::from(width));
        let positions: Vec<[f32; 3]> = (0..(width + 1) * (width + 1))
            .map(|i| [at(i)[0] as f32, at(i)[1] as f32, height(at(i)[0], at(i)[1]) as f32])
            .collect();
        let square = |i: u32| {
            let v = i / width * (width + 1) + i % width;
            [v, v + 1, v + width + 1, v + width + 1, v + 1, v + width + 2]
        };
        (Mesh::new(positions, Faces::default()).unwrap(), (0..width * width).flat_map(square).collect())
    }

    fn bumps(x: f64, y: f64) -> f64 {
        let (x, y) = (x - 0.47, y - 0.52);
        0.3 * x * x * x - 0.2 * y * y + 0.11 * x * y
    }

    /// Returns parts in a row, each with its own scale.
    fn in_a_row(meshes: &[(Mesh, Vec<u32>)], scales: &[f64]) -> Places {
        let row = |(i, &s): (usize, &f64)| {
            let place = [[s, 0.0, 0.0, 20.0 * i as f64], [0.0, s, 0.0, 0.0], [0.0, 0.0, s, 0.0]];
            Arc::from([Place::new(place)])
        };
        let lists = scales.iter().enumerate().map(row).collect();
        Places { lists, of_part: (0..meshes.len()).collect(), problem: None }
    }

    fn parts<'a>(meshes: &'a [(Mesh, Vec<u32>)], scales: &[f64]) -> Vec<Part<'a>> {
        let drawn = meshes.iter().map(|(mesh, triangles)| (mesh, triangles.clone())).collect();
        Part::of_all(drawn, &in_a_row(meshes, scales), Deviation::Units(0.0)).unwrap().0
    }

    fn counts(all: &AllCollapses) -> Vec<usize> {
        all.parts.iter().map(|done| done.sequence.triangle_count(0).unwrap()).collect()
    }

    #[test]
    fn a_common_goal_is_the_order_by_cost_cut_off() {
        let meshes = [grid(24, bumps), grid(6, |x, y| bumps(y, x)), grid(11, |x, y| 2.0 * bumps(x, y))];
        let parts = parts(&meshes, &[1.0, 3.0, 0.5]);
        let all = |goal| {
            simplify_all(&parts, TriangleGoal::OfModel(goal), None, CollapseRules::default(), &()).unwrap()
        };
        let full = all(0);
        let order = LevelOrder::new(&full.parts);
        for goal in [1460, 1300, 1000, 700, 300, 100, 40] {
            let levels = order.of_parts(order.level_of_triangles(&full.parts, goal).unwrap()).unwrap();
            let expected: Vec<Vec<[u32; 3]>> = full
                .parts
                .iter()
                .zip(levels)
                .map(|(done, level)| done.sequence.drawn(level).unwrap())
                .collect();
            let shared = all(goal);
            let found: Vec<Vec<[u32; 3]>> =
                shared.parts.iter().map(|done| done.sequence.drawn(0).unwrap()).collect();
            assert!(found == expected, "{goal}: found {:?}", counts(&shared));
            assert!((goal - 1..=goal).contains(&counts(&shared).iter().sum()), "{goal}");
            assert_eq!(shared.stopped, None);
        }
    }

    #[test]
    fn a_dense_part_gives_the_triangles_and_a_coarse_one_keeps_its_own() {
        let meshes = [grid(40, bumps), grid(4, bumps)];
        let of_scale = |scale: f64| {
            let parts = parts(&meshes, &[1.0, scale]);
            counts(
                &simplify_all(&parts, TriangleGoal::OfModel(600), None, CollapseRules::default(), &())
                    .unwrap(),
            )
        };
        assert_eq!(of_scale(1.0)[1], 32, "nothing of the coarse part");
        // Objects that are small in the scene may be coarse.
        let [small, tiny] = [0.1, 0.01].map(|scale| of_scale(scale)[1]);
        assert!(tiny < small && small < 32, "{tiny} {small}");
    }

    #[test]
    fn a_flat_part_keeps_its_colours() {
        let (plain, painted) = (grid(20, bumps), grid(20, |_, _| 0.0));
        let shade = |p: &[f32; 3]| [p[0] * (2.0 - p[1]), p[1] * p[0] * p[0], p[1]];
        let data = AttributeData::F32(painted.0.positions().iter().flat_map(shade).collect());
        let colours = Attribute { name: "COLOR_0".into(), components: 3, normalized: false, data };
        let painted = (painted.0.with_attribute(colours).unwrap(), painted.1);
        let meshes = [plain, painted];
        let parts = parts(&meshes, &[1.0, 1.0]);
        let all =
            simplify_all(&parts, TriangleGoal::OfModel(400), None, CollapseRules::default(), &()).unwrap();
        assert!(counts(&all)[1] > 50, "{:?}", counts(&all));
        assert!(all.parts[1].sequence.error(0).unwrap() < 1e-6, "by its error it would have two triangles");
    }

    #[test]
    fn what_holds_a_model_above_its_goal_is_summed_over_the_groups() {
        let meshes = [grid(8, bumps), grid(12, bumps)];
        let parts = parts(&meshes, &[1.0, 2.0]);
        let all = simplify_all(&parts, TriangleGoal::OfModel(20), Some(1e-4), CollapseRules::default(), &())
            .unwrap();
        let (stopped, summary) = (all.stopped.unwrap(), all.summary(&parts).unwrap());
        assert_eq!(stopped.triangle_count, counts(&all).iter().sum::<usize>());
        assert_eq!((summary.triangles_after, summary.reached), (stopped.triangle_count, false));
        assert!(stopped.error > 0 && summary.surface_error <= 1e-4);
    }

    #[test]
    fn errors_are_those_in_the_scene() {
        let (mesh, triangles) = grid(12, bumps);
        let simplified = |scale: f64, error: f32| {
            let large = Place::new([[scale, 0.0, 0.0, 0.0], [0.0, 0.0, scale, 0.0], [0.0, -scale, 0.0, 5.0]]);
            let places =
                Places { lists: vec![Arc::from([Place::IDENTITY, large])], of_part: vec![0], problem: None };
            let (parts, _) =
                Part::of_all(vec![(&mesh, triangles.clone())], &places, Deviation::Units(0.0)).unwrap();
            let shown = parts[0].shown(&parts[0].compact.mesh).unwrap();
            assert!((f64::from(shown.positions()[12][0]) - scale.max(1.0)).abs() < 1e-3);
            let all = simplify_all(&parts, TriangleGoal::Fewest, Some(error), CollapseRules::default(), &())
                .unwrap();
            assert_eq!(all.stopped, None);
            all.parts.into_iter().next().unwrap().sequence
        };
        let (one, ten) = (simplified(1.0, 0.01), simplified(10.0, 0.1));
        assert_eq!(one.drawn(0).unwrap(), ten.drawn(0).unwrap());
        let errors = [&one, &ten].map(|sequence| f64::from(sequence.error(0).unwrap()));
        assert!((errors[1] / errors[0] - 10.0).abs() < 1e-4, "{errors:?}");
        assert!(simplified(10.0, 0.01).len() < one.len());
        assert_eq!(simplified(0.0, 0.01).len(), one.len(), "the copy of scale 1 counts");
    }
}
