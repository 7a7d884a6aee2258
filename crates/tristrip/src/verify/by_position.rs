//! Verifies by position that one model draws exactly the faces of another, for any vertex
//! numbering.
//!
//! # Algorithm
//! Most results keep the vertex order of the source. The models are the same if both have the same
//! number of meshes, each result mesh has the same positions as its source mesh, and the triangles
//! of the result mesh draw the source faces by vertex index. Otherwise:
//!
//! 1. The vertices of both models are numbered by position ([`PositionIds`]), over all meshes of a
//!    model.
//! 2. If the result has only triangles, [`verify_drawing`] compares it with the source.
//! 3. If the result has polygons, faces that occur in both models cancel one for one. The rest is
//!    compared as if the result's triangles drew the source. If only the remaining source consists
//!    of triangles, the rest is compared as if the source's triangles drew the result. Polygons
//!    that remain on both sides differ. The polygons of the result are then cut into fans.
//!
//! # Complexity
//! O(n) time and 12 bytes per triangle if the vertices are in the same order. Otherwise O(n log n)
//! time, about 70 bytes per vertex and 60 bytes per triangle, over both models.

use std::borrow::Cow;
use std::cmp::Ordering;

use super::by_id::{Proof, Unproven, verify_drawing};
use crate::error::Error;
use crate::mesh::{Faces, Mesh, PositionIds, canonical_triangles};

/// A difference between what two models draw. Positions are in mesh units. Face indices refer to
/// the source, counted over all its meshes.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Difference {
    /// The triangles differ.
    #[error(
        "triangles missing: {missing}, extra: {extra}, flipped: {flipped}; the first is at {}",
        at(first)
    )]
    Triangles {
        /// Number of triangles of the source that are missing from the result.
        missing: usize,
        /// Number of triangles of the result that are not in the source.
        extra: usize,
        /// Number of triangles that the result draws with the opposite winding.
        flipped: usize,
        /// The corners of the first such triangle.
        first: [[f32; 3]; 3],
    },
    /// A triangle is not part of any polygon.
    #[error("a triangle lies in no face of the source: {}", at(triangle))]
    Outside {
        /// The corners of the triangle.
        triangle: [[f32; 3]; 3],
    },
    /// A polygon has too few or too many triangles.
    #[error("face {face} of the source at {}: triangles found: {found}, expected: {expected}", at(&[*position]))]
    Count {
        /// A face of the source.
        face: u32,
        /// The first corner of the face.
        position: [f32; 3],
        /// Number of triangles found in the face and in faces over the same corners.
        found: usize,
        /// Number of triangles that the face and the faces over the same corners need.
        expected: usize,
    },
    /// The edges of a polygon's triangles do not add up to the edges of the polygon.
    #[error(
        "face {face} of the source: its triangles do not match its boundary, first at the edge {}",
        at(edge)
    )]
    Boundary {
        /// A face of the source.
        face: u32,
        /// The end points of the first edge that differs.
        edge: [[f32; 3]; 2],
    },
}

fn at(positions: &[[f32; 3]]) -> String {
    let point = |p: &[f32; 3]| format!("({}, {}, {})", p[0], p[1], p[2]);
    positions.iter().map(point).collect::<Vec<_>>().join(" ")
}

/// Verifies that the meshes of a result draw every face of a source's meshes exactly once, with its
/// original winding. Vertices are compared by the bits of their positions; 0.0 equals −0.0. The
/// inner result contains the proof or a difference.
///
/// # Errors
/// The models are too large for 32-bit indices.
///
/// ```
/// use tristrip::{Faces, Mesh, verify::verify_models};
/// let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
/// let square = Mesh::new(corners.clone(), Faces::from_polygons([[0, 1, 2, 3]])?)?;
/// let halves = Mesh::new(corners, Faces::from_triangles(vec![0, 1, 2, 2, 3, 0])?)?;
/// assert_eq!(verify_models(&[&square], &[&halves])?.unwrap().triangles, 2);
/// assert!(verify_models(&[&square], &[&halves, &halves])?.is_err());
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn verify_models(source: &[&Mesh], result: &[&Mesh]) -> Result<Result<Proof, Difference>, Error> {
    if same_numbering(source, result) {
        let faces = source.iter().map(|mesh| mesh.faces().face_count()).sum();
        let triangles = result.iter().map(|mesh| mesh.faces().triangle_count()).sum();
        return Ok(Ok(Proof { faces, triangles }));
    }
    let mut ids = PositionIds::default();
    let source = ids.faces(source)?;
    let result = ids.faces(result)?;
    let proof = Proof { faces: source.face_count(), triangles: result.triangle_count() };
    let comparison = match result.as_triangles() {
        Some(_) => compare_drawing(&source, &result, &ids, &|face| face),
        None => compare_polygons(&source, &result, &ids)?,
    };
    Ok(comparison.map(|()| proof))
}

/// Returns whether the meshes of two models have the same vertices in the same order, and the
/// triangles of each result mesh draw the faces of the source mesh by vertex index. This is
/// sufficient but not necessary.
fn same_numbering(source: &[&Mesh], result: &[&Mesh]) -> bool {
    let draws = |(source, result): (&&Mesh, &&Mesh)| {
        let triangles = result.faces().as_triangles();
        source.positions() == result.positions()
            && triangles.is_some_and(|corners| verify_drawing(source.faces(), corners.as_chunks().0).is_ok())
    };
    source.len() == result.len() && source.iter().zip(result).all(draws)
}

/// Compares models whose result has polygons.
fn compare_polygons(
    source: &Faces,
    result: &Faces,
    ids: &PositionIds,
) -> Result<Result<(), Difference>, Error> {
    let (source_left, result_left) = uncommon(source, result);
    let select =
        |faces: &Faces, kept: &[u32]| Faces::from_polygons(kept.iter().map(|&f| faces.face(f as usize)));
    let (expected, found) = (select(source, &source_left)?, select(result, &result_left)?);
    let number = |face: u32| source_left.get(face as usize).copied().unwrap_or(face);
    if found.as_triangles().is_none() && expected.as_triangles().is_some() {
        return Ok(compare_drawing(&found, &expected, ids, &number).map_err(Difference::exchanged));
    }
    Ok(compare_drawing(&expected, &found, ids, &number))
}

impl Difference {
    /// Returns the difference with source and result exchanged.
    fn exchanged(self) -> Self {
        match self {
            Self::Triangles { missing, extra, flipped, first } => {
                Self::Triangles { missing: extra, extra: missing, flipped, first }
            }
            // The face is one of the result here, so only its position is reported.
            Self::Count { position, .. } => {
                Self::Triangles { missing: 0, extra: 1, flipped: 0, first: [position; 3] }
            }
            Self::Boundary { edge: [a, b], .. } => {
                Self::Triangles { missing: 0, extra: 1, flipped: 0, first: [a, b, b] }
            }
            Self::Outside { triangle } => {
                Self::Triangles { missing: 1, extra: 0, flipped: 0, first: triangle }
            }
        }
    }
}

/// Returns the faces that are missing on the other side. Equal faces cancel one for one.
fn uncommon(a: &Faces, b: &Faces) -> (Vec<u32>, Vec<u32>) {
    let sorted = |faces: &Faces| {
        let mut all: Vec<(Vec<u32>, u32)> =
            (0..).zip(faces.iter()).map(|(number, face)| (rotated(face), number)).collect();
        all.sort_unstable();
        all
    };
    let (a, b) = (sorted(a), sorted(b));
    let (mut i, mut j, mut left) = (0, 0, (Vec::new(), Vec::new()));
    while i < a.len() || j < b.len() {
        match (a.get(i), b.get(j)) {
            (Some((x, _)), Some((y, _))) if x == y => (i, j) = (i + 1, j + 1),
            (Some((x, face)), other) if other.is_none_or(|(y, _)| x < y) => {
                left.0.push(*face);
                i += 1;
            }
            (_, other) => {
                left.1.extend(other.map(|(_, face)| *face));
                j += 1;
            }
        }
    }
    left.0.sort_unstable();
    left.1.sort_unstable();
    left
}

/// Returns the lexicographically smallest rotation of a face.
fn rotated(face: &[u32]) -> Vec<u32> {
    let start = least_rotation(face, u32::cmp);
    [&face[start..], &face[..start]].concat()
}

/// Returns the start of the lexicographically smallest rotation in O(n) time. Compares two
/// candidates at a time. No start between a candidate and the first difference can be better
/// (Shiloach 1981).
fn least_rotation(face: &[u32], mut compare: impl FnMut(&u32, &u32) -> Ordering) -> usize {
    let n = face.len();
    let (mut best, mut other, mut same) = (0, 1, 0);
    while best < n && other < n && same < n {
        match compare(&face[(best + same) % n], &face[(other + same) % n]) {
            Ordering::Equal => same += 1,
            Ordering::Less => (other, same) = (other + same + 1, 0),
            Ordering::Greater => (best, same) = (best + same + 1, 0),
        }
        if best == other {
            other += 1;
        }
    }
    best.min(other)
}

/// Compares the triangles of one side, after cutting polygons into fans, with the faces of the
/// other side.
fn compare_drawing(
    faces: &Faces,
    drawing: &Faces,
    ids: &PositionIds,
    number: &dyn Fn(u32) -> u32,
) -> Result<(), Difference> {
    let fan = |face: &[u32]| -> Vec<[u32; 3]> {
        face.windows(2).skip(1).map(|edge| [face[0], edge[0], edge[1]]).collect()
    };
    let triangles: Cow<'_, [[u32; 3]]> = match drawing.as_triangles() {
        Some(corners) => Cow::Borrowed(corners.as_chunks().0),
        None => Cow::Owned(drawing.iter().flat_map(fan).collect()),
    };
    let Err(unproven) = verify_drawing(faces, &triangles) else { return Ok(()) };
    Err(match unproven {
        Unproven::Triangles { first, .. } => {
            triangle_difference(faces, &triangles, first.map(|v| ids.position_of(v)))
        }
        // Only strips have welds; faces have none.
        Unproven::Weld { vertex, other } => {
            Difference::Outside { triangle: [vertex, other, other].map(|v| ids.position_of(v)) }
        }
        Unproven::Outside { triangle } => {
            Difference::Outside { triangle: triangle.map(|v| ids.position_of(v)) }
        }
        Unproven::Count { face, found, expected } => {
            let position = faces.face(face as usize).first().map_or([0.0; 3], |&v| ids.position_of(v));
            Difference::Count { face: number(face), position, found, expected }
        }
        Unproven::Boundary { face, edge } => {
            Difference::Boundary { face: number(face), edge: edge.map(|v| ids.position_of(v)) }
        }
    })
}

/// Counts the missing, extra and flipped triangles. The first difference is known.
fn triangle_difference(faces: &Faces, drawn: &[[u32; 3]], first: [[f32; 3]; 3]) -> Difference {
    let expected = canonical_triangles(faces.iter().map(|f| [f[0], f[1], f[2]]));
    let drawn = canonical_triangles(drawn.iter().copied());
    let (missing, extra) = subtract(&expected, &drawn);
    let reversed = canonical_triangles(extra.iter().map(|&[a, b, c]| [a, c, b]));
    let (lost, not_flipped) = subtract(&missing, &reversed);
    Difference::Triangles {
        missing: lost.len(),
        extra: not_flipped.len(),
        flipped: missing.len() - lost.len(),
        first,
    }
}

/// Returns the differences of two sorted multisets in both directions.
fn subtract(a: &[[u32; 3]], b: &[[u32; 3]]) -> (Vec<[u32; 3]>, Vec<[u32; 3]>) {
    let (mut i, mut j, mut only) = (0, 0, (Vec::new(), Vec::new()));
    while i < a.len() && j < b.len() {
        match a[i].cmp(&b[j]) {
            Ordering::Equal => (i, j) = (i + 1, j + 1),
            Ordering::Less => {
                only.0.push(a[i]);
                i += 1;
            }
            Ordering::Greater => {
                only.1.push(b[j]);
                j += 1;
            }
        }
    }
    only.0.extend_from_slice(&a[i..]);
    only.1.extend_from_slice(&b[j..]);
    only
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeMap;

    /// Builds a mesh in a plane: vertex v is at (v, v², 0), so all positions differ.
    fn mesh(polygons: &[&[u32]]) -> Mesh {
        let positions: Vec<_> = (0..10).map(|v| [v as f32, (v * v) as f32, 0.0]).collect();
        Mesh::new(positions, Faces::from_polygons(polygons).unwrap()).unwrap()
    }

    fn compare(source: &[&[u32]], result: &[&[u32]]) -> Result<Proof, Difference> {
        verify_models(&[&mesh(source)], &[&mesh(result)]).unwrap()
    }

    #[test]
    fn counts_missing_extra_and_flipped_triangles() {
        let source: &[&[u32]] = &[&[0, 1, 2], &[2, 1, 3], &[3, 4, 5], &[3, 4, 5]];
        let found = compare(source, &[&[1, 2, 0], &[1, 2, 3], &[4, 5, 3], &[6, 7, 8]]);
        let first = [[1.0, 1.0, 0.0], [2.0, 4.0, 0.0], [3.0, 9.0, 0.0]];
        assert_eq!(found, Err(Difference::Triangles { missing: 1, extra: 1, flipped: 1, first }));
        assert_eq!(
            found.unwrap_err().to_string(),
            "triangles missing: 1, extra: 1, flipped: 1; the first is at (1, 1, 0) (2, 4, 0) (3, 9, 0)"
        );
        assert_eq!(compare(source, source), Ok(Proof { faces: 4, triangles: 4 }));
    }

    #[test]
    fn polygons_may_stay_be_cut_or_be_joined() {
        let quads: &[&[u32]] = &[&[0, 1, 2, 3], &[3, 2, 4, 5], &[3, 2, 4, 5], &[6, 7, 8]];
        assert!(compare(quads, &[&[2, 3, 0, 1], &[3, 2, 4, 5], &[2, 4, 5, 3], &[7, 8, 6]]).is_ok());
        let cut: &[&[u32]] = &[&[0, 1, 2], &[2, 3, 0], &[3, 2, 4, 5], &[3, 2, 4], &[4, 5, 3], &[6, 7, 8]];
        assert!(compare(quads, cut).is_ok());
        assert!(compare(cut, quads).is_ok(), "triangles joined to polygons");
        assert!(compare(quads, &cut[1..]).is_err());
        assert!(compare(&cut[1..], quads).is_err());
        assert!(compare(quads, &quads[1..]).is_err());
        assert!(compare(quads, &[&[3, 2, 1, 0], &[3, 2, 4, 5], &[3, 2, 4, 5], &[6, 7, 8]]).is_err());
    }

    #[test]
    fn models_of_one_numbering_are_compared_mesh_by_mesh() {
        let (a, b): (&[&[u32]], &[&[u32]]) =
            (&[&[0, 1, 2, 3], &[4, 5, 6]], &[&[1, 2, 0], &[0, 2, 3], &[6, 4, 5]]);
        assert!(same_numbering(&[&mesh(a)], &[&mesh(b)]));
        assert!(!same_numbering(&[&mesh(a)], &[&mesh(&b[1..])]));
        assert!(!same_numbering(&[&mesh(a)], &[&mesh(a)]), "polygons are compared otherwise");
        // Faces moved to another mesh draw the same model, but the shortcut does not detect it.
        let [first, second] = [&b[..1], &b[1..]];
        let exchanged = [&mesh(second), &mesh(first)];
        assert!(!same_numbering(&[&mesh(first), &mesh(second)], &exchanged));
        assert!(verify_models(&[&mesh(first), &mesh(second)], &exchanged).unwrap().is_ok());
    }

    #[test]
    fn a_reported_face_has_its_number_in_the_source() {
        let source: &[&[u32]] = &[&[0, 1, 2, 3], &[3, 2, 4, 5], &[5, 4, 6, 7]];
        let found = compare(source, &[&[0, 1, 2, 3], &[3, 2, 4, 5], &[5, 4, 6]]);
        assert!(matches!(found, Err(Difference::Count { face: 2, found: 1, expected: 2, .. })), "{found:?}");
    }

    #[test]
    fn vertices_at_one_position_are_equal() {
        let seam =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.0, 1.0, 0.0], [1.0, -0.0, 0.0], [1.0; 3]];
        let source =
            Mesh::new(seam.to_vec(), Faces::from_triangles(vec![0, 1, 2, 3, 4, 5]).unwrap()).unwrap();
        let welded = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0; 3], [0.0; 3]];
        let result =
            Mesh::new(welded.to_vec(), Faces::from_triangles(vec![3, 0, 1, 1, 0, 2]).unwrap()).unwrap();
        assert!(verify_models(&[&source], &[&result]).unwrap().is_ok());
    }

    /// Counts how often each oriented triangle is drawn.
    fn multiset(triangles: &[[u32; 3]]) -> BTreeMap<[u32; 3], usize> {
        let mut all = BTreeMap::new();
        canonical_triangles(triangles.iter().copied())
            .into_iter()
            .for_each(|t| *all.entry(t).or_default() += 1);
        all
    }

    #[test]
    fn the_least_rotation_of_a_large_face_takes_linear_time() {
        let n = 100_000;
        let mut almost_constant = vec![0; n];
        almost_constant.extend([1, 0]);
        let alternating: Vec<u32> = (0..n as u32).map(|i| i % 2).collect();
        let rising: Vec<u32> = (0..n as u32).collect();
        for (face, start) in [(vec![7; n], 0), (almost_constant, n + 1), (alternating, 0), (rising, 0)] {
            let mut steps = 0;
            let found = least_rotation(&face, |a, b| {
                steps += 1;
                a.cmp(b)
            });
            assert_eq!(found, start);
            assert!(steps <= 3 * face.len(), "{steps} comparisons of {} corners", face.len());
        }
    }

    proptest! {
        #[test]
        fn the_least_rotation_is_that_of_all(face in prop::collection::vec(0..3_u32, 0..12)) {
            let all = (0..face.len()).map(|i| [&face[i..], &face[..i]].concat());
            prop_assert_eq!(rotated(&face), all.min().unwrap_or_default());
        }

        #[test]
        fn triangles_are_equal_if_their_multisets_are(
            source in prop::collection::vec([0..5_u32, 0..5, 0..5], 0..8),
            change in prop::option::of((0..8_usize, [0..5_u32, 0..5, 0..5])),
            cut in 0..8_usize,
        ) {
            let mut result: Vec<[u32; 3]> = source.iter().rev().map(|&[a, b, c]| [b, c, a]).collect();
            if let (Some((at, other)), false) = (change, result.is_empty()) {
                let at = at % result.len();
                result[at] = other;
            }
            let polygons = |all: &[[u32; 3]]| mesh(&all.iter().map(<[u32; 3]>::as_slice).collect::<Vec<_>>());
            let (first, second) = result.split_at(cut.min(result.len()));
            let comparison = verify_models(&[&polygons(&source)], &[&polygons(first), &polygons(second)]).unwrap();
            prop_assert_eq!(comparison.is_ok(), multiset(&source) == multiset(&result));
            if let Err(Difference::Triangles { missing, extra, flipped, .. }) = comparison {
                let (expected, found) = (multiset(&source), multiset(&result));
                let lacks = |a: &BTreeMap<_, usize>, b: &BTreeMap<_, usize>| -> usize {
                    a.iter().map(|(t, n)| n.saturating_sub(*b.get(t).unwrap_or(&0))).sum()
                };
                prop_assert_eq!(missing + flipped, lacks(&expected, &found));
                prop_assert_eq!(extra + flipped, lacks(&found, &expected));
            }
        }
    }
}
