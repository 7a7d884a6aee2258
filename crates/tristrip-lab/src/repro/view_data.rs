//! Views of Skip Strips as data: how much detail they have, and from where they are seen.

use serde::Deserialize;
use tristrip::simplify::MergeOrder;

use crate::flight::{Axis, Stop};

/// A view of a model, in a row of a table.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PublishedView {
    /// The published number of triangles of its frame.
    pub(crate) triangles: usize,
    /// The vertical axis of the measured file.
    pub(crate) up: Axis,
}

/// How much detail the frames of a flight around a vertical axis have: published triangles of those
/// of the full mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Detail {
    pub(crate) triangles: usize,
    pub(crate) of: usize,
    pub(crate) up: Axis,
}

/// The order of the collapses in each level of a merge tree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum TreeOrder {
    /// As published.
    ShortestEdge,
    /// Ours.
    Quadric,
}

impl From<TreeOrder> for MergeOrder {
    fn from(order: TreeOrder) -> Self {
        match order {
            TreeOrder::ShortestEdge => Self::ShortestEdge,
            TreeOrder::Quadric => Self::Quadric,
        }
    }
}

/// A picture of a view, in a sheet of several.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ViewPanel {
    /// The detail in percent of the triangles of the full mesh; the full mesh for 100.
    pub(crate) percent: f64,
    /// The camera that needs this detail.
    pub(crate) camera: Stop,
    /// The camera of the picture, if it is another one.
    pub(crate) seen_from: Option<Stop>,
    /// Whether each strip has a colour; otherwise the surface has one.
    pub(crate) strips: bool,
}
