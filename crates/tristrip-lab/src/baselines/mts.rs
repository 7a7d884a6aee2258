//! MTS, multiresolution triangle strips: each vertex of a strip lists the edges to its successors
//! at all levels, not sorted by level. It is the baseline of SETS.
//!
//! # A reconstruction
//! The paper on MTS was not available. This implementation follows the description in the paper on
//! SETS: strips are graphs of vertices and successors, with lists that are not sorted by level. As
//! there, it is modified to keep the winding of the triangles. Our additions:
//! - An edge is a slot of the strip that contains the vertex, the vertex that follows it, and the
//!   first and last state at which it does. The edges of a vertex are in the order of the slots, so
//!   its valid edges are its visits in order. The walk counts the visits. Each visit searches the
//!   list linearly for its valid edge.
//! - Strips are walked only when their own vertices change, as in SETS. In table 3 of that paper,
//!   the times of both models decrease as more levels are recovered, "due to the use of coherence".
//! - Labels, states and packed arrays are those of SETS. Only the lists differ.
//!
//! # References
//! Belmonte, Remolar, Ribelles, Chover, Fernández: *Efficiently Using Connectivity Information
//! between Triangles in a Mesh for Real-Time Rendering*, 2004.
//! Belmonte, Aguado, Sancho: *Triangle Strip Multiresolution Modelling Using Sorted Edges*, 2006,
//! section 4.
//!
//! # Complexity
//! A move takes one step per strip, and one per edge of the vertices of changed strips. The bunny's
//! 69,451 triangles take 22 bytes each.

use std::sync::Arc;

use tristrip::lod::strip_graphs::{
    Accesses, Graph, ListBuilder, NONE, Packed, PackedRow, RecoveredStrips, StripGraph, StripGraphs,
    SuccessorLists, bits_for,
};
use tristrip::lod::{LevelCursor, LevelModel, LevelTable};
use tristrip::{CollapseSequence, Error, Strips};

/// Strips at all levels, as lists of edges (after Belmonte et al. 2004).
///
/// ```
/// use std::sync::Arc;
/// use tristrip::{CollapseSequence, Rename, Strips};
/// use tristrip::lod::LevelModel;
/// use tristrip_lab::baselines::Mts;
/// let mut strips = Strips::default();
/// strips.push(&[0, 1, 2, 3, 4, 5]);
/// let rename = [Rename { removed: 2, kept: 3 }];
/// let sequence = CollapseSequence::from_collapses(6, strips.to_list(), [(&rename[..], 0.5)])?;
/// let mut cursor = Arc::new(Mts::new(&strips, &sequence)?).start();
/// cursor.set_level(0)?;
/// assert_eq!(cursor.strips().vertices(), [0, 1, 3, 3, 4, 5]);
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Mts(Arc<StripGraphs<UnsortedEdges>>);

impl Mts {
    /// Builds the model from strips of the full mesh.
    ///
    /// # Errors
    /// A strip has a vertex that is not in the sequence, the collapses rename too many slots, or a
    /// walk would examine too many edges. The latter occurs if one strip surrounds a vertex of
    /// thousands of triangles, because each visit searches all its edges.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let model = Arc::new(Mts::new(&strips, &sequence)?);
    /// let mut cursor = model.start();
    /// cursor.set_level(1)?;
    /// assert_eq!(cursor.strips().vertices(), [0, 1, 2, 3]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn new(strips: &Strips, sequence: &CollapseSequence) -> Result<Self, Error> {
        StripGraphs::new(strips, sequence).map(|graphs| Self(Arc::new(graphs)))
    }

    /// Counts the list entries that a move between two levels reads: beginnings, labels and
    /// successors of the strips that differ between them. These reads take most of the time of a
    /// move, and their number is the same on every machine.
    ///
    /// # Errors
    /// The level does not exist.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let model = Mts::new(&strips, &sequence)?;
    /// assert_eq!(model.accesses(1, 1)?, 0);
    /// assert!(model.accesses(2, 0)? > 0 && model.accesses(0, 3).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn accesses(&self, from: usize, to: usize) -> Result<u64, Error> {
        self.0.accesses(from, to)
    }
}

impl LevelModel for Mts {
    fn levels(&self) -> &LevelTable {
        &self.0.levels
    }

    fn memory(&self) -> usize {
        self.0.memory()
    }

    fn start(self: Arc<Self>) -> Box<dyn LevelCursor> {
        Box::new(RecoveredStrips::new(Arc::clone(&self.0)))
    }
}

/// The lists of a strip: for each node the end of its range of edges, and the edges. An edge has
/// the first and last state, and the next node.
#[derive(Debug, Clone, PartialEq)]
struct UnsortedEdges;

struct Reader<'a> {
    packed: &'a Packed,
    node_ends: PackedRow<'a>,
    edges_start: usize,
    state_bits: u32,
    node_bits: u32,
}

impl SuccessorLists for UnsortedEdges {
    type Builder = EdgeBuilder;
    type Reader<'a> = Reader<'a>;

    fn reader<'a>(packed: &'a Packed, start: usize, graph: &Graph) -> Reader<'a> {
        let end_bits = bits_for(graph.arc_count);
        Reader {
            packed,
            node_ends: PackedRow::new(packed, start, end_bits),
            edges_start: start + graph.node_count as usize * end_bits as usize,
            state_bits: graph.state_bits(),
            node_bits: graph.node_bits(),
        }
    }

    #[inline]
    fn successor(
        lists: &Reader<'_>,
        node: u32,
        visits: &mut u32,
        state: u32,
        accesses: &mut impl Accesses,
    ) -> u32 {
        let edge_bits = (2 * lists.state_bits + lists.node_bits) as usize;
        let first = if node == 0 { 0 } else { lists.node_ends.get(node - 1) };
        let mut at = lists.edges_start + first as usize * edge_bits;
        let mut left = *visits;
        loop {
            accesses.add_one();
            let [first, last] = lists.packed.get_pair(at, [lists.state_bits; 2]);
            if (first..=last).contains(&state) {
                if left == 0 {
                    accesses.add_one();
                    *visits += 1;
                    return lists.packed.get(at + 2 * lists.state_bits as usize, lists.node_bits);
                }
                left -= 1;
            }
            at += edge_bits;
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Edge {
    node: u32,
    slot: u32,
    first: u32,
    last: u32,
    successor: u32,
}

#[derive(Debug, Default)]
struct EdgeBuilder {
    /// The edge of each slot in the current state. Its node is [`NONE`] if the slot is removed.
    open: Vec<Edge>,
    edges: Vec<Edge>,
    cost: usize,
}

impl ListBuilder for EdgeBuilder {
    fn clear(&mut self) {
        self.edges.clear();
        self.open.clear();
        self.cost = 0;
    }

    fn update(&mut self, graph: &StripGraph, state: u32) {
        if state == 0 {
            let none = Edge { node: NONE, slot: 0, first: 0, last: 0, successor: 0 };
            self.open.resize(graph.slot_count(), none);
        }
        for &slot in &graph.changed_slots {
            let edge = graph.edge(slot);
            let open = &mut self.open[slot as usize];
            if edge == Some([open.node, open.successor]) {
                continue;
            }
            if open.node != NONE {
                self.edges.push(Edge { last: state - 1, ..*open });
            }
            let [node, successor] = edge.unwrap_or([NONE; 2]);
            *open = Edge { node, slot, first: state, last: 0, successor };
        }
    }

    /// Also sorts the edges by node and slot.
    fn end(&mut self, last: u32) {
        let open = self.open.iter().filter(|edge| edge.node != NONE);
        self.edges.extend(open.map(|&edge| Edge { last, ..edge }));
        self.edges.sort_unstable();
        let of_node = self.edges.chunk_by(|a, b| a.node == b.node);
        self.cost =
            of_node.map(|edges| edges.len().saturating_mul(edges.len())).fold(0, usize::saturating_add);
    }

    fn arc_count(&self) -> usize {
        self.edges.len()
    }

    fn successor_count(&self) -> usize {
        0
    }

    /// The maximum number of edges that a walk examines: all edges of a node for each of its
    /// visits.
    fn cost(&self) -> usize {
        self.cost
    }

    fn push(&self, graph: &Graph, packed: &mut Packed) {
        for node in 0..graph.node_count {
            let end = self.edges.partition_point(|edge| edge.node <= node);
            packed.push(end as u32, bits_for(graph.arc_count));
        }
        for edge in &self.edges {
            packed.push(edge.first, graph.state_bits());
            packed.push(edge.last, graph.state_bits());
            packed.push(edge.successor.min(graph.node_count), graph.node_bits());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vertex_of_thousands_of_triangles_is_refused() {
        // One strip around vertex 0: each visit of the vertex would search thousands of edges.
        let rim = 5_000_u32;
        let mut strips = Strips::default();
        strips.push(&(1..=rim).flat_map(|v| [v, 0]).collect::<Vec<_>>());
        let sequence = CollapseSequence::from_collapses(rim as usize + 1, strips.to_list(), []).unwrap();
        let error = Mts::new(&strips, &sequence).unwrap_err();
        assert!(error.to_string().contains("successors of all vertices"), "{error}");
    }
}
