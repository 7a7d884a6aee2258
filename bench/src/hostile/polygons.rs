//! Shapes of polygons with many corners.

use super::draft::{Cut, Draft, Shape};
use super::surfaces::circle;

/// The shapes of this family.
pub(super) const SHAPES: &[Shape] = &[
    ("polygon", |n| rim(n + 2, 1.0, 1)),
    ("pillow of two polygons", |n| rim(n / 2 + 2, 1.0, 2)),
    ("star", |n| rim(n + 2, 0.5, 1)),
    ("pillow of two stars", |n| rim(n / 2 + 2, 0.5, 2)),
    ("comb polygon", comb),
    ("spiral polygon", spiral),
    ("prism", prism),
    ("polygons of 1,000 corners", |n| many_polygons(n, 1002, 1.0)),
    ("stars of 1,000 corners", |n| many_polygons(n, 1002, 0.5)),
    ("polygons around 255 shared vertices", around_shared_vertices),
    ("polygons over the same 256 vertices", over_the_same_vertices),
    ("sliding polygons of 256 corners", sliding_polygons),
];

/// One or two polygons over a circle, the second reversed. Every second corner is moved inward.
fn rim(corners: u32, inner: f32, count: u32) -> Draft {
    let mut draft = Draft::new();
    draft.vertices(corners, |i| circle(i, corners).map(|x| if i % 2 == 1 { inner * x } else { x }));
    draft.face(0..corners);
    if count == 2 {
        draft.face((0..corners).rev());
    }
    draft
}

fn comb(triangles: u32) -> Draft {
    let mut draft = Draft::new();
    let corners = triangles / 2 * 2 + 2;
    let top = corners - 2;
    draft.vertices(top, |i| [i as f32, if i % 2 == 0 { 1.0 } else { 9.0 }, 0.0]);
    draft.vertex([top as f32, 0.0, 0.0]);
    draft.vertex([-1.0, 0.0, 0.0]);
    draft.face((0..corners).rev());
    draft
}

fn spiral(triangles: u32) -> Draft {
    let mut draft = Draft::new();
    let half = triangles / 2 + 1;
    draft.vertices(2 * half, |v| {
        let (i, wide) = if v < half { (v, 0.0) } else { (2 * half - 1 - v, 0.4) };
        let angle = 0.1 * i as f32;
        let radius = 1.0 + wide + angle / std::f32::consts::TAU;
        [radius * angle.cos(), radius * angle.sin(), 0.0]
    });
    draft.face(0..2 * half);
    draft
}

fn prism(triangles: u32) -> Draft {
    let mut draft = Draft::new();
    let corners = triangles / 4 + 1;
    for z in [0.0, 1.0] {
        draft.vertices(corners, |i| [circle(i, corners)[0], circle(i, corners)[1], z]);
    }
    draft.face((0..corners).rev());
    draft.face(corners..2 * corners);
    for i in 0..corners {
        let next = (i + 1) % corners;
        draft.quad([i, next, corners + next, corners + i], Cut::Quads);
    }
    draft
}

fn many_polygons(triangles: u32, corners: u32, inner: f32) -> Draft {
    let mut draft = Draft::new();
    for _ in 0..(triangles / (corners - 2)).max(1) {
        let corners = corners.min(triangles + 2);
        let at = |i| circle(i, corners).map(|x| if i % 2 == 1 { inner * x } else { x });
        let first = draft.vertices(corners, at);
        draft.face(first..first + corners);
    }
    draft
}

/// Polygons with 255 common corners and one corner of their own.
fn around_shared_vertices(triangles: u32) -> Draft {
    let mut draft = Draft::new();
    draft.vertices(255, |i| circle(i, 256));
    for polygon in 0..(triangles / 254).max(1) {
        let own = draft.vertex([1.0, 0.0, polygon as f32]);
        let common = (0..255).map(move |i| (i + 7 * polygon) % 255);
        draft.face(common.chain([own]));
    }
    draft
}

fn over_the_same_vertices(triangles: u32) -> Draft {
    let mut draft = Draft::new();
    draft.vertices(256, |i| circle(i, 256));
    (0..(triangles / 254).max(1)).for_each(|polygon| draft.face((0..256).map(|i| (i + 11 * polygon) % 256)));
    draft
}

/// Polygons that share all but eight corners with the previous one.
fn sliding_polygons(triangles: u32) -> Draft {
    let mut draft = Draft::new();
    let count = (triangles / 254).max(1);
    draft.vertices(8 * count + 256, |i| circle(i, 8 * count + 256));
    (0..count).for_each(|polygon| draft.face(8 * polygon..8 * polygon + 256));
    draft
}
