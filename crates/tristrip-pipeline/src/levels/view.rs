//! The view of a camera: each part with the detail that the camera sees of it, as Skip Strips have it.
//!
//! The camera is in the coordinates of the scene. A part that one node places, turned and scaled evenly, is seen by the camera in its own coordinates.
//! A part in several places would need the detail of each of them: it is drawn in full, and so is one that a node stretches. The parts share a budget of
//! triangles.

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

/// A camera and its criteria in the coordinates of a part.
type Seen = (Camera, ViewCriteria);

/// The range of allowed errors in pixels in which that of a budget is searched, and the steps of the search after powers of two.
const MIN_PIXELS: f32 = 1e-3;
const MAX_PIXELS: f32 = 1e9;
const HALVINGS: usize = 8;

/// A view as it is drawn.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct DisplayedView {
    /// The display strips of each part, over the vertices of its collapses; see [`LevelPart::outward`].
    pub strips: Vec<Strips>,
    /// The metrics of the display strips.
    pub metrics: StripMetrics,
    /// Whether the display strips are proven to draw exactly the triangles of the view.
    pub proven: bool,
    /// Notes on parts that are drawn in full, and on borders between parts.
    pub notes: Vec<String>,
    /// The triangles of each part, over its vertices in the model.
    pub(super) triangles: Vec<Vec<u32>>,
}

/// Builds, measures and proves the display strips of the view of a camera, as [`ModelLevels::view`](super::ModelLevels::view) describes.
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
        notes.push(format!("{counted} drawn in full: in several places, or stretched by a node"));
    }
    if parts.len() > 1 {
        notes.push(
            "each part has detail of its own: borders between parts may open by the allowed error".into(),
        );
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
            notes.push(format!("{} asked for: the view has {}", counted(budget, "triangle"), count(drawn)));
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

/// Moves the views of all parts to what their cameras need. They share the budget: all may have the least error in pixels, above the one that is allowed,
/// with which they keep it.
fn choose_detail(
    views: &mut [SkipView],
    cameras: &[Option<Seen>],
    criteria: &ViewCriteria,
) -> Result<(), Error> {
    let Some(budget) = criteria.budget.filter(|_| views.len() > 1) else {
        return update_all(views, cameras, |criteria| *criteria).map(|_| ());
    };
    // What was tried before must not matter.
    let any = Hysteresis::new(1.0)?;
    let mut drawn = |pixels: f32| {
        update_all(views, cameras, |criteria| {
            criteria.with_budget(usize::MAX).with_hysteresis(any).with_pixels(pixels)
        })
    };
    // 1. A power of two of the allowed error that is enough, if one is.
    let (mut low, mut high) = (criteria.pixels, criteria.pixels);
    while drawn(high)? > budget && high < MAX_PIXELS {
        (low, high) = (high, (2.0 * high).max(MIN_PIXELS));
    }
    // 2. The least one between it and half of it.
    for _ in 0..HALVINGS {
        let middle = low + (high - low) / 2.0;
        if drawn(middle)? > budget { low = middle } else { high = middle }
    }
    drawn(high).map(|_| ())
}

/// Updates the views of all parts that have a camera; returns the triangles of all.
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

/// Proves that display strips draw exactly these triangles.
fn prove(triangles: &[[u32; 3]], strips: &Strips) -> Result<(), Error> {
    let expected = Faces::from_triangles(triangles.as_flattened().to_vec())?;
    let drawn: Vec<[u32; 3]> = strips.triangles().collect();
    verify_drawing(&expected, &drawn).map_err(|why| Error::unproven(format!("view: {why}")))?;
    Ok(())
}
