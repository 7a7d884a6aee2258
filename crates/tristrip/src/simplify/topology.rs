//! Triangles over points, and around each point the triangles that meet there.
//!
//! A *point* is a position; vertices of one position are one point, so that a mesh whose attributes have seams is whole where it looks
//! whole. Which vertex a corner has is kept beside it, where that is not always the same one.
//!
//! ```text
//!        u ───── w        A corner of the point b, in the triangle (b, u, w). The ring of b holds its corners, in any order.
//!       ╱ ╲     ╱ ╲       Around an inner point every neighbour is the u of one corner and the w of another; around a border
//!      ╱   ╲   ╱   ╲      point two are but one of both: the neighbours along the border.
//!     ╱     ╲ ╱     ╲
//!    ·────── b ──────·
//! ```
//!
//! # Complexity
//! 12 bytes a triangle, 12 more where there are seams, some 30 for the rings; 18 bytes a point, and about 60 a vertex on a seam.

mod corner;
mod fans;
mod points;
mod rings;

use std::collections::HashMap;

pub(super) use corner::Corner;
use corner::{LAST, NEXT, corners};
use fans::Fans;
pub(super) use fans::Kind;
use points::{Numbering, alike};
use rings::Rings;

use crate::collapse::Rename;
use crate::mesh::Mesh;

/// As many triangles as are taken: rings that grow move to the end of their array, which some ten corners a triangle do not fill.
pub(super) const MOST_TRIANGLES: usize = 1 << 27;

/// From so many corners on a ring is not walked along where that can be done without.
pub(super) const LONG_RING: usize = 64;
/// Triangles that can be taken away and whose corners can move to other points.
#[derive(Debug)]
pub(super) struct Topology {
    /// The points of each triangle; of one that is gone, those that it had last.
    pub(super) triangles: Vec<[u32; 3]>,
    /// The vertex at each corner; empty where each point is one vertex.
    wedges: Vec<u32>,
    /// For each vertex of a point that is several the first one of it with the same attributes, bit for bit.
    alike: HashMap<u32, u32>,
    /// A vertex of each point.
    vertex_of: Vec<u32>,
    /// Whether a point is more than one vertex; empty where none is.
    on_seam: Vec<bool>,
    kinds: Vec<Kind>,
    rings: Rings,
}

impl Topology {
    /// Joins triangles of vertices at points of equal position.
    pub(super) fn new(mesh: &Mesh, vertices: &[u32]) -> Self {
        let numbering = Numbering::new(mesh.positions(), vertices);
        let point = |corner: usize| numbering.points[corner];
        let triangles: Vec<[u32; 3]> =
            (0..vertices.len() / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2].map(point)).collect();
        let is_other = |(&v, &p): (&u32, &u32)| (numbering.vertex_of[p as usize] != v).then_some(p);
        let mut on_seam = Vec::new();
        for point in vertices.iter().zip(&numbering.points).filter_map(is_other) {
            on_seam.resize(numbering.vertex_of.len(), false);
            on_seam[point as usize] = true;
        }
        let alike = alike(mesh, vertices, &numbering.points, &on_seam);
        let rings = Rings::new(&triangles, vertices, numbering.vertex_of.len());
        let mut topology = Self {
            triangles,
            wedges: if on_seam.is_empty() { Vec::new() } else { vertices.to_vec() },
            alike,
            on_seam,
            kinds: vec![Kind::Complex; numbering.vertex_of.len()],
            vertex_of: numbering.vertex_of,
            rings,
        };
        let mut fans = Fans::new(topology.point_count());
        for point in 0..topology.point_count() as u32 {
            topology.kinds[point as usize] = fans.kind(&topology, point);
        }
        topology
    }

    pub(super) fn point_count(&self) -> usize {
        self.vertex_of.len()
    }

    /// Gives the lowest vertex of a point.
    pub(super) fn vertex_of(&self, point: u32) -> u32 {
        self.vertex_of[point as usize]
    }

    /// Gives the vertex at a corner.
    pub(super) fn wedge(&self, corner: Corner) -> u32 {
        if self.wedges.is_empty() {
            self.vertex_of[self.point(corner) as usize]
        } else {
            self.wedges[corner.index()]
        }
    }

    pub(super) fn kind(&self, point: u32) -> Kind {
        self.kinds[point as usize]
    }

    /// Gives the corners of a point.
    pub(super) fn ring(&self, point: u32) -> &[Corner] {
        self.rings.of(point)
    }

    /// Gives the point of a corner.
    #[inline]
    pub(super) fn point(&self, corner: Corner) -> u32 {
        self.triangles[corner.triangle()][corner.place()]
    }

    /// Gives the two other points of a corner's triangle, in its winding.
    #[inline]
    pub(super) fn others(&self, corner: Corner) -> [u32; 2] {
        let triangle = &self.triangles[corner.triangle()];
        [triangle[NEXT[corner.place()]], triangle[LAST[corner.place()]]]
    }

    /// Collects the neighbours of a point that is not complex, each once; those along a border last, two of them.
    pub(super) fn neighbours(&self, point: u32, found: &mut Vec<u32>) {
        found.clear();
        found.extend(self.ring(point).iter().map(|&corner| self.others(corner)[0]));
        if self.kind(point) == Kind::Border {
            let ring = self.ring(point);
            let is_w = |u: u32| ring.iter().any(|&corner| self.others(corner)[1] == u);
            if let Some(first) = found.iter().position(|&u| !is_w(u)) {
                let end = found.len() - 1;
                found.swap(first, end);
            }
            let last = ring.iter().map(|&corner| self.others(corner)[1]).find(|w| !found.contains(w));
            found.extend(last);
        }
    }

    /// Counts the triangles that have all of some points, up to two, looked for around the point with the fewest.
    pub(super) fn triangles_with<const N: usize>(&self, points: [u32; N]) -> usize {
        let around = points.into_iter().min_by_key(|&p| self.ring(p).len());
        let has_all = |corner: &&Corner| points.iter().all(|p| self.triangles[corner.triangle()].contains(p));
        around.map_or(0, |p| self.ring(p).iter().filter(has_all).take(2).count())
    }

    /// Tells whether two vertices of one position have the same attributes.
    fn are_alike(&self, a: u32, b: u32) -> bool {
        a == b || self.alike.get(&a).is_some_and(|of_a| self.alike.get(&b) == Some(of_a))
    }

    /// Gives the vertex that each vertex at `removed` becomes where it is joined to `kept`: `None` where neither it nor one like it has a
    /// triangle with `kept`, or such triangles have different vertices there.
    pub(super) fn renames(&self, removed: u32, kept: u32, found: &mut Vec<Rename>) -> Option<()> {
        found.clear();
        if self.on_seam.is_empty() || !self.on_seam[removed as usize] && !self.on_seam[kept as usize] {
            found.push(Rename { removed: self.vertex_of(removed), kept: self.vertex_of(kept) });
            return Some(());
        }
        for &corner in self.ring(removed) {
            let with_kept =
                [corner.next(), corner.last()].into_iter().find(|&other| self.point(other) == kept);
            let Some(with_kept) = with_kept else { continue };
            let rename = Rename { removed: self.wedge(corner), kept: self.wedge(with_kept) };
            let differs = |known: &&Rename| {
                known.removed == rename.removed && known.kept != rename.kept
                    || self.are_alike(known.removed, rename.removed)
                        && !self.are_alike(known.kept, rename.kept)
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
                let kept = found.iter().find(|known| self.are_alike(known.removed, vertex))?.kept;
                found.push(Rename { removed: vertex, kept });
            }
        }
        Some(())
    }

    /// Moves all corners of one point to another, and takes away the triangles that had both, whose numbers it gives, rising.
    pub(super) fn collapse(&mut self, removed: u32, kept: u32, renames: &[Rename], dropped: &mut Vec<u32>) {
        dropped.clear();
        for i in 0..self.ring(removed).len() {
            let corner = self.ring(removed)[i];
            let (t, k) = (corner.triangle(), corner.place());
            if self.triangles[t].contains(&kept) {
                dropped.push(t as u32);
                continue;
            }
            self.triangles[t][k] = kept;
            if !self.wedges.is_empty() {
                let wedge = &mut self.wedges[corner.index()];
                *wedge = renames
                    .iter()
                    .find(|rename| rename.removed == *wedge)
                    .map_or(*wedge, |rename| rename.kept);
            }
        }
        for &t in &*dropped {
            for (k, &p) in self.triangles[t as usize].iter().enumerate() {
                self.rings.remove(p, Corner::new(t as usize, k));
            }
        }
        self.rings.append(removed, kept);
        dropped.sort_unstable();
    }

    /// Walks over the sides of triangles at borders and seams: the corner that each starts from, and whether there is nothing beyond.
    pub(super) fn open_edges(&self) -> impl Iterator<Item = (Corner, bool)> {
        // Between two points of many triangles each, sides are looked up.
        let is_long = |p: u32| self.ring(p).len() > LONG_RING;
        let mut long = HashMap::new();
        if (0..self.point_count() as u32).any(is_long) {
            let side = |corner: Corner| [self.point(corner), self.others(corner)[1]];
            let between = |corner: &Corner| side(*corner).into_iter().all(is_long);
            long.extend(corners(self.triangles.len()).filter(between).map(|corner| (side(corner), corner)));
        }
        corners(self.triangles.len()).filter_map(move |corner| {
            let (from, [to, _]) = (self.point(corner), self.others(corner));
            if self.wedges.is_empty() && self.kind(from) == Kind::Inner {
                return None;
            }
            // The corner at the same point of the triangle beyond, looked for where there is less to look through.
            let other = if is_long(from) && is_long(to) {
                long.get(&[from, to]).copied()
            } else if self.ring(from).len() <= self.ring(to).len() {
                self.ring(from).iter().copied().find(|&other| self.others(other)[1] == to)
            } else {
                self.ring(to).iter().find(|&&other| self.others(other)[0] == from).map(|other| other.next())
            };
            let Some(other) = other else { return Some((corner, true)) };
            let torn = [(corner, other), (corner.next(), other.last())]
                .iter()
                .any(|&(a, b)| !self.are_alike(self.wedge(a), self.wedge(b)));
            torn.then_some((corner, false))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Attribute, AttributeData, Faces};

    fn mesh(positions: &[[f32; 3]], vertices: &[u32]) -> Mesh {
        Mesh::new(positions.to_vec(), Faces::from_triangles(vertices.to_vec()).unwrap()).unwrap()
    }

    fn topology(positions: &[[f32; 3]], vertices: &[u32]) -> Topology {
        Topology::new(&mesh(positions, vertices), vertices)
    }

    /// The same where no two vertices have the same attributes.
    fn seamed(positions: &[[f32; 3]], vertices: &[u32]) -> Topology {
        let data = AttributeData::U32((0..positions.len() as u32).collect());
        let number = Attribute { name: "number".into(), components: 1, normalized: false, data };
        Topology::new(&mesh(positions, vertices).with_attribute(number).unwrap(), vertices)
    }

    fn line(n: usize) -> Vec<[f32; 3]> {
        (0..n).map(|i| [i as f32, 0.0, 0.0]).collect()
    }

    #[test]
    fn kinds_of_points() {
        // A fan around 0 that is closed, then one that is open, then two of them.
        let fan = |n: u32, closed: bool| {
            (1..=n).filter(move |&i| closed || i < n).flat_map(move |i| [0, i, i % n + 1])
        };
        let kind = |vertices: Vec<u32>| topology(&line(12), &vertices).kind(0);
        assert_eq!(kind(fan(5, true).collect()), Kind::Inner);
        assert_eq!(kind(fan(5, false).collect()), Kind::Border);
        assert_eq!(kind(vec![0, 1, 2, 0, 3, 4]), Kind::Complex);
        assert_eq!(kind(vec![0, 1, 2, 0, 1, 3]), Kind::Complex, "wound against each other");
        assert_eq!(kind(vec![0, 1, 2, 2, 1, 3, 0, 2, 1]), Kind::Inner, "two faces back to back");
        assert_eq!(
            kind(fan(3, true).chain([0, 4, 5, 0, 5, 6, 0, 6, 4]).collect()),
            Kind::Complex,
            "two closed fans"
        );
    }

    #[test]
    fn points_of_one_position_are_joined() {
        let mut positions = line(6);
        positions[4] = positions[1];
        positions[5] = [2.0, -0.0, 0.0];
        let topology = seamed(&positions, &[0, 1, 2, 5, 4, 3]);
        assert_eq!(topology.triangles, [[0, 1, 2], [2, 1, 3]]);
        assert_eq!(
            [0, 1, 2, 3].map(|corner| topology.wedge(Corner::new(corner / 3, corner % 3))),
            [0, 1, 2, 5]
        );
        let open: Vec<(usize, bool)> =
            topology.open_edges().map(|(corner, is_border)| (corner.index(), is_border)).collect();
        assert_eq!(open, [(0, true), (1, false), (2, true), (3, false), (4, true), (5, true)]);
    }

    #[test]
    fn both_vertices_of_a_seam_are_renamed_along_it_only() {
        // 1 and 4, 2 and 5 are pairs; the seam goes from point 1 to point 2.
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
        // Vertices that differ in nothing are no seam: both go anywhere.
        let whole = topology(&positions, &faces);
        assert!(whole.open_edges().all(|(_, is_border)| is_border));
        assert!(whole.renames(1, 0, &mut found).is_some());
        assert_eq!(found, [Rename { removed: 1, kept: 0 }, Rename { removed: 4, kept: 0 }]);
    }

    #[test]
    fn a_collapse_moves_corners_and_takes_triangles_away() {
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
