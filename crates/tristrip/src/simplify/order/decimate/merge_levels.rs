//! Builds the levels of a merge tree; see the module `merge_tree`.

use super::Decimation;
use crate::collapse::CollapseSequence;
use crate::simplify::order::ahead::Pricers;
use crate::simplify::order::merge_tree::{MergeOrder, Spacing};
use crate::simplify::price::best_collapse::PricedCollapse;
use crate::simplify::price::priced_surface::PricedSurface;
use crate::simplify::price::search::PriceSearch;
use crate::simplify::surface::outcome::{CollapseOutcome, Outcomes};
use crate::simplify::surface::topology::PointKind;
use crate::vector::{Point, cross, dot, normal_of, sub};

/// In the quadric order, a level takes a maximal set among the cheapest 1/4 of the vertices. With
/// 1/2, 1/4 and 1/12, a view of the dragon at an error of one pixel has 38, 36 and 36 thousand
/// triangles, as many as with the passes of `simplify`, and the tree has 71, 93 and 183 levels.
const LIMIT_SHARE: [usize; 2] = [1, 4];

/// The share for collapses that only need to be apart. With 4/10, 7/10 and 10/10, a stream of the
/// bunny takes 24.5, 24.0 and 23.8 bits per vertex. After half of its bytes, the surface error is
/// 0.0079, 0.0084 and 0.0127 percent of the diagonal.
const LIMIT_SHARE_APART: [usize; 2] = [7, 10];

/// The minimum cosine of the angle between a triangle and the full mesh at its corners: 78 degrees.
/// Without this limit, triangles between three points of a straight border can stand upright next
/// to a terrain, and thin sheets fold over: in one view of a plane, 96 of 1000 edges were folded,
/// with the limit 10.
const MIN_COSINE: f64 = 0.2;

/// The state of the levels in addition to the surface.
struct MergeLevels {
    order: MergeOrder,
    spacing: Spacing,
    /// For each point, the area-weighted sum of the full mesh's normals at the points that it
    /// represents.
    normals: Vec<Point>,
    /// A factor for the cost of each point; empty if all are 1.
    factors: Vec<f32>,
}

impl MergeLevels {
    fn new(surface: &PricedSurface, order: MergeOrder, spacing: Spacing) -> Self {
        let mut normals = vec![[0.0; 3]; surface.topology.point_count()];
        for triangle in &surface.topology.triangles {
            let normal = normal_of(triangle.map(|p| surface.positions[p as usize]));
            for &p in triangle {
                add(&mut normals[p as usize], normal);
            }
        }
        Self { order, spacing, normals, factors: Vec::new() }
    }

    /// Returns whether a triangle would turn farther than allowed from the full mesh at one of its
    /// corners, and farther than before. Each collapse turns triangles by a small angle, but many
    /// of them could turn one over.
    fn turns_over(&self, surface: &PricedSurface, point: u32, to: u32) -> bool {
        let at = |p: u32| surface.positions[p as usize];
        let sum_at = |p: u32| self.normals[p as usize];
        // The normal that the kept point represents afterwards.
        let mut kept = sum_at(to);
        add(&mut kept, sum_at(point));
        let turns = |before: [Point; 2], after: [Point; 2]| {
            cosine(after[0], after[1]) < MIN_COSINE.min(cosine(before[0], before[1]))
        };
        let changed = surface.topology.opposite(point).iter().filter(|edge| !edge.contains(&to));
        let mut unchanged = surface.topology.opposite(to).iter().filter(|edge| !edge.contains(&point));
        changed.into_iter().any(|&[u, w]| {
            let edge = sub(at(w), at(u));
            let [before, after] = [point, to].map(|p| cross(edge, sub(at(p), at(u))));
            [u, w].iter().any(|&p| turns([before, sum_at(p)], [after, sum_at(p)]))
                || turns([before, sum_at(point)], [after, kept])
        }) || unchanged.any(|&[u, w]| {
            let normal = cross(sub(at(w), at(u)), sub(at(to), at(u)));
            turns([normal, sum_at(to)], [normal, kept])
        })
    }

    /// Returns the best collapse of a point.
    fn best(
        &self,
        surface: &PricedSurface,
        (search, outcomes): (&mut PriceSearch, &mut Outcomes),
        point: u32,
    ) -> Option<PricedCollapse> {
        if self.spacing == Spacing::Apart && surface.topology.kind(point) == PointKind::Irregular {
            return None;
        }
        let outcome = |to| match outcomes.of(&surface.topology, point, to) {
            CollapseOutcome::Keeps if self.turns_over(surface, point, to) => CollapseOutcome::Loses,
            outcome => outcome,
        };
        match self.order {
            MergeOrder::Quadric => search.best(surface, point, outcome),
            MergeOrder::ShortestEdge => search.nearest((surface, point), outcome),
        }
    }

    /// Returns a cost times the factor of its point.
    fn counted(&self, point: u32, cost: f32) -> f32 {
        self.factors.get(point as usize).map_or(cost, |factor| cost * factor)
    }

    fn collapse(&mut self, point: u32, to: u32) {
        let normal = self.normals[point as usize];
        add(&mut self.normals[to as usize], normal);
    }
}

/// Returns the cosine of the angle between two vectors; 1 if one of them has no direction.
fn cosine(a: Point, b: Point) -> f64 {
    let square = dot(a, a) * dot(b, b);
    if square > 0.0 { dot(a, b) / square.sqrt() } else { 1.0 }
}

fn add(sum: &mut Point, other: Point) {
    *sum = [0, 1, 2].map(|k| sum[k] + other[k]);
}

impl Decimation {
    /// Applies collapses level by level until at most `triangle_count` triangles remain or none is
    /// possible. Returns the number of collapses up to the end of each level.
    pub(crate) fn run_levels(
        &mut self,
        (order, spacing): (MergeOrder, Spacing),
        error_factors: &[f32],
        triangle_count: usize,
        sequence: &mut CollapseSequence,
    ) -> Vec<u32> {
        let count = self.surface.topology.point_count();
        let mut levels = MergeLevels::new(&self.surface, order, spacing);
        levels.factors = self.cost_factors(error_factors);
        let mut pricers = Pricers::new(count);
        let mut level_ends = Vec::new();
        // For each vertex, the last level that took an edge with an end at or next to it.
        let mut taken = vec![0_u32; count];
        let mut points: Vec<u32> = (0..count as u32).collect();
        let mut changed = points.clone();
        let mut chosen: Vec<(f32, u32)> = Vec::new();
        for level in 1.. {
            self.price_for_level(&levels, &mut pricers, &changed);
            changed.clear();
            points.retain(|&point| !self.surface.topology.ring(point).is_empty());
            let limit = self.cheapest(&levels, &points, &mut chosen);
            let before = sequence.len();
            for &(_, point) in &chosen {
                if self.triangle_count <= triangle_count {
                    break;
                }
                if taken[point as usize] == level {
                    continue;
                }
                let is_taken = |p: u32| spacing == Spacing::Disjoint && taken[p as usize] == level;
                let Some(collapse) = self.collapse_beside(&levels, point, is_taken) else { continue };
                // The best of the other targets can be much more expensive than the best target.
                if levels.counted(point, collapse.cost) > limit {
                    continue;
                }
                for p in [collapse.to, point] {
                    self.surface.topology.neighbours(p, &mut self.around);
                    for &q in self.around.iter().chain([&p]) {
                        if spacing == Spacing::Disjoint || p == point {
                            taken[q as usize] = level;
                        }
                        changed.push(q);
                    }
                }
                levels.collapse(point, collapse.to);
                self.apply(point, &collapse, sequence);
            }
            if sequence.len() == before {
                break;
            }
            level_ends.push(sequence.len() as u32);
            changed.sort_unstable();
            changed.dedup();
        }
        level_ends
    }

    /// Returns the cost factors of points, given the error factors of vertices. Costs have the unit
    /// of a volume, so their factors are cubed.
    fn cost_factors(&self, error_factors: &[f32]) -> Vec<f32> {
        if error_factors.is_empty() {
            return Vec::new();
        }
        let topology = &self.surface.topology;
        let factor = |point| error_factors.get(topology.vertex_of(point) as usize).copied().unwrap_or(1.0);
        (0..topology.point_count() as u32).map(|point| factor(point).powi(3).min(f32::MAX)).collect()
    }

    /// Collects the vertices that a level may remove with their costs, cheapest first. Returns the
    /// maximum cost of a collapse of the level.
    fn cheapest(&self, levels: &MergeLevels, points: &[u32], chosen: &mut Vec<(f32, u32)>) -> f32 {
        chosen.clear();
        let MergeLevels { order, spacing, .. } = *levels;
        let priced = points
            .iter()
            .map(|&point| (levels.counted(point, self.best_collapses[point as usize].cost), point));
        chosen.extend(priced.filter(|(cost, _)| *cost < f32::INFINITY));
        let by_cost = |a: &(f32, u32), b: &(f32, u32)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        if order == MergeOrder::Quadric {
            let [share, of] = match spacing {
                Spacing::Disjoint => LIMIT_SHARE,
                Spacing::Apart => LIMIT_SHARE_APART,
            };
            let count = (chosen.len() * share).div_ceil(of);
            if count < chosen.len() {
                chosen.select_nth_unstable_by(count, by_cost);
                chosen.truncate(count);
            }
        }
        chosen.sort_unstable_by(by_cost);
        match order {
            MergeOrder::Quadric => chosen.last().map_or(0.0, |&(cost, _)| cost),
            MergeOrder::ShortestEdge => f32::INFINITY,
        }
    }

    /// Returns the best collapse of a vertex to a target that is not taken.
    fn collapse_beside(
        &mut self,
        levels: &MergeLevels,
        point: u32,
        is_taken: impl Fn(u32) -> bool,
    ) -> Option<PricedCollapse> {
        if let Some(priced) = self.priced(point).filter(|priced| !is_taken(priced.to)) {
            return Some(priced);
        }
        self.surface.topology.neighbours(point, &mut self.around);
        self.search.refused.clear();
        self.search.refused.extend(self.around.iter().copied().filter(|&p| is_taken(p)));
        let best = levels.best(&self.surface, (&mut self.search, &mut self.outcomes), point);
        self.search.refused.clear();
        best
    }

    /// Prices vertices, and stores their best collapses.
    fn price_for_level(&mut self, levels: &MergeLevels, pricers: &mut Pricers, points: &[u32]) {
        let mut best_collapses = std::mem::take(&mut self.best_collapses);
        let (this, surface) = (&*self, &self.surface);
        let best = |search: &mut PriceSearch, outcomes: &mut Outcomes, point| {
            this.is_removable(point).then(|| levels.best(surface, (search, outcomes), point)).flatten()
        };
        pricers.price(points, best, |point, best| best_collapses[point as usize].set_price(best));
        self.best_collapses = best_collapses;
    }
}
