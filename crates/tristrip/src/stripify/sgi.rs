//! SGI.

use super::{Plan, stripe};
use crate::dual::DualGraph;
use crate::mesh::{Surface, Triangulation};

pub(super) fn plan<'a>(surface: &'a Surface<'_>, graph: &'a DualGraph) -> Plan<'a> {
    let triangulation = Triangulation::zigzag(surface, graph);
    let cover = stripe::cover_by_look_ahead(triangulation.graph());
    Plan { triangulation, cover }
}
