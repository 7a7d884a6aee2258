//! The order of the chunks of several meshes.

use tristrip::stream::StreamChunk;

/// The chunks of a mesh, and by how much the scene enlarges its errors.
pub(super) struct Queue {
    pub(super) chunks: Vec<StreamChunk>,
    pub(super) scale: f64,
}

/// Joins the chunks of all meshes: their base meshes first, and then always the next chunk of the mesh with the largest error so far. The chunks of `queues[i]` are those of
/// mesh i.
pub(super) fn in_order(queues: &[Queue]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut next: Vec<usize> = vec![0; queues.len()];
    let take = |queue: usize, bytes: &mut Vec<u8>, next: &mut Vec<usize>| {
        bytes.extend(queues[queue].chunks[next[queue]].of_stream(queue as u32));
        next[queue] += 1;
    };
    for queue in (0..queues.len()).filter(|&queue| !queues[queue].chunks.is_empty()) {
        take(queue, &mut bytes, &mut next);
    }
    let error = |queue: usize, next: &[usize]| {
        f64::from(queues[queue].chunks[next[queue] - 1].error) * queues[queue].scale
    };
    loop {
        let left = (0..queues.len()).filter(|&queue| (1..queues[queue].chunks.len()).contains(&next[queue]));
        // The first of several with the same error.
        let worst = left.rev().max_by(|&a, &b| error(a, &next).total_cmp(&error(b, &next)));
        let Some(worst) = worst else { return bytes };
        take(worst, &mut bytes, &mut next);
    }
}
