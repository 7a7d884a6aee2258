//! Computes the tangents of rebuilt parts from their texture coordinates, in the usual convention
//! for normal maps.
//!
//! # References
//! M. S. Mikkelsen: *Simulation of Wrinkled Surfaces Revisited*, 2008. glTF uses the tangents of
//! his program `MikkTSpace`.
//!
//! # Complexity
//! O(n log n) time, plus the square of the number of faces at each vertex. Surfaces with more than
//! [`MAX_CORNERS`] at a vertex keep the tangents of their sources.

use bevy_mikktspace::{Geometry, Ops, TangentSpace, generate_tangents};
use tristrip::{Attribute, Faces, Mesh, PositionIds};

use crate::error::Error;

/// The maximum number of corners at a position for which tangents are computed.
const MAX_CORNERS: usize = 512;

/// The maximum magnitude of values, which keeps sums of products finite.
const LARGEST: f32 = 1e9;

/// Returns a glTF tangent for each corner of triangles; empty for a mesh without tangents.
pub(super) fn tangents(mesh: &Mesh, triangles: &[u32], normals: &[[f32; 3]]) -> Result<Vec<[f32; 4]>, Error> {
    let named = |name: &str, components: u8| {
        mesh.attributes().iter().find(|a| a.name == name && a.components == components)
    };
    let Some(old) = named("TANGENT", 4) else { return Ok(Vec::new()) };
    let copied = |(&v, &normal): (&u32, &[f32; 3])| perpendicular(values(old, v), normal);
    let mut tangents: Vec<[f32; 4]> = triangles.iter().zip(normals).map(copied).collect();
    if let Some(uv) = named("TEXCOORD_0", 2).filter(|uv| is_computable(mesh, uv, triangles)) {
        let is_small = most_corners(mesh, triangles)? <= MAX_CORNERS;
        let mut corners = TangentCorners { mesh, uv, triangles, normals, tangents };
        if is_small && generate_tangents(&mut corners).is_err() {
            return Err(Error::unproven("tangents could not be computed"));
        }
        tangents = corners.tangents;
    }
    Ok(tangents)
}

/// Checks that all values are small enough.
fn is_computable(mesh: &Mesh, uv: &Attribute, triangles: &[u32]) -> bool {
    triangles.iter().all(|&v| {
        let position = mesh.positions()[v as usize];
        position.into_iter().chain(values::<2>(uv, v)).all(|x| x.abs() <= LARGEST)
    })
}

/// Returns the maximum number of corners at one position.
fn most_corners(mesh: &Mesh, triangles: &[u32]) -> Result<usize, Error> {
    let drawn = mesh.with_faces(Faces::from_triangles(triangles.to_vec())?)?;
    let points = PositionIds::default().faces(&[&drawn])?;
    let mut counts = vec![0; triangles.len()];
    points.corners().iter().for_each(|&point| counts[point as usize] += 1);
    Ok(counts.into_iter().max().unwrap_or(0))
}

/// Returns a tangent perpendicular to a unit normal, with the direction and sign of another
/// tangent.
fn perpendicular(tangent: [f32; 4], normal: [f32; 3]) -> [f32; 4] {
    let along: f32 = (0..3).map(|k| tangent[k] * normal[k]).sum();
    let flat = [0, 1, 2].map(|k| tangent[k] - along * normal[k]);
    let length = flat.iter().map(|x| x * x).sum::<f32>().sqrt();
    let sign = if tangent[3] < 0.0 { -1.0 } else { 1.0 };
    if !(length > f32::EPSILON && length.is_finite()) {
        // Use any direction in the plane: across the smallest component of the normal.
        let least = (0..3).min_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs())).unwrap_or(0);
        let [j, k] = [(least + 1) % 3, (least + 2) % 3];
        let across = (normal[j] * normal[j] + normal[k] * normal[k]).sqrt();
        let mut out = [0.0, 0.0, 0.0, sign];
        if across > 0.0 {
            (out[j], out[k]) = (normal[k] / across, -normal[j] / across);
        } else {
            out[0] = 1.0;
        }
        return out;
    }
    [flat[0] / length, flat[1] / length, flat[2] / length, sign]
}

/// Returns the values of a vertex. Non-finite values count as zero.
fn values<const N: usize>(attribute: &Attribute, vertex: u32) -> [f32; N] {
    std::array::from_fn(|k| attribute.float(N * vertex as usize + k).filter(|x| x.is_finite()).unwrap_or(0.0))
}

/// Square root and arc cosine with identical results on every machine.
struct SameEverywhere;

impl Ops for SameEverywhere {
    fn sqrt(x: f32) -> f32 {
        libm::sqrtf(x)
    }

    fn acos(x: f32) -> f32 {
        libm::acos(x.into()) as f32
    }
}

/// The corners of triangles with normals, and their computed tangents.
struct TangentCorners<'a> {
    mesh: &'a Mesh,
    uv: &'a Attribute,
    triangles: &'a [u32],
    normals: &'a [[f32; 3]],
    tangents: Vec<[f32; 4]>,
}

impl Geometry<SameEverywhere> for TangentCorners<'_> {
    fn num_faces(&self) -> usize {
        self.triangles.len() / 3
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, vert: usize) -> [f32; 3] {
        self.mesh.positions()[self.triangles[3 * face + vert] as usize]
    }

    fn normal(&self, face: usize, vert: usize) -> [f32; 3] {
        self.normals[3 * face + vert]
    }

    fn tex_coord(&self, face: usize, vert: usize) -> [f32; 2] {
        values(self.uv, self.triangles[3 * face + vert])
    }

    fn set_tangent(&mut self, found: Option<TangentSpace>, face: usize, vert: usize) {
        let Some(found) = found else { return };
        let corner = 3 * face + vert;
        let [x, y, z] = found.tangent();
        // The v coordinate of glTF points down, so the sign is inverted.
        let sign = if found.is_orientation_preserving() { -1.0 } else { 1.0 };
        self.tangents[corner] = perpendicular([x, y, z, sign], self.normals[corner]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tristrip::AttributeData;

    /// Returns a mesh with texture coordinates and placeholder tangents.
    fn textured(positions: Vec<[f32; 3]>, uv: Vec<f32>) -> Mesh {
        let tangents = [0.0, 0.0, 1.0, 1.0].repeat(positions.len());
        let add = |mesh: Mesh, name: &str, components, values| {
            let data = AttributeData::F32(values);
            mesh.with_attribute(Attribute { name: name.into(), components, normalized: false, data }).unwrap()
        };
        let mesh = Mesh::new(positions, Faces::default()).unwrap();
        add(add(mesh, "TEXCOORD_0", 2, uv), "TANGENT", 4, tangents)
    }

    /// An upright image on a square that faces +z: tangents point right, bitangents up. In a
    /// mirrored image, the sign of the bitangent changes.
    #[test]
    fn tangents_follow_the_texture() {
        let square = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let triangles = [0, 1, 2, 0, 2, 3];
        for (right, expected) in [(1.0, [1.0, 0.0, 0.0, 1.0]), (-1.0, [-1.0, 0.0, 0.0, -1.0])] {
            let uv = square.iter().flat_map(|p| [p[0] * right, 1.0 - p[1]]).collect();
            let mesh = textured(square.clone(), uv);
            let found = tangents(&mesh, &triangles, &[[0.0, 0.0, 1.0]; 6]).unwrap();
            assert_eq!(found, [expected; 6]);
        }
    }

    #[test]
    fn hostile_surfaces_have_perpendicular_tangents() {
        // A fan of many faces around one vertex, texture coordinates without area, and values near
        // the end of their range.
        let fan: Vec<[f32; 3]> = (0..3000).map(|i| [i as f32, 1.0 / (i + 1) as f32, 0.0]).collect();
        let fan_triangles: Vec<u32> = (1..2999).flat_map(|i| [0, i, i + 1]).collect();
        let huge = vec![[f32::MAX, 0.0, 0.0], [0.0, f32::MAX, 0.0], [0.0; 3]];
        let cases = [
            (textured(fan.clone(), vec![0.5; 6000]), fan_triangles),
            (textured(huge.clone(), vec![f32::NAN; 6]), vec![0, 1, 2]),
            (textured(huge, vec![f32::MAX; 6]), vec![0, 1, 2, 2, 1, 0, 0, 0, 1]),
        ];
        for (mesh, triangles) in cases {
            let found = tangents(&mesh, &triangles, &vec![[0.0, 0.0, 1.0]; triangles.len()]).unwrap();
            assert_eq!(found.len(), triangles.len());
            for [x, y, z, w] in found {
                assert!(
                    (x * x + y * y - 1.0).abs() < 1e-5
                        && z.abs() < 1e-5
                        && w.abs().to_bits() == 1.0_f32.to_bits()
                );
            }
        }
    }

    #[test]
    fn random_triangles_have_tangents() {
        let mut random = tristrip::random::Random::new(7);
        for _ in 0..300 {
            let count = 3 + random.below(9);
            let mut number = |n: usize| random.below(n) as f32;
            let positions = (0..count).map(|_| [number(3), number(3), number(3)]).collect();
            let uv = (0..2 * count).map(|_| number(3)).collect();
            let mesh = textured(positions, uv);
            let triangles: Vec<u32> = (0..30).map(|_| random.below(count) as u32).collect();
            let normals: Vec<[f32; 3]> = (0..30).map(|i| [[1.0, 0.0, 0.0], [0.0, 0.6, 0.8]][i % 2]).collect();
            let found = tangents(&mesh, &triangles, &normals).unwrap();
            let is_unit = |t: &[f32; 4]| (t[..3].iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-5;
            assert!(found.iter().all(is_unit));
        }
    }
}
