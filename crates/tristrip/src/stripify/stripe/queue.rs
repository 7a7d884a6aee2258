//! A bucket queue: pieces ordered by a small number that changes by little, each found and moved in constant time.
//!
//! # Algorithm
//! One doubly linked list for each key. A piece that is added or moved goes to the front of its list, so that of several
//! pieces of least key the one that changed last comes first: strips start beside those that were laid before.
//!
//! # Complexity
//! O(1) for adding, moving and taking away; finding the least key is O(1) on average, as keys fall by one at a time.
//! 12 bytes a piece and 4 for each key.

const NONE: u32 = u32::MAX;

/// Pieces by key, the least first.
#[derive(Debug, Clone, Default)]
pub(super) struct BucketQueue {
    heads: Vec<u32>,
    links: Vec<Link>,
    /// No bucket below this one has a piece.
    least: usize,
}

#[derive(Debug, Clone, Copy)]
struct Link {
    before: u32,
    after: u32,
    /// The piece's bucket; `NONE` where it is not in the queue.
    key: u32,
}

impl BucketQueue {
    /// Adds a piece, or moves it to the front of another bucket.
    pub(super) fn put(&mut self, piece: u32, key: u32) {
        self.remove(piece);
        let (p, k) = (piece as usize, key as usize);
        if p >= self.links.len() {
            self.links.resize(p + 1, Link { before: NONE, after: NONE, key: NONE });
        }
        if k >= self.heads.len() {
            self.heads.resize(k + 1, NONE);
        }
        let after = std::mem::replace(&mut self.heads[k], piece);
        self.links[p] = Link { before: NONE, after, key };
        if let Some(link) = self.links.get_mut(after as usize) {
            link.before = piece;
        }
        self.least = self.least.min(k);
    }

    /// Takes a piece out, if it is in.
    pub(super) fn remove(&mut self, piece: u32) {
        let Some(link) = self.links.get_mut(piece as usize) else { return };
        let Link { before, after, key } = *link;
        if key == NONE {
            return;
        }
        link.key = NONE;
        match self.links.get_mut(before as usize) {
            Some(link) => link.after = after,
            None => self.heads[key as usize] = after,
        }
        if let Some(link) = self.links.get_mut(after as usize) {
            link.before = before;
        }
    }

    /// Tells whether a piece is in the queue.
    pub(super) fn contains(&self, piece: u32) -> bool {
        self.links.get(piece as usize).is_some_and(|link| link.key != NONE)
    }

    /// Gives a piece of least key.
    pub(super) fn least(&mut self) -> Option<u32> {
        while let Some(&head) = self.heads.get(self.least) {
            if head != NONE {
                return Some(head);
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
        fn gives_the_least_key_as_a_scan_does(
            changes in prop::collection::vec((0..20_u32, prop::option::of(0..6_u32)), 1..80),
        ) {
            let mut queue = BucketQueue::default();
            let mut keys = [None; 20];
            for (piece, key) in changes {
                match key {
                    Some(key) => queue.put(piece, key),
                    None => queue.remove(piece),
                }
                keys[piece as usize] = key;
                let found = queue.least();
                prop_assert_eq!(found.map(|p| keys[p as usize]), keys.iter().flatten().min().map(|&k| Some(k)));
                prop_assert!((0..20).all(|p| queue.contains(p) == keys[p as usize].is_some()));
            }
        }
    }
}
