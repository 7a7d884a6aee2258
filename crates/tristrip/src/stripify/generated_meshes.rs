//! Generated meshes of many kinds, for the tests of the methods.

use proptest::prelude::*;

use crate::dual::DualGraph;
use crate::mesh::{Faces, Mesh};
use crate::prepare::PreparedFaces;

/// A component of a generated mesh.
#[derive(Debug, Clone)]
pub(super) enum MeshPart {
    /// Quadrilaterals in rows. Bits select which are omitted and which are cut into two triangles.
    Grid { width: u32, height: u32, holes: u64, cut: u64 },
    /// Quadrilaterals, closed in both directions.
    Torus { around: u32, through: u32, cut: u64 },
    /// Rings of quadrilaterals between two poles.
    Sphere { around: u32, rings: u32, cut: u64 },
    /// Triangles around a vertex.
    Fan { size: u32, closed: bool },
    /// Triangles that share one edge, alternating between its two sides.
    Fins { size: u32 },
    /// Triangles over a few vertices, some of them degenerate or duplicate.
    Soup { corners: Vec<[u32; 3]> },
    /// One face.
    Polygon { size: u32 },
}

impl MeshPart {
    /// Returns the polygons, with vertices from 0.
    pub(super) fn polygons(&self) -> Vec<Vec<u32>> {
        match *self {
            Self::Grid { width, height, holes, cut } => {
                let v = |x, y| y * (width + 1) + x;
                cells(width, height, cut, holes, |x, y| [v(x, y), v(x + 1, y), v(x + 1, y + 1), v(x, y + 1)])
            }
            Self::Torus { around, through, cut } => {
                let v = |x, y| y % through * around + x % around;
                cells(around, through, cut, 0, |x, y| [v(x, y), v(x + 1, y), v(x + 1, y + 1), v(x, y + 1)])
            }
            Self::Sphere { around, rings, cut } => {
                let v = |x, y| 2 + y * around + x % around;
                let quads =
                    cells(around, rings, cut, 0, |x, y| [v(x, y), v(x + 1, y), v(x + 1, y + 1), v(x, y + 1)]);
                let caps = (0..around)
                    .flat_map(|x| [vec![0, v(x + 1, 0), v(x, 0)], vec![1, v(x, rings), v(x + 1, rings)]]);
                quads.into_iter().chain(caps).collect()
            }
            Self::Fan { size, closed } => {
                let rim = |i| 1 + if closed { i % size } else { i };
                (0..size).map(|i| vec![0, rim(i), rim(i + 1)]).collect()
            }
            Self::Fins { size } => {
                (0..size).map(|i| if i % 2 == 0 { vec![0, 1, 2 + i] } else { vec![1, 0, 2 + i] }).collect()
            }
            Self::Soup { ref corners } => corners.iter().map(|c| c.to_vec()).collect(),
            Self::Polygon { size } => vec![(0..size).collect()],
        }
    }
}

/// Returns the cells of a lattice. One bit per cell, repeated after 64 cells, selects whether it is
/// omitted or cut into two triangles.
fn cells(
    width: u32,
    height: u32,
    cut: u64,
    holes: u64,
    corners: impl Fn(u32, u32) -> [u32; 4],
) -> Vec<Vec<u32>> {
    let cells = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let bit = |bits: u64, i: usize| bits >> (i % 64) & 1 == 1;
    let kept = cells.enumerate().filter(|&(i, _)| !bit(holes, i));
    kept.flat_map(|(i, (x, y))| {
        let [a, b, c, d] = corners(x, y);
        if bit(cut, i) { vec![vec![a, b, c], vec![a, c, d]] } else { vec![vec![a, b, c, d]] }
    })
    .collect()
}

/// Generates a part. With `all_cut` all of its faces are triangles.
fn part(all_cut: bool) -> impl Strategy<Value = MeshPart> {
    let bits = move || if all_cut { Just(u64::MAX).boxed() } else { any::<u64>().boxed() };
    let holes = || prop_oneof![Just(0), any::<u64>().prop_map(|bits| bits & bits >> 7 & bits >> 13)];
    let largest = if all_cut { 3 } else { 9_u32 };
    prop_oneof![
        4 => (1..9_u32, 1..9_u32, holes(), bits())
            .prop_map(|(width, height, holes, cut)| MeshPart::Grid { width, height, holes, cut }),
        2 => (3..8_u32, 3..8_u32, bits()).prop_map(|(around, through, cut)| MeshPart::Torus { around, through, cut }),
        2 => (3..8_u32, 1..5_u32, bits()).prop_map(|(around, rings, cut)| MeshPart::Sphere { around, rings, cut }),
        1 => (3..12_u32, any::<bool>()).prop_map(|(size, closed)| MeshPart::Fan { size, closed }),
        1 => (2..6_u32).prop_map(|size| MeshPart::Fins { size }),
        1 => prop::collection::vec(prop::array::uniform3(0..6_u32), 1..12).prop_map(|corners| MeshPart::Soup { corners }),
        1 => (3..=largest).prop_map(|size| MeshPart::Polygon { size }),
    ]
}

/// Generates the polygons of several parts: some faces are duplicate, some reversed, and the order
/// may be shuffled.
pub(crate) fn polygons(all_cut: bool, parts: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Vec<u32>>> {
    let whole = prop::collection::vec(part(all_cut), parts).prop_map(|parts| {
        let mut first = 0;
        let mut all = Vec::new();
        for part in parts {
            let polygons = part.polygons();
            all.extend(polygons.iter().map(|polygon| polygon.iter().map(|v| v + first).collect::<Vec<_>>()));
            first = all.iter().flatten().max().map_or(0, |v| v + 1);
        }
        all
    });
    let changes = prop::collection::vec((any::<prop::sample::Index>(), any::<bool>()), 0..4);
    let changed = (whole, changes).prop_map(|(mut polygons, changes)| {
        for (index, is_doubled) in changes {
            if !polygons.is_empty() {
                let index = index.index(polygons.len());
                if is_doubled {
                    polygons.push(polygons[index].clone());
                } else {
                    polygons[index].reverse();
                }
            }
        }
        polygons
    });
    let changed = changed.boxed();
    prop_oneof![changed.clone(), changed.prop_shuffle()]
}

/// Generates the dual graph of triangles in many components.
pub(super) fn triangle_graph() -> impl Strategy<Value = DualGraph> {
    polygons(true, 1..9)
        .prop_map(|polygons| DualGraph::new(PreparedFaces::new(&mesh(&polygons), false).faces()))
}

/// Creates a mesh of polygons whose vertices are all at the origin.
pub(super) fn mesh(polygons: &[Vec<u32>]) -> Mesh {
    let count = polygons.iter().flatten().max().map_or(0, |&v| v as usize + 1);
    Mesh::new(vec![[0.0; 3]; count], Faces::from_polygons(polygons).unwrap()).unwrap()
}
