//! Triangle strips from a mesh: the methods, their options, and the stages that they share.
//!
//! A method chooses two things: the diagonals of each polygon, and the edges over which triangles are linked to paths. The
//! result is a [`StripPlan`]; one emitter turns every plan into strips.

mod best;
pub mod bound;
mod cache;
pub mod eta;
mod fewest;
#[cfg(test)]
mod generated_meshes;
mod indices;
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
pub use indices::{stripify_faces, stripify_indices, stripify_indices_with};
pub use options::{EtaOptions, FaceTriangulation, Method, Objective, Patches, Start, StripifyOptions, Ties};
pub use plan::StripPlan;
pub use watch::{Progress, Watch};

/// Computes triangle strips for a mesh: runs all stages from faces to strips.
///
/// # Errors
/// An option is invalid for the method.
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
    let prepared = PreparedFaces::new(mesh, options.weld());
    let graph = DualGraph::new(prepared.faces());
    let (_, plan) = choose_known(&prepared, &graph, options, &())?;
    Ok(plan.strips())
}

/// Computes the plan of a method: the stage between the dual graph and the strips.
///
/// # Errors
/// An option is invalid for the method, or the graph is not the one of the faces.
pub fn plan<'a>(
    prepared: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    options: &StripifyOptions,
) -> Result<StripPlan<'a>, Error> {
    choose(prepared, graph, options).map(|(_, plan)| plan)
}

/// Computes the plan of a method, and returns it with the method that ran: for [`Method::Auto`] the method that it stands for,
/// otherwise the one in the options.
///
/// # Errors
/// An option is invalid for the method, or the graph is not the one of the faces.
///
/// ```
/// use tristrip::{DualGraph, Faces, Mesh, Method, PreparedFaces, StripifyOptions, stripify::choose};
/// // A fan whose triangles are not in the order of a strip.
/// let mesh = Mesh::new(vec![[0.0; 3]; 5], Faces::from_triangles(vec![0, 1, 2, 4, 2, 3, 2, 1, 3])?)?;
/// let prepared = PreparedFaces::new(&mesh, false);
/// let graph = DualGraph::new(prepared.faces());
/// let (method, plan) = choose(&prepared, &graph, &StripifyOptions::default())?;
/// assert_eq!((method, plan.indices_restart()), (Method::Best, 5));
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn choose<'a>(
    prepared: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    options: &StripifyOptions,
) -> Result<(Method, StripPlan<'a>), Error> {
    choose_watched(prepared, graph, options, &())
}

/// Computes a plan as [`choose`] does, and reports the progress of a long search to a watcher, which may stop it. A stopped
/// search returns the best plan found so far.
///
/// # Errors
/// An option is invalid for the method, or the graph is not the one of the faces.
///
/// ```
/// use tristrip::{DualGraph, Faces, Mesh, Method, PreparedFaces, StripifyOptions};
/// use tristrip::stripify::{Progress, choose_watched};
///
/// let mesh = Mesh::new(vec![[0.0; 3]; 5], Faces::from_triangles(vec![0, 1, 2, 4, 2, 3, 2, 1, 3])?)?;
/// let prepared = PreparedFaces::new(&mesh, false);
/// let graph = DualGraph::new(prepared.faces());
/// let options = StripifyOptions::default().with_method(Method::Best);
/// let (_, plan) = choose_watched(&prepared, &graph, &options, &|progress: Progress| progress.steps < 1000)?;
/// assert_eq!(plan.indices_restart(), 5);
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn choose_watched<'a>(
    prepared: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    options: &StripifyOptions,
    watch: &dyn Watch,
) -> Result<(Method, StripPlan<'a>), Error> {
    graph.check_faces(prepared.faces())?;
    choose_known(prepared, graph, options, watch)
}

/// Computes a plan as [`choose_watched`] does, for a graph that was made from the faces.
fn choose_known<'a>(
    prepared: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    options: &StripifyOptions,
    watch: &dyn Watch,
) -> Result<(Method, StripPlan<'a>), Error> {
    let mut plan = match options.method() {
        Method::Sequential => sequential::plan(prepared, graph),
        Method::Auto | Method::Best => {
            best::plan(prepared, graph, options.cost(), options.effort(), options.seed(), watch)
        }
        Method::Fewest => fewest::plan(prepared, graph, options, watch),
        Method::Cache => cache::plan(prepared, graph, options, watch),
        Method::Input => input::plan(prepared, graph),
        Method::Sgi => sgi::plan(prepared, graph),
        Method::StripeLocal { triangulation, ties } => {
            stripe::plan_local(prepared, graph, triangulation, ties, options.seed())
        }
        Method::StripeGlobal { patches, cutoff } => {
            stripe::plan_global(prepared, graph, patches, cutoff, options.seed())?
        }
        Method::Tunnel { length } => tunnel::plan(prepared, graph, length, watch),
        Method::Eta(eta) => eta::plan(prepared, graph, eta, options.seed(), watch),
    };
    plan.welds = prepared.welds().clone();
    let method = if options.method() == Method::Auto { Method::Best } else { options.method() };
    Ok((method, plan))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Faces;
    use crate::verify::verify;
    use bound::Bound;
    use proptest::prelude::*;

    /// Every method refuses a graph of fewer faces, of more faces, of faces of other sizes, and of faces connected otherwise.
    #[test]
    fn a_graph_of_other_faces_is_refused() {
        let mesh = |polygons: &[Vec<u32>]| {
            Mesh::new(vec![[0.0; 3]; 9], Faces::from_polygons(polygons).unwrap()).unwrap()
        };
        let meshes = [
            mesh(&[vec![0, 1, 2], vec![2, 1, 3], vec![4, 5, 6], vec![6, 5, 7]]),
            mesh(&[vec![4, 5, 6], vec![0, 1, 2], vec![2, 1, 3], vec![7, 8, 0]]),
            mesh(&[vec![0, 1, 2], vec![2, 1, 3]]),
            mesh(&[vec![0, 1, 2, 3], vec![2, 1, 4, 7], vec![4, 5, 6, 8]]),
            mesh(&[vec![0, 1, 2, 3, 4], vec![2, 1, 5], vec![4, 5, 6, 8]]),
            mesh(&[]),
        ];
        for (i, mesh) in meshes.iter().enumerate() {
            let prepared = PreparedFaces::new(mesh, false);
            let own = DualGraph::new(prepared.faces());
            let cover = plan(&prepared, &own, &StripifyOptions::default()).unwrap().cover;
            for (j, other) in meshes.iter().enumerate() {
                let graph = DualGraph::new(PreparedFaces::new(other, false).faces());
                for method in Method::ALL {
                    let options = StripifyOptions::default().with_method(*method);
                    assert_eq!(plan(&prepared, &graph, &options).is_ok(), i == j, "{i} {j} {method}");
                }
                assert_eq!(Bound::of_prepared(&prepared, &graph).is_ok(), i == j, "{i} {j}");
                assert!(cover.len() == graph.face_count() || cover.check(&graph).is_err(), "{i} {j}");
            }
        }
    }

    proptest! {
        /// Meshes with few different positions, so that welding makes faces degenerate and polygons touch themselves.
        #[test]
        fn welded_strips_of_any_mesh_are_proven(
            polygons in generated_meshes::polygons(true, 1..3),
            columns in 1..9_u32,
            rows in 1..9_u32,
        ) {
            let vertex_count = polygons.iter().flatten().max().map_or(0, |&v| v + 1);
            let at = |v: u32| [(v % columns) as f32, (v / columns % rows) as f32, 0.0];
            let positions: Vec<[f32; 3]> = (0..vertex_count).map(at).collect();
            let mesh = Mesh::new(positions, Faces::from_polygons(&polygons).unwrap()).unwrap();
            for method in [Method::Sequential, Method::Best, Method::Input, Method::Cache, Method::STRIPE] {
                let strips = stripify(&mesh, &StripifyOptions::default().with_method(method).with_weld(true)).unwrap();
                prop_assert_eq!(verify(&mesh, &strips).map(drop), Ok(()), "{}", method);
                // Of polygons that touch themselves the proof compares only the edges.
                if !strips.is_empty() && polygons.iter().all(|polygon| polygon.len() == 3) {
                    let mut fewer = Strips::default().with_welds(strips.welds().clone());
                    strips.iter().skip(1).for_each(|strip| fewer.push(strip));
                    prop_assert!(verify(&mesh, &fewer).is_err(), "{}", method);
                }
            }
        }
    }
}
