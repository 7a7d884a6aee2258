//! One of two surfaces: its triangles, sample points, and a tree for nearest-point searches.

use rstar::{AABB, PointDistance, RTree, RTreeObject};
use tristrip::random::Random;
use tristrip::simplify::nearest_in_triangle;
use tristrip::{Attribute, Error, Faces, Mesh};

type Point = [f64; 3];

/// The number of triangles at which the overlap of boxes is estimated.
const PROBES: usize = 32;

/// A point of a triangle: the triangle, and barycentric coordinates.
pub(super) type On<'a> = (&'a Facet, [f64; 3]);

/// A triangle of a surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Facet {
    vertices: [u32; 3],
    corners: [Point; 3],
}

impl Facet {
    /// Creates a triangle of vertices with these positions.
    pub(crate) fn new(vertices: [u32; 3], corners: [Point; 3]) -> Self {
        Self { vertices, corners }
    }

    pub(crate) fn vertices(&self) -> [u32; 3] {
        self.vertices
    }

    /// Returns the point with these barycentric coordinates.
    pub(crate) fn at(&self, shares: [f64; 3]) -> Point {
        mix(self.corners, shares)
    }

    /// Returns the normal. Its length is twice the area of the triangle.
    pub(crate) fn normal(&self) -> Point {
        let [a, b, c] = self.corners;
        cross(sub(b, a), sub(c, a))
    }

    pub(crate) fn area(&self) -> f64 {
        let normal = self.normal();
        0.5 * dot(normal, normal).sqrt()
    }

    /// Returns the squared distance of a point, and the barycentric coordinates of the nearest
    /// point of the triangle.
    pub(crate) fn nearest(&self, p: Point) -> (f64, [f64; 3]) {
        let shares = nearest_in_triangle(p, self.corners);
        let rest = sub(p, self.at(shares));
        (dot(rest, rest), shares)
    }
}

impl RTreeObject for Facet {
    type Envelope = AABB<Point>;

    fn envelope(&self) -> AABB<Point> {
        AABB::from_points(self.corners.iter())
    }
}

impl PointDistance for Facet {
    fn distance_2(&self, point: &Point) -> f64 {
        self.nearest(*point).0
    }
}

/// The triangles of a surface.
#[derive(Debug, Default)]
pub(crate) struct Side {
    pub(super) facets: Vec<Facet>,
}

impl Side {
    pub(crate) fn of(facets: impl Iterator<Item = Facet>) -> Self {
        Self { facets: facets.collect() }
    }

    pub(crate) fn new(mesh: &Mesh, triangles: &[u32]) -> Result<Self, Error> {
        let mut side = Self::default();
        side.add(mesh, triangles)?;
        Ok(side)
    }

    /// Adds triangles over the vertices of a mesh.
    pub(crate) fn add(&mut self, mesh: &Mesh, triangles: &[u32]) -> Result<(), Error> {
        let faces = Faces::from_triangles(triangles.to_vec())?;
        let mesh = mesh.with_faces(faces)?;
        let facet = |vertices: [u32; 3]| {
            let corners = vertices.map(|v| mesh.positions()[v as usize].map(f64::from));
            Facet::new(vertices, corners)
        };
        self.facets.extend(triangles.chunks_exact(3).map(|t| facet([t[0], t[1], t[2]])));
        Ok(())
    }

    pub(super) fn area(&self) -> f64 {
        self.facets.iter().map(Facet::area).sum()
    }

    /// Returns the diagonal of the bounding box.
    pub(crate) fn diagonal(&self) -> f64 {
        let corners = self.facets.iter().flat_map(|facet| &facet.corners);
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for corner in corners {
            for k in 0..3 {
                low[k] = low[k].min(corner[k]);
                high[k] = high[k].max(corner[k]);
            }
        }
        let sides = sub(high, low).map(|side| side.max(0.0));
        dot(sides, sides).sqrt()
    }

    pub(crate) fn tree(&self) -> RTree<Facet> {
        RTree::bulk_load(self.facets.clone())
    }

    /// Estimates how many boxes of a tree contain a point of this surface, as the mean over a few
    /// triangles.
    pub(crate) fn crowd(&self, tree: &RTree<Facet>) -> f64 {
        let step = (self.facets.len() / PROBES).max(1);
        let boxes = |facet: &Facet| {
            let at = AABB::from_point(facet.at([1.0 / 3.0; 3]));
            tree.locate_in_envelope_intersecting(at).count() as f64
        };
        let (sum, count) =
            self.facets.iter().step_by(step).fold((0.0, 0), |(sum, n), f| (sum + boxes(f), n + 1));
        sum / f64::from(count.max(1))
    }

    /// Returns the triangles.
    pub(crate) fn facets(&self) -> &[Facet] {
        &self.facets
    }

    /// Visits about `points` random points, distributed in proportion to area.
    pub(crate) fn sample(&self, points: f64, random: &mut Random, mut visit: impl FnMut(&Facet, [f64; 3])) {
        let total = self.area();
        if total > 0.0 {
            self.visit(|_, area| area / total * points, random, |_, facet, shares| visit(facet, shares));
        }
    }

    /// Visits random points. `expected` returns the number of points of a triangle from its index
    /// and area; fractions accumulate.
    pub(crate) fn visit(
        &self,
        expected: impl Fn(usize, f64) -> f64,
        random: &mut Random,
        mut visit: impl FnMut(usize, &Facet, [f64; 3]),
    ) {
        let mut uniform = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        let mut due = 0.0;
        for (number, facet) in self.facets.iter().enumerate() {
            due += expected(number, facet.area());
            while due >= 1.0 {
                due -= 1.0;
                let (u, v) = (uniform(), uniform());
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                visit(number, facet, [1.0 - u - v, u, v]);
            }
        }
    }
}

/// The attributes that are compared.
pub(super) struct Attributes<'a> {
    normals: Option<&'a Attribute>,
    uv: Option<&'a Attribute>,
}

impl<'a> Attributes<'a> {
    pub(crate) fn new(mesh: &'a Mesh) -> Self {
        let named = |name: &str, components: u8| {
            mesh.attributes().iter().find(|a| a.name == name && a.components == components)
        };
        Self { normals: named("NORMAL", 3), uv: named("TEXCOORD_0", 2) }
    }

    /// Returns the angle between the normals at two points, in radians.
    pub(super) fn angle(&self, here: On<'_>, there: On<'_>) -> f64 {
        let normal = |(facet, shares): On<'_>| {
            let smooth = self.normals.map(|normals| mix(facet.vertices.map(|v| value(normals, v)), shares));
            smooth.filter(|&n| dot(n, n) > 0.0).unwrap_or_else(|| facet.normal())
        };
        let (a, b) = (normal(here), normal(there));
        let across = cross(a, b);
        libm::atan2(dot(across, across).sqrt(), dot(a, b))
    }

    /// Returns the difference between the texture coordinates at two points; `None` if there are
    /// none.
    pub(super) fn uv_difference(&self, here: On<'_>, there: On<'_>) -> Option<[f64; 2]> {
        let uv = self.uv?;
        let of = |(facet, shares): On<'_>| mix(facet.vertices.map(|v| value(uv, v)), shares);
        let [u, v, _] = sub(of(here), of(there));
        Some([u, v])
    }
}

/// Returns up to three components of an attribute of a vertex. Non-finite values count as zero.
fn value(attribute: &Attribute, vertex: u32) -> Point {
    let components = usize::from(attribute.components);
    let component = |k: usize| {
        let value = (k < components).then(|| attribute.float(vertex as usize * components + k)).flatten();
        value.filter(|value| value.is_finite()).map_or(0.0, f64::from)
    };
    [0, 1, 2].map(component)
}

fn mix(corners: [Point; 3], shares: [f64; 3]) -> Point {
    [0, 1, 2].map(|k| shares[0] * corners[0][k] + shares[1] * corners[1][k] + shares[2] * corners[2][k])
}

pub(crate) fn sub(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tree finds the same distance as a search of all triangles, and no sampled point of a
    /// triangle is nearer than the returned one.
    #[test]
    fn the_nearest_triangle_is_the_nearest_of_all() {
        let mut random = Random::new(3);
        let mut number = || (random.below(2000) as f32 - 1000.0) / 1000.0;
        let positions: Vec<[f32; 3]> = (0..90).map(|_| [number(), number(), number()]).collect();
        let mesh = Mesh::new(positions, Faces::default()).unwrap();
        // Includes triangles without area.
        let triangles: Vec<u32> = (0..90).chain([0, 0, 1, 2, 2, 2]).collect();
        let side = Side::new(&mesh, &triangles).unwrap();
        let tree = side.tree();
        for _ in 0..200 {
            let at = [number(), number(), number()].map(f64::from);
            let least = side.facets.iter().map(|facet| facet.nearest(at).0).fold(f64::INFINITY, f64::min);
            let found = tree.nearest_neighbor(at).unwrap().nearest(at).0;
            assert!((found - least).abs() < 1e-12, "{found} {least}");
            for facet in &side.facets {
                let (square, shares) = facet.nearest(at);
                assert!(
                    (shares.iter().sum::<f64>() - 1.0).abs() < 1e-9 && shares.iter().all(|&s| s >= -1e-9)
                );
                for i in 0..=20 {
                    for j in 0..=20 - i {
                        let [u, v] = [i, j].map(|k| f64::from(k) / 20.0);
                        let rest = sub(at, facet.at([1.0 - u - v, u, v]));
                        assert!(square <= dot(rest, rest) + 1e-9);
                    }
                }
            }
        }
    }

    #[test]
    fn points_are_spread_by_area() {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 3.0, 0.0], [3.0, 0.0, 0.0]];
        let mesh = Mesh::new(positions, Faces::default()).unwrap();
        let side = Side::new(&mesh, &[0, 1, 2, 0, 4, 3]).unwrap();
        let mut counts = [0; 2];
        side.sample(1000.0, &mut Random::new(1), |facet, _| counts[usize::from(facet.area() > 1.0)] += 1);
        assert!((99..=101).contains(&counts[0]) && (899..=901).contains(&counts[1]), "{counts:?}");
    }
}
