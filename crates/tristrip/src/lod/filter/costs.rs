//! The cost of all filters over an index map, updated as collapses change it.
//!
//! # Algorithm
//! The map is divided into blocks of 64 entries. For each filter and block, the state of the scan
//! before the block and the cost of the block are stored. A collapse rescans the blocks of its
//! slots, and the following blocks as long as the scan state differs from the stored one. This ends
//! soon, because a new display strip begins where two triangles are not consecutive. The length of
//! the strips therefore does not matter.
//!
//! # Complexity
//! A collapse rescans a few blocks per changed slot. 3 bytes per entry.

use super::{BLOCK, DrawCost, DrawTally, Dtfs, Filter, Gatherer, Linked, Scanner, Stss};

/// The cost of all filters over an index map, updated as the map changes.
///
/// ```
/// use tristrip::lod::{Filter, FilterCosts};
/// let mut map = [0, 1, 2, 3];
/// let mut costs = FilterCosts::new(&map);
/// map[3] = 2;
/// costs.update(&map, &[3]);
/// assert_eq!(costs.sent(), Filter::ALL.map(|filter| filter.sent_by_map(&map)));
/// ```
pub struct FilterCosts {
    none: DrawCost,
    stss: FilterBlocks<Stss>,
    dtfs: FilterBlocks<Dtfs>,
    linked: FilterBlocks<Linked>,
    gatherer: Gatherer,
    touched: Vec<u32>,
}

impl FilterCosts {
    /// Computes the costs for a map.
    ///
    /// ```
    /// use tristrip::lod::FilterCosts;
    /// assert!(FilterCosts::new(&[]).sent().iter().all(|cost| cost.vertices == 0));
    /// ```
    pub fn new(map: &[u32]) -> Self {
        let mut counts = Self {
            none: Filter::None.sent_by_map(map),
            stss: FilterBlocks::new(map),
            dtfs: FilterBlocks::new(map),
            linked: FilterBlocks::new(map),
            gatherer: Gatherer::new(),
            touched: (0..map.len().div_ceil(BLOCK) as u32).collect(),
        };
        counts.scan(map);
        counts
    }

    /// Rescans the blocks whose cost depends on the entries changed since the last call. The length
    /// of the map and its restarts must not change.
    ///
    /// ```
    /// use tristrip::lod::{Filter, FilterCosts};
    /// let mut costs = FilterCosts::new(&[0, 1, 2, 3, 4]);
    /// costs.update(&[0, 1, 2, 2, 2], &[3, 4]);
    /// assert_eq!(costs.sent(), Filter::ALL.map(|filter| filter.sent_by_map(&[0, 1, 2, 2, 2])));
    /// ```
    pub fn update<'a>(&mut self, map: &[u32], slots: impl IntoIterator<Item = &'a u32>) {
        // Filters look up to three entries ahead.
        let blocks = |&slot: &u32| [slot.saturating_sub(3) / BLOCK as u32, slot / BLOCK as u32];
        self.touched.clear();
        self.touched.extend(slots.into_iter().flat_map(blocks));
        self.touched.sort_unstable();
        self.touched.dedup();
        self.scan(map);
    }

    fn scan(&mut self, map: &[u32]) {
        self.stss.update(map, &self.touched, &mut self.gatherer);
        self.dtfs.update(map, &self.touched, &mut self.gatherer);
        self.linked.update(map, &self.touched, &mut self.gatherer);
    }

    /// Returns the cost per filter, in the order of [`Filter::ALL`].
    ///
    /// ```
    /// use tristrip::lod::FilterCosts;
    /// assert_eq!(FilterCosts::new(&[0, 1, 2]).sent().map(|cost| cost.vertices), [3; 4]);
    /// ```
    pub fn sent(&self) -> [DrawCost; 4] {
        [self.none, self.stss.sum.into(), self.dtfs.sum.into(), self.linked.sum.into()]
    }
}

/// The state of a scan before each block and after the last, and the cost of each block and of the
/// end of the map.
struct FilterBlocks<S> {
    scans: Vec<S>,
    tallies: Vec<DrawTally>,
    sum: DrawTally,
}

impl<S: Scanner> FilterBlocks<S> {
    fn new(map: &[u32]) -> Self {
        let count = map.len().div_ceil(BLOCK);
        let (scans, tallies) = (vec![S::default(); count + 1], vec![DrawTally::default(); count + 1]);
        Self { scans, tallies, sum: DrawTally::default() }
    }

    /// Rescans blocks in ascending order. After each, rescans the following ones while their
    /// initial state has changed.
    fn update(&mut self, map: &[u32], touched: &[u32], gatherer: &mut Gatherer) {
        let mut next = 0;
        for &block in touched {
            let mut at = block as usize;
            // A block reached from an earlier one was already rescanned with all its changes.
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
