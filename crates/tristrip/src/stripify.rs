//! Triangle strips from a mesh: the methods, their options, and the common stages.
//!
//! A method chooses the diagonals of each polygon and the edges over which triangles are linked
//! into paths. The result is a [`StripPlan`]. One emitter for all methods converts it to strips.

mod best;
pub mod bound;
mod cache;
mod eta;
mod fewest;
#[cfg(test)]
pub(crate) mod generated_meshes;
mod guided_tunnels;
mod input;
pub(crate) mod one_shot;
pub(crate) mod options;
mod plan;
mod scattered;
mod sequential;
mod sgi;
mod stripe;
mod tunnel;
mod watch;

use crate::dual::DualGraph;
pub(crate) use crate::effort::Effort;
use crate::error::Error;
use crate::prepare::PreparedFaces;
use eta::EtaOptions;
#[cfg(test)]
pub(crate) use one_shot::stripify;
pub use options::{
    Acceptance, FaceTriangulation, LastTie, Localization, Objective, Patches, Start, Ties, TunnelOptions,
};
pub(crate) use options::{Method, StripifyOptions};
pub use plan::StripPlan;
pub use watch::{Progress, Watch};

/// Computes the plan of a method. This is the stage between the dual graph and the strips.
///
/// # Errors
/// An option is invalid for the method, or the graph is not the dual graph of the faces.
///
/// ```
/// use tristrip::{DualGraph, Faces, Mesh, PreparedFaces, StripifyOptions, stripify::plan};
/// // A fan whose triangles are not in strip order.
/// let mesh = Mesh::new(vec![[0.0; 3]; 5], Faces::from_triangles(vec![0, 1, 2, 4, 2, 3, 2, 1, 3])?)?;
/// let prepared = PreparedFaces::new(&mesh, false);
/// let graph = DualGraph::new(prepared.faces());
/// assert_eq!(plan(&prepared, &graph, &StripifyOptions::default())?.indices_restart(), 5);
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn plan<'a>(
    prepared: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    options: &StripifyOptions,
) -> Result<StripPlan<'a>, Error> {
    plan_watched(prepared, graph, options, &())
}

/// Computes a plan like [`plan`](fn@plan), and reports the progress of a long search to `watch`,
/// which may stop the search. A stopped search returns the best plan found so far.
///
/// # Errors
/// An option is invalid for the method, or the graph is not the dual graph of the faces.
///
/// ```
/// use tristrip::{DualGraph, Faces, Mesh, Method, PreparedFaces, StripifyOptions};
/// use tristrip::stripify::{Progress, plan_watched};
///
/// let mesh = Mesh::new(vec![[0.0; 3]; 5], Faces::from_triangles(vec![0, 1, 2, 4, 2, 3, 2, 1, 3])?)?;
/// let prepared = PreparedFaces::new(&mesh, false);
/// let graph = DualGraph::new(prepared.faces());
/// let options = StripifyOptions::default().with_method(Method::Best);
/// let plan = plan_watched(&prepared, &graph, &options, &|progress: Progress| progress.steps < 1000)?;
/// assert_eq!(plan.indices_restart(), 5);
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn plan_watched<'a>(
    prepared: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    options: &StripifyOptions,
    watch: &dyn Watch,
) -> Result<StripPlan<'a>, Error> {
    graph.check_faces(prepared.faces())?;
    plan_known(prepared, graph, options, watch)
}

/// Computes a plan like [`plan_watched`], for a graph known to be that of the faces.
fn plan_known<'a>(
    prepared: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    options: &StripifyOptions,
    watch: &dyn Watch,
) -> Result<StripPlan<'a>, Error> {
    let is_ours =
        matches!(options.method, Method::Sequential | Method::Best | Method::Fewest | Method::Cache);
    let mut plan = match is_ours.then(|| scattered::gather(prepared, graph)).flatten() {
        Some((prepared, graph)) => plan_in_order(&prepared, &graph, options, watch)?.into_owned(),
        None => plan_in_order(prepared, graph, options, watch)?,
    };
    plan.welds = prepared.welds().clone();
    Ok(plan)
}

/// Computes the plan of a method over the faces in their given order.
fn plan_in_order<'a>(
    prepared: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    options: &StripifyOptions,
    watch: &dyn Watch,
) -> Result<StripPlan<'a>, Error> {
    Ok(match options.method {
        Method::Sequential => sequential::plan(prepared, graph),
        Method::Best => {
            best::plan(prepared, graph, options.cost, options.effort_or_default(), options.seed, watch)
        }
        Method::Fewest => fewest::plan(prepared, graph, options, watch),
        Method::Cache => cache::plan(prepared, graph, options, watch),
        Method::Input => input::plan(prepared, graph),
        Method::Sgi { last_tie } => sgi::plan(prepared, graph, last_tie),
        Method::StripeLocal { triangulation, ties } => {
            stripe::plan_local(prepared, graph, triangulation, ties, options.seed)
        }
        Method::StripeGlobal { patches, cutoff, ties } => {
            stripe::plan_global(prepared, graph, (patches, cutoff, ties), options.seed)?
        }
        Method::QuadRows { cutoff } => stripe::quad_rows::plan(prepared, graph, cutoff, options.seed)?,
        Method::Tunnel { length } => tunnel::plan(prepared, graph, length, watch),
        Method::Eta { tunnels, acceptance, localization } => {
            tunnel::plan_joined(prepared, graph, tunnels.start, |graph, cover| {
                let eta = EtaOptions { tunnels, acceptance, localization };
                eta::join(graph, cover, eta, options.seed, watch);
            })
        }
        Method::GuidedTunnels(tunnels) => {
            tunnel::plan_joined(prepared, graph, tunnels.start, |graph, cover| {
                guided_tunnels::join(graph, cover, tunnels, options.seed, watch);
            })
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Faces, Mesh};
    use crate::strip::Strips;
    use crate::verify::verify;
    use bound::Bound;
    use proptest::prelude::*;

    /// Every method rejects a graph of fewer faces, more faces, faces of other sizes, or faces with
    /// other connections.
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
        /// Meshes with few distinct positions: welding makes faces degenerate and lets polygons
        /// touch themselves.
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
                // For polygons that touch themselves the proof compares only the edges.
                if !strips.is_empty() && polygons.iter().all(|polygon| polygon.len() == 3) {
                    let mut fewer = Strips::default().with_welds(strips.welds().clone());
                    strips.iter().skip(1).for_each(|strip| fewer.push(strip));
                    prop_assert!(verify(&mesh, &fewer).is_err(), "{}", method);
                }
            }
        }
    }
}
