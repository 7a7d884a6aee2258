//! Strips of a mesh during refinement, developed for this library. They are maintained while splits
//! add triangles, and never recomputed from scratch.
//!
//! ```text
//!     ╲    aₛ               ╲    aₛ
//!   ━━ ╲━━│━━ ╱        ━━ ╲━━╱S╲━━ ╱
//!       ╲ │ ╱               ╲╱━━╲╱
//!         k                 k    v
//! ```
//! A split inserts the triangle S between the two sides of the edge k–aₛ, which becomes two edges.
//! A strip that crosses the edge passes through S afterwards. No other link changes.
//!
//! # Algorithm
//! 1. *Split*: each new triangle on a link is inserted into the link; the other new triangles
//!    become strips of their own.
//! 2. After a *chunk*, its new triangles are joined in order to the ends of neighbouring strips. A
//!    triangle is joined across the edge that reduces the number of vertices sent most, until no
//!    edge reduces this number.
//! 3. *Search*: take the triangles nearest to the new ones, four per new triangle. A local search
//!    (see `cover/local_search.rs`) starts four times from each of these triangles that is at the
//!    end of a strip, and then once from each of them.
//!
//! The base mesh is the first chunk: all its triangles are new, and it gets more search.
//!
//! # Determinism
//! The strips depend only on the chunks, not on when their bytes arrive. Decoders in other
//! languages perform the same steps with the same random numbers.
//!
//! # Complexity
//! A split takes O(1) time, a chunk time proportional to the triangles that it adds. 20 bytes and
//! one bit per triangle.
//!
//! # Vertices sent
//! The table lists the vertices sent in percent of a triangle list, which sends three vertices per
//! triangle, as the mean over all chunks and for the full mesh, with the default options. Values in
//! parentheses include an index between strips. Times are for all chunks. For the bunny, the levels
//! of Kim et al. 2005 with their filter send 54.4 %, and require the strips of the full mesh in the
//! stream. These take an estimated 1.2 bits per vertex (`strip_links` of the benchmarks), which is
//! 5 % more bytes.
//!
//! | model | chunks | mean | full mesh | decoding, ms | with strips, ms |
//! |---|---|---|---|---|---|
//! | bunny | 31 | 42.3 (44.0) | 39.9 (41.2) | 22 | 121 |
//! | horse | 38 | 42.1 (43.8) | 40.2 (41.5) | 29 | 189 |
//! | dragon | 249 | 42.4 (44.1) | 42.5 (44.2) | 349 | 1785 |
//!
//! # References
//! Kim, Park, Yang, Neelamkavil: *A Rendering-Efficient Progressive Transmission of 3D Meshes*,
//! 2005 (strips stored in a stream). Porcu, Sanna, Scateni: *Efficiently Keeping an Optimal
//! Stripification over a CLOD Mesh*, 2005 (repair next to each change).

use super::surface::{NONE, StreamSurface, corners_of, triangle_of};
#[cfg(test)]
use crate::cover::priced::PricedPaths;
use crate::lod::{RepairedPaths, walk_steps};
use crate::strip::{Cost, Strips};

/// The number of triangles per new triangle from which the search after a chunk starts, and the
/// numbers of rounds from strip ends and from all of them. Tuned on the bunny: halving the first
/// two sends 4 % more vertices in half of the time.
const NEAR: usize = 4;
const ROUNDS_OF_ENDS: u32 = 4;
const ROUNDS: u32 = 1;
/// The number of rounds of search from all triangles of the base mesh.
const BASE_ROUNDS: u32 = 10;

/// The strips of a mesh during refinement.
#[derive(Debug, Clone)]
pub(super) struct KeptStrips {
    repaired: RepairedPaths,
    /// The number of triangles before the current chunk.
    known: u32,
}

/// Returns the half-edge opposite to a corner. Half-edges are numbered by fours: edge e of triangle
/// t, which begins at corner e, is 4 t + e.
fn opposite_side(corner: u32) -> u32 {
    let e = corner & 7;
    4 * triangle_of(corner) + if e == 2 { 0 } else { e + 1 }
}

impl KeptStrips {
    /// Builds the strips of a base mesh.
    pub(super) fn new(surface: &StreamSurface) -> Self {
        let count = surface.triangle_count();
        let mut repaired = RepairedPaths::empty(count, Cost::OpenGl.prices(), 0);
        let paths = &mut repaired.paths;
        (0..count as u32).for_each(|t| paths.insert_triangle(t));
        for corner in surface.corners() {
            let other = surface.opposite(corner);
            paths.set_twin(opposite_side(corner), (other != NONE).then(|| opposite_side(other)));
        }
        let mut strips = Self { repaired, known: 0 };
        strips.finish_chunk(BASE_ROUNDS);
        strips
    }

    /// Updates the strips after a split that has added the triangles S and E, given by their first
    /// corners or [`NONE`].
    pub(super) fn follow_split(&mut self, surface: &StreamSurface, [start, end]: [u32; 2]) {
        self.repaired.grow(surface.triangle_count());
        if start != NONE {
            self.insert(surface, [start + 2, start]);
        }
        if end != NONE {
            self.insert(surface, [end + 1, end]);
        }
        if start != NONE && end != NONE {
            self.pair(opposite_side(start + 1), opposite_side(end + 2));
        }
    }

    /// Inserts a triangle between the two sides of an edge. `corners` are opposite to its edges
    /// there.
    fn insert(&mut self, surface: &StreamSurface, corners: [u32; 2]) {
        self.repaired.paths.insert_triangle(triangle_of(corners[0]));
        let sides = corners.map(opposite_side);
        let beyond = corners.map(|corner| surface.opposite(corner));
        let outer = beyond.map(|other| (other != NONE).then(|| opposite_side(other)));
        if let [Some(a), Some(_)] = outer
            && self.repaired.paths.is_linked(a)
        {
            self.repaired.paths.insert_into_link(a, sides);
            return;
        }
        for (side, outer) in sides.into_iter().zip(outer) {
            if let Some(outer) = outer {
                self.pair(side, outer);
            }
        }
    }

    fn pair(&mut self, a: u32, b: u32) {
        self.repaired.paths.set_twin(a, Some(b));
        self.repaired.paths.set_twin(b, Some(a));
    }

    /// Joins the new triangles to strips, and searches near them.
    pub(super) fn follow_chunk(&mut self) {
        self.finish_chunk(ROUNDS);
    }

    fn finish_chunk(&mut self, rounds: u32) {
        let repaired = &mut self.repaired;
        let count = repaired.paths.len() as u32;
        let new = self.known..count;
        new.clone().for_each(|t| repaired.paths.join_ends(t));
        let most = NEAR.saturating_mul(new.len()).min(count as usize);
        repaired.find_near(new, most);
        repaired.paths.allow_walks(walk_steps(ROUNDS_OF_ENDS + rounds, most));
        repaired.search_near(ROUNDS_OF_ENDS, |paths, t| paths.degree(t) < 2);
        repaired.search_near(rounds, |_, _| true);
        self.known = count;
    }

    /// Returns the number of vertices of all strips, including swaps and winding repeats.
    pub(super) fn vertices_sent(&self) -> usize {
        self.repaired.vertices_sent(self.repaired.paths.len())
    }

    /// Builds the strips, in O(n) time. `vertex` returns the vertex of a corner.
    pub(super) fn emit(&self, vertex: impl Fn(u32) -> u32) -> Strips {
        self.repaired.emit(|t| {
            let first = corners_of(t).start;
            Some([first, first + 1, first + 2].map(&vertex))
        })
    }

    /// Returns the memory in bytes.
    pub(super) fn memory(&self) -> usize {
        self.repaired.memory()
    }

    #[cfg(test)]
    pub(super) fn paths(&self) -> &PricedPaths {
        &self.repaired.paths
    }
}
