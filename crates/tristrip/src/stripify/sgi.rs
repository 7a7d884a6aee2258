//! SGI.

use super::{Plan, Ties, stripe};
use crate::dual::DualGraph;
use crate::mesh::{Surface, Triangulation};

pub(super) fn plan<'a>(surface: &'a Surface<'_>, graph: &'a DualGraph) -> Plan<'a> {
    let triangulation = Triangulation::zigzag(surface, graph);
    let cover = stripe::cover(triangulation.graph(), Ties::LookAhead, 0);
    Plan { triangulation, cover }
}
