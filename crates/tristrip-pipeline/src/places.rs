//! The instances of the parts of a model: the transforms of the nodes that place them in the scene.
//!
//! Parts that the same nodes place, such as the primitives of one glTF mesh, share a list of
//! transforms. Such parts can be compared in their own coordinates. Parts that no node shows, and
//! all parts of a file without nodes, have the identity transform.

use std::collections::HashMap;
use std::sync::Arc;

use tristrip::lod::{Camera, ViewCriteria};
use tristrip_io::Model;

/// The maximum magnitude of a value of a transform. It keeps products with positions far from the
/// limits of a float.
const MAX_COORDINATE: f64 = 1e30;
/// The tolerance for equal scales: rounding changes the scale 1 of a rotation.
pub(crate) const SAME_SCALE: f64 = 1e-6;
/// The maximum deviation of a transform from one that preserves angles, relative to the square of
/// its scale.
const SIMILAR: f64 = 1e-4;

/// An affine transform from a part to the scene, by rows: a linear map and a translation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place([[f64; 4]; 3]);

impl Place {
    pub(crate) const IDENTITY: Self =
        Self([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);

    /// Creates a transform, or the identity if a value is too large. Adding 0.0 turns −0.0 into
    /// 0.0.
    pub(crate) fn new(rows: [[f64; 4]; 3]) -> Self {
        let usable = rows.as_flattened().iter().all(|x| x.abs() <= MAX_COORDINATE);
        if usable { Self(rows.map(|row| row.map(|x| x + 0.0))) } else { Self::IDENTITY }
    }

    /// Returns a transformed position.
    pub(crate) fn at(&self, p: [f32; 3]) -> [f64; 3] {
        let p = p.map(f64::from);
        self.0.map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3])
    }

    /// Returns a position under the linear map, without the translation.
    pub(crate) fn turned(&self, p: [f32; 3]) -> [f64; 3] {
        let p = p.map(f64::from);
        self.0.map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2])
    }

    /// Returns the maximum sum of magnitudes that are added for a scene coordinate. The rounding
    /// error is proportional to it.
    pub(crate) fn magnitude(&self, p: [f32; 3]) -> f64 {
        let p = p.map(|x| f64::from(x).abs());
        let sums =
            self.0.map(|row| row[0].abs() * p[0] + row[1].abs() * p[1] + row[2].abs() * p[2] + row[3].abs());
        sums.into_iter().fold(0.0, f64::max)
    }

    /// Checks whether the transform is a translation.
    pub(crate) fn only_moves(&self) -> bool {
        self.0.map(|row| [row[0], row[1], row[2]]) == Self::IDENTITY.0.map(|row| [row[0], row[1], row[2]])
    }

    /// Returns the scale along the most stretched direction: the largest singular value of the
    /// linear map.
    ///
    /// The eigenvalues of the symmetric matrix are the roots of its characteristic polynomial, in
    /// trigonometric form (Smith: *Eigenvalues of a Symmetric 3 × 3 Matrix*, 1961).
    pub(crate) fn scale(&self) -> f64 {
        if self.only_moves() {
            return 1.0;
        }
        let m = &self.0;
        let entry = |i: usize, j: usize| (0..3).map(|k| m[k][i] * m[k][j]).sum::<f64>();
        let [a, b, c] = [entry(0, 0), entry(1, 1), entry(2, 2)];
        let [d, e, f] = [entry(0, 1), entry(1, 2), entry(0, 2)];
        let off = d * d + e * e + f * f;
        let mean = (a + b + c) / 3.0;
        let spread = ((a - mean).powi(2) + (b - mean).powi(2) + (c - mean).powi(2) + 2.0 * off) / 6.0;
        let p = spread.sqrt();
        if p <= mean * f64::EPSILON {
            return mean.sqrt();
        }
        let [a, b, c] = [a, b, c].map(|x| (x - mean) / p);
        let [d, e, f] = [d, e, f].map(|x| x / p);
        let determinant = a * (b * c - e * e) - d * (d * c - e * f) + f * (d * e - b * f);
        let angle = libm::acos((0.5 * determinant).clamp(-1.0, 1.0)) / 3.0;
        (mean + 2.0 * p * libm::cos(angle)).max(0.0).sqrt()
    }

    /// Returns a camera of the scene and its criteria in the coordinates of the part; `None` if the
    /// transform does not preserve angles, or values become too large.
    ///
    /// An error in part units covers the same number of pixels, because all lengths and distances
    /// change by the same factor.
    pub(crate) fn inward(&self, camera: &Camera, criteria: &ViewCriteria) -> Option<(Camera, ViewCriteria)> {
        if *self == Self::IDENTITY {
            return Some((*camera, *criteria));
        }
        let m = &self.0;
        let product = |i: usize, j: usize| (0..3).map(|k| m[k][i] * m[k][j]).sum::<f64>();
        let square = (product(0, 0) + product(1, 1) + product(2, 2)) / 3.0;
        let is_near = |found: f64, expected: f64| (found - expected).abs() <= SIMILAR * square;
        let is_similar =
            (0..3).all(|i| is_near(product(i, i), square) && is_near(product(i, (i + 1) % 3), 0.0));
        if !is_similar || square <= 0.0 {
            return None;
        }
        let turned =
            |v: [f64; 3]| [0, 1, 2].map(|i| ((0..3).map(|k| m[k][i] * v[k]).sum::<f64>() / square) as f32);
        let point = |p: [f32; 3]| turned([0, 1, 2].map(|k| f64::from(p[k]) - m[k][3]));
        let [columns, rows] = camera.image();
        let inward = Camera::new(point(camera.eye()), point(camera.look_at())).ok()?;
        // Set the up axis of the image explicitly: the default up axis may differ in part
        // coordinates.
        let [right, up, _] = camera.axes();
        let inward = inward.with_up(turned(up)).ok()?;
        let inward =
            inward.with_field_of_view(camera.field_of_view()).ok()?.with_image(columns, rows).ok()?;
        let mut criteria = *criteria;
        if let Some(light) = criteria.light {
            criteria = criteria.with_light(turned(light.map(f64::from)));
            criteria.check().ok()?;
        }
        let (right, own_right) = (turned(right), inward.axes()[0]);
        let is_mirrored = (0..3).map(|k| f64::from(right[k]) * own_right[k]).sum::<f64>() < 0.0;
        if let Some(foveation) = criteria.foveation.filter(|_| is_mirrored) {
            let [x, y] = foveation.attention();
            criteria = criteria.with_foveation(foveation.with_attention([1.0 - x, y]).ok()?);
        }
        Some((inward, criteria))
    }

    fn bits(&self) -> [u64; 12] {
        let mut bits = [0; 12];
        bits.iter_mut().zip(self.0.as_flattened()).for_each(|(bits, x)| *bits = x.to_bits());
        bits
    }
}

/// The transforms of all parts of a model.
#[derive(Debug, Clone)]
pub(crate) struct Places {
    /// The distinct, non-empty lists of transforms.
    pub(crate) lists: Vec<Arc<[Place]>>,
    /// The index of the list of each part.
    pub(crate) of_part: Vec<usize>,
    /// Why the nodes of the model could not be evaluated; `None` if they could.
    pub(crate) problem: Option<String>,
}

impl Places {
    /// Gives all parts the identity transform.
    pub(crate) fn one(part_count: usize) -> Self {
        Self { lists: vec![Arc::new([Place::IDENTITY])], of_part: vec![0; part_count], problem: None }
    }

    /// Returns the transforms with which the nodes of a model's scene show its parts.
    pub(crate) fn of(model: &Model) -> Self {
        let part_count = model.parts.len();
        let Some(scene) = &model.scene else { return Self::one(part_count) };
        let placements = match scene.placements() {
            Ok(placements) => placements,
            Err(error) => return Self { problem: Some(error.to_string()), ..Self::one(part_count) },
        };
        // 1. The transforms of each range of parts. Ranges do not overlap.
        let mut ranges = HashMap::new();
        let mut found: Vec<(std::ops::Range<usize>, Vec<Place>)> = Vec::new();
        for placement in placements {
            let range = *ranges.entry(placement.parts.start).or_insert(found.len());
            if range == found.len() {
                found.push((placement.parts, Vec::new()));
            }
            found[range].1.push(Place::new(placement.transform));
        }
        // 2. Merge equal lists.
        let mut lists: Vec<Arc<[Place]>> = vec![Arc::new([Place::IDENTITY])];
        let mut known = HashMap::from([(vec![Place::IDENTITY.bits()], 0)]);
        let mut of_part = vec![0; part_count];
        for (parts, mut places) in found {
            places.sort_by_key(Place::bits);
            places.dedup_by_key(|place| place.bits());
            let list = *known.entry(places.iter().map(Place::bits).collect()).or_insert_with(|| {
                lists.push(places.into());
                lists.len() - 1
            });
            of_part[parts].fill(list);
        }
        Self { lists, of_part, problem: None }
    }

    /// Returns a note if the nodes could not be evaluated.
    pub(crate) fn note(&self) -> Option<String> {
        let problem = self.problem.as_ref()?;
        Some(format!(
            "the nodes of the scene cannot be evaluated, parts are compared in their own coordinates: {problem}"
        ))
    }
}

#[cfg(test)]
mod tests {
    use tristrip::lod::Foveation;

    use super::*;

    #[test]
    fn the_scale_is_the_largest_singular_value() {
        let of = |m: [[f64; 3]; 3]| Place::new(m.map(|[a, b, c]| [a, b, c, 7.0])).scale();
        let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        near(of([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), 1.0);
        near(of([[0.0, -10.0, 0.0], [10.0, 0.0, 0.0], [0.0, 0.0, 10.0]]), 10.0);
        near(of([[0.6, -1.6, 0.0], [0.8, 1.2, 0.0], [0.0, 0.0, 0.5]]), 2.0);
        near(of([[0.0; 3]; 3]), 0.0);
        // A shear. The golden ratio is its largest singular value.
        near(of([[1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), f64::midpoint(1.0, 5.0_f64.sqrt()));
        near(of([[1e31, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), 1.0);
    }

    #[test]
    fn a_camera_is_seen_from_a_turned_and_scaled_part() {
        let camera = Camera::new([7.0, 2.0, 0.0], [7.0, 0.0, 0.0]).unwrap().with_up([1.0, 0.0, 0.0]).unwrap();
        // Scale by 2, rotate by 90° about z, and translate along x.
        let place = Place::new([[0.0, -2.0, 0.0, 7.0], [2.0, 0.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0]]);
        let criteria = ViewCriteria::default().with_light([0.0, 3.0, 0.0]);
        let (inward, lit) = place.inward(&camera, &criteria).unwrap();
        assert_eq!(lit.light, Some([1.5, 0.0, 0.0]));
        assert_eq!(
            (inward.eye(), inward.look_at(), inward.up()),
            ([1.0, 0.0, 0.0], [0.0; 3], [0.0, -0.5, 0.0])
        );
        assert_eq!(Place::IDENTITY.inward(&camera, &criteria), Some((camera, criteria)));
        // In a mirrored part, the attention stays at the same position.
        let left = Foveation::new(1.0).unwrap().with_attention([0.25, 0.125]).unwrap();
        let criteria = criteria.with_foveation(left);
        let attention = |place: &Place| {
            let (_, criteria) = place.inward(&camera, &criteria)?;
            criteria.foveation.map(|foveation| foveation.attention())
        };
        assert_eq!(attention(&place), Some([0.25, 0.125]));
        let mirror = Place::new([[-2.0, 0.0, 0.0, 7.0], [0.0, 2.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0]]);
        assert_eq!(attention(&mirror), Some([0.75, 0.125]));
        for m in [[1.0, 1.0, 2.0], [0.0; 3]] {
            let place = Place::new([0, 1, 2].map(|i| [0, 1, 2, 3].map(|k| if k == i { m[i] } else { 0.0 })));
            assert_eq!(place.inward(&camera, &criteria), None, "{m:?}");
        }
    }

    #[test]
    fn parts_of_one_mesh_share_their_places() {
        let json = r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":1,"scale":[2,2,2]},{"mesh":1,"scale":[2,2,2]},
            {"mesh":0,"scale":[2,2,2]},{"mesh":2}],"meshes":[
            {"primitives":[{"attributes":{"POSITION":0}}]},
            {"primitives":[{"attributes":{"POSITION":0}},{"attributes":{"POSITION":0}}]},
            {"primitives":[{"attributes":{"POSITION":0}}]},{"primitives":[{"attributes":{"POSITION":0}}]}],
            "accessors":[{"componentType":5126,"count":3,"type":"VEC3"}]}"#;
        let model = tristrip_io::read(json.as_bytes(), tristrip_io::Format::Glb).unwrap();
        let places = Places::of(&model);
        assert_eq!(places.of_part, [1, 1, 1, 0, 0], "mesh 3 is not shown");
        assert_eq!(places.lists.iter().map(|list| list.len()).collect::<Vec<_>>(), [1, 1]);
        assert_eq!(
            places.lists[1][0].at([1.0, 2.0, 3.0]).map(f64::to_bits),
            [2.0_f64, 4.0, 6.0].map(f64::to_bits)
        );
        let twice = json.replace(r#"{"mesh":2}"#, r#"{"children":[0]},{"children":[0]}"#);
        let model = tristrip_io::read(twice.as_bytes(), tristrip_io::Format::Glb).unwrap();
        let places = Places::of(&model);
        assert!(places.note().unwrap().contains("two parents") && places.of_part == [0; 5]);
    }
}
