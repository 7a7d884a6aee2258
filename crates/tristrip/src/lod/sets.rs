//! Sorted-edge triangle strips (SETS). Each vertex of a strip stores its successors, sorted by the
//! level up to which they are valid. A single walk recovers any level of a strip.
//!
//! ```text
//! level of the paper     0 a b c d e f g h     1 a b d d e f g h     2 d d e f g h     3 e d g h
//!
//! beginnings   a until 1, d until 2, e until 3
//! a            b until 1
//! b            c until 0, d until 1
//! d            e until 0, d e until 2, g until 3   level 1 visits d twice: d, then e
//! e            f until 2, d until 3
//! ```
//! # Algorithm
//! *Build*: the strips follow the collapses, and superfluous vertices are removed (see
//! `shortened.rs`). At each state of a strip, a vertex whose successors changed gets a new arc. The
//! arc lists all successors of the vertex at this state, in the order of the visits. The label of
//! an arc is the last state at which it is valid. Only the vertices next to a change are examined.
//!
//! *Recover*: find the beginning by binary search. At the first visit of a vertex, find its arc by
//! binary search; at each visit, take the next successor of the arc, until the end is reached.
//!
//! *Coherence*: each strip stores the interval of levels in which its vertices do not change, and
//! is walked only when the level leaves this interval.
//!
//! # Departures
//! - The paper counts levels from the full mesh; this crate counts them from the base mesh.
//! - Labels are indices of the strip's states, not levels. The levels of the states are stored once
//!   per strip, as the paper does for coherence.
//! - The arrays of each strip are packed one after the other, with as many bits per number as the
//!   strip needs, instead of objects that contain arrays. Visit counters belong to the walk, so
//!   instances share the model.
//! - The paper does not say which subsequences are removed; `shortened.rs` removes pairs until none
//!   can be removed.
//!
//! # References
//! Belmonte, Aguado, Sancho: *Triangle Strip Multiresolution Modelling Using Sorted Edges*, 2006,
//! section 3.
//!
//! # Complexity
//! Building takes time proportional to the number of stored successors times its logarithm. A level
//! change takes one step per strip, one step per vertex of the changed strips, and a binary search
//! at the first visit of each vertex. The bunny's 69,451 triangles take 24 bytes each.

pub(crate) mod multiresolution;
pub(crate) mod shortened;
pub(crate) mod strip_graph;
pub(crate) mod strip_states;

use std::sync::Arc;

use crate::collapse::CollapseSequence;
use crate::error::Error;
use crate::lod::level::level_model::{LevelCursor, LevelModel};
use crate::lod::level::level_table::LevelTable;
use crate::lod::sets::multiresolution::{
    Accesses, Graph, ListBuilder, RecoveredStrips, StripGraphs, SuccessorLists,
};
use crate::lod::sets::strip_graph::StripGraph;
use crate::packed::{Packed, PackedRow, bits_for};
use crate::strip::Strips;

/// Strips at all levels as sorted edges (Belmonte et al. 2006).
///
/// ```
/// use std::sync::Arc;
/// use tristrip::{CollapseSequence, Rename, Strips};
/// use tristrip::lod::{LevelModel, Sets};
/// let mut strips = Strips::default();
/// strips.push(&[0, 1, 2, 3, 4, 5, 6, 7]);
/// // The collapses of figure 1 of the paper: c to d, a to b, and f to d.
/// let renames = [(2, 3), (0, 1), (5, 3)].map(|(removed, kept)| [Rename { removed, kept }]);
/// let collapses = renames.iter().map(|renames| (&renames[..], 0.5));
/// let sequence = CollapseSequence::from_collapses(8, strips.to_list(), collapses)?;
/// let mut cursor = Arc::new(Sets::new(&strips, &sequence)?).start();
/// cursor.set_level(2)?;
/// assert_eq!(cursor.strips().vertices(), [0, 1, 3, 3, 4, 5, 6, 7]);
/// cursor.set_level(0)?;
/// assert_eq!(cursor.strips().vertices(), [4, 3, 6, 7]);
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Sets(Arc<StripGraphs<SortedArcs>>);

impl Sets {
    /// Builds the model from strips of the full mesh.
    ///
    /// # Errors
    /// A strip has a vertex that is not in the sequence, or the strips have too many arcs. A strip
    /// has too many arcs if thousands of its triangles surround one vertex, because the successors
    /// of this vertex change with each collapse around it.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let model = Arc::new(Sets::new(&strips, &sequence)?);
    /// let mut cursor = model.start();
    /// cursor.set_level(1)?;
    /// assert_eq!(cursor.strips().vertices(), [0, 1, 2, 3]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn new(strips: &Strips, sequence: &CollapseSequence) -> Result<Self, Error> {
        StripGraphs::new(strips, sequence).map(|graphs| Self(Arc::new(graphs)))
    }

    /// Returns the number of list entries that a level change reads: beginnings, labels and
    /// successors of the strips that differ between the two levels. Reading them dominates the time
    /// of a level change. Their number does not depend on the machine.
    ///
    /// # Errors
    /// One of the levels does not exist.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let model = Sets::new(&strips, &sequence)?;
    /// assert_eq!(model.accesses(1, 1)?, 0);
    /// assert!(model.accesses(2, 0)? > 0 && model.accesses(0, 3).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn accesses(&self, from: usize, to: usize) -> Result<u64, Error> {
        self.0.accesses(from, to)
    }
}

impl LevelModel for Sets {
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

/// The lists of a strip: per node, the end of its arcs; per arc, its label and the start of its
/// successors; the successors.
#[derive(Debug, Clone, PartialEq)]
struct SortedArcs;

struct Reader<'a> {
    packed: &'a Packed,
    node_ends: PackedRow<'a>,
    arcs_start: usize,
    /// The bits of a label and of a start.
    arc_bits: [u32; 2],
    successors: PackedRow<'a>,
}

impl SuccessorLists for SortedArcs {
    type Builder = ArcBuilder;
    type Reader<'a> = Reader<'a>;

    fn reader<'a>(packed: &'a Packed, start: usize, graph: &Graph) -> Reader<'a> {
        let end_bits = bits_for(graph.arc_count);
        let arc_bits = [graph.state_bits(), bits_for(graph.successor_count)];
        let arcs_start = start + graph.node_count as usize * end_bits as usize;
        let arcs_end = arcs_start + graph.arc_count as usize * (arc_bits[0] + arc_bits[1]) as usize;
        Reader {
            packed,
            node_ends: PackedRow::new(packed, start, end_bits),
            arcs_start,
            arc_bits,
            successors: PackedRow::new(packed, arcs_end, graph.node_bits()),
        }
    }

    #[inline]
    fn successor(
        lists: &Reader<'_>,
        node: u32,
        next: &mut u32,
        state: u32,
        accesses: &mut impl Accesses,
    ) -> u32 {
        if *next == 0 {
            let mut low = if node == 0 { 0 } else { lists.node_ends.get(node - 1) };
            let mut high = lists.node_ends.get(node) - 1;
            let width = (lists.arc_bits[0] + lists.arc_bits[1]) as usize;
            let arc = |i: u32| lists.packed.get_pair(lists.arcs_start + i as usize * width, lists.arc_bits);
            while low < high {
                let middle = low.midpoint(high);
                accesses.add_one();
                if arc(middle)[0] < state { low = middle + 1 } else { high = middle }
            }
            accesses.add_one();
            // One more than the index of the next successor.
            *next = 1 + arc(low)[1];
        }
        accesses.add_one();
        *next += 1;
        lists.successors.get(*next - 2)
    }
}

#[derive(Debug, Default)]
struct ArcBuilder {
    /// Nodes after `node_count` are kept to reuse their memory.
    nodes: Vec<SortedNode>,
    node_count: usize,
    successor_count: usize,
    current: Vec<u32>,
}

#[derive(Debug, Default)]
struct SortedNode {
    /// The last state of each arc, and its end in `successors`. The arc of the current state is
    /// open: it has no label yet.
    arcs: Vec<(u32, u32)>,
    successors: Vec<u32>,
    is_open: bool,
}

impl ListBuilder for ArcBuilder {
    fn clear(&mut self) {
        self.nodes[..self.node_count].iter_mut().for_each(|node| {
            node.arcs.clear();
            node.successors.clear();
            node.is_open = false;
        });
        (self.node_count, self.successor_count) = (0, 0);
    }

    /// Opens an arc for each node whose successors changed.
    fn update(&mut self, graph: &StripGraph, state: u32) {
        self.node_count = graph.vertices.len();
        if self.nodes.len() < self.node_count {
            self.nodes.resize_with(self.node_count, SortedNode::default);
        }
        for &number in &graph.changed {
            graph.successors_to(number, &mut self.current);
            let node = &mut self.nodes[number as usize];
            let open = node.open();
            if node.is_open && node.successors[open..] == self.current {
                continue;
            }
            node.close(state.saturating_sub(1));
            if !self.current.is_empty() {
                node.successors.extend_from_slice(&self.current);
                node.is_open = true;
                self.successor_count += self.current.len();
            }
        }
    }

    fn end(&mut self, last: u32) {
        self.nodes[..self.node_count].iter_mut().for_each(|node| node.close(last));
    }

    fn arc_count(&self) -> usize {
        self.nodes[..self.node_count].iter().map(|node| node.arcs.len()).sum()
    }

    fn successor_count(&self) -> usize {
        self.successor_count
    }

    /// The stored successors.
    fn cost(&self) -> usize {
        self.successor_count
    }

    fn push(&self, graph: &Graph, packed: &mut Packed) {
        let nodes = &self.nodes[..self.node_count];
        let mut end = 0;
        for node in nodes {
            end += node.arcs.len() as u32;
            packed.push(end, bits_for(graph.arc_count));
        }
        let mut before = 0;
        for node in nodes {
            let mut start = before;
            for &(label, end) in &node.arcs {
                packed.push(label, graph.state_bits());
                packed.push(start, bits_for(graph.successor_count));
                start = before + end;
            }
            before = start;
        }
        for &successor in nodes.iter().flat_map(|node| &node.successors) {
            packed.push(successor.min(graph.node_count), graph.node_bits());
        }
    }
}

impl SortedNode {
    /// Returns the start of the open arc.
    fn open(&self) -> usize {
        self.arcs.last().map_or(0, |&(_, end)| end as usize)
    }

    fn close(&mut self, label: u32) {
        if std::mem::take(&mut self.is_open) {
            self.arcs.push((label, self.successors.len() as u32));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collapse::Rename;
    use crate::lod::sets::shortened::{NONE, edits_of};

    /// The strip a to h of the paper's figures as vertices 0 to 7, and its four collapses.
    fn figures() -> (Strips, CollapseSequence) {
        let mut strips = Strips::default();
        strips.push(&[0, 1, 2, 3, 4, 5, 6, 7]);
        let renames = ["cd", "ab", "fd", "gh"].map(|pair| {
            let [removed, kept] = [0, 1].map(|i| u32::from(pair.as_bytes()[i] - b'a'));
            [Rename { removed, kept }]
        });
        let collapses = renames.iter().map(|renames| (&renames[..], 0.5));
        let sequence = CollapseSequence::from_collapses(8, strips.to_list(), collapses).unwrap();
        (strips, sequence)
    }

    fn letter(number: u32) -> String {
        if number == NONE { "end".into() } else { char::from(b'a' + number as u8).to_string() }
    }

    #[test]
    fn figure_1() {
        let (strips, sequence) = figures();
        let mut cursor = Arc::new(Sets::new(&strips, &sequence).unwrap()).start();
        let mut of_level = |level_of_the_paper: usize| {
            cursor.set_level(4 - level_of_the_paper).unwrap();
            cursor.strips().vertices().iter().map(|&v| letter(v)).collect::<String>()
        };
        // The last step of the figure, g to h, gives e d h h and removes one vertex. The number of
        // removed vertices should be even (section 3.2), but nothing follows the end of a strip, so
        // no winding changes.
        assert_eq!([0, 1, 2, 3, 4].map(&mut of_level), ["abcdefgh", "abddefgh", "ddefgh", "edgh", "edh"]);
    }

    #[test]
    fn figure_2() {
        let (strips, sequence) = figures();
        let edits = edits_of(&strips, &sequence).unwrap();
        let (mut graph, mut arcs, mut beginnings) =
            (StripGraph::default(), ArcBuilder::default(), Vec::new());
        graph.start(&[0, 1, 2, 3, 4, 5, 6, 7]);
        arcs.update(&graph, 0);
        beginnings.push(letter(graph.first()));
        for (state, step) in (1..).zip(edits.row(0).chunk_by(|a, b| a.step == b.step)) {
            graph.step(step);
            arcs.update(&graph, state);
            beginnings.push(letter(graph.first()));
        }
        arcs.end(4);
        let series = |node: &SortedNode| {
            let mut start = 0;
            let arc = |&(label, end): &(u32, u32)| {
                let successors = &node.successors[std::mem::replace(&mut start, end as usize)..end as usize];
                let names: Vec<String> = successors.iter().map(|&node| letter(node)).collect();
                format!("{} ({label})", names.join(","))
            };
            node.arcs.iter().map(arc).collect::<Vec<_>>().join(" ")
        };
        let printed = [
            "b (1)",
            "c (0) d (1)",
            "d (0)",
            "e (0) d,e (2) g (3) h (4)",
            "f (2) d (4)",
            "g (2)",
            "h (3)",
            "end (4)",
        ];
        assert_eq!(arcs.nodes[..8].iter().map(series).collect::<Vec<_>>(), printed);
        // The figure prints a until 1, d until 2 and e until 3; its own walk needs e until 4.
        assert_eq!(beginnings, ["a", "a", "d", "e", "e"]);
    }

    #[test]
    fn figure_4() {
        let (strips, sequence) = figures();
        let Sets(model) = Sets::new(&strips, &sequence).unwrap();
        let walk = |state: u32| {
            let mut vertices = [NONE; 8];
            let len = model.recover(0, state, &mut Vec::new(), &mut vertices, &mut ());
            vertices[..len].iter().map(|&v| letter(v)).collect::<String>()
        };
        assert_eq!((walk(1), walk(3)), ("abddefgh".into(), "edgh".into()));
    }

    #[test]
    fn a_vertex_with_ever_new_successors_is_refused() {
        // One strip around vertex 0: its successors change with each collapse of the rim.
        let rim = 5_000_u32;
        let mut strips = Strips::default();
        strips.push(&(1..=rim).flat_map(|v| [v, 0]).collect::<Vec<_>>());
        let renames: Vec<[Rename; 1]> = (1..rim).map(|v| [Rename { removed: v, kept: v + 1 }]).collect();
        let collapses = renames.iter().map(|renames| (&renames[..], 0.0));
        let sequence =
            CollapseSequence::from_collapses(rim as usize + 1, strips.to_list(), collapses).unwrap();
        let error = Sets::new(&strips, &sequence).unwrap_err();
        assert!(error.to_string().contains("successors of all vertices"), "{error}");
    }
}
