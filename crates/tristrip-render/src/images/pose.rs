//! The pose of a part in the scene: morph targets, then the joints of a skin or the transform of a
//! node.
//!
//! # Algorithm
//! Linear blend skinning as defined by glTF: the transform of a vertex is the weighted sum of its
//! joint matrices. Weights that do not sum to 1 are normalized; a vertex without weights follows
//! its first joint. Normals are transformed by the cofactor matrix.
//!
//! # References
//! The Khronos Group: *glTF 2.0 Specification*, 2021, sections 3.7.2.2 (morph targets) and 3.7.3
//! (skins).
//!
//! # Complexity
//! Linear in triangle corners and joints per vertex. Displacements are stored for one instance at a
//! time.

use std::collections::BTreeSet;

use tristrip::{Attribute, Mesh};
use tristrip_io::Model;
use tristrip_io::gltf::{Instance, MorphReader, Skin};

use super::attributes::values;
use super::vector::{Vector, add, cross, dot, unit};
use crate::error::Error;

/// The number of joints and weights per attribute.
const JOINTS: usize = 4;

/// The rows of an affine transform.
type Transform = [[f64; 4]; 3];

/// Computes the poses of a scene's parts.
pub(super) struct Poses<'a> {
    skins: &'a [Skin],
    morphs: Option<MorphReader<'a>>,
    notes: BTreeSet<String>,
}

/// The pose of a part's vertices.
pub(super) struct Pose<'a> {
    place: Placement,
    /// Morph displacements of positions and of normals.
    moved: [Option<Vec<[f32; 3]>>; 2],
    joints: Option<Joints<'a>>,
}

/// The joints of a mesh's vertices.
struct Joints<'a> {
    matrices: &'a [Transform],
    /// Joint attributes with their weights.
    sets: Vec<(&'a Attribute, &'a Attribute)>,
}

/// An affine transform and its normal matrix.
struct Placement {
    rows: Transform,
    /// The rows of the normal matrix: the cofactors, which are the inverse transpose times the
    /// determinant.
    of_normals: [Vector; 3],
}

impl<'a> Poses<'a> {
    pub(super) fn new(model: &'a Model, skins: &'a [Skin]) -> Self {
        let morphs = model.scene.as_ref().map(tristrip_io::gltf::Scene::morph_reader);
        Self { skins, morphs, notes: BTreeSet::new() }
    }

    /// Returns the pose of a part's instance.
    pub(super) fn of(&mut self, mesh: &'a Mesh, instance: &Instance) -> Pose<'a> {
        let moved = ["POSITION", "NORMAL"].map(|name| self.displacements(mesh, instance, name));
        let skin = instance.skin.and_then(|skin| self.skins.get(skin));
        let joints = skin.and_then(|skin| Joints::of(&skin.joints, mesh));
        Pose { place: Placement::of(instance.transform), moved, joints }
    }

    /// Returns the morph displacements of a part's vertices, if they can be read.
    fn displacements(&mut self, mesh: &Mesh, instance: &Instance, name: &str) -> Option<Vec<[f32; 3]>> {
        match self.morphs.as_mut()?.displacements(instance.part, instance.node, name) {
            Ok(moved) => moved.filter(|moved| moved.len() == mesh.vertex_count()),
            Err(error) => {
                self.notes.insert(format!("drawn without morph targets: {error}"));
                None
            }
        }
    }

    /// Returns the differences between the image and the file, as text.
    pub(super) fn into_notes(self) -> impl Iterator<Item = String> {
        self.notes.into_iter()
    }
}

impl Pose<'_> {
    /// Returns the position of a vertex in the scene.
    pub(super) fn point(&self, point: Vector, vertex: u32) -> Result<Vector, Error> {
        let point = self.displaced(0, point, vertex);
        let moved = match self.of_joints(vertex) {
            Some(place) => place.point(point),
            None => self.place.point(point),
        };
        if moved.iter().all(|x| x.is_finite()) {
            return Ok(moved);
        }
        Err(Error::Image(format!("scene: found a vertex at {moved:?}, expected finite coordinates")))
    }

    /// Returns the unit normal of a vertex in the scene.
    pub(super) fn normal(&self, normal: Vector, vertex: u32) -> Option<Vector> {
        let normal = self.displaced(1, normal, vertex);
        match self.of_joints(vertex) {
            Some(place) => place.normal(normal),
            None => self.place.normal(normal),
        }
    }

    fn displaced(&self, of: usize, value: Vector, vertex: u32) -> Vector {
        let moved = self.moved[of].as_ref().and_then(|moved| moved.get(vertex as usize));
        moved.map_or(value, |moved| add(value, moved.map(f64::from)))
    }

    fn of_joints(&self, vertex: u32) -> Option<Placement> {
        self.joints.as_ref()?.blended(vertex).map(Placement::of)
    }
}

impl<'a> Joints<'a> {
    /// Finds the joints and weights of a mesh. Returns `None` if it has none.
    fn of(matrices: &'a [Transform], mesh: &'a Mesh) -> Option<Self> {
        let attribute = |name: &str| mesh.attributes().iter().find(|attribute| attribute.name == name);
        let set = |number: usize| {
            Some((attribute(&format!("JOINTS_{number}"))?, attribute(&format!("WEIGHTS_{number}"))?))
        };
        let sets: Vec<_> = (0..).map_while(set).collect();
        (!sets.is_empty()).then_some(Self { matrices, sets })
    }

    /// Returns the transform of a vertex, or `None` if it has no joint of the skin.
    fn blended(&self, vertex: u32) -> Option<Transform> {
        let (mut sum, mut total) = (Transform::default(), 0.0);
        for (joints, weights) in &self.sets {
            let joints = values::<JOINTS>(joints, vertex);
            for (joint, weight) in joints.into_iter().zip(values::<JOINTS>(weights, vertex)) {
                // NaN is not a valid weight either.
                let Some(matrix) = self.matrix(joint).filter(|_| weight > 0.0) else { continue };
                let weight = f64::from(weight);
                total += weight;
                for (sum, x) in sum.iter_mut().flatten().zip(matrix.iter().flatten()) {
                    *sum += weight * x;
                }
            }
        }
        if total > 0.0 {
            return Some(sum.map(|row| row.map(|x| x / total)));
        }
        let [first] = values(self.sets.first()?.0, vertex);
        self.matrix(first).copied()
    }

    fn matrix(&self, joint: f32) -> Option<&'a Transform> {
        #[allow(clippy::cast_sign_loss, reason = "joints are not negative; negative numbers become 0")]
        self.matrices.get(joint as usize)
    }
}

impl Placement {
    fn of(rows: Transform) -> Self {
        let [a, b, c] = rows.map(|[x, y, z, _]| [x, y, z]);
        let cofactors = [cross(b, c), cross(c, a), cross(a, b)];
        let sign = if dot(a, cofactors[0]) < 0.0 { -1.0 } else { 1.0 };
        Self { rows, of_normals: cofactors.map(|row| row.map(|x| sign * x)) }
    }

    fn point(&self, point: Vector) -> Vector {
        self.rows.map(|[x, y, z, offset]| dot([x, y, z], point) + offset)
    }

    fn normal(&self, normal: Vector) -> Option<Vector> {
        unit(self.of_normals.map(|row| dot(row, normal)))
    }
}
