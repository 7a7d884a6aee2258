//! The neighbours of a triangle, at most three.

use crate::ids::OptionalId;

/// The distinct neighbours of a triangle.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Neighbours([OptionalId; 3]);

impl Neighbours {
    /// Adds a neighbour unless it is known or there are three already.
    pub(super) fn insert(&mut self, other: u32) {
        for slot in &mut self.0 {
            match slot.get() {
                None => return *slot = OptionalId::some(other),
                Some(known) if known == other => return,
                Some(_) => (),
            }
        }
    }

    /// Iterates over the neighbours in insertion order.
    #[inline]
    pub(super) fn iter(self) -> impl Iterator<Item = u32> + use<> {
        self.0.into_iter().map_while(OptionalId::get)
    }
}
