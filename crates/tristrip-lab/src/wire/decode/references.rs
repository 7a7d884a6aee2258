//! The symbols of a received map: each must lead, over any number of others, to a vertex of its
//! strip.

use tristrip::lod::{RESTART, encoded_offset};

/// Returns the first slot whose reference leaves its strip or forms a cycle. Takes linear time:
/// slots that lead to a vertex are not followed again.
pub(super) fn first_without_vertex(entries: &[u32]) -> Option<usize> {
    // For each slot, the slot from which it was followed, plus one; 0 if it was not followed.
    let mut followed_from = vec![0_u32; entries.len()];
    for slot in 0..entries.len() {
        let (mut at, mark) = (slot, slot as u32 + 1);
        while let Some(offset) = encoded_offset(entries[at]) {
            match followed_from[at] {
                0 => followed_from[at] = mark,
                other if other == mark => return Some(slot),
                _ => break,
            }
            let Some(target) = target(entries, at, offset) else { return Some(at) };
            at = target;
        }
    }
    None
}

/// Returns the slot at an offset, if it is in the same strip.
fn target(entries: &[u32], slot: usize, offset: i8) -> Option<usize> {
    let between = slot.checked_add_signed(offset.signum().into())?;
    let target = slot.checked_add_signed(offset.into())?;
    let is_inside = *entries.get(target)? != RESTART && *entries.get(between)? != RESTART;
    is_inside.then_some(target)
}
