//! The neighbours of a triangle, at most three.

use crate::ids::OptionalId;

/// The distinct neighbours of a triangle.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Neighbours([OptionalId; 3]);

impl Neighbours {
    /// Adds a neighbour. One that is known, and any after the third, is not added.
    pub(super) fn insert(&mut self, other: u32) {
        for slot in &mut self.0 {
            match slot.get() {
                None => return *slot = OptionalId::some(other),
                Some(known) if known == other => return,
                Some(_) => (),
            }
        }
    }

    /// Iterates over the neighbours in the order in which they were added.
    #[inline]
    pub(super) fn iter(self) -> impl Iterator<Item = u32> + use<> {
        self.0.into_iter().map_while(OptionalId::get)
    }
}
