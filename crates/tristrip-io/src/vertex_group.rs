//! Parts over the same vertices, with the order of these vertices.

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

impl VertexGroup {
    /// Keeps the old order of the vertices.
    pub(crate) fn keep(&mut self, why: String) -> Result<(), Error> {
        self.order = VertexOrder::identity(self.order.vertex_count())?;
        self.kept = Some(why);
        Ok(())
    }
}
