//! Tags: which path each triangle is on, and where, so that a search finds out whether a step would close a loop.
//!
//! Porcu and Scateni tag every node with its strip, and rewrite the tags node by node whenever a search links or cuts. Here a tag is a
//! path and a position on it, and a search writes none (see `path_intervals`). Only a complement that is kept writes tags, those of the
//! paths that it changed.
//!
//! # References
//! Porcu, Scateni: *An Iterative Stripification Algorithm Based on Dual Graph Operations*, 2003.
//!
//! # Complexity
//! 8 bytes per triangle and 8 per path. A complement takes O(length of the paths that it changes).

use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::ids::{FaceId, OptionalId};

/// The path and the position of every triangle, kept up to date.
#[derive(Debug)]
pub(in crate::stripify) struct PathTags {
    path: Vec<u32>,
    position: Vec<u32>,
    /// The first and the last triangle of each path; none for a path that was joined to another.
    ends: Vec<[OptionalId; 2]>,
    /// The paths that a complement changes.
    changed_paths: Vec<u32>,
    /// Triangles that may be ends of the changed paths.
    end_candidates: Vec<u32>,
}

/// A step of a tunnel: over a red edge, then over a black one. The last step has no black edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::stripify) struct TunnelStep {
    /// The half-edge that leads on from the tip of the tunnel.
    pub(in crate::stripify) red: u32,
    /// The half-edge that leads on from there.
    pub(in crate::stripify) black: OptionalId,
}

impl TunnelStep {
    fn half_edges(self) -> impl Iterator<Item = u32> {
        [Some(self.red), self.black.get()].into_iter().flatten()
    }
}

impl PathTags {
    /// Tags the triangles of a cover.
    pub(in crate::stripify) fn new(graph: &DualGraph, cover: &PathCover) -> Self {
        let numbering = cover.renumber(graph);
        let mut ends: Vec<[u32; 2]> = numbering.first.iter().map(|first| [first.0; 2]).collect();
        for (t, &path) in numbering.path.iter().enumerate() {
            let last = &mut ends[path as usize][1];
            if numbering.position[t] > numbering.position[*last as usize] {
                *last = t as u32;
            }
        }
        Self {
            path: numbering.path,
            position: numbering.position,
            ends: ends.into_iter().map(|ends| ends.map(OptionalId::some)).collect(),
            changed_paths: Vec::new(),
            end_candidates: Vec::new(),
        }
    }

    /// Returns the path of a triangle.
    #[inline]
    pub(in crate::stripify) fn path(&self, triangle: u32) -> u32 {
        self.path[triangle as usize]
    }

    /// Returns the position of a triangle on its path.
    #[inline]
    pub(in crate::stripify) fn position(&self, triangle: u32) -> u32 {
        self.position[triangle as usize]
    }

    /// Returns the position of a path's last triangle.
    #[inline]
    pub(super) fn last_position(&self, path: u32) -> u32 {
        self.ends[path as usize][1].get().map_or(0, |last| self.position(last))
    }

    /// Complements a tunnel: cuts its black edges, links its red ones, and rewrites the tags of the paths that changed. Returns the
    /// number of tags written.
    pub(in crate::stripify) fn complement(
        &mut self,
        graph: &DualGraph,
        cover: &mut PathCover,
        tunnel: &[TunnelStep],
    ) -> u64 {
        self.changed_paths.clear();
        self.end_candidates.clear();
        for h in tunnel.iter().flat_map(|step| step.half_edges()) {
            let Some(twin) = graph.twin_of(h) else { continue };
            for t in [h / 3, twin / 3] {
                self.changed_paths.push(self.path(t));
                self.end_candidates.push(t);
            }
        }
        complement_links(graph, cover, tunnel);
        self.changed_paths.sort_unstable();
        self.changed_paths.dedup();
        for &path in &self.changed_paths {
            let ends = std::mem::take(&mut self.ends[path as usize]);
            self.end_candidates.extend(ends.into_iter().filter_map(OptionalId::get));
        }
        let written = self.write_tags(graph, cover);
        #[cfg(test)]
        assert!(cover.len() > 4096 || cover.check(graph).is_ok() && self.check(graph, cover));
        written
    }

    /// Renumbers the changed paths, each from an end that is not yet known as the other end of a renumbered one.
    fn write_tags(&mut self, graph: &DualGraph, cover: &PathCover) -> u64 {
        let mut written = 0;
        let mut free_paths = self.changed_paths.iter();
        self.end_candidates.retain(|&t| cover.degree(FaceId(t)) < 2);
        self.end_candidates.sort_unstable();
        self.end_candidates.dedup();
        for &start in &self.end_candidates {
            if self.ends[self.path(start) as usize].contains(&OptionalId::some(start)) {
                continue;
            }
            let Some(&path) = free_paths.next() else { break };
            let mut last = start;
            for (position, (face, _, _)) in cover.walk(graph, FaceId(start)).enumerate() {
                self.path[face.0 as usize] = path;
                self.position[face.0 as usize] = position as u32;
                last = face.0;
                written += 1;
            }
            self.ends[path as usize] = [start, last].map(OptionalId::some);
        }
        written
    }

    /// Checks that the tags are those of the cover, whatever the paths' numbers and directions.
    #[cfg(test)]
    pub(super) fn check(&self, graph: &DualGraph, cover: &PathCover) -> bool {
        let mut seen = std::collections::HashSet::new();
        cover.path_starts(graph).all(|start| {
            let path = self.path(start.0);
            let walked: Vec<u32> = cover.walk(graph, start).map(|(face, _, _)| face.0).collect();
            let mut positions: Vec<u32> = walked.iter().map(|&t| self.position(t)).collect();
            let mut ends = [walked[0], walked[walked.len() - 1]];
            if positions[0] != 0 {
                positions.reverse();
                ends.reverse();
            }
            seen.insert(path)
                && self.ends[path as usize] == ends.map(OptionalId::some)
                && walked.iter().all(|&t| self.path(t) == path)
                && positions.iter().copied().eq(0..walked.len() as u32)
        })
    }
}

/// Cuts the black edges of a tunnel and links its red ones.
fn complement_links(graph: &DualGraph, cover: &mut PathCover, tunnel: &[TunnelStep]) {
    for black in tunnel.iter().filter_map(|step| step.black.get()) {
        if let Some(twin) = graph.twin_of(black) {
            cover.cut_unchecked(black, twin);
        }
    }
    for step in tunnel {
        if let Some(twin) = graph.twin_of(step.red) {
            cover.link_unchecked(step.red, twin);
        }
    }
}
