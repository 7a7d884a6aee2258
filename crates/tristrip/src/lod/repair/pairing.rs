//! Updates the twins of half-edges at collapses and splits. Half-edges of triangles are called
//! *sides* here.
//!
//! ```text
//!          x
//!        ╱ │ ╲
//!      k ━ r   ∙
//! ```
//! A collapse of r to k renames the edges r–x, and drops the triangles at the edge r–k. Only the
//! edges k–x change. Their sides are *released* if they came from r or if their twin was dropped.
//! All other twins remain, no matter how many triangles surround k or share the edge.
//!
//! If an edge has two sides, they are twins if they have opposite directions. If it has more, the
//! sides that were twins remain twins. The others have no twin. After each change they are paired
//! like brackets. In the order of the triangles, each side is paired with the last side of the
//! opposite direction that has no twin yet. All sides of an edge that remain without a twin
//! therefore have the same direction.
//!
//! # Algorithm
//! The sides without a twin are kept in a set ordered by edge. To pair the released sides of an
//! edge:
//! 1. Released sides with the same direction as the sides of the set are added to the set.
//! 2. Each of the others, in order, is paired with the last side of the set before it. If there is
//!    no such side, it is *pending*. The next sides of the set are paired with the pending sides,
//!    starting with the last one.
//! 3. Sides that remain pending form the new set.
//!
//! # Complexity
//! O(log n) time per released side. About 24 bytes per side without a twin.

use std::collections::BTreeSet;

use crate::collapse::Collapse;
use crate::cover::priced::PricedPaths;
use crate::lod::level::level_mesh::LevelMesh;

/// A side without a twin: the lower and the higher vertex of its edge, and its half-edge.
type UnpairedSide = [u32; 3];

/// The sides of a level that have no twin, and the sides released by a change.
#[derive(Debug, Clone, Default)]
pub(super) struct Pairing {
    unpaired: BTreeSet<UnpairedSide>,
    released: Vec<u32>,
    pending: Vec<u32>,
}

/// Half-edges whose twins change, and their new twins.
pub(super) type TwinChanges = Vec<(u32, Option<u32>)>;

impl Pairing {
    /// Pairs the sides of a level that have no twin yet.
    pub(super) fn of(mesh: &LevelMesh, paths: &PricedPaths, changes: &mut TwinChanges) -> Self {
        let mut pairing = Self::default();
        let drawn = (0..mesh.triangle_count() as u32).filter(|&t| mesh.is_drawn(t));
        pairing.released = drawn.flat_map(sides_of).filter(|&h| paths.twin(h).is_none()).collect();
        pairing.pair(mesh, paths, sorted, changes);
        pairing
    }

    /// Returns the memory in bytes.
    pub(super) fn memory(&self) -> usize {
        2 * self.unpaired.len() * size_of::<UnpairedSide>()
    }

    /// Releases the sides that a collapse will change. Call it before the mesh changes.
    pub(super) fn release_for_collapse(
        &mut self,
        collapse: &Collapse<'_>,
        mesh: &LevelMesh,
        paths: &PricedPaths,
    ) {
        self.released.clear();
        let renamed = collapse.renames.iter().flat_map(|rename| mesh.around(rename.removed));
        for h in collapse.dropped.iter().flat_map(|&t| sides_of(t)).chain(renamed.flat_map(sides_at)) {
            match paths.twin(h) {
                Some(twin) if is_dropped(collapse, h) => self.released.push(twin),
                Some(_) => {}
                None => {
                    self.unpaired.remove(&unpaired(mesh.edge(h), h));
                    self.released.push(h);
                }
            }
        }
        self.released.retain(|&h| !is_dropped(collapse, h));
    }

    /// Releases the sides that a split has changed. Call it after the mesh has changed and the
    /// restored triangles were inserted.
    pub(super) fn release_for_split(
        &mut self,
        collapse: &Collapse<'_>,
        mesh: &LevelMesh,
        paths: &PricedPaths,
    ) {
        self.released.clear();
        self.released.extend(collapse.dropped.iter().flat_map(|&t| sides_of(t)));
        let mut renames = collapse.renames.to_vec();
        renames.sort_unstable_by_key(|rename| rename.removed);
        let renamed = |v: u32| match renames.binary_search_by_key(&v, |rename| rename.removed) {
            Ok(i) => renames[i].kept,
            Err(_) => v,
        };
        for h in collapse.renames.iter().flat_map(|rename| mesh.around(rename.removed)).flat_map(sides_at) {
            let edge = mesh.edge(h);
            let [from, to] = edge;
            match paths.twin(h) {
                Some(twin) if mesh.edge(twin) != [to, from] => self.released.extend([h, twin]),
                Some(_) => {}
                None => {
                    self.unpaired.remove(&unpaired(edge.map(renamed), h));
                    self.released.push(h);
                }
            }
        }
    }

    /// Pairs the released sides around vertices. Appends the changes in the order of the vertices,
    /// and for each vertex in the order of its neighbours.
    pub(super) fn pair_around(
        &mut self,
        vertices: impl Iterator<Item = u32>,
        mesh: &LevelMesh,
        paths: &PricedPaths,
        changes: &mut TwinChanges,
    ) {
        let mut ranks: Vec<(u32, u32)> = vertices.zip(0..).collect();
        ranks.sort_unstable();
        let rank = |v: u32| {
            let at = ranks.partition_point(|&(other, _)| other < v);
            ranks.get(at).filter(|&&(other, _)| other == v).map_or(u32::MAX, |&(_, rank)| rank)
        };
        let row = |[a, b]: [u32; 2]| [[rank(a), b], [rank(b), a]].into_iter().min().unwrap_or_default();
        self.pair(mesh, paths, row, changes);
    }

    /// Pairs the released sides edge by edge, ordered by a key of each edge.
    fn pair(
        &mut self,
        mesh: &LevelMesh,
        paths: &PricedPaths,
        key: impl Fn([u32; 2]) -> [u32; 2],
        changes: &mut TwinChanges,
    ) {
        let mut released = std::mem::take(&mut self.released);
        let mut rows: Vec<([u32; 2], u32)> = released.drain(..).map(|h| (key(mesh.edge(h)), h)).collect();
        rows.sort_unstable();
        rows.dedup();
        for row in rows.chunk_by(|a, b| a.0 == b.0) {
            self.pair_edge(row.iter().map(|&(_, h)| h), mesh, changes);
            for &(_, h) in row {
                if paths.twin(h).is_some() && self.unpaired.contains(&unpaired(mesh.edge(h), h)) {
                    changes.push((h, None));
                }
            }
        }
        self.released = released;
    }

    /// Pairs the sorted released sides of one edge.
    fn pair_edge(
        &mut self,
        sides: impl Iterator<Item = u32> + Clone,
        mesh: &LevelMesh,
        changes: &mut TwinChanges,
    ) {
        let Some(first) = sides.clone().next() else { return };
        let [low, high] = sorted(mesh.edge(first));
        let is_up = |h: u32| mesh.edge(h)[0] == low;
        let mut set = EdgeSides { sides: &mut self.unpaired, edge: [low, high] };
        let up = is_up(set.after(0).unwrap_or(first));
        sides.clone().filter(|&h| is_up(h) == up).for_each(|h| set.insert(h));
        let pending = &mut self.pending;
        pending.clear();
        let mut pair =
            |earlier: u32, later: u32| changes.extend([(earlier, Some(later)), (later, Some(earlier))]);
        let mut seen = 0;
        for h in sides.filter(|&h| is_up(h) != up).map(Some).chain([None]) {
            while let Some(&last) = pending.last()
                && let Some(next) = set.after(seen).filter(|&next| h.is_none_or(|h| next < h))
            {
                pending.pop();
                set.remove(next);
                pair(last, next);
                seen = next;
            }
            let Some(h) = h else { break };
            match set.before(h).filter(|_| pending.is_empty()) {
                Some(last) => {
                    set.remove(last);
                    pair(last, h);
                }
                None => pending.push(h),
            }
            seen = h;
        }
        pending.iter().for_each(|&h| set.insert(h));
    }
}

/// The sides of one edge in the set of those without a twin.
struct EdgeSides<'a> {
    sides: &'a mut BTreeSet<UnpairedSide>,
    edge: [u32; 2],
}

impl EdgeSides<'_> {
    fn side(&self, h: u32) -> UnpairedSide {
        [self.edge[0], self.edge[1], h]
    }

    /// Returns the first side at or after a half-edge.
    fn after(&self, h: u32) -> Option<u32> {
        self.sides.range(self.side(h)..=self.side(u32::MAX)).next().map(|side| side[2])
    }

    /// Returns the last side before a half-edge.
    fn before(&self, h: u32) -> Option<u32> {
        self.sides.range(self.side(0)..self.side(h)).next_back().map(|side| side[2])
    }

    fn insert(&mut self, h: u32) {
        self.sides.insert(self.side(h));
    }

    fn remove(&mut self, h: u32) {
        self.sides.remove(&self.side(h));
    }
}

fn unpaired(edge: [u32; 2], h: u32) -> UnpairedSide {
    let [low, high] = sorted(edge);
    [low, high, h]
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Returns the half-edges of a triangle, numbered by fours.
fn sides_of(t: u32) -> [u32; 3] {
    [4 * t, 4 * t + 1, 4 * t + 2]
}

/// Returns the half-edges that begin and end at a corner.
fn sides_at(corner: u32) -> [u32; 2] {
    let (t, e) = (corner / 3, corner % 3);
    [4 * t + e, 4 * t + (e + 2) % 3]
}

fn is_dropped(collapse: &Collapse<'_>, h: u32) -> bool {
    collapse.dropped.binary_search(&(h / 4)).is_ok()
}
