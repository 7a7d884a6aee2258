//! The bounds of a collapse, which a view evaluates: error, sphere and cone of normals.
//!
//! - The *error*, or switch value, is the largest error of the collapse and of its dependencies, in
//!   mesh units. A view that allows a collapse therefore also allows its dependencies at the same
//!   distance.
//! - The *sphere* around the removed vertex contains the kept vertex and all vertices that the
//!   removed vertex replaces.
//! - The *cone* contains the normals of all triangles of the full mesh at these vertices.
//!
//! # Complexity
//! O(n) time. 24 bytes per vertex, including its position.

use super::cone::{Cone, WideCone};
use super::dependencies::Dependencies;
use super::vertex_tree::{NodeNumbers, VertexTree};
use crate::collapse::CollapseSequence;
use crate::error::Error;
use crate::mesh::{Positions, check_positions, triangles_of};
use crate::text::counted;
use crate::vector::{Point, dot, normal_of, sub};

/// The bounds of all collapses, indexed by node.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TreeBounds {
    pub(super) nodes: Vec<NodeBounds>,
    /// The center of the bounding box.
    pub(super) center: Point,
    /// The distance from the center to the corners of the bounding box.
    pub(super) radius: f64,
}

/// The bounds of the collapse of a node, in mesh units.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct NodeBounds {
    pub(super) position: [f32; 3],
    pub(super) radius: f32,
    pub(super) error: f32,
    pub(super) cone: Cone,
}

impl TreeBounds {
    /// Computes the bounds of all collapses of a tree.
    ///
    /// # Errors
    /// A position is missing or not finite.
    pub(super) fn new<P: Positions + ?Sized>(
        positions: &P,
        sequence: &CollapseSequence,
        (tree, numbers): (&VertexTree, &NodeNumbers),
        dependencies: &Dependencies,
    ) -> Result<Self, Error> {
        let triangles = sequence.triangles();
        if positions.vertex_count() < sequence.vertex_count() {
            let found =
                format!("{} for {}", positions.vertex_count(), counted(sequence.vertex_count(), "vertex"));
            return Err(Error::Parameter { name: "positions", found, expected: "one per vertex" });
        }
        check_positions(triangles, positions)?;
        let position = |node: u32| positions.position(tree.vertex(node) as usize).unwrap_or_default();
        let bounds = |node| NodeBounds { position: position(node), ..NodeBounds::default() };
        let mut nodes: Vec<NodeBounds> = (0..tree.len() as u32).map(bounds).collect();
        let mut cones = cones(triangles, numbers, &nodes);
        for collapse in sequence.iter() {
            let Some(collapse_id) = collapse.renames.first().map(|first| numbers.of(first.removed)) else {
                continue;
            };
            let needed = dependencies.needed(collapse_id).map(|needed| nodes[needed as usize].error);
            let error = needed.fold(collapse.error, f32::max);
            // Vertices that collapse together have the same sphere and cone.
            let members = || collapse.renames.iter().map(|r| [r.removed, r.kept].map(|v| numbers.of(v)));
            let (mut radius, mut cone) = (0.0_f32, WideCone::default());
            let center = nodes[collapse_id as usize].position;
            for [removed, kept] in members() {
                let [own, other] = [removed, kept].map(|node| &nodes[node as usize]);
                radius = radius.max(reach(center, own)).max(reach_of(center, other.position));
                cone = cone.with(&cones[removed as usize]);
            }
            for [removed, kept] in members() {
                cones[kept as usize] = cones[kept as usize].with(&cones[removed as usize]);
                let node = &mut nodes[removed as usize];
                (node.radius, node.error, node.cone) = (radius, error, cone.rounded());
                let reached = reach(nodes[kept as usize].position, &nodes[removed as usize]);
                let kept = &mut nodes[kept as usize];
                kept.radius = kept.radius.max(reached);
            }
        }
        let (center, radius) = sphere_of(nodes.iter().map(|node| node.position));
        Ok(Self { nodes, center, radius })
    }

    pub(super) fn memory(&self) -> usize {
        size_of_val(&self.nodes[..])
    }
}

/// Returns a cone of the triangle normals at each node.
fn cones(triangles: &[u32], numbers: &NodeNumbers, nodes: &[NodeBounds]) -> Vec<WideCone> {
    let mut cones = vec![WideCone::default(); nodes.len()];
    for triangle in triangles_of(triangles) {
        let corners = triangle.map(|v| numbers.of(v));
        let normal = WideCone::of(normal_of(corners.map(|node| point(nodes[node as usize].position))));
        for node in corners {
            cones[node as usize] = cones[node as usize].with(&normal);
        }
    }
    cones
}

/// Returns the radius of a sphere around `from` that contains the sphere of a node.
fn reach(from: [f32; 3], node: &NodeBounds) -> f32 {
    rounded_up(distance(from, node.position) + f64::from(node.radius))
}

fn reach_of(from: [f32; 3], to: [f32; 3]) -> f32 {
    rounded_up(distance(from, to))
}

fn distance(a: [f32; 3], b: [f32; 3]) -> f64 {
    let edge = sub(point(b), point(a));
    dot(edge, edge).sqrt()
}

fn point(position: [f32; 3]) -> Point {
    position.map(f64::from)
}

/// Rounds up to an `f32`, at most `f32::MAX`.
fn rounded_up(x: f64) -> f32 {
    (x as f32).next_up().min(f32::MAX)
}

/// Returns the center of the bounding box, and the distance from there to its corners.
fn sphere_of(positions: impl Iterator<Item = [f32; 3]>) -> (Point, f64) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for position in positions.map(point) {
        low = [0, 1, 2].map(|k| low[k].min(position[k]));
        high = [0, 1, 2].map(|k| high[k].max(position[k]));
    }
    if low[0] > high[0] {
        return ([0.0; 3], 0.0);
    }
    let half = sub(high, low).map(|x| x / 2.0);
    ([0, 1, 2].map(|k| low[k] + half[k]), dot(half, half).sqrt())
}
