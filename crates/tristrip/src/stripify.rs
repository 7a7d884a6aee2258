//! Strips from a mesh: the methods, their options, and the stages that they share.
//!
//! Every method only chooses: which diagonals a polygon gets, and over which edges the triangles are linked to paths. What a
//! method chose is a [`StripPlan`]; one emitter makes the strips of it.

mod best;
pub mod bound;
mod cache;
mod fewest;
pub mod input;
mod options;
mod plan;
pub mod sequential;
pub mod sgi;
pub mod stripe;
pub mod tunnel;
pub mod watch;

use crate::dual::DualGraph;
pub use crate::effort::Effort;
use crate::error::Error;
use crate::mesh::Mesh;
use crate::prepare::PreparedFaces;
use crate::strip::Strips;
pub use options::{EtaOptions, FaceTriangulation, Method, Objective, Patches, Start, StripifyOptions, Ties};
pub use plan::StripPlan;
pub use watch::{Progress, Watch};

/// Finds triangle strips for a mesh: the whole way from faces to strips.
///
/// # Errors
/// An option makes no sense for the method.
///
/// ```
/// use tristrip::{Faces, Mesh, StripifyOptions, stripify, verify::verify};
/// let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
/// let mesh = Mesh::new(corners, Faces::from_polygons([[0, 1, 2, 3]])?)?;
/// let strips = stripify(&mesh, &StripifyOptions::default())?;
/// assert_eq!(strips.vertices_sent(), 4);
/// assert!(verify(&mesh, &strips).is_ok());
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn stripify(mesh: &Mesh, options: &StripifyOptions) -> Result<Strips, Error> {
    let surface = PreparedFaces::new(mesh, options.weld());
    let graph = DualGraph::new(surface.faces());
    let plan = plan(&surface, &graph, options)?;
    Ok(plan.strips())
}

/// Lets a method choose: the stage between the dual graph and the strips.
///
/// # Errors
/// An option makes no sense for the method.
pub fn plan<'a>(
    surface: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    options: &StripifyOptions,
) -> Result<StripPlan<'a>, Error> {
    choose(surface, graph, options).map(|(_, plan)| plan)
}

/// Lets a method choose, and says which method it was: for [`Method::Auto`] the one that it stands for, else the one that was
/// asked for.
///
/// # Errors
/// An option makes no sense for the method.
///
/// ```
/// use tristrip::{DualGraph, Faces, Mesh, Method, PreparedFaces, StripifyOptions, stripify::choose};
/// // A fan in an order that no strip takes.
/// let mesh = Mesh::new(vec![[0.0; 3]; 5], Faces::from_triangles(vec![0, 1, 2, 4, 2, 3, 2, 1, 3])?)?;
/// let surface = PreparedFaces::new(&mesh, false);
/// let graph = DualGraph::new(surface.faces());
/// let (method, plan) = choose(&surface, &graph, &StripifyOptions::default())?;
/// assert_eq!((method, plan.indices_restart()), (Method::Best, 5));
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn choose<'a>(
    surface: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    options: &StripifyOptions,
) -> Result<(Method, StripPlan<'a>), Error> {
    choose_watched(surface, graph, options, &())
}

/// Lets a method choose as [`choose`] does, under a watcher that takes notice of a long search's progress and may stop it. A search
/// that is stopped gives the best that it has.
///
/// # Errors
/// An option makes no sense for the method.
///
/// ```
/// use std::sync::atomic::{AtomicU64, Ordering};
/// use tristrip::{DualGraph, Faces, Mesh, Method, PreparedFaces, StripifyOptions};
/// use tristrip::stripify::{Progress, Watch, choose_watched};
///
/// struct Impatient(AtomicU64);
/// impl Watch for Impatient {
///     fn go_on(&self, progress: Progress) -> bool {
///         self.0.fetch_max(progress.steps, Ordering::Relaxed) < 1000
///     }
/// }
///
/// let mesh = Mesh::new(vec![[0.0; 3]; 5], Faces::from_triangles(vec![0, 1, 2, 4, 2, 3, 2, 1, 3])?)?;
/// let surface = PreparedFaces::new(&mesh, false);
/// let graph = DualGraph::new(surface.faces());
/// let options = StripifyOptions::default().with_method(Method::Best);
/// let (_, plan) = choose_watched(&surface, &graph, &options, &Impatient(AtomicU64::new(0)))?;
/// assert_eq!(plan.indices_restart(), 5);
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn choose_watched<'a>(
    surface: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    options: &StripifyOptions,
    watch: &dyn Watch,
) -> Result<(Method, StripPlan<'a>), Error> {
    let plan = match options.method() {
        Method::Sequential => sequential::plan(surface, graph),
        Method::Auto | Method::Best => {
            best::plan(surface, graph, options.cost(), options.effort(), options.seed(), watch)
        }
        Method::Fewest => fewest::plan(surface, graph, options, watch),
        Method::Cache => cache::plan(surface, graph, options, watch),
        Method::Input => input::plan(surface, graph),
        Method::Sgi => sgi::plan(surface, graph),
        Method::StripeLocal { triangulation, ties } => {
            stripe::plan_local(surface, graph, triangulation, ties, options.seed())
        }
        Method::StripeGlobal { patches, cutoff } => {
            stripe::plan_global(surface, graph, patches, cutoff, options.seed())?
        }
        Method::Tunnel { length } => tunnel::plan_tunnel(surface, graph, length, watch),
        Method::Eta(eta) => tunnel::plan_eta(surface, graph, eta, options.seed(), watch),
    };
    let taken = if options.method() == Method::Auto { Method::Best } else { options.method() };
    Ok((taken, plan))
}
