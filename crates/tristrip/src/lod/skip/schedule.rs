//! When the collapses of a view have to be looked at again.
//!
//! Each collapse that a view might change next waits for an amount of travel before which its choice cannot change. Buckets hold those of nearly the same
//! amount, so that a frame looks only at expired entries: near the limits of its choice, in the direction of the camera's way.
//!
//! ```text
//! travel    ──────────▶ now
//! buckets   … empty … │ expired │     │     │     │ … the last one: all that expire later
//! ```
//! # Complexity
//! Constant time per entry. 4 bytes per vertex, and per entry.

/// The number of buckets.
const BUCKETS: u64 = 1024;
/// The travel per bucket, in diameters of the model: a camera that moves by a hundredth of the model per frame passes 20 of them.
const BUCKETS_PER_DIAMETER: f64 = 2048.0;

/// The longest travel, in buckets: less than a millionth of a bucket is lost in rounding.
const LONGEST: f64 = (1_u64 << 32) as f64;

/// The position of entries that expire with any travel.
const NEXT_TRAVEL: u32 = u32::MAX;
/// The position of entries that have expired.
const EXPIRED: u32 = u32::MAX - 1;

/// The entries that wait.
#[derive(Debug, Clone)]
pub(super) struct Schedule {
    /// The travel so far.
    travel: f64,
    /// The travel per bucket.
    width: f64,
    /// The number of the last bucket that was emptied.
    passed: u64,
    buckets: Vec<Vec<u32>>,
    /// Entries that expire with any travel, since they may do so before the current bucket is passed.
    soon: Vec<u32>,
    /// Entries that expire with the next advance.
    left: Vec<u32>,
    /// Where the only valid entry of each node is: in the bucket of this slot plus 1, [`NEXT_TRAVEL`], or [`EXPIRED`]; 0 if it has none.
    waits: Vec<u32>,
}

impl Schedule {
    /// Creates a schedule without entries for a model of this radius.
    pub(super) fn new(node_count: usize, radius: f64) -> Self {
        let diameter = 2.0 * radius;
        Self {
            travel: 0.0,
            width: if diameter > 0.0 { diameter / BUCKETS_PER_DIAMETER } else { 1.0 },
            passed: 0,
            buckets: vec![Vec::new(); BUCKETS as usize],
            soon: Vec::new(),
            left: Vec::new(),
            waits: vec![0; node_count],
        }
    }

    /// Removes all entries.
    pub(super) fn clear(&mut self) {
        self.buckets.iter_mut().for_each(Vec::clear);
        self.soon.clear();
        self.left.clear();
        self.waits.fill(0);
        (self.travel, self.passed) = (0.0, 0);
    }

    /// Adds travel, and moves the entries that expire to `expired`, and those that were left to `left`.
    pub(super) fn advance(&mut self, travel: f64, expired: &mut Vec<u32>, left: &mut Vec<u32>) {
        self.travel += travel;
        let reached = self.bucket_at(self.travel);
        let passed = self.passed..reached.min(self.passed + BUCKETS);
        self.passed = reached;
        left.append(&mut self.left);
        if travel > 0.0 {
            self.soon.drain(..).for_each(|node| take_valid(node, NEXT_TRAVEL, &mut self.waits, expired));
        }
        for number in passed.map(|number| number + 1) {
            let slot = (number % BUCKETS) as u32;
            let bucket = &mut self.buckets[slot as usize];
            bucket.drain(..).for_each(|node| take_valid(node, slot + 1, &mut self.waits, expired));
        }
    }

    /// Checks whether everything expires within a travel, or the travel so far is so long that more of it would be lost in rounding: then all entries are to be
    /// removed instead.
    pub(super) fn ends_with(&self, travel: f64) -> bool {
        travel >= self.width * BUCKETS as f64 || self.travel >= self.width * LONGEST
    }

    /// Returns the number of the bucket at a travel, which is not negative.
    #[allow(clippy::cast_sign_loss, reason = "not negative")]
    fn bucket_at(&self, travel: f64) -> u64 {
        (travel / self.width) as u64
    }

    /// Lets a node wait for a travel from now on.
    pub(super) fn wait(&mut self, node: u32, travel: f64) {
        let number = self.bucket_at(self.travel + travel);
        let slot = (number.min(self.passed + BUCKETS) % BUCKETS) as u32;
        let place = if number <= self.passed { NEXT_TRAVEL } else { slot + 1 };
        // An entry in the same place is there already.
        if std::mem::replace(&mut self.waits[node as usize], place) == place {
            return;
        }
        if place == NEXT_TRAVEL { self.soon.push(node) } else { self.buckets[slot as usize].push(node) }
    }

    /// Removes the entry of a node, if it has one.
    pub(super) fn cancel(&mut self, node: u32) {
        self.waits[node as usize] = 0;
    }

    /// Checks whether the expired entry of a node was not removed.
    pub(super) fn has_expired(&self, node: u32) -> bool {
        self.waits[node as usize] == EXPIRED
    }

    /// Lets the entries of nodes expire now.
    pub(super) fn expire(&mut self, nodes: &[u32]) {
        nodes.iter().for_each(|&node| self.waits[node as usize] = EXPIRED);
    }

    /// Leaves nodes to the next advance, whatever the travel.
    pub(super) fn leave(&mut self, nodes: impl Iterator<Item = u32>) {
        self.left.extend(nodes);
    }

    /// Counts the nodes that are left to the next advance.
    pub(super) fn left_count(&self) -> usize {
        self.left.len()
    }

    pub(super) fn memory(&self) -> usize {
        let entries: usize = self.buckets.iter().map(Vec::capacity).sum();
        size_of_val(&self.waits[..])
            + size_of::<u32>() * (entries + self.soon.capacity() + self.left.capacity())
    }
}

/// Appends a node that has its valid entry in a place, which expires then.
fn take_valid(node: u32, place: u32, waits: &mut [u32], expired: &mut Vec<u32>) {
    let waits = &mut waits[node as usize];
    if *waits == place {
        *waits = EXPIRED;
        expired.push(node);
    }
}
