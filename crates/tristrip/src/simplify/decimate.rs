//! The collapses themselves: which vertex goes next, to which neighbour, and what that changes.
//!
//! # Algorithm
//! Every point that may go waits in a queue, by the cost of its best collapse. Two prices are used:
//! - the *estimate*: the point's quadric at the neighbour that would stand in its place. It takes one evaluation a neighbour, and is a lower
//!   bound of the other;
//! - the *price*: to the estimate is added how far the point comes to lie from the triangles that take the place of its own, squared and
//!   weighted as the quadric is. The quadric knows planes only; the price sees where an edge comes to run across a ridge.
//!
//! 1. Take the cheapest point. Where its neighbourhood has changed since it was priced, price it: its neighbours by rising estimate,
//!    until the estimate alone is above the best price; those that are refused are left out. Put it back and start over.
//! 2. Else collapse it: its corners move to the kept point, its triangles with that are dropped, its quadric is added to the kept one's.
//! 3. Estimate the kept point anew. Its new neighbours only learn of it: they wait at the least of what they knew and the estimate for it,
//!    and are priced when their turn comes.
//!
//! A collapse is refused if it would
//! - turn a remaining triangle by more than about 75 degrees ([`LEAST_COSINE`]);
//! - change the topology (the link condition): the two points must have no common neighbours but those of their common triangles, two or on
//!   a border one; a border point goes along the border only; a last triangle or tetrahedron stays;
//! - tear a seam: each vertex at the point needs a triangle with the kept point, and they must agree;
//! - exceed the error allowed, where there is one.
//!
//! # References
//! Garland, Heckbert: *Surface Simplification Using Quadric Error Metrics*, 1997. Dey, Edelsbrunner, Guha, Nekhayev: *Topology
//! Preserving Edge Contraction*, 1999 (the link condition). The second price is ours: it takes the distance between the surfaces at 5 % of
//! the triangles from 0.95 of meshoptimizer's to 0.83 on the bunny.

use super::Stopped;
use super::quadric::Quadric;
use super::queue::Queue;
use super::topology::{Corner, Kind, LONG_RING, Topology};
use crate::collapse::{CollapseSequence, Rename};
use crate::mesh::{is_degenerate, triangles_of};
use crate::vector::{Point, cross, dot, normal_of, sub, to_segment, to_triangle};

use crate::mesh::Mesh;

const NONE: u32 = u32::MAX;
/// What a plane along a border weighs next to a face of the same size. As Garland and Heckbert, section 6, have it: a large penalty.
const BORDER_WEIGHT: f64 = 10.0;
/// The same for a seam, across which only attributes differ.
const SEAM_WEIGHT: f64 = 1.0;
/// What the squared distance to the new triangles counts next to the quadric. From 1 to 3 made little difference on bunny, horse and
/// armadillo; 0.3 and 10 were worse.
const DISTANCE_WEIGHT: f64 = 2.0;
/// What the squared way to the neighbour counts, weighted as the quadric is. Where all neighbours cost the same, as on a plane, light points go
/// to near ones, and no point is handed on along a chain, which would rename the same places again and again.
const WAY_WEIGHT: f64 = 1e-6;
/// The cosine of the angle that a triangle may turn by.
const LEAST_COSINE: f64 = 0.25;
/// A point with more triangles does not go, so that pricing one takes no time by the size of the mesh.
const MOST_CORNERS: usize = 256;

/// Why a collapse is not done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Refusal {
    FoldOver,
    Topology,
    Seam,
}

/// What a collapse costs.
#[derive(Debug, Clone, Copy)]
struct Price {
    cost: f64,
    /// The distance between the surfaces, as a share of the frame.
    error: f64,
}

/// What is known of a point's best collapse. Times are counted in collapses.
#[derive(Debug, Clone, Copy)]
struct Plan {
    /// Where the point would go to.
    target: u32,
    /// The error of that, in mesh units, once it is priced.
    error: f32,
    /// When it was priced.
    priced: u32,
    /// When its neighbourhood changed.
    changed: u32,
}

/// A triangle at the point looked at, without the point.
#[derive(Debug, Clone, Copy)]
struct Side {
    points: [u32; 2],
    positions: [Point; 2],
}

impl Side {
    fn has(&self, point: u32) -> bool {
        self.points[0] == point || self.points[1] == point
    }
}

pub(super) struct Decimation {
    topology: Topology,
    positions: Vec<Point>,
    /// The length of a unit of the local frame, in mesh units.
    unit: f64,
    quadrics: Vec<Quadric>,
    locked: Vec<bool>,
    queue: Queue,
    plans: Vec<Plan>,
    now: u32,
    marks: Vec<u32>,
    mark: u32,
    /// Triangles that are drawn.
    triangle_count: usize,
    /// The greatest error allowed, as a share of the frame.
    error_limit: f64,
    /// The triangles at the point that was looked at last.
    sides: Vec<Side>,
    neighbours: Vec<u32>,
    /// The neighbours of a point that has just gone.
    around: Vec<u32>,
    candidates: Vec<(f64, u32)>,
    renames: Vec<Rename>,
    dropped: Vec<u32>,
}

impl Decimation {
    /// Makes ready: joins vertices, weighs planes, estimates all points.
    pub(super) fn new(mesh: &Mesh, vertices: &[u32], locked: &[bool], error_limit: Option<f32>) -> Self {
        let (topology, positions) = (Topology::new(mesh, vertices), mesh.positions());
        let count = topology.point_count();
        let mut is_locked = vec![false; count];
        if !locked.is_empty() {
            for (corner, &v) in vertices.iter().enumerate() {
                let point = topology.triangles[corner / 3][corner % 3];
                is_locked[point as usize] |= locked.get(v as usize).copied().unwrap_or(false);
            }
        }
        let (framed, unit) = frame((0..count as u32).map(|p| positions[topology.vertex_of(p) as usize]));
        let quadrics = quadrics(&topology, &framed);
        let mut decimation = Self {
            triangle_count: triangles_of(vertices).filter(|&t| !is_degenerate(t)).count(),
            topology,
            positions: framed,
            unit,
            quadrics,
            locked: is_locked,
            queue: Queue::new(count),
            plans: vec![Plan { target: NONE, error: 0.0, priced: 0, changed: 1 }; count],
            now: 1,
            marks: vec![0; count],
            mark: 0,
            error_limit: error_limit.map_or(f64::INFINITY, |error| f64::from(error) / unit),
            sides: Vec::new(),
            neighbours: Vec::new(),
            around: Vec::new(),
            candidates: Vec::new(),
            renames: Vec::new(),
            dropped: Vec::new(),
        };
        (0..count as u32).for_each(|point| decimation.estimate(point));
        decimation
    }

    /// Collapses until there are so few triangles, or nothing can go.
    pub(super) fn run(&mut self, triangle_count: usize, sequence: &mut CollapseSequence) {
        while self.triangle_count > triangle_count {
            let Some(point) = self.queue.first() else { break };
            if self.is_priced(point) {
                self.collapse(point, sequence);
            } else {
                self.price(point);
            }
        }
    }

    /// Says what keeps each point that is left from going.
    pub(super) fn stopped(&mut self) -> Stopped {
        let mut stopped = Stopped { triangle_count: self.triangle_count, ..Stopped::default() };
        for point in 0..self.topology.point_count() as u32 {
            if self.topology.ring(point).is_empty() {
                continue;
            }
            let reason = if self.locked[point as usize] {
                &mut stopped.locked
            } else if self.topology.kind(point) == Kind::Complex {
                &mut stopped.non_manifold
            } else if self.topology.ring(point).len() > MOST_CORNERS {
                &mut stopped.topology
            } else {
                self.collect_candidates(point);
                self.look_at(point);
                let candidates = std::mem::take(&mut self.candidates);
                let refusals: Vec<_> = candidates.iter().map(|&(_, to)| self.refusal(point, to)).collect();
                self.candidates = candidates;
                let refusal = if refusals.contains(&None) { None } else { refusals[0] };
                match refusal {
                    Some(Refusal::FoldOver) => &mut stopped.fold_over,
                    Some(Refusal::Seam) => &mut stopped.seam,
                    Some(Refusal::Topology) => &mut stopped.topology,
                    // Nothing holds it but its price.
                    None => &mut stopped.error,
                }
            };
            *reason += 1;
        }
        stopped
    }

    fn may_go(&self, point: u32) -> bool {
        let ring = self.topology.ring(point);
        !self.locked[point as usize]
            && self.topology.kind(point) != Kind::Complex
            && !ring.is_empty()
            && ring.len() <= MOST_CORNERS
    }

    /// Looks at the triangles of a point.
    fn look_at(&mut self, point: u32) {
        let (topology, positions) = (&self.topology, &self.positions);
        self.sides.clear();
        self.sides.extend(topology.ring(point).iter().map(|&corner| {
            let points = topology.others(corner);
            Side { points, positions: points.map(|p| positions[p as usize]) }
        }));
    }

    /// Collects the neighbours that a point may go to, with their estimates; of a border point those along the border.
    fn collect_candidates(&mut self, point: u32) {
        self.topology.neighbours(point, &mut self.neighbours);
        let first = match self.topology.kind(point) {
            Kind::Border => self.neighbours.len().saturating_sub(2),
            _ => 0,
        };
        let (quadric, from) = (&self.quadrics[point as usize], self.positions[point as usize]);
        let estimate = |&to: &u32| (estimate_of(quadric, from, self.positions[to as usize]), to);
        self.candidates.clear();
        self.candidates.extend(self.neighbours[first..].iter().map(estimate));
    }

    /// Puts a point into the queue by the estimate of its best collapse.
    fn estimate(&mut self, point: u32) {
        if !self.may_go(point) {
            self.plans[point as usize].target = NONE;
            self.queue.remove(point);
            return;
        }
        self.collect_candidates(point);
        let least = self.candidates.iter().copied().min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        if let Some((cost, to)) = least {
            self.plans[point as usize].target = to;
            self.queue.set(point, cost as f32);
        }
    }

    /// Prices the collapses of a point, and puts it into the queue by the best, or takes it out where none can be done.
    fn price(&mut self, point: u32) {
        self.collect_candidates(point);
        self.look_at(point);
        let mut candidates = std::mem::take(&mut self.candidates);
        candidates.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut best: Option<(Price, u32)> = None;
        for &(estimate, to) in &candidates {
            if best.is_some_and(|(price, _)| estimate >= price.cost) {
                break;
            }
            let price = self.price_of(point, to, estimate);
            let is_better = best.is_none_or(|(best, _)| price.cost < best.cost);
            if is_better && price.error <= self.error_limit && self.refusal(point, to).is_none() {
                best = Some((price, to));
            }
        }
        self.candidates = candidates;
        if let Some((price, to)) = best {
            let plan = &mut self.plans[point as usize];
            (plan.target, plan.error, plan.priced) =
                (to, (price.error * self.unit).min(f64::from(f32::MAX)) as f32, self.now);
            self.queue.set(point, price.cost as f32);
        } else {
            self.plans[point as usize].target = NONE;
            self.queue.remove(point);
        }
    }

    /// Adds to an estimate for the point looked at the distance to the triangles that would stand around the kept point.
    fn price_of(&self, point: u32, to: u32, estimate: f64) -> Price {
        let (from, kept) = (self.positions[point as usize], self.positions[to as usize]);
        let (mut least, mut least_edge) = (f64::INFINITY, f64::INFINITY);
        for side in &self.sides {
            let [u, w] = side.positions;
            if side.has(to) {
                least_edge = least_edge.min(to_segment(from, [u, w]));
            } else {
                least = to_triangle(from, [kept, u, w], least);
            }
        }
        // Without other triangles, what is left is the edge that the point was opposite to.
        let square = if least.is_finite() { least } else { least_edge };
        let weight = self.quadrics[point as usize].weight;
        let quadric = &self.quadrics[point as usize];
        let mean = if quadric.whole_weight > 0.0 { quadric.at(kept) / quadric.whole_weight } else { 0.0 };
        Price { cost: estimate + DISTANCE_WEIGHT * weight * square, error: mean.max(square).sqrt() }
    }

    /// Tells whether the price of a point still holds.
    fn is_priced(&mut self, point: u32) -> bool {
        let Plan { target, priced, changed, .. } = self.plans[point as usize];
        priced >= changed
            && (priced >= self.plans[target as usize].changed || self.keeps_topology(point, target))
    }

    fn refusal(&mut self, point: u32, to: u32) -> Option<Refusal> {
        if self.folds_over(point, to) {
            return Some(Refusal::FoldOver);
        }
        if !self.keeps_topology(point, to) {
            return Some(Refusal::Topology);
        }
        let mut renames = std::mem::take(&mut self.renames);
        let renamed = self.topology.renames(point, to, &mut renames);
        self.renames = renames;
        if renamed.is_none() {
            return Some(Refusal::Seam);
        }
        None
    }

    /// Tells whether a triangle at the point looked at, that stays, would turn too far; one without area must not come
    /// to lie upside down.
    fn folds_over(&self, point: u32, to: u32) -> bool {
        let (from, kept) = (self.positions[point as usize], self.positions[to as usize]);
        let normals = |side: &Side, at: Point| {
            let [u, w] = side.positions;
            cross(sub(w, u), sub(at, u))
        };
        // The triangles of the point together say what is up where one of them does not.
        let all = || {
            let sum = |sum: Point, normal: Point| [0, 1, 2].map(|k| sum[k] + normal[k]);
            self.sides.iter().map(|side| normals(side, from)).fold([0.0; 3], sum)
        };
        self.sides.iter().filter(|side| !side.has(to)).any(|side| {
            let (before, after) = (normals(side, from), normals(side, kept));
            let square = dot(before, before);
            if square == 0.0 {
                return dot(after, all()) < 0.0;
            }
            let cosine = dot(before, after);
            cosine <= 0.0 || cosine * cosine < LEAST_COSINE * LEAST_COSINE * square * dot(after, after)
        })
    }

    /// Tells whether the surface stays the same but for its shape.
    fn keeps_topology(&mut self, point: u32, to: u32) -> bool {
        let ring = self.topology.ring(point);
        let common = ring.iter().filter(|&&corner| self.topology.others(corner).contains(&to)).count();
        let expected = if self.topology.kind(point) == Kind::Border { 1 } else { 2 };
        if common != expected {
            return false;
        }
        if ring.len() <= 3 && !self.leaves_something(point, to) {
            return false;
        }
        self.common_neighbours(point, to) == common
    }

    /// Tells whether more is left of a component than one triangle, or two back to back, once a point with few triangles is gone.
    fn leaves_something(&self, point: u32, to: u32) -> bool {
        let ring = self.topology.ring(point);
        // Whether there is a triangle already where the one opposite to the point comes to lie.
        let opposite = |corner: Corner| {
            let [u, w] = self.topology.others(corner);
            self.topology.triangles_with([to, u, w]) > 0
        };
        let side = ring.iter().find(|&&corner| !self.topology.others(corner).contains(&to));
        match (self.topology.kind(point), side) {
            (Kind::Inner, Some(&corner)) => ring.len() != 3 || !opposite(corner),
            (Kind::Border, None) => {
                let third = ring.iter().flat_map(|&corner| self.topology.others(corner)).find(|&p| p != to);
                third.is_some_and(|third| self.topology.triangles_with([to, third]) > 1)
            }
            (Kind::Border, Some(_)) => true,
            _ => false,
        }
    }

    /// Counts the points that are neighbours of both.
    fn common_neighbours(&mut self, point: u32, to: u32) -> usize {
        self.mark += 2;
        let (is_neighbour, is_counted) = (self.mark, self.mark + 1);
        let (topology, marks) = (&self.topology, &mut self.marks);
        let around = |p: u32| topology.ring(p).iter().flat_map(|&corner| topology.others(corner));
        let mut count = 0;
        if topology.ring(to).len() <= LONG_RING {
            around(point).for_each(|p| marks[p as usize] = is_neighbour);
            for p in around(to) {
                if marks[p as usize] == is_neighbour {
                    marks[p as usize] = is_counted;
                    count += 1;
                }
            }
        } else {
            for p in around(point) {
                if p == to || std::mem::replace(&mut marks[p as usize], is_neighbour) == is_neighbour {
                    continue;
                }
                let [short, long] =
                    if topology.ring(p).len() < topology.ring(to).len() { [p, to] } else { [to, p] };
                count += usize::from(around(short).any(|q| q == long));
            }
        }
        count
    }

    fn collapse(&mut self, point: u32, sequence: &mut CollapseSequence) {
        let to = self.plans[point as usize].target;
        let (mut renames, mut dropped) =
            (std::mem::take(&mut self.renames), std::mem::take(&mut self.dropped));
        let mut around = std::mem::take(&mut self.around);
        self.topology.neighbours(point, &mut around);
        let renamed = self.topology.renames(point, to, &mut renames);
        debug_assert!(renamed.is_some());
        self.topology.collapse(point, to, &renames, &mut dropped);
        sequence.push(&renames, &dropped, self.plans[point as usize].error);
        self.triangle_count -= dropped.len();
        self.queue.remove(point);
        let quadric = self.quadrics[point as usize];
        self.quadrics[to as usize].add(&quadric);
        (self.renames, self.dropped) = (renames, dropped);

        self.now += 1;
        for &p in &around {
            self.plans[p as usize].changed = self.now;
        }
        self.estimate(to);
        for &p in &around {
            if p != to {
                self.meet(p, to);
            }
        }
        self.around = around;
    }

    /// Lets a point know of a neighbour that stands in the place of one that is gone.
    fn meet(&mut self, point: u32, kept: u32) {
        let Some(cost) = self.queue.cost(point) else { return self.estimate(point) };
        if self.topology.kind(point) == Kind::Border && self.topology.kind(kept) != Kind::Border {
            return;
        }
        let [from, to] = [point, kept].map(|p| self.positions[p as usize]);
        let other = estimate_of(&self.quadrics[point as usize], from, to) as f32;
        if other < cost {
            self.plans[point as usize].target = kept;
            self.queue.set(point, other);
        }
    }
}

/// Gives the lower bound of what it costs to go from one place to another.
#[inline]
fn estimate_of(quadric: &Quadric, from: Point, to: Point) -> f64 {
    let way = sub(to, from);
    quadric.at(to) + WAY_WEIGHT * quadric.weight * dot(way, way)
}

/// Gives positions in a frame around them in which the longest side of their box is 1, and the length of that side.
fn frame(positions: impl Iterator<Item = [f32; 3]> + Clone) -> (Vec<Point>, f64) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in positions.clone() {
        for k in 0..3 {
            low[k] = low[k].min(f64::from(p[k]));
            high[k] = high[k].max(f64::from(p[k]));
        }
    }
    let side = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
    let unit = if side > 0.0 { side } else { 1.0 };
    (positions.map(|p| [0, 1, 2].map(|k| (f64::from(p[k]) - low[k]) / unit)).collect(), unit)
}

/// Gives each point the planes of its triangles, weighted by area, and planes that stand on borders and seams.
fn quadrics(topology: &Topology, positions: &[Point]) -> Vec<Quadric> {
    let mut quadrics = vec![Quadric::default(); positions.len()];
    let unit_normal = |t: usize| {
        let normal = normal_of(topology.triangles[t].map(|p| positions[p as usize]));
        let length = dot(normal, normal).sqrt();
        (length > 0.0).then(|| (normal.map(|x| x / length), length))
    };
    for (t, triangle) in topology.triangles.iter().enumerate() {
        let Some((normal, weight)) = unit_normal(t) else { continue };
        let plane = Quadric::plane(normal, positions[triangle[0] as usize], weight).of_faces(weight);
        triangle.iter().for_each(|&p| quadrics[p as usize].add(&plane));
    }
    for (corner, is_border) in topology.open_edges() {
        let [from, to] = [topology.point(corner), topology.others(corner)[0]];
        let Some((normal, _)) = unit_normal(corner.triangle()) else { continue };
        let edge = sub(positions[to as usize], positions[from as usize]);
        let across = cross(edge, normal);
        let length = dot(across, across).sqrt();
        if length > 0.0 {
            let weight = dot(edge, edge) * if is_border { BORDER_WEIGHT } else { SEAM_WEIGHT };
            let plane = Quadric::plane(across.map(|x| x / length), positions[from as usize], weight);
            [from, to].iter().for_each(|&p| quadrics[p as usize].add(&plane));
        }
    }
    quadrics
}
