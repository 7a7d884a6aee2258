//! The proof that strips draw exactly the faces that they came from: each once, with its winding.
//!
//! # Algorithm
//! *Triangles*: the two multisets of oriented triangles, each rotated to begin with its lowest vertex, are sorted and compared.
//!
//! *Polygons*: a triangle belongs to a polygon whose corners include its own. Polygons that a triangle could belong to in common
//! form a group, mostly of one polygon. A group is proven where it has the k − 2 triangles of each of its polygons, and its
//! triangles' oriented edges add up to the polygons' oriented edges: diagonals cancel, boundaries remain. So diagonals
//! may run as the method liked, but nothing is missing, doubled, flipped or outside.
//!
//! Corners that repeat the one before, and faces without three different corners in a row, draw nothing on either side. A polygon
//! that passes a vertex twice is held to its oriented edges only, as its triangles may lose their area.
//!
//! # Complexity
//! O(n log n) time, 24 bytes a triangle; for polygons O(n · valence) time.

use crate::mesh::{Faces, Mesh, canonical_triangle};
use crate::strip::Strips;
use crate::union_find::UnionFind;

/// What was proven.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Proof {
    /// Faces that were compared.
    pub faces: usize,
    /// Triangles that draw them.
    pub triangles: usize,
}

/// Says why a drawing is not that of the faces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Unproven {
    /// Triangles differ from the faces.
    #[error("{missing} triangles are missing and {extra} are extra or flipped; the first is {first:?}")]
    Triangles {
        /// Faces that no triangle draws.
        missing: usize,
        /// Triangles that no face asks for.
        extra: usize,
        /// The vertices of the first one at fault.
        first: [u32; 3],
    },
    /// A triangle lies in no polygon.
    #[error("triangle {triangle:?} lies in no face")]
    Outside {
        /// Its vertices.
        triangle: [u32; 3],
    },
    /// A polygon has too few or too many triangles.
    #[error("face {face}: found {found} triangles, expected {expected}")]
    Count {
        /// A face of the group that is at fault.
        face: u32,
        /// Triangles that lie in the group.
        found: usize,
        /// Triangles that its polygons make.
        expected: usize,
    },
    /// The edges of a polygon's triangles do not add up to its own.
    #[error("face {face}: its triangles do not have its boundary at edge {edge:?}")]
    Boundary {
        /// A face of the group that is at fault.
        face: u32,
        /// The vertices of the first edge at fault.
        edge: [u32; 2],
    },
}

/// Proves that strips draw a mesh's faces, each once, with its winding.
///
/// # Errors
/// What is wrong, with the first place.
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

/// Proves that triangles draw faces, where both name the same vertices alike.
///
/// # Errors
/// What is wrong, with the first place.
pub fn verify_drawing(faces: &Faces, triangles: &[[u32; 3]]) -> Result<Proof, Unproven> {
    let proof = Proof { faces: faces.face_count(), triangles: triangles.len() };
    let mut drawn: Vec<[u32; 3]> = triangles
        .iter()
        .filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0])
        .copied()
        .map(canonical_triangle)
        .collect();
    drawn.sort_unstable();
    match faces.as_triangles() {
        Some(corners) => {
            let asked = corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]);
            let mut asked: Vec<_> = asked
                .filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0])
                .map(canonical_triangle)
                .collect();
            asked.sort_unstable();
            if asked == drawn { Ok(proof) } else { Err(first_difference(&asked, &drawn)) }
        }
        None => verify_polygons(faces, &drawn).map(|()| proof),
    }
}

fn first_difference(asked: &[[u32; 3]], drawn: &[[u32; 3]]) -> Unproven {
    let (mut i, mut j, mut missing, mut extra, mut first) = (0, 0, 0, 0, None);
    while i < asked.len() || j < drawn.len() {
        match (asked.get(i), drawn.get(j)) {
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

/// Polygons with what repeats left out, and which polygons each vertex is a corner of.
struct Corners {
    faces: Faces,
    /// The face's number in the input, and whether a vertex comes twice in it.
    origin: Vec<(u32, bool)>,
    incident_ends: Vec<u32>,
    incident: Vec<u32>,
}

impl Corners {
    fn new(faces: &Faces) -> Self {
        let (mut corners, mut offsets, mut origin): (Vec<u32>, _, _) = (Vec::new(), vec![0], Vec::new());
        let mut sorted: Vec<u32> = Vec::new();
        let mut polygon: Vec<u32> = Vec::new();
        for (face, all) in faces.iter().enumerate() {
            polygon.clear();
            polygon.extend_from_slice(all);
            polygon.dedup();
            while polygon.len() > 1 && polygon.first() == polygon.last() {
                polygon.pop();
            }
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
        let mut incident_ends = vec![0_u32; vertex_count];
        corners.iter().for_each(|&v| incident_ends[v as usize] += 1);
        let mut total = 0;
        for end in &mut incident_ends {
            total += std::mem::replace(end, total);
        }
        let mut incident = vec![0; corners.len()];
        for (face, range) in offsets.windows(2).enumerate() {
            for &v in &corners[range[0] as usize..range[1] as usize] {
                incident[incident_ends[v as usize] as usize] = face as u32;
                incident_ends[v as usize] += 1;
            }
        }
        let faces = Faces::from_offsets(offsets, corners).unwrap_or_default();
        Self { faces, origin, incident_ends, incident }
    }

    /// The polygons that a vertex is a corner of, in order.
    fn at(&self, vertex: u32) -> &[u32] {
        let v = vertex as usize;
        match self.incident_ends.get(v) {
            Some(&end) => {
                let start = if v == 0 { 0 } else { self.incident_ends[v - 1] };
                &self.incident[start as usize..end as usize]
            }
            None => &[],
        }
    }

    /// Calls `each` with every polygon that has all three vertices.
    fn common(&self, triangle: [u32; 3], mut each: impl FnMut(u32)) {
        let mut lists = triangle.map(|v| self.at(v));
        lists.sort_unstable_by_key(|list| list.len());
        let mut last = None;
        for &face in lists[0] {
            let in_all = lists[1].binary_search(&face).is_ok() && lists[2].binary_search(&face).is_ok();
            if in_all && last != Some(face) {
                each(face);
                last = Some(face);
            }
        }
    }
}

/// Holds sorted triangles to polygons.
fn verify_polygons(faces: &Faces, drawn: &[[u32; 3]]) -> Result<(), Unproven> {
    let corners = Corners::new(faces);
    let mut groups = UnionFind::new(corners.faces.face_count());
    let mut home: Vec<u32> = Vec::with_capacity(drawn.len());
    for (i, &triangle) in drawn.iter().enumerate() {
        // A triangle that comes as often as its polygon does is looked up once, or many would take their square of time.
        if i > 0 && drawn[i - 1] == triangle {
            home.push(home[i - 1]);
            continue;
        }
        let mut first = None;
        corners.common(triangle, |face| match first {
            None => first = Some(face),
            Some(first) => groups.unite(first, face),
        });
        home.push(first.ok_or(Unproven::Outside { triangle })?);
    }
    // Triangles and oriented edges of every group; (group, low, high) is counted up one way and down the other.
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
    for (&face, t) in home.iter().zip(drawn) {
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

    fn quads() -> Faces {
        Faces::from_polygons([vec![0, 1, 2, 3], vec![3, 2, 4], vec![2, 1, 5, 6, 7]]).unwrap()
    }

    #[test]
    fn accepts_any_triangulation_and_nothing_else() {
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
    fn many_polygons_over_the_same_corners_take_no_square_of_time() {
        let faces = Faces::from_polygons(vec![[0, 1, 2, 3]; 60_000]).unwrap();
        let drawn = [[0, 1, 2], [0, 2, 3]].repeat(60_000);
        assert!(verify_drawing(&faces, &drawn).is_ok());
        assert!(verify_drawing(&faces, &drawn[1..]).is_err());
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
