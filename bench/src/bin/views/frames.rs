//! The frames of a flight, with the camera data that programs other than
//! [`SkipView`](tristrip::lod::SkipView) need.

use tristrip::Mesh;
use tristrip::lod::Camera;

/// A point or direction.
pub(super) type Point = [f64; 3];

/// A frame of a flight.
#[derive(Debug, Clone)]
pub(super) struct Frame {
    pub(super) camera: Camera,
    /// Whether the frame is proven and counted.
    pub(super) is_sample: bool,
    /// The number of triangles of the Skip Strips view.
    pub(super) triangle_count: usize,
    pub(super) eye: Point,
    /// The inward normals of the planes through the eye that bound the view: four sides, and the
    /// view direction.
    planes: [Point; 5],
    /// The number of pixels that a unit length covers at unit distance.
    pub(super) pixels_per_slope: f64,
    /// The distance of the nearest vertex of the full mesh in the image; `None` if there is none.
    pub(super) nearest: Option<f64>,
}

impl Frame {
    /// Creates the frame of a camera. It uses the same planes and scale as
    /// [`tristrip::lod::ViewCriteria`].
    pub(super) fn new(camera: Camera, mesh: &Mesh, is_sample: bool, triangle_count: usize) -> Self {
        let [right, up, forward] = camera.axes();
        let half_height = (f64::from(camera.field_of_view()).to_radians() / 2.0).tan();
        let [columns, rows] = camera.image().map(f64::from);
        let half_width = half_height * columns / rows;
        // Inward from the right, left, top and bottom of the image.
        let sides = [
            (half_width, right, -1.0),
            (half_width, right, 1.0),
            (half_height, up, -1.0),
            (half_height, up, 1.0),
        ];
        let plane = |(half, across, sign): (f64, Point, f64)| {
            unit([0, 1, 2].map(|k| half * forward[k] + sign * across[k]))
        };
        let [a, b, c, d] = sides.map(plane);
        let eye = camera.eye().map(f64::from);
        let pixels_per_slope = rows / (2.0 * half_height);
        let planes = [a, b, c, d, forward];
        let mut frame =
            Self { camera, is_sample, triangle_count, eye, planes, pixels_per_slope, nearest: None };
        let seen = mesh.positions().iter().filter(|&&position| frame.sees(position, 0.0));
        let nearest = seen.map(|&position| frame.distance(position)).min_by(f64::total_cmp);
        frame.nearest = nearest;
        frame
    }

    /// Checks whether a sphere is at least partly inside every plane.
    pub(super) fn sees(&self, center: [f32; 3], radius: f32) -> bool {
        let away = sub(center.map(f64::from), self.eye);
        self.planes.iter().all(|&plane| dot(plane, away) + f64::from(radius) >= 0.0)
    }

    /// Returns the distance of a point from the eye.
    pub(super) fn distance(&self, point: [f32; 3]) -> f64 {
        let away = sub(point.map(f64::from), self.eye);
        dot(away, away).sqrt()
    }

    /// Returns the number of pixels that a length covers at the nearest vertex in the image; 0 if
    /// there is none.
    pub(super) fn pixels_at_nearest(&self, length: f64) -> f64 {
        self.nearest.map_or(0.0, |distance| length * self.pixels_per_slope / distance)
    }
}

pub(super) fn sub(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|k| a[k] - b[k])
}

pub(super) fn dot(a: Point, b: Point) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

pub(super) fn cross(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|k| a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3])
}

fn unit(a: Point) -> Point {
    let length = dot(a, a).sqrt();
    a.map(|x| x / length)
}

#[cfg(test)]
mod tests {
    use tristrip::Faces;

    use super::*;

    /// A square of 90° around the z axis, seen from the origin.
    #[test]
    fn a_frame_sees_what_is_within_its_planes() {
        let camera = Camera::new([0.0; 3], [0.0, 0.0, 1.0]).unwrap();
        let camera = camera.with_field_of_view(90.0).unwrap().with_image(100, 100).unwrap();
        let corners = vec![[0.0, 0.0, -1.0], [5.0, 0.0, 4.0], [0.0, 3.0, 4.0]];
        let mesh = Mesh::new(corners, Faces::from_triangles(vec![0, 1, 2]).unwrap()).unwrap();
        let frame = Frame::new(camera, &mesh, true, 1);
        assert!(frame.sees([0.9, -0.9, 1.0], 0.0) && !frame.sees([1.1, 0.0, 1.0], 0.0));
        // The plane at 45° is 0.2 / √2 away.
        assert!(frame.sees([1.2, 0.0, 1.0], 0.15) && !frame.sees([1.2, 0.0, 1.0], 0.14));
        assert!(!frame.sees([0.0, 0.0, -1.0], 0.5));
        // Only the third vertex is in the image. 50 pixels cover its distance.
        assert_eq!(frame.nearest, Some(5.0));
        assert!((frame.pixels_at_nearest(0.1) - 1.0).abs() < 1e-9);
    }
}
