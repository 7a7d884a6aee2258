//! A bucket queue: remaining faces ordered by a small number that changes in small steps, each found and moved in constant time.
//!
//! # Algorithm
//! One doubly linked list per key. A face that is added or moved goes to the front of its list, so that among the
//! faces of least key the last one that changed comes first: strips start next to earlier ones.
//!
//! # Complexity
//! O(1) for adding, moving and removing; finding the least key is O(1) on average, because keys fall by one at a time.
//! 12 bytes per face and 4 per key.

use crate::ids::OptionalId;

/// Faces by key, the least first.
#[derive(Debug, Clone, Default)]
pub(super) struct BucketQueue {
    heads: Vec<OptionalId>,
    links: Vec<BucketLink>,
    /// All buckets below this one are empty.
    least: usize,
}

#[derive(Debug, Clone, Copy, Default)]
struct BucketLink {
    before: OptionalId,
    after: OptionalId,
    /// The face's bucket, if it is in the queue.
    key: OptionalId,
}

impl BucketQueue {
    /// Adds a face, or moves it to the front of another bucket.
    pub(super) fn put(&mut self, face: u32, key: u32) {
        self.remove(face);
        let (f, k) = (face as usize, key as usize);
        if f >= self.links.len() {
            self.links.resize(f + 1, BucketLink::default());
        }
        if k >= self.heads.len() {
            self.heads.resize(k + 1, OptionalId::NONE);
        }
        let after = std::mem::replace(&mut self.heads[k], OptionalId::some(face));
        self.links[f] = BucketLink { before: OptionalId::NONE, after, key: OptionalId::some(key) };
        if let Some(after) = after.get() {
            self.links[after as usize].before = OptionalId::some(face);
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
        if let Some(after) = after.get() {
            self.links[after as usize].before = before;
        }
    }

    /// Checks whether a face is in the queue.
    pub(super) fn contains(&self, face: u32) -> bool {
        self.links.get(face as usize).is_some_and(|link| !link.key.is_none())
    }

    /// Returns the face of least key that changed last.
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
        fn returns_the_face_of_least_key_that_changed_last(
            changes in prop::collection::vec((0..20_u32, prop::option::of(0..6_u32)), 1..80),
        ) {
            let mut queue = BucketQueue::default();
            let mut keys = [None; 20];
            for (time, (face, key)) in changes.into_iter().enumerate() {
                match key {
                    Some(key) => queue.put(face, key),
                    None => queue.remove(face),
                }
                keys[face as usize] = key.map(|key| (key, std::cmp::Reverse(time), face));
                prop_assert_eq!(queue.least(), keys.iter().flatten().min().map(|&(_, _, face)| face));
                prop_assert!((0..20).all(|face| queue.contains(face) == keys[face as usize].is_some()));
            }
        }
    }
}
