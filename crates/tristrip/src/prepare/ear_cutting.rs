//! Ear cutting of polygons that are not convex.
//!
//! The `earcut` crate drops corners on straight edges and may fail on self-intersecting polygons,
//! so its result is checked.

use earcut::Earcut;

use super::convex::project;
use crate::mesh::Positions;

/// Maximum number of corners of a polygon for ear cutting. `earcut` uses a z-order curve and takes
/// less than 0.3 ms for 2,000 corners of combs, bowls and round shapes, but up to 28 ns · k² for
/// self-intersecting polygons. Tuned on stars, combs, spirals, random and self-intersecting
/// polygons of 1,000 to 16,000 corners. A polygon at this limit takes at most 0.47 s.
pub(super) const EAR_CORNERS: usize = 4096;

/// Maximum sum of k² over the polygons of a mesh with more than [`EAR_SMALL`] corners that are cut:
/// four of the largest, 1.4 s in the worst case.
pub(super) const EAR_STEPS: usize = 4 * EAR_CORNERS * EAR_CORNERS;

/// Polygons of up to this many corners are always cut, in at most 7 µs per corner.
pub(super) const EAR_SMALL: usize = 256;

/// The remaining steps of ear cutting in a mesh.
pub(super) struct EarBudget {
    steps_left: usize,
}

impl EarBudget {
    pub(super) fn new() -> Self {
        Self { steps_left: EAR_STEPS }
    }

    /// Reserves the steps for a polygon of k corners. Returns whether it is within the limits.
    pub(super) fn reserve(&mut self, k: usize) -> bool {
        let steps = if k > EAR_SMALL { k.saturating_mul(k) } else { 0 };
        let fits = k <= EAR_CORNERS && steps <= self.steps_left;
        self.steps_left -= if fits { steps } else { 0 };
        fits
    }
}

/// Cuts a polygon into triangles by ear cutting, or returns `None` if the result is not a
/// triangulation of all corners.
pub(super) fn cut_ears<P: Positions + ?Sized>(polygon: &[u32], positions: &P) -> Option<Vec<[u32; 3]>> {
    let points = project(polygon, positions)?;
    let mut local: Vec<u32> = Vec::new();
    Earcut::new().earcut(points, &[], &mut local);
    let n = polygon.len() as u32;
    if local.len() != 3 * (polygon.len() - 2) {
        return None;
    }
    let mut triangles: Vec<[u32; 3]> = local.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    // The projected polygon is counter-clockwise. `earcut` may return either winding.
    let ascends = |t: &[u32; 3]| (t[0] < t[1]) as u8 + (t[1] < t[2]) as u8 + (t[2] < t[0]) as u8 == 2;
    if triangles.iter().any(|t| !ascends(t)) {
        triangles.iter_mut().for_each(|t| t.swap(0, 1));
    }
    // Every boundary edge must occur once, and every other edge in both directions.
    let mut edges: Vec<(u32, u32)> =
        triangles.iter().flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]).collect();
    edges.sort_unstable();
    let once = edges.windows(2).all(|w| w[0] != w[1]);
    let matched = |&(a, b): &(u32, u32)| b == (a + 1) % n || edges.binary_search(&(b, a)).is_ok();
    let boundary = (0..n).all(|a| edges.binary_search(&(a, (a + 1) % n)).is_ok());
    (once && boundary && triangles.iter().all(ascends) && edges.iter().all(matched))
        .then(|| triangles.iter().map(|t| t.map(|i| polygon[i as usize])).collect())
}
