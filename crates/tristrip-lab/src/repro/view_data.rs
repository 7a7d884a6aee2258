//! Views of Skip Strips as data: their detail and their cameras.

use serde::Deserialize;
use tristrip::simplify::MergeOrder;

use crate::flight::{Axis, Stop};

/// A view of a model, in a row of a table.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PublishedView {
    /// The published number of triangles of the frame.
    pub(crate) triangles: usize,
    /// The vertical axis of the measured file.
    pub(crate) up: Axis,
}

/// The detail of the frames of a flight around a vertical axis: the published number of triangles,
/// out of that of the full mesh.
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
    /// By quadric errors, as in this project.
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

/// An image of a view, in a sheet of several images.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ViewPanel {
    /// The detail in percent of the triangles of the full mesh; 100 is the full mesh.
    pub(crate) percent: f64,
    /// The camera that decides the detail.
    pub(crate) camera: Stop,
    /// The camera of the image, if it differs.
    pub(crate) seen_from: Option<Stop>,
    /// Whether each strip has its own colour; otherwise the surface has one colour.
    pub(crate) strips: bool,
}
