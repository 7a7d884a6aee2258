//! Meshes, strips and collapse sequences for the tests of level models.

use proptest::prelude::*;

use tristrip::{CollapseSequence, Faces, Mesh, Method, Rename, StripifyOptions, Strips, stripify};

/// Strips of a mesh, and a collapse sequence over the triangles that they draw.
#[derive(Debug, Clone)]
pub(crate) struct Sample {
    pub(crate) strips: Strips,
    pub(crate) sequence: CollapseSequence,
}

/// A grid of quadrilaterals, with random diagonals and a random order of triangles, optionally
/// closed to a torus.
fn grid() -> impl Strategy<Value = Vec<[u32; 3]>> {
    (2..6_u32, 2..6_u32, any::<bool>(), any::<u64>()).prop_map(|(w, h, is_torus, diagonals)| {
        let (columns, rows) = if is_torus { (w + 1, h + 1) } else { (w, h) };
        let (across, down) = if is_torus { (columns, rows) } else { (columns + 1, rows + 1) };
        let vertex = |x: u32, y: u32| (y % down) * across + x % across;
        let mut triangles = Vec::new();
        for y in 0..rows {
            for x in 0..columns {
                let [a, b, c, d] = [vertex(x, y), vertex(x + 1, y), vertex(x + 1, y + 1), vertex(x, y + 1)];
                if diagonals >> ((y * 7 + x) % 64) & 1 == 0 {
                    triangles.extend([[a, b, c], [a, c, d]]);
                } else {
                    triangles.extend([[a, b, d], [b, c, d]]);
                }
            }
        }
        triangles
    })
}

/// Arbitrary triangles over a few vertices: edges of many triangles, duplicates, both windings.
fn soup() -> impl Strategy<Value = Vec<[u32; 3]>> {
    prop::collection::vec((0..9_u32, 1..9_u32, 1..9_u32), 1..20).prop_map(|triangles| {
        let corners = triangles.into_iter().map(|(a, b, c)| [a, (a + b) % 9, (a + b + c) % 9]);
        corners.filter(|[a, b, c]| a != b && b != c && a != c).collect()
    })
}

/// Meshes with strips of several methods and with collapses: mostly along edges, sometimes of two
/// vertices at once, or of any two vertices.
pub(crate) fn samples() -> impl Strategy<Value = Sample> {
    samples_of(prop_oneof![4 => grid(), 1 => soup()])
}

fn samples_of(mesh: impl Strategy<Value = Vec<[u32; 3]>>) -> impl Strategy<Value = Sample> {
    (mesh, 0..4_usize, prop::collection::vec(any::<[u16; 4]>(), 0..30)).prop_map(
        |(triangles, method, choices)| {
            let strips = strips_of(&triangles, method);
            let list = strips.to_list();
            let vertex_count = list.iter().max().map_or(0, |&v| v + 1);
            let sequence = collapse(vertex_count, &list, &choices);
            Sample { strips, sequence }
        },
    )
}

fn strips_of(triangles: &[[u32; 3]], method: usize) -> Strips {
    let faces = Faces::from_triangles(triangles.concat()).unwrap();
    let mesh = Mesh::new(vec![[0.0; 3]; 64], faces).unwrap();
    let method = [Method::STRIPE, Method::Sequential, Method::Input, Method::Fewest][method];
    stripify(&mesh, &StripifyOptions::default().with_method(method)).unwrap()
}

/// Applies the selected collapses that are possible.
fn collapse(vertex_count: u32, list: &[u32], choices: &[[u16; 4]]) -> CollapseSequence {
    let mut now = list.to_vec();
    let mut collapses: Vec<Vec<Rename>> = Vec::new();
    for &[triangle, corner, other, kind] in choices {
        let count = now.len() / 3;
        let any = |choice: u16| now[choice as usize % now.len()];
        let edge = |choice: u16, corner: u16| {
            let t = &now[3 * (choice as usize % count)..];
            (t[corner as usize % 3], t[(corner as usize + 1) % 3])
        };
        if now.is_empty() {
            break;
        }
        let pairs = match kind % 8 {
            0 => vec![(any(triangle), any(other))],
            1 => vec![edge(triangle, corner), edge(other, corner / 3)],
            _ => vec![edge(triangle, corner)],
        };
        let mut renames: Vec<Rename> = Vec::new();
        for (removed, kept) in pairs {
            let is_new = |r: &Rename| ![removed, kept].contains(&r.removed) && removed != r.kept;
            if removed != kept && renames.iter().all(is_new) {
                renames.push(Rename { removed, kept });
            }
        }
        for r in &renames {
            now.iter_mut().filter(|v| **v == r.removed).for_each(|v| *v = r.kept);
        }
        let is_real = |t: &&[u32]| t[0] != t[1] && t[1] != t[2] && t[0] != t[2];
        now = now.chunks_exact(3).filter(is_real).flatten().copied().collect();
        if !renames.is_empty() {
            collapses.push(renames);
        }
    }
    let renames = collapses.iter().map(|renames| (&renames[..], 0.0));
    CollapseSequence::from_collapses(vertex_count as usize, list.to_vec(), renames).unwrap()
}
