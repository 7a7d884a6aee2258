//! Parts over the same vertices, with the new numbers of these vertices.

use tristrip::VertexOrder;

use crate::error::Error;

/// Parts over the same vertices, and the new order of these vertices.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VertexGroup {
    /// The indices of the parts in the model, ascending.
    pub parts: Vec<usize>,
    /// The new index of each vertex.
    pub order: VertexOrder,
    /// Why the vertices kept their order, where something in the scene depends on it.
    pub kept: Option<String>,
}

impl From<(Vec<usize>, Renumbering)> for VertexGroup {
    fn from((parts, Renumbering { order, kept, .. }): (Vec<usize>, Renumbering)) -> Self {
        Self { parts, order, kept }
    }
}

/// New numbers for the vertices of a group, some of which may be dropped.
#[derive(Debug)]
pub(crate) struct Renumbering {
    /// The new numbers; those of vertices that are dropped are the highest.
    pub(crate) order: VertexOrder,
    /// The number of vertices that stay.
    pub(crate) left: usize,
    /// Why all vertices keep their numbers, if they must.
    pub(crate) kept: Option<String>,
}

impl Renumbering {
    /// Keeps all vertices, in the order or, with a reason, in their old order.
    pub(crate) fn of_order(order: VertexOrder, kept: Option<String>) -> Self {
        Self { left: order.vertex_count(), order, kept }
    }

    /// Keeps all vertices and their numbers, for a reason.
    pub(crate) fn keep(&mut self, why: String) -> Result<(), Error> {
        *self = Self::of_order(VertexOrder::identity(self.order.vertex_count())?, Some(why));
        Ok(())
    }

    /// Returns whether vertices are dropped.
    pub(crate) fn drops(&self) -> bool {
        self.left < self.order.vertex_count()
    }

    /// Returns whether vertices are dropped or get other numbers.
    pub(crate) fn changes(&self) -> bool {
        self.drops() || self.order.moved_count() > 0
    }

    /// Returns the old number of each vertex that stays.
    pub(crate) fn left_to_old(&self) -> &[u32] {
        &self.order.new_to_old()[..self.left]
    }
}
