//! The joints that move each vertex of a skin, converted to lengths.
//!
//! A skin moves a vertex by the weighted mean of its joints (`JOINTS_n`, `WEIGHTS_n`). Vertices
//! with different weights move differently. If a joint turns by a radian, the displacement differs
//! by the difference of the weights times the distance from the joint. This module uses that
//! product as the length of a weight. It replaces the distance by the extent of the part that the
//! joint moves.
//!
//! # Algorithm
//! 1. The extent of a joint's part is the weighted root mean square distance of its vertices from
//!    their centre.
//! 2. The weights of a vertex times the extents form a vector with one value per joint. Few values
//!    are nonzero. With more than [`MAX_VALUES`] joints, the vector is projected onto that many
//!    values. Each of these values is a sum over all joints with fixed signs. Averaged over all
//!    choices of these signs, the projection preserves the distances between vectors. The signs
//!    come from a fixed hash, so results are reproducible.
//!
//! # References
//! Achlioptas: *Database-friendly Random Projections*, 2001.
//!
//! # Complexity
//! O(n log j) time for n vertices and j joints; 32 bytes per vertex and about 60 per joint.

use std::collections::BTreeMap;

use crate::mesh::{Attribute, AttributeData, Mesh};

/// The maximum number of values per vertex for joints.
const MAX_VALUES: usize = 8;

/// The joint weights as lengths.
#[derive(Debug)]
pub(crate) struct SkinValues {
    /// The number of values per vertex.
    pub(crate) width: usize,
    values: Vec<f32>,
}

/// The weighted moments of the part that a joint moves.
#[derive(Debug, Clone, Copy, Default)]
struct JointMoments {
    weight: f64,
    sum: [f64; 3],
    squares: f64,
}

impl JointMoments {
    fn add(&mut self, weight: f64, position: [f64; 3]) {
        self.weight += weight;
        for (sum, x) in self.sum.iter_mut().zip(position) {
            *sum += weight * x;
            self.squares += weight * x * x;
        }
    }

    /// Returns the root mean square distance from the centre.
    fn extent(&self) -> f64 {
        if self.weight <= 0.0 {
            return 0.0;
        }
        let centre = self.sum.map(|sum| sum / self.weight);
        (self.squares / self.weight - centre.map(|x| x * x).iter().sum::<f64>()).max(0.0).sqrt()
    }
}

impl SkinValues {
    /// Computes the values of a mesh in a frame with the given unit; `None` if it has no skin.
    pub(crate) fn new(mesh: &Mesh, unit: f64) -> Option<Self> {
        let influences = Influences::of(mesh);
        let mut moments: BTreeMap<u32, JointMoments> = BTreeMap::new();
        for (v, position) in mesh.positions().iter().enumerate() {
            let position = position.map(|x| f64::from(x) / unit);
            for (joint, weight) in influences.at(v) {
                moments.entry(joint).or_default().add(weight, position);
            }
        }
        let joints = moments.into_iter().enumerate();
        let joints: BTreeMap<u32, (usize, f64)> =
            joints.map(|(number, (joint, moments))| (joint, (number, moments.extent()))).collect();
        let width = joints.len().min(MAX_VALUES);
        let mut values = vec![0.0; width * mesh.vertex_count()];
        for v in 0..mesh.vertex_count() {
            for (joint, weight) in influences.at(v) {
                let Some(&(number, extent)) = joints.get(&joint) else { continue };
                for (k, value) in values[v * width..][..width].iter_mut().enumerate() {
                    *value += (weight * extent * share(number, k, joints.len())) as f32;
                }
            }
        }
        (width > 0).then_some(Self { width, values })
    }

    /// Returns the values of a vertex.
    pub(crate) fn of(&self, vertex: usize) -> &[f32] {
        &self.values[vertex * self.width..][..self.width]
    }
}

/// Returns the share of a joint in a value: 1 or 0 if each joint has its own value, otherwise the
/// same magnitude for each, added or subtracted.
fn share(joint: usize, value: usize, joint_count: usize) -> f64 {
    if joint_count <= MAX_VALUES {
        return f64::from(u8::from(joint == value));
    }
    let hash = (joint as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let sign = if hash >> (40 + value) & 1 == 0 { 1.0 } else { -1.0 };
    sign / (MAX_VALUES as f64).sqrt()
}

/// Returns the joint index stored as value `i` of an attribute.
fn joint_number(joints: &Attribute, i: usize) -> Option<u32> {
    match &joints.data {
        AttributeData::U8(numbers) => numbers.get(i).map(|&joint| joint.into()),
        AttributeData::U16(numbers) => numbers.get(i).map(|&joint| joint.into()),
        AttributeData::U32(numbers) => numbers.get(i).copied(),
        _ => None,
    }
}

/// The pairs of attributes with joints and their weights.
struct Influences<'a>(Vec<[&'a Attribute; 2]>);

impl<'a> Influences<'a> {
    fn of(mesh: &'a Mesh) -> Self {
        let weights_of = |joints: &&'a Attribute| {
            let name = format!("WEIGHTS_{}", joints.name.strip_prefix("JOINTS_")?);
            mesh.attributes().iter().find(|other| other.name == name && other.components == joints.components)
        };
        Self(mesh.attributes().iter().filter_map(|joints| Some([joints, weights_of(&joints)?])).collect())
    }

    /// Iterates over the joints of a vertex and their weights.
    fn at(&self, vertex: usize) -> impl Iterator<Item = (u32, f64)> {
        self.0.iter().flat_map(move |[joints, weights]| {
            let components = usize::from(joints.components);
            (vertex * components..(vertex + 1) * components).filter_map(move |i| {
                let weight = weights.float(i).filter(|&weight| weight > 0.0 && weight.is_finite())?;
                Some((joint_number(joints, i)?, weight.min(1.0).into()))
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Faces;

    /// Returns points along a line, each moved by the joint of its segment and the next one.
    fn chain(joint_count: u16) -> Mesh {
        let positions: Vec<[f32; 3]> =
            (0..10 * (joint_count - 1)).map(|i| [f32::from(i), 0.0, 0.0]).collect();
        let joints = (0..positions.len() as u16).flat_map(|i| [i / 10, i / 10 + 1]).collect();
        let weights =
            (0..positions.len() as u16).map(|i| f32::from(i % 10) / 10.0).flat_map(|w| [1.0 - w, w]);
        let attribute =
            |name: &str, data| Attribute { name: name.into(), components: 2, normalized: false, data };
        let weights = attribute("WEIGHTS_0", AttributeData::F32(weights.collect()));
        let mesh = Mesh::new(positions, Faces::default()).unwrap();
        mesh.with_attribute(attribute("JOINTS_0", AttributeData::U16(joints)))
            .unwrap()
            .with_attribute(weights)
            .unwrap()
    }

    #[test]
    fn few_joints_have_a_value_each() {
        let skin = SkinValues::new(&chain(3), 1.0).unwrap();
        assert_eq!((skin.width, skin.values.len()), (3, 60));
        // The second joint moves points 1 to 19, the middle one most. Their mean distance from the
        // centre is about four.
        assert!((3.5..4.5).contains(&skin.values[3 * 10 + 1]), "{}", skin.values[31]);
        assert!(skin.values[..3].iter().filter(|&&x| x > 0.0).count() == 1);
    }

    #[test]
    fn many_joints_keep_the_distances_of_vertices() {
        let skin = SkinValues::new(&chain(40), 1.0).unwrap();
        assert_eq!(skin.width, MAX_VALUES);
        let of = |v: usize| &skin.values[v * MAX_VALUES..][..MAX_VALUES];
        let distance = |a: usize, b: usize| {
            of(a).iter().zip(of(b)).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>().sqrt()
        };
        // Points at inner joints differ by the extents of both, about four each.
        let distances: Vec<f64> = (1..38).map(|i| distance(10 * i, 10 * i + 10)).collect();
        let mean = distances.iter().sum::<f64>() / 37.0;
        assert!((4.5..6.5).contains(&mean), "{mean}");
        assert!(distances.iter().all(|&distance| distance > 1.0), "{distances:?}");
    }

    #[test]
    fn wrong_joints_and_weights_do_not_count() {
        let mut mesh = chain(3);
        let plain = Mesh::new(mesh.positions().to_vec(), Faces::default()).unwrap();
        assert!(SkinValues::new(&plain, 1.0).is_none());
        let wrong = Attribute {
            name: "JOINTS_1".into(),
            components: 1,
            normalized: false,
            data: AttributeData::F32([f32::NAN, -1.0, 1e9, 0.0].repeat(5)),
        };
        let unused = Attribute {
            name: "JOINTS_2".into(),
            components: 1,
            normalized: false,
            data: AttributeData::U32([9, u32::MAX].repeat(10)),
        };
        let no_weights = Attribute {
            name: "WEIGHTS_2".into(),
            data: AttributeData::F32([f32::NAN, 0.0].repeat(10)),
            ..unused.clone()
        };
        let weights = Attribute {
            name: "WEIGHTS_1".into(),
            data: AttributeData::F32([1.0, 1.0, 1.0, f32::NAN].repeat(5)),
            ..wrong.clone()
        };
        mesh = mesh.with_attribute(unused).unwrap().with_attribute(no_weights).unwrap();
        mesh = mesh.with_attribute(wrong).unwrap().with_attribute(weights).unwrap();
        assert_eq!(
            SkinValues::new(&mesh, 1.0).unwrap().values,
            SkinValues::new(&chain(3), 1.0).unwrap().values
        );
    }
}
