//! The policies of strip growth: weights of indices and misses, seed strips, horizons, and the
//! policies that an effort tries.

use crate::stripify::Objective;

/// The costs of an index and of a miss.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct PolicyWeights {
    pub(super) index: i64,
    pub(super) miss: i64,
}

/// Strips of another method that growth follows where possible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SeedStrips {
    None,
    Sequential,
    Best,
}

/// A variant of strip growth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct GrowthPolicy {
    pub(super) seeds: SeedStrips,
    pub(super) weights: PolicyWeights,
    /// Number of triangles of a speculative simulation, in sixteenths of the cache entries.
    horizon: u32,
    /// Number of oldest cache entries whose vertices do not justify a restart, in sixteenths of all
    /// entries.
    slack: u32,
}

/// Limits of the horizon, in triangles. Longer simulations take more time without a gain.
pub(super) const MAX_HORIZON: u32 = 64;
const MIN_HORIZON: u32 = 12;

const fn policy(seeds: SeedStrips, index: i64, miss: i64, horizon: u32, slack: u32) -> GrowthPolicy {
    GrowthPolicy { seeds, weights: PolicyWeights { index, miss }, horizon, slack }
}

/// The policies for balanced costs. Every effort uses the first one. Selected on bunny, fandisk,
/// horse and armadillo with a FIFO cache of 16 entries. The weights of growth differ from those of
/// the objective, because seed strips alone save indices.
const BALANCED: [GrowthPolicy; 8] = [
    policy(SeedStrips::None, 8, 1, 32, 2),
    policy(SeedStrips::Sequential, 1, 1, 24, 2),
    policy(SeedStrips::Best, 1, 1, 24, 2),
    policy(SeedStrips::None, 3, 1, 32, 2),
    policy(SeedStrips::Best, 2, 3, 24, 2),
    policy(SeedStrips::Sequential, 2, 3, 24, 2),
    policy(SeedStrips::Best, 1, 1, 40, 2),
    policy(SeedStrips::None, 6, 1, 36, 2),
];

/// The policies for few misses, selected on the same models.
const FEW_MISSES: [GrowthPolicy; 8] = [
    policy(SeedStrips::None, 1, 4, 28, 3),
    policy(SeedStrips::None, 1, 4, 32, 3),
    policy(SeedStrips::None, 1, 4, 28, 4),
    policy(SeedStrips::None, 1, 2, 28, 3),
    policy(SeedStrips::None, 1, 8, 28, 3),
    policy(SeedStrips::None, 1, 4, 24, 3),
    policy(SeedStrips::None, 1, 4, 36, 3),
    policy(SeedStrips::None, 1, 2, 32, 4),
];

impl GrowthPolicy {
    /// Returns the policies of an objective, in the order in which they are tried.
    /// [`Objective::Indices`] grows no strips and has none.
    pub(super) const fn all(objective: Objective) -> &'static [Self] {
        match objective {
            Objective::Indices => &[],
            Objective::Balanced => &BALANCED,
            Objective::Misses => &FEW_MISSES,
        }
    }

    /// Returns the number of triangles of a speculative simulation for a cache.
    pub(super) fn horizon(self, entry_count: u32) -> u32 {
        (entry_count.saturating_mul(self.horizon) / 16).clamp(MIN_HORIZON, MAX_HORIZON)
    }

    /// Returns the number of oldest cache entries whose vertices do not justify a restart.
    pub(super) fn slack(self, entry_count: u32) -> u32 {
        entry_count.saturating_mul(self.slack) / 16
    }

    /// Replaces the weights.
    #[cfg(test)]
    pub(super) fn with_weights(self, weights: PolicyWeights) -> Self {
        Self { weights, ..self }
    }
}

impl PolicyWeights {
    /// Returns the weights of an objective.
    pub(super) fn of(objective: Objective) -> Self {
        match objective {
            Objective::Indices => Self { index: 10, miss: 1 },
            Objective::Balanced => Self { index: 3, miss: 2 },
            Objective::Misses => Self { index: 1, miss: 4 },
        }
    }
}
