//! Options of `repair`: the amount of search, the seed, and the cost to minimize.

use crate::effort::Effort;
use crate::strip::Cost;

/// How much to search next to a change, and at a level that is computed directly.
#[derive(Debug, Clone, Copy)]
pub(super) struct SearchAmount {
    /// The number of triangles next to a change to search from.
    pub(super) near: usize,
    /// The number of searches from each of them.
    pub(super) rounds: u32,
    /// The number of searches from each triangle of a level that is computed directly.
    pub(super) all_rounds: u32,
}

/// The amount of search by effort. Tuned on the bunny.
pub(super) const SEARCH_AMOUNTS: [SearchAmount; 10] = [
    SearchAmount { near: 6, rounds: 1, all_rounds: 0 },
    SearchAmount { near: 12, rounds: 1, all_rounds: 1 },
    SearchAmount { near: 24, rounds: 1, all_rounds: 4 },
    SearchAmount { near: 40, rounds: 2, all_rounds: 12 },
    SearchAmount { near: 80, rounds: 2, all_rounds: 36 },
    SearchAmount { near: 120, rounds: 3, all_rounds: 100 },
    SearchAmount { near: 160, rounds: 4, all_rounds: 200 },
    SearchAmount { near: 240, rounds: 6, all_rounds: 400 },
    SearchAmount { near: 400, rounds: 6, all_rounds: 800 },
    SearchAmount { near: 640, rounds: 8, all_rounds: 1600 },
];

/// The options of [`Repair`](super::Repair).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
#[non_exhaustive]
pub struct RepairOptions {
    /// The search effort next to each change.
    pub effort: Effort,
    /// Seed for the random number generator.
    pub seed: u64,
    /// The cost to minimize; see [`RepairOptions::with_cost`].
    pub cost: Cost,
}

/// The default effort, seed 0, and the cost [`Cost::OpenGl`].
impl Default for RepairOptions {
    fn default() -> Self {
        Self { effort: Effort::default(), seed: 0, cost: Cost::OpenGl }
    }
}

impl RepairOptions {
    crate::setters! {
        /// Sets the search effort next to each change. Effort 0 disables the search when strips are
        /// computed directly for a level.
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// let sent = |effort| repaired(RepairOptions::default().with_effort(effort)).map(|strips| strips.vertices_sent());
        /// assert!(sent(Effort::MAX)? < sent(Effort::new(0).unwrap())?);
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_effort(effort: Effort);

        /// Sets the seed for the random number generator.
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// let strips = |seed| repaired(RepairOptions::default().with_seed(seed));
        /// assert_ne!(strips(1)?, strips(2)?);
        /// assert_eq!(strips(2)?, strips(2)?);
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_seed(seed: u64);

        /// Sets the cost to minimize. [`Cost::OpenGl`], the default, counts vertices sent.
        /// [`Cost::Restart`] and [`Cost::Degenerate`] also count an index between strips.
        /// [`Cost::Gl`] is treated as [`Cost::OpenGl`].
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// let count = |cost| repaired(RepairOptions::default().with_cost(cost)).map(|strips| strips.len());
        /// // With an index between strips, fewer strips with more swaps are better.
        /// assert!(count(Cost::Restart)? < count(Cost::OpenGl)?);
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_cost(cost: Cost);
    }
}
