//! The policies of the greedy stripper: seed order, swaps, time of triangulation and look-ahead.

/// Cost of a strip in addition to one index per triangle: two vertices and the restart.
pub(super) const STRIP_COST: u32 = 3;

/// Which free triangle seeds the next strip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SeedOrder {
    /// The last added of the triangles with the fewest free neighbours.
    LastAdded,
    /// The first added of the triangles with the fewest free neighbours.
    FirstAdded,
    /// The first in input order.
    Input,
}

/// When a run takes a swap.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SwapPolicy {
    /// Where it saves the end of a strip, and at a dead end.
    Lookahead,
    /// At a dead end: where the run can continue only by a swap.
    DeadEnd,
    /// Never.
    Never,
}

/// When polygons are triangulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PolygonCuts {
    /// In advance.
    Before,
    /// When a strip enters.
    OnEntry,
}

/// A variant of the greedy stripper.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Policy {
    pub(super) seeds: SeedOrder,
    pub(super) swaps: SwapPolicy,
    pub(super) cuts: PolygonCuts,
    /// Maximum number of triangles of a tentative run.
    pub(super) lookahead: u32,
}

impl Policy {
    /// The best policy on irregular meshes. A longer look-ahead gains nothing there and takes more
    /// time.
    pub(super) const DEFAULT: Self = Self {
        seeds: SeedOrder::LastAdded,
        swaps: SwapPolicy::Lookahead,
        cuts: PolygonCuts::OnEntry,
        lookahead: 16,
    };
    /// The default with a longer look-ahead, for regular meshes. The limit also bounds the time.
    const LONG: Self = Self { lookahead: 512, ..Self::DEFAULT };
    /// The other policies. Each is the best on some regular or small mesh.
    pub(super) const ALTERNATIVES: [Self; 5] = [
        Self::LONG,
        Self { seeds: SeedOrder::Input, ..Self::LONG },
        Self { seeds: SeedOrder::Input, swaps: SwapPolicy::DeadEnd, ..Self::LONG },
        Self { seeds: SeedOrder::FirstAdded, swaps: SwapPolicy::Never, ..Self::LONG },
        Self { seeds: SeedOrder::Input, swaps: SwapPolicy::Never, ..Self::LONG },
    ];
    /// Further policies for polygons: some quadrilateral grids align better when triangulated in
    /// advance.
    pub(super) const POLYGON_ALTERNATIVES: [Self; 2] = [
        Self { cuts: PolygonCuts::Before, ..Self::LONG },
        Self { seeds: SeedOrder::Input, cuts: PolygonCuts::Before, ..Self::LONG },
    ];
}
