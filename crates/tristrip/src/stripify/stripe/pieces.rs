//! Pieces: what strips have left of the faces, how many neighbours each piece has, and which has the fewest.
//!
//! At first every face is a piece. A strip takes a piece whole, or, where partial triangulation is on, only the part between
//! the edges by which it enters and leaves; the rest becomes one or two smaller pieces.
//!
//! ```text
//!     k'────k           the strip enters across 0 → 1 and leaves across k → k'
//!    ╱│    ╱│╲          0 1 k k' is cut out (one triangle where two of them are equal);
//!   ╱ │  ╱  │ ╲         1 … k and k' … 0 may be left, where they have three corners or more
//!   ╲ │╱    │ ╱
//!    0────▶1
//! ```
//!
//! # Complexity
//! O(1) for each edge taken; O(log n) for each corner where polygons are cut, as the smaller rest gets the new number.
//! 12 bytes a corner while polygons are cut, 17 a piece.

use super::queue::BucketQueue;
use crate::dual::DualGraph;
use crate::ids::{FaceId, HalfEdge};

const NONE: u32 = u32::MAX;
/// How many edges of a polygon are looked at, on either side, where looking at all could make large polygons slow.
pub(super) const REACH: u32 = 32;

/// The parts of the faces that are not yet in a strip.
#[derive(Debug)]
pub(super) struct Pieces<'a> {
    graph: &'a DualGraph,
    /// The pieces' corners, where polygons may be cut; else every piece is a face.
    rings: Option<Rings>,
    /// Edges of each piece that lead to a piece which is still free, or was when this one was taken.
    adjacency: Vec<u32>,
    taken: Vec<bool>,
    queue: BucketQueue,
}

/// Corners in rings, one for each piece. A corner stands for the edge to the next one of its ring.
#[derive(Debug)]
struct Rings {
    next: Vec<u32>,
    previous: Vec<u32>,
    /// The piece that a face's edge belongs to; `NONE` once a strip has taken it.
    owner: Vec<u32>,
    /// A corner of each piece, and how many it has.
    heads: Vec<u32>,
    sizes: Vec<u32>,
}

impl<'a> Pieces<'a> {
    /// Makes a piece of every face; `partial` lets strips take parts of polygons.
    pub(super) fn new(graph: &'a DualGraph, partial: bool) -> Self {
        let face_count = graph.face_count() as u32;
        let faces = || (0..face_count).map(FaceId);
        let adjacency: Vec<u32> = faces().map(|face| graph.neighbours(face).count() as u32).collect();
        let mut queue = BucketQueue::default();
        (0..face_count).rev().for_each(|piece| queue.put(piece, adjacency[piece as usize]));
        let rings = (partial && graph.half_edge_count() > 3 * graph.face_count()).then(|| Rings::new(graph));
        Self { graph, rings, adjacency, taken: vec![false; face_count as usize], queue }
    }

    /// Gives a free piece with the fewest neighbours, the one that changed last.
    pub(super) fn fewest_neighbours(&mut self) -> Option<u32> {
        self.queue.least()
    }

    /// Tells whether parts of polygons may be taken.
    pub(super) fn partial(&self) -> bool {
        self.rings.is_some()
    }

    /// Counts the neighbours of a piece, over its edges.
    #[inline]
    pub(super) fn adjacency(&self, piece: u32) -> u32 {
        self.adjacency[piece as usize]
    }

    /// Tells whether a piece is in no strip.
    #[inline]
    pub(super) fn is_free(&self, piece: u32) -> bool {
        !self.taken[piece as usize]
    }

    /// Tells whether no strip has taken any part of a face.
    pub(super) fn is_untouched(&self, face: u32) -> bool {
        let size = || self.graph.half_edges(FaceId(face)).count();
        self.is_free(face)
            && self.rings.as_ref().is_none_or(|rings| rings.sizes[face as usize] as usize == size())
    }

    /// Gives the piece that a half-edge belongs to, free or not.
    #[inline]
    fn owner(&self, half_edge: u32) -> Option<u32> {
        match &self.rings {
            Some(rings) => Some(rings.owner[half_edge as usize]).filter(|&piece| piece != NONE),
            None => Some(self.graph.face_of(HalfEdge(half_edge)).0),
        }
    }

    /// Gives the half-edge and the free piece on the other side of a piece's edge. Where a strip has passed, and the edge is
    /// inside the face now, the other side is not free.
    #[inline]
    pub(super) fn across(&self, half_edge: u32) -> Option<(u32, u32)> {
        let twin = self.graph.twin(HalfEdge(half_edge))?.0;
        self.owner(twin).filter(|&piece| self.is_free(piece)).map(|piece| (twin, piece))
    }

    /// Counts the corners of a piece.
    #[inline]
    pub(super) fn size(&self, piece: u32) -> u32 {
        if let Some(rings) = &self.rings {
            return rings.sizes[piece as usize];
        }
        let mut corners = self.graph.half_edges(FaceId(piece));
        let (first, last) = (corners.next(), corners.next_back());
        first.zip(last).map_or(0, |(first, last)| last.0 - first.0 + 1)
    }

    /// Gives a corner of a piece.
    #[inline]
    pub(super) fn corner(&self, piece: u32) -> u32 {
        match &self.rings {
            Some(rings) => rings.heads[piece as usize],
            None => self.graph.half_edges(FaceId(piece)).next().map_or(NONE, |h| h.0),
        }
    }

    /// Gives the corner after this one in its face.
    #[inline]
    pub(super) fn after(&self, corner: u32) -> u32 {
        let mut face = self.graph.half_edges(self.graph.face_of(HalfEdge(corner)));
        match face.next_back() {
            Some(last) if last.0 == corner => face.next().map_or(corner, |first| first.0),
            _ => corner + 1,
        }
    }

    /// Gives the corner after this one in its piece.
    #[inline]
    pub(super) fn next(&self, corner: u32) -> u32 {
        match &self.rings {
            Some(rings) => rings.next[corner as usize],
            None => self.after(corner),
        }
    }

    /// Gives the corner before this one in its piece.
    #[inline]
    pub(super) fn previous(&self, corner: u32) -> u32 {
        match &self.rings {
            Some(rings) => rings.previous[corner as usize],
            None => before(self.graph, corner),
        }
    }

    /// Gives the face of a half-edge, which is its piece where polygons are not cut.
    #[inline]
    pub(super) fn face(&self, half_edge: u32) -> u32 {
        self.graph.face_of(HalfEdge(half_edge)).0
    }

    /// Gives the half-edge on the other side.
    #[inline]
    pub(super) fn twin(&self, half_edge: u32) -> Option<u32> {
        self.graph.twin(HalfEdge(half_edge)).map(|h| h.0)
    }

    /// Tells whether two of the next `edges` edges, from a corner on, have a free piece on the other side. Of many edges only
    /// the first are looked at, and the answer is then yes.
    pub(super) fn has_two_neighbours(&self, first: u32, edges: u32) -> bool {
        let mut corner = first;
        let mut found = 0;
        for _ in 0..edges.min(2 * REACH) {
            found += u32::from(self.across(corner).is_some());
            corner = self.next(corner);
        }
        found > 1 || edges > 2 * REACH
    }

    /// Checks what is kept of the free pieces' neighbours and rings.
    #[cfg(test)]
    pub(super) fn check(&self) -> Result<(), u32> {
        for piece in (0..self.taken.len() as u32).filter(|&piece| self.is_free(piece)) {
            let (mut corner, mut adjacency) = (self.corner(piece), 0);
            for _ in 0..self.size(piece) {
                let twin = self.graph.twin(HalfEdge(corner)).filter(|_| self.owner(corner) == Some(piece));
                let neighbour = twin.and_then(|h| self.owner(h.0));
                // Where pieces may be cut, one that is being passed still counts.
                adjacency += u32::from(neighbour.is_some_and(|n| self.partial() || self.is_free(n)));
                if self.previous(self.next(corner)) != corner {
                    return Err(piece);
                }
                corner = self.next(corner);
            }
            if corner != self.corner(piece)
                || adjacency != self.adjacency(piece)
                || !self.queue.contains(piece)
            {
                return Err(piece);
            }
        }
        Ok(())
    }

    /// Puts a piece into the strip that is being made. Its neighbours lose it, unless parts of it may stay.
    pub(super) fn take(&mut self, piece: u32) {
        self.queue.remove(piece);
        self.taken[piece as usize] = true;
        if self.rings.is_none() || self.size(piece) == 3 {
            self.finish(piece);
        }
    }

    /// Lets the neighbours of a taken piece know that nothing of it will stay.
    pub(super) fn finish(&mut self, piece: u32) {
        let mut corner = self.corner(piece);
        for _ in 0..self.size(piece) {
            self.consume(corner);
            corner = self.next(corner);
        }
    }

    /// Takes an edge out: the piece across it loses a neighbour.
    fn consume(&mut self, half_edge: u32) {
        let twin = self.graph.twin(HalfEdge(half_edge)).map(|h| h.0);
        let neighbour = twin.and_then(|h| self.owner(h));
        if let Some(rings) = &mut self.rings {
            let piece = std::mem::replace(&mut rings.owner[half_edge as usize], NONE);
            if piece == NONE {
                return;
            }
            if neighbour.is_some() {
                self.adjacency[piece as usize] -= 1;
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

    /// Cuts what a strip needs out of a taken piece, which it enters across the first half-edge and leaves across the second,
    /// the `place`th after it. `rests` says on which sides the rest is to be left, by the letter of the side's chain; it
    /// becomes free.
    pub(super) fn cut(&mut self, piece: u32, [entry, exit]: [u32; 2], place: u32, rests: [bool; 2]) {
        let size = self.size(piece);
        if size == 3 {
            return;
        }
        let mut sides =
            [(self.next(entry), exit, place, rests[0]), (self.next(exit), entry, size - place, rests[1])];
        self.consume(entry);
        self.consume(exit);
        for (first, last, corners, stays) in sides {
            if !stays {
                let mut corner = first;
                for _ in 1..corners {
                    self.consume(corner);
                    corner = self.next(corner);
                }
            } else if let Some(rings) = &mut self.rings {
                rings.next[last as usize] = first;
                rings.previous[first as usize] = last;
            }
        }
        sides.sort_unstable_by_key(|&(_, _, corners, stays)| (stays, corners));
        let [smaller, larger] = sides;
        if smaller.3 {
            self.split_off(piece, smaller.0, smaller.2);
        }
        if larger.3
            && let Some(rings) = &mut self.rings
        {
            rings.heads[piece as usize] = larger.0;
            rings.sizes[piece as usize] = larger.2;
            self.taken[piece as usize] = false;
            self.queue.put(piece, self.adjacency[piece as usize]);
        }
    }

    /// Makes a new piece of a ring that was cut off another one.
    fn split_off(&mut self, piece: u32, first: u32, size: u32) {
        let new = self.taken.len() as u32;
        let mut adjacency = 0;
        let mut corner = first;
        for _ in 0..size {
            if self.owner(corner).is_some() {
                let twin = self.graph.twin(HalfEdge(corner));
                adjacency += u32::from(twin.is_some_and(|h| self.owner(h.0).is_some()));
                if let Some(rings) = &mut self.rings {
                    rings.owner[corner as usize] = new;
                }
            }
            corner = self.next(corner);
        }
        if let Some(rings) = &mut self.rings {
            rings.heads.push(first);
            rings.sizes.push(size);
        }
        self.adjacency[piece as usize] -= adjacency;
        self.adjacency.push(adjacency);
        self.taken.push(false);
        self.queue.put(new, adjacency);
    }
}

/// Gives the corner before this one in its face.
fn before(graph: &DualGraph, corner: u32) -> u32 {
    let mut face = graph.half_edges(graph.face_of(HalfEdge(corner)));
    match face.next() {
        Some(first) if first.0 == corner => face.next_back().map_or(corner, |last| last.0),
        _ => corner - 1,
    }
}

impl Rings {
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
            rings.owner.extend(graph.half_edges(FaceId(face)).map(|_| face));
            let last = rings.owner.len() - 1;
            rings.next[last] = first as u32;
            rings.previous[first] = last as u32;
            rings.heads.push(first as u32);
            rings.sizes.push((last - first + 1) as u32);
        }
        rings
    }
}
