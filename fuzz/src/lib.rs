//! Common parts of the fuzz targets: builders of meshes, strips and collapses, and the comparison
//! of triangles.

use tristrip::CollapseSequence;
use tristrip::Rename;
use tristrip::simplify::{self, Simplification};
use tristrip::{Attribute, AttributeData, Faces, Mesh, Method, StripifyOptions, Strips, stripify};

/// The remaining bytes, followed by zeros.
pub struct Bytes<'a>(pub &'a [u8]);

impl Bytes<'_> {
    /// Returns the next byte.
    pub fn next(&mut self) -> u8 {
        let Some((&first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        first
    }

    /// Returns the next four bytes as a little-endian number.
    pub fn word(&mut self) -> u32 {
        u32::from_le_bytes([0; 4].map(|_| self.next()))
    }
}

/// Returns triangles in canonical order, each starting at its lowest vertex. Equal drawings give
/// equal results; the winding is preserved.
pub fn sorted(triangles: impl IntoIterator<Item = [u32; 3]>) -> Vec<[u32; 3]> {
    let canonical_triangle = |mut t: [u32; 3]| {
        let lowest = (0..3).min_by_key(|&i| t[i]).unwrap_or(0);
        t.rotate_left(lowest);
        t
    };
    let mut all: Vec<_> = triangles.into_iter().map(canonical_triangle).collect();
    all.sort_unstable();
    all
}

/// Builds a mesh: positions in one of several patterns, then polygons until the bytes end.
pub fn mesh(bytes: &mut Bytes) -> Mesh {
    let vertex_count = match bytes.next() {
        small @ 0..=199 => u32::from(small) % 40 + 1,
        large => u32::from(large) * 4 + u32::from(bytes.next()),
    };
    let pattern = bytes.next();
    let positions: Vec<[f32; 3]> = (0..vertex_count).map(|v| position(v, pattern, bytes)).collect();
    let mut polygons: Vec<Vec<u32>> = Vec::new();
    let mut corners = 0;
    while !bytes.0.is_empty() && corners < 600 {
        let polygon = polygon(vertex_count, &polygons, bytes);
        corners += polygon.len();
        polygons.push(polygon);
    }
    let faces = Faces::from_polygons(polygons).expect("few corners");
    Mesh::new(positions, faces).expect("indices in range")
}

/// Returns the position of a vertex, always finite.
fn position(v: u32, pattern: u8, bytes: &mut Bytes) -> [f32; 3] {
    let (x, y) = ((v % 8) as f32, (v / 8) as f32);
    let finite = |bits: u32| Some(f32::from_bits(bits)).filter(|x| x.is_finite()).unwrap_or(0.0);
    match pattern % 6 {
        0 => [x, y, 0.0],
        1 => [(v as f32).cos(), (v as f32).sin(), 0.0],
        2 => [0.0; 3],
        3 => [0; 3].map(|_| f32::from(bytes.next() as i8)),
        4 => [0; 3].map(|_| finite(bytes.word())),
        _ => [
            x / 8.0 * f32::MAX,
            -y * f32::MIN_POSITIVE,
            if v.is_multiple_of(2) { f32::MAX } else { f32::MIN },
        ],
    }
}

/// Builds a polygon of any size: corner by corner, as a run of vertices, or as an earlier polygon,
/// rotated or reversed.
fn polygon(vertex_count: u32, earlier: &[Vec<u32>], bytes: &mut Bytes) -> Vec<u32> {
    let size = bytes.next();
    match size {
        0..=99 => (0..size / 10).map(|_| u32::from(bytes.next()) % vertex_count).collect(),
        100..=179 => (0..3 + size % 2).map(|_| u32::from(bytes.next()) % vertex_count).collect(),
        180..=219 => {
            // A quad of a grid with eight columns, so grid patches occur.
            let v = u32::from(bytes.next());
            let quad = [v, v + 1, v + 9, v + 8].map(|v| v % vertex_count);
            if size < 210 { quad.to_vec() } else { quad.into_iter().rev().collect() }
        }
        220..=239 => {
            let [first, step, count] = [0; 3].map(|_| u32::from(bytes.next()));
            (0..count).map(|i| (first + i * step) % vertex_count).collect()
        }
        _ => {
            let mut copy = match earlier.len() {
                0 => Vec::new(),
                n => earlier[usize::from(bytes.next()) % n].clone(),
            };
            if size.is_multiple_of(2) {
                copy.reverse();
            }
            let shift = usize::from(size) % copy.len().max(1);
            copy.rotate_left(shift);
            copy
        }
    }
}

/// Adds the vertex attributes selected by two bits: a coarse and a fine one. Their differences are
/// seams between vertices at the same position.
pub fn with_attributes(mesh: Mesh, choice: u8) -> Mesh {
    let count = mesh.vertex_count();
    let attribute =
        |name: &str, data| Attribute { name: name.into(), components: 1, normalized: false, data };
    let coarse =
        attribute("coarse", AttributeData::U8((0..count).map(|v| u8::from(v >= count / 2)).collect()));
    let fine = attribute("fine", AttributeData::F32((0..count).map(|v| (v % 3) as f32).collect()));
    let wanted = [coarse, fine].into_iter().enumerate().filter(|(bit, _)| choice >> bit & 1 == 1);
    wanted.fold(mesh, |mesh, (_, attribute)| mesh.with_attribute(attribute).expect("a value per vertex"))
}

/// Strips of a mesh, and collapses of the triangles that they draw.
pub struct Model {
    pub strips: Strips,
    pub sequence: CollapseSequence,
}

/// Builds a mesh, its strips by a method of moderate cost, and collapses: those of a
/// simplification, or arbitrary ones. Returns `None` if the mesh has no strips.
pub fn model(bytes: &mut Bytes) -> Option<Model> {
    let [kind, method, attributes] = [0; 3].map(|_| bytes.next());
    let is_simplified = kind.is_multiple_of(2);
    let choice_count = if is_simplified { 0 } else { kind / 8 };
    let choices: Vec<[u8; 4]> = (0..choice_count).map(|_| [0; 4].map(|_| bytes.next())).collect();
    let mesh = with_attributes(mesh(bytes), attributes);
    let methods =
        [Method::Input, Method::Sequential, Method::SGI, Method::STRIPE, Method::QUAD_ROWS, Method::Fewest];
    let options = StripifyOptions::default().with_method(methods[usize::from(method) % methods.len()]);
    let strips = stripify(&mesh, &options).ok()?;
    let sequence = if is_simplified {
        simplified(&mesh, strips.to_list(), &simplify::SimplifyOptions::default()).sequence
    } else {
        collapsed(mesh.vertex_count(), strips.to_list(), &choices)
    };
    Some(Model { strips, sequence })
}

/// Simplifies triangles of a mesh and checks the sequence.
pub fn simplified(mesh: &Mesh, triangles: Vec<u32>, options: &simplify::SimplifyOptions) -> Simplification {
    let result = simplify::simplify_triangles(mesh, triangles, options).expect("valid triangles and options");
    assert_eq!(result.sequence.check(), Ok(()));
    result
}

/// Builds a sequence of arbitrary collapses: mostly of edges, sometimes of two vertices at once, or
/// of any two vertices.
fn collapsed(vertex_count: usize, list: Vec<u32>, choices: &[[u8; 4]]) -> CollapseSequence {
    let mut now = list.clone();
    let mut collapses: Vec<Vec<Rename>> = Vec::new();
    for &[triangle, corner, other, kind] in choices {
        if now.is_empty() {
            break;
        }
        let pairs = match kind % 8 {
            0 => vec![[triangle, other].map(|choice| now[usize::from(choice) % now.len()])],
            1 => vec![edge(&now, triangle, corner), edge(&now, other, corner / 3)],
            _ => vec![edge(&now, triangle, corner)],
        };
        let mut renames: Vec<Rename> = Vec::new();
        for [removed, kept] in pairs {
            let is_new = |r: &Rename| ![removed, kept].contains(&r.removed) && removed != r.kept;
            if removed != kept && renames.iter().all(is_new) {
                renames.push(Rename { removed, kept });
            }
        }
        renames.iter().for_each(|rename| apply(&mut now, *rename));
        if !renames.is_empty() {
            collapses.push(renames);
        }
    }
    let collapses = collapses.iter().map(|renames| (&renames[..], 0.0));
    let sequence =
        CollapseSequence::from_collapses(vertex_count, list, collapses).expect("vertices that are drawn");
    assert_eq!(sequence.check(), Ok(()));
    sequence
}

/// Returns an edge of a triangle of a list.
fn edge(list: &[u32], triangle: u8, corner: u8) -> [u32; 2] {
    let first = usize::from(triangle) % (list.len() / 3) * 3;
    [corner, corner % 3 + 1].map(|corner| list[first + usize::from(corner) % 3])
}

/// Renames a vertex in a list of triangles and removes triangles that become degenerate.
pub fn apply(list: &mut Vec<u32>, rename: Rename) {
    list.iter_mut().filter(|v| **v == rename.removed).for_each(|v| *v = rename.kept);
    let is_real = |t: &&[u32]| t[0] != t[1] && t[1] != t[2] && t[0] != t[2];
    *list = list.chunks_exact(3).filter(is_real).flatten().copied().collect();
}

/// Returns the triangles of a list of corners.
pub fn triangles_of(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]])
}
