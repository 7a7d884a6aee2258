//! The view of a camera: each part is refined for this camera with Skip Strips.
//!
//! The camera is in scene coordinates. If one node places a part without shear or uneven scale, the
//! camera is transformed into the coordinates of the part. A part with several instances would need
//! a separate refinement per instance, so it is drawn in full. A part whose node shears it or
//! scales it unevenly is also drawn in full. The parts share one triangle budget.

use tristrip::lod::{Camera, Hysteresis, SkipView, ViewCriteria};
use tristrip::verify::verify_drawing;
use tristrip::{Faces, StripifyOptions, Strips};
use tristrip_io::Model;

use super::part::LevelPart;
use crate::error::{Error, UnprovenMetrics};
use crate::metrics::StripMetrics;
use crate::observer::{Observer, Stage, begin};
use crate::parts::map;
use crate::places::Places;
use crate::text::{count, counted};

/// A camera and its criteria, in the coordinates of a part.
type Seen = (Camera, ViewCriteria);

/// The limits of the search for the error in pixels that meets a budget, and the bisection steps
/// after the doubling phase.
const MIN_PIXELS: f32 = 1e-3;
const MAX_PIXELS: f32 = 1e9;
const HALVINGS: usize = 8;

/// The display strips of a view, with their metrics.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct DisplayedView {
    /// The display strips of each part, over the vertices of its collapses; see
    /// [`LevelPart::outward`].
    pub strips: Vec<Strips>,
    /// The metrics of the display strips.
    pub metrics: StripMetrics,
    /// Whether the display strips are verified to draw exactly the triangles of the view.
    pub proven: bool,
    /// Notes on parts that are drawn in full, and on gaps between parts.
    pub notes: Vec<String>,
    /// The triangles of each part, over its vertices in the model.
    pub(super) triangles: Vec<Vec<u32>>,
}

/// Builds, measures and verifies the display strips for the view of a camera; see
/// [`ModelLevels::view`](super::ModelLevels::view).
pub(super) fn displayed(
    parts: &[LevelPart],
    model: &Model,
    (camera, criteria): (&Camera, &ViewCriteria),
    (options, is_verified): (&StripifyOptions, bool),
    observer: &dyn Observer,
) -> Result<DisplayedView, Error> {
    begin(observer, Stage::Filter)?;
    if model.parts.len() != parts.len() {
        let (found, expected) = (model.parts.len(), parts.len());
        return Err(Error::unproven(format!(
            "found a model of {}, expected {expected}",
            tristrip::text::counted(found, "part")
        )));
    }
    let places = Places::of(model);
    let seen = places.of_part.iter().map(|&list| match &places.lists[list][..] {
        [place] => (place.inward(camera, criteria), place.scale()),
        _ => (None, 1.0),
    });
    let (cameras, scales): (Vec<Option<Seen>>, Vec<f64>) = seen.unzip();
    let mut notes: Vec<String> = places.note().into_iter().collect();
    let full_count = cameras.iter().filter(|camera| camera.is_none()).count();
    if full_count > 0 {
        let counted = counted(full_count, "part");
        notes.push(format!("{counted} drawn in full: they have several instances, or a node stretches them"));
    }
    if parts.len() > 1 {
        notes.push("parts are refined separately: gaps up to the allowed error may open between them".into());
    }
    let pairs: Vec<_> = parts.iter().zip(&model.parts).zip(cameras.iter().zip(&scales)).collect();
    let views = map(&pairs, |((part, model), (camera, scale))| {
        part.view(model.mesh.positions(), camera.is_none(), **scale)
    });
    let mut views = views.into_iter().collect::<Result<Vec<SkipView>, Error>>()?;
    choose_detail(&mut views, &cameras, criteria)?;
    if let Some(budget) = criteria.budget {
        let drawn: usize = views.iter().map(SkipView::triangle_count).sum();
        if drawn > budget {
            notes.push(format!(
                "requested {}, but the view has {}",
                counted(budget, "triangle"),
                count(drawn)
            ));
        }
    }
    let strips: Vec<Strips> = views.iter().map(SkipView::display_strips).collect();

    begin(observer, Stage::Measure)?;
    let vertex_counts = parts.iter().map(LevelPart::vertex_count);
    let measured: Vec<_> = strips.iter().zip(vertex_counts).collect();
    let metrics = StripMetrics::of(&measured, options)?;

    let triangles: Vec<Vec<[u32; 3]>> = views.iter().map(SkipView::renamed_triangles).collect();
    if is_verified {
        begin(observer, Stage::Prove)?;
        let pairs: Vec<_> = triangles.iter().zip(&strips).collect();
        let proofs = map(&pairs, |(triangles, strips)| prove(triangles, strips));
        let proven = proofs.into_iter().collect::<Result<(), Error>>();
        proven.map_err(|error| error.with_metrics(|| UnprovenMetrics::Strips(metrics.clone())))?;
    }
    let outward = parts.iter().zip(triangles);
    let triangles = outward.map(|(part, triangles)| part.outward_triangles(triangles)).collect();
    Ok(DisplayedView { strips, metrics, proven: is_verified, notes, triangles })
}

/// Refines the views of all parts for their cameras. The budget is shared: all parts get the same
/// error in pixels, the minimum above the allowed error that meets the budget.
fn choose_detail(
    views: &mut [SkipView],
    cameras: &[Option<Seen>],
    criteria: &ViewCriteria,
) -> Result<(), Error> {
    let Some(budget) = criteria.budget.filter(|_| views.len() > 1) else {
        return update_all(views, cameras, |criteria| *criteria).map(|_| ());
    };
    // The result must not depend on earlier attempts.
    let any = Hysteresis::new(1.0)?;
    let mut drawn = |pixels: f32| {
        update_all(views, cameras, |criteria| {
            criteria.with_budget(usize::MAX).with_hysteresis(any).with_pixels(pixels)
        })
    };
    // 1. Double the allowed error until the budget is met.
    let (mut low, mut high) = (criteria.pixels, criteria.pixels);
    while drawn(high)? > budget && high < MAX_PIXELS {
        (low, high) = (high, (2.0 * high).max(MIN_PIXELS));
    }
    // 2. Bisect between this error and the previous one.
    for _ in 0..HALVINGS {
        let middle = low + (high - low) / 2.0;
        if drawn(middle)? > budget { low = middle } else { high = middle }
    }
    drawn(high).map(|_| ())
}

/// Updates the views of all parts that have a camera. Returns the total number of triangles.
fn update_all(
    views: &mut [SkipView],
    cameras: &[Option<Seen>],
    criteria_of: impl Fn(&ViewCriteria) -> ViewCriteria,
) -> Result<usize, Error> {
    let mut sum = 0;
    for (view, seen) in views.iter_mut().zip(cameras) {
        if let Some((camera, criteria)) = seen {
            view.update(camera, &criteria_of(criteria))?;
        }
        sum += view.triangle_count();
    }
    Ok(sum)
}

/// Verifies that display strips draw exactly these triangles.
fn prove(triangles: &[[u32; 3]], strips: &Strips) -> Result<(), Error> {
    let expected = Faces::from_triangles(triangles.as_flattened().to_vec())?;
    let drawn: Vec<[u32; 3]> = strips.triangles().collect();
    verify_drawing(&expected, &drawn).map_err(|why| Error::unproven(format!("view: {why}")))?;
    Ok(())
}
