//! How triangles lie around points: like a disk, like half of one, or otherwise.

use super::Topology;
use crate::mesh::is_degenerate;

const NONE: u32 = u32::MAX;

/// How the triangles lie around a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::simplify) enum Kind {
    /// All around.
    Inner,
    /// From one border edge to another.
    Border,
    /// In more than one fan, or more than two at an edge, or wound against each other, or twice at the point.
    Complex,
}

/// Tells how the triangles lie around points.
pub(super) struct Fans {
    /// For each neighbour of the point looked at: corners that it is the u of, and the w of, counted up to two.
    ins: Vec<u8>,
    outs: Vec<u8>,
    /// The neighbour that comes after each, around the point.
    next: Vec<u32>,
}

impl Fans {
    pub(super) fn new(point_count: usize) -> Self {
        Self { ins: vec![0; point_count], outs: vec![0; point_count], next: vec![NONE; point_count] }
    }

    pub(super) fn kind(&mut self, topology: &Topology, point: u32) -> Kind {
        let ring = topology.ring(point);
        for &corner in ring {
            let [u, w] = topology.others(corner);
            self.outs[u as usize] = (self.outs[u as usize] + 1).min(2);
            self.ins[w as usize] = (self.ins[w as usize] + 1).min(2);
            self.next[u as usize] = w;
        }
        let kind = self.classify(topology, point);
        for &corner in ring {
            for p in topology.others(corner) {
                (self.ins[p as usize], self.outs[p as usize], self.next[p as usize]) = (0, 0, NONE);
            }
        }
        kind
    }

    fn classify(&self, topology: &Topology, point: u32) -> Kind {
        let ring = topology.ring(point);
        let others = || ring.iter().flat_map(|&corner| topology.others(corner));
        if ring.is_empty() || ring.iter().any(|&corner| is_degenerate(topology.triangles[corner.triangle()]))
        {
            return Kind::Complex;
        }
        if others().any(|p| self.ins[p as usize] > 1 || self.outs[p as usize] > 1) {
            return Kind::Complex;
        }
        // The fan from where it opens, or from anywhere, must take in all corners.
        let opening = others().find(|&p| self.ins[p as usize] == 0);
        let first = opening.unwrap_or_else(|| topology.others(ring[0])[0]);
        let (mut at, mut count) = (first, 0);
        while self.next[at as usize] != NONE {
            at = self.next[at as usize];
            count += 1;
            if at == first || count > ring.len() {
                break;
            }
        }
        match (count == ring.len(), opening) {
            (false, _) => Kind::Complex,
            (true, None) => Kind::Inner,
            (true, Some(_)) => Kind::Border,
        }
    }
}
