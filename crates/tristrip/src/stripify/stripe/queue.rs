//! A bucket queue of remaining faces, ordered by a small number that changes in small steps. Faces
//! are found and moved in constant time.
//!
//! # Algorithm
//! Each key has a doubly linked list of faces. A face that is added or moved goes to the front or
//! the end of its list: see [`QueueOrder`].
//!
//! # Complexity
//! O(1) for adding, moving and removing. Finding the lowest key is O(1) on average, because keys
//! decrease by one at a time. 12 bytes per face and 8 per key.

use crate::ids::OptionalId;

/// Which of several faces with the lowest key comes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum QueueOrder {
    /// The face whose key changed last: strips start next to earlier ones.
    LastChanged,
    /// The face that has had its key for the longest time.
    FirstIn,
}

/// Faces in the order of their keys, lowest key first.
#[derive(Debug, Clone)]
pub(super) struct BucketQueue {
    order: QueueOrder,
    heads: Vec<OptionalId>,
    tails: Vec<OptionalId>,
    links: Vec<BucketLink>,
    /// All lower buckets are empty.
    least: usize,
}

#[derive(Debug, Clone, Copy, Default)]
struct BucketLink {
    before: OptionalId,
    after: OptionalId,
    /// The bucket of the face, if it is in the queue.
    key: OptionalId,
}

impl BucketQueue {
    pub(super) fn new(order: QueueOrder) -> Self {
        Self { order, heads: Vec::new(), tails: Vec::new(), links: Vec::new(), least: 0 }
    }

    /// Adds a face, or moves it to another bucket or to the front or end of its own.
    pub(super) fn put(&mut self, face: u32, key: u32) {
        self.remove(face);
        let (f, k) = (face as usize, key as usize);
        if f >= self.links.len() {
            self.links.resize(f + 1, BucketLink::default());
        }
        if k >= self.heads.len() {
            self.heads.resize(k + 1, OptionalId::NONE);
            self.tails.resize(k + 1, OptionalId::NONE);
        }
        let (before, after) = match self.order {
            QueueOrder::LastChanged => (OptionalId::NONE, self.heads[k]),
            QueueOrder::FirstIn => (self.tails[k], OptionalId::NONE),
        };
        self.links[f] = BucketLink { before, after, key: OptionalId::some(key) };
        match before.get() {
            Some(before) => self.links[before as usize].after = OptionalId::some(face),
            None => self.heads[k] = OptionalId::some(face),
        }
        match after.get() {
            Some(after) => self.links[after as usize].before = OptionalId::some(face),
            None => self.tails[k] = OptionalId::some(face),
        }
        self.least = self.least.min(k);
    }

    /// Removes a face, if it is in the queue.
    pub(super) fn remove(&mut self, face: u32) {
        let Some(link) = self.links.get_mut(face as usize) else { return };
        let BucketLink { before, after, key } = *link;
        let Some(key) = key.get() else { return };
        link.key = OptionalId::NONE;
        match before.get() {
            Some(before) => self.links[before as usize].after = after,
            None => self.heads[key as usize] = after,
        }
        match after.get() {
            Some(after) => self.links[after as usize].before = before,
            None => self.tails[key as usize] = before,
        }
    }

    /// Returns whether a face is in the queue.
    pub(super) fn contains(&self, face: u32) -> bool {
        self.links.get(face as usize).is_some_and(|link| !link.key.is_none())
    }

    /// Returns the first face with the lowest key.
    pub(super) fn least(&mut self) -> Option<u32> {
        while let Some(head) = self.heads.get(self.least) {
            if let Some(face) = head.get() {
                return Some(face);
            }
            self.least += 1;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn returns_the_face_of_least_key_in_the_order(
            changes in prop::collection::vec((0..20_u32, prop::option::of(0..6_u32)), 1..80),
            is_last_first in any::<bool>(),
        ) {
            let order = if is_last_first { QueueOrder::LastChanged } else { QueueOrder::FirstIn };
            let mut queue = BucketQueue::new(order);
            let mut keys = [None; 20];
            for (time, (face, key)) in (0_i32..).zip(changes) {
                match key {
                    Some(key) => queue.put(face, key),
                    None => queue.remove(face),
                }
                let rank = time * if is_last_first { -1 } else { 1 };
                keys[face as usize] = key.map(|key| (key, rank, face));
                prop_assert_eq!(queue.least(), keys.iter().flatten().min().map(|&(_, _, face)| face));
                prop_assert!((0..20).all(|face| queue.contains(face) == keys[face as usize].is_some()));
            }
        }
    }
}
