//! Letters: how a strip turns, and which order of turns inside polygons costs the fewest swaps.
//!
//! A strip runs between two chains of vertices, A and B. Each triangle advances on one of them, its *letter*; a swap is due
//! wherever two letters in a row are equal. A polygon fixes only how many letters of each kind lie between its entry and its
//! exit, and leaves their order free.
//!
//! ```text
//!         b'─────b''         entry b → a; chain A: a, a'; chain B: b, b', b''
//!        ╱      ╱            one A and two B between the entry and the exit a' → b'': as B A B without a swap
//!       b ──▶ a ── a'
//! ```
//!
//! # Algorithm
//! The least number of swaps up to an edge, for either last letter, follows from that at the edge before (Viterbi 1967): so a
//! walk knows at each face what every exit costs, and the orders of all polygons of a strip are chosen together at its end.
//!
//! # Complexity
//! O(1) for each face.

/// The letter of a triangle that advances on chain A, the one on the side of the entry's head.
pub(super) const A: usize = 0;
/// The letter of a triangle that advances on chain B.
pub(super) const B: usize = 1;

/// How many triangles advance on chain A and on chain B.
pub(super) type Counts = [u32; 2];

/// Stands for what cannot be; small enough to be added to.
const NEVER: u32 = u32::MAX / 4;

/// The least number of swaps so far, by the last letter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Swaps(pub(super) [u32; 2]);

impl Swaps {
    /// At the exit of a strip's first face, where any order may be chosen.
    pub(super) const FREE: Self = Self([0, 0]);

    /// Gives the swaps at the exit of a face, by its counts and the swaps at its entry.
    pub(super) fn through(self, counts: Counts) -> Self {
        Self([A, B].map(|last| {
            [A, B]
                .map(|before| self.0[before] + least(counts, before, last))
                .into_iter()
                .min()
                .unwrap_or(NEVER)
        }))
    }

    /// Gives the lesser of the two numbers.
    pub(super) fn least(self) -> u32 {
        self.0[A].min(self.0[B])
    }

    /// Gives the letter of the lesser number.
    pub(super) fn letter(self) -> usize {
        usize::from(self.0[B] < self.0[A])
    }
}

/// Counts the runs of each letter when an order has as many as it can, for given first and last letters.
fn runs(counts: Counts, first: usize, last: usize) -> Option<Counts> {
    let other = 1 - first;
    let mut runs = [0; 2];
    if first == last {
        runs[other] = counts[other].min(counts[first].checked_sub(1)?);
        runs[first] = runs[other] + 1;
    } else {
        runs = [counts[A].min(counts[B]); 2];
    }
    // Every letter that is there makes at least one run.
    let possible = [A, B].iter().all(|&x| (counts[x] == 0) == (runs[x] == 0));
    (possible && runs[last] > 0).then_some(runs)
}

/// Gives the first letter and the swaps of the best order after the letter `before` that ends in `last`.
fn best(counts: Counts, before: usize, last: usize) -> Option<(usize, u32)> {
    // The letter that needs no swap is tried first.
    [1 - before, before]
        .into_iter()
        .filter_map(|first| {
            let runs = runs(counts, first, last)?;
            Some((first, counts[A] + counts[B] - runs[A] - runs[B] + u32::from(first == before)))
        })
        .min_by_key(|&(_, swaps)| swaps)
}

/// Counts the swaps of the best order of letters after the letter `before` that ends in `last`.
pub(super) fn least(counts: Counts, before: usize, last: usize) -> u32 {
    best(counts, before, last).map_or(NEVER, |(_, swaps)| swaps)
}

/// Appends the best order of letters after the letter `before` that ends in `last`.
pub(super) fn spell(counts: Counts, before: usize, last: usize, out: &mut Vec<usize>) {
    let Some((first, _)) = best(counts, before, last) else { return };
    let Some(runs) = runs(counts, first, last) else { return };
    // What does not alternate is put into each letter's first run.
    let mut surplus = [counts[A] - runs[A], counts[B] - runs[B]];
    let mut letter = first;
    for _ in 0..runs[A] + runs[B] {
        out.extend(std::iter::repeat_n(letter, 1 + std::mem::take(&mut surplus[letter]) as usize));
        letter = 1 - letter;
    }
}

/// Counts the letters of an alternating order of `length` that begins with `first`.
pub(super) fn alternating(length: u32, first: usize) -> Counts {
    let mut counts = [length / 2; 2];
    counts[first] += length % 2;
    counts
}

/// Gives the last of `length` letters that alternate after the letter `before`; that letter itself where there is none.
pub(super) fn alternate(before: usize, length: u32) -> usize {
    if length.is_multiple_of(2) { before } else { 1 - before }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn swaps(letters: &[usize]) -> u32 {
        letters.windows(2).filter(|w| w[0] == w[1]).count() as u32
    }

    /// Tries every order of the letters.
    fn naive(counts: Counts, before: usize, last: usize) -> u32 {
        let length = counts[A] + counts[B];
        let orders = (0..1_u32 << length).filter(|bits| bits.count_ones() == counts[B]).map(|bits| {
            std::iter::once(before).chain((0..length).map(|i| (bits >> i & 1) as usize)).collect::<Vec<_>>()
        });
        orders.filter(|o| o.len() > 1 && o.last() == Some(&last)).map(|o| swaps(&o)).min().unwrap_or(NEVER)
    }

    #[test]
    fn spells_the_orders_with_the_fewest_swaps() {
        for case in 0..6 * 6 * 4 {
            let (counts, before, last) =
                ([case / 4 % 6, case / 24], case as usize % 2, case as usize / 2 % 2);
            let expected = naive(counts, before, last);
            assert_eq!(least(counts, before, last), expected, "{counts:?} {before} {last}");
            let mut letters = vec![before];
            spell(counts, before, last, &mut letters);
            if expected != NEVER {
                assert_eq!((swaps(&letters), letters.last()), (expected, Some(&last)));
                assert_eq!([A, B].map(|x| letters[1..].iter().filter(|&&l| l == x).count() as u32), counts);
            }
        }
    }
}
