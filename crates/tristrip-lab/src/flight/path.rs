//! Paths of a camera: around a model, towards it, over it, or through cameras of a file.

use std::str::FromStr;

use serde::Deserialize;
use tristrip::lod::{Camera, View};

use crate::error::Error;

/// The most frames of a flight.
pub const MAX_FRAMES: usize = 100_000;
/// The most cameras of a file.
const MAX_CAMERAS: usize = 10_000;
/// The tangent of the angle from which an orbit and a dolly look down: 20 degrees.
const ELEVATION: f64 = 0.364;
/// The share of the image that a model in orbit fills.
const FILLED: f64 = 0.92;
/// The slices of a model, and the points of their rings, by which the distance of an orbit is determined.
const SLICES: usize = 64;
const ANGLES: usize = 64;
/// The distance from which a dolly begins, in distances at which the model fills the image.
const FAR: f64 = 20.0;
/// The share of the way from the box to that distance at which it ends.
const CLOSE: f64 = 0.1;
/// The height of a flyover above the box, how far ahead and how far down it looks, in lengths of the box.
const HEIGHT: f64 = 0.03;
const AHEAD: f64 = 0.25;
const DOWN: f64 = 0.06;

/// An axis of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Axis {
    /// The first coordinate.
    X,
    /// The second coordinate.
    Y,
    /// The third coordinate.
    Z,
}

impl Axis {
    /// All axes.
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// Returns the name: `x`, `y` or `z`.
    ///
    /// ```
    /// assert_eq!(tristrip_lab::flight::Axis::ALL.map(|axis| axis.name()), ["x", "y", "z"]);
    /// ```
    pub fn name(self) -> &'static str {
        ["x", "y", "z"][self as usize]
    }

    /// Returns a line on the axis.
    ///
    /// ```
    /// assert_eq!(tristrip_lab::flight::Axis::Y.summary(), "The second coordinate");
    /// ```
    pub fn summary(self) -> &'static str {
        ["The first coordinate", "The second coordinate", "The third coordinate"][self as usize]
    }

    fn direction(self) -> [f64; 3] {
        [0, 1, 2].map(|k| if k == self as usize { 1.0 } else { 0.0 })
    }
}

impl FromStr for Axis {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let axis = Self::ALL.into_iter().find(|axis| axis.name() == text);
        axis.ok_or_else(|| format!("found `{text}`, expected x, y or z"))
    }
}

/// The image of a camera: its vertical angle and its size.
///
/// ```
/// use tristrip_lab::flight::Lens;
/// assert_eq!(Lens::default(), Lens { field_of_view: 45.0, image: [1920, 1080] });
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    /// The vertical angle in degrees, between 0 and 180.
    pub field_of_view: f32,
    /// The columns and rows in pixels.
    pub image: [u32; 2],
}

impl Default for Lens {
    fn default() -> Self {
        Self { field_of_view: View::FIELD_OF_VIEW, image: [1920, 1080] }
    }
}

impl Lens {
    /// Checks the angle and the size.
    ///
    /// # Errors
    /// The angle is not between 0 and 180 degrees, or a size is 0.
    ///
    /// ```
    /// use tristrip_lab::flight::Lens;
    /// assert!(Lens { field_of_view: 0.0, ..Lens::default() }.check().is_err());
    /// ```
    pub fn check(self) -> Result<(), Error> {
        self.camera([0.0; 3], [1.0; 3], upward())?;
        Ok(())
    }

    /// Returns the tangents of half of the horizontal and of the vertical angle.
    fn tangents(self) -> [f64; 2] {
        let vertical = libm::tan(f64::from(self.field_of_view).to_radians() / 2.0);
        [vertical * f64::from(self.image[0]) / f64::from(self.image[1]), vertical]
    }

    /// Returns a camera with this image.
    fn camera(self, eye: [f64; 3], look_at: [f64; 3], up: [f64; 3]) -> Result<Camera, tristrip::Error> {
        let point = |p: [f64; 3]| p.map(|x| x as f32);
        let [columns, rows] = self.image;
        Camera::new(point(eye), point(look_at))?
            .with_up(point(up))?
            .with_field_of_view(self.field_of_view)?
            .with_image(columns, rows)
    }
}

/// A path of a camera, which gives any number of frames.
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
struct Stop {
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
    /// Returns one turn around a model, at the distance at which it fills the image, seen from 20 degrees above.
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

    /// Returns a way straight towards a model, from far away until close to it. Each frame shortens the distance by the same factor.
    ///
    /// # Errors
    /// As of [`FlightPath::orbit`].
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

    /// Returns a way low over a model such as a terrain, along the longest side of its bounding box. Without an axis, its shortest side is vertical.
    ///
    /// # Errors
    /// As of [`FlightPath::orbit`].
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

    /// Reads a path through cameras from JSON: an array of at least one object with `eye` and `look_at`, and, if wanted, `up` and the vertical angle
    /// `field_of_view` in degrees. The cameras are at equal distances in time.
    ///
    /// # Errors
    /// The text is no such array, or a camera is not valid.
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

    /// Returns the cameras of a number of frames, with the image of a lens. The last frame of an orbit is the one before the first.
    ///
    /// # Errors
    /// The number is 0 or more than [`MAX_FRAMES`], the lens is not valid, or a camera between two of a file has no direction.
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
        // Errors of the lens alone are not those of a frame.
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
    fn camera(&self, lens: Lens) -> Result<Camera, tristrip::Error> {
        let field_of_view = self.field_of_view.map_or(lens.field_of_view, |degrees| degrees as f32);
        Lens { field_of_view, ..lens }.camera(self.eye, self.look_at, self.up)
    }

    /// Returns the camera at a share of the way to another one.
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

/// Returns the direction of length 1 from a model to the eye at a share of a turn. It begins at the axis before the vertical one in the order of x, y, z,
/// which is the front for a vertical y axis: z.
fn towards(up: Axis, turn: f64) -> [f64; 3] {
    let up = up as usize;
    let angle = std::f64::consts::TAU * turn;
    let mut direction = [0.0; 3];
    direction[(up + 1) % 3] = libm::cos(angle);
    direction[(up + 2) % 3] = libm::sin(angle);
    direction[up] = ELEVATION;
    let length = (1.0 + ELEVATION * ELEVATION).sqrt();
    direction.map(|x| x / length)
}

/// The bounding box of a model.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Bounds {
    low: [f64; 3],
    high: [f64; 3],
}

impl Bounds {
    /// Returns the bounding box of positions; one without extent is as large as 1.
    fn of(positions: &[[f32; 3]]) -> Result<Self, Error> {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for (vertex, position) in positions.iter().enumerate() {
            if !position.iter().all(|x| x.is_finite()) {
                let expected = "expected finite coordinates";
                return Err(Error::Data(format!("vertex {vertex}: found {position:?}, {expected}")));
            }
            for axis in 0..3 {
                low[axis] = low[axis].min(position[axis].into());
                high[axis] = high[axis].max(position[axis].into());
            }
        }
        if positions.is_empty() {
            return Err(Error::Data("positions: found none, expected a model to fly around".into()));
        }
        if (0..3).all(|axis| low[axis] >= high[axis]) {
            (low, high) = (low.map(|x| x - 0.5), high.map(|x| x + 0.5));
        }
        Ok(Self { low, high })
    }

    fn center(&self) -> [f64; 3] {
        [0, 1, 2].map(|k| self.low[k] / 2.0 + self.high[k] / 2.0)
    }

    fn side(&self, axis: Axis) -> f64 {
        self.high[axis as usize] - self.low[axis as usize]
    }

    /// Returns a point in a direction from the center.
    fn beyond(&self, direction: [f64; 3], distance: f64) -> [f64; 3] {
        let center = self.center();
        [0, 1, 2].map(|k| center[k] + distance * direction[k])
    }

    /// Returns the distance from the center to the surface of the box in a direction.
    fn way_out(&self, direction: [f64; 3]) -> f64 {
        let ways = (0..3).filter(|&k| direction[k] != 0.0);
        let way = |k: usize| (self.high[k] - self.low[k]) / 2.0 / direction[k].abs();
        ways.map(way).fold(f64::INFINITY, f64::min)
    }

    /// Returns the eye and what it looks at on the way over the box, at a share of the way.
    fn over(&self, up: Axis, share: f64) -> [[f64; 3]; 2] {
        let others = Axis::ALL.into_iter().filter(|&axis| axis != up);
        let along = others.max_by(|&a, &b| self.side(a).total_cmp(&self.side(b))).unwrap_or(Axis::X);
        let length = self.side(along).max(self.side(up));
        let (up, along) = (up as usize, along as usize);
        let mut eye = self.center();
        eye[up] = self.high[up] + HEIGHT * length;
        // From a little before the box until what is ahead ends.
        let (first, last) = (self.low[along] - 0.05 * length, self.high[along] - 0.15 * length);
        eye[along] = first + share * (last - first);
        let mut look_at = eye;
        look_at[along] += AHEAD * length;
        look_at[up] -= DOWN * length;
        [eye, look_at]
    }
}

/// The outline of a model that turns around its vertical axis: a few of its widest points.
///
/// ```text
///      up                    ring: the height over the center, and the distance from the axis
///       │   ●
///       │  ●     ● eye       a ring at a height over the axis of the view, and at a depth towards the eye, is inside
///   ────┼────●───            at a distance of height / tangent + depth
///       │   ●
/// ```
#[derive(Debug, Clone, PartialEq)]
struct Rings {
    up: Axis,
    /// Heights and distances.
    points: Vec<[f64; 2]>,
}

impl Rings {
    /// Returns the widest point of each of some slices of a model.
    #[allow(clippy::cast_sign_loss, reason = "positions are above the lowest one")]
    fn of(positions: &[[f32; 3]], up: Axis) -> Result<Self, Error> {
        let bounds = Bounds::of(positions)?;
        let (center, side) = (bounds.center(), bounds.side(up));
        let mut widest: [Option<[f64; 2]>; SLICES + 1] = [None; SLICES + 1];
        for position in positions {
            let from_center = [0, 1, 2].map(|k| f64::from(position[k]) - center[k]);
            let across = [1, 2].map(|step| from_center[(up as usize + step) % 3]);
            let radius = (across[0] * across[0] + across[1] * across[1]).sqrt();
            let height = from_center[up as usize];
            let share = if side > 0.0 { height / side + 0.5 } else { 0.0 };
            let slice = &mut widest[((share * SLICES as f64) as usize).min(SLICES)];
            if slice.is_none_or(|[_, widest]| radius > widest) {
                *slice = Some([height, radius]);
            }
        }
        let mut points: Vec<[f64; 2]> = widest.into_iter().flatten().collect();
        if points.iter().all(|&[height, radius]| height == 0.0 && radius == 0.0) {
            // A model without extent.
            points.push([0.0, 0.5]);
        }
        Ok(Self { up, points })
    }

    /// Returns the least distance from the center at which the camera of an orbit sees all rings.
    fn filling_distance(&self, lens: Lens) -> f64 {
        let tangents = lens.tangents().map(|tangent| FILLED * tangent);
        let length = (1.0 + ELEVATION * ELEVATION).sqrt();
        let (sine, cosine) = (ELEVATION / length, 1.0 / length);
        let mut distance = 0.0_f64;
        for angle in 0..ANGLES {
            let angle = std::f64::consts::TAU * angle as f64 / ANGLES as f64;
            for [height, radius] in &self.points {
                let (front, right) = (radius * libm::cos(angle), radius * libm::sin(angle));
                let depth = front * cosine + height * sine;
                let upward = height * cosine - front * sine;
                distance = distance.max(depth + right.abs() / tangents[0]);
                distance = distance.max(depth + upward.abs() / tangents[1]);
            }
        }
        distance
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
        // Halfway the camera stands in what it looks at.
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
