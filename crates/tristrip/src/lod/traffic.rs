//! What all levels of detail cost: vertices sent for each level, and places renamed between them.
//!
//! The literature prices a progressive transmission by drawing each intermediate mesh once, from the base mesh to the full one: as a
//! progressive mesh, three vertices a triangle, and as strips through each [`Filter`].
//!
//! # The published unit
//! Table 2 of Kim et al. gives totals in Gbits, without the bits of a vertex. The sums of 3 T over all levels, of which table 1 gives
//! number and ends, are 24.7, 363, 1929 and 3618 million vertices; published for them are 2.6, 37.9, 201.3 and 377.1 Gbits. That is
//! [`VERTEX_BITS`] = 112 within 0.3 %, with a Gbit of 2³⁰ bits: 12 bytes of a position and 2 of an index, which are the sizes that the
//! paper names elsewhere.
//!
//! # Algorithm
//! A collapse touches the strips that hold the removed vertex, and no other. So each strip keeps its counts, and only those touched are
//! scanned again.
//!
//! # References
//! Kim et al. 2005, section 5, tables 1 and 2, figures 9 and 11.
//!
//! # Complexity
//! Each collapse takes O(length of the strips that it touches), once a filter; the bunny's 33,000 levels take a third of a second for strips
//! of ten to a hundred triangles. 100 bytes a strip and 4 an entry, beside the models.

use super::progressive::{Encoding, ProgressiveStrips};
use super::{Filter, Sent};
use crate::error::Error;
use crate::simplify::CollapseSequence;
use crate::simplify::collapse::is_degenerate;
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
    sent: [Sent; 4],
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
    pub fn sent(&self, filter: Filter) -> Sent {
        let of_filter = Filter::ALL.iter().zip(self.sent).find(|(other, _)| **other == filter);
        of_filter.map_or_else(Sent::default, |(_, sent)| sent)
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
/// use tristrip::{CollapseSequence, Strips, simplify::Rename};
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
    let mut counts = Counts::new(strips);
    let never_drawn = sequence.triangles().chunks_exact(3).filter(|t| is_degenerate(t)).count();
    let (mut totals, mut split) = (Totals::default(), None);
    loop {
        let level = model.level();
        let triangles = sequence.triangle_count(level) - never_drawn;
        let now = Level { level, triangles, sent: counts.sum, split };
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

/// What the strips of an index map cost, each by itself and all together.
struct Counts {
    of_strip: Vec<[Sent; 4]>,
    sum: [Sent; 4],
    /// The strip of each entry, restarts included.
    strip_of: Vec<u32>,
    /// Where each strip begins in the map.
    starts: Vec<u32>,
    touched: Vec<u32>,
}

impl Counts {
    fn new(strips: &Strips) -> Self {
        let mut counts = Self {
            of_strip: Vec::with_capacity(strips.len()),
            sum: [Sent::default(); 4],
            strip_of: Vec::with_capacity(strips.vertices_sent() + strips.len()),
            starts: Vec::with_capacity(strips.len()),
            touched: Vec::new(),
        };
        for (i, strip) in strips.iter().enumerate() {
            counts.starts.push(counts.strip_of.len() as u32);
            counts.strip_of.resize(counts.strip_of.len() + strip.len() + 1, i as u32);
            counts.of_strip.push(Filter::ALL.map(|filter| filter.sent(strip)));
            counts.replace([Sent::default(); 4], counts.of_strip[i]);
        }
        counts
    }

    /// Scans again the strips of which entries have changed.
    fn update<'a>(&mut self, entries: &[u32], places: impl Iterator<Item = &'a u32>) {
        let mut touched = std::mem::take(&mut self.touched);
        touched.clear();
        touched.extend(places.map(|&place| self.strip_of[place as usize]));
        touched.sort_unstable();
        touched.dedup();
        for &i in &touched {
            let i = i as usize;
            let end = self.starts.get(i + 1).map_or(entries.len(), |&next| next as usize - 1);
            let strip = &entries[self.starts[i] as usize..end];
            let now = Filter::ALL.map(|filter| filter.sent(strip));
            let before = std::mem::replace(&mut self.of_strip[i], now);
            self.replace(before, now);
        }
        self.touched = touched;
    }

    fn replace(&mut self, before: [Sent; 4], now: [Sent; 4]) {
        for (sum, (before, now)) in self.sum.iter_mut().zip(before.into_iter().zip(now)) {
            *sum += now;
            sum.vertices -= before.vertices;
            sum.strips -= before.strips;
            sum.winding_repeats -= before.winding_repeats;
        }
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
