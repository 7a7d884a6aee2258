//! The sides of triangles at borders of the surface or at attribute seams.

use std::collections::HashMap;

use super::corner::{CornerId, corners};
use super::{LONG_RING, PointKind, Topology};

impl Topology {
    /// Iterates over the sides of triangles at borders and seams: the corner at which each begins,
    /// and whether it is a border of its mesh.
    pub(crate) fn open_edges(&self) -> impl Iterator<Item = (CornerId, bool)> {
        // Sides between two points with many triangles each are looked up in a map.
        let is_long = |p: u32| self.ring(p).len() > LONG_RING;
        let mut long = HashMap::new();
        if (0..self.point_count() as u32).any(is_long) {
            let side = |corner: CornerId| [self.point(corner), self.others(corner)[1]];
            let between = |corner: &CornerId| side(*corner).into_iter().all(is_long);
            long.extend(corners(self.triangles.len()).filter(between).map(|corner| (side(corner), corner)));
        }
        corners(self.triangles.len()).filter_map(move |corner| {
            let (from, [to, _]) = (self.point(corner), self.others(corner));
            if self.wedges.is_empty() && self.kind(from) == PointKind::Inner {
                return None;
            }
            // The corner at the same point of the adjacent triangle, searched around the point with
            // fewer corners.
            let other = if is_long(from) && is_long(to) {
                long.get(&[from, to]).copied()
            } else if self.ring(from).len() <= self.ring(to).len() {
                self.ring(from).iter().copied().find(|&other| self.others(other)[1] == to)
            } else {
                self.ring(to).iter().find(|&&other| self.others(other)[0] == from).map(|other| other.next())
            };
            let Some(other) = other else {
                // An edge between triangles of different winding is not a border.
                let has_edge = |other: &&CornerId| **other != corner && self.others(**other)[0] == to;
                let is_inside = !is_long(from) && self.ring(from).iter().any(|other| has_edge(&other));
                return (!is_inside).then_some((corner, true));
            };
            if !self.are_of_one_mesh(self.wedge(corner), self.wedge(other)) {
                return Some((corner, true));
            }
            let is_seam = [(corner, other), (corner.next(), other.previous())]
                .iter()
                .any(|&(a, b)| !self.are_equal(self.wedge(a), self.wedge(b)));
            is_seam.then_some((corner, false))
        })
    }
}
