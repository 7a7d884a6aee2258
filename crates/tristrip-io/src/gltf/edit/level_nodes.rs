//! Nodes with levels of detail: `MSFT_lod` lists the nodes that replace a node at lower levels, and
//! `MSFT_screencoverage` lists the screen coverage of each.
//!
//! ```text
//! a node that only places its mesh               any other node, such as an animated one
//!   wall: mesh 0, translation                      wheel: rotation, animated, children …
//!     MSFT_lod ids ─▶ wall: mesh 3, translation      └ wheel: mesh 1     new child, no transform
//!              └────▶ wall: mesh 6, translation           MSFT_lod ids ─▶ wheel: mesh 4 …
//! ```
//! # Where the levels are attached
//! A level replaces the node that lists it. It has the same parent and its own transform, children
//! and animations, because the extension has no transform of its own. If a node contains only a
//! mesh and a transform, its levels have copies of the transform. Any other node keeps its
//! transform, animations, children, camera and extensions, which would otherwise have to be copied
//! per level. Its mesh moves to a new child without a transform, together with everything that
//! belongs to the mesh: skin, morph weights, and extensions that instance it. An animation of the
//! node then moves all its levels, a viewer that ignores the extension shows the finest level, and
//! no node changes its index. The nodes of lower levels are not listed in any scene.
//!
//! Morph weights are on the node with the mesh. An animation of the weights gets a channel per
//! level with the same sampler. Nodes whose weights are animated by `KHR_animation_pointer` get no
//! levels.
//!
//! # References
//! S. Bhatia, G. Hsu et al.: *`MSFT_lod`*, 2018.

use std::collections::{BTreeMap, HashMap, HashSet};

use serde_json::json;

use crate::error::Error;
use crate::gltf::document::json::{JsonContent, Members, Value};
use crate::gltf::document::spec::{LEVELS_OF_DETAIL, SCREEN_COVERAGE};
use crate::gltf::document::{array, index, items, list_mut, uses};

/// Members of a node that belong to its mesh.
const OF_MESH: [&str; 3] = ["mesh", "skin", "weights"];

/// Members of a node that form its transform.
const TRANSFORM: [&str; 4] = ["matrix", "translation", "rotation", "scale"];

/// Node extensions that belong to the mesh.
const MESH_EXTENSIONS: [&str; 2] = ["EXT_mesh_gpu_instancing", "EXT_instance_features"];

const ANIMATION_POINTER: &str = "KHR_animation_pointer";

/// The lower levels of a mesh.
pub(in crate::gltf) struct MeshLevels {
    /// The mesh of each lower level, finest first.
    pub(in crate::gltf) lower: Vec<usize>,
    /// The minimum screen coverage at which each level is drawn, for all levels, finest first.
    pub(in crate::gltf) coverage: Vec<f64>,
}

/// Adds nodes for the lower levels of meshes. Returns the number of nodes without levels although
/// their mesh has some.
///
/// # Errors
/// The document already has levels of detail.
pub(in crate::gltf) fn add(root: &mut Members, levels: &BTreeMap<usize, MeshLevels>) -> Result<usize, Error> {
    let old = array(root, "nodes")?;
    if uses(root, LEVELS_OF_DETAIL) || old.iter().any(has_levels) {
        return Err(Error::Unsupported(format!(
            "the scene already has levels of detail ({LEVELS_OF_DETAIL}); specify a directory to write one file per level"
        )));
    }
    let motion = Motion::of(root)?;
    let joints = joints(root)?;
    let mut changed: Vec<(usize, Value)> = Vec::new();
    let mut new: Vec<Value> = Vec::new();
    let mut animated: HashMap<usize, Vec<usize>> = HashMap::new();
    let mut without = 0;
    for (number, node) in old.iter().enumerate() {
        let Some(levels) = node.get("mesh").and_then(index).and_then(|mesh| levels.get(&mesh)) else {
            continue;
        };
        if motion.weights_by_pointer.contains(&number) {
            without += 1;
            continue;
        }
        // 1. The node with the mesh: the node itself or a new child.
        let mut node = node.clone();
        let is_plain = !motion.of_nodes.contains(&number) && !joints.contains(&number) && only_places(&node);
        let mut drawn = if is_plain { node.clone() } else { without_mesh(&mut node) };
        let drawn_number = if is_plain { number } else { old.len() + new.len() };
        if !is_plain {
            add_child(&mut node, drawn_number);
            new.push(JsonContent::Null.into());
        }
        // 2. The nodes of lower levels.
        let first = old.len() + new.len();
        new.extend((1..).zip(&levels.lower).map(|(level, &mesh)| node_at_level(&drawn, level, mesh)));
        let lower: Vec<usize> = (first..first + levels.lower.len()).collect();
        if motion.weights_of_nodes.contains(&number) {
            animated.insert(number, [&[drawn_number][..], &lower].concat());
        }
        name_levels(&mut drawn, &lower, &levels.coverage);
        if is_plain {
            node = drawn;
        } else {
            new[drawn_number - old.len()] = drawn;
        }
        changed.push((number, node));
    }
    if changed.is_empty() {
        return Ok(without);
    }
    let nodes = list_mut(root, "nodes")?;
    changed.into_iter().for_each(|(number, node)| nodes[number] = node);
    nodes.extend(new);
    animate_levels(root, &animated)?;
    list_mut(root, "extensionsUsed")?.push(LEVELS_OF_DETAIL.into());
    Ok(without)
}

/// Appends a level number to the name of an object, if it has a name.
pub(in crate::gltf) fn name_level(members: &mut Members, level: usize) {
    let name = members.get("name").and_then(Value::as_str).map(|name| format!("{name}_lod{level}"));
    name.into_iter().for_each(|name| members.insert("name", name.as_str()));
}

/// Checks whether a node lists lower levels, even if the document does not declare the extension.
fn has_levels(node: &Value) -> bool {
    node.get("extensions").is_some_and(|extensions| extensions.get(LEVELS_OF_DETAIL).is_some())
}

/// Checks whether a node only places a mesh.
fn only_places(node: &Value) -> bool {
    let is_of_mesh = |name: &str| MESH_EXTENSIONS.contains(&name);
    items(node, "children").is_empty()
        && node.get("camera").is_none()
        && node.get("extras").is_none_or(|extras| extras.as_object().is_some())
        && node.get("extensions").is_none_or(|extensions| {
            extensions.as_object().is_some_and(|members| members.iter().all(|(name, _)| is_of_mesh(name)))
        })
}

/// Moves the mesh of a node, and everything that belongs to it, to a new node.
fn without_mesh(node: &mut Value) -> Value {
    let mut moved = Members::default();
    let Some(members) = node.as_object_mut() else { return JsonContent::Object(moved).into() };
    if let Some(name) = members.get("name").cloned() {
        moved.insert("name", name);
        name_level(&mut moved, 0);
    }
    OF_MESH.iter().for_each(|name| moved.take_from(members, name));
    if let Some(extensions) = members.get_mut("extensions").and_then(Value::as_object_mut) {
        let mut of_mesh = Members::default();
        MESH_EXTENSIONS.iter().for_each(|name| of_mesh.take_from(extensions, name));
        let is_empty = extensions.is_empty();
        if !of_mesh.is_empty() {
            moved.insert("extensions", JsonContent::Object(of_mesh));
        }
        if is_empty {
            members.remove("extensions");
        }
    }
    JsonContent::Object(moved).into()
}

/// Adds a child to a node.
fn add_child(node: &mut Value, child: usize) {
    let Some(members) = node.as_object_mut() else { return };
    if !members.contains_key("children") {
        members.insert("children", JsonContent::Array(Vec::new()));
    }
    let children = members.get_mut("children").and_then(Value::as_array_mut);
    children.into_iter().for_each(|children| children.push(child.into()));
}

/// Returns the node of a lower level, with the same transform.
fn node_at_level(drawn: &Value, level: usize, mesh: usize) -> Value {
    let mut copy = Members::default();
    let names = ["name"].iter().chain(&OF_MESH).chain(&TRANSFORM).chain(&["extensions"]);
    for name in names {
        if let Some(value) = drawn.get(name) {
            copy.insert(name, value.clone());
        }
    }
    copy.insert("mesh", mesh);
    // If the mesh was moved to a child, the name of the finest level ends in `_lod0`.
    let name = copy
        .get("name")
        .and_then(Value::as_str)
        .map(|name| name.strip_suffix("_lod0").unwrap_or(name).to_owned());
    if let Some(name) = name {
        copy.insert("name", name.as_str());
        name_level(&mut copy, level);
    }
    JsonContent::Object(copy).into()
}

/// Sets the lower levels of a node and the screen coverages of all levels.
fn name_levels(node: &mut Value, lower: &[usize], coverage: &[f64]) {
    let Some(members) = node.as_object_mut() else { return };
    set_inside(members, "extensions", LEVELS_OF_DETAIL, json!({ "ids": lower }));
    set_inside(members, "extras", SCREEN_COVERAGE, json!(coverage));
}

/// Sets a member of a nested object, which is created if it is missing.
fn set_inside(members: &mut Members, object: &str, name: &str, value: impl Into<Value>) {
    if !members.contains_key(object) {
        members.insert(object, JsonContent::Object(Members::default()));
    }
    if let Some(inner) = members.get_mut(object).and_then(Value::as_object_mut) {
        inner.insert(name, value);
    }
}

/// Copies the animation channels of morph weights to the nodes that draw the levels of each node.
fn animate_levels(root: &mut Members, levels: &HashMap<usize, Vec<usize>>) -> Result<(), Error> {
    if levels.is_empty() {
        return Ok(());
    }
    for animation in list_mut(root, "animations")? {
        let nodes_of = |channel: &Value| weights_target(channel).and_then(|node| levels.get(&node));
        if !items(animation, "channels").iter().any(|channel| nodes_of(channel).is_some()) {
            continue;
        }
        let channels = animation.as_object_mut().and_then(|a| a.get_mut("channels")?.as_array_mut());
        let Some(channels) = channels else { continue };
        for channel in std::mem::take(channels) {
            let nodes = nodes_of(&channel).cloned();
            for &node in nodes.iter().flatten() {
                let mut copy = channel.clone();
                let target = copy.as_object_mut().and_then(|copy| copy.get_mut("target")?.as_object_mut());
                target.into_iter().for_each(|target| target.insert("node", node));
                channels.push(copy);
            }
            if nodes.is_none() {
                channels.push(channel);
            }
        }
    }
    Ok(())
}

/// Returns the node whose morph weights a channel animates.
fn weights_target(channel: &Value) -> Option<usize> {
    let target = channel.get("target")?;
    target
        .get("node")
        .and_then(index)
        .filter(|_| target.get("path").and_then(Value::as_str) == Some("weights"))
}

/// The nodes that animations change.
#[derive(Default)]
struct Motion {
    /// Nodes with an animation of anything other than morph weights.
    of_nodes: HashSet<usize>,
    /// Nodes with animated morph weights.
    weights_of_nodes: HashSet<usize>,
    /// Nodes whose morph weights an extension animates.
    weights_by_pointer: HashSet<usize>,
}

impl Motion {
    fn of(root: &Members) -> Result<Self, Error> {
        let mut found = Self::default();
        let channels = array(root, "animations")?.iter().flat_map(|animation| items(animation, "channels"));
        for channel in channels {
            match weights_target(channel) {
                Some(node) => drop(found.weights_of_nodes.insert(node)),
                None => found.of_nodes.extend(channel.get("target").and_then(|t| index(t.get("node")?))),
            }
            let pointer = channel.get("target").and_then(|target| {
                target.get("extensions")?.get(ANIMATION_POINTER)?.get("pointer")?.as_str()
            });
            let mut words = pointer.and_then(|p| p.strip_prefix("/nodes/")).unwrap_or_default().split('/');
            let Some(node) = words.next().and_then(|number| number.parse().ok()) else { continue };
            if words.next() == Some("weights") {
                found.weights_by_pointer.insert(node);
            } else {
                found.of_nodes.insert(node);
            }
        }
        Ok(found)
    }
}

/// Returns the nodes that are joints of skins or roots of their skeletons.
fn joints(root: &Members) -> Result<HashSet<usize>, Error> {
    let skins = array(root, "skins")?.iter();
    Ok(skins
        .flat_map(|skin| items(skin, "joints").iter().chain(skin.get("skeleton")))
        .filter_map(index)
        .collect())
}
