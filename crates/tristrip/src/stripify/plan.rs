//! What a method chose: which diagonals polygons get, and over which edges triangles are linked to paths.

use crate::cover::PathCover;
use crate::dual::Triangulation;
use crate::ids::FaceId;
use crate::strip::{Metrics, Strips, cover_cost, emit, emit_in_order};

/// What a method chose: a triangulation and a cover of it.
#[derive(Debug, Clone)]
pub struct StripPlan<'a> {
    /// The triangles.
    pub triangulation: Triangulation<'a>,
    /// The paths over them.
    pub cover: PathCover,
    /// The triangle with which each path begins, the paths as they are drawn; `None` leaves order and direction to the emitter.
    pub order: Option<Vec<FaceId>>,
}

impl<'a> StripPlan<'a> {
    /// Leaves the paths' order and direction to the emitter.
    pub fn new(triangulation: Triangulation<'a>, cover: PathCover) -> Self {
        Self { triangulation, cover, order: None }
    }

    /// Makes the strips.
    pub fn strips(&self) -> Strips {
        match &self.order {
            Some(order) => emit_in_order(&self.triangulation, &self.cover, order),
            None => emit(&self.triangulation, &self.cover),
        }
    }

    /// Counts the indices of the strips with restarts between them, as [`StripPlan::strips`] sends them.
    ///
    /// ```
    /// use tristrip::{DualGraph, Faces, Mesh, PreparedFaces, StripifyOptions, stripify::plan};
    /// let mesh = Mesh::new(vec![[0.0; 3]; 4], Faces::from_triangles(vec![0, 1, 2, 2, 1, 3])?)?;
    /// let surface = PreparedFaces::new(&mesh, false);
    /// let graph = DualGraph::new(surface.faces());
    /// assert_eq!(plan(&surface, &graph, &StripifyOptions::default())?.indices_restart(), 4);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn indices_restart(&self) -> usize {
        match &self.order {
            Some(_) => Metrics::of(&self.strips()).indices_restart,
            None => cover_cost(self.triangulation.graph(), &self.cover).saturating_sub(1),
        }
    }
}
