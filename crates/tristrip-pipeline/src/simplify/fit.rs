//! Moves the vertices of a simplified surface closer to the original surface. Half-edge collapses
//! keep vertices at their original positions. Where the surface is curved, the simplified surface
//! therefore lies on one side of the original. Moving the vertices reduces the distance by a third
//! or more.
//!
//! ```text
//!        ·  ·                    original: points spread over it
//!     ·  ╱ ╲   ·      ──▶     ·╱─·─╲·
//!    · ╱     ╲  ·             ╱·     ·╲      each point pulls at its nearest triangle
//! ```
//! # Algorithm
//! 1. Sample points on both surfaces with a seeded generator, with about the same number per
//!    triangle of the simplified surface. Each point represents an area (`points`). The vertices of
//!    both surfaces are additional points without weight: they only measure the maximum distance.
//! 2. In each round, find the nearest point of the other surface for each point. The search walks
//!    from triangle to neighbour as long as the distance decreases (`surface`). The search is wider
//!    for points that are much farther away than most points. For a point of the original, the
//!    first search starts at the triangle that the collapses moved its corners to. For a point of
//!    the simplified surface, it starts at the nearest point found so far in its triangle.
//! 3. Move the positions by the solution of a linear least-squares problem (`equations`). It
//!    minimizes the distances of the points from the planes of their nearest points. Distances
//!    along the planes, and the moves themselves, have small weights that keep the problem regular.
//! 4. Halve moves that would rotate a triangle too far, and drop them if that is not enough. Moves
//!    at points whose distance exceeds the initial maximum are halved or dropped, too.
//! 5. Keep the positions with the minimum mean squared distance. The initial positions are among
//!    the candidates.
//!
//! Parts that are simplified as one surface are also fitted as one surface. All vertices at one
//! position move together, so no cracks open between parts or at attribute seams. Positions are
//! fixed at borders, at edges of more than two triangles, where they touch parts placed by other
//! nodes, and in parts whose positions a file cannot change. Distances are in the coordinates of
//! the parts.
//!
//! # References
//! Hoppe et al.: *Mesh Optimization*, 1993, section 4.1: optimal positions for fixed triangles.
//! That method uses point distances, not plane distances, and samples only the original. Chen,
//! Medioni: *Object Modelling by Registration of Multiple Range Images*, 1992: distances from
//! planes.
//!
//! # Complexity
//! O(p) time per round for p points: about 24 points per triangle of the simplified surface, and up
//! to half as many vertices. 72 bytes per point, and 60 bytes per triangle of the original. A
//! search visits a bounded number of triangles.

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
use surface::{FitSurface, Point, unit};

/// The number of rounds of search and solution.
const ROUNDS: usize = 3;
/// The minimum cosine of the angle that a triangle may rotate by.
const MAX_TURN: f64 = 0.5;
/// How often the moves around a rotated triangle are halved before they are dropped.
const HALVINGS: usize = 3;
/// The maximum number of attempts to halve or drop moves. After these, all moves are dropped.
const MAX_ATTEMPTS: usize = 16;

/// The result of a fit.
pub(super) struct Fitted {
    /// The reduced mesh of each part with new positions; `None` if none of its vertices moved.
    pub(super) meshes: Vec<Option<Mesh>>,
    /// The number of moved positions. A position that several parts share counts once.
    pub(super) moved: usize,
}

/// The new positions by the bits of the old ones.
type Moves = HashMap<[u32; 3], [f32; 3]>;

/// Moves the remaining vertices of all parts. Fixed parts, and the vertices that others share with
/// them, are not moved. `goes_on` is called before each round; if it returns `false`, the fit ends
/// with the current positions.
///
/// # Errors
/// The collapses do not match the parts.
pub(super) fn fit(
    parts: &[Part<'_>],
    done: &[PartCollapses],
    is_fixed: &[bool],
    goes_on: &(dyn Fn() -> bool + Sync),
) -> Result<Fitted, Error> {
    let groups = groups_of(parts);
    let moves = map(&groups, |members| {
        let group: Vec<FittedPart<'_>> = members
            .iter()
            .map(|&part| FittedPart { part: &parts[part], done: &done[part], is_fixed: is_fixed[part] })
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

/// Returns a mesh with new positions and without faces; `None` if none of its vertices moves.
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
struct FittedPart<'a> {
    part: &'a Part<'a>,
    done: &'a PartCollapses,
    is_fixed: bool,
}

/// Returns the new positions for parts that form one surface.
fn moves_of(group: &[FittedPart<'_>], goes_on: &(dyn Fn() -> bool + Sync)) -> Result<Moves, Error> {
    if group.iter().all(|member| member.is_fixed || member.done.sequence.is_empty()) || !goes_on() {
        return Ok(Moves::new());
    }
    // 1. Both surfaces over position indices. Those of the simplified surface come first.
    let mut ids = PositionIds::default();
    let base: Vec<Mesh> = group.iter().map(FittedPart::base).collect::<Result<_, Error>>()?;
    let full: Vec<Mesh> = group.iter().map(FittedPart::full).collect::<Result<_, Error>>()?;
    let base_faces = ids.faces(&base.iter().collect::<Vec<_>>())?;
    let base_count = position_count(&base_faces, 0);
    let full_faces = ids.faces(&full.iter().collect::<Vec<_>>())?;
    let old: Vec<[f32; 3]> =
        (0..position_count(&full_faces, base_count) as u32).filter_map(|id| ids.position(id)).collect();
    drop((ids, full));
    let at: Vec<Point> = old.iter().map(|position| position.map(f64::from)).collect();
    let mut simplified = FitSurface::new(&base_faces, at[..base_count].to_vec());
    let original = FitSurface::new(&full_faces, at);
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
        let stays_near = (0..MAX_ATTEMPTS).any(|attempt| {
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
    // 3. The positions that moved.
    let rounded = best.1.iter().map(|at| at.map(|x| x as f32));
    let moved = old.iter().zip(rounded).zip(&is_free).filter(|&((old, new), &is_free)| {
        is_free && bits(*old) != bits(new) && new.iter().all(|x| x.is_finite())
    });
    Ok(moved.map(|((old, new), _)| (bits(*old), new)).collect())
}

impl FittedPart<'_> {
    /// Returns the reduced mesh with the remaining triangles.
    fn base(&self) -> Result<Mesh, Error> {
        let corners = self.done.sequence.drawn(0)?.into_flattened();
        Ok(self.part.compact.mesh.with_faces(Faces::from_triangles(corners)?)?)
    }

    /// Returns the reduced mesh with all triangles.
    fn full(&self) -> Result<Mesh, Error> {
        Ok(self.part.compact.mesh.with_faces(Faces::from_triangles(self.part.triangles().to_vec())?)?)
    }
}

/// Returns the number of positions that faces use, but at least `least`.
fn position_count(faces: &Faces, least: usize) -> usize {
    faces.corners().iter().max().map_or(0, |&last| last as usize + 1).max(least)
}

/// Returns the positions that may move.
fn free(group: &[FittedPart<'_>], base: &[Mesh], simplified: &FitSurface) -> Vec<bool> {
    let mut is_free = simplified.inner();
    let mut ids = simplified.triangles.as_flattened().iter();
    for (member, base) in group.iter().zip(base) {
        let locked = member.part.locked();
        // The corners of this member come first, so there are enough position indices.
        for (&v, &id) in base.faces().corners().iter().zip(&mut ids) {
            if member.is_fixed || locked.get(v as usize) == Some(&true) {
                is_free[id as usize] = false;
            }
        }
    }
    is_free
}

/// Returns, for each triangle of the original, a simplified triangle that the collapses moved one
/// of its corners to; `None` for removed components.
fn starts(group: &[FittedPart<'_>], base: &[Mesh]) -> Result<Vec<Option<u32>>, Error> {
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

/// Adds the moves to the positions. Moves around triangles that would rotate too far are halved,
/// then dropped, until no triangle does. After too many attempts, all moves are dropped.
fn step(surface: &mut FitSurface, mut moves: Vec<Point>, normals: &[Point]) {
    for attempt in 0..MAX_ATTEMPTS {
        let moved: Vec<Point> = surface.at.iter().zip(&moves).map(|(at, by)| sum(*at, *by)).collect();
        let turned = |(t, normal): (&[u32; 3], &Point)| {
            let now = unit_normal(&moved, t);
            (dot(*normal, *normal) > 0.0 && dot(now, *normal) < MAX_TURN).then_some(*t)
        };
        let turned: Vec<[u32; 3]> = surface.triangles.iter().zip(normals).filter_map(turned).collect();
        if turned.is_empty() {
            surface.at = moved;
            return;
        }
        lessen(&mut moves, turned, attempt);
    }
}

/// Moves the corners of some triangles back to their old positions, halfway or completely. Returns
/// which triangles this affects.
fn go_back(
    surface: &mut FitSurface,
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

/// Halves the moves of the corners of triangles. After some attempts, drops them.
fn lessen(moves: &mut [Point], triangles: Vec<[u32; 3]>, attempt: usize) {
    let factor = if attempt < HALVINGS { 0.5 } else { 0.0 };
    let mut corners = triangles.into_flattened();
    corners.sort_unstable();
    corners.dedup();
    corners.iter().for_each(|&v| moves[v as usize] = moves[v as usize].map(|x| factor * x));
}

/// Returns the bits of a position, with −0 as 0.
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
mod tests;
