//! The cost of all levels of detail: vertices sent at each level, and slots renamed between levels.
//!
//! The literature measures a progressive transmission by drawing each intermediate mesh once, from
//! the base mesh to the full mesh. It is drawn as a progressive mesh, with three vertices per
//! triangle, and as strips through each [`Filter`].
//!
//! # The published unit
//! Table 2 of Kim et al. gives totals in Gbit, but not the bits per vertex. The sums of 3 T over
//! all levels, from the counts in table 1, are 24.7, 363, 1929 and 3618 million vertices. The
//! published totals are 2.6, 37.9, 201.3 and 377.1 Gbit. This corresponds to [`VERTEX_BITS`] = 112,
//! within 0.3 % or the printed digits, if a Gbit has 2³⁰ bits. These are 12 bytes for a position
//! and 2 for an index, the sizes that the paper uses elsewhere.
//!
//! # References
//! Kim et al. 2005, section 5, tables 1 and 2, figures 9 and 11.
//!
//! # Complexity
//! That of [`FilterCosts`]: the 33,000 levels of the bunny take 0.25 seconds, or 0.35 seconds with
//! two strips in total.

use std::sync::Arc;

use tristrip::lod::{DrawCost, Encoding, Filter, FilterCosts, LevelCursor, ProgressiveStrips};
use tristrip::{CollapseSequence, Error, Strips};

/// Bits per vertex sent in the published totals: a position of three 32-bit numbers, and a 16-bit
/// index.
pub const VERTEX_BITS: u64 = 112;

/// The number of bins of a transmission. Each bin has a twentieth of all splits.
pub const BIN_COUNT: usize = 20;

/// The cost of one level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LevelTraffic {
    /// The level, from 0 for the base mesh.
    pub level: usize,
    /// The number of triangles drawn.
    pub triangles: usize,
    /// The cost by filter, in the order of [`Filter::ALL`].
    sent: [DrawCost; 4],
    /// The cost of the split to the next level; `None` for the full mesh.
    pub split: Option<SplitTraffic>,
}

/// The cost of one vertex split.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SplitTraffic {
    /// The number of restored vertices.
    pub vertices: usize,
    /// The number of slots renamed in the naive encoding, including swaps.
    pub naive_slots: usize,
    /// The number of slots renamed in the encoding by offsets.
    pub encoded_slots: usize,
}

impl LevelTraffic {
    /// Returns the cost of a filter at this level.
    ///
    /// Filters outside [`Filter::ALL`] have no cost here.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut sent = Vec::new();
    /// traffic::walk(&strips, &sequence, |level| sent.push(level.sent(Filter::None).vertices))?;
    /// // Without a filter, every level sends what the full mesh does.
    /// assert_eq!(sent, [5, 5, 5]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn sent(&self, filter: Filter) -> DrawCost {
        let of_filter = Filter::ALL.iter().zip(self.sent).find(|(other, _)| **other == filter);
        of_filter.map_or_else(DrawCost::default, |(_, sent)| sent)
    }

    /// Returns the number of vertices of a progressive mesh: three per triangle.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut sent = Vec::new();
    /// traffic::walk(&strips, &sequence, |level| sent.push(level.progressive_mesh_vertices()))?;
    /// assert_eq!(sent, [9, 6, 3]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn progressive_mesh_vertices(&self) -> usize {
        3 * self.triangles
    }
}

impl SplitTraffic {
    /// Returns the number of slots renamed in an encoding, which is u in the literature.
    ///
    /// ```
    /// use tristrip::lod::Encoding;
    /// use tristrip_lab::traffic::SplitTraffic;
    /// let split = SplitTraffic { vertices: 1, naive_slots: 14, encoded_slots: 3 };
    /// assert_eq!((split.slots(Encoding::Naive), split.slots(Encoding::Offsets)), (14, 3));
    /// ```
    pub fn slots(&self, encoding: Encoding) -> usize {
        match encoding {
            Encoding::Naive => self.naive_slots,
            Encoding::Offsets => self.encoded_slots,
        }
    }

    /// Returns the size of its record as published: 12 bytes per vertex position, and 2 per slot.
    ///
    /// ```
    /// use tristrip::lod::Encoding;
    /// use tristrip_lab::traffic::SplitTraffic;
    /// let split = SplitTraffic { vertices: 1, naive_slots: 14, encoded_slots: 3 };
    /// assert_eq!((split.bytes(Encoding::Naive), split.bytes(Encoding::Offsets)), (40, 18));
    /// ```
    pub fn bytes(&self, encoding: Encoding) -> usize {
        12 * self.vertices + 2 * self.slots(encoding)
    }
}

/// Sums over all levels, each drawn once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TrafficTotals {
    /// The number of levels drawn, one more than the number of collapses.
    pub levels: usize,
    /// The number of triangles drawn.
    pub triangles: u64,
    /// Vertices sent by each filter, in the order of [`Filter::ALL`].
    sent: [u64; 4],
    /// The cost of the splits, in bins of a twentieth each, starting at the base mesh.
    bins: [TrafficBin; BIN_COUNT],
}

/// The cost of a twentieth of the splits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TrafficBin {
    /// The number of splits.
    pub splits: usize,
    /// The number of restored vertices.
    pub vertices: u64,
    /// The number of slots renamed in the naive encoding.
    pub naive_slots: u64,
    /// The number of slots renamed in the encoding by offsets.
    pub encoded_slots: u64,
}

impl TrafficBin {
    /// Returns the mean number of slots per split, which is the mean of u; 0 if there is no split.
    ///
    /// ```
    /// use tristrip::lod::Encoding;
    /// use tristrip_lab::traffic::TrafficBin;
    /// let bin = TrafficBin { splits: 4, vertices: 4, naive_slots: 30, encoded_slots: 12 };
    /// assert_eq!((bin.slots_per_split(Encoding::Naive), bin.slots_per_split(Encoding::Offsets)), (7.5, 3.0));
    /// ```
    pub fn slots_per_split(&self, encoding: Encoding) -> f64 {
        let slots = match encoding {
            Encoding::Naive => self.naive_slots,
            Encoding::Offsets => self.encoded_slots,
        };
        if self.splits == 0 { 0.0 } else { slots as f64 / self.splits as f64 }
    }
}

impl TrafficTotals {
    /// Returns the number of vertices that a filter sends over all levels.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let totals = traffic::walk(&strips, &sequence, |_| ())?;
    /// // 5, 4 and 3 vertices at the three levels.
    /// assert_eq!(totals.vertices(Filter::Linked), 12);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn vertices(&self, filter: Filter) -> u64 {
        Filter::ALL.iter().zip(self.sent).find(|(other, _)| **other == filter).map_or(0, |(_, sent)| sent)
    }

    /// Returns the number of vertices that a progressive mesh sends over all levels.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let totals = traffic::walk(&strips, &sequence, |_| ())?;
    /// assert_eq!((totals.triangles, totals.progressive_mesh_vertices()), (6, 18));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn progressive_mesh_vertices(&self) -> u64 {
        3 * self.triangles
    }

    /// Returns the vertices of a filter divided by those of a progressive mesh; 0 if there are no
    /// triangles.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let totals = traffic::walk(&strips, &sequence, |_| ())?;
    /// assert_eq!(format!("{:.2}", totals.fraction(Filter::Linked)), "0.67");
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn fraction(&self, filter: Filter) -> f64 {
        let whole = self.progressive_mesh_vertices();
        if whole == 0 { 0.0 } else { self.vertices(filter) as f64 / whole as f64 }
    }

    /// Returns the bins of the splits, starting at the base mesh.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let totals = traffic::walk(&strips, &sequence, |_| ())?;
    /// // One of the two splits is at the base mesh, the other halfway to the full mesh.
    /// let bins: Vec<usize> = (0..20).filter(|&bin| totals.bins()[bin].splits > 0).collect();
    /// assert_eq!(bins, [0, 10]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn bins(&self) -> &[TrafficBin; BIN_COUNT] {
        &self.bins
    }

    /// Returns the sum of all bins.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let splits = traffic::walk(&strips, &sequence, |_| ())?.splits();
    /// assert_eq!((splits.splits, splits.naive_slots, splits.encoded_slots), (2, 3, 2));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn splits(&self) -> TrafficBin {
        self.bins.iter().fold(TrafficBin::default(), |sum, bin| TrafficBin {
            splits: sum.splits + bin.splits,
            vertices: sum.vertices + bin.vertices,
            naive_slots: sum.naive_slots + bin.naive_slots,
            encoded_slots: sum.encoded_slots + bin.encoded_slots,
        })
    }

    fn add(&mut self, level: &LevelTraffic, level_count: usize) {
        self.levels += 1;
        self.triangles += level.triangles as u64;
        self.sent.iter_mut().zip(level.sent).for_each(|(sum, sent)| *sum += sent.vertices as u64);
        if let Some(split) = level.split {
            let bin = &mut self.bins[level.level * BIN_COUNT / level_count];
            bin.splits += 1;
            bin.vertices += split.vertices as u64;
            bin.naive_slots += split.naive_slots as u64;
            bin.encoded_slots += split.encoded_slots as u64;
        }
    }
}

/// Converts a number of vertices, with [`VERTEX_BITS`] each, to the published unit of 2³⁰ bits.
///
/// ```
/// use tristrip_lab::traffic::gigabits;
/// // The sum of 3 T over the levels of the published bunny, which is printed as 377.1.
/// assert_eq!(format!("{:.0}", gigabits(3_618_000_000)), "377");
/// ```
pub fn gigabits(vertices: u64) -> f64 {
    (vertices as f64 * VERTEX_BITS as f64) / f64::from(1 << 30)
}

/// Coarsens from the full mesh to the base mesh, passes the cost of each level to `show`, and
/// returns the sums.
///
/// # Errors
/// The errors of [`ProgressiveStrips::new`].
///
/// ```
/// use tristrip::lod::Filter;
/// use tristrip::{CollapseSequence, Rename, Strips};
/// use tristrip_lab::traffic;
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
    mut show: impl FnMut(&LevelTraffic),
) -> Result<TrafficTotals, Error> {
    let model = Arc::new(ProgressiveStrips::new(strips, sequence, Encoding::Naive)?);
    let encoded = ProgressiveStrips::new(strips, sequence, Encoding::Offsets)?;
    let mut cursor = model.cursor();
    let mut counts = FilterCosts::new(cursor.entries());
    let (mut totals, mut split) = (TrafficTotals::default(), None);
    loop {
        let level = cursor.level();
        let triangles = sequence.triangle_count(level)?;
        let now = LevelTraffic { level, triangles, sent: counts.sent(), split };
        show(&now);
        totals.add(&now, sequence.len());
        if !cursor.coarsen() {
            return Ok(totals);
        }
        let level = cursor.level();
        let updates = || model.split(level).into_iter().flatten();
        counts.update(cursor.entries(), updates().flat_map(|update| update.slots));
        split = Some(SplitTraffic {
            vertices: updates().count(),
            naive_slots: model.slot_count(level),
            encoded_slots: encoded.slot_count(level),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::samples;
    use proptest::prelude::*;
    use tristrip::simplify::{SimplifyOptions, simplify_triangles};
    use tristrip::{Method, StripifyOptions, stripify};

    /// At each level of the small free models, each filter sends at most as much as the one before.
    #[test]
    fn filters_are_ordered_over_all_levels() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/models");
        for name in ["catmark_bishop.ply", "fish_control.ply", "hand.ply", "milktruck.glb", "wingnut.ply"] {
            for part in tristrip_io::read_path(folder.join(name)).unwrap().parts {
                let strips =
                    stripify(&part.mesh, &StripifyOptions::default().with_method(Method::STRIPE)).unwrap();
                let options = SimplifyOptions::default();
                let sequence = simplify_triangles(&part.mesh, strips.to_list(), &options).unwrap().sequence;
                let totals = walk(&strips, &sequence, |_| ()).unwrap();
                let [none, stss, dtfs, linked] = Filter::ALL.map(|filter| totals.vertices(filter));
                assert!(none >= stss && stss >= dtfs && dtfs >= linked, "{name}");
                let splits = totals.splits();
                assert!(splits.encoded_slots <= splits.naive_slots, "{name}");
            }
        }
    }

    proptest! {
        #[test]
        fn every_level_costs_what_its_strips_cost(sample in samples()) {
            let (strips, sequence) = (&sample.strips, &sample.sequence);
            let mut levels = Vec::new();
            let totals = walk(strips, sequence, |level| levels.push(*level)).unwrap();
            prop_assert_eq!((levels.len(), totals.levels), (sequence.len() + 1, sequence.len() + 1));
            let model = Arc::new(ProgressiveStrips::new(strips, sequence, Encoding::Offsets).unwrap());
            let mut cursor = model.cursor();
            let mut map = Vec::new();
            for found in &levels {
                prop_assert_eq!(found.level, cursor.level());
                cursor.decode_to(&mut map);
                prop_assert_eq!(found.triangles, sequence.drawn(cursor.level()).unwrap().len());
                for filter in Filter::ALL {
                    prop_assert_eq!(found.sent(filter), filter.sent_by_map(&map));
                }
                let level = cursor.level();
                let slots = (level < sequence.len()).then(|| model.slot_count(level));
                prop_assert_eq!(found.split.map(|split| split.encoded_slots), slots);
                cursor.coarsen();
            }
            for filter in Filter::ALL {
                let sent: u64 = levels.iter().map(|level| level.sent(filter).vertices as u64).sum();
                prop_assert_eq!(totals.vertices(filter), sent);
            }
            let splits: Vec<SplitTraffic> = levels.iter().filter_map(|level| level.split).collect();
            let all = totals.splits();
            prop_assert_eq!(all.splits, sequence.len());
            prop_assert_eq!(all.naive_slots, splits.iter().map(|split| split.naive_slots as u64).sum::<u64>());
            let bytes: usize = splits.iter().map(|split| split.bytes(Encoding::Offsets)).sum();
            prop_assert_eq!(bytes as u64, 12 * all.vertices + 2 * all.encoded_slots);
        }
    }

    #[test]
    fn totals_of_no_strips() {
        let totals = walk(&Strips::default(), &CollapseSequence::default(), |_| ()).unwrap();
        assert_eq!((totals.levels, totals.fraction(Filter::Dtfs).to_bits()), (1, 0));
        assert_eq!(totals.bins()[0].slots_per_split(Encoding::Naive).to_bits(), 0);
    }

    #[test]
    fn the_published_totals_fit_one_unit() {
        // Triangles of the base mesh and of the full mesh, collapses, and the printed Gbit of the
        // progressive mesh.
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
