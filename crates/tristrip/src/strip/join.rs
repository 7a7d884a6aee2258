//! The order in which strips are joined into one by degenerate triangles, with few indices between them.
//!
//! A strip follows without extra indices on one that ended with its first vertex, if it then begins at a position of the right parity: a
//! strip of an even number of vertices at an even position from either end, one of an odd number at an even position forward, at an odd
//! position backward. A strip that begins with a repeat does not need it at a position of the other parity.
//!
//! ```text
//!   (a, even) ──────── (z, even)     a strip a … z of an even number of vertices, sent either way
//!   (a, even) ──────── (z, odd)      of an odd number; forward from the left, backward from the right
//! ```
//! # Algorithm
//! 1. A node is a vertex with the parity of the position after it, and each strip is an edge between two nodes. A strip of one triangle is
//!    one of three edges, as it may begin with any of its vertices: the one that leaves the fewest nodes of odd degree.
//! 2. The nodes of odd degree are paired by bridges: first those of one vertex, since a repeat changes the parity; then the others in
//!    order.
//! 3. Closed Euler trails through all edges and bridges are found (Hierholzer), and opened at the most expensive bridges. The number of
//!    trails is minimal: each node of odd degree begins or ends one.
//! 4. The trails are ordered so that each begins with the parity with which the one before ended.
//!
//! # References
//! Hierholzer, Wiener: *Über die Möglichkeit, einen Linienzug ohne Wiederholung und ohne Unterbrechung zu umfahren*, 1873.
//!
//! # Complexity
//! O(s log s) time and 70 bytes per strip for s strips.

use rustc_hash::FxHashSet;

use super::Strips;

/// A direction in which to draw a strip: from its first vertex or from its last; one triangle also from each of its vertices.
#[derive(Debug, Clone, Copy)]
pub(super) struct DirectedStrip<'a> {
    strip: &'a [u32],
    rotation: usize,
    reversed: bool,
    /// Whether the forward strip keeps its winding at an odd position, because a repeat of its first vertex was removed.
    is_odd: bool,
}

/// Consecutive vertices of a strip, sent from the first or from the last.
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

    /// Calls `send` for each vertex in the order in which it is sent.
    pub(super) fn for_each(self, send: impl FnMut(u32)) {
        let vertices = self.vertices.iter().copied();
        if self.reversed { vertices.rev().for_each(send) } else { vertices.for_each(send) }
    }

    fn last(self) -> Option<u32> {
        if self.reversed { self.vertices.first().copied() } else { self.vertices.last().copied() }
    }
}

impl<'a> DirectedStrip<'a> {
    /// Returns the vertices in the order in which they are sent, in two runs, because the strip may begin inside its array.
    fn runs(self) -> [StripRun<'a>; 2] {
        let (head, tail) = self.strip.split_at(self.rotation);
        let (first, second) = if self.reversed { (head, tail) } else { (tail, head) };
        [first, second].map(|vertices| StripRun { vertices, reversed: self.reversed })
    }

    /// Returns the first vertex that is sent. A strip has at least one triangle.
    fn first(self) -> u32 {
        let n = self.strip.len();
        self.strip[if self.reversed { (self.rotation + n - 1) % n } else { self.rotation }]
    }

    /// Returns whether the strip keeps its winding at an odd position, rather than at an even one.
    fn starts_at_odd(self) -> bool {
        self.is_odd != (self.reversed && self.strip.len() % 2 == 1)
    }

    /// Appends the strip to a joined buffer, and the indices between: the last vertex and the first one again if they differ, and
    /// the first one once more if the strip would otherwise begin at a position of the wrong parity.
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

/// A buffer of joined strips: the parity of its length, its last index, and where its indices go.
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

/// Returns the strips of at least one triangle in an order, and with directions, that require few indices between them.
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

/// Returns the strips of at least one triangle in the present order and direction.
pub(super) fn in_order(strips: &Strips) -> impl Iterator<Item = DirectedStrip<'_>> {
    strips.iter().filter(|strip| strip.len() >= 3).map(without_repeats)
}

/// Removes the repeats at the start of a strip: a start at the other parity replaces them.
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

/// An end of an edge: twice the edge's number, plus one at the side of the strip's last vertex.
type End = u32;

/// A graph with strips as edges.
struct JoinGraph {
    /// The node at each end.
    nodes: Vec<u64>,
    /// The first edge that is a bridge within a vertex; from `jumps` on they are bridges between two vertices.
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
        // Nodes of odd degree, counting only the longer strips.
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

    /// Pairs the nodes of odd degree.
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

    /// Returns trails over all strips, each a list of the ends from which its strips are drawn, in an order of low cost.
    fn trails(&self, strip_count: usize) -> Vec<Vec<End>> {
        let mut trails = Vec::new();
        for circuit in self.circuits(strip_count) {
            // Open it where that saves the most: at every jump, otherwise at one repeat.
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

    /// Returns closed trails over all edges: the ends over which each leaves its edges.
    fn circuits(&self, strip_count: usize) -> Vec<Vec<End>> {
        let mut by_node: Vec<(u64, End)> = self.nodes.iter().copied().zip(0..).collect();
        by_node.sort_unstable();
        // The first slot of each end's node.
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

    /// Orders and reverses trails so that each begins with the parity with which the one before ended, with at most one exception.
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
