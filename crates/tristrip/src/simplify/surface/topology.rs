//! Triangles over points, and the triangles around each point, under half-edge collapses.
//!
//! A *point* is a position: vertices at the same position are one point, so attribute seams do not
//! interrupt the connectivity of a mesh. At open borders, nearly equal positions can be one point
//! too (module `near_points`). If points have several vertices, the vertex of each corner is stored
//! separately.
//!
//! ```text
//!        u ───── w
//!       ╱ ╲     ╱ ╲
//!      ╱   ╲   ╱   ╲
//!     ╱     ╲ ╱     ╲
//!    ·────── b ──────·
//! ```
//! The triangle (b, u, w) has a corner of the point b. The ring of b contains its corners, in any
//! order. Around an inner point, every neighbour is the u of one corner and the w of another.
//! Around a border point, each of the two neighbours along the border is only a u or only a w.
//!
//! A ring is a range of one array: pricing reads the whole ring of a point several times per
//! collapse, and a range is read sequentially. Levels of detail have the opposite access pattern:
//! their collapses and splits read each ring once, and a split has to restore the ring in constant
//! time. The linked rings of `lod::level::level_mesh` do that. Here, a removed corner is replaced
//! by the last one, and the order of a ring determines the order in which normals are added. The
//! two modules therefore cannot share one structure without losing speed or changing results.
//!
//! # Complexity
//! 12 bytes per triangle, 12 more if there are seams, and about 30 for the rings; 18 bytes per
//! point, and about 60 per vertex on a seam.

mod corner;
mod fans;
mod near_points;
mod open_edges;
mod points;
mod rings;

use std::collections::HashMap;

use super::curve::along_curve;
use crate::collapse::Rename;
use crate::mesh::{PositionIds, Positions, triangles_of};
pub(crate) use corner::CornerId;
use corner::corners;
use fans::FanClassifier;
pub(crate) use fans::PointKind;
use points::{by_first_use, equal_vertices, lowest_vertices, picked};
use rings::CornerRings;

/// The maximum number of triangles of a mesh. Rings that grow move to the end of their array; about
/// ten corners per triangle do not fill it.
pub(crate) const MAX_TRIANGLES: usize = 1 << 27;

/// Longer rings are not searched if there is an alternative.
pub(crate) const LONG_RING: usize = 64;

/// Triangles that can be removed, and whose corners can move to other points.
#[derive(Debug)]
pub(crate) struct Topology {
    /// The points of each triangle. A removed triangle keeps its last points.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The index of each triangle in the mesh, if they are in another order.
    triangle_ids: Option<Vec<u32>>,
    /// The vertex at each corner; empty if each point has one vertex.
    wedges: Vec<u32>,
    /// For each vertex of a point with several vertices, the first vertex of the point with the
    /// same attributes, bit for bit.
    equal_vertices: HashMap<u32, u32>,
    /// The lowest vertex of each point.
    vertex_of: Vec<u32>,
    /// Whether each point has several vertices; empty if none has.
    on_seam: Vec<bool>,
    kinds: Vec<PointKind>,
    /// Reclassifies points after a collapse, if there are irregular ones or collapses may break the
    /// surface.
    classifier: Option<FanClassifier>,
    rings: CornerRings,
    /// The first vertex of each mesh, if there are several.
    meshes: Vec<u32>,
    /// The number of remaining triangles of each mesh, indexed by [`Topology::mesh_of`].
    triangles_left: Vec<u32>,
}

impl Topology {
    /// Connects triangles of vertices at points of equal position, and at open borders within
    /// `weld_distance`; 0 for none. If collapses may break the surface, any point may change its
    /// kind.
    pub(crate) fn new<P: Positions + ?Sized>(
        positions: &P,
        attribute_bits: impl Fn(u32) -> Vec<u8>,
        vertices: &[u32],
        may_break: bool,
        weld_distance: f32,
    ) -> Self {
        let points = PositionIds::default().numbers(positions, vertices);
        let apart = Self::connect(positions, &attribute_bits, vertices, &points, may_break);
        match apart.near_points(positions, weld_distance) {
            Some(joined) => {
                let points = by_first_use(apart.points_in_mesh_order(|p| joined[p as usize]));
                Self::connect(positions, &attribute_bits, vertices, &points, may_break)
            }
            None => apart,
        }
    }

    /// Returns the points of all corners, mapped by `becomes`, in the order of the triangles in the
    /// mesh.
    fn points_in_mesh_order(&self, becomes: impl Fn(u32) -> u32) -> Vec<u32> {
        let mut points = vec![0; 3 * self.triangles.len()];
        for (i, triangle) in self.triangles.iter().enumerate() {
            let t = self.triangle_ids.as_ref().map_or(i, |ids| ids[i] as usize);
            points[3 * t..3 * t + 3].copy_from_slice(&triangle.map(&becomes));
        }
        points
    }

    /// Connects triangles of vertices at points, numbered in the order of their first use.
    fn connect<P: Positions + ?Sized>(
        positions: &P,
        attribute_bits: impl Fn(u32) -> Vec<u8>,
        vertices: &[u32],
        points: &[u32],
        may_break: bool,
    ) -> Self {
        let triangle_ids = along_curve(positions, vertices, points);
        let sorted =
            triangle_ids.as_ref().map(|ids| [picked(vertices, ids), by_first_use(picked(points, ids))]);
        let (vertices, points) = match &sorted {
            Some([vertices, points]) => (&vertices[..], &points[..]),
            None => (vertices, points),
        };
        let vertex_of = lowest_vertices(vertices, points);
        let triangles: Vec<[u32; 3]> = triangles_of(points).collect();
        let is_other = |(&v, &p): (&u32, &u32)| (vertex_of[p as usize] != v).then_some(p);
        let mut on_seam = Vec::new();
        for point in vertices.iter().zip(points).filter_map(is_other) {
            on_seam.resize(vertex_of.len(), false);
            on_seam[point as usize] = true;
        }
        let equal_vertices = equal_vertices(attribute_bits, vertices, points, &on_seam);
        let rings = CornerRings::new(&triangles, vertices, vertex_of.len());
        let mut fans = FanClassifier::new(vertex_of.len());
        let kinds: Vec<PointKind> = (0..vertex_of.len() as u32)
            .map(|p| fans.kind(&triangles, rings.of(p), rings.opposite(p)))
            .collect();
        let classifier = (may_break || kinds.contains(&PointKind::Irregular)).then_some(fans);
        let wedges = if on_seam.is_empty() { Vec::new() } else { vertices.to_vec() };
        Self {
            triangles,
            triangle_ids,
            wedges,
            equal_vertices,
            vertex_of,
            on_seam,
            kinds,
            classifier,
            rings,
            meshes: Vec::new(),
            triangles_left: Vec::new(),
        }
    }

    /// Sets the first vertices of the meshes that the vertices belong to.
    pub(crate) fn with_meshes(mut self, meshes: &[u32]) -> Self {
        if meshes.len() > 1 {
            self.meshes = meshes.to_vec();
            self.triangles_left = vec![0; meshes.len() + 1];
            for triangle in 0..self.triangles.len() {
                let mesh = self.mesh_of(self.wedge(CornerId::new(triangle, 0)));
                self.triangles_left[mesh as usize] += 1;
            }
        }
        self
    }

    /// Returns whether a collapse removes the last triangles of one of several meshes.
    pub(crate) fn ends_mesh(&self, removed: u32, kept: u32) -> bool {
        if self.meshes.len() < 2 {
            return false;
        }
        let dropped = || {
            let corners = self.ring(removed).iter().zip(self.opposite(removed));
            corners
                .filter(|(_, edge)| edge.contains(&kept))
                .map(|(&corner, _)| self.mesh_of(self.wedge(corner)))
        };
        dropped().any(|mesh| {
            let count = dropped().filter(|&other| other == mesh).count();
            self.triangles_left[mesh as usize] as usize <= count
        })
    }

    /// Returns whether two vertices belong to the same mesh.
    fn are_of_one_mesh(&self, a: u32, b: u32) -> bool {
        self.meshes.len() < 2 || self.mesh_of(a) == self.mesh_of(b)
    }

    /// Returns the number of the mesh that a vertex belongs to, counted from 1; 0 if there is one
    /// mesh.
    fn mesh_of(&self, v: u32) -> u32 {
        self.meshes.partition_point(|&start| start <= v) as u32
    }

    /// Collects the mesh of each corner of a point, in the order of its ring. Collects nothing if
    /// all corners belong to the same mesh.
    pub(crate) fn meshes_around(&self, point: u32, found: &mut Vec<u32>) {
        found.clear();
        if self.meshes.len() > 1 && self.on_seam.get(point as usize) == Some(&true) {
            found.extend(self.ring(point).iter().map(|&corner| self.mesh_of(self.wedge(corner))));
            if found.windows(2).all(|pair| pair[0] == pair[1]) {
                found.clear();
            }
        }
    }

    pub(crate) fn point_count(&self) -> usize {
        self.vertex_of.len()
    }

    /// Returns the lowest vertex of a point.
    pub(crate) fn vertex_of(&self, point: u32) -> u32 {
        self.vertex_of[point as usize]
    }

    /// Returns the vertex at a corner.
    pub(crate) fn wedge(&self, corner: CornerId) -> u32 {
        if self.wedges.is_empty() {
            self.vertex_of[self.point(corner) as usize]
        } else {
            self.wedges[corner.index()]
        }
    }

    pub(crate) fn kind(&self, point: u32) -> PointKind {
        self.kinds[point as usize]
    }

    /// Reclassifies points after a collapse. Points with more than `most` triangles count as
    /// irregular, so the time does not depend on the number of collapses next to them.
    pub(crate) fn classify(&mut self, points: &[u32], most: usize) {
        let Some(classifier) = &mut self.classifier else { return };
        for &point in points {
            let (ring, kind) = (self.rings.of(point), &mut self.kinds[point as usize]);
            if ring.len() <= most {
                *kind = classifier.kind(&self.triangles, ring, self.rings.opposite(point));
            } else if *kind != PointKind::Degenerate {
                *kind = PointKind::Irregular;
            }
        }
    }

    /// Returns the corners of a point.
    pub(crate) fn ring(&self, point: u32) -> &[CornerId] {
        self.rings.of(point)
    }

    /// Returns the opposite edge of each corner of a point, in the order of its ring: the points of
    /// the two other corners of the triangle, in winding order.
    pub(crate) fn opposite(&self, point: u32) -> &[[u32; 2]] {
        self.rings.opposite(point)
    }

    /// Iterates over all corners.
    pub(crate) fn corners(&self) -> impl Iterator<Item = CornerId> + use<> {
        corners(self.triangles.len())
    }

    /// Returns the point of a corner.
    #[inline]
    pub(crate) fn point(&self, corner: CornerId) -> u32 {
        self.triangles[corner.triangle()][corner.within()]
    }

    /// Returns the points of the two other corners of a corner's triangle, in winding order.
    #[inline]
    pub(crate) fn others(&self, corner: CornerId) -> [u32; 2] {
        corner.others(&self.triangles)
    }

    /// Collects the distinct neighbours of a point; for a border point, the two along the border
    /// come last.
    pub(crate) fn neighbours(&self, point: u32, found: &mut Vec<u32>) {
        found.clear();
        let edges = self.opposite(point);
        found.extend(edges.iter().map(|&[u, _]| u));
        if self.kind(point) == PointKind::Border {
            let is_w = |u: u32| edges.iter().any(|&[_, w]| w == u);
            if let Some(first) = found.iter().position(|&u| !is_w(u)) {
                let end = found.len() - 1;
                found.swap(first, end);
            }
            let last = edges.iter().map(|&[_, w]| w).find(|w| !found.contains(w));
            found.extend(last);
        } else if self.kind(point) != PointKind::Inner {
            found.extend(edges.iter().map(|&[_, w]| w));
            found.sort_unstable();
            found.dedup();
        }
    }

    /// Counts the triangles that contain all of the given points, up to two.
    pub(crate) fn triangles_with<const N: usize>(&self, points: [u32; N]) -> usize {
        let Some(around) = points.into_iter().min_by_key(|&p| self.opposite(p).len()) else { return 0 };
        let has_all = |edge: &&[u32; 2]| points.iter().all(|p| *p == around || edge.contains(p));
        self.opposite(around).iter().filter(has_all).take(2).count()
    }

    /// Returns the first of the point's vertices that have the same attributes as a vertex.
    pub(crate) fn first_equal(&self, v: u32) -> u32 {
        self.equal_vertices.get(&v).copied().unwrap_or(v)
    }

    /// Returns whether two vertices at the same position have the same attributes.
    fn are_equal(&self, a: u32, b: u32) -> bool {
        let first_equal = |v: u32| self.equal_vertices.get(&v);
        a == b || first_equal(a).is_some_and(|of_a| first_equal(b) == Some(of_a))
    }

    /// Collects the renames of all vertices at `removed` if that point collapses to `kept`. Returns
    /// `None` if a vertex and its equal vertices have no triangle with `kept`, or if such triangles
    /// have different vertices there.
    pub(crate) fn renames(&self, removed: u32, kept: u32, found: &mut Vec<Rename>) -> Option<()> {
        found.clear();
        if self.on_seam.is_empty() || !self.on_seam[removed as usize] && !self.on_seam[kept as usize] {
            found.push(Rename { removed: self.vertex_of(removed), kept: self.vertex_of(kept) });
            return Some(());
        }
        for &corner in self.ring(removed) {
            let Some(with_kept) = self.corner_at(corner, kept) else { continue };
            let rename = Rename { removed: self.wedge(corner), kept: self.wedge(with_kept) };
            let differs = |known: &&Rename| {
                known.removed == rename.removed && known.kept != rename.kept
                    || self.are_equal(known.removed, rename.removed)
                        && !self.are_equal(known.kept, rename.kept)
            };
            if found.iter().any(|known| differs(&known)) {
                return None;
            }
            if !found.contains(&rename) {
                found.push(rename);
            }
        }
        for &corner in self.ring(removed) {
            let vertex = self.wedge(corner);
            if found.iter().all(|known| known.removed != vertex) {
                let kept = found.iter().find(|known| self.are_equal(known.removed, vertex))?.kept;
                found.push(Rename { removed: vertex, kept });
            }
        }
        Some(())
    }

    /// Collects renames like [`Topology::renames`], but also across seams. A vertex without a
    /// triangle with `kept` is renamed to the vertex there with the smallest difference, among
    /// those of the first triangles; ties go to the lowest vertex. Returns `None` if the triangles
    /// of one vertex have different vertices at `kept`, because not all of them could be dropped.
    pub(crate) fn renames_across(
        &self,
        removed: u32,
        kept: u32,
        found: &mut Vec<Rename>,
        difference: impl Fn(u32, u32) -> f64,
    ) -> Option<()> {
        found.clear();
        for &corner in self.ring(removed) {
            let Some(with_kept) = self.corner_at(corner, kept) else { continue };
            let rename = Rename { removed: self.wedge(corner), kept: self.wedge(with_kept) };
            match found.iter().find(|known| known.removed == rename.removed) {
                Some(known) if known.kept != rename.kept => return None,
                Some(_) => {}
                None => found.push(rename),
            }
        }
        let ring = self.ring(kept);
        let mut targets: Vec<u32> = ring.iter().take(LONG_RING).map(|&corner| self.wedge(corner)).collect();
        targets.sort_unstable();
        targets.dedup();
        for &corner in self.ring(removed) {
            let vertex = self.wedge(corner);
            if found.iter().all(|known| known.removed != vertex) {
                let by_difference =
                    |a: &&u32, b: &&u32| difference(vertex, **a).total_cmp(&difference(vertex, **b));
                let of_mesh = targets.iter().filter(|&&target| self.are_of_one_mesh(target, vertex));
                let kept = *of_mesh.min_by(by_difference)?;
                found.push(Rename { removed: vertex, kept });
            }
        }
        Some(())
    }

    /// Returns the corner of a corner's triangle at another point.
    fn corner_at(&self, corner: CornerId, point: u32) -> Option<CornerId> {
        [corner.next(), corner.previous()].into_iter().find(|&other| self.point(other) == point)
    }

    /// Moves all corners of one point to another. Removes the triangles that contain both, and
    /// writes their indices in the mesh to `dropped`, ascending.
    pub(crate) fn collapse(&mut self, removed: u32, kept: u32, renames: &[Rename], dropped: &mut Vec<u32>) {
        dropped.clear();
        for i in 0..self.ring(removed).len() {
            let corner = self.ring(removed)[i];
            let (t, k) = (corner.triangle(), corner.within());
            if self.triangles[t].contains(&kept) {
                dropped.push(t as u32);
                continue;
            }
            self.triangles[t][k] = kept;
            for (other, end) in [(corner.next(), 1), (corner.previous(), 0)] {
                self.rings.set_opposite(self.triangles[t][other.within()], other, end, kept);
            }
            if !self.wedges.is_empty() {
                let wedge = &mut self.wedges[corner.index()];
                *wedge = renames
                    .iter()
                    .find(|rename| rename.removed == *wedge)
                    .map_or(*wedge, |rename| rename.kept);
            }
        }
        for &t in &*dropped {
            if self.meshes.len() > 1 {
                let mesh = self.mesh_of(self.wedge(CornerId::new(t as usize, 0)));
                self.triangles_left[mesh as usize] -= 1;
            }
            for (k, &p) in self.triangles[t as usize].iter().enumerate() {
                self.rings.remove(p, CornerId::new(t as usize, k));
            }
        }
        self.rings.append(removed, kept);
        if let Some(ids) = &self.triangle_ids {
            dropped.iter_mut().for_each(|t| *t = ids[*t as usize]);
        }
        dropped.sort_unstable();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn topology(positions: &[[f32; 3]], vertices: &[u32]) -> Topology {
        Topology::new(positions, |_| Vec::new(), vertices, false, 0.0)
    }

    /// Builds a topology whose vertices all have different attributes.
    fn seamed(positions: &[[f32; 3]], vertices: &[u32]) -> Topology {
        Topology::new(positions, |v| v.to_le_bytes().to_vec(), vertices, false, 0.0)
    }

    fn line(n: usize) -> Vec<[f32; 3]> {
        (0..n).map(|i| [i as f32, 0.0, 0.0]).collect()
    }

    #[test]
    fn kinds_of_points() {
        // A closed fan around vertex 0, an open one, and points that are neither.
        let fan = |n: u32, closed: bool| {
            (1..=n).filter(move |&i| closed || i < n).flat_map(move |i| [0, i, i % n + 1])
        };
        let kind = |vertices: Vec<u32>| topology(&line(12), &vertices).kind(0);
        assert_eq!(kind(fan(5, true).collect()), PointKind::Inner);
        assert_eq!(kind(fan(5, false).collect()), PointKind::Border);
        assert_eq!(kind(vec![0, 1, 2, 0, 3, 4]), PointKind::Irregular);
        assert_eq!(kind(vec![0, 1, 2, 0, 1, 3]), PointKind::Irregular, "inconsistent winding");
        assert_eq!(kind(vec![0, 1, 2, 2, 1, 3, 0, 2, 1]), PointKind::Inner, "two faces back to back");
        assert_eq!(
            kind(fan(3, true).chain([0, 4, 5, 0, 5, 6, 0, 6, 4]).collect()),
            PointKind::Irregular,
            "two closed fans"
        );
    }

    #[test]
    fn vertices_of_one_position_are_one_point() {
        let mut positions = line(6);
        positions[4] = positions[1];
        positions[5] = [2.0, -0.0, 0.0];
        let topology = seamed(&positions, &[0, 1, 2, 5, 4, 3]);
        assert_eq!(topology.triangles, [[0, 1, 2], [2, 1, 3]]);
        assert_eq!(
            [0, 1, 2, 3].map(|corner| topology.wedge(CornerId::new(corner / 3, corner % 3))),
            [0, 1, 2, 5]
        );
        let open: Vec<(usize, bool)> =
            topology.open_edges().map(|(corner, is_border)| (corner.index(), is_border)).collect();
        assert_eq!(open, [(0, true), (1, false), (2, true), (3, false), (4, true), (5, true)]);
    }

    #[test]
    fn both_vertices_of_a_seam_are_renamed_along_it_only() {
        // Vertices 1 and 4 are one point, 2 and 5 another. The seam is between these points.
        let mut positions = line(8);
        positions[4] = positions[1];
        positions[5] = positions[2];
        let faces = [0, 1, 2, 5, 4, 3];
        let seam = seamed(&positions, &faces);
        let mut found = Vec::new();
        assert!(seam.renames(1, 2, &mut found).is_some());
        assert_eq!(found, [Rename { removed: 1, kept: 2 }, Rename { removed: 4, kept: 5 }]);
        assert!(seam.renames(1, 0, &mut found).is_none());
        assert!(seam.renames(0, 1, &mut found).is_some());
        // Vertices with the same attributes are not a seam: both may be renamed to any vertex.
        let whole = topology(&positions, &faces);
        assert!(whole.open_edges().all(|(_, is_border)| is_border));
        assert!(whole.renames(1, 0, &mut found).is_some());
        assert_eq!(found, [Rename { removed: 1, kept: 0 }, Rename { removed: 4, kept: 0 }]);
    }

    #[test]
    fn a_collapse_moves_corners_and_removes_triangles() {
        let fan: Vec<u32> = (1..=6).flat_map(|i| [0, i, i % 6 + 1]).collect();
        let mut topology = topology(&line(7), &fan);
        let at = |v: u32| (0..7).find(|&p| topology.vertex_of(p) == v).unwrap();
        let (center, rim) = (at(0), at(1));
        let mut dropped = Vec::new();
        topology.collapse(center, rim, &[], &mut dropped);
        assert_eq!(dropped, [0, 5]);
        assert_eq!(topology.ring(rim).len(), 4);
        assert!(topology.ring(center).is_empty());
        let mut ring: Vec<usize> = topology.ring(rim).iter().map(|corner| corner.index()).collect();
        ring.sort_unstable();
        assert_eq!(ring, [3, 6, 9, 12]);
    }
}
