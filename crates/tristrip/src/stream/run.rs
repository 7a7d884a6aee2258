//! A pass of the encoder over the base mesh and the batches. It makes every decision, either as a
//! rehearsal or to write the stream.

use super::base::{BaseToEncode, code_triangles};
use super::channels::ChannelModel;
use super::chunk::ChunkHead;
use super::head::{Head, code_weights};
use super::options::StreamOptions;
use super::places::{EstimateWeights, REGIMES};
use super::plan::FanSplit;
use super::refiner::{Refiner, SplitToEncode};
use super::source::StreamSource;
use super::surface::{NONE, StreamSurface, corners_of, triangle_of};
use crate::entropy::range_coder::{BitCoder, Rehearsal};
use crate::error::Error;
use rustc_hash::FxHashMap;

/// A collapse, whose splits form a group.
#[derive(Debug, Clone, Copy)]
struct SplitGroup {
    /// The visited fan.
    fan: u32,
    /// The collapse, counted from the full mesh.
    collapse: usize,
}

/// One pass over all batches.
pub(super) struct EncodingRun<'a> {
    source: &'a StreamSource<'a>,
    pub(super) refiner: Refiner,
    weights: EstimateWeights,
    /// For each fan of the plan, the fan of the stream.
    fans: Vec<u32>,
    /// The inverse of `fans`.
    sources: Vec<u32>,
    /// For each input triangle, the triangle of the stream; `triangles` is the inverse.
    numbers: Vec<u32>,
    triangles: Vec<u32>,
}

/// What a pass does with its decisions.
pub(super) trait Pass {
    type Coder: BitCoder;
    fn coder(&mut self) -> &mut Self::Coder;
    /// Returns the number of bytes of the current chunk.
    fn len(&self) -> usize;
    fn begin(&mut self, _: &Head) {}
    fn end(&mut self, _: ChunkHead) {}
}

#[derive(Default)]
pub(super) struct Rehearsing {
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

impl<'a> EncodingRun<'a> {
    pub(super) fn new(source: &'a StreamSource<'a>, weights: &EstimateWeights) -> Self {
        let models = source.channels.iter();
        let models = models.map(|channel| ChannelModel::new(channel.kind, channel.width(), channel.bits));
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

    /// Encodes the base mesh and all batches.
    pub(super) fn all<P: Pass>(&mut self, pass: &mut P, options: &StreamOptions) -> Result<(), Error> {
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
            while self.refiner.next != NONE {
                let fan = self.refiner.next;
                let at = groups.partition_point(|group| group.fan < fan);
                let count = groups[at..].iter().take_while(|group| group.fan == fan).count();
                self.visit(pass, &groups[at..at + count]);
                visits += 1;
                let is_last = self.refiner.next == NONE;
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

    /// Sorts the groups of a batch by the visited fans.
    fn groups(&self, start: usize, end: usize) -> Vec<SplitGroup> {
        let plan = &self.source.plan;
        let group = |collapse: usize| {
            let splits = &plan.splits[plan.end(collapse)..plan.end(collapse + 1)];
            let fan = splits.iter().map(|split| self.fans[split.kept as usize]).min();
            SplitGroup { fan: fan.unwrap_or(NONE), collapse }
        };
        let is_done = |&collapse: &usize| plan.end(collapse) < plan.end(collapse + 1);
        let mut groups: Vec<SplitGroup> = (start..end).filter(is_done).map(group).collect();
        groups.sort_unstable_by_key(|group| (group.fan, group.collapse));
        groups
    }

    /// Visits the next fan.
    fn visit<P: Pass>(&mut self, pass: &mut P, groups: &[SplitGroup]) {
        let plan = &self.source.plan;
        let mut to_encode = Vec::with_capacity(groups.len());
        // The splits, in stream order.
        let mut order = Vec::new();
        for group in groups {
            let mut splits = plan.splits[plan.end(group.collapse)..plan.end(group.collapse + 1)].to_vec();
            // The split of the visited fan comes first.
            splits.sort_by_key(|split| self.fans[split.kept as usize] != group.fan);
            let of_split = |number: usize| {
                let split = &splits[number];
                let vertex = |split: &FanSplit| plan.vertices[split.removed as usize];
                let same_as = splits[..number].iter().position(|other| vertex(other) == vertex(split));
                SplitToEncode {
                    fan: self.fans[split.kept as usize],
                    first: if split.first == NONE { NONE } else { self.numbers[split.first as usize] },
                    count: split.count as usize,
                    adds: split.added.map(|t| t != NONE),
                    place: self.source.place(split.removed),
                    same_as,
                    values: self.source.values(vertex(split)),
                }
            };
            to_encode.push((0..splits.len()).map(of_split).collect::<Vec<_>>());
            order.extend(splits);
        }
        self.refiner.visit(pass.coder(), &to_encode);
        for split in order {
            self.fans[split.removed as usize] = self.sources.len() as u32;
            self.sources.push(split.removed);
            for t in split.added.into_iter().filter(|&t| t != NONE) {
                self.numbers[t as usize] = self.triangles.len() as u32;
                self.triangles.push(t);
            }
        }
    }

    /// Encodes the base mesh.
    fn base<P: Pass>(&mut self, pass: &mut P) -> Result<(), Error> {
        let (source, plan) = (self.source, &self.source.plan);
        // 1. Number the drawn triangles.
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
        self.refiner.know_bits(source.position_bits - unknown_bits, unknown_bits);
        code_weights(pass.coder(), &self.weights);

        // 3. The triangles, and the fans in their new order.
        let wrong = |_| Error::Parameter {
            name: "sequence",
            found: "edges that do not fit".into(),
            expected: "triangles",
        };
        let (opposite, corners) = code_triangles(pass.coder(), drawn.len(), &opposite).map_err(wrong)?;
        self.refiner.surface = StreamSurface::new(&opposite);
        self.sources = vec![NONE; self.refiner.surface.first.len()];
        for (corner, &of_drawn) in self.refiner.surface.corners().zip(&corners) {
            let t = drawn[of_drawn as usize / 3];
            let fan = self.refiner.surface.fan(corner);
            self.sources[fan as usize] = plan.surface.fan(8 * t + of_drawn % 3);
            if corner.is_multiple_of(8) {
                self.numbers[t as usize] = triangle_of(corner);
                self.triangles.push(t);
            }
        }
        (0..).zip(&self.sources).for_each(|(fan, &source)| self.fans[source as usize] = fan);

        // 4. The vertices and points.
        let mut of_vertex: FxHashMap<u32, u32> = FxHashMap::default();
        let mut of_position: FxHashMap<[u32; 3], u32> = FxHashMap::default();
        let mut to_encode = BaseToEncode::default();
        for (fan, &source_fan) in (0..).zip(&self.sources) {
            let vertex = plan.vertices[source_fan as usize];
            // −0 and 0 are the same position.
            let bits = source.mesh.positions()[vertex as usize].map(|x| (x + 0.0).to_bits());
            let first = *of_vertex.entry(vertex).or_insert(fan);
            let twin = *of_position.entry(bits).or_insert(fan);
            to_encode.same_vertex.push((first != fan).then_some(first));
            to_encode.twins.push((twin != fan).then_some(twin));
            to_encode.places.push(source.place(source_fan));
            to_encode.values.push(source.values(vertex));
        }
        self.refiner.code_base(pass.coder(), Some(&to_encode));
        let error = source.error(source.sequence.len());
        self.end_chunk(pass, 0, error);
        Ok(())
    }

    /// Checks that the triangles built are those of the input.
    pub(super) fn check(&self) -> Result<(), Error> {
        let wrong = |found: String| Error::Parameter {
            name: "level_ends",
            found,
            expected: "batches whose points have no common triangle",
        };
        let planned = self.source.plan.collapse_count();
        if self.refiner.group_count as usize != planned {
            return Err(wrong(format!("{} of {planned} collapses", self.refiner.group_count)));
        }
        let mut vertices = vec![NONE; self.refiner.vertex_count as usize];
        for (number, &t) in self.triangles.iter().enumerate() {
            let source = &self.source.sequence.triangles()[3 * t as usize..][..3];
            let fans: Vec<u32> =
                corners_of(number as u32).map(|corner| self.refiner.surface.fan(corner)).collect();
            let built = [0, 1, 2].map(|i| self.refiner.vertices[fans[i] as usize]);
            let turned = |by: usize| {
                (0..3).all(|i| {
                    let vertex = vertices[built[i] as usize];
                    vertex == NONE || vertex == source[(i + by) % 3]
                })
            };
            // The corners of a triangle can be rotated. The fans of the plan determine the
            // rotation.
            let of_plan = |by: usize| {
                (0..3).all(|i| {
                    self.fan_source(fans[i])
                        .is_none_or(|fan| self.source.plan.vertices[fan as usize] == source[(i + by) % 3])
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
