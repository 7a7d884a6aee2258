//! The priced vertex attributes, converted to lengths on the surface.
//!
//! Positions, normals, texture coordinates and colours have different units. Each is converted to a
//! length on the surface, so the deviations can be added to the distance between the surfaces:
//! - *texture coordinates*: the distance by which the texture shifts on the surface, computed from
//!   the mean size of the texture on the surface. A model with a repeated texture is thus treated
//!   like a model with an atlas;
//! - *normals*, *tangents* and *colours*: the difference times a fixed length in the local frame
//!   ([`NORMAL_LENGTH`], [`TANGENT_LENGTH`], [`COLOUR_LENGTH`]). A surface that moves by that
//!   length counts as much as a normal that turns by a radian, or a colour that changes from black
//!   to full intensity;
//! - *joints and weights*: the resulting difference in the displacement of a vertex when a joint
//!   turns (module `skin`).
//!
//! The module `attribute_quadrics` computes the deviations of these lengths.

use super::skin::SkinValues;
use crate::mesh::{Attribute, Mesh, triangles_of};
use crate::simplify::options::AttributeWeights;
use crate::vector::{Point, dot, normal_of};

/// The distance, in units of the frame, that is as bad as a difference of 1 between unit normals.
/// Tuned on images of a duck, a man, a truck and a fox: from 0.04 to 0.06, larger values gave
/// better normals, worse textures and more holes.
const NORMAL_LENGTH: f64 = 0.042;
/// The distance for tangents, which affect only normal maps.
const TANGENT_LENGTH: f64 = 0.03;
/// The distance for a change of 1, from none to full, in a colour component.
const COLOUR_LENGTH: f64 = 0.1;
/// The expected rotation of joints in radians. From 0.1 to 0.5, larger values were better for the
/// man, even in the pose of the file, and worse for the fox.
const SKIN_LENGTH: f64 = 0.1;
/// The distance that is as bad as a texture shift of 1 on the surface. From 1 to 2, on the same
/// images, larger values gave better textures and worse normals.
const TEXTURE_SHARE: f64 = 1.5;
/// The maximum number of values per vertex. The time of a price is proportional to their number.
const MAX_VALUES: usize = 32;
/// The maximum length of a unit of a texture coordinate, so that an atlas that a model hardly uses
/// does not outweigh the shape.
const MAX_TEXTURE_LENGTH: f64 = 8.0;

/// The values of the priced attributes, as lengths in the local frame.
#[derive(Debug)]
pub(crate) struct PricedAttributes {
    /// The number of values per vertex.
    width: usize,
    values: Vec<f32>,
}

impl PricedAttributes {
    /// Collects the attributes of a mesh that have a weight; `None` if it has none. Values that are
    /// not finite count as zero. Values beyond [`MAX_VALUES`] per vertex are ignored.
    pub(crate) fn new(mesh: &Mesh, triangles: &[u32], unit: f64, weights: AttributeWeights) -> Option<Self> {
        let length = |attribute: &&Attribute| length_of(mesh, attribute, triangles, unit, weights);
        let lengths = mesh.attributes().iter().map(|attribute| (attribute, length(&attribute)));
        let columns: Vec<(&Attribute, f64)> = lengths.filter(|&(_, length)| length > 0.0).collect();
        let of_skin = SKIN_LENGTH * f64::from(weights.skin);
        let skin = if of_skin > 0.0 { SkinValues::new(mesh, unit) } else { None };
        let width: usize = columns.iter().map(|(attribute, _)| usize::from(attribute.components)).sum();
        let width = (width + skin.as_ref().map_or(0, |skin| skin.width)).min(MAX_VALUES);
        let mut values = Vec::with_capacity(width * mesh.vertex_count());
        for v in 0..mesh.vertex_count() {
            let of_skin = skin.iter().flat_map(|skin| skin.of(v).iter().map(|&x| f64::from(x) * of_skin));
            let of_columns = columns.iter().flat_map(|&(attribute, length)| {
                let n = usize::from(attribute.components);
                (n * v..n * (v + 1)).map(move |i| f64::from(finite(attribute.float(i))) * length)
            });
            values.extend(
                of_columns
                    .chain(of_skin)
                    .take(width)
                    .map(|x| x.clamp(f32::MIN.into(), f32::MAX.into()) as f32),
            );
        }
        (width > 0).then_some(Self { width, values })
    }

    /// Joins the values of several meshes, each with its number of vertices; `None` if no mesh has
    /// any. Values are compared only within a mesh.
    pub(crate) fn joined(meshes: &[(Option<Self>, usize)]) -> Option<Self> {
        let width = meshes.iter().filter_map(|(priced, _)| Some(priced.as_ref()?.width)).max()?;
        let mut values =
            vec![0.0; width * meshes.iter().map(|(_, vertex_count)| vertex_count).sum::<usize>()];
        let mut rows = values.chunks_exact_mut(width);
        for (priced, vertex_count) in meshes {
            let rows = rows.by_ref().take(*vertex_count);
            match priced {
                None => rows.for_each(drop),
                Some(priced) => rows
                    .zip(priced.values.chunks_exact(priced.width))
                    .for_each(|(row, own)| row[..priced.width].copy_from_slice(own)),
            }
        }
        Some(Self { width, values })
    }

    /// Returns the number of values per vertex.
    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// Returns the number of vertices.
    pub(crate) fn vertex_count(&self) -> usize {
        self.values.len() / self.width
    }

    /// Returns the values of a vertex.
    pub(crate) fn of(&self, vertex: u32) -> &[f32] {
        &self.values[vertex as usize * self.width..][..self.width]
    }
}

/// Returns the length of a unit of an attribute, in units of the frame; 0 if it has no price.
fn length_of(
    mesh: &Mesh,
    attribute: &Attribute,
    triangles: &[u32],
    unit: f64,
    weights: AttributeWeights,
) -> f64 {
    match (attribute.name.trim_end_matches(|c: char| c.is_ascii_digit()), attribute.components) {
        ("NORMAL", 3) => NORMAL_LENGTH * f64::from(weights.normal),
        ("TANGENT", 4) => TANGENT_LENGTH * f64::from(weights.tangent),
        ("TEXCOORD_", 2) if weights.uv > 0.0 => {
            TEXTURE_SHARE * texture_length(mesh, attribute, triangles, unit) * f64::from(weights.uv)
        }
        ("COLOR_", 3 | 4) => COLOUR_LENGTH * f64::from(weights.colour),
        _ => 0.0,
    }
}

fn finite(value: Option<f32>) -> f32 {
    value.filter(|value| value.is_finite()).unwrap_or(0.0)
}

/// Returns the mean length on the surface of a unit of the texture coordinates, in units of the
/// frame; 0 if they cover no area.
fn texture_length(mesh: &Mesh, attribute: &Attribute, triangles: &[u32], unit: f64) -> f64 {
    let position = |v: u32| -> Point {
        mesh.positions().get(v as usize).map_or([0.0; 3], |p| p.map(|x| f64::from(x) / unit))
    };
    let texture = |v: u32| -> Point {
        [
            finite(attribute.float(2 * v as usize)).into(),
            finite(attribute.float(2 * v as usize + 1)).into(),
            0.0,
        ]
    };
    let area = |corners: [Point; 3]| {
        let normal = normal_of(corners);
        dot(normal, normal).sqrt()
    };
    let (mut on_surface, mut on_texture) = (0.0, 0.0);
    for triangle in triangles_of(triangles) {
        on_surface += area(triangle.map(position));
        on_texture += area(triangle.map(texture));
    }
    if on_texture > 0.0 { (on_surface / on_texture).sqrt().min(MAX_TEXTURE_LENGTH) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{AttributeData, Faces};
    use crate::simplify::{SimplifyOptions, simplify};
    use crate::vector::{nearest_in_triangle, sub};

    const SIDE: u32 = 20;

    /// Returns a flat grid with one attribute.
    fn grid(name: &str, components: u8, value: impl Fn(f32, f32) -> Vec<f32>) -> Mesh {
        let at = |i: u32| [(i % (SIDE + 1)) as f32, (i / (SIDE + 1)) as f32, 0.0];
        let quad = |i: u32| {
            let v = i / SIDE * (SIDE + 1) + i % SIDE;
            [v, v + 1, v + SIDE + 1, v + SIDE + 1, v + 1, v + SIDE + 2]
        };
        let positions: Vec<[f32; 3]> = (0..(SIDE + 1) * (SIDE + 1)).map(at).collect();
        let faces = Faces::from_triangles((0..SIDE * SIDE).flat_map(quad).collect()).unwrap();
        let data = AttributeData::F32(positions.iter().flat_map(|p| value(p[0], p[1])).collect());
        let attribute = Attribute { name: name.into(), components, normalized: false, data };
        Mesh::new(positions, faces).unwrap().with_attribute(attribute).unwrap()
    }

    /// Simplifies a flat grid to 24 triangles, and returns the maximum difference of the attribute
    /// at a vertex of the grid.
    fn largest_difference(mesh: &Mesh, weights: AttributeWeights) -> f64 {
        let options = SimplifyOptions::default().with_triangles(24).with_weights(weights);
        let simple = simplify(mesh, &options).unwrap();
        let base = simple.simplification.sequence.drawn(0).unwrap();
        let attribute = &mesh.attributes()[0];
        let n = usize::from(attribute.components);
        let value = |v: u32, k: usize| f64::from(attribute.float(v as usize * n + k).unwrap());
        let point = |v: u32| mesh.positions()[v as usize].map(f64::from);
        let difference = |v: u32| {
            let distance = |triangle: &[u32; 3]| {
                let corners = triangle.map(point);
                let shares = nearest_in_triangle(point(v), corners);
                let near = [0, 1, 2].map(|k| (0..3).map(|i| shares[i] * corners[i][k]).sum::<f64>());
                let rest = sub(near, point(v));
                let of =
                    |k: usize| (0..3).map(|i| shares[i] * value(triangle[i], k)).sum::<f64>() - value(v, k);
                (dot(rest, rest), (0..n).map(|k| of(k).abs()).fold(0.0, f64::max))
            };
            base.iter().map(distance).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap().1
        };
        (0..mesh.vertex_count() as u32).map(difference).fold(0.0, f64::max)
    }

    /// On a plane, every collapse has the same shape price, so only the attribute determines which
    /// vertices are kept.
    #[test]
    fn kinks_of_an_attribute_stay() {
        let none = AttributeWeights::NONE;
        let texture =
            |x: f32, y: f32| vec![if x < 10.0 { x / 40.0 } else { 0.25 + (x - 10.0) / 16.0 }, y / 20.0];
        let bent = |x: f32, _: f32| {
            let angle = (x - 10.0).clamp(-3.0, 3.0) / 3.0;
            vec![angle.sin(), 0.0, angle.cos()]
        };
        let colour = |_: f32, y: f32| vec![(y - 10.0).abs() / 10.0; 3];
        let tangent = |x: f32, y: f32| [bent(x, y), vec![1.0]].concat();
        let blend = |x: f32, _: f32| {
            let first = ((x - 7.0) / 6.0).clamp(0.0, 1.0);
            vec![first, 1.0 - first]
        };
        let joints = AttributeData::U8([0, 1].repeat((SIDE as usize + 1).pow(2)));
        let joints = Attribute { name: "JOINTS_0".into(), components: 2, normalized: false, data: joints };
        let meshes = [
            (grid("TEXCOORD_0", 2, texture), 0.03),
            (grid("TEXCOORD_3", 2, texture), 0.03),
            (grid("NORMAL", 3, bent), 0.25),
            (grid("TANGENT", 4, tangent), 0.25),
            (grid("COLOR_0", 3, colour), 0.1),
            (grid("WEIGHTS_0", 2, blend).with_attribute(joints).unwrap(), 0.2),
        ];
        for (mesh, most) in meshes {
            let name = &mesh.attributes()[0].name;
            let [with, without] = [AttributeWeights::default(), none].map(|w| largest_difference(&mesh, w));
            assert!(with < most && with < 0.5 * without, "{name}: {with} with a weight, {without} without");
        }
    }

    #[test]
    fn a_texture_is_as_large_as_its_image_on_the_surface() {
        // The texture covers the surface of 20 × 20 units once, then five times in each direction.
        for repeats in [1.0, 5.0] {
            let mesh = grid("TEXCOORD_0", 2, |x, y| vec![x / 20.0 * repeats, y / 20.0 * repeats]);
            let triangles = mesh.faces().as_triangles().unwrap();
            let length = texture_length(&mesh, &mesh.attributes()[0], triangles, 20.0);
            assert!((length * f64::from(repeats) - 1.0).abs() < 1e-6, "{length}");
        }
        let mesh = grid("TEXCOORD_0", 2, |x, _| vec![x, f32::NAN]);
        let triangles = mesh.faces().as_triangles().unwrap();
        assert!(texture_length(&mesh, &mesh.attributes()[0], triangles, 20.0) == 0.0);
        assert!(PricedAttributes::new(&mesh, triangles, 20.0, AttributeWeights::default()).is_none());
    }
}
