//! The result of a method: the diagonals of the polygons, and the edges over which triangles are
//! linked into paths.

use crate::cover::{CoverFault, PathCover};
use crate::dual::Triangulation;
use crate::ids::FaceId;
use crate::mesh::VertexWelds;
use crate::prepare::PreparedFaces;
use crate::strip::{Metrics, Strips, cover_cost, emit, emit_in_order};

/// The result of a method: a triangulation and a path cover of its triangles.
#[derive(Debug, Clone)]
pub struct StripPlan<'a> {
    pub(crate) triangulation: Triangulation<'a>,
    pub(crate) cover: PathCover,
    /// The first triangle of each path, in drawing order. `None` lets the emitter choose order and
    /// direction.
    pub(crate) order: Option<Vec<FaceId>>,
    /// The vertices that were welded during preparation.
    pub(crate) welds: VertexWelds,
}

impl<'a> StripPlan<'a> {
    /// Creates a plan that lets the emitter choose the order and direction of the paths.
    pub(crate) fn new(triangulation: Triangulation<'a>, cover: PathCover) -> Self {
        Self { triangulation, cover, order: None, welds: VertexWelds::default() }
    }

    /// Creates a plan from a cover of the triangles of prepared faces, for example from your own
    /// method.
    ///
    /// # Errors
    /// The cover violates an invariant; see [`PathCover::check`].
    ///
    /// ```
    /// use tristrip::stripify::StripPlan;
    /// use tristrip::{DualGraph, Faces, HalfEdge, Mesh, PathCover, PreparedFaces, Triangulation};
    /// let mesh = Mesh::new(vec![[0.0; 3]; 4], Faces::from_triangles(vec![0, 1, 2, 2, 1, 3])?)?;
    /// let prepared = PreparedFaces::new(&mesh, false);
    /// let graph = DualGraph::new(prepared.faces());
    /// let triangulation = Triangulation::fans(&prepared, &graph)?;
    /// let mut cover = PathCover::isolated(2);
    /// // Join across the edge from vertex 1 to vertex 2.
    /// assert!(cover.join(&graph, HalfEdge(1)));
    /// let plan = StripPlan::from_cover(&prepared, triangulation, cover)?;
    /// assert_eq!((plan.strips().len(), plan.strips().vertices_sent()), (1, 4));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn from_cover(
        prepared: &PreparedFaces<'_>,
        triangulation: Triangulation<'a>,
        cover: PathCover,
    ) -> Result<Self, CoverFault> {
        cover.check(triangulation.graph())?;
        Ok(Self { welds: prepared.welds().clone(), ..Self::new(triangulation, cover) })
    }

    /// Creates a plan with the first triangle of each path, in drawing order.
    pub(crate) fn in_order(triangulation: Triangulation<'a>, cover: PathCover, order: Vec<FaceId>) -> Self {
        Self { order: Some(order), ..Self::new(triangulation, cover) }
    }

    /// Returns the same plan with owned data.
    pub(super) fn into_owned<'b>(self) -> StripPlan<'b> {
        let Self { triangulation, cover, order, welds } = self;
        StripPlan { triangulation: triangulation.into_owned(), cover, order, welds }
    }

    /// Returns the triangles and their dual graph.
    ///
    /// ```
    #[doc = include_str!("../dual/example.txt")]
    /// assert_eq!(plan.triangulation().triangle_count(), plan.strips().triangles().count());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn triangulation(&self) -> &Triangulation<'a> {
        &self.triangulation
    }

    /// Returns the paths over the triangles.
    ///
    /// ```
    #[doc = include_str!("../dual/example.txt")]
    /// assert_eq!(plan.cover().path_count(), plan.strips().len());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn cover(&self) -> &PathCover {
        &self.cover
    }

    /// Emits the strips, with the [welds](Strips::welds) of the faces.
    ///
    /// ```
    #[doc = include_str!("../dual/example.txt")]
    /// assert!(verify::verify(&mesh, &plan.strips()).is_ok());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn strips(&self) -> Strips {
        let strips = match &self.order {
            Some(order) => emit_in_order(&self.triangulation, &self.cover, order),
            None => emit(&self.triangulation, &self.cover),
        };
        strips.with_welds(self.welds.clone())
    }

    /// Returns the number of indices of [`StripPlan::strips`], including restarts between strips.
    ///
    /// ```
    /// use tristrip::{DualGraph, Faces, Mesh, PreparedFaces, StripifyOptions, stripify::plan};
    /// let mesh = Mesh::new(vec![[0.0; 3]; 4], Faces::from_triangles(vec![0, 1, 2, 2, 1, 3])?)?;
    /// let prepared = PreparedFaces::new(&mesh, false);
    /// let graph = DualGraph::new(prepared.faces());
    /// assert_eq!(plan(&prepared, &graph, &StripifyOptions::default())?.indices_restart(), 4);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn indices_restart(&self) -> usize {
        match &self.order {
            Some(_) => Metrics::of(&self.strips()).indices_restart,
            None => cover_cost(self.triangulation.graph(), &self.cover).saturating_sub(1),
        }
    }
}
