//! Moves the vertices of a simplified surface closer to the original one. Half-edge collapses leave vertices where they were, on the original
//! surface, and so all of the simplified surface on one side of it where it is curved; vertices that may move lower the distance by a third or more.
//!
//! ```text
//!        ·  ·                    original: points spread over it
//!     ·  ╱ ╲   ·      ──▶     ·╱─·─╲·
//!    · ╱     ╲  ·             ╱·     ·╲      each point pulls at the corners of the triangle that is nearest to it
//! ```
//! # Algorithm
//! 1. Points are spread over both surfaces by a seeded generator, about as many for each triangle of the simplified one, and stand for its area
//!    (`points`). Vertices of both are further points, which pull at nothing and show the largest distance.
//! 2. In each round, the nearest point of the other surface is searched for each of them, from triangle to neighbour as long as the distance
//!    falls (`surface`), and more widely for points that are much farther away than most. For a point of the original, the first search begins
//!    where the collapses brought the corners of its triangle; for one of the simplified surface, at the nearest of the points that were found in
//!    its triangle.
//! 3. The positions are moved by the solution of a linear least-squares problem (`equations`): the distances of the points from the planes that they were
//!    found on, and to a small part those along the planes and the moves themselves, which keep the problem regular.
//! 4. Moves that would turn a triangle are halved, and dropped if that is not enough; so are those at points that are farther away than the farthest
//!    point before the first round.
//! 5. The positions with the least mean of the squared distances are kept, those before the first round among them.
//!
//! Parts that are simplified as one surface are fitted as one: all vertices at a position move together, so that no crack opens between parts or at seams
//! of attributes. What collapses keep stays: positions that touch parts in other places of the scene. So do those at borders and at edges
//! of more than two triangles, and those of parts whose positions a file cannot change. Distances are those in the coordinates of the parts.
//!
//! # References
//! Hoppe et al.: *Mesh Optimization*, 1993, section 4.1: the positions for fixed triangles. There the distances are
//! those to the points found, not from planes, and the points are those of the original. Chen, Medioni: *Object Modelling by Registration of Multiple Range
//! Images*, 1992: distances from planes.
//!
//! # Complexity
//! O(p) time per round for p points, of which there are about 24 per triangle of the simplified surface, and up to half as many vertices; 72 bytes per
//! point, and 60 per triangle of the original. A search looks at a limited number of triangles.

mod equations;
mod points;
mod surface;

use std::collections::HashMap;

use tristrip::{Faces, Mesh, PositionIds};

use super::groups::groups_of;
use super::order::PartCollapses;
use super::parts::Part;
use crate::error::Error;
use crate::parts::map;
use crate::surface_change::{Facet, dot, sub};
use points::Points;
use surface::{Point, Surface, unit};

/// The rounds of search and solution.
const ROUNDS: usize = 3;
/// The smallest cosine of the angle by which a triangle may turn.
const MOST_TURN: f64 = 0.5;
/// How often the moves around a turned triangle are halved before they are dropped.
const HALVINGS: usize = 3;
/// How often moves are halved or dropped before all are.
const MOST_ATTEMPTS: usize = 16;

/// What was fitted.
pub(super) struct Fitted {
    /// For each part its reduced mesh with new positions; `None` if none of its vertices moved.
    pub(super) meshes: Vec<Option<Mesh>>,
    /// The number of positions that moved; those that several parts share count once.
    pub(super) moved: usize,
}

/// The new positions by the bits of the old ones.
type Moves = HashMap<[u32; 3], [f32; 3]>;

/// Moves the vertices that are left of all parts; those of fixed parts stay, and what they share with others. It asks before each round whether to
/// go on, and otherwise ends with the positions so far.
///
/// # Errors
/// The collapses do not fit the parts.
pub(super) fn fit(
    parts: &[Part<'_>],
    done: &[PartCollapses],
    is_fixed: &[bool],
    goes_on: &(dyn Fn() -> bool + Sync),
) -> Result<Fitted, Error> {
    let groups = groups_of(parts);
    let moves = map(&groups, |members| {
        let group: Vec<Member<'_>> = members
            .iter()
            .map(|&part| Member { part: &parts[part], done: &done[part], is_fixed: is_fixed[part] })
            .collect();
        moves_of(&group, goes_on)
    });
    let mut fitted = Fitted { meshes: vec![None; parts.len()], moved: 0 };
    for (members, moves) in groups.iter().zip(moves) {
        let moves = moves?;
        fitted.moved += moves.len();
        for &part in members {
            if !is_fixed[part] {
                fitted.meshes[part] = moved(&parts[part].compact.mesh, &moves)?;
            }
        }
    }
    Ok(fitted)
}

/// Returns a mesh with new positions, without faces; `None` if none of its vertices moves.
fn moved(mesh: &Mesh, moves: &Moves) -> Result<Option<Mesh>, Error> {
    let new = |position: &[f32; 3]| moves.get(&bits(*position)).copied();
    if !mesh.positions().iter().any(|position| new(position).is_some()) {
        return Ok(None);
    }
    let positions: Vec<[f32; 3]> =
        mesh.positions().iter().map(|position| new(position).unwrap_or(*position)).collect();
    let mut moved = Mesh::new(positions, Faces::default())?;
    for attribute in mesh.attributes() {
        moved = moved.with_attribute(attribute.clone())?;
    }
    Ok(Some(moved))
}

/// A part of a group.
struct Member<'a> {
    part: &'a Part<'a>,
    done: &'a PartCollapses,
    is_fixed: bool,
}

/// Returns the positions that move in parts that are one surface.
fn moves_of(group: &[Member<'_>], goes_on: &(dyn Fn() -> bool + Sync)) -> Result<Moves, Error> {
    if group.iter().all(|member| member.is_fixed || member.done.sequence.is_empty()) || !goes_on() {
        return Ok(Moves::new());
    }
    // 1. Both surfaces over numbered positions, those of the simplified one first.
    let mut ids = PositionIds::default();
    let base: Vec<Mesh> = group.iter().map(Member::base).collect::<Result<_, Error>>()?;
    let full: Vec<Mesh> = group.iter().map(Member::full).collect::<Result<_, Error>>()?;
    let base_faces = ids.faces(&base.iter().collect::<Vec<_>>())?;
    let base_count = position_count(&base_faces, 0);
    let full_faces = ids.faces(&full.iter().collect::<Vec<_>>())?;
    let old: Vec<[f32; 3]> =
        (0..position_count(&full_faces, base_count) as u32).filter_map(|id| ids.position(id)).collect();
    drop((ids, full));
    let at: Vec<Point> = old.iter().map(|position| position.map(f64::from)).collect();
    let mut simplified = Surface::new(&base_faces, at[..base_count].to_vec());
    let original = Surface::new(&full_faces, at);
    let is_free = free(group, &base, &simplified);
    if !is_free.contains(&true) {
        return Ok(Moves::new());
    }
    // 2. The rounds.
    let mut points = Points::new(&original, &simplified, &starts(group, &base)?);
    let normals: Vec<Point> = simplified.triangles.iter().map(|t| unit_normal(&simplified.at, t)).collect();
    let old_at = simplified.at.clone();
    let limit = points.largest_square(&original, &simplified);
    let mut best = (points.mean_squares(&original, &simplified), old_at.clone());
    for _ in 0..ROUNDS {
        if !goes_on() {
            break;
        }
        let by = points.equations(&original, &simplified).solve(&is_free);
        step(&mut simplified, by, &normals);
        let mut has_moved = vec![true; simplified.triangles.len()];
        let stays_near = (0..MOST_ATTEMPTS).any(|attempt| {
            points.search(&original, &simplified, &has_moved);
            let far = points.beyond(&original, &simplified, &has_moved, limit);
            if !far.is_empty() {
                has_moved = go_back(&mut simplified, &old_at, &far, attempt, &normals);
            }
            far.is_empty()
        });
        let squares = points.mean_squares(&original, &simplified);
        if stays_near && squares < best.0 {
            best = (squares, simplified.at.clone());
        }
    }
    // 3. Those that moved.
    let rounded = best.1.iter().map(|at| at.map(|x| x as f32));
    let moved = old.iter().zip(rounded).zip(&is_free).filter(|&((old, new), &is_free)| {
        is_free && bits(*old) != bits(new) && new.iter().all(|x| x.is_finite())
    });
    Ok(moved.map(|((old, new), _)| (bits(*old), new)).collect())
}

impl Member<'_> {
    /// Returns the reduced mesh with the triangles that are left.
    fn base(&self) -> Result<Mesh, Error> {
        let corners = self.done.sequence.drawn(0)?.into_flattened();
        Ok(self.part.compact.mesh.with_faces(Faces::from_triangles(corners)?)?)
    }

    /// Returns the reduced mesh with all triangles.
    fn full(&self) -> Result<Mesh, Error> {
        Ok(self.part.compact.mesh.with_faces(Faces::from_triangles(self.part.triangles().to_vec())?)?)
    }
}

/// Returns the number of positions that faces use, at least `least`.
fn position_count(faces: &Faces, least: usize) -> usize {
    faces.corners().iter().max().map_or(0, |&last| last as usize + 1).max(least)
}

/// Returns the positions that may move.
fn free(group: &[Member<'_>], base: &[Mesh], simplified: &Surface) -> Vec<bool> {
    let mut is_free = simplified.inner();
    let mut ids = simplified.triangles.as_flattened().iter();
    for (member, base) in group.iter().zip(base) {
        let locked = member.part.locked();
        // The corners of the member come first: there are at least as many numbers.
        for (&v, &id) in base.faces().corners().iter().zip(&mut ids) {
            if member.is_fixed || locked.get(v as usize) == Some(&true) {
                is_free[id as usize] = false;
            }
        }
    }
    is_free
}

/// Returns for each triangle of the original a triangle that the collapses brought one of its corners to; `None` in vanished components.
fn starts(group: &[Member<'_>], base: &[Mesh]) -> Result<Vec<Option<u32>>, Error> {
    let (mut starts, mut first) = (Vec::new(), 0);
    for (member, base) in group.iter().zip(base) {
        let mut triangle_at = vec![None; base.vertex_count()];
        for (corner, &v) in (0..).zip(base.faces().corners()) {
            triangle_at[v as usize] = Some(first + corner / 3);
        }
        let kept = member.done.sequence.renaming(0)?;
        let start = |corners: &[u32]| corners.iter().find_map(|&v| triangle_at[kept[v as usize] as usize]);
        starts.extend(member.part.triangles().chunks_exact(3).map(start));
        first += (base.faces().corner_count() / 3) as u32;
    }
    Ok(starts)
}

/// Adds the moves to the positions. Around triangles that would turn too far from their normals they are halved, and at last dropped, until no triangle
/// turns; if that takes too long, all are dropped.
fn step(surface: &mut Surface, mut moves: Vec<Point>, normals: &[Point]) {
    for attempt in 0..MOST_ATTEMPTS {
        let moved: Vec<Point> = surface.at.iter().zip(&moves).map(|(at, by)| sum(*at, *by)).collect();
        let turned = |(t, normal): (&[u32; 3], &Point)| {
            let now = unit_normal(&moved, t);
            (dot(*normal, *normal) > 0.0 && dot(now, *normal) < MOST_TURN).then_some(*t)
        };
        let turned: Vec<[u32; 3]> = surface.triangles.iter().zip(normals).filter_map(turned).collect();
        if turned.is_empty() {
            surface.at = moved;
            return;
        }
        lessen(&mut moves, turned, attempt);
    }
}

/// Moves the corners of some triangles back to where they were, half of the way or all of it; returns which triangles this moves.
fn go_back(
    surface: &mut Surface,
    old_at: &[Point],
    triangles: &[u32],
    attempt: usize,
    normals: &[Point],
) -> Vec<bool> {
    let mut moves: Vec<Point> = surface.at.iter().zip(old_at).map(|(at, old)| sub(*at, *old)).collect();
    let before: Vec<Point> = old_at.iter().zip(&moves).map(|(old, by)| sum(*old, *by)).collect();
    lessen(&mut moves, triangles.iter().map(|&t| surface.triangles[t as usize]).collect(), attempt);
    surface.at = old_at.to_vec();
    step(surface, moves, normals);
    let has_moved = |&v: &u32| {
        let [before, now] = [before[v as usize], surface.at[v as usize]].map(|at| at.map(f64::to_bits));
        before != now
    };
    surface.triangles.iter().map(|corners| corners.iter().any(has_moved)).collect()
}

/// Halves the moves of the corners of triangles, and after some attempts drops them.
fn lessen(moves: &mut [Point], triangles: Vec<[u32; 3]>, attempt: usize) {
    let factor = if attempt < HALVINGS { 0.5 } else { 0.0 };
    let mut corners = triangles.into_flattened();
    corners.sort_unstable();
    corners.dedup();
    corners.iter().for_each(|&v| moves[v as usize] = moves[v as usize].map(|x| factor * x));
}

/// Returns the bits of a position; −0 is 0.
fn bits(position: [f32; 3]) -> [u32; 3] {
    position.map(|x| (x + 0.0).to_bits())
}

fn sum(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|k| a[k] + b[k])
}

fn unit_normal(at: &[Point], triangle: &[u32; 3]) -> Point {
    unit(Facet::new(*triangle, triangle.map(|v| at[v as usize])).normal())
}

#[cfg(test)]
#[allow(clippy::format_push_string, reason = "small texts")]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::{Amount, Goal, Ratio, Simplified, SimplifyOptions, simplify};
    use tristrip::random::Random;
    use tristrip_io::{Format, Model, read};

    /// A ball of triangles, or its upper half; each half is a part, of a material of its own.
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

    /// Counts the edges that have one triangle, by position.
    fn open_edges(model: &Model) -> usize {
        let mut edges: HashMap<[[u32; 3]; 2], usize> = HashMap::new();
        for [a, b, c] in triangles(model) {
            for [a, b] in [[a, b], [b, c], [c, a]] {
                *edges.entry([a.min(b), a.max(b)]).or_default() += 1;
            }
        }
        edges.values().filter(|&&triangles| triangles == 1).count()
    }

    /// The positions that both parts have, and how many of them a source does not have.
    fn shared(model: &Model, source: &Model) -> [usize; 2] {
        let of = |model: &Model, part: usize| -> HashSet<[u32; 3]> {
            model.parts[part].mesh.positions().iter().map(|&position| bits(position)).collect()
        };
        let [upper, lower, old] = [of(model, 0), of(model, 1), of(source, 0)];
        let shared = || upper.intersection(&lower);
        [shared().count(), shared().filter(|position| !old.contains(*position)).count()]
    }

    fn simplified(model: &Model, fit: bool) -> Simplified {
        let goal = Goal { amount: Ratio::new(0.1).map(Amount::Ratio), ..Goal::default() };
        simplify(model, &SimplifyOptions::new(goal).with_fit(fit)).unwrap()
    }

    #[test]
    fn a_ball_is_closer_and_stays_closed() {
        let model = ball(24, 40, false);
        let [before, after] = [false, true].map(|fit| simplified(&model, fit));
        let change = |done: &Simplified| done.change.unwrap();
        assert!(change(&after).rms < 0.6 * change(&before).rms, "{:?} {:?}", after.change, before.change);
        assert!(change(&after).largest < change(&before).largest);
        let faces = |done: &Simplified| -> usize {
            done.redrawn.model.parts.iter().map(|part| part.mesh.faces().face_count()).sum()
        };
        assert_eq!((faces(&before), before.moved_positions), (faces(&after), None));
        assert_eq!(open_edges(&before.redrawn.model) + open_edges(&after.redrawn.model), 0);
        // Vertices of a ball that is fitted are outside of it.
        let radius = |p: &[f32; 3]| p.iter().map(|x| x * x).sum::<f32>().sqrt();
        let positions = after.redrawn.model.parts[0].mesh.positions();
        assert!(positions.iter().filter(|p| radius(p) > 1.001).count() > positions.len() / 2);
        // Both sides of the border between the parts move to the same places.
        let [[all, _], [still, moved]] = [&before, &after].map(|done| shared(&done.redrawn.model, &model));
        assert!(all == still && moved == all && all > 5, "{all} {still} {moved}");
    }

    /// A GLB of two materials: read back, it is the fitted model, and the border between them is closed.
    #[test]
    fn scenes_are_fitted_and_written() {
        let whole = simplify(&ball(24, 40, false), &SimplifyOptions::new(Goal::default())).unwrap();
        let scene = read(&whole.encode_as(Format::Glb, true, &()).unwrap().bytes, Format::Glb).unwrap();
        let goal = Goal { amount: Ratio::new(0.1).map(Amount::Ratio), ..Goal::default() };
        let options = SimplifyOptions::new(goal).with_fit(true).with_format(Format::Glb);
        let done = simplify(&scene, &options).unwrap();
        assert!(done.notes.is_empty() && done.redrawn.kept == 0, "{:?}", done.notes);
        let back = read(&done.encode(&()).unwrap().bytes, Format::Glb).unwrap();
        assert!(scene.scene.is_some() && triangles(&back) == triangles(&done.redrawn.model));
        let [border, moved] = shared(&back, &scene);
        assert!(border > 5 && moved == border && open_edges(&back) == 0, "{border} {moved}");
        let corners: HashSet<[u32; 3]> = triangles(&back).into_flattened().into_iter().collect();
        assert_eq!(done.moved_positions, Some(corners.len()));
        // The vertices of the source are the ones from which the values are taken.
        for (part, new) in done.redrawn.model.parts.iter().enumerate() {
            let sources = done.source_vertices(part).unwrap();
            assert_eq!(sources.len(), new.mesh.vertex_count());
            for (&source, new) in sources.iter().zip(new.mesh.positions()) {
                let old = scene.parts[part].mesh.positions()[source as usize];
                assert!((0..3).all(|k| (old[k] - new[k]).abs() < 0.2), "{old:?} {new:?}");
            }
        }
    }

    /// A ball over a floor of two triangles with most of the area: the ball is fitted as well as alone.
    #[test]
    fn large_triangles_take_no_points_from_small_ones() {
        let mut model = ball(24, 40, false);
        let floor = "v -900 -900 -2\nv 900 -900 -2\nv 900 900 -2\nv -900 900 -2\nf 1 2 3\nf 1 3 4\n";
        let floor = read(floor.as_bytes(), Format::Obj).unwrap();
        model.parts.extend(floor.parts);
        let goal =
            Goal { amount: Ratio::new(0.2).map(Amount::Ratio), deviation: crate::Deviation::Percent(100.0) };
        let done = simplify(&model, &SimplifyOptions::new(goal).with_fit(true)).unwrap();
        assert!(done.moved_positions.unwrap() > 100);
        for part in &done.redrawn.model.parts[..2] {
            for p in part.mesh.positions() {
                let radius = p.iter().map(|x| x * x).sum::<f32>().sqrt();
                assert!((0.99..1.06).contains(&radius), "{radius}");
            }
        }
    }

    /// A column of many sides, whose ends are fans around one corner each: no search visits all of a fan.
    #[test]
    fn fans_of_many_triangles_take_little_time() {
        let sides = 3000;
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
            text += &format!(
                "f 1 {} {}\nf 2 {} {}\n",
                at(0, side + 1),
                at(0, side),
                at(4, side),
                at(4, side + 1)
            );
        }
        let model = read(text.as_bytes(), Format::Obj).unwrap();
        let goal = Goal { amount: Ratio::new(0.5).map(Amount::Ratio), ..Goal::default() };
        let done = simplify(&model, &SimplifyOptions::new(goal).with_fit(true).with_measure(false)).unwrap();
        assert!(done.moved_positions.is_some());
    }

    /// Whatever the moves are, no triangle turns by more than it may.
    #[test]
    fn no_step_turns_a_triangle() {
        let mut random = Random::new(3);
        let mut number = move || (random.below(2000) as f64 - 1000.0) / 1000.0;
        let mesh = ball(12, 20, false).parts.remove(0).mesh;
        let at: Vec<Point> = mesh.positions().iter().map(|p| p.map(f64::from)).collect();
        for size in [0.01, 0.1, 0.5, 3.0] {
            let mut surface = Surface::new(mesh.faces(), at.clone());
            let normals: Vec<Point> = surface.triangles.iter().map(|t| unit_normal(&at, t)).collect();
            let moves = at.iter().map(|_| [size * number(), size * number(), size * number()]).collect();
            step(&mut surface, moves, &normals);
            for (t, normal) in surface.triangles.iter().zip(&normals) {
                assert!(dot(unit_normal(&surface.at, t), *normal) >= MOST_TURN, "{size} {t:?}");
            }
            assert!(size > 0.1 || surface.at != at);
        }
    }

    /// An observer that ends a simplification in the fit gets what there is; one that cancels, an error.
    /// Balls with needles: a vertex at the foot of one may not be pulled away by the points of what collapsed.
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
                let done = simplify(&model, &SimplifyOptions::new(goal).with_fit(fit)).unwrap();
                done.change.unwrap()
            };
            let [kept, fitted] = [of(false), of(true)];
            assert!(fitted.largest <= 1.05 * kept.largest, "{fitted:?} {kept:?}");
        }
    }

    #[test]
    fn the_fit_can_be_interrupted() {
        use std::sync::atomic::{AtomicBool, Ordering};

        use crate::{Error, Event, Observer, SimplifyProgress, Stage, simplify_observed};

        struct Ends {
            is_ended: AtomicBool,
            cancels: bool,
            at: Stage,
        }
        impl Observer for Ends {
            fn event(&self, event: Event<'_>) {
                if let Event::Begin(stage) = event {
                    self.is_ended.fetch_or(stage == self.at, Ordering::Relaxed);
                }
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
                let options = SimplifyOptions::new(goal).with_fit(true).with_verify(verify);
                let run = |cancels| {
                    simplify_observed(&model, &options, &Ends { is_ended: false.into(), cancels, at })
                };
                let is_asked_later = at != Stage::Compare && (verify || at == Stage::Fit);
                let done = run(false).unwrap();
                assert_eq!(done.interrupted, is_asked_later, "{at:?} {verify}");
                assert_eq!(done.change.is_some(), !is_asked_later);
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
}
