//! Shapes with edges or vertices of many faces, and with repeated faces.

use super::draft::{Cut, Draft, Order, Shape};
use super::surfaces::{circle, poles};

/// The shapes of this family.
pub(super) const SHAPES: &[Shape] = &[
    ("book on one edge", |n| books(n, 1)),
    ("100 books", |n| books(n, 100)),
    ("book of quads", book_of_quads),
    ("three poles", |n| poles(n, 3)),
    ("grid with twins of opposite winding", |n| plane(n / 2).repeated(1, true)),
    ("grid with twins, shuffled", |n| plane(n / 2).repeated(1, true).in_order(Order::Shuffled)),
    ("book with twins of opposite winding", |n| books(n / 2, 1).repeated(1, true)),
    ("grid, every triangle eight times", |n| plane(n / 8).repeated(7, false)),
    ("one triangle", |n| one_triangle(n, false)),
    ("one triangle and its reverse", |n| one_triangle(n, true)),
    ("isolated triangles around a vertex", star),
    ("walls of quads", |n| walls(n, Cut::Quads)),
    ("walls of triangles", |n| walls(n, Cut::Random)),
    ("all triples of vertices", triples),
    ("random triangles on few vertices", soup),
];

/// Books: triangles in both directions that share one edge.
fn books(triangles: u32, count: u32) -> Draft {
    let mut draft = Draft::new();
    let pages = triangles / count;
    for book in 0..count {
        let z = book as f32;
        let [a, b] = [[0.0, 0.0, z], [0.0, 0.0, z + 0.5]].map(|position| draft.vertex(position));
        let first = draft.vertices(pages, |i| [circle(i, pages)[0], circle(i, pages)[1], z]);
        for page in 0..pages {
            draft.face(if page % 2 == 0 { [a, b, first + page] } else { [b, a, first + page] });
        }
    }
    draft
}

fn book_of_quads(triangles: u32) -> Draft {
    let mut draft = Draft::new();
    let pages = triangles / 2;
    let [a, b] = [0.0, 1.0].map(|z| draft.vertex([0.0, 0.0, z]));
    let low = draft.vertices(pages, |i| circle(i, pages));
    let high = draft.vertices(pages, |i| [circle(i, pages)[0], circle(i, pages)[1], 1.0]);
    for page in 0..pages {
        let mut quad = [a, b, high + page, low + page];
        if page % 2 == 1 {
            quad.reverse();
        }
        draft.face(quad);
    }
    draft
}

/// A square of triangles with random diagonals.
fn plane(triangles: u32) -> Draft {
    let mut draft = Draft::new();
    let side = (triangles / 2).isqrt();
    let row = side + 1;
    draft.vertices(row * row, |v| [(v % row) as f32, (v / row) as f32, 0.0]);
    for v in (0..side).flat_map(|y| (0..side).map(move |x| y * row + x)) {
        draft.quad([v, v + 1, v + row + 1, v + row], Cut::Random);
    }
    draft
}

fn one_triangle(triangles: u32, with_reverse: bool) -> Draft {
    let mut draft = Draft::new();
    draft.vertices(3, |i| circle(i, 3));
    (0..triangles).for_each(|i| draft.face(if with_reverse && i % 2 == 1 { [2, 1, 0] } else { [0, 1, 2] }));
    draft
}

fn star(triangles: u32) -> Draft {
    let mut draft = Draft::new();
    let hub = draft.vertex([0.0; 3]);
    let first = draft.vertices(2 * triangles, |i| circle(i, 2 * triangles));
    (0..triangles).for_each(|i| draft.face([hub, first + 2 * i, first + 2 * i + 1]));
    draft
}

/// Returns the largest integer whose cube is at most `n`.
fn cube_root(n: u32) -> u32 {
    (0..n).take_while(|i| (i + 1).pow(3) <= n).count() as u32
}

/// All walls between the cells of a cube. Most edges have four faces.
fn walls(triangles: u32, cut: Cut) -> Draft {
    let side = cube_root(triangles / 6);
    let mut draft = Draft::new();
    let row = side + 1;
    let steps = [1, row, row * row];
    draft.vertices(row * row * row, |v| [(v % row) as f32, (v / row % row) as f32, (v / row / row) as f32]);
    for v in 0..row * row * row {
        let at = steps.map(|step| v / step % row);
        for axis in 0..3 {
            let [i, j] = [(axis + 1) % 3, (axis + 2) % 3];
            if at[i] < side && at[j] < side {
                draft.quad([v, v + steps[i], v + steps[i] + steps[j], v + steps[j]], cut);
            }
        }
    }
    draft
}

fn triples(triangles: u32) -> Draft {
    let vertices = cube_root(6 * triangles) + 2;
    let mut draft = Draft::new();
    draft.vertices(vertices, |i| circle(i, vertices));
    let all = (0..vertices).flat_map(|a| {
        (0..a)
            .flat_map(move |b| (0..b).map(move |c| if (a + b + c) % 2 == 0 { [a, b, c] } else { [b, a, c] }))
    });
    all.take(triangles as usize).for_each(|triangle| draft.face(triangle));
    draft
}

fn soup(triangles: u32) -> Draft {
    let vertices = triangles.isqrt();
    let mut draft = Draft::new();
    draft.vertices(vertices, |i| circle(i, vertices));
    for _ in 0..triangles {
        let a = draft.below(vertices);
        let b = (a + 1 + draft.below(vertices - 2)) % vertices;
        let c = (b + 1 + draft.below(vertices - 2)) % vertices;
        draft.face([a, b, if c == a { (a + 1 + u32::from(b == (a + 1) % vertices)) % vertices } else { c }]);
    }
    draft
}
