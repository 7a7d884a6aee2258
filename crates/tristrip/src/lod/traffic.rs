//! What all levels of detail cost: vertices sent for each level, and places renamed between them.
//!
//! The literature prices a progressive transmission by drawing each intermediate mesh once, from the base mesh to the full one: as a
//! progressive mesh, three vertices a triangle, and as strips through each [`Filter`].
//!
//! # The published unit
//! Table 2 of Kim et al. gives totals in Gbits, without the bits of a vertex. The sums of 3 T over all levels, of which table 1 gives
//! number and ends, are 24.7, 363, 1929 and 3618 million vertices; published for them are 2.6, 37.9, 201.3 and 377.1 Gbits. That is
//! [`VERTEX_BITS`] = 112 within 0.3 % or the digits printed, with a Gbit of 2³⁰ bits: 12 bytes of a position and 2 of an index, which are the sizes that the
//! paper names elsewhere.
//!
//! # Algorithm
//! The map is cut into blocks of 64 entries. For each filter and block stands how the scan stood before it, and what it sent. A collapse has
//! the blocks of its places scanned again, and the next ones as long as the scan comes to them otherwise than before: that is soon over,
//! since a new display strip begins where two triangles do not follow on each other. So the length of strips does not matter.
//!
//! # References
//! Kim et al. 2005, section 5, tables 1 and 2, figures 9 and 11.
//!
//! # Complexity
//! A collapse takes a few blocks for each place that it changes, however long the strips: the bunny's 33,000 levels take a quarter
//! of a second, 0.35 as two strips in all. 3 bytes an entry, beside the models.

use super::filter::{BLOCK, DrawCost, DrawTally, Dtfs, Filter, Gatherer, Linked, Scanner, Stss};
use super::progressive::{Encoding, ProgressiveStrips};
use crate::collapse::CollapseSequence;
use crate::error::Error;
use crate::strip::Strips;

/// Bits of a vertex that is sent, as published totals have them: a position of three 32-bit numbers and an index of 16 bits.
pub const VERTEX_BITS: u64 = 112;

/// Bins of a transmission: a twentieth of all splits each.
pub const BIN_COUNT: usize = 20;

/// What one level costs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Level {
    /// The level, from 0 for the base mesh.
    pub level: usize,
    /// Triangles drawn.
    pub triangles: usize,
    /// What each filter sends, in the order of [`Filter::ALL`].
    sent: [DrawCost; 4],
    /// Vertices and places that the split to the next level writes; `None` for the full mesh.
    pub split: Option<Split>,
}

/// What one vertex split costs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Split {
    /// Vertices that come back.
    pub vertices: usize,
    /// Places renamed in the naive encoding, swaps included.
    pub naive_places: usize,
    /// Places renamed in the encoding by offsets.
    pub encoded_places: usize,
}

impl Level {
    /// Gives what a filter sends at this level.
    ///
    /// Filters that are not in [`Filter::ALL`] have no count here.
    pub fn sent(&self, filter: Filter) -> DrawCost {
        let of_filter = Filter::ALL.iter().zip(self.sent).find(|(other, _)| **other == filter);
        of_filter.map_or_else(DrawCost::default, |(_, sent)| sent)
    }

    /// Counts the vertices of a progressive mesh: three a triangle.
    pub fn progressive_mesh_vertices(&self) -> usize {
        3 * self.triangles
    }
}

impl Split {
    /// Counts the places renamed in an encoding, the u of the literature.
    pub fn places(&self, encoding: Encoding) -> usize {
        match encoding {
            Encoding::Naive => self.naive_places,
            Encoding::Offsets => self.encoded_places,
        }
    }

    /// Counts the bytes of its record as published: 12 for the position of each vertex, 2 for each place.
    pub fn bytes(&self, encoding: Encoding) -> usize {
        12 * self.vertices + 2 * self.places(encoding)
    }
}

/// Sums over all levels, each drawn once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Totals {
    /// Levels drawn, one more than there are collapses.
    pub levels: usize,
    /// Triangles drawn.
    pub triangles: u64,
    /// Vertices sent by each filter, in the order of [`Filter::ALL`].
    sent: [u64; 4],
    /// What the splits cost, from the base mesh on, a twentieth of them each.
    bins: [Bin; BIN_COUNT],
}

/// What the splits of a twentieth of the transmission cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Bin {
    /// Splits.
    pub splits: usize,
    /// Vertices that come back.
    pub vertices: u64,
    /// Places renamed in the naive encoding.
    pub naive_places: u64,
    /// Places renamed in the encoding by offsets.
    pub encoded_places: u64,
}

impl Bin {
    /// Divides the places by the splits, the average u; 0 where there is no split.
    pub fn places_per_split(&self, encoding: Encoding) -> f64 {
        let places = match encoding {
            Encoding::Naive => self.naive_places,
            Encoding::Offsets => self.encoded_places,
        };
        if self.splits == 0 { 0.0 } else { places as f64 / self.splits as f64 }
    }
}

impl Totals {
    /// Counts the vertices that a filter sends for all levels.
    pub fn vertices(&self, filter: Filter) -> u64 {
        Filter::ALL.iter().zip(self.sent).find(|(other, _)| **other == filter).map_or(0, |(_, sent)| sent)
    }

    /// Counts the vertices that a progressive mesh sends for all levels.
    pub fn progressive_mesh_vertices(&self) -> u64 {
        3 * self.triangles
    }

    /// Divides what a filter sends by what a progressive mesh sends; 0 where there is no triangle.
    pub fn fraction(&self, filter: Filter) -> f64 {
        let whole = self.progressive_mesh_vertices();
        if whole == 0 { 0.0 } else { self.vertices(filter) as f64 / whole as f64 }
    }

    /// Gives the bins of the splits, from the base mesh on.
    pub fn bins(&self) -> &[Bin; BIN_COUNT] {
        &self.bins
    }

    /// Sums all bins.
    pub fn splits(&self) -> Bin {
        self.bins.iter().fold(Bin::default(), |sum, bin| Bin {
            splits: sum.splits + bin.splits,
            vertices: sum.vertices + bin.vertices,
            naive_places: sum.naive_places + bin.naive_places,
            encoded_places: sum.encoded_places + bin.encoded_places,
        })
    }

    fn add(&mut self, level: &Level, level_count: usize) {
        self.levels += 1;
        self.triangles += level.triangles as u64;
        self.sent.iter_mut().zip(level.sent).for_each(|(sum, sent)| *sum += sent.vertices as u64);
        if let Some(split) = level.split {
            let bin = &mut self.bins[level.level * BIN_COUNT / level_count];
            bin.splits += 1;
            bin.vertices += split.vertices as u64;
            bin.naive_places += split.naive_places as u64;
            bin.encoded_places += split.encoded_places as u64;
        }
    }
}

/// Gives the published unit of a number of vertices: 2³⁰ bits, of [`VERTEX_BITS`] each.
///
/// ```
/// use tristrip::lod::traffic::gigabits;
/// // The sum of 3 T over the levels of the published bunny, which is printed as 377.1.
/// assert_eq!(format!("{:.0}", gigabits(3_618_000_000)), "377");
/// ```
pub fn gigabits(vertices: u64) -> f64 {
    (vertices as f64 * VERTEX_BITS as f64) / f64::from(1 << 30)
}

/// Goes from the full mesh to the base mesh, shows what each level costs, and sums it up.
///
/// # Errors
/// As for [`ProgressiveStrips::new`].
///
/// ```
/// use tristrip::lod::{Filter, traffic};
/// use tristrip::{CollapseSequence, Strips, collapse::Rename};
/// let mut strips = Strips::default();
/// strips.push(&[0, 1, 2, 3]);
/// let rename = [Rename { removed: 3, kept: 2 }];
/// let sequence = CollapseSequence::from_collapses(4, strips.to_list(), [(&rename[..], 0.5)])?;
/// let mut sent = Vec::new();
/// let totals = traffic::walk(&strips, &sequence, |level| sent.push(level.sent(Filter::Dtfs).vertices))?;
/// assert_eq!(sent, [4, 3]);
/// assert_eq!((totals.vertices(Filter::Dtfs), totals.progressive_mesh_vertices()), (7, 9));
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn walk(
    strips: &Strips,
    sequence: &CollapseSequence,
    mut show: impl FnMut(&Level),
) -> Result<Totals, Error> {
    let mut model = ProgressiveStrips::new(strips, sequence, Encoding::Naive)?;
    let encoded = ProgressiveStrips::new(strips, sequence, Encoding::Offsets)?;
    let mut counts = Counts::new(model.entries());
    let (mut totals, mut split) = (Totals::default(), None);
    loop {
        let level = model.level();
        let triangles = sequence.triangle_count(level);
        let now = Level { level, triangles, sent: counts.sent(), split };
        show(&now);
        totals.add(&now, sequence.len());
        if !model.coarsen() {
            return Ok(totals);
        }
        let level = model.level();
        let places = model.split(level).flat_map(|update| update.places);
        counts.update(model.entries(), places);
        split = Some(Split {
            vertices: model.split(level).len(),
            naive_places: model.place_count(level),
            encoded_places: encoded.place_count(level),
        });
    }
}

/// What the blocks of an index map cost through each filter.
struct Counts {
    none: DrawCost,
    stss: Blocks<Stss>,
    dtfs: Blocks<Dtfs>,
    linked: Blocks<Linked>,
    gatherer: Gatherer,
    touched: Vec<u32>,
}

impl Counts {
    fn new(map: &[u32]) -> Self {
        let mut counts = Self {
            none: Filter::None.sent_by_map(map),
            stss: Blocks::new(map),
            dtfs: Blocks::new(map),
            linked: Blocks::new(map),
            gatherer: Gatherer::new(),
            touched: (0..map.len().div_ceil(BLOCK) as u32).collect(),
        };
        counts.scan(map);
        counts
    }

    /// Scans again what changed entries change.
    fn update<'a>(&mut self, map: &[u32], places: impl Iterator<Item = &'a u32>) {
        // Filters look up to three entries ahead.
        let blocks = |&place: &u32| [place.saturating_sub(3) / BLOCK as u32, place / BLOCK as u32];
        self.touched.clear();
        self.touched.extend(places.flat_map(blocks));
        self.touched.sort_unstable();
        self.touched.dedup();
        self.scan(map);
    }

    fn scan(&mut self, map: &[u32]) {
        self.stss.update(map, &self.touched, &mut self.gatherer);
        self.dtfs.update(map, &self.touched, &mut self.gatherer);
        self.linked.update(map, &self.touched, &mut self.gatherer);
    }

    /// Gives what each filter sends, in the order of [`Filter::ALL`].
    fn sent(&self) -> [DrawCost; 4] {
        [self.none, self.stss.sum.into(), self.dtfs.sum.into(), self.linked.sum.into()]
    }
}

/// A scan as it stands before each block and after the last, and what each block sends; at last, what its end does.
struct Blocks<S> {
    scans: Vec<S>,
    tallies: Vec<DrawTally>,
    sum: DrawTally,
}

impl<S: Scanner> Blocks<S> {
    fn new(map: &[u32]) -> Self {
        let count = map.len().div_ceil(BLOCK);
        let (scans, tallies) = (vec![S::default(); count + 1], vec![DrawTally::default(); count + 1]);
        Self { scans, tallies, sum: DrawTally::default() }
    }

    /// Scans blocks again, in rising order, and after each those to which it now comes otherwise than before.
    fn update(&mut self, map: &[u32], touched: &[u32], gatherer: &mut Gatherer) {
        let mut next = 0;
        for &block in touched {
            let mut at = block as usize;
            // One that an earlier block led to was scanned with all its changes.
            while at >= next && at < self.scans.len() - 1 {
                let (mut scan, mut tally) = (self.scans[at].clone(), DrawTally::default());
                scan.scan(&map[at * BLOCK..], gatherer, &mut tally);
                self.replace(at, tally);
                at += 1;
                next = at;
                if self.scans[at] == scan {
                    break;
                }
                self.scans[at] = scan;
            }
        }
        let mut end = DrawTally::default();
        if let Some(scan) = self.scans.last() {
            scan.end(&mut end);
        }
        self.replace(self.tallies.len() - 1, end);
    }

    fn replace(&mut self, at: usize, now: DrawTally) {
        let before = std::mem::replace(&mut self.tallies[at], now);
        self.sum.vertices += now.vertices - before.vertices;
        self.sum.strips += now.strips - before.strips;
        self.sum.winding_repeats += now.winding_repeats - before.winding_repeats;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lod::samples::samples;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_level_costs_what_its_strips_cost(sample in samples()) {
            let (strips, sequence) = (&sample.strips, &sample.sequence);
            let mut levels = Vec::new();
            let totals = walk(strips, sequence, |level| levels.push(*level)).unwrap();
            prop_assert_eq!((levels.len(), totals.levels), (sequence.len() + 1, sequence.len() + 1));
            let mut model = ProgressiveStrips::new(strips, sequence, Encoding::Offsets).unwrap();
            let mut map = Vec::new();
            for found in &levels {
                prop_assert_eq!(found.level, model.level());
                model.decode_to(&mut map);
                prop_assert_eq!(found.triangles, sequence.drawn(model.level()).len());
                for filter in Filter::ALL {
                    prop_assert_eq!(found.sent(filter), filter.sent_by_map(&map));
                }
                let places = (model.level() < model.len()).then(|| model.place_count(model.level()));
                prop_assert_eq!(found.split.map(|split| split.encoded_places), places);
                model.coarsen();
            }
            for filter in Filter::ALL {
                let sent: u64 = levels.iter().map(|level| level.sent(filter).vertices as u64).sum();
                prop_assert_eq!(totals.vertices(filter), sent);
            }
            let splits: Vec<Split> = levels.iter().filter_map(|level| level.split).collect();
            let all = totals.splits();
            prop_assert_eq!(all.splits, sequence.len());
            prop_assert_eq!(all.naive_places, splits.iter().map(|split| split.naive_places as u64).sum::<u64>());
            let bytes: usize = splits.iter().map(|split| split.bytes(Encoding::Offsets)).sum();
            prop_assert_eq!(bytes as u64, 12 * all.vertices + 2 * all.encoded_places);
        }
    }

    #[test]
    fn totals_of_no_strips() {
        let totals = walk(&Strips::default(), &CollapseSequence::default(), |_| ()).unwrap();
        assert_eq!((totals.levels, totals.fraction(Filter::Dtfs).to_bits()), (1, 0));
        assert_eq!(totals.bins()[0].places_per_split(Encoding::Naive).to_bits(), 0);
    }

    #[test]
    fn the_published_totals_fit_one_unit() {
        // Triangles of the base mesh and of the full one, collapses, and the printed Gbits of the progressive mesh.
        let models = [
            (254, 5804, 2722, 2.6),
            (1104, 22104, 10412, 37.9),
            (2538, 50761, 24129, 201.3),
            (3471, 69451, 33077, 377.1),
        ];
        for (base, full, collapses, published) in models {
            let vertices = 3 * (base + full) * (collapses + 1) / 2;
            let ratio = gigabits(vertices) / published;
            assert!((0.99..1.01).contains(&ratio), "{ratio}");
        }
    }
}
