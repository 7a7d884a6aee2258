//! Moves the vertices of a simplified surface closer to the original one. Half-edge collapses leave vertices where they were, on the original
//! surface, and so all of the simplified surface on one side of it where it is curved; vertices that may move halve the distance.
//!
//! ```text
//!        ·  ·                    original: points spread over it
//!     ·  ╱ ╲   ·      ──▶     ·╱─·─╲·
//!    · ╱     ╲  ·             ╱·     ·╲      each point pulls at the corners of the triangle that is nearest to it
//! ```
//! # Algorithm
//! 1. Points are spread over the original surface in proportion to its area, by a seeded generator.
//! 2. In each round, the nearest point of the simplified surface is searched for each of them, from triangle to neighbour as long as the distance
//!    falls. The first search begins where the collapses brought the corners of the point's own triangle. Then the positions are moved by the solution of a linear least-squares problem: the distances of the points from the planes of their triangles, and to a small
//!    part those along the planes and the moves themselves, which keep the problem regular. It is solved by conjugate gradients with a fixed number
//!    of steps.
//! 3. Moves that would turn a triangle are halved, and dropped if that is not enough.
//! 4. The positions with the least distance are kept, those before the first round among them: the result is never worse.
//!
//! Vertices at one position move together. Those at borders and at edges of more than two triangles stay.
//!
//! # References
//! Hoppe et al.: *Mesh Optimization*, 1993, section 4.1: the positions for fixed triangles. There the distances are
//! those to the points found, not from planes. Chen, Medioni: *Object Modelling by Registration of Multiple Range Images*, 1992: distances from planes.
//!
//! # Complexity
//! O(p) time per round for p points, of which there are 12 per triangle of the simplified surface; 130 bytes per point.

use std::collections::HashMap;

use tristrip::random::Random;
use tristrip::{CollapseSequence, Faces, Mesh, PositionIds};
use tristrip_io::{Model, Redrawn};

use super::{Part, PartCollapses};
use crate::error::Error;
use crate::observer::{Event, Observer};
use crate::parts::map;
use crate::surface_change::{ChangedSurface, Facet, Side, SurfaceChange, dot, sub, surface_change};

type Point = [f64; 3];

/// The points per triangle of the simplified surface.
const POINTS_PER_TRIANGLE: f64 = 12.0;
/// The least and the most points.
const POINTS: (f64, f64) = (2_000.0, 4_000_000.0);
/// The rounds of search and solution.
const ROUNDS: usize = 3;
/// The steps of conjugate gradients per round.
const STEPS: usize = 16;
/// How much a distance along the plane of a triangle counts, compared with one from it.
const ALONG: f64 = 0.05;
/// How much the moves themselves count, compared with the points.
const STIFFNESS: f64 = 0.02;
/// The smallest cosine of the angle by which a triangle may turn.
const MOST_TURN: f64 = 0.5;
/// How often the moves around a turned triangle are halved before they are dropped.
const HALVINGS: usize = 3;
/// The most steps from triangle to neighbour in one search.
const MOST_STEPS: usize = 32;
/// Points whose searches are one task of a thread.
const CHUNK: usize = 4096;

/// A point of the original, and the triangle at which its next search begins.
#[derive(Debug, Clone, Copy)]
struct Start {
    point: Point,
    triangle: u32,
}

/// The simplified surface over its positions, with the triangles around each.
struct Surface<'a> {
    triangles: &'a [[u32; 3]],
    /// The end of the triangles around each position.
    ends: Vec<u32>,
    around: Vec<u32>,
}

/// A point of the original, and what it is nearest to.
struct Pull {
    triangle: u32,
    corners: [u32; 3],
    shares: Point,
    /// From the simplified surface to the point.
    rest: Point,
    /// The direction in which distances count in full.
    normal: Point,
}

/// Moves the vertices of a simplified model, and returns whether any moved. Notes tell which parts keep theirs.
pub(super) fn fit(
    model: &Model,
    (parts, done): (&[Part<'_>], &[PartCollapses]),
    redrawn: &mut Redrawn,
    notes: &mut Vec<String>,
    observer: &dyn Observer,
) -> Result<bool, Error> {
    let kept = if model.scene.is_some() {
        Some("vertices not fitted: those of scenes in glTF stay where they are")
    } else if share_vertices(redrawn) {
        Some("vertices not fitted: several parts share them")
    } else {
        None
    };
    if let Some(note) = kept {
        observer.event(Event::Note(note));
        notes.push(note.into());
        return Ok(false);
    }
    let mut parts_at: HashMap<[u32; 3], (usize, bool)> = HashMap::new();
    for (number, part) in redrawn.model.parts.iter().enumerate() {
        for position in part.mesh.positions() {
            let (first, is_shared) = parts_at.entry(bits(*position)).or_insert((number, false));
            *is_shared |= *first != number;
        }
    }
    let mut is_any = false;
    for ((part, done), new) in parts.iter().zip(done).zip(&mut redrawn.model.parts) {
        let positions = new.mesh.shared_positions();
        let is_locked =
            |v: u32| parts_at.get(&bits(positions[v as usize])).is_some_and(|&(_, shared)| shared);
        let original =
            Original { mesh: &part.compact.mesh, triangles: part.triangles(), done: &done.sequence };
        let Some(moved) = fitted(&original, &new.mesh, &is_locked)? else { continue };
        new.mesh = with_positions(&new.mesh, moved)?;
        is_any = true;
    }
    Ok(is_any)
}

/// Checks whether parts have the same array of vertices.
fn share_vertices(redrawn: &Redrawn) -> bool {
    let mut arrays: Vec<_> = redrawn.model.parts.iter().map(|part| part.mesh.positions().as_ptr()).collect();
    arrays.sort_unstable();
    arrays.windows(2).any(|pair| pair[0] == pair[1])
}

/// Returns the bits of a position; −0 is 0.
fn bits(position: [f32; 3]) -> [u32; 3] {
    position.map(|x| (x + 0.0).to_bits())
}

fn with_positions(mesh: &Mesh, positions: Vec<[f32; 3]>) -> Result<Mesh, Error> {
    let mut moved = Mesh::new(positions, mesh.faces().clone())?;
    for attribute in mesh.attributes() {
        moved = moved.with_attribute(attribute.clone())?;
    }
    Ok(moved)
}

/// Measures how far fitted parts are from what they were, at so many points in each direction.
pub(super) fn change(
    parts: &[Part<'_>],
    redrawn: &Redrawn,
    textures: &[Option<[u32; 2]>],
    points: usize,
) -> Result<SurfaceChange, Error> {
    let both = parts.iter().zip(&redrawn.model.parts).map(|(part, new)| both(&part.compact.mesh, &new.mesh));
    let both = both.collect::<Result<Vec<_>, Error>>()?;
    let surfaces: Vec<ChangedSurface<'_>> = parts
        .iter()
        .zip(&both)
        .zip(textures)
        .map(|((part, (mesh, after)), &texels)| ChangedSurface {
            mesh,
            before: part.triangles(),
            after,
            texels,
        })
        .collect();
    surface_change(&surfaces, points)
}

/// Returns the vertices of two meshes, and the triangles of the second one over them.
fn both(first: &Mesh, second: &Mesh) -> Result<(Mesh, Vec<u32>), Error> {
    let positions = [first.positions(), second.positions()].concat();
    let mut mesh = Mesh::new(positions, Faces::default())?;
    for attribute in first.attributes() {
        let named = second.attributes().iter().find(|other| other.name == attribute.name);
        let Some(other) = named else { continue };
        let mut all = attribute.clone();
        all.append(other)?;
        mesh = mesh.with_attribute(all)?;
    }
    let start = first.vertex_count() as u32;
    Ok((mesh, second.faces().fans().iter().map(|&v| v + start).collect()))
}

/// The original of a part.
struct Original<'a> {
    mesh: &'a Mesh,
    triangles: &'a [u32],
    /// The collapses that lead to the simplified mesh.
    done: &'a CollapseSequence,
}

/// Returns new positions for the vertices of a simplified mesh, closer to its original; `None` if none are. The faces are those of the last
/// collapse, in their order.
///
/// # Errors
/// The collapses do not fit the original.
fn fitted(
    original: &Original<'_>,
    simplified: &Mesh,
    is_locked: &dyn Fn(u32) -> bool,
) -> Result<Option<Vec<[f32; 3]>>, Error> {
    if simplified.faces().as_triangles().is_none_or(<[u32]>::is_empty) {
        return Ok(None);
    }
    // 1. One variable per position.
    let mut ids = PositionIds::default();
    let by_position = ids.faces(&[simplified])?;
    let surface = Surface::new(by_position.corners().as_chunks().0);
    let pairs = || simplified.faces().corners().iter().zip(by_position.corners());
    let mut at = vec![[0.0; 3]; surface.ends.len()];
    let mut is_free = surface.free();
    for (&v, &id) in pairs() {
        at[id as usize] = simplified.positions()[v as usize].map(f64::from);
        is_free[id as usize] &= !is_locked(v);
    }

    // 2. The points.
    let mut starts = starts(original, &surface)?;
    if starts.is_empty() || !is_free.contains(&true) {
        return Ok(None);
    }

    // 3. The rounds; the last one only measures.
    let normals: Vec<Point> = surface.triangles.iter().map(|t| unit_normal(&at, t)).collect();
    let mut best: Option<(f64, Vec<Point>)> = None;
    for round in 0..=ROUNDS {
        let (pulls, sum) = search(&mut starts, &surface, &at, round > 0);
        if best.as_ref().is_none_or(|(least, _)| sum < *least) {
            best = Some((sum, at.clone()));
        }
        if round < ROUNDS {
            let moves = solve(&pulls, &is_free);
            step(&mut at, moves, surface.triangles, &normals);
        }
    }
    let Some((_, at)) = best else { return Ok(None) };
    let mut moved = simplified.positions().to_vec();
    for (&v, &id) in pairs() {
        if is_free[id as usize] {
            moved[v as usize] = at[id as usize].map(|x| x as f32);
        }
    }
    let is_finite = moved.iter().flatten().all(|x| x.is_finite());
    Ok((is_finite && moved != simplified.positions()).then_some(moved))
}

impl<'a> Surface<'a> {
    fn new(triangles: &'a [[u32; 3]]) -> Self {
        let corners = triangles.as_flattened();
        let count = corners.iter().max().map_or(0, |&id| id as usize + 1);
        let mut ends = vec![0_u32; count + 1];
        corners.iter().for_each(|&v| ends[v as usize + 1] += 1);
        (0..count).for_each(|v| ends[v + 1] += ends[v]);
        let mut around = vec![0; corners.len()];
        // Each start becomes the end while its triangles are entered.
        for (corner, &v) in corners.iter().enumerate() {
            around[ends[v as usize] as usize] = corner as u32 / 3;
            ends[v as usize] += 1;
        }
        ends.truncate(count);
        Self { triangles, ends, around }
    }

    /// Returns the triangles around a position.
    fn around(&self, v: u32) -> &[u32] {
        let start = if v == 0 { 0 } else { self.ends[v as usize - 1] };
        &self.around[start as usize..self.ends[v as usize] as usize]
    }

    /// Returns the positions that may move: those in triangles whose edges all have two triangles.
    fn free(&self) -> Vec<bool> {
        let mut edges: HashMap<[u32; 2], u32> = HashMap::new();
        for &[a, b, c] in self.triangles {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                *edges.entry([from.min(to), from.max(to)]).or_default() += 1;
            }
        }
        let mut is_free = vec![true; self.ends.len()];
        for (edge, triangles) in edges {
            if triangles != 2 {
                edge.iter().for_each(|&v| is_free[v as usize] = false);
            }
        }
        is_free
    }

    fn facet(&self, triangle: u32, at: &[Point]) -> Facet {
        let corners = self.triangles[triangle as usize];
        Facet::new(corners, corners.map(|v| at[v as usize]))
    }

    /// Searches the nearest point from a triangle on. One inside of that triangle is taken if the search is to stay near it.
    fn nearest(&self, start: &Start, at: &[Point], stays: bool) -> Pull {
        let mut triangle = start.triangle;
        let (mut least, mut shares) = self.facet(triangle, at).nearest(start.point);
        for _ in 0..MOST_STEPS {
            if stays && is_inside(shares) {
                break;
            }
            let from = triangle;
            for &near in self.triangles[from as usize].iter().flat_map(|&v| self.around(v)) {
                let (square, found) = self.facet(near, at).nearest(start.point);
                if square < least {
                    (triangle, least, shares) = (near, square, found);
                }
            }
            if triangle == from {
                break;
            }
        }
        let facet = self.facet(triangle, at);
        let rest = sub(start.point, facet.at(shares));
        let normal = unit(if is_inside(shares) { facet.normal() } else { rest });
        Pull { triangle, corners: facet.vertices(), shares, rest, normal }
    }
}

/// Checks whether the shares are those of a point inside of a triangle.
fn is_inside(shares: Point) -> bool {
    shares.iter().all(|&share| share > 0.0)
}

/// Spreads points over the original, each with a triangle where the collapses brought it.
fn starts(original: &Original<'_>, surface: &Surface<'_>) -> Result<Vec<Start>, Error> {
    let kept = original.done.renaming(0)?;
    let mut triangle_at = vec![None; original.mesh.vertex_count()];
    for (number, triangle) in original.done.drawn(0)?.iter().enumerate() {
        triangle.iter().for_each(|&v| triangle_at[v as usize] = Some(number as u32));
    }
    let side = Side::new(original.mesh, original.triangles)?;
    let count = (surface.triangles.len() as f64 * POINTS_PER_TRIANGLE).clamp(POINTS.0, POINTS.1);
    let mut starts = Vec::new();
    side.sample(count, &mut Random::new(0), |facet, shares| {
        // Points of components that vanished have none.
        let triangle = facet.vertices().iter().find_map(|&v| triangle_at[kept[v as usize] as usize]);
        let start = triangle.map(|triangle| Start { point: facet.at(shares), triangle });
        starts.extend(start.filter(|start| (start.triangle as usize) < surface.triangles.len()));
    });
    Ok(starts)
}

/// Searches the nearest point of the surface for each point, from where the last search ended and near it if there was one, and returns the sum of the squared distances.
fn search(starts: &mut [Start], surface: &Surface<'_>, at: &[Point], stays: bool) -> (Vec<Pull>, f64) {
    let chunks: Vec<&[Start]> = starts.chunks(CHUNK).collect();
    let found = map(&chunks, |chunk| {
        chunk.iter().map(|start| surface.nearest(start, at, stays)).collect::<Vec<Pull>>()
    });
    let pulls: Vec<Pull> = found.into_iter().flatten().collect();
    starts.iter_mut().zip(&pulls).for_each(|(start, pull)| start.triangle = pull.triangle);
    let sum = pulls.iter().map(|pull| dot(pull.rest, pull.rest)).sum();
    (pulls, sum)
}

impl Pull {
    /// Weighs a difference: in full along the normal, to a small part across it.
    fn weighted(&self, difference: Point) -> Point {
        let along = (1.0 - ALONG) * dot(self.normal, difference);
        [0, 1, 2].map(|k| along * self.normal[k] + ALONG * difference[k])
    }

    /// Adds a vector to the corners, by their shares.
    fn spread(&self, vector: Point, to: &mut [Point]) {
        for (&corner, share) in self.corners.iter().zip(self.shares) {
            let to = &mut to[corner as usize];
            (0..3).for_each(|k| to[k] += share * vector[k]);
        }
    }

    /// Returns the value at the point of a field over the positions.
    fn value(&self, field: &[Point]) -> Point {
        let [a, b, c] = self.corners.map(|v| field[v as usize]);
        [0, 1, 2].map(|k| self.shares[0] * a[k] + self.shares[1] * b[k] + self.shares[2] * c[k])
    }
}

/// Solves the least-squares problem for the moves, by conjugate gradients with a diagonal preconditioner.
fn solve(pulls: &[Pull], is_free: &[bool]) -> Vec<Point> {
    let count = is_free.len();
    let mut gradient = vec![[0.0; 3]; count];
    let mut mass = vec![0.0; count];
    for pull in pulls {
        pull.spread(pull.weighted(pull.rest), &mut gradient);
        for (&corner, share) in pull.corners.iter().zip(pull.shares) {
            mass[corner as usize] += share * share;
        }
    }
    let fix = |field: &mut [Point]| {
        field.iter_mut().zip(is_free).filter(|(_, is_free)| !**is_free).for_each(|(x, _)| *x = [0.0; 3]);
    };
    let stiffness = |v: usize| STIFFNESS * mass[v] + f64::MIN_POSITIVE;
    let apply = |field: &[Point]| {
        let mut out = vec![[0.0; 3]; count];
        for pull in pulls {
            pull.spread(pull.weighted(pull.value(field)), &mut out);
        }
        for (v, (out, x)) in out.iter_mut().zip(field).enumerate() {
            (0..3).for_each(|k| out[k] += stiffness(v) * x[k]);
        }
        fix(&mut out);
        out
    };
    fix(&mut gradient);
    let conditioned = |field: &[Point]| -> Vec<Point> {
        field.iter().zip(&mass).map(|(x, &mass)| if mass > 0.0 { x.map(|x| x / mass) } else { *x }).collect()
    };
    let inner = |a: &[Point], b: &[Point]| a.iter().zip(b).map(|(a, b)| dot(*a, *b)).sum::<f64>();
    let mut moves = vec![[0.0; 3]; count];
    let mut rest = gradient;
    let mut search = conditioned(&rest);
    let mut energy = inner(&rest, &search);
    for _ in 0..STEPS {
        if energy <= 0.0 {
            break;
        }
        let image = apply(&search);
        let curvature = inner(&search, &image);
        if curvature <= 0.0 {
            break;
        }
        let length = energy / curvature;
        for v in 0..count {
            for k in 0..3 {
                moves[v][k] += length * search[v][k];
                rest[v][k] -= length * image[v][k];
            }
        }
        let next = conditioned(&rest);
        let now = inner(&rest, &next);
        let ratio = now / energy;
        energy = now;
        for (search, next) in search.iter_mut().zip(next) {
            (0..3).for_each(|k| search[k] = next[k] + ratio * search[k]);
        }
    }
    moves
}

/// Adds the moves to the positions. Around triangles that would turn too far from their normals they are halved, and at last dropped.
fn step(at: &mut [Point], mut moves: Vec<Point>, surface: &[[u32; 3]], normals: &[Point]) {
    for halving in 0..=HALVINGS {
        let moved: Vec<Point> =
            at.iter().zip(&moves).map(|(at, by)| [0, 1, 2].map(|k| at[k] + by[k])).collect();
        let turned = |(t, normal): (&[u32; 3], &Point)| {
            let now = unit_normal(&moved, t);
            (dot(*normal, *normal) > 0.0 && dot(now, *normal) < MOST_TURN).then_some(*t)
        };
        let turned: Vec<[u32; 3]> = surface.iter().zip(normals).filter_map(turned).collect();
        if turned.is_empty() {
            break;
        }
        let factor = if halving < HALVINGS { 0.5 } else { 0.0 };
        let mut vertices = turned.into_flattened();
        vertices.sort_unstable();
        vertices.dedup();
        vertices.iter().for_each(|&v| moves[v as usize] = moves[v as usize].map(|x| factor * x));
    }
    for (at, by) in at.iter_mut().zip(moves) {
        (0..3).for_each(|k| at[k] += by[k]);
    }
}

fn unit_normal(at: &[Point], triangle: &[u32; 3]) -> Point {
    unit(Facet::new(*triangle, triangle.map(|v| at[v as usize])).normal())
}

/// Returns a vector of length 1; the zero vector for one without a direction.
fn unit(vector: Point) -> Point {
    let length = dot(vector, vector).sqrt();
    if length > 0.0 && length.is_finite() { vector.map(|x| x / length) } else { [0.0; 3] }
}

#[cfg(test)]
#[allow(
    clippy::format_push_string,
    clippy::float_cmp,
    reason = "small texts, and positions that must not change by a bit"
)]
mod tests {
    use super::*;
    use crate::{Amount, Goal, Ratio, Simplified, SimplifyOptions, simplify};
    use tristrip_io::{Format, read};

    /// A ball of triangles, or its upper half.
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
        for column in 0..columns {
            text += &format!("f 1 {} {}\n", at(1, column), at(1, column + 1));
            for row in 1..last {
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

    fn simplified(model: &Model, fit: bool) -> Simplified {
        let goal = Goal { amount: Ratio::new(0.1).map(Amount::Ratio), ..Goal::default() };
        simplify(model, &SimplifyOptions::new(goal).with_fit(fit)).unwrap()
    }

    #[test]
    fn a_ball_is_closer_and_stays_closed() {
        let model = ball(24, 40, false);
        let [before, after] = [false, true].map(|fit| simplified(&model, fit));
        let rms = |done: &Simplified| done.change.unwrap().rms;
        assert!(rms(&after) < 0.6 * rms(&before), "{} {}", rms(&after), rms(&before));
        let faces = |done: &Simplified| done.redrawn.model.parts[0].mesh.faces().clone();
        assert_eq!(faces(&before), faces(&after));
        // Vertices of a ball that is fitted are outside of it.
        let radius = |p: &[f32; 3]| p.iter().map(|x| x * x).sum::<f32>().sqrt();
        let positions = after.redrawn.model.parts[0].mesh.positions();
        assert!(positions.iter().filter(|p| radius(p) > 1.001).count() > positions.len() / 2);
    }

    #[test]
    fn borders_stay() {
        let model = ball(24, 40, true);
        let [before, after] = [false, true].map(|fit| simplified(&model, fit));
        let [before, after] = [&before, &after].map(|done| done.redrawn.model.parts[0].mesh.positions());
        let mut moved = 0;
        for (old, new) in before.iter().zip(after) {
            assert!(old[2] > 1e-6 || old == new, "{old:?} {new:?}");
            moved += usize::from(old != new);
        }
        assert!(moved > 10, "{moved}");
    }

    /// The steps of conjugate gradients solve the equations that the sums of all points give.
    #[test]
    fn the_moves_solve_the_equations() {
        let mut random = Random::new(7);
        let mut number = || (random.below(2000) as f64 - 1000.0) / 1000.0;
        let pulls: Vec<Pull> = (0..60)
            .map(|i| {
                let [u, v] = [number().abs() / 2.0, number().abs() / 2.0];
                let normal = unit([number(), number(), number()]);
                let corners = [i % 4, (i + 1) % 4, (i + 2) % 4];
                let rest = [number(), number(), number()];
                Pull { triangle: 0, corners, shares: [1.0 - u - v, u, v], rest, normal }
            })
            .collect();
        let moves = solve(&pulls, &[true, true, true, false]);
        assert_eq!(moves[3], [0.0; 3]);
        let energy = |moves: &[Point]| {
            let mut sum = 0.0;
            for pull in &pulls {
                let left = sub(pull.value(moves), pull.rest);
                sum += dot(left, pull.weighted(left));
                for (&corner, share) in pull.corners.iter().zip(pull.shares) {
                    let by = moves[corner as usize];
                    sum += STIFFNESS * share * share * dot(by, by);
                }
            }
            sum
        };
        let least = energy(&moves);
        for v in 0..3 {
            for k in 0..3 {
                for by in [-1e-3, 1e-3] {
                    let mut other = moves.clone();
                    other[v][k] += by;
                    assert!(energy(&other) >= least, "{v} {k} {by}");
                }
            }
        }
    }
}
