//! Regular surfaces: ribbons, fans, grids, tori and Klein bottles, with several face orders.

use std::f32::consts::TAU;

use super::draft::{Cut, Draft, Order, Shape};

/// The shapes of this family.
pub(super) const SHAPES: &[Shape] = &[
    ("ribbon", |n| ribbon(n, Cut::Regular)),
    ("ribbon, shuffled", |n| ribbon(n, Cut::Regular).in_order(Order::Shuffled)),
    ("ribbon, bits reversed", |n| ribbon(n, Cut::Regular).in_order(Order::BitReversed)),
    ("ribbon, alternate winding", |n| ribbon(n, Cut::Regular).with_alternate_winding()),
    ("ribbon, random diagonals", |n| ribbon(n, Cut::Random)),
    ("ribbon, random diagonals, shuffled", |n| ribbon(n, Cut::Random).in_order(Order::Shuffled)),
    ("ribbon of quads", |n| ribbon(n, Cut::Quads)),
    ("ribbon of quads, shuffled", |n| ribbon(n, Cut::Quads).in_order(Order::Shuffled)),
    ("Moebius ribbon", |n| moebius(n, Cut::Regular)),
    ("Moebius ribbon, shuffled", |n| moebius(n, Cut::Regular).in_order(Order::Shuffled)),
    ("Moebius ribbon of quads", |n| moebius(n, Cut::Quads)),
    ("closed ribbon, shuffled", |n| {
        closed(n / 2, 1, Twist::Cylinder, Cut::Regular).in_order(Order::Shuffled)
    }),
    ("fan", |n| fan(n, false)),
    ("fan, closed, shuffled", |n| fan(n, true).in_order(Order::Shuffled)),
    ("bipyramid", |n| poles(n, 2)),
    ("bipyramid, shuffled", |n| poles(n, 2).in_order(Order::Shuffled)),
    ("torus", |n| square(n, Twist::Torus, Cut::Regular)),
    ("torus of quads", |n| square(n, Twist::Torus, Cut::Quads)),
    ("torus of quads, shuffled", |n| square(n, Twist::Torus, Cut::Quads).in_order(Order::Shuffled)),
    ("thin torus", |n| closed(n / 6, 3, Twist::Torus, Cut::Regular)),
    ("Klein bottle", |n| square(n, Twist::Klein, Cut::Regular)),
    ("Klein bottle of quads", |n| square(n, Twist::Klein, Cut::Quads)),
    ("Klein bottle of quads, shuffled", |n| square(n, Twist::Klein, Cut::Quads).in_order(Order::Shuffled)),
    ("thin Klein bottle of quads", |n| closed(n / 6, 3, Twist::Klein, Cut::Quads)),
    ("cylinder of quads", |n| square(n, Twist::Cylinder, Cut::Quads)),
    ("grid", |n| grid(n, Cut::Regular)),
    ("grid of quads", |n| grid(n, Cut::Quads)),
    ("grid, random diagonals", |n| grid(n, Cut::Random)),
    ("grid, random diagonals, shuffled", |n| grid(n, Cut::Random).in_order(Order::Shuffled)),
    ("long thin grid", |n| lattice(n / 8, 4, Cut::Random)),
    ("sphere with poles", sphere),
];

/// Returns the integer square root of half a number of triangles: the side of a square of
/// quadrilaterals.
fn side(triangles: u32) -> u32 {
    (triangles / 2).isqrt()
}

fn ribbon(triangles: u32, cut: Cut) -> Draft {
    lattice(triangles / 2, 1, cut)
}

fn grid(triangles: u32, cut: Cut) -> Draft {
    lattice(side(triangles), side(triangles), cut)
}

/// A rectangle of quadrilaterals.
fn lattice(width: u32, height: u32, cut: Cut) -> Draft {
    let mut draft = Draft::new();
    let row = width + 1;
    draft.vertices(row * (height + 1), |v| [(v % row) as f32, (v / row) as f32, 0.1 * (v % 7) as f32]);
    for y in 0..height {
        for x in 0..width {
            let v = y * row + x;
            draft.quad([v, v + 1, v + row + 1, v + row], cut);
        }
    }
    draft
}

/// A ribbon whose end is joined to its start with a half twist.
fn moebius(triangles: u32, cut: Cut) -> Draft {
    let length = triangles / 2;
    let mut draft = Draft::new();
    draft.vertices(2 * length, |v| {
        let angle = TAU * (v / 2) as f32 / length as f32;
        let across = if v % 2 == 0 { -1.0 } else { 1.0 };
        let radius = 9.0 + across * (0.5 * angle).cos();
        [radius * angle.cos(), radius * angle.sin(), across * (0.5 * angle).sin()]
    });
    for i in 0..length {
        let [c, d] = if i + 1 < length { [2 * i + 2, 2 * i + 3] } else { [1, 0] };
        draft.quad([2 * i, c, d, 2 * i + 1], cut);
    }
    draft
}

/// How a lattice is closed: in one direction, or in both, the latter with or without a reversal.
#[derive(Clone, Copy, PartialEq)]
enum Twist {
    Cylinder,
    Torus,
    Klein,
}

fn square(triangles: u32, twist: Twist, cut: Cut) -> Draft {
    closed(side(triangles), side(triangles), twist, cut)
}

/// A lattice that is closed in one direction and, except for the cylinder, in the other.
fn closed(around: u32, through: u32, twist: Twist, cut: Cut) -> Draft {
    let mut draft = Draft::new();
    let rows = through + u32::from(twist == Twist::Cylinder);
    draft.vertices(around * rows, |v| {
        let u = TAU * (v % around) as f32 / around as f32;
        let w = TAU * (v / around) as f32 / rows as f32;
        let radius = 3.0 + w.cos();
        [radius * u.cos(), radius * u.sin(), w.sin()]
    });
    let at = |x: u32, y: u32| {
        let x = if twist == Twist::Klein && y == through { 2 * around - x } else { x };
        y % rows * around + x % around
    };
    for y in 0..through {
        for x in 0..around {
            draft.quad([at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)], cut);
        }
    }
    draft
}

/// Triangles around a vertex.
fn fan(triangles: u32, is_closed: bool) -> Draft {
    let mut draft = Draft::new();
    let hub = draft.vertex([0.0; 3]);
    let rim = triangles + u32::from(!is_closed);
    draft.vertices(rim, |i| circle(i, rim));
    (0..triangles).for_each(|i| draft.face([hub, 1 + i, 1 + (i + 1) % rim]));
    draft
}

/// Triangles between a circle and each of several poles. Two poles make a bipyramid; more poles
/// make edges of more than two faces.
pub(super) fn poles(triangles: u32, count: u32) -> Draft {
    let mut draft = Draft::new();
    let rim = triangles / count;
    draft.vertices(count, |pole| [0.0, 0.0, pole as f32 - 0.5]);
    draft.vertices(rim, |i| circle(i, rim));
    for i in 0..rim {
        let [a, b] = [count + i, count + (i + 1) % rim];
        (0..count).for_each(|pole| draft.face(if pole % 2 == 0 { [pole, b, a] } else { [pole, a, b] }));
    }
    draft
}

/// Returns a point of the unit circle.
pub(super) fn circle(i: u32, count: u32) -> [f32; 3] {
    let (y, x) = (TAU * i as f32 / count as f32).sin_cos();
    [x, y, 0.0]
}

/// A few rings of quadrilaterals between two poles. Each pole has as many triangles as a ring has
/// quadrilaterals.
fn sphere(triangles: u32) -> Draft {
    let around = triangles / 8;
    let mut draft = closed(around, 3, Twist::Cylinder, Cut::Quads);
    let [south, north] = [-2.0, 2.0].map(|z| draft.vertex([0.0, 0.0, z]));
    for x in 0..around {
        let next = (x + 1) % around;
        draft.face([south, next, x]);
        draft.face([north, 3 * around + x, 3 * around + next]);
    }
    draft
}
