//! The visible difference between a simplified surface and its original: distances, normals and
//! texture coordinates.
//!
//! # Algorithm
//! Sample points on each surface in proportion to area, with a seeded generator. For each point,
//! find the nearest point of the other surface in a tree of bounding boxes, in both directions.
//! Removed vertices are the most likely to be far away, so their nearest points also count for the
//! maximum distance. Normals and texture coordinates are interpolated at both points and compared,
//! from the original to the simplified surface.
//!
//! # References
//! Cignoni, Rocchini, Scopigno: *Metro: Measuring Error on Simplified Surfaces*, 1998.
//!
//! # Complexity
//! O((n + p) log n) time for n triangles and p points if the triangles have similar sizes, as in
//! scans and models. Where many boxes overlap, a search visits all of them. In such cases, fewer
//! points are compared to limit the number of visited boxes ([`MAX_VISITS`]).

mod side;

use tristrip::Mesh;
use tristrip::random::Random;

use crate::error::Error;
use crate::parts::map;
use side::Attributes;
pub(crate) use side::{Facet, Side, dot, sub};

/// The maximum number of triangle boxes that the searches on one surface visit, by estimate.
pub(crate) const MAX_VISITS: f64 = 2e7;
/// The minimum number of boxes that a search visits, by estimate.
const MIN_VISITS: f64 = 100.0;

/// A surface before and after a change: triangles over the vertices of one mesh.
#[derive(Debug, Clone, Copy)]
pub struct ChangedSurface<'a> {
    /// The vertices with their attributes.
    pub mesh: &'a Mesh,
    /// The corners of the original, three vertices per triangle.
    pub before: &'a [u32],
    /// The corners of the result, three vertices per triangle.
    pub after: &'a [u32],
    /// The width and height of the texture at `TEXCOORD_0`, in texels; `None` if they are unknown.
    pub texels: Option<[u32; 2]>,
}

/// The difference between the surfaces, in the unit of the positions.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct SurfaceChange {
    /// The maximum distance found.
    pub largest: f64,
    /// The root mean square of the distances in both directions.
    pub rms: f64,
    /// The root mean square of the angles between normals, in degrees. Vertex normals are
    /// interpolated; a triangle without vertex normals has its face normal.
    pub normal_degrees: f64,
    /// The root mean square of the distances between texture coordinates (`TEXCOORD_0`), relative
    /// to the size of the texture; `None` if there are none.
    pub uv: Option<f64>,
    /// The root mean square of these distances in texels, over the surfaces whose texture size is
    /// known; `None` if there are none.
    pub uv_texels: Option<f64>,
}

/// The sums over the points of one part.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    largest: f64,
    /// Squared distances and points, from the original and from the result.
    squares: [f64; 2],
    counts: [usize; 2],
    /// Squared angles in radians, and squared distances of texture coordinates.
    angles: f64,
    uv: f64,
    uv_count: usize,
    /// Squared distances in texels.
    texels: f64,
    texel_count: usize,
}

/// Measures the difference between surfaces and their originals, with a total of about `points`
/// points per direction.
///
/// If nothing is left of a surface, its distance is the diagonal of its bounding box.
///
/// # Errors
/// The number of indices is not a multiple of three, or an index is out of range.
///
/// ```
/// use tristrip::{Faces, Mesh};
/// use tristrip_pipeline::{ChangedSurface, surface_change};
/// // A pyramid of height 1 over a square, and the square.
/// let corners = vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0], [1.0, 1.0, 1.0]];
/// let mesh = Mesh::new(corners, Faces::default())?;
/// let (before, after) = (&[0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4], &[0, 1, 2, 0, 2, 3]);
/// let change = surface_change(&[ChangedSurface { mesh: &mesh, before, after, texels: None }], 1000)?;
/// assert!((change.largest - 1.0).abs() < 1e-9 && (0.3..0.7).contains(&change.rms));
/// assert!((change.normal_degrees - 45.0).abs() < 1e-3 && change.uv.is_none());
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn surface_change(surfaces: &[ChangedSurface<'_>], points: usize) -> Result<SurfaceChange, Error> {
    let pair = |s: &ChangedSurface<'_>| Ok([Side::new(s.mesh, s.before)?, Side::new(s.mesh, s.after)?]);
    let sides = surfaces.iter().map(pair).collect::<Result<Vec<[Side; 2]>, tristrip::Error>>()?;
    let areas = [0, 1].map(|k| sides.iter().map(|pair| pair[k].area()).sum::<f64>());
    let numbered: Vec<(usize, &ChangedSurface<'_>)> = surfaces.iter().enumerate().collect();
    let sums = map(&numbered, |&(i, surface)| {
        let share =
            |k: usize| if areas[k] > 0.0 { sides[i][k].area() / areas[k] * points as f64 } else { 0.0 };
        compare(surface, &sides[i], [share(0), share(1)], i as u64)
    });
    let mut all = Sums::default();
    for sum in &sums {
        all.largest = all.largest.max(sum.largest);
        for k in 0..2 {
            all.squares[k] += sum.squares[k];
            all.counts[k] += sum.counts[k];
        }
        all.angles += sum.angles;
        all.uv += sum.uv;
        all.uv_count += sum.uv_count;
        all.texels += sum.texels;
        all.texel_count += sum.texel_count;
    }
    let mean = |sum: f64, count: usize| if count > 0 { sum / count as f64 } else { 0.0 };
    let squares = [0, 1].map(|k| mean(all.squares[k], all.counts[k]));
    Ok(SurfaceChange {
        largest: all.largest,
        rms: f64::midpoint(squares[0], squares[1]).sqrt(),
        normal_degrees: mean(all.angles, all.counts[0]).sqrt().to_degrees(),
        uv: (all.uv_count > 0).then(|| mean(all.uv, all.uv_count).sqrt()),
        uv_texels: (all.texel_count > 0).then(|| mean(all.texels, all.texel_count).sqrt()),
    })
}

/// Compares one surface in both directions, with the given numbers of points.
fn compare(surface: &ChangedSurface<'_>, sides: &[Side; 2], points: [f64; 2], seed: u64) -> Sums {
    let mut sums = Sums::default();
    let [before, after] = sides;
    if before.facets.is_empty() {
        return sums;
    }
    if after.facets.is_empty() {
        let most = before.diagonal();
        let count = at_least_one(points[0]);
        return Sums {
            largest: most,
            squares: [most * most * count as f64, 0.0],
            counts: [count, 0],
            ..sums
        };
    }
    let trees = [before.tree(), after.tree()];
    let points = [0, 1].map(|k| affordable(points[k], sides[k].crowd(&trees[1 - k])));
    let attributes = Attributes::new(surface.mesh);
    let mut random = Random::new(seed);
    for k in 0..2 {
        sides[k].sample(points[k], &mut random, |facet, shares| {
            let at = facet.at(shares);
            let Some(nearest) = trees[1 - k].nearest_neighbor(at) else { return };
            let (square, there) = nearest.nearest(at);
            sums.squares[k] += square;
            sums.counts[k] += 1;
            sums.largest = sums.largest.max(square.sqrt());
            if k == 0 {
                sums.angles += attributes.angle((facet, shares), (nearest, there)).powi(2);
                if let Some([u, v]) = attributes.uv_difference((facet, shares), (nearest, there)) {
                    sums.uv += u * u + v * v;
                    sums.uv_count += 1;
                    if let Some([width, height]) = surface.texels {
                        sums.texels += (u * f64::from(width)).powi(2) + (v * f64::from(height)).powi(2);
                        sums.texel_count += 1;
                    }
                }
            }
        });
    }
    // The vertices that are no longer drawn, evenly selected if there are more of them than points.
    let mut is_drawn = vec![false; surface.mesh.vertex_count()];
    surface.after.iter().for_each(|&v| is_drawn[v as usize] = true);
    let mut removed: Vec<u32> = surface.before.iter().copied().filter(|&v| !is_drawn[v as usize]).collect();
    removed.sort_unstable();
    removed.dedup();
    let step = (removed.len() / at_least_one(points[0])).max(1);
    for &v in removed.iter().step_by(step) {
        let at = surface.mesh.positions()[v as usize].map(f64::from);
        if let Some(nearest) = trees[1].nearest_neighbor(at) {
            sums.largest = sums.largest.max(nearest.nearest(at).0.sqrt());
        }
    }
    sums
}

/// Returns the number of points that can be searched, given the number of boxes that contain each.
fn affordable(points: f64, crowd: f64) -> f64 {
    points.min(MAX_VISITS / (MIN_VISITS + crowd))
}

#[expect(clippy::cast_sign_loss, reason = "at least 1")]
fn at_least_one(points: f64) -> usize {
    points.max(1.0) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use tristrip::{Attribute, AttributeData, Faces};

    fn square(z: f32) -> Vec<[f32; 3]> {
        [[0.0, 0.0], [3.0, 0.0], [3.0, 4.0], [0.0, 4.0]].map(|[x, y]| [x, y, z]).to_vec()
    }

    #[test]
    fn parallel_squares_are_as_far_apart_as_they_are() {
        let positions = [square(0.0), square(2.0)].concat();
        let data =
            AttributeData::F32((0..16).map(|i| if i < 8 { 0.0 } else { (i % 2) as f32 * 0.5 }).collect());
        let uv = Attribute { name: "TEXCOORD_0".into(), components: 2, normalized: false, data };
        let mesh = Mesh::new(positions, Faces::default()).unwrap().with_attribute(uv).unwrap();
        let surface = ChangedSurface {
            mesh: &mesh,
            before: &[0, 1, 2, 0, 2, 3],
            after: &[4, 5, 6, 4, 6, 7],
            texels: None,
        };
        let change = surface_change(&[surface], 1000).unwrap();
        assert!((change.largest - 2.0).abs() < 1e-9 && (change.rms - 2.0).abs() < 1e-9, "{change:?}");
        assert!(change.normal_degrees < 1e-9 && (change.uv.unwrap() - 0.5).abs() < 1e-6, "{change:?}");
        // Only v differs, by half of the texture.
        let wide = surface_change(&[ChangedSurface { texels: Some([1024, 64]), ..surface }], 1000).unwrap();
        assert!((wide.uv_texels.unwrap() - 32.0).abs() < 1e-4 && change.uv_texels.is_none(), "{wide:?}");
        // An unchanged second surface with half of the area.
        let same = ChangedSurface { after: &[0, 1, 2, 0, 2, 3], ..surface };
        let both = surface_change(&[surface, same], 4000).unwrap();
        assert!((both.rms - 2.0_f64.sqrt()).abs() < 0.01 && (both.largest - 2.0).abs() < 1e-9, "{both:?}");
    }

    #[test]
    fn nothing_left_is_the_diagonal_away() {
        let mesh = Mesh::new(square(0.0), Faces::default()).unwrap();
        let (before, after): (&[u32], &[u32]) = (&[0, 1, 2, 0, 2, 3], &[]);
        let gone =
            surface_change(&[ChangedSurface { mesh: &mesh, before, after, texels: None }], 10).unwrap();
        assert!((gone.largest - 5.0).abs() < 1e-9, "{gone:?}");
        let none = surface_change(&[ChangedSurface { mesh: &mesh, before: after, after, texels: None }], 10)
            .unwrap();
        assert_eq!(none, SurfaceChange::default());
        assert_eq!(surface_change(&[], 10).unwrap(), SurfaceChange::default());
        for wrong in [&[0, 1][..], &[0, 1, 4]] {
            assert!(
                surface_change(&[ChangedSurface { mesh: &mesh, before: wrong, after, texels: None }], 10)
                    .is_err()
            );
        }
    }

    #[test]
    fn overlapping_triangles_get_fewer_points() {
        let mut random = Random::new(5);
        let mut number = || random.below(1000) as f32;
        let corner = |i: u32, x: f32, y: f32| {
            [if i.is_multiple_of(3) { x } else { 1000.0 - x }, y, (i % 3) as f32 * 500.0]
        };
        let positions: Vec<[f32; 3]> = (0..6000).map(|i| corner(i, number() / 9.0, number())).collect();
        let mesh = Mesh::new(positions, Faces::default()).unwrap();
        let triangles: Vec<u32> = (0..6000).collect();
        let side = Side::new(&mesh, &triangles).unwrap();
        let crowd = side.crowd(&side.tree());
        assert!((300.0..2000.0).contains(&crowd), "{crowd}");
        // A million such triangles allow few points, an ordinary surface allows all.
        assert!(affordable(5000.0, 500.0 * crowd) < 150.0 && affordable(5000.0, 10.0) >= 5000.0);
        let surface = ChangedSurface { mesh: &mesh, before: &triangles, after: &triangles, texels: None };
        assert!(surface_change(&[surface], 500).unwrap().largest < 1e-6);
    }
}
