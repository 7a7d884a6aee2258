//! Shapes with many components or many ends.

use super::draft::{Draft, Order, Shape};

/// The shapes of this family.
pub(super) const SHAPES: &[Shape] = &[
    ("isolated triangles", isolated),
    ("isolated triangles, shuffled", |n| isolated(n).in_order(Order::Shuffled)),
    ("tetrahedra, shuffled", |n| tetrahedra(n).in_order(Order::Shuffled)),
    ("tree of triangles", tree),
    ("tree of triangles, shuffled", |n| tree(n).in_order(Order::Shuffled)),
    ("comb of triangles", comb),
    ("comb of triangles, shuffled", |n| comb(n).in_order(Order::Shuffled)),
];

fn isolated(triangles: u32) -> Draft {
    let mut draft = Draft::new();
    for i in 0..triangles {
        let at = |corner: u32| [i as f32, (corner % 2) as f32, (corner / 2) as f32];
        let first = draft.vertices(3, at);
        draft.face(first..first + 3);
    }
    draft
}

/// Triangles whose dual graph is a complete binary tree: every triangle has two children on its
/// other edges.
fn tree(triangles: u32) -> Draft {
    let mut draft = Draft::new();
    let [a, b] = [0.0, 1.0].map(|x| draft.vertex([x, 0.0, 0.0]));
    let mut open = std::collections::VecDeque::from([(a, b, 1.0_f32)]);
    for _ in 0..triangles {
        let Some((a, b, height)) = open.pop_front() else { break };
        let number = draft.vertex_count() as f32;
        let tip = draft.vertex([number, height, 0.0]);
        draft.face([a, b, tip]);
        open.extend([(tip, b, height + 1.0), (a, tip, height + 1.0)]);
    }
    draft
}

fn tetrahedra(triangles: u32) -> Draft {
    let mut draft = Draft::new();
    for i in 0..triangles / 4 {
        let v = draft
            .vertices(4, |corner| [(2 * i + corner % 2) as f32, (corner / 2) as f32, (corner % 3) as f32]);
        [[0, 1, 2], [0, 2, 3], [0, 3, 1], [3, 2, 1]].iter().for_each(|face| draft.face(face.map(|c| v + c)));
    }
    draft
}

/// A ribbon with one more triangle on every second boundary edge, which gives one end per tooth.
fn comb(triangles: u32) -> Draft {
    let mut draft = Draft::new();
    let length = triangles / 3;
    draft.vertices(2 * length + 2, |v| [(v / 2) as f32, (v % 2) as f32, 0.0]);
    for i in 0..length {
        let v = 2 * i;
        draft.face([v, v + 2, v + 3]);
        draft.face([v, v + 3, v + 1]);
        let tip = draft.vertex([i as f32 + 0.5, 2.0, 0.0]);
        draft.face([v + 1, v + 3, tip]);
    }
    draft
}
