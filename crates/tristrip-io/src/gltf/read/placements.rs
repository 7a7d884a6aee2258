//! The instances of meshes in a scene: the transforms of nodes, and their products.
//!
//! Animations are not applied. As the specification requires, the transform of a node with a skin
//! is ignored; `pose.rs` computes the joint matrices that replace it.
//!
//! # Complexity
//! Linear in nodes and parts: a node with a mesh adds one [`Placement`], whatever the number of
//! primitives.

use std::ops::Range;

use crate::error::Error;
use crate::gltf::document::json::Members;
use crate::gltf::document::scene::Scene;
use crate::gltf::document::{Located, array};

/// An instance of a mesh in the scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    /// The range of part indices; not empty.
    pub parts: Range<usize>,
    /// The rows of the affine transform from the parts to the scene: three columns of the linear
    /// map, then the translation.
    pub transform: [[f64; 4]; 3],
    /// The index of the node; `None` if no node of the scene has a mesh.
    pub node: Option<usize>,
}

impl Scene {
    /// Returns the placements of all meshes in the default scene, in the order of its nodes. If the
    /// scene has no meshes, the result is one placement of all parts.
    ///
    /// # Errors
    /// The nodes used by the scene are not valid glTF 2.0.
    ///
    /// ```
    /// let json = br#"{"asset":{"version":"2.0"},
    ///     "nodes":[{"mesh":0,"translation":[1,2,3]},{"mesh":0}],
    ///     "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
    ///     "accessors":[{"componentType":5126,"count":3,"type":"VEC3"}]}"#;
    /// let scene = tristrip_io::gltf::read(json.to_vec(), None)?.scene.unwrap_or_default();
    /// let places = scene.placements()?;
    /// assert_eq!((places.len(), &places[0].parts), (2, &(0..1)));
    /// assert_eq!(places[0].transform[2], [0.0, 0.0, 1.0, 3.0]);
    /// # Ok::<(), tristrip_io::Error>(())
    /// ```
    pub fn placements(&self) -> Result<Vec<Placement>, Error> {
        let root = &self.document.root;
        let nodes: Vec<Located<'_>> = Located::entries(root, "nodes")?.collect();
        let parts_of = self.parts_of_meshes()?;
        // Nodes to visit, starting at the roots of the scene.
        let mut open: Vec<(usize, Transform)> = roots(root, nodes.len())?;
        open.reverse();
        let mut seen = vec![false; nodes.len()];
        let mut placements = Vec::new();
        while let Some((number, above)) = open.pop() {
            let node = &nodes[number];
            if std::mem::replace(&mut seen[number], true) {
                return Err(Error::format(node.at.clone(), "a node with two parents", "a tree"));
            }
            let transform = above.of(&of_node(node)?);
            if let Some(mesh) = node.field("mesh") {
                let count = parts_of.len();
                let parts = parts_of.get(mesh.size()?);
                let parts =
                    parts.ok_or_else(|| mesh.wrong(format!("less than {count}, the number of meshes")))?;
                let skinned = node.field("skin").is_some();
                let shown = if skinned { Transform::IDENTITY } else { transform };
                if !shown.is_finite() {
                    let found = "a transform that overflows";
                    return Err(Error::format(node.at.clone(), found, "a finite transform"));
                }
                if !parts.is_empty() {
                    let (parts, transform) = (parts.clone(), shown.rows());
                    placements.push(Placement { parts, transform, node: Some(number) });
                }
            }
            if let Some(children) = node.field("children") {
                let children = children.items()?.map(|child| child.size()).collect::<Result<Vec<_>, _>>()?;
                open.extend(children.into_iter().rev().map(|child| (child, transform)));
            }
        }
        // A document without nodes that have meshes is a library of meshes.
        if placements.is_empty() && !self.primitives.is_empty() {
            let parts = 0..self.primitives.len();
            placements.push(Placement { parts, transform: Transform::IDENTITY.rows(), node: None });
        }
        Ok(placements)
    }

    /// Returns the parts of each mesh. Parts are in the order of the meshes.
    fn parts_of_meshes(&self) -> Result<Vec<Range<usize>>, Error> {
        let mut parts_of = vec![0..0; array(&self.document.root, "meshes")?.len()];
        for (part, source) in self.primitives.iter().enumerate() {
            if let Some(parts) = parts_of.get_mut(source.mesh) {
                let first = if parts.start == parts.end { part } else { parts.start };
                *parts = first..part + 1;
            }
        }
        Ok(parts_of)
    }
}

/// Returns the roots of the default scene. Without scenes, these are the nodes without a parent.
fn roots(root: &Members, node_count: usize) -> Result<Vec<(usize, Transform)>, Error> {
    let scenes: Vec<Located<'_>> = Located::entries(root, "scenes")?.collect();
    let shown = match Located::root(root, "scene") {
        Ok(shown) => Some(shown.target(root, "scenes")?),
        Err(_) => scenes.into_iter().next(),
    };
    let mut numbers = Vec::new();
    if let Some(scene) = shown {
        let listed = scene.field("nodes").map(|nodes| nodes.items()).transpose()?;
        for node in listed.into_iter().flatten() {
            match node.size()? {
                number if number < node_count => numbers.push(number),
                _ => return Err(node.wrong(format!("less than {node_count}, the number of nodes"))),
            }
        }
    } else {
        let mut is_child = vec![false; node_count];
        for node in Located::entries(root, "nodes")? {
            let children = node.field("children").map(|children| children.items()).transpose()?;
            for child in children.into_iter().flatten() {
                if let Some(is_child) = is_child.get_mut(child.size()?) {
                    *is_child = true;
                }
            }
        }
        numbers.extend((0..node_count).filter(|&node| !is_child[node]));
    }
    Ok(numbers.into_iter().map(|node| (node, Transform::IDENTITY)).collect())
}

/// An affine transform: the rows of a linear map, each with its translation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::gltf) struct Transform([[f64; 4]; 3]);

impl Transform {
    pub(in crate::gltf) const IDENTITY: Self =
        Self([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);

    /// Returns the transform of a column-major matrix whose last row is 0 0 0 1.
    pub(in crate::gltf) fn of_columns(columns: [f64; 16]) -> Self {
        Self([0, 1, 2].map(|row| [0, 1, 2, 3].map(|column| columns[4 * column + row])))
    }

    /// Returns the transform that applies `inner` first.
    pub(in crate::gltf) fn of(&self, inner: &Self) -> Self {
        Self(self.0.map(|row| {
            std::array::from_fn(|column| {
                let linear: f64 = (0..3).map(|k| row[k] * inner.0[k][column]).sum();
                if column == 3 { linear + row[3] } else { linear }
            })
        }))
    }

    /// Returns whether all numbers are finite. Products of finite transforms can overflow.
    pub(in crate::gltf) fn is_finite(&self) -> bool {
        self.0.iter().flatten().all(|x| x.is_finite())
    }

    pub(in crate::gltf) fn rows(self) -> [[f64; 4]; 3] {
        self.0
    }
}

/// Returns the transform of a node.
pub(in crate::gltf) fn of_node(node: &Located<'_>) -> Result<Transform, Error> {
    if let Some(matrix) = node.field("matrix") {
        return Ok(Transform::of_columns(matrix.numbers()?));
    }
    let [tx, ty, tz] = node.field("translation").map_or(Ok([0.0; 3]), |t| t.numbers())?;
    let [x, y, z, w] = node.field("rotation").map_or(Ok([0.0, 0.0, 0.0, 1.0]), |r| r.numbers())?;
    let [sx, sy, sz] = node.field("scale").map_or(Ok([1.0; 3]), |s| s.numbers())?;
    Ok(Transform([
        [sx * (1.0 - 2.0 * (y * y + z * z)), sy * (2.0 * (x * y - z * w)), sz * (2.0 * (x * z + y * w)), tx],
        [sx * (2.0 * (x * y + z * w)), sy * (1.0 - 2.0 * (x * x + z * z)), sz * (2.0 * (y * z - x * w)), ty],
        [sx * (2.0 * (x * z - y * w)), sy * (2.0 * (y * z + x * w)), sz * (1.0 - 2.0 * (x * x + y * y)), tz],
    ]))
}
