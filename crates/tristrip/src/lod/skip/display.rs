//! The display strips of a view, stored in an index buffer.
//!
//! # Algorithm
//! A collapse or split flags the segments affected by the vertices that it renames. For each chunk
//! with a flagged segment:
//!
//! 1. The flagged segments are scanned again, each from the filter state at the end of the segment
//!    before it. A scan reads the name of each vertex, which is its first active ancestor, and
//!    emits the display strips.
//! 2. If the state at the end of a segment differs from before, the next segment is scanned, too.
//! 3. The output of the remaining segments of the chunk is moved. The part of the region that
//!    differs is reported as a changed range. If a region has become too short, a longer one is
//!    allocated at the end of the buffer.
//!
//! Unused entries of a region are filled with [`RESTART`], so the whole buffer can be drawn at
//! once.
//!
//! # References
//! El-Sana, Evans, Kalaiah, Varshney, Skiena, Azanli 2000, section 5.2.2. Departure: the paper
//! rebuilds whole strips.

use std::ops::Range;

use super::original_strips::{AHEAD, EntryRange, OriginalStrips};
use crate::lod::filter::{BLOCK, Dtfs, Filter, Gatherer, Linked, Scanner, Sink, Stss};
use crate::lod::filter::{replace_last_triangle, replace_last_vertex, reverse_but_for_start};
use crate::lod::level::index_map::RESTART;
use crate::strip::Strips;

/// The display strips, for each filter.
#[derive(Debug, Clone)]
pub(super) enum Display {
    None(Scanned<Unfiltered>),
    Stss(Scanned<Stss>),
    Dtfs(Scanned<Dtfs>),
    Linked(Scanned<Linked>),
}

/// Calls a method of the display strips for any filter.
macro_rules! with_filter {
    ($display:expr, $scanned:ident => $call:expr) => {
        match $display {
            Display::None($scanned) => $call,
            Display::Stss($scanned) => $call,
            Display::Dtfs($scanned) => $call,
            Display::Linked($scanned) => $call,
        }
    };
}

impl Display {
    /// Creates empty display strips with all segments flagged.
    pub(super) fn new(filter: Filter, strips: &OriginalStrips) -> Self {
        match filter {
            Filter::None => Self::None(Scanned::new(strips, true)),
            Filter::Stss => Self::Stss(Scanned::new(strips, true)),
            Filter::Dtfs => Self::Dtfs(Scanned::new(strips, true)),
            // This filter changes vertices that it has already sent.
            Filter::Linked => Self::Linked(Scanned::new(strips, false)),
        }
    }

    /// Flags the segments affected by a range of nodes.
    pub(super) fn flag(&mut self, nodes: Range<u32>, strips: &OriginalStrips) {
        with_filter!(self, scanned => scanned.buffer.flag(nodes, strips));
    }

    /// Scans the flagged segments and appends the ranges of the buffer that changed, in ascending
    /// order within each chunk. Returns the number of segments scanned.
    pub(super) fn rebuild(
        &mut self,
        strips: &OriginalStrips,
        names: &[u32],
        changed: &mut Vec<Range<usize>>,
    ) -> usize {
        with_filter!(self, scanned => scanned.rebuild(strips, names, changed))
    }

    /// Returns the index buffer, with [`RESTART`] between strips.
    pub(super) fn indices(&self) -> &[u32] {
        &self.buffer().indices
    }

    /// Iterates over the ranges of the buffer that contain display strips, in the order of the
    /// strips.
    pub(super) fn ranges(&self) -> impl Iterator<Item = Range<usize>> {
        let regions = self.buffer().regions.iter().filter(|region| region.len > 0);
        regions.map(|region| region.start as usize..(region.start + region.len) as usize)
    }

    /// Returns a copy of the display strips.
    pub(super) fn to_strips(&self) -> Strips {
        let mut strips = Strips::default();
        let indices = self.indices();
        let all = self.ranges().flat_map(|range| indices[range].split(|&index| index == RESTART));
        all.filter(|strip| !strip.is_empty()).for_each(|strip| strips.push(strip));
        strips
    }

    fn buffer(&self) -> &StripBuffer {
        with_filter!(self, scanned => &scanned.buffer)
    }

    pub(super) fn memory(&self) -> usize {
        with_filter!(self, scanned => scanned.memory())
    }
}

/// The display strips for one filter.
#[derive(Debug, Clone)]
pub(super) struct Scanned<S> {
    buffer: StripBuffer,
    /// The scan state after each segment.
    states: Vec<ScanState<S>>,
    /// Whether a scan can resume from a stored state, without the vertices sent before.
    may_resume: bool,
}

/// The scan state between two segments.
#[derive(Debug, Clone, PartialEq, Default)]
struct ScanState<S> {
    filter: S,
    /// Whether the next vertex starts a strip.
    is_next_new: bool,
}

/// The index buffer and the segments to rebuild.
#[derive(Debug, Clone)]
struct StripBuffer {
    indices: Vec<u32>,
    regions: Vec<Region>,
    /// The end of the output of each segment, relative to the start of its region.
    ends: Vec<u32>,
    is_flagged: Vec<bool>,
    flagged: Vec<u32>,
    /// The chunk of each segment.
    chunk_of: Vec<u32>,
}

/// The range of the buffer that holds the display strips of a chunk.
#[derive(Debug, Clone, Copy)]
struct Region {
    start: u32,
    len: u32,
    capacity: u32,
}

impl StripBuffer {
    fn new(strips: &OriginalStrips) -> Self {
        let count = strips.segment_count();
        let mut start = 0;
        let region = |chunk: &EntryRange| {
            // Filters send only slightly more vertices than the strips have, unless they split at
            // every second triangle.
            let len = chunk.end - chunk.start;
            let capacity = len + len / 4 + 16;
            start += capacity;
            Region { start: start - capacity, len: 0, capacity }
        };
        let chunk_of = strips
            .chunks()
            .iter()
            .zip(0..)
            .flat_map(|(chunk, number)| std::iter::repeat_n(number, chunk.segment_count()));
        let chunk_of = chunk_of.collect();
        let regions: Vec<Region> = strips.chunks().iter().map(region).collect();
        Self {
            indices: vec![RESTART; start as usize],
            regions,
            ends: vec![0; count],
            is_flagged: vec![true; count],
            flagged: (0..count as u32).collect(),
            chunk_of,
        }
    }

    fn flag(&mut self, nodes: Range<u32>, strips: &OriginalStrips) {
        for segment in strips.segments_of(nodes) {
            let is_flagged = &mut self.is_flagged[segment as usize];
            if !*is_flagged {
                *is_flagged = true;
                self.flagged.push(segment);
            }
        }
    }

    /// Returns the earlier output of a segment, given the first segment of its chunk.
    fn sent(&self, region: Region, first: usize, segment: usize) -> &[u32] {
        let from = if segment == first { 0 } else { self.ends[segment - 1] };
        &self.indices[(region.start + from) as usize..(region.start + self.ends[segment]) as usize]
    }

    /// Writes the output of a chunk from a position on, and appends the changed ranges.
    fn write(&mut self, chunk: usize, from: u32, sent: &[u32], changed: &mut Vec<Range<usize>>) {
        let region = self.regions[chunk];
        let len = from + sent.len() as u32;
        if len < region.capacity {
            let start = (region.start + from) as usize;
            let old = &mut self.indices[start..(region.start + region.len.max(len)) as usize];
            let is_new = |i: &usize| old[*i] != sent.get(*i).copied().unwrap_or(RESTART);
            let Some(first) = (0..old.len()).find(is_new) else {
                self.regions[chunk].len = len;
                return;
            };
            let last = (first..old.len()).rfind(is_new).unwrap_or(first);
            let kept = sent.len().min(old.len());
            old[..kept].copy_from_slice(&sent[..kept]);
            old[kept..].fill(RESTART);
            changed.push(start + first..start + last + 1);
            self.regions[chunk].len = len;
            return;
        }
        // The region moves to the end of the buffer.
        let old = region.start as usize..(region.start + region.len) as usize;
        let start = self.indices.len() as u32;
        self.indices.extend_from_within(region.start as usize..(region.start + from) as usize);
        self.indices.extend_from_slice(sent);
        let capacity = len + len / 2 + 16;
        self.indices.resize((start + capacity) as usize, RESTART);
        self.indices[old.clone()].fill(RESTART);
        changed.extend([old, start as usize..(start + capacity) as usize]);
        self.regions[chunk] = Region { start, len, capacity };
    }
}

impl<S: Scanner> Scanned<S> {
    fn new(strips: &OriginalStrips, may_resume: bool) -> Self {
        let buffer = StripBuffer::new(strips);
        Self { states: vec![ScanState::default(); buffer.ends.len()], buffer, may_resume }
    }

    fn rebuild(&mut self, strips: &OriginalStrips, names: &[u32], changed: &mut Vec<Range<usize>>) -> usize {
        let mut flagged = std::mem::take(&mut self.buffer.flagged);
        flagged.sort_unstable();
        let (mut scan, mut scanned) = (SegmentScan::new(), 0);
        let mut at = 0;
        while let Some(&segment) = flagged.get(at) {
            let number = self.buffer.chunk_of[segment as usize];
            at += flagged[at..].partition_point(|&s| self.buffer.chunk_of[s as usize] == number);
            let chunk = &strips.chunks()[number as usize];
            let from = if self.may_resume { segment } else { chunk.first_segment };
            scanned += self.rebuild_chunk(
                strips,
                (number as usize, chunk),
                from as usize,
                &mut scan,
                names,
                changed,
            );
        }
        flagged.clear();
        self.buffer.flagged = flagged;
        scanned
    }

    /// Scans the flagged segments of a chunk, starting with `from`.
    fn rebuild_chunk(
        &mut self,
        strips: &OriginalStrips,
        (number, chunk): (usize, &EntryRange),
        from: usize,
        scan: &mut SegmentScan,
        names: &[u32],
        changed: &mut Vec<Range<usize>>,
    ) -> usize {
        let first = chunk.first_segment as usize;
        let segments = from..first + chunk.segment_count();
        let entries = strips.entries(chunk);
        let mut state = if from == first { ScanState::default() } else { self.states[from - 1].clone() };
        let sent_before = if from == first { 0 } else { self.buffer.ends[from - 1] };
        let region = self.buffer.regions[number];
        scan.sink.start(sent_before > 0, state.is_next_new);
        scan.ends.clear();
        let (mut is_other, mut scanned) = (!self.may_resume, 0);
        for segment in segments.clone() {
            if is_other || self.buffer.is_flagged[segment] {
                self.buffer.is_flagged[segment] = false;
                scanned += 1;
                let start = (segment - first) * BLOCK;
                let end = entries.len().min(start + BLOCK + AHEAD);
                scan.names.clear();
                // [`RESTART`] is not a node.
                let name = |&node: &u32| names.get(node as usize).copied().unwrap_or(RESTART);
                scan.names.extend(entries[start..end].iter().map(name));
                state.filter.scan(&scan.names, &mut scan.gatherer, &mut scan.sink);
                state.is_next_new = scan.sink.is_next_new;
                is_other = !self.may_resume || state != self.states[segment];
                self.states[segment] = state.clone();
            } else {
                scan.sink.append(self.buffer.sent(region, first, segment));
                state = self.states[segment].clone();
                scan.sink.is_next_new = state.is_next_new;
            }
            scan.ends.push(sent_before + scan.sink.indices.len() as u32);
        }
        if !self.may_resume {
            state.filter.end(&mut scan.sink);
        }
        self.buffer.ends[segments].copy_from_slice(&scan.ends);
        self.buffer.write(number, sent_before, &scan.sink.indices, changed);
        scanned
    }

    fn memory(&self) -> usize {
        let buffer = &self.buffer;
        size_of_val(&buffer.indices[..])
            + size_of_val(&buffer.regions[..])
            + size_of_val(&buffer.ends[..])
            + size_of_val(&buffer.is_flagged[..])
            + size_of_val(&buffer.chunk_of[..])
            + size_of_val(&self.states[..])
    }
}

/// The working buffers for the scan of a chunk.
struct SegmentScan {
    names: Vec<u32>,
    gatherer: Gatherer,
    sink: RestartSink,
    ends: Vec<u32>,
}

impl SegmentScan {
    fn new() -> Self {
        Self { names: Vec::new(), gatherer: Gatherer::new(), sink: RestartSink::default(), ends: Vec::new() }
    }
}

/// Display strips as indices, with [`RESTART`] before each strip except the first.
#[derive(Debug, Default)]
struct RestartSink {
    indices: Vec<u32>,
    /// Whether a strip was sent before.
    is_begun: bool,
    /// Whether the next vertex starts a strip.
    is_next_new: bool,
    /// The start of the open strip.
    open: usize,
}

impl RestartSink {
    /// Starts the indices of a chunk. Earlier segments may have sent strips already.
    fn start(&mut self, is_begun: bool, is_next_new: bool) {
        self.indices.clear();
        (self.is_begun, self.is_next_new, self.open) = (is_begun, is_next_new, 0);
    }

    /// Appends the output of an earlier scan.
    fn append(&mut self, sent: &[u32]) {
        self.indices.extend_from_slice(sent);
        self.is_begun |= !sent.is_empty();
    }

    fn begin_strip(&mut self) {
        if std::mem::replace(&mut self.is_begun, true) {
            self.indices.push(RESTART);
        }
        self.open = self.indices.len();
        self.is_next_new = false;
    }
}

impl Sink for RestartSink {
    fn send(&mut self, vertex: u32) {
        self.send_all(&[vertex]);
    }

    fn send_all(&mut self, vertices: &[u32]) {
        if self.is_next_new || !self.is_begun {
            self.begin_strip();
        }
        self.indices.extend_from_slice(vertices);
    }

    fn send_block(
        &mut self,
        vertices: &[u32],
        starts: impl ExactSizeIterator<Item = u32>,
        _: usize,
        _: bool,
    ) {
        let mut from = 0;
        for start in starts.map(|start| start as usize) {
            self.indices.extend_from_slice(&vertices[from..start]);
            self.begin_strip();
            from = start;
        }
        self.indices.extend_from_slice(&vertices[from..]);
    }

    fn send_before_last(&mut self, vertex: u32) {
        let last = replace_last_vertex(&mut self.indices[self.open..], vertex);
        self.indices.extend(last);
    }

    fn replace_last(&mut self, vertices: [u32; 3]) {
        replace_last_triangle(&mut self.indices[self.open..], vertices);
    }

    fn reverse_open_strip(&mut self) {
        reverse_but_for_start(&mut self.indices[self.open..]);
        self.indices.pop();
    }

    fn end(&mut self) {
        self.is_next_new = true;
    }
}

/// Sends the renamed strips unchanged.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Unfiltered {
    /// Whether a strip is open.
    is_begun: bool,
}

impl Scanner for Unfiltered {
    fn scan(&mut self, rest: &[u32], _: &mut Gatherer, sink: &mut impl Sink) {
        for &vertex in &rest[..rest.len().min(BLOCK)] {
            if vertex == RESTART {
                self.end(sink);
            } else {
                sink.send(vertex);
            }
            self.is_begun = vertex != RESTART;
        }
    }

    fn end(&self, sink: &mut impl Sink) {
        if self.is_begun {
            sink.end();
        }
    }
}
