//! Plans the splits of a stream from the collapses of a simplification: which corners each split
//! moves, and which triangles it adds.
//!
//! # Algorithm
//! 1. Build a corner table of the triangles of the full mesh: an edge is shared if it has exactly
//!    two triangles, one in each direction. On non-manifold surfaces and attribute seams, vertices
//!    have several fans.
//! 2. Apply the collapses one after another. For each vertex that it renames, a collapse removes
//!    one or more fans: the corners between the dropped triangles move to the fan of the kept
//!    vertex.
//! 3. Leave out collapses that do not have this form. Leave out later collapses of the vertices
//!    around it too, because their triangles would differ from the triangles of the simplification.
//!    The remaining triangles are the base mesh.
//!
//! # Complexity
//! O(n) time for fans of bounded size; 45 bytes per triangle.

use rustc_hash::FxHashMap;

use super::surface::{MAX_CORNERS, NONE, Ring, StreamSurface, corners_of, next, previous, triangle_of};
use crate::collapse::{Collapse, CollapseSequence, Rename};
use crate::mesh::{is_degenerate, triangles_of};

/// The split of one fan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct FanSplit {
    pub(super) kept: u32,
    pub(super) removed: u32,
    /// The first triangle that moves, or [`NONE`].
    pub(super) first: u32,
    /// The number of triangles that move.
    pub(super) count: u32,
    /// The triangles added before and after them, or [`NONE`].
    pub(super) added: [u32; 2],
}

/// The base mesh, and the splits that lead to the full mesh.
#[derive(Debug)]
pub(super) struct Plan {
    /// The triangles of the full mesh. Those that are drawn at the end are the base mesh.
    pub(super) surface: StreamSurface,
    pub(super) is_drawn: Vec<bool>,
    /// The vertex of each fan.
    pub(super) vertices: Vec<u32>,
    /// The splits, in the order of the collapses.
    pub(super) splits: Vec<FanSplit>,
    /// The number of splits up to each collapse.
    ends: Vec<u32>,
    /// The removed vertices of collapses that cannot become splits of fans.
    pub(super) unsplittable: Vec<u32>,
    /// The number of fans of each vertex.
    fan_counts: Vec<u32>,
}

/// A fan that a collapse removes, and its corners that move.
#[derive(Debug)]
struct Ending {
    split: FanSplit,
    moved: Vec<u32>,
}

impl Plan {
    pub(super) fn new(sequence: &CollapseSequence) -> Self {
        let triangles = sequence.triangles();
        let (surface, vertices) = surface_of(triangles);
        let mut fan_counts = vec![0; sequence.vertex_count()];
        vertices.iter().for_each(|&v| fan_counts[v as usize] += 1);
        let is_drawn = triangles_of(triangles).map(|t| !is_degenerate(t)).collect();
        let mut plan = Self {
            surface,
            is_drawn,
            vertices,
            splits: Vec::new(),
            ends: Vec::new(),
            unsplittable: Vec::new(),
            fan_counts,
        };
        let mut is_frozen = vec![false; sequence.vertex_count()];
        for collapse in sequence.iter() {
            let is_free = collapse.renames.iter().all(|rename| !is_frozen[rename.removed as usize]);
            if is_free && plan.collapse(&collapse).is_none() {
                plan.unsplittable.extend(collapse.renames.iter().map(|rename| rename.removed));
                plan.freeze(&collapse, &mut is_frozen);
            } else if !is_free {
                plan.freeze(&collapse, &mut is_frozen);
            }
            plan.ends.push(plan.splits.len() as u32);
        }
        plan
    }

    /// Locks all vertices of the triangles that a collapse would have changed.
    fn freeze(&self, collapse: &Collapse<'_>, is_frozen: &mut [bool]) {
        let mut ring = Ring::new();
        for rename in collapse.renames {
            is_frozen[rename.removed as usize] = true;
            is_frozen[rename.kept as usize] = true;
        }
        for &t in collapse.dropped {
            for fan in corners_of(t).map(|corner| self.surface.fan(corner)) {
                if collapse.renames.iter().all(|rename| rename.removed != self.vertices[fan as usize]) {
                    continue;
                }
                self.surface.ring(fan, NONE, &mut ring);
                for corner in ring.corners().iter().flat_map(|&corner| corners_of(triangle_of(corner))) {
                    is_frozen[self.vertices[self.surface.fan(corner) as usize] as usize] = true;
                }
            }
        }
    }

    /// Returns the triangles of the base mesh, as vertices of the full mesh.
    pub(super) fn base(&self) -> Vec<u32> {
        let drawn = (0..).zip(&self.is_drawn).filter(|(_, is_drawn)| **is_drawn);
        let corners = drawn.flat_map(|(t, _)| corners_of(t));
        corners.map(|corner| self.vertices[self.surface.fan(corner) as usize]).collect()
    }

    /// Returns the number of collapses that become splits.
    pub(super) fn collapse_count(&self) -> usize {
        (0..self.ends.len()).filter(|&collapse| self.end(collapse + 1) > self.end(collapse)).count()
    }

    /// Returns the number of splits up to a number of collapses.
    pub(super) fn end(&self, collapses: usize) -> usize {
        collapses.checked_sub(1).map_or(0, |last| self.ends[last] as usize)
    }

    /// Applies a collapse. Returns `None` if it cannot become splits of fans.
    fn collapse(&mut self, collapse: &Collapse<'_>) -> Option<()> {
        // 1. The fans that are removed, with the dropped triangles of each.
        let mut fans: Vec<(u32, Rename, Vec<u32>)> = Vec::new();
        for &t in collapse.dropped {
            let is_removed = |&&rename: &&Rename| self.corner_of_vertex(t, rename.removed).is_some();
            let rename = *collapse.renames.iter().find(is_removed)?;
            let fan = self.surface.fan(self.corner_of_vertex(t, rename.removed)?);
            match fans.iter_mut().find(|(other, ..)| *other == fan) {
                Some((.., dropped)) => dropped.push(t),
                None => fans.push((fan, rename, vec![t])),
            }
        }
        // All fans of each removed vertex must be removed.
        for rename in collapse.renames {
            let ended = fans.iter().filter(|(_, other, _)| other == rename).count();
            if ended == 0 || self.fan_counts[rename.removed as usize] != ended as u32 {
                return None;
            }
        }
        // 2. Check everything before the first change, so that a failed collapse changes nothing.
        let mut endings: Vec<Ending> = Vec::new();
        for (fan, rename, dropped) in &fans {
            endings.push(self.ending(*fan, *rename, dropped)?);
        }
        // A group splits a fan at most once, and no fan that it adds.
        let is_twice = |(i, ending): (usize, &Ending)| {
            let kept = ending.split.kept;
            endings[..i].iter().any(|other| other.split.kept == kept)
                || endings.iter().any(|other| other.split.removed == kept)
        };
        if endings.iter().enumerate().any(is_twice) {
            return None;
        }
        let mut firsts: Vec<(u32, u32, bool)> = Vec::new();
        for corner in collapse.dropped.iter().flat_map(|&t| corners_of(t)) {
            let fan = self.surface.fan(corner);
            if fans.iter().all(|(ending, ..)| *ending != fan)
                && firsts.iter().all(|&(other, ..)| other != fan)
            {
                let ends = || endings.iter().filter(|ending| ending.split.kept == fan);
                let moved = ends().flat_map(|ending| &ending.moved).copied();
                let own = self.remaining(fan, corner, collapse.dropped);
                let opens = ends().any(|ending| self.surface.is_open(ending.split.removed));
                firsts.push((fan, own.or_else(|| moved.clone().next())?, opens || self.surface.is_open(fan)));
            }
        }
        // 3. Apply it.
        for Ending { split, moved } in &endings {
            for (side, &t) in split.added.iter().enumerate().filter(|(_, t)| **t != NONE) {
                let kept = self.corner_of_fan(t, split.kept)?;
                // The corner of the removed fan is opposite to the outer edge at the kept fan.
                let removed = if side == 0 { previous(kept) } else { next(kept) };
                let [outer, inner] = [removed, kept].map(|c| self.surface.opposite(c));
                self.surface.join(outer, inner);
                self.is_drawn[t as usize] = false;
            }
            moved.iter().for_each(|&corner| self.surface.set_fan(corner, split.kept));
            self.surface.first[split.removed as usize] = NONE;
            self.splits.push(*split);
        }
        for (fan, corner, is_open) in firsts {
            let first = if is_open { self.surface.first_around(corner) } else { corner };
            self.surface.first[fan as usize] = first;
        }
        Some(())
    }

    /// Determines what the collapse of a fan moves, given its dropped triangles.
    fn ending(&self, fan: u32, rename: Rename, dropped: &[u32]) -> Option<Ending> {
        let mut added = [NONE; 2];
        let mut kept = None;
        for &t in dropped {
            let [own, other] = [self.corner_of_fan(t, fan)?, self.corner_of_vertex(t, rename.kept)?];
            // S is the triangle (k aₛ v), E is (k v aₑ).
            let side = usize::from(next(other) == own);
            let other = self.surface.fan(other);
            if added[side] != NONE || *kept.get_or_insert(other) != other {
                return None;
            }
            added[side] = t;
        }
        let (mut of_removed, mut of_kept) = (Ring::new(), Ring::new());
        self.surface.ring(fan, NONE, &mut of_removed);
        let (ring, is_open) = (of_removed.corners(), of_removed.is_open);
        let place = |t: u32| ring.iter().position(|&corner| triangle_of(corner) == t);
        let [start_added, end_added] = added.map(|t| t != NONE);
        let start = if start_added { place(added[0])? + 1 } else { 0 };
        let count = ring.len() - usize::from(start_added) - usize::from(end_added);
        // A fan with many corners is not split.
        self.surface.ring(kept?, NONE, &mut of_kept);
        let is_small = of_kept.corners().len() + count <= MAX_CORNERS / 2;
        let is_at_end = !end_added || place(added[1])? % ring.len() == (start + count) % ring.len();
        // An open fan starts with S; a closed one has both S and E.
        let is_whole =
            if is_open { !start_added || start == 1 } else { start_added && end_added && count > 0 };
        let moved: Vec<u32> = (start..start + count).map(|i| ring[i % ring.len()]).collect();
        let first = moved.first().map_or(NONE, |&corner| triangle_of(corner));
        let split = FanSplit { kept: kept?, removed: fan, first, count: count as u32, added };
        (is_at_end && is_whole && is_small && kept? != fan).then_some(Ending { split, moved })
    }

    /// Returns a corner of a fan that remains when triangles are dropped: its first corner, or one
    /// near `dropped_corner`, a corner of the fan in a dropped triangle.
    fn remaining(&self, fan: u32, dropped_corner: u32, dropped: &[u32]) -> Option<u32> {
        let stays = |corner: &u32| !dropped.contains(&triangle_of(*corner));
        let first = self.surface.first[fan as usize];
        let steps = 0..=dropped.len();
        let next = |corner: &Option<u32>| corner.and_then(|corner| self.surface.after(corner));
        let last = |corner: &Option<u32>| corner.and_then(|corner| self.surface.before(corner));
        let after = steps.clone().scan(Some(dropped_corner), |at, _| std::mem::replace(at, next(at)));
        let before = steps.scan(Some(dropped_corner), |at, _| std::mem::replace(at, last(at)));
        [first].into_iter().chain(after).chain(before).find(stays)
    }

    fn corner_of_vertex(&self, t: u32, vertex: u32) -> Option<u32> {
        corners_of(t).find(|&c| self.vertices[self.surface.fan(c) as usize] == vertex)
    }

    fn corner_of_fan(&self, t: u32, fan: u32) -> Option<u32> {
        corners_of(t).find(|&c| self.surface.fan(c) == fan)
    }
}

/// Builds the corner table of triangles over vertices, and the vertex of each fan. Degenerate
/// triangles have no neighbours.
fn surface_of(triangles: &[u32]) -> (StreamSurface, Vec<u32>) {
    // 1. Share the edges of two triangles. Corners are counted three per triangle here.
    let mut edges: FxHashMap<[u32; 2], (u32, u32)> = FxHashMap::default();
    let edge = |corner: usize| {
        let first = corner / 3 * 3;
        [(corner + 1) % 3, (corner + 2) % 3].map(|i| triangles[first + i])
    };
    let is_drawn = |corner: &usize| {
        let first = corner / 3 * 3;
        !is_degenerate([triangles[first], triangles[first + 1], triangles[first + 2]])
    };
    for corner in (0..triangles.len()).filter(is_drawn) {
        edges.entry(edge(corner)).or_insert((corner as u32, 0)).1 += 1;
    }
    let mut opposite = vec![NONE; triangles.len()];
    for corner in (0..triangles.len()).filter(is_drawn) {
        let [from, to] = edge(corner);
        if let (Some((_, 1)), Some((other, 1))) = (edges.get(&[from, to]), edges.get(&[to, from])) {
            opposite[corner] = *other;
        }
    }
    // 2. Number the fans.
    let surface = StreamSurface::new(&opposite);
    let mut vertices = vec![0; surface.first.len()];
    for (t, triangle) in (0..).zip(triangles_of(triangles)) {
        for (corner, vertex) in corners_of(t).zip(triangle) {
            vertices[surface.fan(corner) as usize] = vertex;
        }
    }
    (surface, vertices)
}
