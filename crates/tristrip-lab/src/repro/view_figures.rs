//! Skip Strips as in El-Sana et al. 2000, section 6.3: the vertices that views send, and the cost
//! of an update.
//!
//! A view of some detail is an orbit at the distance where the model fills the image. The allowed
//! error in pixels is chosen to give the sampled frames the published mean number of triangles; for
//! a stand-in, the published fraction. At the detail of the full mesh there is no camera and no
//! update.
//!
//! The paper prints times, which pages do not contain. Counts replace them: the collapses that an
//! update examines, applies or undoes, and the strip segments that it scans. Strips that are
//! computed from scratch start with all triangles of the frame.
//!
//! Metrics of the merge tree:
//! - `collapses`, `levels`, `triangles_base`;
//! - `height` and `depth`: the maximum number of collapses on a path, and of ancestors of a vertex;
//!   `expected_height`: the logarithm of the number of vertices to base 1.25; `percent_height`: the
//!   height in percent of it;
//! - `children`: the maximum number of collapses into one vertex; `dependencies`: the mean number
//!   of collapses that a collapse requires according to its list;
//! - `hops_parents` and `hops_skips`: the mean number of pointers from a vertex of the strips to
//!   its first active ancestor in the base mesh, by parents alone and by pointers that skip
//!   ancestors.
//!
//! Metrics of a view, as means over the sampled frames:
//! - `pixels`: the allowed error; `triangles`; `vertices_list`: the vertices of single triangles;
//! - `vertices_stss`, `vertices_dtfs`, `vertices_linked`: the vertices sent by Skip Strips with
//!   each filter;
//! - `vertices_again`: the vertices sent by strips that the method of the flags computes from
//!   scratch for the frame.
//!
//! Metrics of an update, as means over all frames but the first:
//! - `active`: the vertices that the published update examines; `looked_at`: the collapses that our
//!   update examines;
//! - `moved`: the collapses and splits; `segments`: the scanned strip segments, of up to 64
//!   entries; `entries`: the sum of examined, moved and scanned items.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use tristrip::lod::{Camera, Filter, Hysteresis, SkipStrips, SkipView, ViewCriteria};
use tristrip::simplify::{MergeTree, SimplifyOptions, merge_tree};
use tristrip::{Faces, Mesh, StripifyOptions, Strips, stripify};
use tristrip_pipeline::PreparedModel;

use super::view_data::{Detail, TreeOrder, ViewPanel};
use crate::error::Error;
use crate::flight::{FlightObserver, FlightOptions, FlightPath, FrameRow, Lens, fly, is_among};
use tristrip_render::images::SheetImage;

/// The number of frames of an orbit, and how many of them are proven and sampled.
const FRAMES: usize = 300;
const SAMPLES: usize = 5;
/// The range of the search for the error in pixels of a view, and its number of steps. Each step
/// halves the logarithm of the ratio of its ends.
const PIXELS: [f64; 2] = [1e-5, 1e4];
const STEPS: usize = 18;
/// The base of the logarithm in the expected height of a merge tree.
const BASE: f64 = 1.25;
/// The maximum number of entries of a segment.
const SEGMENT: usize = 64;
/// The size of a panel of an image.
pub(super) const PANEL: [u32; 2] = [400, 300];

/// The requested measurements of the merge trees of one order.
#[derive(Debug, Clone, Default)]
pub(super) struct ViewRequests {
    pub(super) details: BTreeSet<Detail>,
    /// Panels of images, by the file of the image.
    pub(super) pictures: BTreeMap<String, Vec<ViewPanel>>,
}

/// The metrics and images of a model.
#[derive(Debug, Default)]
pub(super) struct ViewFigures {
    trees: BTreeMap<TreeOrder, BTreeMap<String, f64>>,
    views: BTreeMap<(TreeOrder, Detail), BTreeMap<String, f64>>,
    pictures: BTreeMap<String, Vec<u8>>,
}

impl ViewFigures {
    /// Returns a metric of a view, or of the merge tree.
    pub(super) fn get(&self, order: TreeOrder, detail: Option<Detail>, figure: &str) -> Option<f64> {
        let of_tree = || self.trees.get(&order)?.get(figure);
        let of_view = detail.and_then(|detail| self.views.get(&(order, detail))?.get(figure));
        of_view.or_else(of_tree).copied()
    }

    /// Returns an image by its file.
    pub(super) fn picture(&self, file: &str) -> Option<&[u8]> {
        self.pictures.get(file).map(Vec::as_slice)
    }
}

/// Measures views of a model over the strips of its full mesh. A model with several parts, or
/// without triangles, has no metrics.
///
/// # Errors
/// A frame is not proven, or a model cannot be built.
pub(super) fn measure(
    prepared: &PreparedModel<'_>,
    strips: &[Strips],
    options: &StripifyOptions,
    requests: &BTreeMap<TreeOrder, ViewRequests>,
) -> Result<ViewFigures, Error> {
    let mut measured = ViewFigures::default();
    let ([part], [strips]) = (prepared.parts(), strips) else { return Ok(measured) };
    if strips.triangles().next().is_none() {
        return Ok(measured);
    }
    for (&order, requests) in requests {
        let tree = merge_tree(part.mesh, strips.to_list(), order.into(), &SimplifyOptions::default())?;
        let model = Arc::new(SkipStrips::new(strips, &tree.sequence, part.mesh.positions())?);
        measured.trees.insert(order, of_tree(&tree, &model)?);
        let built = BuiltModel { mesh: part.mesh, model, options: *options };
        for &detail in &requests.details {
            measured.views.insert((order, detail), built.view(detail)?);
        }
        for (file, panels) in &requests.pictures {
            measured.pictures.insert(file.clone(), built.picture(panels)?);
        }
    }
    Ok(measured)
}

/// Returns the metrics of a merge tree.
fn of_tree(tree: &MergeTree, model: &Arc<SkipStrips>) -> Result<BTreeMap<String, f64>, Error> {
    let full = model.full_view().active_vertex_count();
    let expected = libm::log(full as f64) / libm::log(BASE);
    let height = f64::from(model.height());
    let mut children: BTreeMap<u32, usize> = BTreeMap::new();
    for rename in tree.sequence.iter().flat_map(|collapse| collapse.renames) {
        *children.entry(rename.kept).or_default() += 1;
    }
    let [parents, skips, _] = model.view().mean_hops();
    let figures = [
        ("collapses", tree.sequence.len() as f64),
        ("levels", tree.level_ends.len() as f64),
        ("triangles_base", tree.sequence.triangle_count(0)? as f64),
        ("height", height),
        ("depth", f64::from(model.depth())),
        ("expected_height", expected),
        ("percent_height", if expected > 0.0 { 100.0 * height / expected } else { 0.0 }),
        ("children", children.into_values().max().unwrap_or(0) as f64),
        ("dependencies", model.mean_dependencies()),
        ("hops_parents", parents),
        ("hops_skips", skips),
    ];
    Ok(figures.map(|(name, figure)| (name.to_owned(), figure)).into())
}

/// A model with its full mesh.
struct BuiltModel<'a> {
    mesh: &'a Mesh,
    model: Arc<SkipStrips>,
    options: StripifyOptions,
}

impl BuiltModel<'_> {
    fn full_triangle_count(&self) -> Result<usize, Error> {
        Ok(self.model.levels().triangle_count(self.model.levels().collapse_count())?)
    }

    /// Returns the metrics of views of some detail.
    fn view(&self, detail: Detail) -> Result<BTreeMap<String, f64>, Error> {
        if detail.triangles >= detail.of {
            let mut full = Samples::new(self);
            full.add(&self.model.full_view())?;
            return Ok(full.figures());
        }
        let share = detail.triangles as f64 / detail.of as f64;
        let target = share * self.full_triangle_count()? as f64;
        let path = FlightPath::orbit(self.mesh.positions(), detail.up)?;
        let cameras = path.cameras(FRAMES, Lens::default())?;
        let sampled = cameras.iter().enumerate().filter(|(frame, _)| is_among(*frame, FRAMES, SAMPLES));
        let sampled: Vec<Camera> = sampled.map(|(_, &camera)| camera).collect();
        let pixels = pixels_of(&self.model, &sampled, target)?;
        let options =
            FlightOptions { criteria: criteria(pixels)?, filter: Filter::Dtfs, proof_count: SAMPLES };
        let mut samples = Samples::new(self);
        let rows = fly(&self.model, &cameras, &options, &mut samples)?;
        let mut figures = samples.figures();
        figures.insert("pixels".into(), f64::from(pixels));
        let updates = &rows[1..];
        let mut add = |name: &str, of: &dyn Fn(&FrameRow) -> usize| {
            let sum: usize = updates.iter().map(of).sum();
            figures.insert(name.into(), sum as f64 / updates.len() as f64);
        };
        add("active", &|row| row.active_vertices);
        add("looked_at", &|row| row.looked_at);
        add("moved", &|row| row.collapses + row.splits);
        add("segments", &|row| row.segments);
        add("entries", &|row| row.looked_at + row.collapses + row.splits + SEGMENT * row.segments);
        Ok(figures)
    }

    /// Draws an image with some panels.
    fn picture(&self, panels: &[ViewPanel]) -> Result<Vec<u8>, Error> {
        let mut views = Vec::new();
        for panel in panels {
            let lens = Lens { image: PANEL, ..Lens::default() };
            let camera = panel.camera.camera(lens)?;
            let seen_from = panel.seen_from.map_or(Ok(camera), |stop| stop.camera(lens))?;
            let strips = if panel.percent >= 100.0 {
                self.model.full_view().display_strips()
            } else {
                let target = panel.percent / 100.0 * self.full_triangle_count()? as f64;
                let mut view = self.model.view();
                let pixels = pixels_of(&self.model, &[camera], target)?;
                view.update(&camera, &criteria(pixels)?)?;
                view.display_strips()
            };
            views.push((strips, seen_from, panel.strips));
        }
        let pictures: Vec<SheetImage<'_>> = views
            .iter()
            .map(|(strips, camera, is_coloured)| SheetImage {
                positions: self.mesh.positions(),
                strips,
                camera,
                is_coloured: *is_coloured,
            })
            .collect();
        Ok(tristrip_render::images::sheet(&pictures, PANEL)?)
    }
}

/// Returns the criteria of a view. They have no hysteresis, as in the paper, so the detail depends
/// only on the camera.
fn criteria(pixels: f32) -> Result<ViewCriteria, Error> {
    Ok(ViewCriteria::default().with_pixels(pixels).with_hysteresis(Hysteresis::new(1.0)?))
}

/// Finds the error in pixels at which the views of some cameras have a given mean number of
/// triangles.
#[allow(clippy::cast_possible_truncation, reason = "pixels are f32")]
fn pixels_of(model: &Arc<SkipStrips>, cameras: &[Camera], target: f64) -> Result<f32, Error> {
    let mut views: Vec<SkipView> = cameras.iter().map(|_| model.view_without_strips()).collect();
    let [mut low, mut high] = PIXELS;
    for _ in 0..STEPS {
        let middle = (low * high).sqrt();
        let criteria = criteria(middle as f32)?;
        let mut sum = 0;
        for (view, camera) in views.iter_mut().zip(cameras) {
            view.update(camera, &criteria)?;
            sum += view.triangle_count();
        }
        if sum as f64 > target * cameras.len() as f64 {
            low = middle;
        } else {
            high = middle;
        }
    }
    Ok(high as f32)
}

/// Counts of the sampled frames.
struct Samples<'a> {
    built: &'a BuiltModel<'a>,
    count: usize,
    sums: BTreeMap<&'static str, usize>,
}

impl<'a> Samples<'a> {
    fn new(built: &'a BuiltModel<'a>) -> Self {
        Self { built, count: 0, sums: BTreeMap::new() }
    }

    /// Adds a frame.
    fn add(&mut self, view: &SkipView) -> Result<(), Error> {
        let triangles = view.renamed_triangles();
        let simplified = view.clone().simplified_strips();
        let sent = |filter: Filter| filter.strips(&simplified).vertices_sent();
        let counts = [
            ("triangles", triangles.len()),
            ("vertices_list", 3 * triangles.len()),
            ("vertices_stss", sent(Filter::Stss)),
            ("vertices_dtfs", view.display_strips().vertices_sent()),
            ("vertices_linked", sent(Filter::Linked)),
            ("vertices_again", self.computed_again(triangles)?),
        ];
        counts.into_iter().for_each(|(name, count)| *self.sums.entry(name).or_default() += count);
        self.count += 1;
        Ok(())
    }

    /// Counts the vertices sent by strips that are computed from scratch for the triangles of a
    /// frame.
    fn computed_again(&self, triangles: Vec<[u32; 3]>) -> Result<usize, Error> {
        let faces = Faces::from_triangles(triangles.into_flattened())?;
        let drawn = Mesh::new(self.built.mesh.shared_positions(), faces)?;
        Ok(stripify(&drawn, &self.built.options)?.vertices_sent())
    }

    /// Returns the means.
    fn figures(self) -> BTreeMap<String, f64> {
        let count = self.count.max(1) as f64;
        self.sums.into_iter().map(|(name, sum)| (name.to_owned(), sum as f64 / count)).collect()
    }
}

impl FlightObserver for Samples<'_> {
    fn frame(&mut self, row: &FrameRow, _camera: &Camera, view: &SkipView) -> Result<(), Error> {
        if row.proven.is_some() { self.add(view) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::Axis;
    use tristrip_io::{Format, read};
    use tristrip_pipeline::parse_method;

    const ORDERS: [TreeOrder; 2] = [TreeOrder::ShortestEdge, TreeOrder::Quadric];

    fn half() -> Detail {
        Detail { triangles: 3000, of: 6000, up: Axis::Y }
    }

    fn full() -> Detail {
        Detail { triangles: 6000, ..half() }
    }

    /// Measures two details, and two panels of an image, with both orders.
    fn measured(model: &tristrip_io::Model) -> Result<ViewFigures, Error> {
        let prepared = PreparedModel::new(model, false);
        let options = parse_method("sgi")?;
        let strips = prepared.find_strips(&options, &())?;
        let camera = serde_json::from_str(r#"{"eye": [9, 2, 9], "look_at": [0, 0, 0]}"#).unwrap();
        let panel = |percent, strips| ViewPanel { percent, camera, seen_from: None, strips };
        let pictures = BTreeMap::from([("a.png".to_owned(), vec![panel(20.0, true), panel(100.0, false)])]);
        let requests = ViewRequests { details: [half(), full()].into(), pictures };
        measure(&prepared, &strips, &options, &ORDERS.map(|order| (order, requests.clone())).into())
    }

    fn wingnut() -> tristrip_io::Model {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../testdata/models/wingnut.ply");
        tristrip_io::read_path(path).unwrap()
    }

    #[test]
    fn views_have_the_wanted_detail_and_their_updates_are_small() {
        let figures = measured(&wingnut()).unwrap();
        for order in ORDERS {
            let of = |detail, figure| figures.get(order, Some(detail), figure);
            let of_half = |figure| of(half(), figure).unwrap();
            // 6090 triangles.
            assert!((of_half("triangles") - 3045.0).abs() < 0.02 * 3045.0, "{}", of_half("triangles"));
            assert!((of_half("vertices_list") - 3.0 * of_half("triangles")).abs() < 1e-6);
            assert!(of_half("vertices_linked") <= of_half("vertices_dtfs"));
            assert!(of_half("vertices_again") < of_half("vertices_list"));
            assert!(of_half("moved") > 0.0 && of_half("moved") < of_half("active"));
            assert!(of_half("entries") > of_half("looked_at") + of_half("moved") + of_half("segments"));
            assert_eq!((of(full(), "triangles"), of(full(), "moved")), (Some(6090.0), None));
            // With or without a view, a metric of the tree is the same.
            let height = figures.get(order, None, "height").unwrap();
            assert_eq!(of(half(), "height"), Some(height));
            assert!(height > 8.0 && height < figures.get(order, None, "expected_height").unwrap());
            assert!(figures.get(order, None, "hops_skips") < figures.get(order, None, "hops_parents"));
            assert_eq!(figures.get(order, None, "triangles"), None);
        }
        assert!(figures.picture("a.png").unwrap().starts_with(b"\x89PNG"));
        assert_eq!(figures.picture("b.png"), None);
    }

    #[test]
    fn models_without_triangles_or_of_several_parts_have_no_figures() {
        for text in ["v 0 0 0\n", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 2\n"] {
            let figures = measured(&read(text.as_bytes(), Format::Obj).unwrap()).unwrap();
            assert_eq!(figures.get(ORDERS[0], None, "height"), None, "{text}");
            assert_eq!(figures.picture("a.png"), None);
        }
        let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../testdata/models/milktruck.glb");
        let figures = measured(&tristrip_io::read_path(scene).unwrap()).unwrap();
        assert_eq!(figures.get(ORDERS[0], None, "height"), None);
        // One triangle has no collapse.
        let one = measured(&read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj).unwrap()).unwrap();
        assert_eq!(one.get(ORDERS[0], Some(half()), "triangles"), Some(1.0));
    }
}
