//! The k-star of a terminal: the triangles at most k steps away. Temporary edges bridge strips
//! where they leave the star and return.
//!
//! ```text
//!      star │ outside            Between two crossings of the same strip, one temporary edge
//!   ━━ a ━━━┿━ o ━ o             replaces the outside. A strip that ends outside keeps a
//!      ┊    │      ┃             single crossing, where it neither continues nor ends.
//!   ━━ c ━━━┿━ o ━ o
//! ```
//! # Complexity
//! O(star + crossings · log crossings) time. 8 bytes per triangle and 32 per crossing.

use super::tagged_strips::{TagLink, TaggedStrips};
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::ids::{FaceId, HalfEdge};
use crate::stripify::tunnel::path_tags::PathTags;

/// The star of the last search.
#[derive(Debug, Default)]
pub(super) struct EtaStar {
    stamp: u32,
    /// The stamp of the last star that contained each triangle.
    stamps: Vec<u32>,
    triangles: Vec<u32>,
    crossings: Vec<StarCrossing>,
}

/// A crossing of a strip and the boundary of a star.
#[derive(Debug, Clone, Copy)]
struct StarCrossing {
    path: u32,
    /// The positions of the triangles inside and outside.
    inside: u32,
    outside: u32,
    triangle: u32,
    /// The half-edge that leads outside.
    half_edge: u32,
    /// The link that replaces it.
    link: TagLink,
}

impl EtaStar {
    /// Finds the star of a terminal, and replaces the links that cross its boundary. Returns the
    /// number of node accesses.
    pub(super) fn build(
        &mut self,
        (graph, cover, tags): (&DualGraph, &PathCover, &PathTags),
        terminal: u32,
        length: u32,
        strips: &mut TaggedStrips,
    ) -> u64 {
        let last_ring = self.find(graph, cover.len(), terminal, length);
        self.crossings.clear();
        for &triangle in &self.triangles[last_ring] {
            for HalfEdge(half_edge) in cover.edges(FaceId(triangle)).into_iter().flatten() {
                let Some(twin) = graph.twin_of(half_edge) else { continue };
                if self.stamps[twin as usize / 3] != self.stamp {
                    self.crossings.push(StarCrossing {
                        path: tags.path(triangle),
                        inside: tags.position(triangle),
                        outside: tags.position(twin / 3),
                        triangle,
                        half_edge,
                        link: TagLink::Outside,
                    });
                }
            }
        }
        self.crossings
            .sort_unstable_by_key(|crossing| (crossing.path, crossing.inside.min(crossing.outside)));
        for i in 1..self.crossings.len() {
            let [leaving, back] = [self.crossings[i - 1], self.crossings[i]];
            if leaving.path == back.path && leaving.inside < leaving.outside && back.outside < back.inside {
                self.crossings[i - 1].link = TagLink::Temporary(back.triangle);
                self.crossings[i].link = TagLink::Temporary(leaving.triangle);
            }
        }
        for crossing in &self.crossings {
            strips.replace(crossing.triangle, TagLink::Black(crossing.half_edge), crossing.link);
        }
        (self.triangles.len() + self.crossings.len()) as u64
    }

    /// Restores the links that cross the boundary.
    pub(super) fn remove(&self, strips: &mut TaggedStrips) {
        for crossing in &self.crossings {
            strips.replace(crossing.triangle, crossing.link, TagLink::Black(crossing.half_edge));
        }
    }

    /// Finds the triangles at most `length` steps away, breadth first. Returns the range of those
    /// exactly that far away.
    fn find(
        &mut self,
        graph: &DualGraph,
        triangle_count: usize,
        terminal: u32,
        length: u32,
    ) -> std::ops::Range<usize> {
        self.stamps.resize(triangle_count, 0);
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            // After 2³² stars the stamps start from 1 again.
            self.stamps.fill(0);
            self.stamp = 1;
        }
        self.triangles.clear();
        self.triangles.push(terminal);
        self.stamps[terminal as usize] = self.stamp;
        let mut ring = 0..1;
        for _ in 0..length {
            for i in ring.clone() {
                let t = self.triangles[i];
                for neighbour in (3 * t..3 * t + 3).filter_map(|h| Some(graph.twin_of(h)? / 3)) {
                    if std::mem::replace(&mut self.stamps[neighbour as usize], self.stamp) != self.stamp {
                        self.triangles.push(neighbour);
                    }
                }
            }
            ring = ring.end..self.triangles.len();
            if ring.is_empty() {
                break;
            }
        }
        ring
    }
}
