//! A mesh refined by batches of splits: the code shared by the encoder and the decoder.
//!
//! Both walk through the same fans and make the same decisions. The encoder takes each decision
//! from its plan and writes it; the decoder reads it. [`BitCoder`] hides this difference. Every
//! decision is valid, so any byte sequence decodes to some mesh.

use super::channels::ChannelModel;
use super::costs::StreamCosts;
use super::fans::{GridPlace, SurfaceFan};
use super::fit::Fit;
use super::places::{EstimateWeights, Estimates, PlaceModel};
use super::splits::SplitModel;
use super::strips::KeptStrips;
use super::surface::{MAX_CORNERS, NONE, Ring, Split, StreamSurface, triangle_of};
use crate::entropy::range_coder::{BitCoder, code_bits};
use crate::entropy::slots::Simple;

/// A split to encode.
#[derive(Debug, Clone)]
pub(super) struct SplitToEncode {
    /// The fan that is split: the kept fan, or another one of its point.
    pub(super) fan: u32,
    /// The first triangle that moves, or [`NONE`].
    pub(super) first: u32,
    pub(super) count: usize,
    pub(super) adds: [bool; 2],
    /// The position on the grid of the full mesh.
    pub(super) place: GridPlace,
    /// The earlier fan of the group with the same vertex, if there is one. Its attributes are not
    /// coded again.
    pub(super) same_as: Option<usize>,
    pub(super) values: Vec<Vec<i32>>,
}

/// A mesh, and the state needed for its next split.
#[derive(Debug, Clone)]
pub(super) struct Refiner {
    pub(super) surface: StreamSurface,
    pub(super) fans: Vec<SurfaceFan>,
    /// The vertex of each fan.
    pub(super) vertices: Vec<u32>,
    /// For each fan up to the last one whose point has several, the next fan of the same point, and
    /// the first one.
    twins: Vec<[u32; 2]>,
    /// The attributes of each vertex, one array per channel.
    pub(super) values: Vec<Vec<i32>>,
    pub(super) vertex_count: u32,
    /// The number of position bits that are still unknown.
    pub(super) unknown_bits: u32,
    known_bits: u32,
    /// The maximum number of triangles of the level being decoded.
    pub(super) most_triangles: usize,
    /// The number of fans visited, plus the corners around those that were split.
    pub(super) corner_count: u64,
    /// The number of collapses undone.
    pub(super) group_count: u32,
    /// The fan that each split has kept, combined with [`FOLLOWS`]. Splits add fans in order.
    pub(super) record: Vec<u32>,
    batch: u32,
    regime: usize,
    /// The next fan to visit, or [`NONE`] at the end of a batch.
    pub(super) next: u32,
    splits: SplitModel,
    pub(super) place_model: PlaceModel,
    channels: Vec<ChannelModel>,
    flags: Simple,
    /// The bits of each component, if they are counted, and the total bits at the last update.
    pub(super) costs: Option<(StreamCosts, f64)>,
    /// Fits the weights while encoding.
    pub(super) fit: Option<Fit>,
    /// The strips of the mesh, if they are maintained.
    pub(super) strips: Option<KeptStrips>,
    ring: Ring,
    estimates: Estimates,
}

/// Flag on the kept fan of a split that belongs to the same collapse as the previous split.
pub(super) const FOLLOWS: u32 = 1 << 31;

/// The maximum number of fans of a point to choose from.
const MAX_TWINS: u32 = 1024;

/// Contexts of single flags.
const MORE_REFINING: usize = 0;
const REGIME: usize = 1;
const MORE_IN_GROUP: usize = 3;
const SAME_VERTEX: usize = 5;
const FLAGS: usize = 6;

impl Refiner {
    pub(super) fn new(weights: &EstimateWeights, channels: Vec<ChannelModel>) -> Self {
        Self {
            surface: StreamSurface::default(),
            fans: Vec::new(),
            vertices: Vec::new(),
            twins: Vec::new(),
            values: vec![Vec::new(); channels.len()],
            vertex_count: 0,
            known_bits: 0,
            unknown_bits: 0,
            most_triangles: usize::MAX,
            corner_count: 0,
            group_count: 0,
            record: Vec::new(),
            batch: 0,
            regime: 0,
            next: NONE,
            splits: SplitModel::new(),
            place_model: PlaceModel::new(weights),
            channels,
            flags: Simple::new(FLAGS),
            costs: None,
            fit: None,
            strips: None,
            ring: Ring::new(),
            estimates: Estimates::default(),
        }
    }

    /// Adds a fan that the surface has or will get. `twin` is another fan of its point. `vertex` is
    /// the next vertex, or that of one of the point's fans.
    pub(super) fn push_fan(&mut self, place: GridPlace, twin: Option<u32>, vertex: u32, is_open: bool) {
        let fan = self.fans.len() as u32;
        self.fans.push(SurfaceFan::new(place, self.batch, is_open));
        self.vertices.push(vertex);
        if let Some(twin) = twin {
            self.twins.extend((self.twins.len() as u32..=fan).map(|fan| [fan, fan]));
            let [next, first] = self.twins[twin as usize];
            self.twins[fan as usize] = [next, first];
            self.twins[twin as usize] = [fan, first];
        }
        self.vertex_count = self.vertex_count.max(vertex + 1);
    }

    /// Begins a batch: codes whether positions gain bits, and the regime. `full` returns the
    /// position of a fan on the grid of the full mesh.
    pub(super) fn begin_batch<C: BitCoder>(
        &mut self,
        coder: &mut C,
        regime: usize,
        unknown_bits: u32,
        full: impl Fn(u32) -> GridPlace,
    ) {
        self.batch += 1;
        self.account(coder, |_| None);
        self.refine_places(coder, unknown_bits, full);
        self.account(coder, |costs| Some(&mut costs.precision));
        self.regime = if self.flags.code(coder, REGIME, regime == 2) {
            2
        } else {
            usize::from(self.flags.code(coder, REGIME + 1, regime == 1))
        };
        self.next = if self.fans.is_empty() { NONE } else { 0 };
    }

    /// Sets the numbers of known and unknown bits of a coordinate.
    pub(super) fn know_bits(&mut self, known: u32, unknown: u32) {
        (self.known_bits, self.unknown_bits) = (known, unknown);
        self.place_model.most = (1 << known) - 1;
    }

    /// Codes further bits of all positions. `full` returns the position of a fan on the grid of the
    /// full mesh.
    pub(super) fn refine_places<C: BitCoder>(
        &mut self,
        coder: &mut C,
        unknown_bits: u32,
        full: impl Fn(u32) -> GridPlace,
    ) {
        while self.unknown_bits > 0 && self.flags.code(coder, MORE_REFINING, self.unknown_bits > unknown_bits)
        {
            self.know_bits(self.known_bits + 1, self.unknown_bits - 1);
            for fan in 0..self.fans.len() {
                let leader = self.twins.get(fan).map_or(fan, |&[_, first]| first as usize);
                if leader != fan {
                    let place = self.fans[leader].place();
                    self.fans[fan].set_place(place);
                    continue;
                }
                let [x, y, z] = full(fan as u32).map(|x| (x >> self.unknown_bits & 1).cast_unsigned());
                let bits = code_bits(coder, 3, x << 2 | y << 1 | z);
                let mut place = self.fans[fan].place();
                for (axis, x) in place.iter_mut().enumerate() {
                    *x = *x << 1 | (bits >> (2 - axis) & 1).cast_signed();
                }
                self.fans[fan].set_place(place);
            }
            self.sum_around();
        }
    }

    /// Visits the next fan of the batch and codes all its splits. `to_encode` has the splits to
    /// encode, in groups.
    pub(super) fn visit<C: BitCoder>(&mut self, coder: &mut C, to_encode: &[Vec<SplitToEncode>]) {
        let fan = self.next;
        // Read before the visit: it inserts new fans after this one, for the next batch.
        self.next = self.fans[fan as usize].next;
        let mut done = 0;
        loop {
            let group: Option<&[SplitToEncode]> = to_encode.get(done).map(Vec::as_slice);
            self.corner_count += 1;
            let of = &self.fans[fan as usize];
            let is_split = self.splits.code_mark(coder, of, self.batch, done, group.is_some());
            self.account(coder, |costs| Some(&mut costs.marks));
            if !is_split {
                break;
            }
            self.surface.ring(fan, self.batch, &mut self.ring);
            let n = self.ring.corners().len();
            if n == 0 || n > MAX_CORNERS {
                break;
            }
            self.code_group(coder, fan, group.unwrap_or(&[]));
            if self.is_too_large(coder) {
                break;
            }
            done += 1;
        }
    }

    /// Reserves memory for this many triangles, and for the fans of a closed surface with a few
    /// borders.
    pub(super) fn reserve(&mut self, triangles: usize) {
        if triangles <= self.surface.capacity() {
            return;
        }
        let fans = (triangles / 2 + triangles / 32 + 64).saturating_sub(self.fans.len());
        self.surface.reserve(triangles - self.surface.triangle_count(), fans);
        self.fans.reserve_exact(fans);
        self.vertices.reserve_exact(fans);
        self.record.reserve_exact(fans);
    }

    /// Returns whether more was built than the bytes may build. Always `false` while encoding.
    fn is_too_large<C: BitCoder>(&self, coder: &C) -> bool {
        coder.is_past_end() || self.surface.triangle_count() > self.most_triangles
    }

    /// Adds the bits since the last call to a component, if bits are counted.
    #[inline]
    pub(super) fn account<C: BitCoder>(
        &mut self,
        coder: &C,
        component: impl Fn(&mut StreamCosts) -> Option<&mut f64>,
    ) {
        if let Some((costs, before)) = &mut self.costs {
            let bits = coder.bits();
            if let Some(component) = component(costs) {
                *component += bits - *before;
            }
            *before = bits;
        }
    }

    /// Codes the splits of one collapse: one, or on a seam one for each fan of the new point.
    fn code_group<C: BitCoder>(&mut self, coder: &mut C, fan: u32, to_encode: &[SplitToEncode]) {
        let first_new = self.fans.len() as u32;
        let mut of = fan;
        let mut number = 0;
        loop {
            self.code_split(coder, of, to_encode.get(number), first_new);
            number += 1;
            // A point has several fans only where a surface has borders.
            if !self.ring.is_open {
                break;
            }
            let has_twins = usize::from(self.twin_of(fan) != fan);
            if !self.flags.code(coder, MORE_IN_GROUP + has_twins, to_encode.len() > number) {
                break;
            }
            of = self.code_twin(coder, fan, to_encode.get(number).map_or(fan, |to_encode| to_encode.fan));
            self.surface.ring(of, self.batch, &mut self.ring);
            let n = self.ring.corners().len();
            if n == 0 || n > MAX_CORNERS || self.is_too_large(coder) {
                break;
            }
        }
        // New fans are visited directly after this one, from the next batch on. Neighbouring fans
        // are thus visited one after the other.
        let mut next = std::mem::replace(&mut self.fans[fan as usize].next, first_new);
        for new in (first_new..self.fans.len() as u32).rev() {
            self.fans[new as usize].next = next;
            next = new;
        }
        self.group_count += 1;
    }

    /// Returns the next fan of the same point, or the fan itself if it is the only one.
    fn twin_of(&self, fan: u32) -> u32 {
        self.twins.get(fan as usize).map_or(fan, |&[next, _]| next)
    }

    /// Codes a fan of the same point as another one, as the number of steps from it.
    fn code_twin<C: BitCoder>(&self, coder: &mut C, fan: u32, to_encode: u32) -> u32 {
        let (mut count, mut place, mut twin) = (1, 0, self.twin_of(fan));
        while twin != fan && count < MAX_TWINS {
            if twin == to_encode {
                place = count;
            }
            count += 1;
            twin = self.twin_of(twin);
        }
        let bits = u32::BITS - u32::leading_zeros(count - 1);
        let steps = code_bits(coder, bits, place) % count;
        (0..steps).fold(fan, |fan, _| self.twin_of(fan))
    }

    fn code_split<C: BitCoder>(
        &mut self,
        coder: &mut C,
        fan: u32,
        to_encode: Option<&SplitToEncode>,
        first_new: u32,
    ) {
        let new = self.fans.len() as u32;
        let (corners, is_open) = (self.ring.corners(), self.ring.is_open);
        self.corner_count += corners.len() as u64;
        // 1. The corners that move.
        let split_to_encode = to_encode.map(|to_encode| {
            let start = corners.iter().position(|&corner| triangle_of(corner) == to_encode.first);
            let of_none = if to_encode.adds[1] { 0 } else { corners.len() };
            Split { start: start.unwrap_or(of_none), count: to_encode.count, is_open, adds: to_encode.adds }
        });
        let known = (&self.surface, &self.fans[..], self.batch);
        let split = self.splits.code_split(coder, known, (fan, &self.ring), split_to_encode);
        self.account(coder, |costs| Some(&mut costs.corners));
        // 2. The point.
        self.ring.repeat(split);
        let [_, around] = self.ring.run(split);
        let is_first = new == first_new;
        let place = if is_first {
            self.estimates.look_around(&self.fans, (fan, around), self.regime);
            let place = to_encode.map_or([0; 3], |to_encode| to_encode.place.map(|x| x >> self.unknown_bits));
            if let Some(fit) = &mut self.fit {
                fit.add(&self.estimates, &self.place_model.weights, place);
            }
            self.place_model.code(coder, &self.estimates, place)
        } else {
            self.fans[first_new as usize].place()
        };
        self.account(coder, |costs| Some(&mut costs.positions));
        // 3. The vertex.
        let same_as = to_encode.and_then(|to_encode| to_encode.same_as);
        let is_same = !is_first && self.flags.code(coder, SAME_VERTEX, same_as.is_some());
        let vertex = if is_same {
            let count = new - first_new;
            let bits = u32::BITS - u32::leading_zeros(count - 1);
            let number = code_bits(coder, bits, same_as.unwrap_or(0) as u32) % count;
            self.vertices[(first_new + number) as usize]
        } else {
            if !self.channels.is_empty() {
                let [_, around] = self.ring.run(split);
                let around: Vec<u32> = std::iter::once(fan).chain(around.iter().copied()).collect();
                self.code_values(coder, &around, to_encode.map(|to_encode| &to_encode.values[..]));
            }
            self.vertex_count
        };
        self.account(coder, |costs| Some(&mut costs.attributes));
        // 4. Apply the split.
        self.push_fan(place, (!is_first).then_some(first_new), vertex, split.adds != [true; 2]);
        self.update_around(fan, split);
        let added = self.surface.split(fan, &self.ring, split, self.batch);
        if let Some(strips) = &mut self.strips {
            strips.follow_split(&self.surface, added);
        }
        self.record.push(if is_first { fan } else { fan | FOLLOWS });
    }

    /// Codes the attributes of a new vertex.
    pub(super) fn code_values<C: BitCoder>(
        &mut self,
        coder: &mut C,
        around: &[u32],
        to_encode: Option<&[Vec<i32>]>,
    ) {
        for (number, channel) in self.channels.iter_mut().enumerate() {
            let values = &mut self.values[number];
            let width = channel.width;
            let of_fan = |&fan: &u32| {
                let vertex = self.vertices[fan as usize] as usize;
                &values[vertex * width..][..width]
            };
            let around: Vec<&[i32]> = around.iter().map(of_fan).collect();
            let mut new = Vec::with_capacity(width);
            channel.code(coder, &around, to_encode.map_or(&[], |to_encode| &to_encode[number]), &mut new);
            values.extend(new);
        }
    }

    /// Initializes the summaries of all fans.
    pub(super) fn look_around(&mut self) {
        for fan in 0..self.fans.len() {
            self.fans[fan].next = if fan + 1 < self.fans.len() { fan as u32 + 1 } else { NONE };
            self.fans[fan].is_open = self.surface.is_open(fan as u32);
        }
        self.sum_around();
    }

    /// Counts the neighbours of all fans, and sums their positions.
    fn sum_around(&mut self) {
        self.fans.iter_mut().for_each(SurfaceFan::clear);
        let mut add = |fan: u32, other: u32| {
            let place = self.fans[other as usize].place();
            self.fans[fan as usize].add(place, 1);
        };
        for cells in self.surface.triangles() {
            for [i, after, before] in [[0, 1, 2], [1, 2, 0], [2, 0, 1]] {
                add(cells[i], cells[after]);
                if cells[4 + after] == NONE {
                    add(cells[i], cells[before]);
                }
            }
        }
    }

    /// Updates the fans around the last fan before it is split off: their used corners, the number
    /// of their neighbours and the sum of the neighbours' positions.
    fn update_around(&mut self, kept: u32, split: Split) {
        let [corners, around] = self.ring.run(split);
        let (kept, new, last) = (kept as usize, self.fans.len() - 1, around.len() - 1);
        let [of_kept, of_new] = [kept, new].map(|fan| self.fans[fan].place());
        let moved = difference(of_new, of_kept);
        let (mut of_lost, mut lost, mut all) = ([0; 3], 0, of_kept);
        let (mut not_free, mut before) = (0, 0);
        for (i, &other) in around.iter().enumerate() {
            // The corner between this fan and the next one moves.
            let mut used = 0;
            if let Some(&corner) = corners.get(i) {
                // It may already be used if a group has several splits.
                used = u32::from(self.surface.mark(corner) != self.batch);
                not_free += 1 - used;
                self.surface.set_mark(corner, self.batch);
            }
            let fan = &mut self.fans[other as usize];
            let place = fan.place();
            all = sum(all, place);
            // The first and the last fan remain neighbours of the kept fan if a triangle is added
            // there.
            let stays = corners.is_empty() || i == 0 && split.adds[0] || i == last && split.adds[1];
            fan.use_corners(self.batch, before + used + u32::from(stays), 0);
            before = used;
            if stays {
                fan.add(of_new, 1);
            } else {
                (of_lost, lost) = (sum(of_lost, place), lost + 1);
                fan.add(moved, 0);
            }
        }
        self.fans[new].add(all, around.len() as u32 + 1);
        let kept = &mut self.fans[kept];
        kept.use_corners(self.batch, split.adds.map(u32::from).iter().sum(), not_free);
        kept.add(difference(of_new, of_lost), 1_u32.wrapping_sub(lost));
    }
}

fn sum(a: GridPlace, b: GridPlace) -> GridPlace {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn difference(a: GridPlace, b: GridPlace) -> GridPlace {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
