//! Remaining faces: the parts of faces that no strip has taken yet, the number of neighbours of
//! each, and the part with the fewest neighbours.
//!
//! Initially, all faces of the mesh remain. A strip takes a remaining face completely or, with
//! partial triangulation, only the part between its entry and exit edges. The rest becomes one or
//! two smaller faces, and one of them gets a new number.
//!
//! ```text
//!     k'────k           the strip enters across 0 → 1 and leaves across k → k'
//!    ╱│    ╱│╲          0 1 k k' is cut out (one triangle if two of them are equal);
//!   ╱ │  ╱  │ ╲         1 … k and k' … 0 may remain if they have at least three corners
//!   ╲ │╱    │ ╱
//!    0────▶1
//! ```
//!
//! # Complexity
//! O(1) per edge taken. O(log n) per corner where polygons are cut, because the smaller part gets
//! the new number. 12 bytes per corner while polygons are cut, and 17 per face.

use super::queue::{BucketQueue, QueueOrder};
use crate::dual::DualGraph;
use crate::ids::{FaceId, HalfEdge, OptionalId};

/// Number of edges of a polygon examined on either side, where examining all could make large
/// polygons slow.
pub(super) const REACH: u32 = 32;

/// The faces, or parts of faces, that are not in a strip yet.
#[derive(Debug)]
pub(super) struct RemainingFaces<'a> {
    graph: &'a DualGraph,
    /// The corners of the remaining faces if polygons may be cut; otherwise the corners of the
    /// graph are used.
    rings: Option<FaceRings>,
    /// By face: the number of edges to a face that is free, or was free when this one was taken.
    adjacency: Vec<u32>,
    taken: Vec<bool>,
    queue: BucketQueue,
}

/// Corners in rings, one ring per remaining face. A corner represents the edge to the next corner
/// of its ring.
#[derive(Debug)]
struct FaceRings {
    next: Vec<u32>,
    previous: Vec<u32>,
    /// The remaining face that contains an original edge; none once a strip has taken the edge.
    owner: Vec<OptionalId>,
    /// A corner of each face, and its number of corners.
    heads: Vec<u32>,
    sizes: Vec<u32>,
}

/// One side of a face that a strip passes through.
#[derive(Debug, Clone, Copy)]
struct RingSide {
    first: u32,
    last: u32,
    corner_count: u32,
    /// Whether the side becomes a remaining face.
    remains: bool,
}

impl<'a> RemainingFaces<'a> {
    /// Starts with all faces. `partial` lets strips take parts of polygons. `starts` chooses among
    /// the faces with the fewest neighbours.
    pub(super) fn new(graph: &'a DualGraph, partial: bool, starts: QueueOrder) -> Self {
        let face_count = graph.face_count() as u32;
        let faces = || (0..face_count).map(FaceId);
        let adjacency: Vec<u32> = faces().map(|face| graph.neighbours(face).count() as u32).collect();
        let mut queue = BucketQueue::new(starts);
        let mut put = |face: u32| queue.put(face, adjacency[face as usize]);
        match starts {
            QueueOrder::LastChanged => (0..face_count).rev().for_each(&mut put),
            QueueOrder::FirstIn => (0..face_count).for_each(&mut put),
        }
        let has_polygons = graph.half_edge_count() > 3 * graph.face_count();
        let rings = (partial && has_polygons).then(|| FaceRings::new(graph));
        Self { graph, rings, adjacency, taken: vec![false; face_count as usize], queue }
    }

    /// Returns a free face with the fewest neighbours, the first in queue order.
    pub(super) fn fewest_neighbours(&mut self) -> Option<u32> {
        self.queue.least()
    }

    /// Returns whether parts of polygons may be taken.
    pub(super) fn is_partial(&self) -> bool {
        self.rings.is_some()
    }

    /// Returns the number of edges of a face that lead to a neighbour.
    #[inline]
    pub(super) fn adjacency(&self, face: u32) -> u32 {
        self.adjacency[face as usize]
    }

    /// Returns whether a face is in no strip.
    #[inline]
    pub(super) fn is_free(&self, face: u32) -> bool {
        !self.taken[face as usize]
    }

    /// Returns whether no strip has taken any part of an original face.
    pub(super) fn is_untouched(&self, original: u32) -> bool {
        let size = || self.graph.half_edges(FaceId(original)).count();
        self.is_free(original)
            && self.rings.as_ref().is_none_or(|rings| rings.sizes[original as usize] as usize == size())
    }

    /// Returns the remaining face of a half-edge, free or not.
    #[inline]
    fn owner(&self, half_edge: u32) -> Option<u32> {
        match &self.rings {
            Some(rings) => rings.owner[half_edge as usize].get(),
            None => Some(self.original_face(half_edge)),
        }
    }

    /// Returns the half-edge and the free face on the other side of an edge. If a strip has passed
    /// and the edge is now inside its original face, the other side is not free.
    #[inline]
    pub(super) fn across(&self, half_edge: u32) -> Option<(u32, u32)> {
        let twin = self.graph.twin_of(half_edge)?;
        self.owner(twin).filter(|&face| self.is_free(face)).map(|face| (twin, face))
    }

    /// Counts the corners of a face.
    #[inline]
    pub(super) fn size(&self, face: u32) -> u32 {
        if let Some(rings) = &self.rings {
            return rings.sizes[face as usize];
        }
        let mut corners = self.graph.half_edges(FaceId(face));
        let (first, last) = (corners.next(), corners.next_back());
        first.zip(last).map_or(0, |(first, last)| last.0 - first.0 + 1)
    }

    /// Returns a corner of a face.
    #[inline]
    pub(super) fn corner(&self, face: u32) -> u32 {
        match &self.rings {
            Some(rings) => rings.heads[face as usize],
            // Every face has at least three corners.
            None => self.graph.half_edges(FaceId(face)).next().map_or(0, |h| h.0),
        }
    }

    /// Returns the next corner of the original face.
    #[inline]
    pub(super) fn next_in_original(&self, corner: u32) -> u32 {
        let mut face = self.graph.half_edges(self.graph.face_of(HalfEdge(corner)));
        match face.next_back() {
            Some(last) if last.0 == corner => face.next().map_or(corner, |first| first.0),
            _ => corner + 1,
        }
    }

    /// Returns the next corner of the remaining face.
    #[inline]
    pub(super) fn next(&self, corner: u32) -> u32 {
        match &self.rings {
            Some(rings) => rings.next[corner as usize],
            None => self.next_in_original(corner),
        }
    }

    /// Returns the previous corner of the remaining face.
    #[inline]
    pub(super) fn previous(&self, corner: u32) -> u32 {
        match &self.rings {
            Some(rings) => rings.previous[corner as usize],
            None => previous_in_original(self.graph, corner),
        }
    }

    /// Returns the original face of a half-edge. If polygons are not cut, it is also the remaining
    /// face of the half-edge.
    #[inline]
    pub(super) fn original_face(&self, half_edge: u32) -> u32 {
        self.graph.face_of(HalfEdge(half_edge)).0
    }

    /// Returns the twin of a half-edge.
    #[inline]
    pub(super) fn twin(&self, half_edge: u32) -> Option<u32> {
        self.graph.twin_of(half_edge)
    }

    /// Returns whether at least two of the next `edge_count` edges, starting at a corner, have a
    /// free face on the other side. Of many edges only the first are examined, and the result is
    /// then `true`.
    pub(super) fn has_two_neighbours(&self, first: u32, edge_count: u32) -> bool {
        let mut corner = first;
        let mut found = 0;
        for _ in 0..edge_count.min(2 * REACH) {
            found += u32::from(self.across(corner).is_some());
            corner = self.next(corner);
        }
        found > 1 || edge_count > 2 * REACH
    }

    /// Checks the neighbour counts and the rings of the free faces.
    #[cfg(test)]
    pub(super) fn check(&self) -> Result<(), u32> {
        for face in (0..self.taken.len() as u32).filter(|&face| self.is_free(face)) {
            let (mut corner, mut adjacency) = (self.corner(face), 0);
            for _ in 0..self.size(face) {
                let twin = self.graph.twin_of(corner).filter(|_| self.owner(corner) == Some(face));
                let neighbour = twin.and_then(|twin| self.owner(twin));
                // If polygons may be cut, a face that a strip is passing through still counts.
                adjacency += u32::from(neighbour.is_some_and(|n| self.is_partial() || self.is_free(n)));
                if self.previous(self.next(corner)) != corner {
                    return Err(face);
                }
                corner = self.next(corner);
            }
            if corner != self.corner(face) || adjacency != self.adjacency(face) || !self.queue.contains(face)
            {
                return Err(face);
            }
        }
        Ok(())
    }

    /// Adds a face to the current strip. Its neighbours lose it, unless parts of it may remain.
    pub(super) fn take(&mut self, face: u32) {
        self.queue.remove(face);
        self.taken[face as usize] = true;
        if self.rings.is_none() || self.size(face) == 3 {
            self.finish(face);
        }
    }

    /// Updates the neighbours of a taken face that leaves no remainder.
    pub(super) fn finish(&mut self, face: u32) {
        let mut corner = self.corner(face);
        for _ in 0..self.size(face) {
            self.consume(corner);
            corner = self.next(corner);
        }
    }

    /// Takes an edge: the face across it loses a neighbour.
    fn consume(&mut self, half_edge: u32) {
        let neighbour = self.graph.twin_of(half_edge).and_then(|twin| self.owner(twin));
        if let Some(rings) = &mut self.rings {
            let Some(face) = std::mem::take(&mut rings.owner[half_edge as usize]).get() else { return };
            if neighbour.is_some() {
                self.adjacency[face as usize] -= 1;
            }
        }
        if let Some(neighbour) = neighbour
            && (self.rings.is_some() || self.is_free(neighbour))
        {
            let adjacency = &mut self.adjacency[neighbour as usize];
            *adjacency -= 1;
            if self.queue.contains(neighbour) {
                self.queue.put(neighbour, *adjacency);
            }
        }
    }

    /// Cuts out the part of a taken face that a strip needs. The strip enters across the first
    /// half-edge and leaves across the second, the `exit_offset`-th after it. `rests` contains
    /// whether each side's remainder is kept, by the chain of the side. A remainder becomes free.
    pub(super) fn cut(&mut self, face: u32, [entry, exit]: [u32; 2], exit_offset: u32, rests: [bool; 2]) {
        let size = self.size(face);
        if size == 3 {
            return;
        }
        let mut sides = [
            RingSide { first: self.next(entry), last: exit, corner_count: exit_offset, remains: rests[0] },
            RingSide {
                first: self.next(exit),
                last: entry,
                corner_count: size - exit_offset,
                remains: rests[1],
            },
        ];
        self.consume(entry);
        self.consume(exit);
        for side in sides {
            if !side.remains {
                let mut corner = side.first;
                for _ in 1..side.corner_count {
                    self.consume(corner);
                    corner = self.next(corner);
                }
            } else if let Some(rings) = &mut self.rings {
                rings.next[side.last as usize] = side.first;
                rings.previous[side.first as usize] = side.last;
            }
        }
        sides.sort_unstable_by_key(|side| (side.remains, side.corner_count));
        let [smaller, larger] = sides;
        if smaller.remains {
            self.split_off(face, smaller.first, smaller.corner_count);
        }
        if larger.remains
            && let Some(rings) = &mut self.rings
        {
            rings.heads[face as usize] = larger.first;
            rings.sizes[face as usize] = larger.corner_count;
            self.taken[face as usize] = false;
            self.queue.put(face, self.adjacency[face as usize]);
        }
    }

    /// Adds a new face for a ring that was split off another one.
    fn split_off(&mut self, face: u32, first: u32, size: u32) {
        let new = self.taken.len() as u32;
        let mut adjacency = 0;
        let mut corner = first;
        for _ in 0..size {
            if self.owner(corner).is_some() {
                let neighbour = self.graph.twin_of(corner).and_then(|twin| self.owner(twin));
                adjacency += u32::from(neighbour.is_some());
                if let Some(rings) = &mut self.rings {
                    rings.owner[corner as usize] = OptionalId::some(new);
                }
            }
            corner = self.next(corner);
        }
        if let Some(rings) = &mut self.rings {
            rings.heads.push(first);
            rings.sizes.push(size);
        }
        self.adjacency[face as usize] -= adjacency;
        self.adjacency.push(adjacency);
        self.taken.push(false);
        self.queue.put(new, adjacency);
    }
}

/// Returns the previous corner of the original face.
fn previous_in_original(graph: &DualGraph, corner: u32) -> u32 {
    let mut face = graph.half_edges(graph.face_of(HalfEdge(corner)));
    match face.next() {
        Some(first) if first.0 == corner => face.next_back().map_or(corner, |last| last.0),
        _ => corner - 1,
    }
}

impl FaceRings {
    fn new(graph: &DualGraph) -> Self {
        let corner_count = graph.half_edge_count();
        let mut rings = Self {
            next: (1..=corner_count as u32).collect(),
            previous: (0..corner_count as u32).map(|corner| corner.wrapping_sub(1)).collect(),
            owner: Vec::with_capacity(corner_count),
            heads: Vec::with_capacity(graph.face_count()),
            sizes: Vec::with_capacity(graph.face_count()),
        };
        for face in 0..graph.face_count() as u32 {
            let first = rings.owner.len();
            rings.owner.extend(graph.half_edges(FaceId(face)).map(|_| OptionalId::some(face)));
            let last = rings.owner.len() - 1;
            rings.next[last] = first as u32;
            rings.previous[first] = last as u32;
            rings.heads.push(first as u32);
            rings.sizes.push((last - first + 1) as u32);
        }
        rings
    }
}
