//! The proof by vertex id that strips draw exactly the faces that they were made from: each once, with its winding.
//!
//! # Algorithm
//! *Triangles*: the two multisets of oriented triangles, each rotated to begin with its lowest vertex, are sorted and compared.
//!
//! *Polygons*: a triangle belongs to a polygon whose corners include its own. Polygons to which the same triangle may belong
//! form a group, usually of one polygon. A group is proven if it has the k − 2 triangles of each of its polygons, and its
//! triangles' oriented edges add up to the polygons' oriented edges: diagonals cancel, boundaries remain. Any diagonals are therefore
//! accepted, but nothing is missing, doubled, flipped or outside.
//!
//! Corners that repeat the one before, and faces with fewer than three corners after that, draw nothing on either side. For a polygon
//! that contains a vertex twice only the oriented edges are compared, as some of its triangles may be degenerate.
//!
//! # Complexity
//! O(n log n) time, 24 bytes per triangle; for polygons O(n · valence) time.

use crate::csr::Csr;
use crate::mesh::{Faces, Mesh, canonical_triangles, triangles_of, without_repeats};
use crate::strip::Strips;
use crate::union_find::UnionFind;

/// The result of a successful proof.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Proof {
    /// Number of faces compared.
    pub faces: usize,
    /// Number of triangles that draw them.
    pub triangles: usize,
}

/// The reason why triangles do not draw the faces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Unproven {
    /// Triangles differ from the faces.
    #[error("{missing} triangles are missing and {extra} are extra or flipped; the first is {first:?}")]
    Triangles {
        /// Number of faces that no triangle draws.
        missing: usize,
        /// Number of triangles without a face.
        extra: usize,
        /// The vertices of the first of them.
        first: [u32; 3],
    },
    /// A triangle is not part of any polygon.
    #[error("triangle {triangle:?} lies in no face")]
    Outside {
        /// Its vertices.
        triangle: [u32; 3],
    },
    /// A polygon has too few or too many triangles.
    #[error("face {face}: found {found} triangles, expected {expected}")]
    Count {
        /// A face of the group.
        face: u32,
        /// Number of triangles in the group.
        found: usize,
        /// Number of triangles of its polygons.
        expected: usize,
    },
    /// The edges of a polygon's triangles do not add up to those of the polygon.
    #[error("face {face}: its triangles do not have its boundary at edge {edge:?}")]
    Boundary {
        /// A face of the group.
        face: u32,
        /// The vertices of the first edge that differs.
        edge: [u32; 2],
    },
}

/// Proves that strips draw a mesh's faces, each once, with its winding.
///
/// # Errors
/// The first difference found.
///
/// ```
/// use tristrip::{Faces, Mesh, Strips, verify::verify};
/// let mesh = Mesh::new(vec![[0.0; 3]; 4], Faces::from_triangles(vec![0, 1, 2, 2, 1, 3])?)?;
/// let mut strips = Strips::default();
/// strips.push(&[0, 1, 2, 3]);
/// assert!(verify(&mesh, &strips).is_ok());
/// strips.push(&[0, 1, 2]);
/// assert!(verify(&mesh, &strips).is_err());
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn verify(mesh: &Mesh, strips: &Strips) -> Result<Proof, Unproven> {
    let triangles: Vec<[u32; 3]> = strips.triangles().collect();
    verify_drawing(mesh.faces(), &triangles)
}

/// Proves that triangles draw faces; both refer to the same vertices.
///
/// # Errors
/// The first difference found.
pub fn verify_drawing(faces: &Faces, triangles: &[[u32; 3]]) -> Result<Proof, Unproven> {
    let proof = Proof { faces: faces.face_count(), triangles: triangles.len() };
    let drawn = canonical_triangles(triangles.iter().copied());
    match faces.as_triangles() {
        Some(corners) => {
            let expected = canonical_triangles(triangles_of(corners));
            if expected == drawn { Ok(proof) } else { Err(first_difference(&expected, &drawn)) }
        }
        None => verify_polygons(faces, &drawn).map(|()| proof),
    }
}

fn first_difference(expected: &[[u32; 3]], drawn: &[[u32; 3]]) -> Unproven {
    let (mut i, mut j, mut missing, mut extra, mut first) = (0, 0, 0, 0, None);
    while i < expected.len() || j < drawn.len() {
        match (expected.get(i), drawn.get(j)) {
            (Some(a), Some(d)) if a == d => (i, j) = (i + 1, j + 1),
            (Some(a), d) if d.is_none_or(|d| a < d) => {
                first = first.or(Some(*a));
                (i, missing) = (i + 1, missing + 1);
            }
            (_, d) => {
                first = first.or(d.copied());
                (j, extra) = (j + 1, extra + 1);
            }
        }
    }
    Unproven::Triangles { missing, extra, first: first.unwrap_or_default() }
}

/// Polygons without repeated corners, and the polygons around each vertex.
struct IncidentPolygons {
    faces: Faces,
    /// The number of each polygon's face in the input, and whether it contains a vertex twice.
    origin: Vec<(u32, bool)>,
    incident: Csr,
}

impl IncidentPolygons {
    fn new(faces: &Faces) -> Self {
        let (mut corners, mut offsets, mut origin): (Vec<u32>, _, _) = (Vec::new(), vec![0], Vec::new());
        let mut sorted: Vec<u32> = Vec::new();
        let mut polygon: Vec<u32> = Vec::new();
        for (face, all) in faces.iter().enumerate() {
            without_repeats(all, &mut polygon);
            if polygon.len() < 3 {
                continue;
            }
            sorted.clear();
            sorted.extend_from_slice(&polygon);
            sorted.sort_unstable();
            origin.push((face as u32, sorted.windows(2).any(|w| w[0] == w[1])));
            corners.extend_from_slice(&polygon);
            offsets.push(corners.len() as u32);
        }
        let vertex_count = corners.iter().max().map_or(0, |&v| v as usize + 1);
        let sizes = (0_u32..).zip(offsets.windows(2).map(|range| range[1] - range[0]));
        let face_of: Vec<u32> =
            sizes.flat_map(|(face, size)| std::iter::repeat_n(face, size as usize)).collect();
        let mut incident = Csr::group(corners.iter().copied(), vertex_count);
        incident.map_items(|corner| face_of[corner as usize]);
        let faces = Faces::from_offsets(offsets, corners).unwrap_or_default();
        Self { faces, origin, incident }
    }

    /// Returns the polygons that have a vertex as a corner, ascending.
    fn at(&self, vertex: u32) -> &[u32] {
        if (vertex as usize) < self.incident.key_count() { self.incident.row(vertex) } else { &[] }
    }

    /// Calls `each` with every polygon that has all three vertices.
    fn common(&self, triangle: [u32; 3], mut each: impl FnMut(u32)) {
        let mut lists = triangle.map(|v| self.at(v));
        lists.sort_unstable_by_key(|list| list.len());
        let mut last = None;
        for &face in lists[0] {
            #[cfg(test)]
            tests::LOOKUPS.set(tests::LOOKUPS.get() + 1);
            let in_all = lists[1].binary_search(&face).is_ok() && lists[2].binary_search(&face).is_ok();
            if in_all && last != Some(face) {
                each(face);
                last = Some(face);
            }
        }
    }
}

/// Compares sorted triangles with polygons.
fn verify_polygons(faces: &Faces, drawn: &[[u32; 3]]) -> Result<(), Unproven> {
    let corners = IncidentPolygons::new(faces);
    let mut groups = UnionFind::new(corners.faces.face_count());
    let mut owners: Vec<u32> = Vec::with_capacity(drawn.len());
    for (i, &triangle) in drawn.iter().enumerate() {
        // A triangle that is repeated as often as its polygon is looked up once: otherwise the time would be quadratic.
        if i > 0 && drawn[i - 1] == triangle {
            owners.push(owners[i - 1]);
            continue;
        }
        let mut first = None;
        corners.common(triangle, |face| match first {
            None => first = Some(face),
            Some(first) => groups.unite(first, face),
        });
        owners.push(first.ok_or(Unproven::Outside { triangle })?);
    }
    // Triangles and oriented edges of every group: (group, low, high) counts +1 in one direction and −1 in the other.
    let mut count: Vec<(usize, usize, bool)> = vec![(0, 0, false); corners.faces.face_count()];
    let mut edges: Vec<(u32, u32, u32, i32)> =
        Vec::with_capacity(3 * drawn.len() + corners.faces.corner_count());
    let mut add = |group: u32, from: u32, to: u32, sign: i32| {
        edges.push(if from < to { (group, from, to, sign) } else { (group, to, from, -sign) });
    };
    for (face, polygon) in corners.faces.iter().enumerate() {
        let group = groups.find(face as u32);
        let c = &mut count[group as usize];
        c.1 += polygon.len() - 2;
        c.2 |= corners.origin[face].1;
        for (i, &from) in polygon.iter().enumerate() {
            add(group, from, polygon[(i + 1) % polygon.len()], 1);
        }
    }
    for (&face, t) in owners.iter().zip(drawn) {
        let group = groups.find(face);
        count[group as usize].0 += 1;
        (0..3).for_each(|i| add(group, t[i], t[(i + 1) % 3], -1));
    }
    for (group, &(found, expected, repeats)) in count.iter().enumerate() {
        if found != expected && !repeats {
            return Err(Unproven::Count { face: corners.origin[group].0, found, expected });
        }
    }
    edges.sort_unstable_by_key(|e| (e.0, e.1, e.2));
    for edge in edges.chunk_by(|a, b| (a.0, a.1, a.2) == (b.0, b.1, b.2)) {
        if edge.iter().map(|e| e.3).sum::<i32>() != 0 {
            let (group, a, b, _) = edge[0];
            return Err(Unproven::Boundary { face: corners.origin[group as usize].0, edge: [a, b] });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    thread_local! {
        /// Number of polygons that lookups have examined.
        pub(super) static LOOKUPS: Cell<usize> = const { Cell::new(0) };
    }

    fn quads() -> Faces {
        Faces::from_polygons([vec![0, 1, 2, 3], vec![3, 2, 4], vec![2, 1, 5, 6, 7]]).unwrap()
    }

    #[test]
    fn accepts_every_triangulation_and_nothing_else() {
        let good = [[0, 1, 3], [1, 2, 3], [4, 3, 2], [1, 5, 2], [5, 7, 2], [7, 5, 6]];
        assert_eq!(verify_drawing(&quads(), &good), Ok(Proof { faces: 3, triangles: 6 }));
        let changed = |i: usize, t: [u32; 3]| {
            let mut all = good;
            all[i] = t;
            verify_drawing(&quads(), &all).unwrap_err()
        };
        assert!(matches!(changed(0, [0, 1, 2]), Unproven::Boundary { face: 0, .. }), "overlaps");
        assert!(matches!(changed(0, [1, 0, 3]), Unproven::Boundary { face: 0, .. }), "flipped");
        assert!(matches!(changed(2, [4, 3, 1]), Unproven::Outside { triangle: [1, 4, 3] }));
        assert!(matches!(changed(2, [0, 1, 3]), Unproven::Count { .. }), "missing and doubled");
        assert!(matches!(changed(2, [3, 4, 2]), Unproven::Boundary { face: 1, .. }), "flipped");
    }

    #[test]
    fn doubled_polygons_share_a_group() {
        let faces = Faces::from_polygons([[0, 1, 2, 3], [0, 1, 2, 3], [3, 2, 1, 0]]).unwrap();
        let drawn = [[0, 1, 2], [0, 2, 3], [0, 1, 3], [1, 2, 3], [3, 2, 1], [3, 1, 0]];
        assert!(verify_drawing(&faces, &drawn).is_ok());
        assert!(verify_drawing(&faces, &drawn[..5]).is_err());
    }

    #[test]
    fn many_polygons_over_the_same_corners_take_linear_time() {
        let count = 60_000;
        let faces = Faces::from_polygons(vec![[0, 1, 2, 3]; count]).unwrap();
        let drawn = [[0, 1, 2], [0, 2, 3]].repeat(count);
        LOOKUPS.set(0);
        assert!(verify_drawing(&faces, &drawn).is_ok());
        assert!(verify_drawing(&faces, &drawn[1..]).is_err());
        // Each proof examines all polygons once for each of two distinct triangles.
        assert_eq!(LOOKUPS.get(), 2 * 2 * count);
    }

    #[test]
    fn counts_triangles_with_their_winding() {
        let faces = Faces::from_triangles(vec![0, 1, 2, 2, 1, 0, 0, 1, 2, 5, 5, 6]).unwrap();
        assert!(verify_drawing(&faces, &[[1, 2, 0], [0, 1, 2], [0, 2, 1]]).is_ok());
        assert_eq!(
            verify_drawing(&faces, &[[1, 2, 0], [0, 2, 1], [0, 2, 1]]),
            Err(Unproven::Triangles { missing: 1, extra: 1, first: [0, 1, 2] })
        );
    }
}
