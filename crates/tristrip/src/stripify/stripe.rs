//! STRIPE.

mod letters;
mod local;
mod patch;
mod pieces;
mod queue;
mod weave;

use super::{FaceTriangulation, Patches, Plan, Ties};
use crate::cover::PathCover;
use crate::dual::{DualGraph, HalfEdge};
use crate::mesh::{Surface, Triangulation};
use local::Walker;
use pieces::Pieces;
use weave::{Linker, Weaver};

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
        let cover = cover(triangulation.graph(), ties, seed);
        return Plan { triangulation, cover };
    }
    let mut weaver = Weaver::new(faces, graph);
    let pieces = Pieces::new(graph, triangulation == FaceTriangulation::Partial);
    Walker::new(pieces, ties, seed).run(&mut weaver);
    weaver.finish()
}

/// Covers triangles by the local algorithm.
pub(super) fn cover(graph: &DualGraph, ties: Ties, seed: u64) -> PathCover {
    let mut linker = Linker::new(graph);
    Walker::new(Pieces::new(graph, false), ties, seed).run(&mut linker);
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
        let cover = cover(graph, Ties::Sequential, seed);
        return Plan { triangulation, cover };
    }
    let mut weaver = Weaver::new(faces, graph);
    let mut walker = Walker::new(Pieces::new(graph, false), Ties::Sequential, seed);
    let found = patch::Patches::new(graph).find(cutoff);
    let extend = std::env::var("EXT").is_ok() || patches == Patches::Full;
    walker.reserve(found.iter().flatten().flatten().copied());
    for rows in &found {
        match patches {
            Patches::Rows => {
                for row in rows {
                    walker.follow(row.iter().copied());
                    if extend { walker.grow(); walker.turn_around(); walker.grow(); }
                    walker.end(&mut weaver);
                }
            }
            Patches::Full => {
                walker.follow(winding(graph, rows));
                walker.grow();
                walker.turn_around();
                walker.grow();
                walker.end(&mut weaver);
            }
        }
    }
    walker.run(&mut weaver);
    weaver.finish()
}

/// The headings of a path through all rows of a patch, every other row from east to west.
fn winding(graph: &DualGraph, rows: &[Vec<u32>]) -> impl Iterator<Item = u32> {
    let turn = |h: u32, turns: u32| {
        let first = graph.half_edges(graph.face_of(HalfEdge(h))).next().map_or(0, |h| h.0);
        first + ((h - first + turns) & 3)
    };
    rows.iter().enumerate().flat_map(move |(i, row)| {
        let mut headings: Vec<u32> = if i % 2 == 0 { row.clone() } else { row.iter().rev().map(|&h| turn(h, 2)).collect() };
        if let Some(last) = headings.last_mut() {
            *last = turn(*last, if i % 2 == 0 { 1 } else { 3 });
        }
        headings
    })
}
