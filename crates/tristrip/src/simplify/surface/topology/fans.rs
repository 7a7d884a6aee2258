//! The arrangement of the triangles around a point: a disk, a half disk, or neither.

use super::corner::CornerId;
use crate::ids::OptionalId;
use crate::mesh::is_degenerate;

/// The arrangement of the triangles around a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PointKind {
    /// A closed fan.
    Inner,
    /// A fan from one border edge to another.
    Border,
    /// More than one fan, more than two triangles at an edge, or inconsistent winding.
    Irregular,
    /// No triangle, or one that has two corners at the same point.
    Degenerate,
}

/// Classifies points.
#[derive(Debug)]
pub(super) struct FanClassifier {
    /// For each neighbour of the current point, the number of corners that it follows and that it
    /// precedes, counted up to two.
    ins: Vec<u8>,
    outs: Vec<u8>,
    /// The next neighbour around the point.
    next: Vec<OptionalId>,
}

impl FanClassifier {
    pub(super) fn new(point_count: usize) -> Self {
        Self {
            ins: vec![0; point_count],
            outs: vec![0; point_count],
            next: vec![OptionalId::NONE; point_count],
        }
    }

    /// Classifies a point by the corners around it and their opposite edges.
    pub(super) fn kind(
        &mut self,
        triangles: &[[u32; 3]],
        ring: &[CornerId],
        opposite: &[[u32; 2]],
    ) -> PointKind {
        if is_short_circle(opposite) && !ring.iter().any(|corner| is_degenerate(triangles[corner.triangle()]))
        {
            return PointKind::Inner;
        }
        for &corner in ring {
            let [u, w] = corner.others(triangles);
            self.outs[u as usize] = (self.outs[u as usize] + 1).min(2);
            self.ins[w as usize] = (self.ins[w as usize] + 1).min(2);
            self.next[u as usize] = OptionalId::some(w);
        }
        let kind = self.classify(triangles, ring);
        for &corner in ring {
            for p in corner.others(triangles) {
                (self.ins[p as usize], self.outs[p as usize], self.next[p as usize]) =
                    (0, 0, OptionalId::NONE);
            }
        }
        kind
    }

    fn classify(&self, triangles: &[[u32; 3]], ring: &[CornerId]) -> PointKind {
        let others = || ring.iter().flat_map(|corner| corner.others(triangles));
        if ring.is_empty() || ring.iter().any(|corner| is_degenerate(triangles[corner.triangle()])) {
            return PointKind::Degenerate;
        }
        if others().any(|p| self.ins[p as usize] > 1 || self.outs[p as usize] > 1) {
            return PointKind::Irregular;
        }
        // The fan must contain all corners. It starts at its border edge, or anywhere if it is
        // closed.
        let opening = others().find(|&p| self.ins[p as usize] == 0);
        let first = opening.unwrap_or_else(|| ring[0].others(triangles)[0]);
        let (mut at, mut count) = (first, 0);
        while let Some(next) = self.next[at as usize].get() {
            at = next;
            count += 1;
            if at == first || count > ring.len() {
                break;
            }
        }
        match (count == ring.len(), opening) {
            (false, _) => PointKind::Irregular,
            (true, None) => PointKind::Inner,
            (true, Some(_)) => PointKind::Border,
        }
    }
}

/// Returns whether a few edges form a single circle with each neighbour once. Most points have such
/// a ring.
fn is_short_circle(edges: &[[u32; 2]]) -> bool {
    const LONGEST: usize = 10;
    let Some(&[first, mut at]) = edges.first() else { return false };
    if edges.len() > LONGEST {
        return false;
    }
    for _ in 1..edges.len() {
        if at == first {
            return false;
        }
        let mut next = edges.iter().filter(|&&[u, _]| u == at);
        let (Some(&[_, w]), None) = (next.next(), next.next()) else { return false };
        at = w;
    }
    at == first
}
