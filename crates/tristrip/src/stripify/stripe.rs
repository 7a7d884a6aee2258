//! STRIPE.

mod letters;
mod local;
mod patch;
mod pieces;
mod queue;
mod weave;

use super::{FaceTriangulation, Patches, Plan, Ties};
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::mesh::{Surface, Triangulation};
use local::{Rule, Walker};
use pieces::Pieces;
use weave::{Linker, Weaver};

/// The shortest part of a row that becomes a strip: shorter ones are left to the local algorithm.
const SHORTEST_ROW: usize = 3;

pub(super) fn plan_local<'a>(
    surface: &'a Surface<'_>,
    graph: &'a DualGraph,
    triangulation: FaceTriangulation,
    ties: Ties,
    seed: u64,
) -> Plan<'a> {
    let faces = surface.faces();
    if triangulation == FaceTriangulation::Static || faces.as_triangles().is_some() {
        let triangulation = Triangulation::zigzag(surface, graph);
        let cover = cover(triangulation.graph(), Rule::Adjacency(ties), seed);
        return Plan { triangulation, cover };
    }
    let mut weaver = Weaver::new(faces, graph);
    let pieces = Pieces::new(graph, triangulation == FaceTriangulation::Partial);
    Walker::new(pieces, Rule::Adjacency(ties), seed).run(&mut weaver);
    weaver.finish()
}

/// Covers triangles by least adjacency, ties by one level of look-ahead.
pub(super) fn cover_by_look_ahead(graph: &DualGraph) -> PathCover {
    cover(graph, Rule::Adjacency(Ties::LookAhead), 0)
}

/// Covers triangles by the local algorithm.
fn cover(graph: &DualGraph, rule: Rule, seed: u64) -> PathCover {
    let mut linker = Linker::new(graph);
    Walker::new(Pieces::new(graph, false), rule, seed).run(&mut linker);
    linker.finish()
}

pub(super) fn plan_global<'a>(
    surface: &'a Surface<'_>,
    graph: &'a DualGraph,
    patches: Patches,
    cutoff: u32,
    seed: u64,
) -> Plan<'a> {
    let faces = surface.faces();
    if faces.as_triangles().is_some() {
        let triangulation = Triangulation::zigzag(surface, graph);
        let cover = cover(graph, Rule::Reluctant, seed);
        return Plan { triangulation, cover };
    }
    let mut weaver = Weaver::new(faces, graph);
    let mut walker = Walker::new(Pieces::new(graph, false), Rule::Reluctant, seed);
    for rows in patch::Patches::new(graph).find(cutoff) {
        match patches {
            Patches::Rows => rows.iter().for_each(|row| walker.follow(row, SHORTEST_ROW, &mut weaver)),
            Patches::Full => walker.follow(&patch::winding(graph, &rows), SHORTEST_ROW, &mut weaver),
        }
    }
    walker.run(&mut weaver);
    weaver.finish()
}
