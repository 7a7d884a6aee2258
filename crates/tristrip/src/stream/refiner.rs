//! A mesh that batches of splits refine: what the encoder and the decoder have in common.
//!
//! Both walk through the same fans and ask the same questions. The encoder answers them from its plan and writes the answers down, the decoder reads them: that
//! is the only difference, hidden in [`BitCoder`]. Every decision is valid, so that any bytes build some mesh.

use super::channels::ChannelModel;
use super::costs::StreamCosts;
use super::fit::Fit;
use super::places::{Estimates, Place, PlaceModel, Polygon, Weights, reciprocal};
use super::range_coder::{BitCoder, code_bits};
use super::slots::Simple;
use super::splits::{Fan, Ring, SplitModel};
use super::strips::KeptStrips;
use super::surface::{MOST_CORNERS, NONE, Split, Surface, next, previous, triangle_of};

/// A split to be encoded.
#[derive(Debug, Clone)]
pub(super) struct Wanted {
    /// The fan that is split: the kept fan, or another one of its point.
    pub(super) fan: u32,
    /// The first triangle that moves, or none.
    pub(super) first: u32,
    pub(super) count: usize,
    pub(super) adds: [bool; 2],
    /// The position on the grid of the full mesh.
    pub(super) place: Place,
    /// The attributes of the vertex; none if it is the vertex of an earlier fan of the group.
    pub(super) same_as: Option<usize>,
    pub(super) values: Vec<Vec<i32>>,
}

/// A mesh with what is known for the next split.
#[derive(Debug, Clone)]
pub(super) struct Refiner {
    pub(super) surface: Surface,
    pub(super) fans: Vec<Fan>,
    /// The vertex of each fan.
    pub(super) vertices: Vec<u32>,
    /// The next fan of the same point; of one fan alone itself.
    twins: Vec<u32>,
    /// The first fan of the point.
    leaders: Vec<u32>,
    /// The attributes of each vertex, one array per channel.
    pub(super) values: Vec<Vec<i32>>,
    pub(super) vertex_count: u32,
    /// Bits of a coordinate that are still unknown.
    pub(super) unknown_bits: u32,
    known_bits: u32,
    /// The most triangles of the level to decode.
    pub(super) most_triangles: usize,
    /// The corners around the fans that were visited.
    pub(super) corner_count: u64,
    /// The collapses that have been undone.
    pub(super) group_count: u32,
    /// The kept and the new fan of each split.
    pub(super) record: Vec<[u32; 2]>,
    /// The number of splits after each group.
    pub(super) record_ends: Vec<u32>,
    batch: u32,
    regime: usize,
    /// The next fan to visit, or none at the end of a batch.
    pub(super) next: u32,
    splits: SplitModel,
    pub(super) place_model: PlaceModel,
    channels: Vec<ChannelModel>,
    flags: Simple,
    /// Counts the bits of each component, if that is wanted, and those up to the last one.
    pub(super) costs: Option<(StreamCosts, f64)>,
    /// Learns the weights, while encoding.
    pub(super) fit: Option<Fit>,
    /// The strips of the mesh, if they are kept.
    pub(super) strips: Option<KeptStrips>,
    ring: Vec<u32>,
    /// The fans at the other ends of its edges.
    neighbours: Vec<u32>,
    rim: Vec<u32>,
    polygon: Polygon,
}

/// The fans of a point among which one is chosen.
const MOST_TWINS: u32 = 1024;

/// Contexts of single flags.
const MORE_REFINING: usize = 0;
const REGIME: usize = 1;
const MORE_IN_GROUP: usize = 3;
const SAME_VERTEX: usize = 5;
const FLAGS: usize = 6;

impl Refiner {
    pub(super) fn new(weights: &Weights, channels: Vec<ChannelModel>) -> Self {
        Self {
            surface: Surface::default(),
            fans: Vec::new(),
            vertices: Vec::new(),
            twins: Vec::new(),
            leaders: Vec::new(),
            values: vec![Vec::new(); channels.len()],
            vertex_count: 0,
            known_bits: 0,
            unknown_bits: 0,
            most_triangles: usize::MAX,
            corner_count: 0,
            group_count: 0,
            record: Vec::new(),
            record_ends: Vec::new(),
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
            ring: Vec::new(),
            neighbours: Vec::new(),
            rim: Vec::new(),
            polygon: Polygon::default(),
        }
    }

    /// Adds a fan that the surface has or will get. `twin` is another fan of its point, and `vertex` the next vertex or one of these fans.
    pub(super) fn push_fan(&mut self, place: Place, twin: Option<u32>, vertex: u32, is_open: bool) {
        let fan = self.fans.len() as u32;
        self.fans.push(Fan::new(place, self.batch, is_open));
        self.vertices.push(vertex);
        match twin {
            None => {
                self.twins.push(fan);
                self.leaders.push(fan);
            }
            Some(twin) => {
                self.twins.push(self.twins[twin as usize]);
                self.twins[twin as usize] = fan;
                self.leaders.push(self.leaders[twin as usize]);
            }
        }
        self.vertex_count = self.vertex_count.max(vertex + 1);
    }

    /// Begins a batch: codes whether the positions get another bit, and the regime. `full` returns the position of a fan on the grid of the full mesh.
    pub(super) fn begin_batch<C: BitCoder>(
        &mut self,
        coder: &mut C,
        regime: usize,
        unknown_bits: u32,
        full: impl Fn(u32) -> Place,
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
        self.fans.iter_mut().for_each(|fan| fan.used = 0);
        self.next = if self.fans.is_empty() { NONE } else { 0 };
    }

    /// Sets how many bits of a coordinate are known, and how many are not.
    pub(super) fn know_bits(&mut self, known: u32, unknown: u32) {
        (self.known_bits, self.unknown_bits) = (known, unknown);
        self.place_model.most = (1 << known) - 1;
    }

    /// Codes further bits of all positions. `full` returns the position of a fan on the grid of the full mesh.
    pub(super) fn refine_places<C: BitCoder>(
        &mut self,
        coder: &mut C,
        unknown_bits: u32,
        full: impl Fn(u32) -> Place,
    ) {
        while self.unknown_bits > 0 && self.flags.code(coder, MORE_REFINING, self.unknown_bits > unknown_bits)
        {
            self.know_bits(self.known_bits + 1, self.unknown_bits - 1);
            for fan in 0..self.fans.len() {
                let leader = self.leaders[fan] as usize;
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

    /// Visits the next fan of the batch: codes all its splits. `wanted` are those to be encoded, in groups.
    pub(super) fn visit<C: BitCoder>(&mut self, coder: &mut C, wanted: &[Vec<Wanted>]) {
        let fan = self.next;
        // The fans of this batch come before it.
        self.next = self.fans[fan as usize].next;
        let mut done = 0;
        loop {
            let group: Option<&[Wanted]> = wanted.get(done).map(Vec::as_slice);
            self.corner_count += 1;
            let of = &self.fans[fan as usize];
            let is_split = self.splits.code_mark(coder, of, self.batch, done, group.is_some());
            self.account(coder, |costs| Some(&mut costs.marks));
            if is_split {
                let mut ring = std::mem::take(&mut self.ring);
                let is_open = self.surface.ring(fan, &mut ring);
                let is_small = !ring.is_empty() && ring.len() <= MOST_CORNERS;
                if is_small {
                    self.code_group(coder, (fan, &mut ring, is_open), group.unwrap_or(&[]));
                }
                self.ring = ring;
                if !is_small {
                    break;
                }
            }
            if !is_split || self.is_too_large(coder) {
                break;
            }
            done += 1;
        }
    }

    /// Returns whether more has been built than the bytes may build; never while encoding.
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
    fn code_group<C: BitCoder>(
        &mut self,
        coder: &mut C,
        (fan, ring, is_open): (u32, &mut Vec<u32>, bool),
        wanted: &[Wanted],
    ) {
        let first_new = self.fans.len() as u32;
        let (mut of, mut is_open) = (fan, is_open);
        let mut number = 0;
        loop {
            self.code_split(coder, (of, ring, is_open), wanted.get(number), first_new);
            number += 1;
            // Only where a surface has borders a point has several fans.
            if !is_open {
                break;
            }
            let has_twins = usize::from(self.twins[fan as usize] != fan);
            if !self.flags.code(coder, MORE_IN_GROUP + has_twins, wanted.len() > number) {
                break;
            }
            of = self.code_twin(coder, fan, wanted.get(number).map_or(fan, |wanted| wanted.fan));
            is_open = self.surface.ring(of, ring);
            if ring.is_empty() || ring.len() > MOST_CORNERS || self.is_too_large(coder) {
                break;
            }
        }
        // New fans are visited after this one, from the next batch on, so that fans near each other are visited one after the other.
        let mut next = std::mem::replace(&mut self.fans[fan as usize].next, first_new);
        for new in (first_new..self.fans.len() as u32).rev() {
            self.fans[new as usize].next = next;
            next = new;
        }
        self.group_count += 1;
        self.record_ends.push(self.record.len() as u32);
    }

    /// Codes a fan of the point of another one, whose number is counted from it.
    fn code_twin<C: BitCoder>(&self, coder: &mut C, fan: u32, wanted: u32) -> u32 {
        let (mut count, mut place, mut twin) = (1, 0, self.twins[fan as usize]);
        while twin != fan && count < MOST_TWINS {
            if twin == wanted {
                place = count;
            }
            count += 1;
            twin = self.twins[twin as usize];
        }
        let bits = u32::BITS - u32::leading_zeros(count - 1);
        let steps = code_bits(coder, bits, place) % count;
        (0..steps).fold(fan, |fan, _| self.twins[fan as usize])
    }

    fn code_split<C: BitCoder>(
        &mut self,
        coder: &mut C,
        (fan, ring, is_open): (u32, &[u32], bool),
        wanted: Option<&Wanted>,
        first_new: u32,
    ) {
        let new = self.fans.len() as u32;
        self.corner_count += ring.len() as u64;
        // 1. The corners that move.
        let mut around = std::mem::take(&mut self.neighbours);
        around.clear();
        around.extend(ring.iter().map(|&corner| self.surface.fan(next(corner))));
        around.push(self.surface.fan(previous(ring[ring.len() - 1])));
        let wanted_split = wanted.map(|wanted| {
            let start = ring.iter().position(|&corner| triangle_of(corner) == wanted.first);
            let of_none = if wanted.adds[1] { 0 } else { ring.len() };
            Split { start: start.unwrap_or(of_none), count: wanted.count, is_open, adds: wanted.adds }
        });
        let known = (&self.surface, &self.fans[..], self.batch);
        let looked = Ring { fan, corners: ring, around: &around, is_open };
        let split = self.splits.code_split(coder, known, looked, wanted_split);
        self.account(coder, |costs| Some(&mut costs.corners));
        // 2. The point.
        let mut rim = std::mem::take(&mut self.rim);
        collect_rim(fan, &around, split, &mut rim);
        let is_first = new == first_new;
        let place = if is_first {
            self.collect_polygon(&rim);
            let estimates = Estimates::new(&self.polygon, self.regime);
            let place = wanted.map_or([0; 3], |wanted| wanted.place.map(|x| x >> self.unknown_bits));
            if let Some(fit) = &mut self.fit {
                fit.add(&estimates, &self.place_model.weights, place);
            }
            self.place_model.code(coder, &estimates, place)
        } else {
            self.fans[first_new as usize].place()
        };
        self.account(coder, |costs| Some(&mut costs.positions));
        // 3. The vertex.
        let same_as = wanted.and_then(|wanted| wanted.same_as);
        let is_same = !is_first && self.flags.code(coder, SAME_VERTEX, same_as.is_some());
        let vertex = if is_same {
            let count = new - first_new;
            let bits = u32::BITS - u32::leading_zeros(count - 1);
            let number = code_bits(coder, bits, same_as.unwrap_or(0) as u32) % count;
            self.vertices[(first_new + number) as usize]
        } else {
            self.code_values(coder, &rim, wanted.map(|wanted| &wanted.values[..]));
            self.vertex_count
        };
        self.account(coder, |costs| Some(&mut costs.attributes));
        // 4. Do it.
        self.use_corners(&rim, ring, split);
        self.push_fan(place, (!is_first).then_some(first_new), vertex, split.adds != [true; 2]);
        self.update_around(&rim, split);
        let added = self.surface.split(fan, ring, split);
        for corner in added.into_iter().filter(|&corner| corner != NONE) {
            self.surface.set_mark(corner, self.batch);
        }
        if let Some(strips) = &mut self.strips {
            strips.follow_split(&self.surface, added);
        }
        self.fans[fan as usize].split = self.batch as u8;
        self.record.push([fan, new]);
        (self.rim, self.neighbours) = (rim, around);
    }

    /// Codes the attributes of a new vertex.
    pub(super) fn code_values<C: BitCoder>(
        &mut self,
        coder: &mut C,
        around: &[u32],
        wanted: Option<&[Vec<i32>]>,
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
            channel.code(coder, &around, wanted.map_or(&[], |wanted| &wanted[number]), &mut new);
            values.extend(new);
        }
    }

    /// Collects what is known around a new point.
    fn collect_polygon(&mut self, rim: &[u32]) {
        let polygon = &mut self.polygon;
        polygon.points.clear();
        polygon.laplacians = [0; 3];
        for &fan in rim {
            let fan = &self.fans[fan as usize];
            polygon.points.push(fan.place());
            let laplacian = fan.laplacian();
            let share = reciprocal(fan.count.into());
            for j in 0..3 {
                polygon.laplacians[j] += (16 * i64::from(laplacian[j]) * share) >> 16;
            }
        }
        // A triangle at the end of a border has no third point.
        if rim.len() == 2 {
            polygon.points.push(polygon.points[1]);
        }
    }

    /// Finds what is around all fans.
    pub(super) fn look_around(&mut self) {
        for fan in 0..self.fans.len() {
            self.fans[fan].next = if fan + 1 < self.fans.len() { fan as u32 + 1 } else { NONE };
            self.fans[fan].is_open = self.surface.is_open(fan as u32);
        }
        self.sum_around();
    }

    /// Sums up the positions around all fans.
    fn sum_around(&mut self) {
        for fan in &mut self.fans {
            fan.clear();
        }
        for corner in self.surface.corners() {
            let fan = self.surface.fan(corner) as usize;
            let of = |corner: u32| self.surface.fan(corner) as usize;
            let place = self.fans[of(next(corner))].place();
            self.fans[fan].add(place);
            if self.fans[fan].is_open && self.surface.after(corner).is_none() {
                let place = self.fans[of(previous(corner))].place();
                self.fans[fan].add(place);
            }
        }
    }

    /// Marks the corners of a split as used, before it is done.
    fn use_corners(&mut self, rim: &[u32], ring: &[u32], split: Split) {
        let mut use_one = |i: usize| {
            let used = &mut self.fans[rim[i] as usize].used;
            *used = used.saturating_add(1);
        };
        let Split { start, count, adds, .. } = split;
        let mut moved = 0_u8;
        for i in 0..count {
            let corner = if start + i < ring.len() { ring[start + i] } else { ring[start + i - ring.len()] };
            // It may be used already where a group has several splits.
            if self.surface.mark(corner) == self.batch {
                moved = moved.saturating_add(1);
            } else {
                self.surface.set_mark(corner, self.batch);
                use_one(i + 1);
                use_one(i + 2);
            }
        }
        for (is_added, end) in adds.into_iter().zip([1, rim.len() - 1]) {
            if is_added {
                use_one(0);
                use_one(end);
            }
        }
        let kept = &mut self.fans[rim[0] as usize];
        kept.used = kept.used.saturating_sub(moved);
    }

    /// Changes the sums of the fans around the last fan, before it is split off.
    fn update_around(&mut self, rim: &[u32], split: Split) {
        let new = self.fans.len() - 1;
        let (kept, last) = (rim[0] as usize, rim.len() - 1);
        let [of_kept, of_new] = [kept, new].map(|fan| self.fans[fan].place());
        self.fans[new].add(of_kept);
        for (i, &fan) in rim.iter().enumerate().skip(1) {
            let place = self.fans[fan as usize].place();
            self.fans[new].add(place);
            // The first and the last one stay neighbours of the kept fan if a triangle is added there.
            let stays = split.count == 0 || i == 1 && split.adds[0] || i == last && split.adds[1];
            if !stays {
                self.fans[fan as usize].remove(of_kept);
                self.fans[kept].remove(place);
            }
            self.fans[fan as usize].add(of_new);
        }
        self.fans[kept].add(of_new);
    }
}

/// Collects the fans around the new point: the kept one, then those around the corners that move.
fn collect_rim(fan: u32, around: &[u32], split: Split, rim: &mut Vec<u32>) {
    let Split { start, count, adds, .. } = split;
    let n = around.len() - 1;
    rim.clear();
    rim.push(fan);
    match count {
        0 if adds[0] => rim.push(around[n]),
        0 => rim.push(around[0]),
        _ => rim.extend((start..=start + count).map(|i| around[if i <= n { i } else { i - n }])),
    }
}
