//! The order in which strips are joined into one by degenerate triangles, so that little stands between them.
//!
//! A strip follows for nothing on one that ended with its first vertex, if it then begins at a place of the right parity: a strip
//! of an even number of vertices at an even place from either end, one of an odd number at an even place forward, at an odd
//! place backward. A strip that begins with a repeat goes without it at a place of the other parity.
//!
//! ```text
//!   (a, even) ──────── (z, even)     a strip a … z of an even number of vertices, sent either way
//!   (a, even) ──────── (z, odd)      of an odd number; forward from the left, backward from the right
//! ```
//! # Algorithm
//! 1. A node is a vertex with the parity of the place after it, and each strip an edge between two. A triangle alone is
//!    one of three edges, as it may begin with any of its vertices: that which leaves the fewest nodes with an odd number of edges.
//! 2. The nodes with an odd number of edges are paired by bridges: of one vertex first, since a repeat leads from one parity to the
//!    other; the rest in order.
//! 3. Closed Euler trails through all edges and bridges are found (Hierholzer), and opened at the bridges that cost most. No choice
//!    of trails is fewer: two nodes with an odd number of edges begin or end one each.
//! 4. The trails are put in an order in which each begins with the parity that the one before ended with.
//!
//! # References
//! Hierholzer, Wiener: *Über die Möglichkeit, einen Linienzug ohne Wiederholung und ohne Unterbrechung zu umfahren*, 1873.
//!
//! # Complexity
//! O(s log s) time and 60 bytes a strip.

use std::collections::BTreeSet;

use super::Strips;

/// A way to send a strip: from its first vertex or from its last; a triangle alone also from each of its vertices.
#[derive(Debug, Clone, Copy)]
pub(super) struct Way<'a> {
    strip: &'a [u32],
    rotation: usize,
    reversed: bool,
    /// Whether the strip as it stands keeps its winding at an odd place: one that repeated its first vertex goes without.
    is_odd: bool,
}

impl Way<'_> {
    fn vertices(self) -> impl Iterator<Item = u32> {
        let n = self.strip.len();
        (0..n).map(move |i| self.strip[(if self.reversed { n - 1 - i } else { i } + self.rotation) % n])
    }

    /// Tells whether the strip keeps its winding at an odd place, rather than at an even one.
    fn is_for_odd_place(self) -> bool {
        self.is_odd != (self.reversed && self.strip.len() % 2 == 1)
    }

    /// Adds the strip to those sent before, and what must stand between: the last vertex and the first one again where they are
    /// not the same, and once more where the strip would else begin at a place of the wrong parity.
    pub(super) fn join_to(self, out: &mut Vec<u32>) {
        let Some(first) = self.vertices().next() else { return };
        if let Some(&last) = out.last()
            && last != first
        {
            out.extend([last, first]);
        }
        if (out.len() % 2 == 1) != self.is_for_odd_place() {
            out.push(first);
        }
        out.extend(self.vertices());
    }
}

/// Gives the strips of at least a triangle in an order, and ways of them, that need little between them.
pub(super) fn order(strips: &Strips) -> Vec<Way<'_>> {
    let mut ways: Vec<Way<'_>> = in_order(strips).collect();
    let mut edges = Edges::new(&mut ways);
    edges.add_bridges(ways.len());
    let trails = edges.trails(ways.len());
    let places = trails.into_iter().flatten();
    places.map(|end| Way { reversed: end % 2 == 1, ..ways[end as usize / 2] }).collect()
}

/// Gives the strips of at least a triangle as they stand.
pub(super) fn in_order(strips: &Strips) -> impl Iterator<Item = Way<'_>> {
    strips.iter().filter(|strip| strip.len() >= 3).map(without_repeats)
}

/// Leaves out the repeats at the start of a strip, of which a place of the other parity takes the place.
fn without_repeats(mut strip: &[u32]) -> Way<'_> {
    let mut is_odd = false;
    while let [first, rest @ ..] = strip
        && rest.len() >= 3
        && rest[0] == *first
    {
        strip = rest;
        is_odd = !is_odd;
    }
    Way { strip, rotation: 0, reversed: false, is_odd }
}

/// An end of an edge: twice its number, one more at the side of the strip's last vertex.
type End = u32;

/// A graph of which the strips are edges.
struct Edges {
    /// The node at each end.
    nodes: Vec<u64>,
    /// Edges from this one on are bridges within a vertex, and from `jumps` on between two.
    repeats: usize,
    jumps: usize,
}

fn node(vertex: u32, odd: bool) -> u64 {
    u64::from(vertex) << 1 | u64::from(odd)
}

impl Edges {
    /// Makes an edge of each strip, and chooses the rotations of triangles.
    fn new(ways: &mut [Way<'_>]) -> Self {
        let ends_of = |way: Way<'_>| {
            let (n, rotation) = (way.strip.len(), way.rotation);
            let (first, last) = (way.strip[rotation], way.strip[(n - 1 + rotation) % n]);
            [node(first, way.is_odd), node(last, way.is_odd != (n % 2 == 1))]
        };
        let mut nodes: Vec<u64> = ways.iter().flat_map(|&way| ends_of(way)).collect();
        // Nodes with an odd number of edges of other strips.
        let others = ways.iter().filter(|way| way.strip.len() > 3).flat_map(|&way| ends_of(way));
        let mut odd = BTreeSet::new();
        let toggle = |odd: &mut BTreeSet<u64>, node| {
            if !odd.remove(&node) {
                odd.insert(node);
            }
        };
        others.for_each(|node| toggle(&mut odd, node));
        for (i, way) in ways.iter_mut().enumerate().filter(|(_, way)| way.strip.len() == 3) {
            let met =
                |rotation| ends_of(Way { rotation, ..*way }).iter().filter(|node| odd.contains(node)).count();
            way.rotation = (0..3).rev().max_by_key(|&rotation| met(rotation)).unwrap_or(0);
            let ends = ends_of(*way);
            ends.into_iter().for_each(|node| toggle(&mut odd, node));
            nodes[2 * i..2 * i + 2].copy_from_slice(&ends);
        }
        Self { nodes, repeats: ways.len(), jumps: ways.len() }
    }

    /// Pairs the nodes with an odd number of edges.
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

    /// Finds trails over all strips, each a list of the ends from which its strips are sent, in an order of little cost.
    fn trails(&self, strip_count: usize) -> Vec<Vec<End>> {
        let mut trails = Vec::new();
        for circuit in self.circuits(strip_count) {
            // Open it where that saves the most: at every jump, or else at one repeat.
            let is_jump = |end: &End| *end as usize / 2 >= self.jumps;
            let is_bridge = |end: &End| *end as usize / 2 >= self.repeats;
            let opening = circuit.iter().position(is_jump).or_else(|| circuit.iter().position(is_bridge));
            let (before, from) = circuit.split_at(opening.unwrap_or(0));
            let opened = [from, before].concat();
            let pieces = opened
                .split(is_jump)
                .map(|piece| piece.iter().copied().filter(|end| !is_bridge(end)).collect::<Vec<End>>());
            trails.extend(pieces.filter(|piece| !piece.is_empty()));
        }
        self.line_up(trails)
    }

    /// Finds closed trails over all edges: of each the ends that it leaves by.
    fn circuits(&self, strip_count: usize) -> Vec<Vec<End>> {
        let mut by_node: Vec<(u64, End)> = self.nodes.iter().copied().zip(0..).collect();
        by_node.sort_unstable();
        let first_at = |node: u64| by_node.partition_point(|&(other, _)| other < node);
        // Where the search at the node of each place goes on; only that of a node's first place counts.
        let mut next: Vec<u32> = (0..by_node.len() as u32).collect();
        let mut used = vec![false; self.nodes.len() / 2];
        let (mut circuits, mut stack) = (Vec::new(), Vec::new());
        for strip in 0..strip_count {
            if used[strip] {
                continue;
            }
            let mut circuit = Vec::new();
            stack.push((first_at(self.nodes[2 * strip]), None));
            while let Some(&(place, via)) = stack.last() {
                let at = next[place] as usize;
                if let Some(&(_, end)) = by_node.get(at).filter(|(node, _)| *node == by_node[place].0) {
                    next[place] += 1;
                    if !std::mem::replace(&mut used[end as usize / 2], true) {
                        stack.push((first_at(self.nodes[end as usize ^ 1]), Some(end)));
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

    /// Orders trails, and turns them around, so that each begins with the parity that the one before ended with, but for one.
    fn line_up(&self, trails: Vec<Vec<End>>) -> Vec<Vec<End>> {
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
