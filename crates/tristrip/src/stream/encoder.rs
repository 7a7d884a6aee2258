//! Encodes a mesh with its collapses as a stream.
//!
//! # Algorithm
//! 1. The plan: collapses become splits of fans (module `plan`), and what no collapse removes is the base mesh.
//! 2. Rehearsals: all decisions are made without being written, so that the weights of the estimates can be fitted (module `fit`).
//! 3. The batches, from the base mesh on. In each, the groups of splits are sorted by the fans that they split. Before a batch the
//!    positions get as many bits as the error of the level is worth; the last batches have all.
//! 4. Chunks: the coder is closed at the end of a batch if there is enough for a chunk, and within a batch where a chunk would become too large.
//!
//! # Complexity
//! O(n) time, three times that of decoding and more; about 150 bytes per triangle.

use super::base::{WantedBase, code_triangles};
use super::chunk::ChunkHead;
use super::fit::Fit;
use super::grid::{AttributeBits, Channel, Grid};
use super::head::{Head, code_weights};
use super::places::{MOST_BITS, REGIMES, USUAL_WEIGHTS, Weights};
use super::plan::Plan;
use super::range_coder::{BitCoder, RangeEncoder, Rehearsal};
use super::refiner::{Refiner, Wanted};
use super::surface::{NONE, Surface, corners_of, triangle_of};
use crate::collapse::CollapseSequence;
use crate::error::Error;
use crate::mesh::Mesh;
use rustc_hash::FxHashMap;

/// The fits of the weights.
const REHEARSALS: usize = 2;
/// Batches with all bits of the positions, the last ones.
const EXACT_BATCHES: usize = 2;
/// A position may be off by this share of the error of its level.
const PRECISION: f64 = 0.5;

/// How a mesh is encoded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StreamOptions {
    position_bits: u32,
    attribute_bits: AttributeBits,
    least_chunk_bytes: usize,
    most_chunk_bytes: usize,
}

impl Default for StreamOptions {
    /// 14 bits per coordinate, 10 per coordinate of a normal, 12 of texture coordinates and 10 of others; chunks of 1 to 16 kilobytes.
    fn default() -> Self {
        Self {
            position_bits: 14,
            attribute_bits: AttributeBits { normal: 10, uv: 12, other: 10 },
            least_chunk_bytes: 1 << 10,
            most_chunk_bytes: 1 << 14,
        }
    }
}

impl StreamOptions {
    /// Sets the bits of a coordinate: 4 to 16.
    ///
    /// # Errors
    /// There are fewer or more.
    ///
    /// ```
    /// use tristrip::stream::StreamOptions;
    /// assert!(StreamOptions::default().with_position_bits(12).is_ok());
    /// assert!(StreamOptions::default().with_position_bits(17).is_err());
    /// ```
    pub fn with_position_bits(mut self, bits: u32) -> Result<Self, Error> {
        if !(4..=MOST_BITS).contains(&bits) {
            let found = bits.to_string();
            return Err(Error::Parameter { name: "position-bits", found, expected: "4 to 16" });
        }
        self.position_bits = bits;
        Ok(self)
    }
}

/// A chunk of a stream.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct StreamChunk {
    /// Its bytes, head and checksum included.
    pub bytes: Vec<u8>,
    /// The level that it leads to: the collapses that are undone.
    pub level: u32,
    /// The triangles of that level.
    pub triangles: u32,
    /// The error of that level in mesh units, that of the positions included.
    pub error: f32,
}

/// A mesh as a stream, chunk by chunk: the base mesh first.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct EncodedStream {
    /// The chunks.
    pub chunks: Vec<StreamChunk>,
    /// The triangles of the base mesh, over the vertices of the input.
    pub base: Vec<u32>,
    /// How far a position of the full mesh may be from that of the input, in mesh units.
    pub position_error: f32,
}

impl EncodedStream {
    /// Returns all bytes.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// assert_eq!(stream.bytes().len(), stream.chunks.iter().map(|chunk| chunk.bytes.len()).sum::<usize>());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn bytes(&self) -> Vec<u8> {
        self.chunks.iter().flat_map(|chunk| chunk.bytes.iter().copied()).collect()
    }
}

/// Encodes a mesh with its collapses. `level_ends` are the numbers of collapses, from the full mesh on, after which a batch ends; the points that a batch removes may not have a
/// common triangle, as those of `simplify::refinement_batches`. `stream` is the number of the mesh among those of a file. Degenerate triangles and unused vertices are left out.
///
/// # Errors
/// The sequence is not one of the mesh, a batch removes points that have a common triangle, a position or an attribute is not finite, or there are too many attributes.
///
/// ```
#[doc = include_str!("example.txt")]
/// // Seven bytes per vertex, in twelve of a position alone.
/// assert!(stream.bytes().len() < 81 * 7);
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn encode(
    mesh: &Mesh,
    sequence: &CollapseSequence,
    level_ends: &[u32],
    stream: u32,
    options: &StreamOptions,
) -> Result<EncodedStream, Error> {
    let source = Source::new(mesh, sequence, level_ends, options)?;
    let mut weights = USUAL_WEIGHTS;
    for _ in 0..REHEARSALS {
        let mut run = Run::new(&source, &weights);
        run.refiner.fit = Some(Fit::new(&weights));
        run.all(&mut Rehearsing::default(), options)?;
        if let Some(fit) = run.refiner.fit.take() {
            weights = fit.solve(&weights);
        }
    }
    let mut run = Run::new(&source, &weights);
    let mut writing = Writing { stream, coder: RangeEncoder::new(), chunks: Vec::new(), head: Vec::new() };
    run.all(&mut writing, options)?;
    source.check(&run)?;
    Ok(EncodedStream {
        chunks: writing.chunks,
        base: source.plan.base(),
        position_error: source.grid.error(0),
    })
}

/// Finds the vertices that a stream cannot restore: those whose collapse does more than to move the corners of one fan, since a surface touches itself there or attributes differ
/// all around. With these locked, a simplification finds other collapses.
///
/// ```
#[doc = include_str!("example.txt")]
/// assert!(tristrip::stream::unsplittable(&batches.sequence).is_empty());
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn unsplittable(sequence: &CollapseSequence) -> Vec<u32> {
    Plan::new(sequence).unsplittable
}

/// What is encoded.
struct Source<'a> {
    mesh: &'a Mesh,
    sequence: &'a CollapseSequence,
    plan: Plan,
    grid: Grid,
    position_bits: u32,
    channels: Vec<Channel>,
    /// The number of collapses from the full mesh to the start and end of each batch, in the order of the stream.
    batches: Vec<[usize; 2]>,
}

impl<'a> Source<'a> {
    fn new(
        mesh: &'a Mesh,
        sequence: &'a CollapseSequence,
        level_ends: &[u32],
        options: &StreamOptions,
    ) -> Result<Self, Error> {
        if sequence.vertex_count() != mesh.vertex_count() {
            let found = format!("collapses over {} vertices", sequence.vertex_count());
            return Err(Error::Parameter { name: "sequence", found, expected: "the vertices of the mesh" });
        }
        let plan = Plan::new(sequence);
        let count = sequence.len();
        let mut ends: Vec<usize> = level_ends.iter().map(|&end| (end as usize).min(count)).collect();
        ends.push(count);
        ends.sort_unstable();
        ends.dedup();
        let starts = [0].into_iter().chain(ends.iter().copied());
        let batches = starts
            .zip(&ends)
            .map(|(start, &end)| [start, end])
            .filter(|&[start, end]| plan.end(start) < plan.end(end));
        let mut batches: Vec<[usize; 2]> = batches.collect();
        batches.reverse();
        let used = plan.vertices.iter().map(|&v| mesh.positions()[v as usize]);
        let grid = Grid::new(used, options.position_bits);
        let channels =
            mesh.attributes().iter().map(|attribute| Channel::new(attribute, options.attribute_bits));
        let channels = channels.collect::<Result<Vec<_>, _>>()?;
        if channels.len() > 64 || channels.iter().any(|channel| channel.name.len() > 256) {
            let found = format!("{} attributes", channels.len());
            return Err(Error::Parameter {
                name: "attributes",
                found,
                expected: "at most 64, with names of at most 256 bytes",
            });
        }
        Ok(Self { mesh, sequence, plan, grid, position_bits: options.position_bits, channels, batches })
    }

    fn values(&self, vertex: u32) -> Vec<Vec<i32>> {
        let channels = self.channels.iter().zip(self.mesh.attributes());
        channels.map(|(channel, attribute)| channel.integers(attribute, vertex as usize)).collect()
    }

    fn place(&self, fan: u32) -> [i32; 3] {
        self.grid.place(self.mesh.positions()[self.plan.vertices[fan as usize] as usize], self.position_bits)
    }

    /// The error of the surface after a number of collapses from the full mesh.
    fn error(&self, collapses: usize) -> f32 {
        self.sequence.error(self.sequence.len() - collapses).unwrap_or(0.0)
    }

    /// The bits that need not be known after a number of collapses from the full mesh.
    fn unknown_bits(&self, batch: usize) -> u32 {
        if batch + EXACT_BATCHES >= self.batches.len() {
            return 0;
        }
        // The mean of the errors that the batch mends: the largest ones are of few places.
        let [start, end] = self.batches[batch];
        let level = |collapse: usize| self.sequence.len() - 1 - collapse;
        let errors = (start..end).filter_map(|collapse| self.sequence.collapse(level(collapse)).ok());
        let sum: f64 = errors.map(|collapse| f64::from(collapse.error)).sum();
        let error = sum / (end - start) as f64 * PRECISION;
        let is_enough = |bits: &u32| f64::from(self.grid.error(*bits)) <= error;
        (0..self.position_bits - 3).rev().find(is_enough).unwrap_or(0)
    }

    /// Checks that the triangles that were built are those of the input.
    fn check(&self, run: &Run<'_>) -> Result<(), Error> {
        let wrong = |found: String| Error::Parameter {
            name: "level_ends",
            found,
            expected: "batches whose points have no common triangle",
        };
        let planned = self.plan.collapse_count();
        if run.refiner.group_count as usize != planned {
            return Err(wrong(format!("{} of {planned} collapses", run.refiner.group_count)));
        }
        let mut vertices = vec![NONE; run.refiner.vertex_count as usize];
        for (number, &t) in run.triangles.iter().enumerate() {
            let source = &self.sequence.triangles()[3 * t as usize..][..3];
            let fans: Vec<u32> =
                corners_of(number as u32).map(|corner| run.refiner.surface.fan(corner)).collect();
            let built = [0, 1, 2].map(|i| run.refiner.vertices[fans[i] as usize]);
            let turned = |by: usize| {
                (0..3).all(|i| {
                    let vertex = vertices[built[i] as usize];
                    vertex == NONE || vertex == source[(i + by) % 3]
                })
            };
            // A triangle may be turned; which way, the fans of the plan tell.
            let of_plan = |by: usize| {
                (0..3).all(|i| {
                    run.fan_source(fans[i])
                        .is_none_or(|fan| self.plan.vertices[fan as usize] == source[(i + by) % 3])
                })
            };
            let Some(by) = (0..3).find(|&by| turned(by) && of_plan(by)) else {
                return Err(wrong(format!("another triangle than number {t}")));
            };
            (0..3).for_each(|i| vertices[built[i] as usize] = source[(i + by) % 3]);
        }
        Ok(())
    }
}

/// The collapses and splits of one group.
#[derive(Debug, Clone, Copy)]
struct Group {
    /// The fan that is visited.
    fan: u32,
    /// The collapse, counted from the full mesh.
    collapse: usize,
}

/// One pass over all batches.
struct Run<'a> {
    source: &'a Source<'a>,
    refiner: Refiner,
    weights: Weights,
    /// The fan of the stream for each fan of the plan.
    fans: Vec<u32>,
    /// And the other way round.
    sources: Vec<u32>,
    /// The triangle of the stream for each of the input, and the other way round.
    numbers: Vec<u32>,
    triangles: Vec<u32>,
}

/// What a pass does with its decisions.
trait Pass {
    type Coder: BitCoder;
    fn coder(&mut self) -> &mut Self::Coder;
    /// The bytes of the chunk so far.
    fn len(&self) -> usize;
    fn begin(&mut self, _: &Head) {}
    fn end(&mut self, _: ChunkHead) {}
}

#[derive(Default)]
struct Rehearsing {
    coder: Rehearsal,
}

impl Pass for Rehearsing {
    type Coder = Rehearsal;
    fn coder(&mut self) -> &mut Rehearsal {
        &mut self.coder
    }
    fn len(&self) -> usize {
        0
    }
}

struct Writing {
    stream: u32,
    coder: RangeEncoder,
    chunks: Vec<StreamChunk>,
    head: Vec<u8>,
}

impl Pass for Writing {
    type Coder = RangeEncoder;
    fn coder(&mut self) -> &mut RangeEncoder {
        &mut self.coder
    }
    fn len(&self) -> usize {
        self.coder.len()
    }
    fn begin(&mut self, head: &Head) {
        head.write(&mut self.head);
    }
    fn end(&mut self, head: ChunkHead) {
        let coder = std::mem::replace(&mut self.coder, RangeEncoder::new());
        let mut payload = std::mem::take(&mut self.head);
        payload.extend(coder.finish());
        let head = ChunkHead { stream: self.stream, ..head };
        let ChunkHead { level, triangles, error, .. } = head;
        self.chunks.push(StreamChunk { bytes: head.with_payload(&payload), level, triangles, error });
    }
}

impl<'a> Run<'a> {
    fn new(source: &'a Source<'a>, weights: &Weights) -> Self {
        let models = source.channels.iter();
        let models = models
            .map(|channel| super::channels::ChannelModel::new(channel.kind, channel.width(), channel.bits));
        Self {
            source,
            refiner: Refiner::new(weights, models.collect()),
            weights: *weights,
            fans: vec![NONE; source.plan.vertices.len()],
            sources: Vec::new(),
            numbers: vec![NONE; source.plan.is_drawn.len()],
            triangles: Vec::new(),
        }
    }

    fn fan_source(&self, fan: u32) -> Option<u32> {
        self.sources.get(fan as usize).copied()
    }

    /// Does all batches.
    fn all<P: Pass>(&mut self, pass: &mut P, options: &StreamOptions) -> Result<(), Error> {
        self.base(pass)?;
        let batch_count = self.source.batches.len();
        let mut visits = 0;
        for number in 0..batch_count {
            let [start, end] = self.source.batches[number];
            let groups = self.groups(start, end);
            let regime = (batch_count - 1 - number).min(REGIMES - 1);
            let unknown_bits = self.source.unknown_bits(number);
            let (source, sources) = (self.source, std::mem::take(&mut self.sources));
            let full = |fan: u32| sources.get(fan as usize).map_or([0; 3], |&fan| source.place(fan));
            self.refiner.begin_batch(pass.coder(), regime, unknown_bits, full);
            self.sources = sources;
            let mut at = 0;
            while self.refiner.next < self.refiner.end {
                let fan = self.refiner.next;
                let count = groups[at..].iter().take_while(|group| group.fan == fan).count();
                self.visit(pass, &groups[at..at + count]);
                at += count;
                visits += 1;
                let is_last = self.refiner.next == self.refiner.end;
                let is_full = pass.len() >= options.most_chunk_bytes;
                let is_enough =
                    is_last && (pass.len() >= options.least_chunk_bytes || number + 1 == batch_count);
                if is_full || is_enough {
                    let collapses = if is_last { start } else { end };
                    self.end_chunk(pass, visits, self.source.error(collapses));
                    visits = 0;
                }
            }
        }
        Ok(())
    }

    fn end_chunk<P: Pass>(&self, pass: &mut P, visits: u32, error: f32) {
        pass.end(ChunkHead {
            stream: 0,
            payload_bytes: 0,
            visits,
            level: self.refiner.group_count,
            triangles: self.refiner.surface.triangle_count() as u32,
            error: error + self.source.grid.error(self.refiner.unknown_bits),
        });
    }

    /// Sorts the groups of a batch by the fans that are visited.
    fn groups(&self, start: usize, end: usize) -> Vec<Group> {
        let plan = &self.source.plan;
        let group = |collapse: usize| {
            let splits = &plan.splits[plan.end(collapse)..plan.end(collapse + 1)];
            let fan = splits.iter().map(|split| self.fans[split.kept as usize]).min();
            Group { fan: fan.unwrap_or(NONE), collapse }
        };
        let is_done = |&collapse: &usize| plan.end(collapse) < plan.end(collapse + 1);
        let mut groups: Vec<Group> = (start..end).filter(is_done).map(group).collect();
        groups.sort_unstable_by_key(|group| (group.fan, group.collapse));
        groups
    }

    /// Visits the next fan.
    fn visit<P: Pass>(&mut self, pass: &mut P, groups: &[Group]) {
        let plan = &self.source.plan;
        let mut wanted = Vec::with_capacity(groups.len());
        // The splits in the order of the stream.
        let mut order = Vec::new();
        for group in groups {
            let mut splits = plan.splits[plan.end(group.collapse)..plan.end(group.collapse + 1)].to_vec();
            // That of the visited fan first.
            splits.sort_by_key(|split| self.fans[split.kept as usize] != group.fan);
            let of_split = |number: usize| {
                let split = &splits[number];
                let vertex = |split: &super::plan::FanSplit| plan.vertices[split.removed as usize];
                let same_as = splits[..number].iter().position(|other| vertex(other) == vertex(split));
                Wanted {
                    fan: self.fans[split.kept as usize],
                    first: if split.first == NONE { NONE } else { self.numbers[split.first as usize] },
                    count: split.count as usize,
                    adds: split.added.map(|t| t != NONE),
                    place: self.source.place(split.removed),
                    same_as,
                    values: self.source.values(vertex(split)),
                }
            };
            wanted.push((0..splits.len()).map(of_split).collect::<Vec<_>>());
            order.extend(splits);
        }
        self.refiner.visit(pass.coder(), &wanted);
        for split in order {
            self.fans[split.removed as usize] = self.sources.len() as u32;
            self.sources.push(split.removed);
            for t in split.added.into_iter().filter(|&t| t != NONE) {
                self.numbers[t as usize] = self.triangles.len() as u32;
                self.triangles.push(t);
            }
        }
    }

    /// Does the base mesh.
    fn base<P: Pass>(&mut self, pass: &mut P) -> Result<(), Error> {
        let (source, plan) = (self.source, &self.source.plan);
        // 1. The triangles that are drawn, numbered.
        let drawn: Vec<u32> =
            (0..).zip(&plan.is_drawn).filter_map(|(t, &is_drawn)| is_drawn.then_some(t)).collect();
        let mut places = vec![NONE; plan.is_drawn.len()];
        (0..).zip(&drawn).for_each(|(place, &t)| places[t as usize] = place);
        let in_base = |corner: u32| match corner {
            NONE => NONE,
            _ => 3 * places[triangle_of(corner) as usize] + (corner & 7),
        };
        let corners = drawn.iter().flat_map(|&t| corners_of(t));
        let opposite: Vec<u32> = corners.map(|corner| in_base(plan.surface.opposite(corner))).collect();

        // 2. The head.
        let unknown_bits = if source.batches.is_empty() { 0 } else { source.unknown_bits(0) };
        let mut is_used = vec![false; source.mesh.vertex_count()];
        source.sequence.triangles().iter().for_each(|&v| is_used[v as usize] = true);
        pass.begin(&Head {
            grid: source.grid,
            position_bits: source.position_bits,
            unknown_bits,
            channels: source.channels.clone(),
            base_triangles: drawn.len() as u32,
            levels: plan.collapse_count() as u32,
            triangles: source.sequence.triangle_count(source.sequence.len())? as u32,
            vertices: is_used.iter().filter(|&&is_used| is_used).count() as u32,
        });
        (self.refiner.position_bits, self.refiner.unknown_bits) = (source.position_bits, unknown_bits);
        code_weights(pass.coder(), &self.weights);

        // 3. The triangles, and the fans in their new order.
        let wrong = |_| Error::Parameter {
            name: "sequence",
            found: "edges that do not fit".into(),
            expected: "triangles",
        };
        let (opposite, corners) = code_triangles(pass.coder(), drawn.len(), &opposite).map_err(wrong)?;
        self.refiner.surface = Surface::new(&opposite);
        self.sources = vec![NONE; self.refiner.surface.first.len()];
        for (corner, &of_drawn) in self.refiner.surface.corners().zip(&corners) {
            let t = drawn[of_drawn as usize / 3];
            let fan = self.refiner.surface.fan(corner);
            self.sources[fan as usize] = plan.surface.fan(8 * t + of_drawn % 3);
            if corner.trailing_zeros() >= 3 {
                self.numbers[t as usize] = triangle_of(corner);
                self.triangles.push(t);
            }
        }
        (0..).zip(&self.sources).for_each(|(fan, &source)| self.fans[source as usize] = fan);

        // 4. The vertices and points.
        let mut of_vertex: FxHashMap<u32, u32> = FxHashMap::default();
        let mut of_position: FxHashMap<[u32; 3], u32> = FxHashMap::default();
        let mut wanted = WantedBase::default();
        for (fan, &source_fan) in (0..).zip(&self.sources) {
            let vertex = plan.vertices[source_fan as usize];
            // −0 and 0 are one position.
            let bits = source.mesh.positions()[vertex as usize].map(|x| (x + 0.0).to_bits());
            let first = *of_vertex.entry(vertex).or_insert(fan);
            let twin = *of_position.entry(bits).or_insert(fan);
            wanted.same_vertex.push((first != fan).then_some(first));
            wanted.twins.push((twin != fan).then_some(twin));
            wanted.places.push(source.place(source_fan));
            wanted.values.push(source.values(vertex));
        }
        self.refiner.code_base(pass.coder(), Some(&wanted));
        let error = source.error(source.sequence.len());
        self.end_chunk(pass, 0, error);
        Ok(())
    }
}
