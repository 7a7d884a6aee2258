//! The cost of sending strips with a mesh: the entropy of the links between their triangles.
//!
//! Progressive strips as published need the strips of the full mesh in the stream. If the triangles
//! and their neighbours are known, one bit per edge of two triangles describes the strips: whether
//! a strip crosses the edge. The estimate codes these bits with adaptive probabilities. Their
//! context is what is known of both triangles: the number of crossed edges, and of undecided edges.
//! An encoder with more context needs fewer bits; one with less adapted tables needs more.

use std::collections::{HashMap, HashSet};

use tristrip::{Mesh, Strips};

/// The known links of a triangle, and its undecided edges of two triangles.
#[derive(Debug, Clone, Copy, Default)]
struct Known {
    links: usize,
    open: usize,
}

/// Returns the entropy of the links, in bits, for strips that draw the triangles of a mesh.
///
/// ```
/// use tristrip::{Faces, Mesh, StripifyOptions, stripify};
/// use tristrip_bench::strip_links::bits;
/// let quad = |i: u32| [i, i + 1, i + 9, i + 9, i + 1, i + 10];
/// let faces = Faces::from_triangles((0..8).flat_map(|y| (0..8).flat_map(move |x| quad(9 * y + x))).collect())?;
/// let mesh = Mesh::new((0..81).map(|i| [(i % 9) as f32, (i / 9) as f32, 0.0]).collect::<Vec<_>>(), faces)?;
/// let strips = stripify(&mesh, &StripifyOptions::default())?;
/// let bits = bits(&mesh, &strips);
/// assert!(bits > 10.0 && bits < 2.0 * 128.0, "{bits}");
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn bits(mesh: &Mesh, strips: &Strips) -> f64 {
    let sides = |[a, b, c]: [u32; 3]| [[a, b], [b, c], [c, a]];
    // 1. The edges that strips cross, from the lower to the higher vertex.
    let sorted = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
    let mut crossed = HashSet::new();
    for strip in strips.iter() {
        let mut alone = Strips::default();
        alone.push(strip);
        let triangles: Vec<[u32; 3]> = alone.triangles().collect();
        for pair in triangles.windows(2) {
            let back = sides(pair[1]).map(|[a, b]| [b, a]);
            for side in sides(pair[0]).into_iter().filter(|side| back.contains(side)) {
                crossed.insert(sorted(side));
            }
        }
    }
    // 2. The edges of two triangles.
    let triangles: Vec<[u32; 3]> = mesh.faces().iter().map(|face| [face[0], face[1], face[2]]).collect();
    let mut owners: HashMap<[u32; 2], usize> = HashMap::new();
    for (t, &triangle) in triangles.iter().enumerate() {
        owners.extend(sides(triangle).map(|side| (side, t)));
    }
    let neighbour = |[a, b]: [u32; 2]| owners.get(&[b, a]).copied();
    let mut known: Vec<Known> = triangles
        .iter()
        .map(|&t| Known { links: 0, open: sides(t).into_iter().filter_map(neighbour).count() })
        .collect();
    // 3. The bits of the edges, each coded at the first of its triangles.
    let mut counts = [[1.0_f64; 2]; 256];
    let mut sum = 0.0;
    for (t, &triangle) in triangles.iter().enumerate() {
        for side in sides(triangle) {
            let Some(other) = neighbour(side).filter(|&other| other > t) else { continue };
            let [here, there] = [t, other].map(|i| known[i].links.min(3) * 4 + known[i].open.min(3));
            let bit = usize::from(crossed.contains(&sorted(side)));
            let count = &mut counts[here * 16 + there];
            sum -= (count[bit] / (count[0] + count[1])).log2();
            count[bit] += 1.0;
            for i in [t, other] {
                known[i].links += bit;
                known[i].open = known[i].open.saturating_sub(1);
            }
        }
    }
    sum
}
