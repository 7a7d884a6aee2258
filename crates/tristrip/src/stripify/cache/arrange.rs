//! Drawing order and direction of given strips.

use super::active_front::{ActiveFront, EdgeCrossing, StripHead};
use super::speculative::SpeculativeCache;
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::ids::FaceId;

/// Orders the paths of a cover. The next path is the one at the oldest edge of the front whose
/// vertices are in the cache, in its cheaper direction. Returns the first triangle of each path.
pub(super) fn arrange<C: SpeculativeCache>(mut front: ActiveFront<'_, C>, cover: &PathCover) -> Vec<FaceId> {
    let graph = front.graph();
    let numbering = cover.renumber(graph);
    let mut order = Vec::with_capacity(numbering.first.len());
    while let Some(edge) = front.oldest_edge(0).or_else(|| front.newest_edge()) {
        let first = numbering.first[numbering.path[(edge / 3) as usize] as usize];
        let last = cover.other_end(graph, first).unwrap_or(first);
        let [forward, backward] = [first, last].map(|start| {
            let before = (front.checkpoint(), front.cost());
            draw_path(&mut front, graph, cover, start);
            let cost = front.cost() - before.1;
            front.roll_back(before.0);
            cost
        });
        let start = if backward < forward { last } else { first };
        draw_path(&mut front, graph, cover, start);
        front.commit();
        order.push(start);
    }
    order
}

/// Draws a whole path from one of its ends.
fn draw_path<C: SpeculativeCache>(
    front: &mut ActiveFront<'_, C>,
    graph: &DualGraph,
    cover: &PathCover,
    start: FaceId,
) {
    let mut head: Option<StripHead> = None;
    for (face, entry, exit) in cover.walk(graph, start) {
        let next = match (head, entry.and_then(|entry| graph.twin(entry).map(|exit| (exit, entry)))) {
            (Some(head), Some((exit, entry))) => {
                front.advance(head, EdgeCrossing { exit: exit.0, entry: entry.0 })
            }
            _ => front.start(face.0, exit.map(|exit| exit.0 % 3)),
        };
        head = Some(next);
    }
}
