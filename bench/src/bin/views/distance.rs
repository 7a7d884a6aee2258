//! The distance of a drawn surface from the full mesh, in pixels. It is one measure for all
//! alternatives, whose stated errors have different definitions.
//!
//! # Algorithm
//! Takes vertices of the full mesh that are in the image and face the eye. For each vertex, the
//! distance of the nearest drawn triangle is divided by the distance of the vertex from the eye.
//! Triangles are in a tree of boxes, split at the median center along the longest axis.
//!
//! # References
//! Ericson: *Real-Time Collision Detection*, 2005, section 5.1.5: the closest point of a triangle.
//!
//! # Complexity
//! O(n log n) time for n triangles, 36 bytes per triangle.

use tristrip::Mesh;
use tristrip::random::Random;

use crate::frames::{Frame, Point, cross, dot, sub};

/// The maximum number of points of a frame.
pub(super) const POINTS: usize = 4000;
/// The maximum number of triangles of a leaf.
const LEAF: usize = 4;

/// Vertices of the full mesh with their normals.
pub(super) struct SurfacePoints {
    vertices: Vec<([f32; 3], Point)>,
}

impl SurfacePoints {
    /// Takes all vertices in random order, which spreads the first ones in an image over it.
    pub(super) fn of(mesh: &Mesh) -> Self {
        let positions = mesh.positions();
        let mut vertices: Vec<_> = positions.iter().map(|&position| (position, [0.0; 3])).collect();
        let (triangles, _) = mesh.faces().as_triangles().unwrap_or_default().as_chunks::<3>();
        for triangle in triangles {
            let [a, b, c] = triangle.map(|vertex| positions[vertex as usize].map(f64::from));
            let normal = cross(sub(b, a), sub(c, a));
            for &vertex in triangle {
                let sum = &mut vertices[vertex as usize].1;
                *sum = [0, 1, 2].map(|k| sum[k] + normal[k]);
            }
        }
        let mut random = Random::new(0);
        for end in (1..vertices.len()).rev() {
            vertices.swap(end, random.below(end + 1));
        }
        Self { vertices }
    }

    /// Returns the root mean square and the maximum of the distances in a frame, in pixels; 0 if no
    /// vertex is visible.
    pub(super) fn pixels(&self, frame: &Frame, mesh: &Mesh, triangles: &[[u32; 3]]) -> [f64; 2] {
        let tree = BoxTree::new(mesh.positions(), triangles);
        let is_seen = |&&(position, normal): &&([f32; 3], Point)| {
            frame.sees(position, 0.0) && dot(normal, sub(frame.eye, position.map(f64::from))) > 0.0
        };
        let (mut sum, mut most, mut count) = (0.0, 0.0_f64, 0_usize);
        for &(position, _) in self.vertices.iter().filter(is_seen).take(POINTS) {
            let pixels =
                tree.distance(position.map(f64::from)) * frame.pixels_per_slope / frame.distance(position);
            sum += pixels * pixels;
            most = most.max(pixels);
            count += 1;
        }
        [(sum / count.max(1) as f64).sqrt(), most]
    }
}

/// Triangles in a tree of boxes.
struct BoxTree<'a> {
    positions: &'a [[f32; 3]],
    triangles: Vec<[u32; 3]>,
    nodes: Vec<BoxNode>,
}

/// A box around some triangles.
#[derive(Debug, Clone, Copy)]
struct BoxNode {
    low: [f32; 3],
    high: [f32; 3],
    first: u32,
    count: u32,
    /// The index of the second child. The first child follows its parent. `None` for a leaf.
    second: Option<u32>,
}

impl<'a> BoxTree<'a> {
    fn new(positions: &'a [[f32; 3]], triangles: &[[u32; 3]]) -> Self {
        let mut tree = Self { positions, triangles: triangles.to_vec(), nodes: Vec::new() };
        if !triangles.is_empty() {
            tree.build(0, triangles.len());
        }
        tree
    }

    /// Builds the tree of some triangles. Returns its root.
    fn build(&mut self, first: usize, end: usize) -> u32 {
        let corners = |triangle: &[u32; 3]| triangle.map(|vertex| self.positions[vertex as usize]);
        let center =
            |triangle: &[u32; 3], k: usize| corners(triangle).iter().map(|corner| corner[k]).sum::<f32>();
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for corner in self.triangles[first..end].iter().flat_map(corners) {
            low = [0, 1, 2].map(|k| low[k].min(corner[k]));
            high = [0, 1, 2].map(|k| high[k].max(corner[k]));
        }
        let node = self.nodes.len();
        let count = end - first;
        if count > LEAF {
            let size = [0, 1, 2].map(|k| high[k] - low[k]);
            let axis = (0..3).max_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(0);
            let mut within = self.triangles[first..end].to_vec();
            within.select_nth_unstable_by(count / 2, |a, b| center(a, axis).total_cmp(&center(b, axis)));
            self.triangles[first..end].copy_from_slice(&within);
        }
        self.nodes.push(BoxNode { low, high, first: first as u32, count: count as u32, second: None });
        if count > LEAF {
            self.build(first, first + count / 2);
            self.nodes[node].second = Some(self.build(first + count / 2, end));
        }
        node as u32
    }

    /// Returns the distance to the nearest triangle; infinite if there is none.
    fn distance(&self, point: Point) -> f64 {
        let mut least = f64::INFINITY;
        let mut stack: Vec<(f64, u32)> = Vec::new();
        stack.extend(self.nodes.first().map(|root| (root.square_distance(point), 0)));
        while let Some((square, number)) = stack.pop() {
            if square >= least {
                continue;
            }
            let node = &self.nodes[number as usize];
            let Some(second) = node.second else {
                let first = node.first as usize;
                for triangle in &self.triangles[first..first + node.count as usize] {
                    let corners = triangle.map(|vertex| self.positions[vertex as usize].map(f64::from));
                    least = least.min(square_distance(point, corners));
                }
                continue;
            };
            let mut children =
                [number + 1, second].map(|child| (self.nodes[child as usize].square_distance(point), child));
            // Visit the nearer child first.
            if children[0].0 < children[1].0 {
                children.swap(0, 1);
            }
            stack.extend(children);
        }
        least.sqrt()
    }
}

impl BoxNode {
    fn square_distance(&self, point: Point) -> f64 {
        let outside = [0, 1, 2].map(|k| {
            let (low, high) = (f64::from(self.low[k]), f64::from(self.high[k]));
            (low - point[k]).max(point[k] - high).max(0.0)
        });
        dot(outside, outside)
    }
}

/// Returns the squared distance of a point from a triangle.
fn square_distance(point: Point, [a, b, c]: [Point; 3]) -> f64 {
    let (ab, ac) = (sub(b, a), sub(c, a));
    let normal = cross(ab, ac);
    let area = dot(normal, normal);
    if area > 0.0 {
        // Inside all edges, the nearest point is the projection onto the plane of the triangle.
        let is_inside = |from: Point, edge: Point| dot(cross(edge, sub(point, from)), normal) >= 0.0;
        if is_inside(a, ab) && is_inside(b, sub(c, b)) && is_inside(c, sub(a, c)) {
            let height = dot(sub(point, a), normal);
            return height * height / area;
        }
    }
    let to_edge = |[from, to]: [Point; 2]| {
        let (edge, away) = (sub(to, from), sub(point, from));
        let length = dot(edge, edge);
        let share = if length > 0.0 { (dot(away, edge) / length).clamp(0.0, 1.0) } else { 0.0 };
        let rest = [0, 1, 2].map(|k| away[k] - share * edge[k]);
        dot(rest, rest)
    };
    [[a, b], [b, c], [c, a]].map(to_edge).into_iter().fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use tristrip::Faces;
    use tristrip::lod::Camera;

    use super::*;

    #[test]
    fn distances_of_a_triangle_are_those_of_its_plane_edges_and_corners() {
        let triangle = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        for (point, expected) in [
            ([1.0, 1.0, 3.0], 9.0),
            ([1.0, 1.0, -3.0], 9.0),
            ([2.0, -3.0, 4.0], 25.0),
            ([-3.0, -4.0, 0.0], 25.0),
            ([7.0, 0.0, 4.0], 25.0),
            ([4.0, 4.0, 0.0], 8.0),
        ] {
            assert!((square_distance(point, triangle) - expected).abs() < 1e-12, "{point:?}");
        }
        // A triangle without area still has edges.
        let line = [[0.0; 3], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]];
        assert!((square_distance([5.0, 1.0, 0.0], line) - 5.0).abs() < 1e-12);
    }

    #[test]
    fn the_tree_finds_the_nearest_of_all_triangles() {
        let mut random = Random::new(1);
        let mut point = || [(); 3].map(|()| random.below(1000) as f32 / 100.0);
        let positions: Vec<[f32; 3]> = (0..300).map(|_| point()).collect();
        let triangles: Vec<[u32; 3]> = (0..298).map(|v| [v, v + 1, v + 2]).collect();
        let tree = BoxTree::new(&positions, &triangles);
        for _ in 0..200 {
            let from = point().map(f64::from);
            let of = |triangle: &[u32; 3]| {
                square_distance(from, triangle.map(|v| positions[v as usize].map(f64::from)))
            };
            let least = triangles.iter().map(of).fold(f64::INFINITY, f64::min).sqrt();
            assert!((tree.distance(from) - least).abs() < 1e-12);
        }
        assert!(BoxTree::new(&positions, &[]).distance([0.0; 3]).is_infinite());
    }

    /// A square at distance 10, drawn by one with a corner 0.1 farther away. At 45°, the scale is
    /// half of the 1080 rows.
    #[test]
    fn pixels_are_those_of_the_distance_in_the_image() {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]];
        let at = |[x, y]: [f32; 2], z: f32| [x, y, z];
        let mut positions: Vec<_> = corners.iter().map(|&corner| at(corner, 0.0)).collect();
        positions.push(at(corners[3], -0.1));
        let mesh = Mesh::new(positions, Faces::from_triangles(vec![0, 1, 2, 2, 1, 3]).unwrap()).unwrap();
        let camera = Camera::new([0.0, 0.0, 10.0], [0.0; 3]).unwrap();
        let frame = Frame::new(camera, &mesh, true, 2);
        let points = SurfacePoints::of(&mesh);
        let [rms, most] = points.pixels(&frame, &mesh, &[[0, 1, 2], [2, 1, 3]]);
        assert!(rms < 1e-9 && most < 1e-9);
        let [rms, most] = points.pixels(&frame, &mesh, &[[0, 1, 2], [2, 1, 4]]);
        let expected = 0.1 * 540.0 / (2.0_f64.sqrt() - 1.0) / 102.0_f64.sqrt();
        assert!((most / expected - 1.0).abs() < 0.01, "{most} of {expected}");
        assert!((rms / (most / 2.0) - 1.0).abs() < 1e-9);
    }
}
