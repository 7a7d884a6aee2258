//! The best known collapse of a point.

use crate::ids::OptionalId;

/// The best known collapse of a point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BestCollapse {
    /// Its cost; infinite if no collapse is possible.
    pub(crate) cost: f32,
    /// The point that it collapses to, if it was priced.
    pub(crate) target: OptionalId,
    /// The error of this collapse, in units of the frame.
    pub(crate) error: f32,
    /// The last pass in which the neighbourhood of the point changed.
    pub(crate) changed: u32,
}

impl BestCollapse {
    /// No collapse is possible.
    pub(crate) const NONE: Self =
        Self { cost: f32::INFINITY, target: OptionalId::NONE, error: 0.0, changed: 0 };

    /// Sets the best collapse; `None` if none is possible.
    pub(crate) fn set_price(&mut self, best: Option<PricedCollapse>) {
        match best {
            None => (self.cost, self.target) = (f32::INFINITY, OptionalId::NONE),
            Some(PricedCollapse { to, cost, error }) => {
                (self.cost, self.target, self.error) = (cost, OptionalId::some(to), error);
            }
        }
    }

    /// Returns whether a collapse is possible.
    pub(crate) fn is_possible(&self) -> bool {
        self.cost < f32::INFINITY
    }
}

/// A collapse with its price.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PricedCollapse {
    pub(crate) to: u32,
    pub(crate) cost: f32,
    /// The distance between the surfaces, in units of the frame.
    pub(crate) error: f32,
}

/// Converts a number to `f32`, clamped to finite values.
pub(crate) fn finite(x: f64) -> f32 {
    x.min(f64::from(f32::MAX)) as f32
}
