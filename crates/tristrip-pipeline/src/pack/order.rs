//! The order of the chunks of several meshes.

use tristrip::stream::StreamChunk;

/// The chunks of a mesh, and the scale of its errors in the scene.
pub(super) struct Queue {
    pub(super) chunks: Vec<StreamChunk>,
    pub(super) scale: f64,
}

/// Merges the chunks of all meshes. The base meshes come first, followed by the next chunk of the
/// mesh with the largest current error. The chunks of `queues[i]` belong to mesh i.
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
        // The first of several meshes with the same error.
        let worst = left.rev().max_by(|&a, &b| error(a, &next).total_cmp(&error(b, &next)));
        let Some(worst) = worst else { return bytes };
        take(worst, &mut bytes, &mut next);
    }
}
