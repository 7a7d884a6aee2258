//! Variants of STRIPE and of the SGI algorithm.

use crate::names::names;

/// When STRIPE triangulates polygons (Evans et al. 1996, section 3.1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum FaceTriangulation {
    /// In advance, by alternate left and right turns.
    Static,
    /// Completely, when a strip enters the face.
    #[default]
    Whole,
    /// Only as far as needed for the strip to leave the face over the chosen edge.
    Partial,
    /// Like [`Self::Partial`], but the remainder of a polygon joins the strip if it would keep
    /// fewer than two free neighbours. Not in the paper.
    Absorbing,
}

/// How STRIPE breaks ties between neighbours with the lowest adjacency (Evans et al. 1996, section
/// 3.1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Ties {
    /// The first neighbour found.
    Arbitrary,
    /// The neighbour whose own neighbours have the lowest adjacency.
    LookAhead,
    /// The neighbour on the side opposite to the previous turn.
    Alternate,
    /// A random neighbour, depending on the seed.
    Random,
    /// A neighbour that needs no swap, otherwise a random one.
    #[default]
    Sequential,
    /// A neighbour that needs the fewest swaps. Not in the paper.
    FewestSwaps,
}

/// Which neighbour is chosen if the look-ahead leaves a tie. The papers do not specify this.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum LastTie {
    /// The first neighbour, in winding order from the entry edge.
    First,
    /// The last neighbour, in winding order from the entry edge.
    #[default]
    Last,
}

/// How STRIPE turns patches into strips (Evans et al. 1996, section 3.2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Patches {
    /// One strip per row or per column, whichever is longer.
    #[default]
    Rows,
    /// One strip per patch, extended backward and forward.
    Full,
}

names! {
    "tristrip::stripify::FaceTriangulation", FaceTriangulation, "triangulation",
    Static => "static", "In advance, by alternate left and right turns";
    Whole => "whole", "Completely, when a strip enters the face";
    Partial => "partial", "Only as far as the strip needs to leave the face";
    Absorbing => "absorbing", "Partial, plus remainders with fewer than two neighbours (not in the paper)";
}

names! {
    "tristrip::stripify::Ties", Ties, "ties",
    Arbitrary => "arbitrary", "The first one found";
    LookAhead => "look-ahead", "The one whose neighbours have the lowest adjacency";
    Alternate => "alternate", "The one on the side opposite to the previous turn";
    Random => "random", "A random one, depending on the seed";
    Sequential => "sequential", "One that needs no swap, otherwise a random one";
    FewestSwaps => "fewest-swaps", "One that needs the fewest swaps (not in the paper)";
}

names! {
    "tristrip::stripify::LastTie", LastTie, "last tie",
    First => "first", "The first after the entry";
    Last => "last", "The last after the entry";
}

names! {
    "tristrip::stripify::Patches", Patches, "patches",
    Rows => "rows", "One strip per row or column";
    Full => "full", "One strip per patch, extended at both ends";
}
