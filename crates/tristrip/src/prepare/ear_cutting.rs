//! Ear cutting of polygons that are not convex.
//!
//! The `earcut` crate drops corners on straight edges and may fail on polygons that cross themselves, so its result is checked.

use earcut::Earcut;

use super::convex::project;
use crate::mesh::Positions;

/// The largest number of corners of a polygon that is cut by ears. The ear cutter uses a z-order curve and takes less than 0.3 ms for
/// 2,000 corners of combs, bowls and round shapes, but up to 28 ns · k² for polygons that cross themselves (tuned on stars, combs,
/// spirals, random and self-crossing polygons of 1,000 to 16,000 corners): 0.47 s at this limit.
pub(super) const EAR_CORNERS: usize = 4096;

/// The limit of the sum of k² over the polygons of a mesh that are cut by ears and have more than [`EAR_SMALL`] corners: four of
/// the largest, 1.4 s at worst.
pub(super) const EAR_STEPS: usize = 4 * EAR_CORNERS * EAR_CORNERS;

/// Polygons of up to this number of corners are always cut by ears: 7 µs per corner at worst.
pub(super) const EAR_SMALL: usize = 256;

/// The steps that ear cutting may still take in a mesh.
pub(super) struct EarBudget {
    steps_left: usize,
}

impl EarBudget {
    pub(super) fn new() -> Self {
        Self { steps_left: EAR_STEPS }
    }

    /// Reserves the steps for a polygon of k corners. Returns whether they are within the limits.
    pub(super) fn reserve(&mut self, k: usize) -> bool {
        let steps = if k > EAR_SMALL { k.saturating_mul(k) } else { 0 };
        let fits = k <= EAR_CORNERS && steps <= self.steps_left;
        self.steps_left -= if fits { steps } else { 0 };
        fits
    }
}

/// Cuts a polygon into triangles by ear cutting; returns `None` if the result is not a triangulation of all its corners.
pub(super) fn cut_ears<P: Positions + ?Sized>(polygon: &[u32], positions: &P) -> Option<Vec<[u32; 3]>> {
    let points = project(polygon, positions)?;
    let mut local: Vec<u32> = Vec::new();
    Earcut::new().earcut(points, &[], &mut local);
    let n = polygon.len() as u32;
    if local.len() != 3 * (polygon.len() - 2) {
        return None;
    }
    let mut triangles: Vec<[u32; 3]> = local.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    // The projected polygon is counter-clockwise; the ear cutter may return either winding.
    let ascends = |t: &[u32; 3]| (t[0] < t[1]) as u8 + (t[1] < t[2]) as u8 + (t[2] < t[0]) as u8 == 2;
    if triangles.iter().any(|t| !ascends(t)) {
        triangles.iter_mut().for_each(|t| t.swap(0, 1));
    }
    // Every boundary edge must occur once, every other edge in both directions.
    let mut edges: Vec<(u32, u32)> =
        triangles.iter().flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]).collect();
    edges.sort_unstable();
    let once = edges.windows(2).all(|w| w[0] != w[1]);
    let matched = |&(a, b): &(u32, u32)| b == (a + 1) % n || edges.binary_search(&(b, a)).is_ok();
    let boundary = (0..n).all(|a| edges.binary_search(&(a, (a + 1) % n)).is_ok());
    (once && boundary && triangles.iter().all(ascends) && edges.iter().all(matched))
        .then(|| triangles.iter().map(|t| t.map(|i| polygon[i as usize])).collect())
}
