//! The view of a camera: each part with the detail that the camera sees of it, as Skip Strips have it.
//!
//! The camera is in the coordinates of the scene. A part that one node places, turned and scaled evenly, is seen by the camera in its own coordinates.
//! A part in several places would need the detail of each of them: it is drawn in full, and so is one that a node stretches.

use tristrip::lod::{Camera, SkipView, ViewCriteria};
use tristrip::verify::verify_drawing;
use tristrip::{Faces, StripifyOptions, Strips};
use tristrip_io::Model;

use super::part::LevelPart;
use crate::error::Error;
use crate::figures::Figures;
use crate::observer::{Event, Observer, Stage, begin};
use crate::parts::map;
use crate::places::Places;
use crate::text::counted;

/// A view as it is drawn.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct DisplayedView {
    /// The display strips of each part, over the vertices of its collapses; see [`LevelPart::outward`].
    pub strips: Vec<Strips>,
    /// The metrics of the display strips.
    pub figures: Figures,
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
        return Err(Error::Unproven(format!("found a model of {found} parts, expected {expected}")));
    }
    let places = Places::of(model);
    let cameras = places.of_part.iter().map(|&list| match &places.lists[list][..] {
        [place] => place.inward(camera),
        _ => None,
    });
    let cameras: Vec<Option<Camera>> = cameras.collect();
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
    let pairs: Vec<_> = parts.iter().zip(&model.parts).zip(&cameras).collect();
    let views =
        map(&pairs, |((part, model), camera)| part.view(model.mesh.positions(), camera.as_ref(), criteria));
    let views = views.into_iter().collect::<Result<Vec<SkipView>, Error>>()?;
    let strips: Vec<Strips> = views.iter().map(SkipView::display_strips).collect();
    observer.event(Event::Filtered);

    begin(observer, Stage::Measure)?;
    let vertex_counts = parts.iter().map(LevelPart::vertex_count);
    let measured: Vec<_> = strips.iter().zip(vertex_counts).collect();
    let figures = Figures::of(&measured, options)?;
    observer.event(Event::Measured(&figures));

    let triangles: Vec<Vec<[u32; 3]>> = views.iter().map(SkipView::renamed_triangles).collect();
    if is_verified {
        begin(observer, Stage::Prove)?;
        let pairs: Vec<_> = triangles.iter().zip(&strips).collect();
        let proofs = map(&pairs, |(triangles, strips)| prove(triangles, strips));
        proofs.into_iter().collect::<Result<(), Error>>()?;
        observer.event(Event::Proven { faces: triangles.iter().map(Vec::len).sum() });
    }
    let outward = parts.iter().zip(triangles);
    let triangles = outward.map(|(part, triangles)| part.outward_triangles(triangles)).collect();
    Ok(DisplayedView { strips, figures, proven: is_verified, notes, triangles })
}

/// Proves that display strips draw exactly these triangles.
fn prove(triangles: &[[u32; 3]], strips: &Strips) -> Result<(), Error> {
    let expected = Faces::from_triangles(triangles.as_flattened().to_vec())?;
    let drawn: Vec<[u32; 3]> = strips.triangles().collect();
    verify_drawing(&expected, &drawn).map_err(|why| Error::Unproven(format!("view: {why}")))?;
    Ok(())
}
