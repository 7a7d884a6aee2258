//! Shared parts of SETS and similar models (MTS, in `tristrip-lab`). Each strip is a graph. A walk
//! through the graph recovers the strip at any of its states. Only strips whose state changed are
//! walked.
//!
//! State 0 of a strip is the full mesh, and each collapse that changes the strip leads to the next
//! state. The collapses at which states begin are stored per strip. The labels of a graph are
//! therefore states instead of levels. A strip has few states.
//!
//! # References
//! Belmonte, Aguado, Sancho: *Triangle Strip Multiresolution Modelling Using Sorted Edges*, 2006,
//! sections 3.2 to 3.4.

use std::marker::PhantomData;
use std::sync::Arc;

use super::shortened::edits_of;
use super::strip_graph::StripGraph;
use crate::collapse::CollapseSequence;
use crate::error::Error;
use crate::lod::level::level_model::LevelCursor;
use crate::lod::level::level_table::LevelTable;
use crate::lod::level::replay::MAX_SLOTS_PER_ENTRY;
use crate::packed::{Packed, PackedRow, bits_for};
use crate::strip::Strips;

/// Defines how the successors of nodes are stored and found.
pub trait SuccessorLists: Send + Sync + 'static {
    /// Collects the lists of a strip.
    type Builder: ListBuilder;
    /// Reads the lists of a strip.
    type Reader<'a>;

    /// Returns the lists of a strip that begin at a bit of the packed array.
    fn reader<'a>(packed: &'a Packed, start: usize, graph: &Graph) -> Self::Reader<'a>;

    /// Returns the node that follows a visit of a node at a state. `visit` is 0 at the first visit;
    /// at later visits it has the value that the previous one assigned.
    fn successor(
        lists: &Self::Reader<'_>,
        node: u32,
        visit: &mut u32,
        state: u32,
        accesses: &mut impl Accesses,
    ) -> u32;
}

/// Counts list entries as they are read. An implementation may ignore them.
pub trait Accesses {
    /// Adds one.
    fn add_one(&mut self);
}

impl Accesses for () {
    #[inline]
    fn add_one(&mut self) {}
}

impl Accesses for u64 {
    fn add_one(&mut self) {
        *self += 1;
    }
}

/// The lists of one strip while its states are enumerated.
pub trait ListBuilder: Default {
    /// Removes all lists.
    fn clear(&mut self);

    /// Records what changed at a state.
    fn update(&mut self, graph: &StripGraph, state: u32);

    /// Closes the lists at the last state.
    fn end(&mut self, last: u32);

    /// Returns the number of arcs or edges, in linear time.
    fn arc_count(&self) -> usize;

    /// Returns the number of successors in the lists of all arcs.
    fn successor_count(&self) -> usize;

    /// Returns the cost to compare with the number of slots of the full mesh. It grows with each
    /// state and is exact at the end.
    fn cost(&self) -> usize;

    /// Packs the lists of a graph. A successor equal to the number of nodes is the end of the
    /// strip.
    fn push(&self, graph: &Graph, packed: &mut Packed);
}

/// The packed graph of one strip. It stores the beginnings of the strip, the vertex of each node,
/// and the lists of successors. A beginning consists of its node and its last valid state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Graph {
    start: usize,
    state_count: u32,
    beginning_count: u32,
    /// The number of nodes.
    pub node_count: u32,
    /// The number of arcs or edges.
    pub arc_count: u32,
    /// The number of successors in the lists of all arcs.
    pub successor_count: u32,
}

impl Graph {
    /// Returns the number of bits of a state.
    pub fn state_bits(&self) -> u32 {
        bits_for(self.state_count - 1)
    }

    /// Returns the number of bits of a node or of the end of the strip.
    pub fn node_bits(&self) -> u32 {
        bits_for(self.node_count)
    }
}

/// The strips of a mesh at all levels, one graph per strip.
#[derive(Debug, Clone, PartialEq)]
pub struct StripGraphs<L> {
    /// The levels.
    pub levels: LevelTable,
    states: StripStates,
    graphs: Vec<Graph>,
    packed: Packed,
    vertex_bits: u32,
    lists: PhantomData<L>,
}

impl<L: SuccessorLists> StripGraphs<L> {
    /// Builds the graphs of strips of the full mesh.
    ///
    /// # Errors
    /// A strip has a vertex that is not in the sequence, or there are too many renamed slots or
    /// successors.
    pub fn new(strips: &Strips, sequence: &CollapseSequence) -> Result<Self, Error> {
        strips.check_vertices(sequence.vertex_count())?;
        let edits = edits_of(strips, sequence)?;
        let mut model = Self {
            levels: LevelTable::of(sequence),
            states: StripStates::new(sequence.len()),
            graphs: Vec::with_capacity(strips.len()),
            packed: Packed::default(),
            vertex_bits: bits_for(sequence.vertex_count() as u32),
            lists: PhantomData,
        };
        let limit = strips.vertices_sent().saturating_mul(MAX_SLOTS_PER_ENTRY).min(u32::MAX as usize);
        let check = |cost: usize| {
            let (found, limit) = (cost as u64, limit as u64);
            let error =
                Error::LimitExceeded { what: "steps to list the successors of all vertices", found, limit };
            if found > limit { Err(error) } else { Ok(()) }
        };
        let (mut graph, mut lists, mut cost) = (StripGraph::default(), L::Builder::default(), 0_usize);
        for (number, strip) in (0..).zip(strips.iter()) {
            // The last state and the node of each beginning.
            let mut beginnings: Vec<(u32, u32)> = Vec::new();
            let mut state = 0;
            graph.start(strip);
            lists.clear();
            lists.update(&graph, state);
            let steps = || edits.row(number).chunk_by(|a, b| a.step == b.step);
            for step in steps() {
                let first = graph.first();
                graph.step(step);
                if graph.first() != first {
                    beginnings.push((state, first));
                }
                state += 1;
                lists.update(&graph, state);
                check(cost.saturating_add(lists.cost()))?;
            }
            beginnings.push((state, graph.first()));
            lists.end(state);
            cost = cost.saturating_add(lists.cost());
            check(cost)?;
            model.states.push(strip.len(), steps().map(|step| step[0].step));
            model.push(&graph.vertices, &beginnings, &lists);
        }
        Ok(model)
    }

    /// Packs the graph of the next strip.
    fn push(&mut self, vertices: &[u32], beginnings: &[(u32, u32)], lists: &L::Builder) {
        let graph = Graph {
            start: self.packed.bit_count(),
            // A graph has at least one beginning; the last one is valid until the last state.
            state_count: 1 + beginnings.last().map_or(0, |&(state, _)| state),
            beginning_count: beginnings.len() as u32,
            node_count: vertices.len() as u32,
            arc_count: lists.arc_count() as u32,
            successor_count: lists.successor_count() as u32,
        };
        for &(state, node) in beginnings {
            self.packed.push(state, graph.state_bits());
            self.packed.push(node.min(graph.node_count), graph.node_bits());
        }
        vertices.iter().for_each(|&vertex| self.packed.push(vertex, self.vertex_bits));
        lists.push(&graph, &mut self.packed);
        self.graphs.push(graph);
    }

    /// Returns the memory in bytes.
    pub fn memory(&self) -> usize {
        let graphs = size_of_val(&self.graphs[..]);
        self.levels.memory() + self.states.memory() + graphs + self.packed.memory()
    }

    /// Writes the vertices of a strip at a state, and returns their number. `walk` is scratch
    /// memory.
    pub(crate) fn recover(
        &self,
        strip: usize,
        state: u32,
        walk: &mut Vec<u32>,
        vertices: &mut [u32],
        accesses: &mut impl Accesses,
    ) -> usize {
        let graph = &self.graphs[strip];
        let (state_bits, node_bits) = (graph.state_bits(), graph.node_bits());
        let pair_bits = (state_bits + node_bits) as usize;
        // 1. The beginning.
        let beginning = |i: u32| graph.start + i as usize * pair_bits;
        let (mut low, mut high) = (0, graph.beginning_count);
        while low < high {
            let middle = low.midpoint(high);
            accesses.add_one();
            let last = self.packed.get(beginning(middle), state_bits);
            if last < state { low = middle + 1 } else { high = middle }
        }
        let mut node = self.packed.get(beginning(low) + state_bits as usize, node_bits);
        // 2. The walk.
        let names_start = beginning(graph.beginning_count);
        let names = PackedRow::new(&self.packed, names_start, self.vertex_bits);
        let lists_start = names_start + graph.node_count as usize * self.vertex_bits as usize;
        let lists = L::reader(&self.packed, lists_start, graph);
        walk.clear();
        walk.resize(graph.node_count as usize, 0);
        let mut len = 0;
        while node < graph.node_count {
            vertices[len] = names.get(node);
            len += 1;
            node = L::successor(&lists, node, &mut walk[node as usize], state, accesses);
        }
        len
    }
}

impl<L: SuccessorLists> StripGraphs<L> {
    /// Returns the number of entries that a level change reads in the strips that differ between
    /// two levels.
    ///
    /// # Errors
    /// A level is greater than the number of collapses.
    pub fn accesses(&self, from: usize, to: usize) -> Result<u64, Error> {
        for level in [from, to] {
            self.levels.check(level)?;
        }
        let [from, to] = [from, to].map(|level| (self.levels.collapse_count() - level) as u32);
        let (mut accesses, mut walk, mut vertices) = (0_u64, Vec::new(), Vec::new());
        for strip in 0..self.states.strip_count() {
            let (state, interval) = self.states.state_at(strip, to);
            if !(interval[0]..interval[1]).contains(&from) {
                let [slots, _] = self.states.ranges(strip);
                vertices.resize(slots.len(), 0);
                self.recover(strip, state, &mut walk, &mut vertices, &mut accesses);
            }
        }
        Ok(accesses)
    }
}

/// The slots of each strip at the full mesh, and the collapses at which its states begin.
#[derive(Debug, Clone, PartialEq, Default)]
struct StripStates {
    /// The end of each strip in the slots of all strips, and of its states in those of all strips.
    ends: Vec<[u32; 2]>,
    /// The collapse that leads to each state but the first, counted from 1 at the full mesh.
    steps: Packed,
    step_bits: u32,
}

impl StripStates {
    fn new(collapse_count: usize) -> Self {
        Self { step_bits: bits_for(collapse_count as u32), ..Self::default() }
    }

    /// Appends a strip, with the collapses that lead to its states but the first.
    fn push(&mut self, slot_count: usize, steps: impl Iterator<Item = u32>) {
        let [mut slot_end, mut state_end] = self.ends.last().copied().unwrap_or_default();
        slot_end += slot_count as u32;
        for step in steps {
            self.steps.push(step, self.step_bits);
            state_end += 1;
        }
        self.ends.push([slot_end, state_end]);
    }

    fn strip_count(&self) -> usize {
        self.ends.len()
    }

    /// Returns the range of a strip's slots, and that of its states but the first.
    fn ranges(&self, strip: usize) -> [std::ops::Range<u32>; 2] {
        let start = if strip == 0 { [0; 2] } else { self.ends[strip - 1] };
        let end = self.ends[strip];
        [start[0]..end[0], start[1]..end[1]]
    }

    /// Returns the state of a strip after a number of collapses, and the half-open range of numbers
    /// of collapses in which it has this state.
    fn state_at(&self, strip: usize, step: u32) -> (u32, [u32; 2]) {
        let [_, states] = self.ranges(strip);
        let steps = PackedRow::new(&self.steps, 0, self.step_bits);
        let next = steps.first_at_least(states.start, states.end, step + 1);
        let from = if next == states.start { 0 } else { steps.get(next - 1) };
        let before = if next == states.end { u32::MAX } else { steps.get(next) };
        (next - states.start, [from, before])
    }

    fn memory(&self) -> usize {
        size_of_val(&self.ends[..]) + self.steps.memory()
    }
}

/// The strips of a model at one level.
#[derive(Debug, Clone)]
pub struct RecoveredStrips<L> {
    model: Arc<StripGraphs<L>>,
    level: usize,
    /// The vertices of each strip, at the beginning of its slots. `lens` has their numbers.
    vertices: Vec<u32>,
    lens: Vec<u32>,
    /// For each strip, the half-open range of numbers of collapses in which its vertices are valid.
    valid: Vec<[u32; 2]>,
    walk: Vec<u32>,
    display: Strips,
    is_current: bool,
}

impl<L: SuccessorLists> RecoveredStrips<L> {
    /// Creates the strips at the full mesh.
    pub fn new(model: Arc<StripGraphs<L>>) -> Self {
        let states = &model.states;
        let strip_count = states.strip_count();
        let slot_count = states.ends.last().map_or(0, |end| end[0] as usize);
        let level = model.levels.collapse_count();
        let mut recovered = Self {
            level,
            vertices: vec![0; slot_count],
            lens: vec![0; strip_count],
            // No strip is valid yet.
            valid: vec![[1, 0]; strip_count],
            walk: Vec::new(),
            display: Strips::default(),
            is_current: false,
            model,
        };
        recovered.recover();
        recovered
    }

    /// Recovers the strips that are not valid at the current level.
    fn recover(&mut self) {
        let step = (self.model.levels.collapse_count() - self.level) as u32;
        let states = &self.model.states;
        for (strip, valid) in self.valid.iter_mut().enumerate() {
            if (valid[0]..valid[1]).contains(&step) {
                continue;
            }
            let (state, interval) = states.state_at(strip, step);
            *valid = interval;
            let [slots, _] = states.ranges(strip);
            let vertices = &mut self.vertices[slots.start as usize..slots.end as usize];
            self.lens[strip] = self.model.recover(strip, state, &mut self.walk, vertices, &mut ()) as u32;
        }
    }
}

impl<L: SuccessorLists> LevelCursor for RecoveredStrips<L> {
    fn levels(&self) -> &LevelTable {
        &self.model.levels
    }

    fn level(&self) -> usize {
        self.level
    }

    fn set_level(&mut self, level: usize) -> Result<(), Error> {
        self.model.levels.check(level)?;
        if level != self.level {
            self.level = level;
            self.is_current = false;
            self.recover();
        }
        Ok(())
    }

    fn strips(&mut self) -> &Strips {
        if !self.is_current {
            self.display.clear();
            for (strip, &len) in self.lens.iter().enumerate().filter(|(_, len)| **len > 0) {
                let [slots, _] = self.model.states.ranges(strip);
                self.display.push(&self.vertices[slots.start as usize..][..len as usize]);
            }
            self.is_current = true;
        }
        &self.display
    }

    fn memory(&self) -> usize {
        let lists = [&self.vertices, &self.lens, &self.walk];
        let numbers: usize = lists.map(|list| size_of_val(&list[..])).iter().sum();
        numbers + size_of_val(&self.valid[..]) + self.display.memory()
    }
}
