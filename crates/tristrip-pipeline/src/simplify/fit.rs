//! Moves the vertices of a simplified surface closer to the original one. Half-edge collapses leave vertices where they were, on the original
//! surface, and so all of the simplified surface on one side of it where it is curved; vertices that may move lower the distance by a third or more.
//!
//! ```text
//!        ·  ·                    original: points spread over it
//!     ·  ╱ ╲   ·      ──▶     ·╱─·─╲·
//!    · ╱     ╲  ·             ╱·     ·╲      each point pulls at the corners of the triangle that is nearest to it
//! ```
//! # Algorithm
//! 1. Points are spread over both surfaces in proportion to area, by a seeded generator (`points`).
//! 2. In each round, the nearest point of the other surface is searched for each of them, from triangle to neighbour as long as the distance
//!    falls (`surface`). For a point of the original, the first search begins where the collapses brought the corners of its triangle; for one of the
//!    simplified surface, at the nearest of the points that were found in its triangle.
//! 3. The positions are moved by the solution of a linear least-squares problem (`equations`): the distances of the points from the planes that they were
//!    found on, and to a small part those along the planes and the moves themselves, which keep the problem regular.
//! 4. Moves that would turn a triangle are halved, and dropped if that is not enough.
//! 5. The positions with the least distance are kept, those before the first round among them: the result is never worse.
//!
//! Parts that are simplified as one surface are fitted as one: all vertices at a position move together, so that no crack opens between parts or at seams
//! of attributes. What collapses keep stays: positions that touch parts in other places of the scene. So do those at borders and at edges
//! of more than two triangles, and those of parts whose positions a file cannot change.
//!
//! # References
//! Hoppe et al.: *Mesh Optimization*, 1993, section 4.1: the positions for fixed triangles. There the distances are
//! those to the points found, not from planes, and the points are those of the original. Chen, Medioni: *Object Modelling by Registration of Multiple Range
//! Images*, 1992: distances from planes.
//!
//! # Complexity
//! O(p) time per round for p points, of which there are 24 per triangle of the simplified surface; 64 bytes per point, and 60 per triangle of the
//! original.

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
use crate::surface_change::{Facet, dot};
use points::Points;
use surface::{Point, Surface, unit};

/// The rounds of search and solution.
const ROUNDS: usize = 3;
/// The smallest cosine of the angle by which a triangle may turn.
const MOST_TURN: f64 = 0.5;
/// How often the moves around a turned triangle are halved before they are dropped.
const HALVINGS: usize = 3;

/// What was fitted.
pub(super) struct Fitted {
    /// For each part its reduced mesh with new positions; `None` if none of its vertices moved.
    pub(super) meshes: Vec<Option<Mesh>>,
    /// The number of positions that moved; those that several parts share count once.
    pub(super) moved: usize,
}

/// The new positions by the bits of the old ones.
type Moves = HashMap<[u32; 3], [f32; 3]>;

/// Moves the vertices that are left of all parts; those of fixed parts stay, and what they share with others.
///
/// # Errors
/// The collapses do not fit the parts.
pub(super) fn fit(parts: &[Part<'_>], done: &[PartCollapses], is_fixed: &[bool]) -> Result<Fitted, Error> {
    let groups = groups_of(parts);
    let moves = map(&groups, |members| {
        let group: Vec<Member<'_>> = members
            .iter()
            .map(|&part| Member { part: &parts[part], done: &done[part], is_fixed: is_fixed[part] })
            .collect();
        moves_of(&group)
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
fn moves_of(group: &[Member<'_>]) -> Result<Moves, Error> {
    if group.iter().all(|member| member.is_fixed || member.done.sequence.is_empty()) {
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
    // 2. The rounds; the last one only measures.
    let mut points = Points::new(&original, &simplified, &starts(group, &base)?);
    let normals: Vec<Point> = simplified.triangles.iter().map(|t| unit_normal(&simplified.at, t)).collect();
    let mut best = (points.mean_squares(&original, &simplified), simplified.at.clone());
    for _ in 0..ROUNDS {
        let moves = points.equations(&original, &simplified).solve(&is_free);
        step(&mut simplified, moves, &normals);
        points.search(&original, &simplified);
        let squares = points.mean_squares(&original, &simplified);
        if squares < best.0 {
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

/// Adds the moves to the positions. Around triangles that would turn too far from their normals they are halved, and at last dropped.
fn step(surface: &mut Surface, mut moves: Vec<Point>, normals: &[Point]) {
    for halving in 0..=HALVINGS {
        let moved: Vec<Point> =
            surface.at.iter().zip(&moves).map(|(at, by)| [0, 1, 2].map(|k| at[k] + by[k])).collect();
        let turned = |(t, normal): (&[u32; 3], &Point)| {
            let now = unit_normal(&moved, t);
            (dot(*normal, *normal) > 0.0 && dot(now, *normal) < MOST_TURN).then_some(*t)
        };
        let turned: Vec<[u32; 3]> = surface.triangles.iter().zip(normals).filter_map(turned).collect();
        if turned.is_empty() {
            break;
        }
        let factor = if halving < HALVINGS { 0.5 } else { 0.0 };
        let mut vertices = turned.into_flattened();
        vertices.sort_unstable();
        vertices.dedup();
        vertices.iter().for_each(|&v| moves[v as usize] = moves[v as usize].map(|x| factor * x));
    }
    for (at, by) in surface.at.iter_mut().zip(moves) {
        (0..3).for_each(|k| at[k] += by[k]);
    }
}

/// Returns the bits of a position; −0 is 0.
fn bits(position: [f32; 3]) -> [u32; 3] {
    position.map(|x| (x + 0.0).to_bits())
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
