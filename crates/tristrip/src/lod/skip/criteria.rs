//! The criteria by which a view chooses its detail, and how far the camera may move before a choice
//! can change.
//!
//! The projected error of a collapse is `e s / d` pixels. Here e is the error in mesh units, s is
//! the size in pixels of a unit length at unit distance, and d is the distance from the eye to the
//! nearest point of the sphere of the collapse. The allowed error is the `pixels` of the criteria
//! times a *tolerance*:
//!
//! | where | tolerance |
//! |---|---|
//! | outside the view frustum | any error |
//! | all normals face away from the eye | 4 |
//! | silhouette: a normal may be perpendicular to the view direction | 1/2 |
//! | all normals face away from the light | 2 |
//!
//! Foveation multiplies the tolerance by another factor (module `foveation`).
//!
//! A collapse is split if its error exceeds the allowed error. It is applied if its error is at
//! most a given share of the allowed error, so small camera movements change nothing.
//!
//! # Travel
//! Every change of the camera is reduced to one number, the *travel*. It is the larger of two
//! lengths: the distance that the eye moved, and the largest change of the distance between a
//! frustum plane and a point of the model. A turn of the gaze adds the distance by which it moves
//! the farthest point of the model. A choice depends on the distance of the sphere from the eye and
//! from the frustum planes, on the angle between its normals and the view direction, and on the
//! angle between the sphere and the gaze direction. The travel bounds the change of each of these
//! values. If a collapse does not change, [`Criteria::choose`] returns the travel for which this
//! choice remains valid.
//!
//! # References
//! El-Sana, Evans, Kalaiah, Varshney, Skiena, Azanli 2000, section 5.2.1; Xia, El-Sana, Varshney
//! 1997; Hoppe: *View-Dependent Refinement of Progressive Meshes*, 1997.

use super::bounds::NodeBounds;
use super::camera::CameraFrame;
use super::cone::Facing;
use super::foveation::{Blur, Foveation, Gaze};
use crate::error::Error;
use crate::lod::level::hysteresis::Hysteresis;
use crate::vector::{Point, dot, sub, unit};

const BACK_TOLERANCE: f64 = 4.0;
const SILHOUETTE_TOLERANCE: f64 = 0.5;
const DARK_TOLERANCE: f64 = 2.0;
/// The minimum allowed error in pixels with a triangle budget. The budget scales the allowed error,
/// which would not change an error of 0.
const MIN_PIXELS: f64 = 1e-6;
/// A travel longer than this share of the distance is accepted without computing a better bound.
const SURE_SHARE: f64 = 0.02;

/// The criteria that determine the detail of a view.
///
/// ```
/// use tristrip::lod::ViewCriteria;
/// let criteria = ViewCriteria::default().with_pixels(1.5).with_budget(200_000).with_silhouettes(false);
/// assert_eq!((criteria.pixels, criteria.budget), (1.5, Some(200_000)));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ViewCriteria {
    /// The allowed error in pixels, at least 0.
    pub pixels: f32,
    /// Whether everything outside the view frustum is as coarse as possible.
    pub frustum: bool,
    /// Whether surfaces that face away from the eye may have four times the allowed error.
    pub back_faces: bool,
    /// Whether silhouettes are limited to half the allowed error.
    pub silhouettes: bool,
    /// The direction to a light, of any length; see [`ViewCriteria::with_light`].
    pub light: Option<[f32; 3]>,
    /// The growth of the allowed error away from the point that the user looks at.
    pub foveation: Option<Foveation>,
    /// The maximum number of triangles of a view.
    pub budget: Option<usize>,
    /// The maximum number of collapses and splits per update.
    pub steps: Option<usize>,
    /// The share of the allowed error up to which a collapse is applied. An applied collapse is
    /// kept up to the full allowed error.
    pub hysteresis: Hysteresis,
}

impl Default for ViewCriteria {
    /// Returns criteria that allow an error of one pixel. They take the frustum, back faces and
    /// silhouettes into account. There is no light, foveation, budget or step limit.
    fn default() -> Self {
        Self {
            pixels: 1.0,
            frustum: true,
            back_faces: true,
            silhouettes: true,
            light: None,
            foveation: None,
            budget: None,
            steps: None,
            hysteresis: Hysteresis::default(),
        }
    }
}

impl ViewCriteria {
    crate::setters! {
        /// Sets the allowed error in pixels, at least 0.
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// let camera = Camera::new([4.0, 3.0, 12.0], [4.0, 0.0, 4.0])?.with_image(100, 100)?;
        /// let update = |pixels| model.view().update(&camera, &ViewCriteria::default().with_pixels(pixels));
        /// assert!(update(0.2)?.splits > update(2.0)?.splits);
        /// assert!(update(f32::NAN).is_err());
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_pixels(pixels: f32);

        /// Sets whether everything outside the view frustum is as coarse as possible.
        ///
        /// ```
        /// use tristrip::lod::ViewCriteria;
        /// assert_ne!(ViewCriteria::default().with_frustum(false), ViewCriteria::default());
        /// ```
        with_frustum(frustum: bool);

        /// Sets whether surfaces that face away from the eye may have four times the allowed error.
        ///
        /// ```
        /// use tristrip::lod::ViewCriteria;
        /// assert_ne!(ViewCriteria::default().with_back_faces(false), ViewCriteria::default());
        /// ```
        with_back_faces(back_faces: bool);

        /// Sets whether silhouettes are limited to half the allowed error.
        ///
        /// ```
        /// use tristrip::lod::ViewCriteria;
        /// assert_ne!(ViewCriteria::default().with_silhouettes(false), ViewCriteria::default());
        /// ```
        with_silhouettes(silhouettes: bool);

        /// Sets the direction to a light, of any length. Surfaces that face away from the light may
        /// have twice the allowed error.
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// let camera = Camera::new([4.0, 3.0, 12.0], [4.0, 0.0, 4.0])?.with_image(100, 100)?;
        /// let update = |light| model.view().update(&camera, &ViewCriteria::default().with_light(light));
        /// assert!(update([0.0, 1.0, 0.0]).is_ok() && update([0.0; 3]).is_err());
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_light(light: [f32; 3]) as Some;

        /// Sets how the allowed error grows away from the point of the image that the user looks
        /// at. There is no foveation by default.
        ///
        /// The point may move from frame to frame; an update treats this like a turn of the camera.
        /// If the growth changes, the next update evaluates every collapse.
        ///
        /// ```
        #[doc = include_str!("example.txt")]
        /// let camera = Camera::new([4.0, 3.0, 12.0], [4.0, 0.0, 4.0])?.with_image(100, 100)?;
        /// let triangles = |criteria: ViewCriteria| {
        ///     let mut view = model.view();
        ///     view.update(&camera, &criteria)?;
        ///     Ok::<_, tristrip::Error>(view.triangle_count())
        /// };
        /// let criteria = ViewCriteria::default().with_pixels(0.2);
        /// assert!(triangles(criteria.with_foveation(Foveation::new(0.5)?))? < triangles(criteria)?);
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_foveation(foveation: Foveation) as Some;

        /// Sets the maximum number of triangles of a view. If the allowed error requires more
        /// triangles, the collapses with the largest errors in pixels are split first. The base
        /// mesh may exceed the budget.
        ///
        /// ```
        /// use tristrip::lod::ViewCriteria;
        /// assert_eq!(ViewCriteria::default().with_budget(1000).budget, Some(1000));
        /// ```
        with_budget(budget: usize) as Some;

        /// Sets the maximum number of collapses and splits per update. The next update continues
        /// with the remaining ones. The mesh between two updates is valid.
        ///
        /// ```
        /// use tristrip::lod::ViewCriteria;
        /// assert_eq!(ViewCriteria::default().with_steps(500).steps, Some(500));
        /// ```
        with_steps(steps: usize) as Some;

        /// Sets the share of the allowed error up to which a collapse is applied. An applied
        /// collapse is kept up to the full allowed error.
        ///
        /// ```
        /// use tristrip::lod::{Hysteresis, ViewCriteria};
        /// let criteria = ViewCriteria::default().with_hysteresis(Hysteresis::new(0.5)?);
        /// assert_ne!(criteria, ViewCriteria::default());
        /// # Ok::<(), tristrip::Error>(())
        /// ```
        with_hysteresis(hysteresis: Hysteresis);
    }

    /// Checks the allowed error and the direction to the light.
    /// [`SkipView::update`](super::view::SkipView::update) performs the same check.
    ///
    /// # Errors
    /// The allowed error is negative or NaN, or the direction to the light is zero or not finite.
    ///
    /// ```
    /// use tristrip::lod::ViewCriteria;
    /// assert!(ViewCriteria::default().with_pixels(2.5).check().is_ok());
    /// assert!(ViewCriteria::default().with_pixels(-1.0).check().is_err());
    /// ```
    pub fn check(&self) -> Result<(), Error> {
        if self.pixels.is_nan() || self.pixels < 0.0 {
            let expected = "0 or more";
            return Err(Error::Parameter { name: "pixels", found: self.pixels.to_string(), expected });
        }
        match self.light {
            Some(light) if light.iter().any(|x| !x.is_finite()) || light.iter().all(|&x| x == 0.0) => {
                let found = format!("{light:?}");
                Err(Error::Parameter { name: "light", found, expected: "a direction" })
            }
            _ => Ok(()),
        }
    }
}

/// The criteria of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Criteria {
    frame: CameraFrame,
    /// The allowed error in mesh units per unit of distance, including the scale for a budget.
    slope: f64,
    /// The distances per unit of error from which a collapse is applied, and from which it is kept.
    needed: [f64; 2],
    share: f64,
    has_frustum: bool,
    has_back_faces: bool,
    has_silhouettes: bool,
    light: Option<Point>,
    gaze: Option<Gaze>,
    /// The distance at which a change of the allowed error is counted as travel. At least the
    /// distance of the farthest point of the model.
    far: f64,
    /// The minimum and maximum tolerance of a collapse inside the frustum.
    tolerances: [f64; 2],
}

/// The result of evaluating a collapse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum CollapseChoice {
    /// The collapse must be applied, or split if it is applied. `ratio` is its error divided by the
    /// allowed error.
    Change { ratio: f64 },
    /// The collapse does not change, at least for this travel.
    Stay { travel: f64 },
}

impl Criteria {
    /// Prepares the criteria of a frame, with the allowed pixels multiplied by `scale`, for
    /// distances of up to `far`.
    pub(super) fn new(frame: CameraFrame, criteria: &ViewCriteria, scale: f64, far: f64) -> Self {
        let mut tolerances = [1.0, 1.0];
        if criteria.back_faces {
            tolerances[1] *= BACK_TOLERANCE;
        }
        if criteria.silhouettes {
            tolerances[0] *= SILHOUETTE_TOLERANCE;
        }
        if criteria.light.is_some() {
            tolerances[1] *= DARK_TOLERANCE;
        }
        let gaze = criteria.foveation.and_then(|foveation| Gaze::new(foveation, &frame));
        if let Some(gaze) = &gaze {
            tolerances[1] *= gaze.most();
        }
        let light = criteria.light.map(|direction| {
            let largest = direction.iter().fold(0.0, |most: f32, x| most.max(x.abs()));
            unit(direction.map(|x| f64::from(x) / f64::from(largest)))
        });
        let pixels = f64::from(criteria.pixels);
        let pixels = if criteria.budget.is_some() { pixels.max(MIN_PIXELS) } else { pixels };
        let slope = scale * pixels / frame.pixels_per_slope;
        let share = f64::from(criteria.hysteresis.share());
        Self {
            frame,
            slope,
            needed: [share, 1.0].map(|share| 1.0 / (slope * share)),
            share,
            has_frustum: criteria.frustum,
            has_back_faces: criteria.back_faces,
            has_silhouettes: criteria.silhouettes,
            light,
            gaze,
            far,
            tolerances,
        }
    }

    /// Returns the distance at which a change of the allowed error is counted as travel.
    pub(super) fn far(&self) -> f64 {
        self.far
    }

    /// Returns whether a collapse must change, or the travel for which it does not.
    pub(super) fn choose(&self, node: &NodeBounds, is_collapsed: bool) -> CollapseChoice {
        let away = sub(node.position.map(f64::from), self.frame.eye);
        let distance = dot(away, away).sqrt();
        let radius = f64::from(node.radius);
        let error = f64::from(node.error);
        let state = Looked {
            is_collapsed,
            near: (distance - radius).max(0.0),
            // A collapse without error is not visible.
            needed: if error > 0.0 { error * self.needed[usize::from(is_collapsed)] } else { 0.0 },
            far: self.far,
            blur: Blur::NONE,
        };
        let (inside, outside) = self.depths(away, radius);
        if outside > 0.0 {
            return state.choice(f64::INFINITY, outside);
        }
        // If every tolerance inside the frustum gives the same choice for a long travel, the
        // normals need not be tested.
        let sure = match state.choice(self.tolerances[usize::from(!is_collapsed)], inside) {
            CollapseChoice::Stay { travel } => travel,
            CollapseChoice::Change { .. } => 0.0,
        };
        if sure > SURE_SHARE * state.near {
            return CollapseChoice::Stay { travel: sure };
        }
        let (tolerance, stays) = self.tolerance(node, away, distance, radius);
        let blur = self.gaze.map_or(Blur::NONE, |gaze| gaze.at(away, distance, radius));
        let state = Looked { blur, ..state };
        match state.choice(tolerance, inside.min(stays)) {
            CollapseChoice::Stay { travel } => CollapseChoice::Stay { travel: travel.max(sure) },
            change @ CollapseChoice::Change { .. } => change,
        }
    }

    /// Returns how far a sphere reaches inside all frustum planes, and how far it lies outside one
    /// of them.
    fn depths(&self, away: Point, radius: f64) -> (f64, f64) {
        if !self.has_frustum {
            return (f64::INFINITY, 0.0);
        }
        let (mut inside, mut outside) = (f64::INFINITY, 0.0_f64);
        for plane in &self.frame.planes {
            let depth = dot(*plane, away) + radius;
            inside = inside.min(depth);
            outside = outside.max(-depth);
        }
        (inside, outside)
    }

    /// Returns the tolerance of a collapse for its normals, and the travel within which it is
    /// constant.
    fn tolerance(&self, node: &NodeBounds, away: Point, distance: f64, radius: f64) -> (f64, f64) {
        let (mut tolerance, mut stays) = (1.0, f64::INFINITY);
        if self.has_back_faces || self.has_silhouettes {
            let sine = if distance > 0.0 { radius / distance } else { 1.0 };
            let (facing, turn) = node.cone.facing(away.map(|x| -x), distance, sine);
            match facing {
                Facing::Back if self.has_back_faces => tolerance *= BACK_TOLERANCE,
                Facing::Edge if self.has_silhouettes => tolerance *= SILHOUETTE_TOLERANCE,
                _ => (),
            }
            stays = travel_of(turn, distance, sine);
        }
        if let Some(light) = self.light
            && node.cone.facing(light, 1.0, 0.0).0 == Facing::Back
        {
            tolerance *= DARK_TOLERANCE;
        }
        (tolerance, stays)
    }

    /// Returns the travel since the criteria of an earlier frame, for a model inside a sphere.
    /// Returns `None` if more has changed than the camera, the gaze and the allowed error.
    pub(super) fn travel_from(&self, before: &Self, sphere: (Point, f64)) -> Option<f64> {
        let frame = CameraFrame { pixels_per_slope: self.frame.pixels_per_slope, ..before.frame };
        let gaze = before.gaze;
        if (Self { frame, slope: before.slope, needed: before.needed, gaze, ..*self }) != *before {
            return None;
        }
        let turn = match (&self.gaze, &before.gaze) {
            (Some(now), Some(then)) => now.turn_from(then)?,
            (None, None) => 0.0,
            _ => return None,
        };
        let [way, planes] = self.frame.motion_from(&before.frame, sphere);
        let farthest = self.frame.farthest(sphere).max(before.frame.farthest(sphere));
        let [low, high] =
            if self.slope < before.slope { [self.slope, before.slope] } else { [before.slope, self.slope] };
        let change = if low < high { (high / low - 1.0) * self.far } else { 0.0 };
        // Distances and angles change by at most the path of the eye plus the turn. Distances from
        // planes change by at most the motion of the planes.
        let travel = (way + change + turn * farthest).max(if self.has_frustum { planes } else { 0.0 });
        // Allows for rounding of large coordinates.
        let travel = if travel > 0.0 { travel + 1e-12 * self.far } else { 0.0 };
        travel.is_finite().then_some(travel)
    }
}

/// The data of a collapse before its tolerance is known.
#[derive(Debug, Clone, Copy)]
struct Looked {
    is_collapsed: bool,
    /// The distance from the eye to the nearest point of its sphere.
    near: f64,
    /// The distance at which its choice changes, for a tolerance of 1.
    needed: f64,
    far: f64,
    blur: Blur,
}

impl Looked {
    /// Returns the choice for a tolerance that is constant within the travel `stays`.
    fn choice(&self, tolerance: f64, stays: f64) -> CollapseChoice {
        let needed = if tolerance == f64::INFINITY { 0.0 } else { self.needed / tolerance };
        let seen = self.near * self.blur.factor;
        let is_allowed = seen >= needed;
        if is_allowed != self.is_collapsed {
            return CollapseChoice::Change { ratio: needed / seen };
        }
        // A change of the allowed error is counted at the distance `far`, but its effect is
        // proportional to the needed distance.
        let slack = (seen - needed).abs();
        let travel = self.blur.travel(slack, self.near);
        let travel = if needed > self.far { travel.min(slack * (self.far / needed)) } else { travel };
        let travel = 0.999 * travel.min(stays);
        CollapseChoice::Stay { travel: if travel > 0.0 { travel } else { 0.0 } }
    }
}

/// Returns a travel within which normals turn by less than `turn` radians relative to the eye, for
/// a sphere at `distance` whose angular radius has this sine.
fn travel_of(turn: f64, distance: f64, sine: f64) -> f64 {
    if sine > 0.5 {
        return 0.0;
    }
    // Three bounds that hold for any travel, up to 0.1 distances, and up to 0.5 distances. Each
    // covers the turn of the direction to the center and the change of the angular radius.
    let any = turn / 3.0;
    let short = (turn / (1.01 + 1.5 * sine)).min(0.1);
    let long = if sine <= 0.25 { (turn / (1.05 + 4.7 * sine)).min(0.5) } else { 0.0 };
    distance * any.max(short).max(long)
}
