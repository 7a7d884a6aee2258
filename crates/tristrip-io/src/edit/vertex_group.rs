//! Parts that share vertices, and the new indices of these vertices.

use tristrip::VertexOrder;

use crate::error::Error;

/// Parts that share vertices, and the new order of these vertices.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VertexGroup {
    /// The indices of the parts in the model, ascending.
    pub parts: Vec<usize>,
    /// The new index of each vertex.
    pub order: VertexOrder,
    /// Why the vertices kept their order, if other data in the scene depends on it.
    pub kept: Option<String>,
}

impl From<(Vec<usize>, Renumbering)> for VertexGroup {
    fn from((parts, Renumbering { order, kept, .. }): (Vec<usize>, Renumbering)) -> Self {
        Self { parts, order, kept }
    }
}

/// The renumbering of a group's vertices; some vertices may be removed.
#[derive(Debug)]
pub(crate) struct Renumbering {
    /// The new indices; removed vertices have the highest.
    pub(crate) order: VertexOrder,
    /// The number of remaining vertices.
    pub(crate) left: usize,
    /// Why all vertices keep their indices, if they must.
    pub(crate) kept: Option<String>,
}

impl Renumbering {
    /// Keeps all vertices, in the given order. `kept` is the reason if it is the old order.
    pub(crate) fn of_order(order: VertexOrder, kept: Option<String>) -> Self {
        Self { left: order.vertex_count(), order, kept }
    }

    /// Keeps all vertices and their indices for the reason `why`.
    pub(crate) fn keep(&mut self, why: String) -> Result<(), Error> {
        *self = Self::of_order(VertexOrder::identity(self.order.vertex_count())?, Some(why));
        Ok(())
    }

    /// Returns whether vertices are removed.
    pub(crate) fn drops(&self) -> bool {
        self.left < self.order.vertex_count()
    }

    /// Returns whether vertices are removed or renumbered.
    pub(crate) fn changes(&self) -> bool {
        self.drops() || self.order.moved_count() > 0
    }

    /// Returns the old index of each remaining vertex.
    pub(crate) fn left_to_old(&self) -> &[u32] {
        &self.order.new_to_old()[..self.left]
    }
}
