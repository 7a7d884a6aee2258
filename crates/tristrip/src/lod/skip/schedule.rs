//! The schedule of a view: when each collapse must be evaluated again.
//!
//! Each collapse that can change next has an entry with a camera travel. Its choice cannot change
//! before the camera has moved by this travel. Entries with nearly the same travel share a bucket.
//! A frame evaluates only the expired entries: collapses close to a threshold in the direction of
//! the camera movement.
//!
//! ```text
//! travel    ──────────▶ now
//! buckets   … empty … │ expired │     │     │     │ … the last one: all that expire later
//! ```
//! # Complexity
//! Constant time per entry. 4 bytes per vertex and 4 per entry.

/// The number of buckets.
const BUCKETS: u64 = 1024;
/// The number of buckets per travel of one model diameter. A camera that moves by 1/100 of the
/// model per frame passes 20 of them.
const BUCKETS_PER_DIAMETER: f64 = 2048.0;

/// The maximum travel in buckets. Up to there, rounding loses less than a millionth of a bucket.
const LONGEST: f64 = (1_u64 << 32) as f64;

/// The position of entries that expire with any travel.
const NEXT_TRAVEL: u32 = u32::MAX;
/// The position of entries that have expired.
const EXPIRED: u32 = u32::MAX - 1;

/// The pending entries.
#[derive(Debug, Clone)]
pub(super) struct Schedule {
    /// The travel so far.
    travel: f64,
    /// The travel per bucket.
    width: f64,
    /// The number of the last bucket that was emptied.
    passed: u64,
    buckets: Vec<Vec<u32>>,
    /// Entries that expire with any travel, because they may expire within the current bucket.
    soon: Vec<u32>,
    /// Entries that expire with the next advance, whatever its travel.
    left: Vec<u32>,
    /// The position of the only valid entry of each node: its bucket slot plus 1, [`NEXT_TRAVEL`]
    /// or [`EXPIRED`]; 0 if it has no entry.
    waits: Vec<u32>,
}

impl Schedule {
    /// Creates an empty schedule for a model of this radius.
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

    /// Adds travel, and moves the expired entries to `expired` and the deferred nodes to `left`.
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

    /// Checks whether everything would expire within a travel, or the travel so far is too long to
    /// be added to without rounding errors. In both cases all entries must be removed instead.
    pub(super) fn ends_with(&self, travel: f64) -> bool {
        travel >= self.width * BUCKETS as f64 || self.travel >= self.width * LONGEST
    }

    /// Returns the index of the bucket for a travel of at least 0.
    #[allow(clippy::cast_sign_loss, reason = "not negative")]
    fn bucket_at(&self, travel: f64) -> u64 {
        (travel / self.width) as u64
    }

    /// Adds an entry for a node that expires after a travel from now.
    pub(super) fn wait(&mut self, node: u32, travel: f64) {
        let number = self.bucket_at(self.travel + travel);
        let slot = (number.min(self.passed + BUCKETS) % BUCKETS) as u32;
        let place = if number <= self.passed { NEXT_TRAVEL } else { slot + 1 };
        // There is already an entry in the same position.
        if std::mem::replace(&mut self.waits[node as usize], place) == place {
            return;
        }
        if place == NEXT_TRAVEL { self.soon.push(node) } else { self.buckets[slot as usize].push(node) }
    }

    /// Removes the entry of a node, if it has one.
    pub(super) fn cancel(&mut self, node: u32) {
        self.waits[node as usize] = 0;
    }

    /// Checks whether the entry of a node has expired and was not removed.
    pub(super) fn has_expired(&self, node: u32) -> bool {
        self.waits[node as usize] == EXPIRED
    }

    /// Marks the entries of nodes as expired.
    pub(super) fn expire(&mut self, nodes: &[u32]) {
        nodes.iter().for_each(|&node| self.waits[node as usize] = EXPIRED);
    }

    /// Defers nodes to the next advance, whatever its travel.
    pub(super) fn leave(&mut self, nodes: impl Iterator<Item = u32>) {
        self.left.extend(nodes);
    }

    /// Returns the number of nodes deferred to the next advance.
    pub(super) fn left_count(&self) -> usize {
        self.left.len()
    }

    pub(super) fn memory(&self) -> usize {
        let entries: usize = self.buckets.iter().map(Vec::capacity).sum();
        size_of_val(&self.waits[..])
            + size_of::<u32>() * (entries + self.soon.capacity() + self.left.capacity())
    }
}

/// Appends a node whose valid entry is in this position, and marks it as expired.
fn take_valid(node: u32, place: u32, waits: &mut [u32], expired: &mut Vec<u32>) {
    let waits = &mut waits[node as usize];
    if *waits == place {
        *waits = EXPIRED;
        expired.push(node);
    }
}
