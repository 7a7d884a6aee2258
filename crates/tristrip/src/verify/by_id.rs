//! Verifies by vertex index that strips draw every face of their mesh exactly once, with its
//! original winding.
//!
//! # Algorithm
//! *Triangles*: the two multisets of oriented triangles are compared (see `triangle_sets`). If they
//! differ, both are sorted to find the first difference.
//!
//! *Polygons*: a triangle may belong to every polygon that has all its corners. Polygons to which
//! the same triangle may belong form a group, usually of one polygon. The search for the polygons
//! of a triangle skips polygons whose group it has already found. Polygons over almost the same
//! corners therefore count as one polygon once they are united. A group is correct under two
//! conditions. It has k − 2 triangles for each of its polygons of k corners. The oriented edges of
//! its triangles add up to the edges of its polygons: diagonals cancel, and boundaries remain. Any
//! choice of diagonals is therefore accepted, but no triangle may be missing, doubled, flipped or
//! outside.
//!
//! Corners that repeat the previous one, and faces with fewer than three remaining corners, draw
//! nothing and are ignored. A polygon that contains a vertex twice, for example a hole with a
//! bridge to it, may have degenerate triangles. At most k − 2 triangles and the oriented edges are
//! then compared. This does not distinguish a triangle and its reverse from another such pair over
//! the same corners.
//!
//! # Complexity
//! O(n) time for meshes of bounded valence, O(n log n) in the worst case. 10 bytes per triangle,
//! and 24 bytes per triangle to describe a difference. Polygons take O(n · groups per vertex) time
//! and 80 bytes per triangle.

use std::ops::Range;

use crate::csr::Csr;
use crate::ids::OptionalId;
use crate::mesh::{
    Faces, Mesh, SPARSE, VertexSubset, canonical_triangles, triangles_of, vertex_bound, without_repeats,
};
use crate::strip::Strips;
use crate::union_find::UnionFind;
use crate::verify::triangle_sets::same_triangles;

/// The result of a successful verification.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Proof {
    /// Number of faces compared.
    pub faces: usize,
    /// Number of triangles that draw these faces.
    pub triangles: usize,
}

/// Why triangles do not draw the faces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Unproven {
    /// The triangles differ from the faces.
    #[error("triangles missing: {missing}, extra or flipped: {extra}; the first is {first:?}")]
    Triangles {
        /// Number of faces that no triangle draws.
        missing: usize,
        /// Number of triangles without a face.
        extra: usize,
        /// The vertices of the first such triangle.
        first: [u32; 3],
    },
    /// The strips replace a vertex with one that does not exist in the mesh, or that differs in
    /// position or attributes.
    #[error("vertex {vertex} is welded to {other}, which differs from it")]
    Weld {
        /// The vertex that was welded.
        vertex: u32,
        /// The vertex that replaces it.
        other: u32,
    },
    /// A triangle is not part of any polygon.
    #[error("triangle {triangle:?} lies in no face")]
    Outside {
        /// The vertices of the triangle.
        triangle: [u32; 3],
    },
    /// A polygon has too few or too many triangles.
    #[error("face {face}: triangles found: {found}, expected: {expected}")]
    Count {
        /// A face of the group. A group contains the polygons to which the same triangle may
        /// belong.
        face: u32,
        /// Number of triangles in the group.
        found: usize,
        /// Number of triangles that the polygons of the group need.
        expected: usize,
    },
    /// The edges of a polygon's triangles do not add up to the edges of the polygon.
    #[error("face {face}: its triangles do not match its boundary at edge {edge:?}")]
    Boundary {
        /// A face of the group. A group contains the polygons to which the same triangle may
        /// belong.
        face: u32,
        /// The vertices of the first edge that differs.
        edge: [u32; 2],
    },
}

/// Verifies that strips draw every face of a mesh exactly once, with its original winding. If the
/// strips have [welds](Strips::welds), also verifies that the welded vertices are equal bit for
/// bit, and compares the faces after welding.
///
/// # Errors
/// The strips do not draw the faces. Returns the first difference found.
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
    let welds = strips.welds();
    if !welds.is_empty() {
        if let Some((vertex, other)) = welds.wrong_weld(mesh) {
            return Err(Unproven::Weld { vertex, other });
        }
        let faces = mesh.faces().renamed(welds.vertices(mesh.faces().corners()));
        let drawn = strips.triangles().map(|triangle| triangle.map(|v| welds.vertex(v)));
        return verify_drawing(&faces, &drawn.collect::<Vec<_>>());
    }
    if let Some(corners) = mesh.faces().as_triangles()
        && let Some(triangles) = same_triangles(corners.as_chunks().0, || strips.triangles())
    {
        return Ok(Proof { faces: mesh.faces().face_count(), triangles });
    }
    verify_drawing(mesh.faces(), &strips.triangles().collect::<Vec<_>>())
}

/// Verifies that triangles draw faces over the same vertices.
///
/// # Errors
/// The triangles do not draw the faces. Returns the first difference found.
///
/// ```
/// use tristrip::{Faces, verify::{Unproven, verify_drawing}};
/// let square = Faces::from_polygons([[0, 1, 2, 3]])?;
/// assert_eq!(verify_drawing(&square, &[[1, 2, 3], [3, 0, 1]]).map(|proof| proof.triangles), Ok(2));
/// // Wrong winding.
/// assert!(verify_drawing(&square, &[[3, 2, 1], [1, 0, 3]]).is_err());
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn verify_drawing(faces: &Faces, triangles: &[[u32; 3]]) -> Result<Proof, Unproven> {
    let proof = Proof { faces: faces.face_count(), triangles: triangles.len() };
    let difference = match faces.as_triangles() {
        Some(corners) if same_triangles(corners.as_chunks().0, || triangles.iter().copied()).is_some() => {
            None
        }
        Some(corners) => {
            let expected = canonical_triangles(triangles_of(corners));
            first_difference(&expected, &canonical_triangles(triangles.iter().copied()))
        }
        None => {
            let drawn = canonical_triangles(triangles.iter().copied());
            let highest = faces.corners().iter().max().map_or(0, |&v| v as usize);
            let is_sparse = highest / SPARSE > faces.corner_count();
            if is_sparse { verify_sparse_polygons(faces, &drawn) } else { verify_polygons(faces, &drawn) }
                .err()
        }
    };
    difference.map_or(Ok(proof), Err)
}

/// Compares sorted triangles, or returns `None` if they are equal.
fn first_difference(expected: &[[u32; 3]], drawn: &[[u32; 3]]) -> Option<Unproven> {
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
    first.map(|first| Unproven::Triangles { missing, extra, first })
}

/// Polygons without corners that repeat the previous one.
struct SimplePolygons {
    corners: Vec<u32>,
    /// The first corner of each polygon, then the number of corners.
    offsets: Vec<u32>,
    /// The index of each polygon's face in the input, and whether it contains a vertex twice.
    origin: Vec<(u32, bool)>,
}

impl SimplePolygons {
    fn new(faces: &Faces) -> Self {
        let mut all = Self { corners: Vec::new(), offsets: vec![0], origin: Vec::new() };
        let mut sorted: Vec<u32> = Vec::new();
        let mut polygon: Vec<u32> = Vec::new();
        for (face, corners) in (0..).zip(faces.iter()) {
            without_repeats(corners, &mut polygon);
            if polygon.len() < 3 {
                continue;
            }
            sorted.clear();
            sorted.extend_from_slice(&polygon);
            sorted.sort_unstable();
            all.origin.push((face, sorted.windows(2).any(|w| w[0] == w[1])));
            all.corners.extend_from_slice(&polygon);
            all.offsets.push(all.corners.len() as u32);
        }
        all
    }

    fn count(&self) -> usize {
        self.origin.len()
    }

    fn iter(&self) -> impl Iterator<Item = &[u32]> {
        self.offsets.windows(2).map(|range| &self.corners[range[0] as usize..range[1] as usize])
    }

    /// Returns the polygons at each vertex, in ascending order.
    fn by_vertex(&self) -> Csr {
        let vertex_count = vertex_bound(&self.corners);
        let sizes = (0_u32..).zip(self.iter().map(<[u32]>::len));
        let polygon_of: Vec<u32> =
            sizes.flat_map(|(polygon, size)| std::iter::repeat_n(polygon, size)).collect();
        let mut by_vertex = Csr::group(self.corners.iter().copied(), vertex_count);
        by_vertex.map_items(|corner| polygon_of[corner as usize]);
        by_vertex
    }
}

/// Polygons, united to groups if the same triangle may belong to them.
struct Groups {
    sets: UnionFind,
    /// Number of unions so far.
    unions: usize,
    by_vertex: Csr,
    /// The rows of `by_vertex`, sorted into runs of polygons of one group. `run_ends` has the end
    /// of the run that starts at a slot.
    runs: Vec<u32>,
    run_ends: Vec<u32>,
    vertices: Vec<VertexRuns>,
}

/// The state of the runs at a vertex.
#[derive(Clone, Copy, Default)]
struct VertexRuns {
    /// Polygons examined since the last regrouping, and the number of unions at that time.
    examined: usize,
    unions: usize,
    /// The polygon that was found last.
    found: OptionalId,
}

impl Groups {
    fn new(polygons: &SimplePolygons) -> Self {
        let by_vertex = polygons.by_vertex();
        let runs: Vec<u32> = by_vertex.rows().flatten().copied().collect();
        Self {
            sets: UnionFind::new(polygons.count()),
            unions: 0,
            run_ends: (1..=runs.len() as u32).collect(),
            runs,
            vertices: vec![VertexRuns::default(); by_vertex.key_count()],
            by_vertex,
        }
    }

    /// Returns whether a polygon has both vertices, each of which is a corner of some polygon.
    fn has(&self, polygon: u32, vertices: [u32; 2]) -> bool {
        vertices.iter().all(|&v| self.by_vertex.row(v).binary_search(&polygon).is_ok())
    }

    /// Unites all polygons that have the three vertices of a triangle. Returns one of them, or
    /// `None` if there are none.
    fn unite_around(&mut self, triangle: [u32; 3]) -> Option<u32> {
        if triangle.iter().any(|&v| v as usize >= self.vertices.len()) {
            return None;
        }
        let [a, others @ ..] = self.fewest_first(triangle);
        let row = self.by_vertex.range(a);
        let mut found = self.vertices[a as usize].found.get().filter(|&polygon| self.has(polygon, others));
        let (mut slot, mut examined) = (row.start, 0);
        while slot < row.end {
            let end = self.run_ends[slot] as usize;
            let is_known =
                found.is_some_and(|known| self.sets.find(known) == self.sets.find(self.runs[slot]));
            let run = if is_known { slot..slot } else { slot..end };
            let hit = run.clone().find(|&slot| self.has(self.runs[slot], others));
            examined += 1 + hit.map_or(run.len(), |hit| hit - slot);
            if let Some(hit) = hit {
                let polygon = self.runs[hit];
                self.unions += usize::from(found.is_some());
                self.sets.unite(*found.get_or_insert(polygon), polygon);
            }
            slot = end;
        }
        #[cfg(test)]
        tests::LOOKUPS.set(tests::LOOKUPS.get() + examined);
        let state = &mut self.vertices[a as usize];
        state.found = found.into();
        state.examined += examined;
        if state.examined >= row.len() && state.unions != self.unions {
            *state = VertexRuns { examined: 0, unions: self.unions, ..*state };
            self.regroup(row);
        }
        found
    }

    /// Returns the vertices of a triangle, starting with the one that has the fewest polygons.
    fn fewest_first(&self, mut triangle: [u32; 3]) -> [u32; 3] {
        triangle.sort_by_key(|&v| self.by_vertex.range(v).len());
        triangle
    }

    /// Sorts a row by group, and stores the ends of the runs.
    fn regroup(&mut self, row: Range<usize>) {
        let sets = &mut self.sets;
        self.runs[row.clone()].sort_unstable_by_key(|&polygon| (sets.find(polygon), polygon));
        let mut end = row.end;
        for slot in row.rev() {
            if slot + 1 < end && sets.find(self.runs[slot]) != sets.find(self.runs[slot + 1]) {
                end = slot + 1;
            }
            self.run_ends[slot] = end as u32;
        }
    }
}

/// Compares sorted triangles with polygons that use few of the vertices up to the highest one,
/// after renumbering the vertices in order.
fn verify_sparse_polygons(faces: &Faces, drawn: &[[u32; 3]]) -> Result<(), Unproven> {
    let used = VertexSubset::of(faces.corners());
    let mut renumbered = Vec::with_capacity(drawn.len());
    for &triangle in drawn {
        let numbers = triangle.map(|v| used.find(v));
        let [Some(a), Some(b), Some(c)] = numbers else { return Err(Unproven::Outside { triangle }) };
        renumbered.push([a, b, c]);
    }
    let old = |v: u32| used.vertices()[v as usize];
    verify_polygons(&faces.renamed(used.numbers(faces.corners())), &renumbered).map_err(|why| match why {
        Unproven::Outside { triangle } => Unproven::Outside { triangle: triangle.map(old) },
        Unproven::Boundary { face, edge } => Unproven::Boundary { face, edge: edge.map(old) },
        why => why,
    })
}

/// Compares sorted triangles with polygons.
fn verify_polygons(faces: &Faces, drawn: &[[u32; 3]]) -> Result<(), Unproven> {
    let polygons = SimplePolygons::new(faces);
    let mut groups = Groups::new(&polygons);
    let mut owners: Vec<u32> = Vec::with_capacity(drawn.len());
    for (i, &triangle) in drawn.iter().enumerate() {
        // A triangle that is repeated like its polygon is looked up once; otherwise the time would
        // be quadratic.
        if i > 0 && drawn[i - 1] == triangle {
            owners.push(owners[i - 1]);
            continue;
        }
        owners.push(groups.unite_around(triangle).ok_or(Unproven::Outside { triangle })?);
    }
    let Groups { sets: mut groups, .. } = groups;
    // Triangles and oriented edges of every group: (group, low, high) counts +1 in one direction
    // and −1 in the other.
    let mut count: Vec<(usize, usize, bool)> = vec![(0, 0, false); polygons.count()];
    let mut edges: Vec<(u32, u32, u32, i32)> = Vec::with_capacity(3 * drawn.len() + polygons.corners.len());
    let mut add = |group: u32, from: u32, to: u32, sign: i32| {
        edges.push(if from < to { (group, from, to, sign) } else { (group, to, from, -sign) });
    };
    for ((number, polygon), &(_, repeats)) in (0..).zip(polygons.iter()).zip(&polygons.origin) {
        let group = groups.find(number);
        let c = &mut count[group as usize];
        c.1 += polygon.len() - 2;
        c.2 |= repeats;
        for (i, &from) in polygon.iter().enumerate() {
            add(group, from, polygon[(i + 1) % polygon.len()], 1);
        }
    }
    for (&polygon, t) in owners.iter().zip(drawn) {
        let group = groups.find(polygon);
        count[group as usize].0 += 1;
        (0..3).for_each(|i| add(group, t[i], t[(i + 1) % 3], -1));
    }
    for (group, &(found, expected, repeats)) in count.iter().enumerate() {
        if found > expected || (found != expected && !repeats) {
            return Err(Unproven::Count { face: polygons.origin[group].0, found, expected });
        }
    }
    edges.sort_unstable_by_key(|e| (e.0, e.1, e.2));
    for edge in edges.chunk_by(|a, b| (a.0, a.1, a.2) == (b.0, b.1, b.2)) {
        if edge.iter().map(|e| e.3).sum::<i32>() != 0 {
            let (group, a, b, _) = edge[0];
            return Err(Unproven::Boundary { face: polygons.origin[group as usize].0, edge: [a, b] });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
