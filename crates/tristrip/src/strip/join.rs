//! Orders strips for joining by degenerate triangles, to keep the number of extra indices low.
//!
//! A strip needs no extra indices if it starts with the vertex that was sent last, at a position
//! with the right parity. A strip with an even number of vertices must start at an even position,
//! in either direction. A strip with an odd number of vertices must start at an even position
//! forward, or at an odd position backward. A strip that starts with a repeat does not need the
//! repeat at the other parity.
//!
//! ```text
//!   (a, even) ──────── (z, even)     a strip a … z of an even number of vertices, sent either way
//!   (a, even) ──────── (z, odd)      of an odd number; forward from the left, or backward
//! ```
//! # Algorithm
//! 1. A node is a vertex with the parity of the next position, and each strip is an edge between
//!    two nodes. A strip of one triangle can be any of three edges, because it can start with any
//!    of its vertices. The algorithm uses the edge that leaves the fewest nodes of odd degree.
//! 2. Bridges pair the nodes of odd degree. The first bridges connect the two parities of the same
//!    vertex, because a repeat changes the parity. The other nodes are paired in order.
//! 3. Hierholzer's algorithm finds closed Euler trails through all edges and bridges. The trails
//!    are then opened at the most expensive bridges. The number of trails is minimal, because each
//!    node of odd degree starts or ends one.
//! 4. The trails are ordered so that each starts with the parity at which the previous one ended.
//!
//! # References
//! Hierholzer, Wiener: *Über die Möglichkeit, einen Linienzug ohne Wiederholung und ohne
//! Unterbrechung zu umfahren*, 1873.
//!
//! # Complexity
//! O(s log s) time and 70 bytes per strip, where s is the number of strips.

use rustc_hash::FxHashSet;

use super::Strips;

/// A strip with a drawing direction: from its first vertex or from its last. A strip of one
/// triangle can start with any of its vertices.
#[derive(Debug, Clone, Copy)]
pub(super) struct DirectedStrip<'a> {
    strip: &'a [u32],
    rotation: usize,
    reversed: bool,
    /// Whether the forward strip must start at an odd position to keep its winding, because a
    /// repeat of its first vertex was removed.
    is_odd: bool,
}

/// Consecutive vertices of a strip, forward or reversed.
#[derive(Debug, Clone, Copy)]
pub(super) struct StripRun<'a> {
    vertices: &'a [u32],
    reversed: bool,
}

impl StripRun<'_> {
    /// Counts the vertices.
    pub(super) fn len(self) -> usize {
        self.vertices.len()
    }

    /// Calls `send` with each vertex in drawing order.
    pub(super) fn for_each(self, send: impl FnMut(u32)) {
        let vertices = self.vertices.iter().copied();
        if self.reversed { vertices.rev().for_each(send) } else { vertices.for_each(send) }
    }

    fn last(self) -> Option<u32> {
        if self.reversed { self.vertices.first().copied() } else { self.vertices.last().copied() }
    }
}

impl<'a> DirectedStrip<'a> {
    /// Returns the vertices in drawing order. There are two runs because the strip may start inside
    /// its array.
    fn runs(self) -> [StripRun<'a>; 2] {
        let (head, tail) = self.strip.split_at(self.rotation);
        let (first, second) = if self.reversed { (head, tail) } else { (tail, head) };
        [first, second].map(|vertices| StripRun { vertices, reversed: self.reversed })
    }

    /// Returns the first vertex in drawing order. A strip has at least one triangle.
    fn first(self) -> u32 {
        let n = self.strip.len();
        self.strip[if self.reversed { (self.rotation + n - 1) % n } else { self.rotation }]
    }

    /// Returns whether the strip must start at an odd position to keep its winding.
    fn starts_at_odd(self) -> bool {
        self.is_odd != (self.reversed && self.strip.len() % 2 == 1)
    }

    /// Appends the strip to a joined buffer with the indices between. These are the last vertex and
    /// the new first vertex if they differ, and the first vertex again if the parity would be
    /// wrong.
    pub(super) fn join_to(self, joined: &mut JoinedStrips<impl FnMut(StripRun<'_>)>) {
        let first = self.first();
        if let Some(last) = joined.last
            && last != first
        {
            joined.send(StripRun { vertices: &[last, first], reversed: false });
        }
        if joined.is_odd != self.starts_at_odd() {
            joined.send(StripRun { vertices: &[first], reversed: false });
        }
        self.runs().into_iter().for_each(|run| joined.send(run));
    }
}

/// A joined index buffer: the parity of its length, its last index, and the receiver of its
/// indices.
pub(super) struct JoinedStrips<F> {
    is_odd: bool,
    last: Option<u32>,
    send: F,
}

impl<F: FnMut(StripRun<'_>)> JoinedStrips<F> {
    /// Starts an empty buffer.
    pub(super) fn new(send: F) -> Self {
        Self { is_odd: false, last: None, send }
    }

    fn send(&mut self, run: StripRun<'_>) {
        (self.send)(run);
        (self.is_odd, self.last) = (self.is_odd != (run.len() % 2 == 1), run.last().or(self.last));
    }
}

/// Returns the strips of at least one triangle, in an order and with directions that need few
/// indices between them.
pub(super) fn order(strips: &Strips) -> Vec<DirectedStrip<'_>> {
    let mut ways: Vec<DirectedStrip<'_>> = in_order(strips).collect();
    let mut edges = JoinGraph::new(&mut ways);
    edges.add_bridges(ways.len());
    let trails = edges.trails(ways.len());
    trails
        .into_iter()
        .flatten()
        .map(|end| DirectedStrip { reversed: end % 2 == 1, ..ways[end as usize / 2] })
        .collect()
}

/// Returns the strips of at least one triangle in their present order and direction.
pub(super) fn in_order(strips: &Strips) -> impl Iterator<Item = DirectedStrip<'_>> {
    strips.iter().filter(|strip| strip.len() >= 3).map(without_repeats)
}

/// Removes the repeats at the start of a strip. Starting at the other parity replaces them.
fn without_repeats(mut strip: &[u32]) -> DirectedStrip<'_> {
    let mut is_odd = false;
    while let [first, rest @ ..] = strip
        && rest.len() >= 3
        && rest[0] == *first
    {
        strip = rest;
        is_odd = !is_odd;
    }
    DirectedStrip { strip, rotation: 0, reversed: false, is_odd }
}

/// An end of an edge: twice the index of the edge, plus 1 at the last vertex of the strip.
type End = u32;

/// A graph whose edges are strips and bridges.
struct JoinGraph {
    /// The node at each end.
    nodes: Vec<u64>,
    /// The index of the first bridge between the parities of one vertex. From `jumps` on, bridges
    /// connect two vertices.
    repeats: usize,
    jumps: usize,
}

fn node(vertex: u32, odd: bool) -> u64 {
    u64::from(vertex) << 1 | u64::from(odd)
}

impl JoinGraph {
    /// Creates an edge for each strip, and chooses the rotations of triangles.
    fn new(ways: &mut [DirectedStrip<'_>]) -> Self {
        let ends_of = |way: DirectedStrip<'_>| {
            let (n, rotation) = (way.strip.len(), way.rotation);
            let (first, last) = (way.strip[rotation], way.strip[(n - 1 + rotation) % n]);
            [node(first, way.is_odd), node(last, way.is_odd != (n % 2 == 1))]
        };
        let mut nodes: Vec<u64> = ways.iter().flat_map(|&way| ends_of(way)).collect();
        // The nodes of odd degree, counting only strips longer than one triangle.
        let others = ways.iter().filter(|way| way.strip.len() > 3).flat_map(|&way| ends_of(way));
        let mut odd = FxHashSet::default();
        let toggle = |odd: &mut FxHashSet<u64>, node| {
            if !odd.remove(&node) {
                odd.insert(node);
            }
        };
        others.for_each(|node| toggle(&mut odd, node));
        for (i, way) in ways.iter_mut().enumerate().filter(|(_, way)| way.strip.len() == 3) {
            let met = |rotation| {
                ends_of(DirectedStrip { rotation, ..*way }).iter().filter(|node| odd.contains(node)).count()
            };
            way.rotation = (0..3).rev().max_by_key(|&rotation| met(rotation)).unwrap_or(0);
            let ends = ends_of(*way);
            ends.into_iter().for_each(|node| toggle(&mut odd, node));
            nodes[2 * i..2 * i + 2].copy_from_slice(&ends);
        }
        Self { nodes, repeats: ways.len(), jumps: ways.len() }
    }

    /// Pairs the nodes of odd degree by bridges.
    fn add_bridges(&mut self, edge_count: usize) {
        let mut sorted = self.nodes.clone();
        sorted.sort_unstable();
        let odd: Vec<u64> =
            sorted.chunk_by(|a, b| a == b).filter(|same| same.len() % 2 == 1).map(|same| same[0]).collect();
        let mut rest = Vec::new();
        let mut left = &odd[..];
        while let [node, after @ ..] = left {
            left = after;
            match after {
                [next, after @ ..] if node >> 1 == next >> 1 => {
                    self.nodes.extend([*node, *next]);
                    left = after;
                }
                _ => rest.push(*node),
            }
        }
        self.repeats = edge_count;
        self.jumps = self.nodes.len() / 2;
        self.nodes.extend(rest);
    }

    /// Returns trails over all strips in a cheap order. A trail is a list of the ends from which
    /// its strips are drawn.
    fn trails(&self, strip_count: usize) -> Vec<Vec<End>> {
        let mut trails = Vec::new();
        for circuit in self.circuits(strip_count) {
            // Open the circuit where that saves the most: at every jump, otherwise at one repeat.
            let is_jump = |end: &End| *end as usize / 2 >= self.jumps;
            let is_bridge = |end: &End| *end as usize / 2 >= self.repeats;
            let opening = circuit.iter().position(is_jump).or_else(|| circuit.iter().position(is_bridge));
            let (before, from) = circuit.split_at(opening.unwrap_or(0));
            let opened = [from, before].concat();
            let parts = opened
                .split(is_jump)
                .map(|part| part.iter().copied().filter(|end| !is_bridge(end)).collect::<Vec<End>>());
            trails.extend(parts.filter(|part| !part.is_empty()));
        }
        self.order_by_parity(trails)
    }

    /// Returns closed trails over all edges, as the ends from which the edges are traversed.
    fn circuits(&self, strip_count: usize) -> Vec<Vec<End>> {
        let mut by_node: Vec<(u64, End)> = self.nodes.iter().copied().zip(0..).collect();
        by_node.sort_unstable();
        // The first slot of the node of each end.
        let mut first_of = vec![0_u32; self.nodes.len()];
        let mut start = 0;
        for same in by_node.chunk_by(|a, b| a.0 == b.0) {
            same.iter().for_each(|&(_, end)| first_of[end as usize] = start);
            start += same.len() as u32;
        }
        // The next unvisited slot of each node, stored at the node's first slot.
        let mut next: Vec<u32> = (0..by_node.len() as u32).collect();
        let mut used = vec![false; self.nodes.len() / 2];
        let (mut circuits, mut stack) = (Vec::new(), Vec::new());
        for strip in 0..strip_count {
            if used[strip] {
                continue;
            }
            let mut circuit = Vec::new();
            stack.push((first_of[2 * strip], None));
            while let Some(&(first, via)) = stack.last() {
                let at = next[first as usize] as usize;
                if let Some(&(_, end)) = by_node.get(at).filter(|(_, end)| first_of[*end as usize] == first) {
                    next[first as usize] += 1;
                    if !std::mem::replace(&mut used[end as usize / 2], true) {
                        stack.push((first_of[end as usize ^ 1], Some(end)));
                    }
                } else {
                    circuit.extend(via);
                    stack.pop();
                }
            }
            circuit.reverse();
            circuits.push(circuit);
        }
        circuits
    }

    /// Orders and reverses trails so that each starts with the parity at which the previous one
    /// ended, with at most one exception.
    fn order_by_parity(&self, trails: Vec<Vec<End>>) -> Vec<Vec<End>> {
        let parities = |trail: &[End]| {
            let (first, last) = (trail.first().copied().unwrap_or(0), trail.last().copied().unwrap_or(1));
            (self.nodes[first as usize] & 1, self.nodes[last as usize ^ 1] & 1)
        };
        let (mixed, pure): (Vec<_>, Vec<_>) = trails.into_iter().partition(|trail| {
            let (first, last) = parities(trail);
            first != last
        });
        let (even, odd): (Vec<_>, Vec<_>) = pure.into_iter().partition(|trail| parities(trail).0 == 0);
        let mut ordered = even;
        let mut parity = 0;
        let mut mixed = mixed.into_iter();
        let mut push_mixed = |ordered: &mut Vec<Vec<End>>, mut trail: Vec<End>| {
            if parities(&trail).0 != parity {
                trail = trail.iter().rev().map(|end| end ^ 1).collect();
            }
            parity ^= 1;
            ordered.push(trail);
        };
        mixed.next().into_iter().for_each(|trail| push_mixed(&mut ordered, trail));
        ordered.extend(odd);
        mixed.for_each(|trail| push_mixed(&mut ordered, trail));
        ordered
    }
}
