//! The attributes of the vertices: how far they are from those of the triangles that would replace a point's own.
//!
//! Positions, normals, texture coordinates and colours have different units. Each becomes a length on the surface, so that its deviation
//! adds to the distance between the surfaces:
//! - *texture coordinates*: the distance by which the texture moves over the surface, by the mean size of the texture on it. A model
//!   with a repeated texture thus counts like one with an atlas;
//! - *normals* and *colours*: the difference, times a fixed length in the local frame ([`NORMAL_LENGTH`], [`COLOUR_LENGTH`]): a surface that moves by
//!   that length is as bad as a normal that turns by a radian, or a colour from black to full.
//!
//! # References
//! Garland, Heckbert: *Simplifying Surfaces with Color and Texture using Quadric Error Metrics*, 1998, and Hoppe: *New Quadric Metric for
//! Simplifying Meshes with Appearance Attributes*, 1999, add attributes to the quadric. Here they are compared where a vertex was, like the
//! distance to the new triangles.

use super::options::AttributeWeights;
use crate::mesh::{Attribute, Mesh, triangles_of};
use crate::vector::{Point, dot, normal_of, sub};

/// The distance, in units of the frame, that is as bad as a difference of 1 between unit normals. Of 0.03, 0.1, 0.2 and 0.4 this gave the pictures of a
/// duck and of a man that differ least: textured, by normals and by texture coordinates together.
const NORMAL_LENGTH: f64 = 0.1;
/// The same for a component of a colour, of 1 between none and full.
const COLOUR_LENGTH: f64 = 0.1;
/// The largest length of a unit of a texture coordinate: an atlas that a model hardly uses does not outweigh its shape.
const MOST_TEXTURE_LENGTH: f64 = 8.0;

/// The values of the attributes that have a price, as lengths in the local frame.
#[derive(Debug)]
pub(super) struct PricedAttributes {
    /// The number of values per vertex.
    width: usize,
    values: Vec<f32>,
    /// The length of a unit normal, if the first three values are one.
    normal_length: Option<f64>,
}

impl PricedAttributes {
    /// Collects the normals, the texture coordinates and the colours of a mesh; `None` if it has none of these, or they have no weight.
    /// A value that is not finite counts as zero.
    pub(super) fn new(mesh: &Mesh, triangles: &[u32], unit: f64, weights: AttributeWeights) -> Option<Self> {
        let mut columns: Vec<(&Attribute, usize, f64)> = Vec::new();
        let mut normal_length = None;
        for attribute in mesh.attributes() {
            let components = usize::from(attribute.components);
            let (count, length) = match attribute.name.as_str() {
                "NORMAL" if components == 3 => (3, NORMAL_LENGTH * f64::from(weights.normal)),
                "TEXCOORD_0" | "TEXCOORD_1" if components == 2 => {
                    (2, texture_length(mesh, attribute, triangles, unit) * f64::from(weights.uv))
                }
                "COLOR_0" if components >= 3 => {
                    (components.min(4), COLOUR_LENGTH * f64::from(weights.colour))
                }
                _ => continue,
            };
            if length > 0.0 {
                if attribute.name == "NORMAL" {
                    normal_length = Some(length);
                    columns.insert(0, (attribute, count, length));
                } else {
                    columns.push((attribute, count, length));
                }
            }
        }
        let width: usize = columns.iter().map(|column| column.1).sum();
        let mut values = Vec::with_capacity(width * mesh.vertex_count());
        for v in 0..mesh.vertex_count() {
            for &(attribute, count, length) in &columns {
                let at = |k: usize| attribute.float(v * usize::from(attribute.components) + k);
                values.extend((0..count).map(|k| (f64::from(finite(at(k))) * length) as f32));
            }
        }
        (width > 0).then_some(Self { width, values, normal_length })
    }

    /// Joins the values of several meshes, each with its number of vertices, which are compared only within a mesh; `None` if no mesh has any.
    pub(super) fn joined(meshes: &[(Option<Self>, usize)]) -> Option<Self> {
        let of_all = || meshes.iter().filter_map(|(priced, _)| priced.as_ref());
        let normal_length = of_all().find_map(|priced| priced.normal_length);
        // Where one mesh has normals, the first three values of all are those.
        let first =
            |priced: &Self| if priced.normal_length.is_none() && normal_length.is_some() { 3 } else { 0 };
        let width = of_all().map(|priced| first(priced) + priced.width).max()?;
        let mut values =
            vec![0.0; width * meshes.iter().map(|(_, vertex_count)| vertex_count).sum::<usize>()];
        let mut rows = values.chunks_exact_mut(width);
        for (priced, vertex_count) in meshes {
            let rows = rows.by_ref().take(*vertex_count);
            let Some(priced) = priced else {
                rows.for_each(drop);
                continue;
            };
            let first = first(priced);
            for (row, own) in rows.zip(priced.values.chunks_exact(priced.width)) {
                row[first..first + priced.width].copy_from_slice(own);
            }
        }
        Some(Self { width, values, normal_length })
    }

    /// Returns the squared deviation of the attributes of a vertex from those at a point of a triangle, given as shares of its corners.
    pub(super) fn deviation(&self, vertex: u32, corners: [u32; 3], shares: [f64; 3]) -> f64 {
        let of = |v: u32| &self.values[v as usize * self.width..(v as usize + 1) * self.width];
        let ([a, b, c], own) = (corners.map(of), of(vertex));
        let at = |k: usize| {
            shares[0] * f64::from(a[k]) + shares[1] * f64::from(b[k]) + shares[2] * f64::from(c[k])
        };
        let mut sum = 0.0;
        let mut first = 0;
        if let Some(length) = self.normal_length {
            // An interpolated normal is drawn as a unit vector.
            let normal = [at(0), at(1), at(2)];
            let size = dot(normal, normal).sqrt();
            let scale = if size > 0.0 { length / size } else { 0.0 };
            let difference = sub(normal.map(|x| x * scale), [0, 1, 2].map(|k| f64::from(own[k])));
            sum += dot(difference, difference);
            first = 3;
        }
        for k in first..self.width {
            let difference = at(k) - f64::from(own[k]);
            sum += difference * difference;
        }
        sum
    }
}

fn finite(value: Option<f32>) -> f32 {
    value.filter(|value| value.is_finite()).unwrap_or(0.0)
}

/// Returns the mean length on the surface, in units of the frame, of a unit of the texture coordinates; zero if they cover no area.
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
    if on_texture > 0.0 { (on_surface / on_texture).sqrt().min(MOST_TEXTURE_LENGTH) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{AttributeData, Faces};
    use crate::simplify::{SimplifyOptions, simplify};
    use crate::vector::nearest_in_triangle;

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

    /// Simplifies a flat grid to 24 triangles, and returns the largest difference of the attribute at a vertex of the grid.
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

    /// On a plane every collapse has the same price by shape, so that only the attribute decides what stays.
    #[test]
    fn kinks_of_an_attribute_stay() {
        let none = AttributeWeights { normal: 0.0, uv: 0.0, colour: 0.0 };
        let texture =
            |x: f32, y: f32| vec![if x < 10.0 { x / 40.0 } else { 0.25 + (x - 10.0) / 16.0 }, y / 20.0];
        let bent = |x: f32, _: f32| {
            let angle = (x - 10.0).clamp(-3.0, 3.0) / 3.0;
            vec![angle.sin(), 0.0, angle.cos()]
        };
        let colour = |_: f32, y: f32| vec![(y - 10.0).abs() / 10.0; 3];
        let meshes = [
            (grid("TEXCOORD_0", 2, texture), 0.03),
            (grid("NORMAL", 3, bent), 0.25),
            (grid("COLOR_0", 3, colour), 0.1),
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
