//! How a bound was proven.

/// How a lower bound on strips was proven, from the simplest method to the strongest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum BoundMethod {
    /// A component needs at least one strip.
    OneStrip,
    /// Each polygon with at most one neighbour contains a strip end.
    Leaves,
    /// A maximum matching in each block, and the best use of the bridges between blocks.
    Matching,
    /// A maximum matching, improved by exactly solved subproblems that prove that a block needs
    /// more strips.
    Subproblems,
    /// Every block was solved exactly. A cover with this number of strips exists.
    Exact,
}
