//! Arranging strips that are already chosen: in which order they are drawn, and from which end each.

use super::border::{Border, Head, Way};
use super::buffers::Trial;
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::ids::FaceId;

/// Orders the paths of a cover: next comes the one at the oldest place of the border whose vertices are in the buffer, from the end
/// from which it costs less. Gives the first triangle of each.
pub(super) fn arrange<B: Trial>(mut border: Border<'_, B>, cover: &PathCover) -> Vec<FaceId> {
    let graph = border.graph();
    let numbering = cover.renumber(graph);
    let mut order = Vec::with_capacity(numbering.first.len());
    while let Some(edge) = border.oldest_edge(0).or_else(|| border.youngest_edge()) {
        let first = numbering.first[numbering.path[(edge / 3) as usize] as usize];
        let last = cover.other_end(graph, first).unwrap_or(first);
        let [forward, backward] = [first, last].map(|start| {
            let before = (border.mark(), border.cost());
            follow(&mut border, graph, cover, start);
            let cost = border.cost() - before.1;
            border.undo(before.0);
            cost
        });
        let start = if backward < forward { last } else { first };
        follow(&mut border, graph, cover, start);
        border.keep();
        order.push(start);
    }
    order
}

/// Draws a whole path from one of its ends.
fn follow<B: Trial>(border: &mut Border<'_, B>, graph: &DualGraph, cover: &PathCover, start: FaceId) {
    let mut head: Option<Head> = None;
    for (face, entry, exit) in cover.walk(graph, start) {
        let next = match (head, entry.and_then(|entry| graph.twin(entry).map(|exit| (exit, entry)))) {
            (Some(head), Some((exit, entry))) => border.go(head, Way { exit: exit.0, entry: entry.0 }),
            _ => border.start(face.0, exit.map(|exit| exit.0 % 3)),
        };
        head = Some(next);
    }
}
