//! How a bound was proven.

/// How a lower bound on strips was proven, from the simplest method to the strongest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum BoundMethod {
    /// A component needs at least one strip.
    OneStrip,
    /// Polygons with at most one neighbour each contain an end of a strip.
    Leaves,
    /// A maximum matching in each block, and the best use of the bridges between blocks.
    Matching,
    /// The same, and subproblems of a block that were solved exactly and show that the block needs
    /// more strips.
    Subproblems,
    /// Every block was solved exactly: a cover with this number of strips exists.
    Exact,
}
