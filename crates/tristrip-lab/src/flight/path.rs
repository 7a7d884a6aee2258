//! Camera paths: around a model, toward it, over it, or through the cameras of a file.

use serde::Deserialize;
use tristrip::lod::Camera;

use super::extent::{Bounds, Rings, towards};
use super::lens::{Axis, Lens};
use crate::error::Error;

/// The maximum number of frames of a flight.
pub const MAX_FRAMES: usize = 100_000;
/// The maximum number of cameras of a file.
const MAX_CAMERAS: usize = 10_000;
/// The start distance of a dolly, relative to the distance at which the model fills the image.
const FAR: f64 = 20.0;
/// The end distance of a dolly, as a fraction of the way from the surface of the box to the
/// distance at which the model fills the image.
const CLOSE: f64 = 0.1;
/// A camera path, which can be sampled with any number of frames.
///
/// ```
/// use tristrip_lab::flight::{Axis, FlightPath, Lens};
/// let path = FlightPath::orbit(&[[-1.0, 0.0, -1.0], [1.0, 1.0, 1.0]], Axis::Y)?;
/// let cameras = path.cameras(120, Lens::default())?;
/// assert_eq!((cameras.len(), cameras[7].look_at()), (120, [0.0, 0.5, 0.0]));
/// # Ok::<(), tristrip_lab::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct FlightPath(Kind);

#[derive(Debug, Clone, PartialEq)]
enum Kind {
    Orbit(Bounds, Rings),
    Dolly(Bounds, Rings),
    Flyover(Bounds, Axis),
    Through(Vec<Stop>),
}

/// A camera of a file.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Stop {
    eye: [f64; 3],
    look_at: [f64; 3],
    #[serde(default = "upward")]
    up: [f64; 3],
    field_of_view: Option<f64>,
}

fn upward() -> [f64; 3] {
    Axis::Y.direction()
}

impl FlightPath {
    /// Returns one turn around a model, at the distance where it fills the image, seen from 20°
    /// above.
    ///
    /// # Errors
    /// There are no positions, or one is not finite.
    ///
    /// ```
    /// use tristrip_lab::flight::{Axis, FlightPath};
    /// assert!(FlightPath::orbit(&[], Axis::Y).is_err());
    /// ```
    pub fn orbit(positions: &[[f32; 3]], up: Axis) -> Result<Self, Error> {
        Ok(Self(Kind::Orbit(Bounds::of(positions)?, Rings::of(positions, up)?)))
    }

    /// Returns a straight path toward a model, from far away to close up. Each frame reduces the
    /// distance by the same factor.
    ///
    /// # Errors
    /// There are no positions, or one is not finite.
    ///
    /// ```
    /// use tristrip_lab::flight::{Axis, FlightPath, Lens};
    /// let path = FlightPath::dolly(&[[-1.0; 3], [1.0; 3]], Axis::Y)?;
    /// let cameras = path.cameras(3, Lens::default())?;
    /// assert!(cameras[0].eye()[2] > 10.0 * cameras[2].eye()[2]);
    /// # Ok::<(), tristrip_lab::Error>(())
    /// ```
    pub fn dolly(positions: &[[f32; 3]], up: Axis) -> Result<Self, Error> {
        Ok(Self(Kind::Dolly(Bounds::of(positions)?, Rings::of(positions, up)?)))
    }

    /// Returns a low path over a model such as a terrain, along the longest side of its bounding
    /// box. Without an axis, its shortest side is vertical.
    ///
    /// # Errors
    /// There are no positions, or one is not finite.
    ///
    /// ```
    /// use tristrip_lab::flight::{FlightPath, Lens};
    /// let cameras = FlightPath::flyover(&[[0.0; 3], [9.0, 5.0, 1.0]], None)?.cameras(2, Lens::default())?;
    /// assert!(cameras.iter().all(|camera| camera.up() == [0.0, 0.0, 1.0] && camera.eye()[2] > 1.0));
    /// # Ok::<(), tristrip_lab::Error>(())
    /// ```
    pub fn flyover(positions: &[[f32; 3]], up: Option<Axis>) -> Result<Self, Error> {
        let bounds = Bounds::of(positions)?;
        let shortest = Axis::ALL.into_iter().min_by(|&a, &b| bounds.side(a).total_cmp(&bounds.side(b)));
        Ok(Self(Kind::Flyover(bounds, up.or(shortest).unwrap_or(Axis::Y))))
    }

    /// Parses a path through cameras from JSON: a non-empty array of objects with `eye` and
    /// `look_at`, and optionally `up` and the vertical field of view `field_of_view` in degrees.
    /// The cameras are equally spaced in time.
    ///
    /// # Errors
    /// The text is not such an array, or a camera is invalid.
    ///
    /// ```
    /// use tristrip_lab::flight::{FlightPath, Lens};
    /// let path = FlightPath::from_json(r#"[{"eye": [0, 0, 9], "look_at": [0, 0, 0]}, {"eye": [0, 0, 3], "look_at": [0, 0, 0]}]"#)?;
    /// assert_eq!(path.cameras(3, Lens::default())?[1].eye(), [0.0, 0.0, 6.0]);
    /// assert!(FlightPath::from_json("[]").is_err());
    /// # Ok::<(), tristrip_lab::Error>(())
    /// ```
    pub fn from_json(text: &str) -> Result<Self, Error> {
        let stops: Vec<Stop> = serde_json::from_str(text).map_err(|error| Error::Data(error.to_string()))?;
        if !(1..=MAX_CAMERAS).contains(&stops.len()) {
            let found = stops.len();
            return Err(Error::Data(format!("cameras: found {found}, expected 1 to {MAX_CAMERAS}")));
        }
        for (number, stop) in stops.iter().enumerate() {
            let camera = stop.camera(Lens::default());
            camera.map_err(|error| Error::Data(format!("camera {number}: {error}")))?;
        }
        Ok(Self(Kind::Through(stops)))
    }

    /// Returns the cameras of `frame_count` frames, with a lens. The last frame of an orbit is one
    /// step before the first.
    ///
    /// # Errors
    /// The number of frames is 0 or exceeds [`MAX_FRAMES`], the lens is invalid, or a camera
    /// between two cameras of a file has no direction.
    ///
    /// ```
    /// use tristrip_lab::flight::{Axis, FlightPath, Lens};
    /// let path = FlightPath::orbit(&[[-1.0; 3], [1.0; 3]], Axis::Y)?;
    /// assert!(path.cameras(0, Lens::default()).is_err());
    /// assert!(path.cameras(9, Lens { field_of_view: f32::NAN, ..Lens::default() }).is_err());
    /// # Ok::<(), tristrip_lab::Error>(())
    /// ```
    pub fn cameras(&self, frame_count: usize, lens: Lens) -> Result<Vec<Camera>, Error> {
        if !(1..=MAX_FRAMES).contains(&frame_count) {
            return Err(Error::Data(format!("frames: found {frame_count}, expected 1 to {MAX_FRAMES}")));
        }
        // Check the lens first, because its errors do not belong to a frame.
        lens.check()?;
        let share = |frame: usize| frame as f64 / (frame_count - 1).max(1) as f64;
        let camera: Box<dyn Fn(usize) -> Result<Camera, tristrip::Error> + '_> = match &self.0 {
            Kind::Orbit(bounds, rings) => {
                let (up, distance) = (rings.up, rings.filling_distance(lens));
                Box::new(move |frame| {
                    let towards = towards(up, frame as f64 / frame_count as f64);
                    lens.camera(bounds.beyond(towards, distance), bounds.center(), up.direction())
                })
            }
            Kind::Dolly(bounds, rings) => {
                let (up, filling) = (rings.up, rings.filling_distance(lens));
                let towards = towards(up, 0.0);
                let surface = bounds.way_out(towards);
                let (far, close) = (FAR * filling, surface + CLOSE * (filling - surface).max(0.0));
                Box::new(move |frame| {
                    let distance = far * libm::pow(close / far, share(frame));
                    lens.camera(bounds.beyond(towards, distance), bounds.center(), up.direction())
                })
            }
            Kind::Flyover(bounds, up) => Box::new(move |frame| {
                let [eye, look_at] = bounds.over(*up, share(frame));
                lens.camera(eye, look_at, up.direction())
            }),
            Kind::Through(stops) => Box::new(move |frame| {
                let ways = stops.len() - 1;
                let frames = (frame_count - 1).max(1);
                let (first, rest) = (frame * ways / frames, frame * ways % frames);
                let second = (first + 1).min(ways);
                stops[first].towards(&stops[second], rest as f64 / frames as f64, lens).camera(lens)
            }),
        };
        let numbered = |frame| camera(frame).map_err(|error| Error::Data(format!("frame {frame}: {error}")));
        (0..frame_count).map(numbered).collect()
    }
}

impl Stop {
    /// Returns the camera with a lens.
    pub(crate) fn camera(&self, lens: Lens) -> Result<Camera, tristrip::Error> {
        let field_of_view = self.field_of_view.map_or(lens.field_of_view, |degrees| degrees as f32);
        Lens { field_of_view, ..lens }.camera(self.eye, self.look_at, self.up)
    }

    /// Returns the camera at a fraction of the way to another one.
    fn towards(&self, other: &Self, share: f64, lens: Lens) -> Self {
        let mix = |a: f64, b: f64| a + share * (b - a);
        let mixed = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|k| mix(a[k], b[k]));
        let angle = |stop: &Self| stop.field_of_view.unwrap_or(lens.field_of_view.into());
        Self {
            eye: mixed(self.eye, other.eye),
            look_at: mixed(self.look_at, other.look_at),
            up: mixed(self.up, other.up),
            field_of_view: Some(mix(angle(self), angle(other))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: [[f32; 3]; 2] = [[-1.0, 0.0, -3.0], [1.0, 1.5, 3.0]];

    #[test]
    fn an_orbit_sees_all_of_the_model_and_comes_around() {
        for (up, image) in [(Axis::Y, [640, 480]), (Axis::Z, [200, 800]), (Axis::X, [1920, 1080])] {
            let lens = Lens { image, ..Lens::default() };
            let cameras = FlightPath::orbit(&BOX, up).unwrap().cameras(90, lens).unwrap();
            let tangents = lens.tangents();
            let mut widest = 0.0_f64;
            for camera in &cameras {
                let [right, upward, forward] = camera.axes();
                for corner in 0..8 {
                    let corner = [0, 1, 2].map(|k| f64::from(BOX[corner >> k & 1][k] - camera.eye()[k]));
                    let dot = |a: [f64; 3]| a[0] * corner[0] + a[1] * corner[1] + a[2] * corner[2];
                    let depth = dot(forward);
                    widest = widest.max(dot(right).abs() / depth / tangents[0]);
                    widest = widest.max(dot(upward).abs() / depth / tangents[1]);
                }
            }
            assert!((0.9..0.93).contains(&widest), "{up:?}: {widest}");
            let step = |a: &Camera, b: &Camera| {
                (0..3).map(|k| f64::from(a.eye()[k] - b.eye()[k]).powi(2)).sum::<f64>().sqrt()
            };
            let (first, last) = (step(&cameras[0], &cameras[1]), step(&cameras[89], &cameras[0]));
            assert!((first - last).abs() < 1e-3 * first, "the last step leads to the first frame");
        }
        assert!(
            FlightPath::orbit(&BOX, Axis::Y).unwrap().cameras(1, Lens::default()).unwrap()[0].eye()[2] > 3.0
        );
    }

    #[test]
    fn a_dolly_ends_outside_of_the_box() {
        let cameras = FlightPath::dolly(&BOX, Axis::Y).unwrap().cameras(50, Lens::default()).unwrap();
        let heights: Vec<f32> = cameras.iter().map(|camera| camera.eye()[2]).collect();
        assert!(heights.windows(2).all(|pair| pair[1] < pair[0]));
        let last = cameras[49].eye();
        assert!((last[2] > 3.0 || last[1] > 1.5) && heights[0] > 10.0 * last[2], "{last:?}");
    }

    #[test]
    fn a_flyover_goes_along_the_longest_side() {
        let cameras = FlightPath::flyover(&BOX, None).unwrap().cameras(9, Lens::default()).unwrap();
        assert!(cameras.windows(2).all(|pair| pair[0].eye()[2] < pair[1].eye()[2]));
        assert!(cameras.iter().all(|camera| camera.eye()[1] > 1.5 && camera.look_at()[2] > camera.eye()[2]));
    }

    #[test]
    fn files_of_cameras_are_checked() {
        let say = |text: &str| FlightPath::from_json(text).unwrap_err().to_string();
        assert!(say("{}").contains("expected a sequence"), "{}", say("{}"));
        assert_eq!(say("[]"), "cameras: found 0, expected 1 to 10000");
        let still = r#"[{"eye": [1, 1, 1], "look_at": [1, 1, 1]}]"#;
        assert!(say(still).starts_with("camera 0: parameter `look_at`: found"), "{}", say(still));
        let far = r#"[{"eye": [1e300, 1, 1], "look_at": [1, 1, 1]}]"#;
        assert!(say(far).starts_with("camera 0: parameter `eye`: found"), "{}", say(far));
        assert!(say(r#"[{"eye": [0, 0], "look_at": [1, 1, 1]}]"#).contains("line 1"));
        let narrow = r#"[{"eye": [0, 0, 0], "look_at": [1, 1, 1], "field_of_view": 0}]"#;
        assert!(say(narrow).contains("`field_of_view`: found 0"), "{}", say(narrow));
        // Halfway, the camera is at the point that it looks at.
        let through =
            r#"[{"eye": [0, 0, 0], "look_at": [2, 0, 0]}, {"eye": [2, 0, 0], "look_at": [0, 0, 0]}]"#;
        let cameras = FlightPath::from_json(through).unwrap().cameras(3, Lens::default());
        assert!(cameras.unwrap_err().to_string().starts_with("frame 1: parameter `look_at`"));
    }

    #[test]
    fn models_without_extent_and_far_away_are_no_problem() {
        let point = FlightPath::orbit(&[[7.0; 3]], Axis::Y).unwrap().cameras(4, Lens::default()).unwrap();
        assert_eq!((point[0].look_at(), point[3].look_at()), ([7.0; 3], [7.0; 3]));
        let huge = FlightPath::dolly(&[[f32::MAX; 3], [-f32::MAX; 3]], Axis::Y).unwrap();
        assert!(huge.cameras(4, Lens::default()).is_err());
        assert!(FlightPath::flyover(&[[f32::NAN; 3]], None).is_err());
    }
}
