//! Tags: the path of each triangle and its position on that path. A search uses them to find out
//! whether a step would close a loop.
//!
//! Porcu and Scateni tag every node with its strip, and rewrite the tags node by node whenever a
//! search links or cuts. Here a tag is a path and a position on that path, and a search writes no
//! tags (see `path_intervals`). Only a complement that is kept writes tags. It divides the changed
//! paths into intervals and links the intervals into new paths. The longest interval of each path
//! keeps its tags.
//!
//! ```text
//!   path 4:  0 ━ 1 ━ 2 ━ 3 ┃ 4 ━ 5        cut between 3 and 4, 3 linked to the first of path 9:
//!   path 9:  0 ━ 1 ━ 2                    0 ━ 1 ━ 2 ━ 3 ━ 4 ━ 5 ━ 6 is path 4, and only the tags
//!                                         of path 9 are rewritten
//! ```
//! Positions are relative to a start per path, so a path can grow at both ends.
//!
//! # References
//! Porcu, Scateni: *An Iterative Stripification Algorithm Based on Dual Graph Operations*, 2003.
//!
//! # Complexity
//! 8 bytes per triangle and 12 per path. A complement takes O(steps · log steps + length of the
//! intervals that do not keep their tags).

use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::ids::{FaceId, OptionalId};

/// The path and the position of every triangle.
#[derive(Debug)]
pub(in crate::stripify) struct PathTags {
    path: Vec<u32>,
    position: Vec<u32>,
    /// The first and last triangle of each path; none for a path that was joined to another.
    ends: Vec<[OptionalId; 2]>,
    /// The stored position of each path's first triangle.
    starts: Vec<u32>,
    /// The paths that the current complement changes.
    changed_paths: Vec<u32>,
    /// Their intervals, sorted by path and position.
    intervals: Vec<TagInterval>,
}

/// The triangles of a path between two cuts.
#[derive(Debug, Clone, Copy)]
struct TagInterval {
    path: u32,
    /// The positions of the first and last triangle, and the triangles.
    positions: [u32; 2],
    triangles: [u32; 2],
    /// The interval and the side that each side is linked to.
    links: [Option<(u32, usize)>; 2],
    /// Whether the interval already belongs to a new path.
    is_used: bool,
}

impl TagInterval {
    fn len(&self) -> u32 {
        self.positions[1] - self.positions[0] + 1
    }
}

/// A step of a tunnel: over a red edge, then over a black one. The last step has no black edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::stripify) struct TunnelStep {
    /// The half-edge that leads away from the tip of the tunnel.
    pub(in crate::stripify) red: u32,
    /// The half-edge that continues from there.
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
            starts: vec![0; ends.len()],
            ends: ends.into_iter().map(|ends| ends.map(OptionalId::some)).collect(),
            changed_paths: Vec::new(),
            intervals: Vec::new(),
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
        self.position[triangle as usize].wrapping_sub(self.starts[self.path(triangle) as usize])
    }

    /// Returns the first triangle of a path.
    pub(in crate::stripify) fn first(&self, path: u32) -> Option<u32> {
        self.ends[path as usize][0].get()
    }

    /// Returns the position of a path's last triangle.
    #[inline]
    pub(super) fn last_position(&self, path: u32) -> u32 {
        self.ends[path as usize][1].get().map_or(0, |last| self.position(last))
    }

    /// Complements a tunnel: cuts its black edges, links its red ones, and rewrites the tags that
    /// change. Returns the total length of the changed paths.
    pub(in crate::stripify) fn complement(
        &mut self,
        graph: &DualGraph,
        cover: &mut PathCover,
        tunnel: &[TunnelStep],
    ) -> u64 {
        let crossed = |h: u32| graph.twin_of(h).map(|twin| [h / 3, twin / 3]);
        self.divide(tunnel, crossed);
        for [a, b] in tunnel.iter().filter_map(|step| crossed(step.red)) {
            self.link_intervals(a, b);
        }
        complement_links(graph, cover, tunnel);
        for &path in &self.changed_paths {
            self.ends[path as usize] = [OptionalId::NONE; 2];
        }
        // If several new paths could keep the tags of one old path, the longest interval keeps
        // them.
        let mut longest_first: Vec<u32> = (0..self.intervals.len() as u32).collect();
        longest_first.sort_by_key(|&i| std::cmp::Reverse(self.intervals[i as usize].len()));
        for &i in &longest_first {
            let path = self.intervals[i as usize].path;
            if !self.intervals[i as usize].is_used && self.ends[path as usize][0].is_none() {
                self.write_around(graph, cover, i);
            }
        }
        // The other new paths reuse the numbers of paths that no longer exist.
        for &i in &longest_first {
            if !self.intervals[i as usize].is_used {
                self.write_all(graph, cover, i);
            }
        }
        #[cfg(test)]
        assert!(cover.len() > 4096 || cover.check(graph).is_ok() && self.check(graph, cover));
        self.intervals.iter().map(|interval| u64::from(interval.len())).sum()
    }

    /// Divides the paths of a tunnel at its black edges.
    fn divide(&mut self, tunnel: &[TunnelStep], crossed: impl Fn(u32) -> Option<[u32; 2]>) {
        let edges = tunnel.iter().flat_map(|step| step.half_edges());
        let triangles = edges.filter_map(&crossed).flatten();
        self.changed_paths.clear();
        self.changed_paths.extend(triangles.map(|t| self.path[t as usize]));
        self.changed_paths.sort_unstable();
        self.changed_paths.dedup();
        // The triangles before and after each cut.
        let black = tunnel.iter().filter_map(|step| crossed(step.black.get()?));
        let mut cuts: Vec<[u32; 2]> =
            black.map(|[a, b]| if self.position(a) < self.position(b) { [a, b] } else { [b, a] }).collect();
        cuts.sort_unstable_by_key(|&[before, _]| (self.path(before), self.position(before)));
        let mut cuts = cuts.into_iter().peekable();
        self.intervals.clear();
        for i in 0..self.changed_paths.len() {
            let path = self.changed_paths[i];
            let [Some(mut first), Some(last)] = self.ends[path as usize].map(OptionalId::get) else {
                continue;
            };
            while let Some([before, after]) = cuts.next_if(|&[before, _]| self.path(before) == path) {
                self.add_interval(path, [first, before]);
                first = after;
            }
            self.add_interval(path, [first, last]);
        }
    }

    fn add_interval(&mut self, path: u32, triangles: [u32; 2]) {
        let positions = triangles.map(|t| self.position(t));
        self.intervals.push(TagInterval { path, positions, triangles, links: [None; 2], is_used: false });
    }

    /// Links the ends of two intervals.
    fn link_intervals(&mut self, a: u32, b: u32) {
        let (a, b) = (self.free_side(a), self.free_side(b));
        self.intervals[a.0 as usize].links[a.1] = Some(b);
        self.intervals[b.0 as usize].links[b.1] = Some(a);
    }

    /// Returns the interval that ends at a triangle, and its unlinked side there.
    fn free_side(&self, triangle: u32) -> (u32, usize) {
        let key = (self.path(triangle), self.position(triangle));
        let i = self.intervals.partition_point(|interval| (interval.path, interval.positions[1]) < key);
        let interval = &self.intervals[i];
        (i as u32, usize::from(interval.triangles[0] != triangle || interval.links[0].is_some()))
    }

    /// Follows a new path beyond a side of an interval, and marks its intervals as used. Returns
    /// their length in triangles, and the triangle at the end.
    fn follow(&mut self, interval: u32, side: usize) -> (u32, u32) {
        let (mut at, mut length) = ((interval, side), 0_u32);
        while let Some((next, entry)) = self.intervals[at.0 as usize].links[at.1] {
            self.intervals[next as usize].is_used = true;
            length += self.intervals[next as usize].len();
            at = (next, 1 - entry);
        }
        (length, self.intervals[at.0 as usize].triangles[at.1])
    }

    /// Writes the tags of a new path, except for one interval that keeps its own.
    fn write_around(&mut self, graph: &DualGraph, cover: &PathCover, interval: u32) {
        let kept = self.intervals[interval as usize];
        let start = self.starts[kept.path as usize];
        let [low, high] = kept.positions.map(|position| start.wrapping_add(position));
        self.intervals[interval as usize].is_used = true;
        let ((before, first), (after, last)) = (self.follow(interval, 0), self.follow(interval, 1));
        let new_start = low.wrapping_sub(before);
        self.write(graph, cover, first, before, (kept.path, new_start, 1));
        self.write(graph, cover, last, after, (kept.path, high.wrapping_add(after), u32::MAX));
        self.starts[kept.path as usize] = new_start;
        self.ends[kept.path as usize] = [first, last].map(OptionalId::some);
    }

    /// Writes all tags of a new path, with the number of a path that no longer exists.
    fn write_all(&mut self, graph: &DualGraph, cover: &PathCover, interval: u32) {
        let free = self.changed_paths.iter().copied().find(|&path| self.ends[path as usize][0].is_none());
        let Some(path) = free else { return };
        self.intervals[interval as usize].is_used = true;
        let ((before, first), (after, last)) = (self.follow(interval, 0), self.follow(interval, 1));
        let length = before + self.intervals[interval as usize].len() + after;
        self.write(graph, cover, first, length, (path, 0, 1));
        self.starts[path as usize] = 0;
        self.ends[path as usize] = [first, last].map(OptionalId::some);
    }

    /// Writes tags along a path, starting at one of its ends: the path number, and positions from
    /// `position` on in increments of `step`.
    fn write(
        &mut self,
        graph: &DualGraph,
        cover: &PathCover,
        end: u32,
        count: u32,
        (path, mut position, step): (u32, u32, u32),
    ) {
        for (face, _, _) in cover.walk(graph, FaceId(end)).take(count as usize) {
            self.path[face.0 as usize] = path;
            self.position[face.0 as usize] = position;
            position = position.wrapping_add(step);
        }
    }

    /// Checks the tags against the cover, regardless of the paths' numbers and directions.
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
pub(in crate::stripify) fn complement_links(graph: &DualGraph, cover: &mut PathCover, tunnel: &[TunnelStep]) {
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
