//! The rest pose of a scene for rendering: vertices of a part deformed by morph weights and joints.
//!
//! ```text
//! vertex ─▶ + Σ weight × displacement (morph targets) ─▶ Σ weight × matrix (joints) ─▶ scene
//! matrix of a joint = transform of its node in the scene × its inverse bind matrix
//! ```
//! Animations are not applied. The joints and weights of a vertex are the attributes `JOINTS_0` and
//! `WEIGHTS_0` of its mesh. This module provides the joint matrices and the morph displacements.
//!
//! # Complexity
//! Linear in nodes and joints; each skin is read once. Displacements take 12 bytes per vertex of an
//! instance. A budget limits their total size, because many nodes may use one mesh with different
//! weights.

use std::collections::HashMap;

use tristrip::AttributeData;
use tristrip::text::counted;

use crate::error::Error;
use crate::gltf::document::accessor::AccessorResolver;
use crate::gltf::document::budget::DecodeBudget;
use crate::gltf::document::json::Members;
use crate::gltf::document::scene::Scene;
use crate::gltf::document::{Located, items};
use crate::gltf::read::placements::{Transform, of_node};

/// Maximum number of bytes of decoded displacements, plus 16 per byte of the buffers.
const FREE_BYTES: u64 = 64 << 20;
const BYTES_FACTOR: u64 = 16;

/// A skin in the rest pose.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct Skin {
    /// The rows of each joint's affine transform from the mesh to the scene, in the order of
    /// `JOINTS_0`: the transform of the joint times its inverse bind matrix.
    pub joints: Vec<[[f64; 4]; 3]>,
}

/// Reads the distinct skins used by nodes.
pub(in crate::gltf) struct SkinReader<'a> {
    resolver: AccessorResolver<'a>,
    /// The transforms of all nodes, after the first skin was read.
    transforms: Option<Vec<Transform>>,
    /// The index of each skin of the document; `None` if it cannot be read.
    known: HashMap<usize, Option<usize>>,
    pub(in crate::gltf) skins: Vec<Skin>,
    pub(in crate::gltf) notes: Vec<String>,
}

impl<'a> SkinReader<'a> {
    pub(in crate::gltf) fn new(scene: &'a Scene) -> Self {
        let resolver = AccessorResolver { root: &scene.document.root, buffers: &scene.buffers };
        Self { resolver, transforms: None, known: HashMap::new(), skins: Vec::new(), notes: Vec::new() }
    }

    /// Returns the index of a node's skin, or `None` if it has none or it cannot be read. The
    /// latter adds a note.
    pub(in crate::gltf) fn of_node(&mut self, node: usize) -> Option<usize> {
        let node = Located::entry(self.resolver.root, "nodes", node).ok()?;
        let skin = node.field("skin")?;
        let number = skin.size().unwrap_or(usize::MAX);
        if let Some(&known) = self.known.get(&number) {
            return known;
        }
        let read =
            self.read(&skin).map_err(|error| self.notes.push(format!("drawn without a skin: {error}")));
        let index = read.ok().map(|skin| {
            self.skins.push(skin);
            self.skins.len() - 1
        });
        self.known.insert(number, index);
        index
    }

    fn read(&mut self, reference: &Located<'a>) -> Result<Skin, Error> {
        let root = self.resolver.root;
        let skin = reference.target(root, "skins")?;
        let joints = skin.need("joints")?.items()?.collect::<Vec<_>>();
        let binds = skin.field("inverseBindMatrices");
        let binds = binds.map(|binds| self.matrices(&binds, joints.len())).transpose()?;
        if self.transforms.is_none() {
            self.transforms = Some(node_transforms(root)?);
        }
        let transforms = self.transforms.as_deref().unwrap_or_default();
        let matrix = |(number, joint): (usize, &Located<'a>)| {
            let place = transforms.get(joint.size()?);
            let expected = || joint.wrong(format!("less than {}, the number of nodes", transforms.len()));
            let place = place.ok_or_else(expected)?;
            let matrix = binds.as_ref().map_or(*place, |binds| place.of(&binds[number]));
            let found = "a transform that overflows";
            let wrong = || Error::format(joint.at.clone(), found, "a finite transform");
            if matrix.is_finite() { Ok(matrix.rows()) } else { Err(wrong()) }
        };
        Ok(Skin { joints: joints.iter().enumerate().map(matrix).collect::<Result<_, Error>>()? })
    }

    /// Returns the first `count` matrices of an accessor.
    fn matrices(&self, accessor: &Located<'a>, count: usize) -> Result<Vec<Transform>, Error> {
        let values = self.resolver.values(accessor)?;
        if values.count < count {
            let expected = format!("at least {count}, one per joint");
            return Err(Error::format(format!("{}.count", values.at), values.count.to_string(), expected));
        }
        let at = values.at.clone();
        let is_matrix = values.components == 16;
        match values.first(count)?.attribute()? {
            AttributeData::F32(all) if is_matrix => {
                let matrices = all.as_chunks::<16>().0.iter();
                Ok(matrices.map(|columns| Transform::of_columns(columns.map(f64::from))).collect())
            }
            _ => Err(Error::format(
                at,
                "values of another type",
                "MAT4 of 5126 (FLOAT) for `inverseBindMatrices`",
            )),
        }
    }
}

/// Returns the global transform of every node, including those outside the default scene, because a
/// joint may be any node.
fn node_transforms(root: &Members) -> Result<Vec<Transform>, Error> {
    let nodes: Vec<Located<'_>> = Located::entries(root, "nodes")?.collect();
    let mut children: Vec<Vec<usize>> = Vec::with_capacity(nodes.len());
    let mut is_child = vec![false; nodes.len()];
    for node in &nodes {
        let list = node.field("children").map(|list| list.items()?.map(|child| child.size()).collect());
        let list: Vec<usize> = list.transpose()?.unwrap_or_default();
        for &child in &list {
            if let Some(is_child) = is_child.get_mut(child) {
                *is_child = true;
            }
        }
        children.push(list);
    }
    let mut transforms: Vec<Option<Transform>> = vec![None; nodes.len()];
    let roots = (0..nodes.len()).filter(|&node| !is_child[node]);
    let mut open: Vec<(usize, Transform)> = roots.map(|node| (node, Transform::IDENTITY)).collect();
    while let Some((number, above)) = open.pop() {
        let Some(transform @ None) = transforms.get_mut(number) else { continue };
        let here = above.of(&of_node(&nodes[number])?);
        *transform = Some(here);
        open.extend(children[number].iter().map(|&child| (child, here)));
    }
    // Readers reject cycles, so every node is reachable from a root.
    Ok(transforms.into_iter().map(|transform| transform.unwrap_or(Transform::IDENTITY)).collect())
}

/// Reads the morph displacements of instances, with a common limit on their size.
#[derive(Debug)]
pub struct MorphReader<'a> {
    scene: &'a Scene,
    budget: DecodeBudget,
}

impl Scene {
    /// Returns a reader of the scene's morph targets.
    pub fn morph_reader(&self) -> MorphReader<'_> {
        MorphReader { scene: self, budget: DecodeBudget::new(FREE_BYTES, BYTES_FACTOR, &self.buffers) }
    }
}

impl MorphReader<'_> {
    /// Returns the morph displacement of each vertex of a part at a node: the weighted sum of the
    /// targets' values of `attribute`, which is `POSITION` or `NORMAL`. The weights come from the
    /// node, or from the mesh if the node has none. Returns `None` if no target with a nonzero
    /// weight has such values.
    ///
    /// # Errors
    /// The weights or targets are not valid glTF 2.0, or the displacements exceed the limit.
    ///
    /// ```
    /// let json = br#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0,"weights":[0.5]}],
    ///     "meshes":[{"primitives":[{"attributes":{"POSITION":0},"targets":[{"POSITION":0}]}]}],
    ///     "accessors":[{"componentType":5126,"count":3,"type":"VEC3"}]}"#;
    /// let scene = tristrip_io::gltf::read(json.to_vec(), None)?.scene.unwrap_or_default();
    /// let moved = scene.morph_reader().displacements(0, Some(0), "POSITION")?;
    /// assert_eq!(moved, Some(vec![[0.0; 3]; 3]));
    /// # Ok::<(), tristrip_io::Error>(())
    /// ```
    pub fn displacements(
        &mut self,
        part: usize,
        node: Option<usize>,
        attribute: &str,
    ) -> Result<Option<Vec<[f32; 3]>>, Error> {
        let root = &self.scene.document.root;
        let Some(source) = self.scene.primitives.get(part) else { return Ok(None) };
        let mesh = Located::entry(root, "meshes", source.mesh)?;
        let node = node.map(|node| Located::entry(root, "nodes", node)).transpose()?;
        let weights = node.and_then(|node| node.field("weights")).or_else(|| mesh.field("weights"));
        let primitive = items(mesh.value, "primitives").get(source.primitive).map(|value| {
            let at = format!("{}.primitives[{}]", mesh.at, source.primitive);
            Located { value, at }
        });
        let targets = primitive.and_then(|primitive| primitive.field("targets"));
        let Some((weights, targets)) = weights.zip(targets) else { return Ok(None) };
        let resolver = AccessorResolver { root, buffers: &self.scene.buffers };
        let mut sum: Option<Vec<[f32; 3]>> = None;
        for (weight, target) in weights.items()?.zip(targets.items()?) {
            let weight = weight.number()? as f32;
            let Some(accessor) = target.field(attribute).filter(|_| weight != 0.0) else { continue };
            let values = resolver.values(&accessor)?.positions(root, &mut self.budget)?;
            let sum = sum.get_or_insert_with(|| vec![[0.0; 3]; values.len()]);
            if sum.len() != values.len() {
                let expected = format!("{}, as in the other targets", sum.len());
                return Err(Error::format(accessor.at, counted(values.len(), "value"), expected));
            }
            for (sum, value) in sum.iter_mut().zip(values) {
                *sum = [0, 1, 2].map(|axis| sum[axis] + weight * value[axis]);
            }
        }
        Ok(sum)
    }
}

#[cfg(test)]
mod tests {
    use base64::Engine;
    use base64::engine::general_purpose::STANDARD;

    use super::*;

    /// Returns the scene of a triangle with these nodes and additional members; accessors from 1 on
    /// contain floats.
    fn scene(members: &str) -> Scene {
        let json = format!(
            r#"{{"asset":{{"version":"2.0"}},
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"targets":[{{"POSITION":2}},{{"POSITION":3}}]}}],"weights":[0,0.5]}}],
            "accessors":[{{"componentType":5126,"count":3,"type":"VEC3"}},
                {{"componentType":5126,"count":2,"type":"MAT4","bufferView":0}},
                {{"componentType":5126,"count":3,"type":"VEC3","bufferView":0}},
                {{"componentType":5126,"count":3,"type":"VEC3","bufferView":0,"byteOffset":64}},
                {{"componentType":5126,"count":1,"type":"MAT4","bufferView":0}}],
            "bufferViews":[{{"buffer":0,"byteLength":128}}],"buffers":[{{"byteLength":128,"uri":"data:;base64,{}"}}],{members}}}"#,
            bytes()
        );
        crate::gltf::read(json.into_bytes(), None).unwrap().scene.unwrap()
    }

    #[test]
    fn joints_stand_where_their_nodes_do_after_the_inverse_bind_matrices() {
        let nodes = r#""nodes":[{"mesh":0,"skin":0,"translation":[9,9,9]},{"translation":[0,0,3],"children":[2]},{"scale":[2,2,2]}],
            "scenes":[{"nodes":[0]}]"#;
        let skins = r#""skins":[{"joints":[2,1],"inverseBindMatrices":1}]"#;
        let appearance = scene(&format!("{nodes},{skins}")).appearance().unwrap();
        assert_eq!((appearance.instances[0].skin, appearance.skins.len()), (Some(0), 1));
        // The bind matrices translate by 1, 2, 3 and 4, 5, 6; the first joint then scales by 2.
        let joints = &appearance.skins[0].joints;
        assert_eq!(joints[0], [[2.0, 0.0, 0.0, 2.0], [0.0, 2.0, 0.0, 4.0], [0.0, 0.0, 2.0, 9.0]]);
        assert_eq!(joints[1], [[1.0, 0.0, 0.0, 4.0], [0.0, 1.0, 0.0, 5.0], [0.0, 0.0, 1.0, 9.0]]);
        let plain = scene(&format!(r#"{nodes},"skins":[{{"joints":[2]}}]"#)).appearance().unwrap();
        assert_eq!(
            plain.skins[0].joints,
            [[[2.0, 0.0, 0.0, 0.0], [0.0, 2.0, 0.0, 0.0], [0.0, 0.0, 2.0, 3.0]]]
        );
        for (skins, message) in [
            (r#""skins":[]"#, "nodes[0].skin: found 0, expected less than 0, the number of skins"),
            (r#""skins":[{"joints":[7]}]"#, "skins[0].joints[0]: found 7, expected less than 3"),
            (
                r#""skins":[{"joints":[1,2],"inverseBindMatrices":4}]"#,
                "accessors[4].count: found 1, expected at least 2",
            ),
            (r#""skins":[{"joints":[1],"inverseBindMatrices":0}]"#, "expected MAT4 of 5126 (FLOAT)"),
        ] {
            let appearance = scene(&format!("{nodes},{skins}")).appearance().unwrap();
            assert_eq!(
                (appearance.instances[0].skin, appearance.skins.len(), appearance.notes.len()),
                (None, 0, 1)
            );
            assert!(appearance.notes[0].contains(message), "{:?}", appearance.notes);
        }
    }

    #[test]
    fn weights_of_the_node_come_before_those_of_the_mesh() {
        let moved = |node: &str| {
            let scene = scene(&format!(r#""nodes":[{{"mesh":0{node}}}]"#));
            scene.morph_reader().displacements(0, Some(0), "POSITION").map(|all| all.map(|all| all[0]))
        };
        // The first rows of both matrices are 1 0 0.
        assert_eq!(moved("").unwrap(), Some([0.5, 0.0, 0.0]));
        assert_eq!(moved(r#","weights":[2,1]"#).unwrap(), Some([3.0, 0.0, 0.0]));
        assert_eq!(moved(r#","weights":[0,0]"#).unwrap(), None);
        let wrong = moved(r#","weights":["a"]"#).unwrap_err().to_string();
        assert!(wrong.contains("nodes[0].weights[0]"), "{wrong}");
    }

    #[test]
    fn what_all_displacements_decode_is_limited() {
        let zeros = r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0,"weights":[1]}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0},"targets":[{"POSITION":1}]}]}],
            "accessors":[{"componentType":5126,"count":3,"type":"VEC3"},{"componentType":5126,"count":2000000,"type":"VEC3"}]}"#;
        let scene = crate::gltf::read(zeros.as_bytes(), None).unwrap().scene.unwrap();
        let mut reader = scene.morph_reader();
        let results: Vec<bool> =
            (0..4).map(|_| reader.displacements(0, Some(0), "POSITION").is_ok()).collect();
        assert_eq!(results, [true, true, false, false]);
    }

    /// Returns two translation matrices as base64.
    fn bytes() -> String {
        let matrix = |x, y, z| [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, x, y, z, 1.0_f32];
        let floats = [matrix(1.0, 2.0, 3.0), matrix(4.0, 5.0, 6.0)].concat();
        let bytes: Vec<u8> = floats.iter().flat_map(|x| x.to_le_bytes()).collect();
        STANDARD.encode(&bytes)
    }
}
