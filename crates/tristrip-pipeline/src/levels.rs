//! Levels of detail of a whole model, drawn with the strips of its full mesh.
//!
//! ```text
//! Model ─ strips of the full mesh ─ their triangles ─ simplify ─▶ collapses in one order
//!                  │
//!                  └ vertices renamed for a level ─ filter ─▶ display strips ─ proof
//!                                                                   └ encode ─ read back, proof
//! ```

mod cursor;
mod filter;
mod level;
mod options;
mod part;
mod view;
mod written;

use std::sync::Arc;

use serde::Serialize;
use tristrip::lod::{Camera, LevelModel, ModelKind, RepairOptions, ViewCriteria};
use tristrip::text::counted;
use tristrip::{CollapseSequence, Mesh, Strips};
use tristrip_io::Model;

use crate::collapses::{Collapses, percent_of};
use crate::error::{Error, UnprovenMetrics};
use crate::figures::MeshProperties;
use crate::goal::Amount;
use crate::method::MethodDescription;
use crate::metrics::StripMetrics;
use crate::observer::{Observer, SearchStop, Stage, begin};
use crate::parts::{check_vertices, map};
use crate::prepared::{PreparedModel, Survey};
use crate::simplify::{
    CollapseRules, LevelOrder, Part, TriangleGoal, locked_note, place_notes, simplify_all,
};
use crate::text::count;
pub use cursor::ModelCursor;
pub use filter::DisplayFilter;
pub use level::{Level, LevelGoal};
pub use options::Options;
pub use part::LevelPart;
pub use view::DisplayedView;

/// The levels of detail of a model, from the base mesh at level 0 to the full mesh at
/// [`ModelLevels::collapse_count`].
#[derive(Debug, Default)]
#[non_exhaustive]
pub struct ModelLevels {
    /// The parts, in the order of the model.
    pub parts: Vec<LevelPart>,
    /// The collapses of all parts, merged into one order.
    pub order: Arc<LevelOrder>,
    /// The collapses to the base mesh.
    pub collapses: Collapses,
    /// Notes on locked vertices, and on parts that stopped before the base mesh. [`run`] moves them
    /// to [`Outcome::notes`].
    pub notes: Vec<String>,
    options: Options,
}

/// The levels of detail of a model. The field names are the keys of the JSON report.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Outcome {
    /// The levels.
    #[serde(skip)]
    pub model: ModelLevels,
    /// The vertex, edge and face counts of the full mesh.
    #[serde(skip)]
    pub mesh: MeshProperties,
    /// The number of strips of the full mesh.
    #[serde(skip)]
    pub strips_full: usize,
    /// The method of the strips and the options that it uses.
    #[serde(flatten)]
    pub method: MethodDescription,
    /// The number of collapses. It is also the level of the full mesh; the base mesh is level 0.
    pub levels: usize,
    /// The number of triangles of the base mesh.
    pub triangles_base: usize,
    /// The number of triangles of the full mesh.
    pub triangles_full: usize,
    /// The length of the diagonal of the bounding box of all triangles in the scene.
    pub diagonal: f64,
    /// Why the search for strips ended before its effort was spent; `None` if it was not stopped.
    pub stopped: Option<SearchStop>,
    /// The number of parts: glTF primitives or OBJ materials.
    pub parts: usize,
    /// Human-readable notes on data that was read, dropped, changed or unusual, on a search that
    /// was stopped, on locked vertices, and on parts that stopped before the base mesh.
    pub notes: Vec<String>,
}

/// The display strips of a level, with their metrics.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct DisplayedLevel {
    /// The level.
    pub level: usize,
    /// The level of each part.
    pub of_parts: Vec<usize>,
    /// The display strips of each part, over the vertices of its collapses; see
    /// [`LevelPart::outward`].
    pub strips: Vec<Strips>,
    /// The metrics of the display strips.
    pub metrics: StripMetrics,
    /// The maximum error of the collapses of the level, in mesh units.
    pub surface_error: f32,
    /// `surface_error` in percent of the diagonal of the model.
    pub surface_error_percent: f64,
    /// Whether the display strips are verified to draw exactly the triangles of the level.
    pub proven: bool,
}

/// Builds the levels of detail of a model.
///
/// # Errors
/// A part is too large, an option has an invalid value, the strips fail verification, or the
/// observer cancelled the operation.
///
/// ```
/// use tristrip::lod::RepairOptions;
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::{levels::DisplayFilter, encode, levels};
/// let corners = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0\n";
/// let model = read([corners, "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"].concat().as_bytes(), Format::Obj)?;
/// let levels = levels::run(&model, &levels::Options::default(), &())?.model;
/// let base = levels.display(0, DisplayFilter::Repair, RepairOptions::default(), &())?;
/// assert_eq!((base.metrics.triangles, base.proven), (1, true));
/// let half = levels.display(levels.collapse_count() / 2, DisplayFilter::Linked, RepairOptions::default(), &())?;
/// let file = levels.encode(&model, &half, &encode::Options::new(Format::Glb), &())?;
/// assert_eq!(file.faces, Some(half.metrics.triangles));
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn run(model: &Model, options: &Options, observer: &dyn Observer) -> Result<Outcome, Error> {
    // 1. The strips of the full mesh.
    let Survey { prepared, options: stripify, mesh, mut notes } =
        Survey::new(model, options.stripify, observer)?;
    let (strips, stopped) = prepared.search(&stripify, observer)?;
    if options.verify {
        begin(observer, Stage::Prove)?;
        prepared.prove(&strips)?;
    }

    // 2. The collapses.
    begin(observer, Stage::Simplify)?;
    let options = Options { stripify, ..*options };
    let mut model = ModelLevels::from_strips(&prepared, &strips, &options, observer)?;
    notes.extend(stopped.map(|stopped| stopped.note().into()));
    notes.append(&mut model.notes);
    Ok(Outcome {
        mesh,
        strips_full: strips.iter().map(Strips::len).sum(),
        method: MethodDescription::of(&stripify),
        levels: model.collapse_count(),
        triangles_base: model.collapses.triangles_after,
        triangles_full: model.collapses.triangles_before,
        diagonal: model.collapses.diagonal,
        stopped,
        parts: model.parts.len(),
        notes,
        model,
    })
}

impl ModelLevels {
    /// Builds levels of detail from strips of the full mesh. The strips must come from a prepared
    /// model and the method of the options. Only [`Observer::simplifies`] of the observer is
    /// called.
    ///
    /// # Errors
    /// The strips do not match the model, the model is too large, or the observer stopped the
    /// collapses.
    ///
    /// ```
    /// use tristrip_pipeline::{levels::ModelLevels, PreparedModel, levels};
    /// let model = tristrip_io::read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", tristrip_io::Format::Obj)?;
    /// let prepared = PreparedModel::new(&model, false);
    /// let options = levels::Options::default();
    /// let strips = prepared.find_strips(&options.stripify, &())?;
    /// let levels = ModelLevels::from_strips(&prepared, &strips, &options, &())?;
    /// assert_eq!((levels.collapse_count(), levels.triangle_count(0)?), (0, 1));
    /// # Ok::<(), tristrip_pipeline::Error>(())
    /// ```
    pub fn from_strips(
        prepared: &PreparedModel<'_>,
        strips: &[Strips],
        options: &Options,
        observer: &dyn Observer,
    ) -> Result<Self, Error> {
        if strips.len() != prepared.parts().len() {
            let (found, expected) = (strips.len(), prepared.parts().len());
            return Err(Error::unproven(format!(
                "found strips of {}, expected {expected}",
                counted(found, "part")
            )));
        }
        let meshes = prepared.parts().iter().map(|part| part.mesh);
        let vertex_counts = meshes.clone().map(Mesh::vertex_count);
        check_vertices(&strips.iter().zip(vertex_counts).collect::<Vec<_>>())?;
        let drawn = meshes.zip(strips.iter().map(Strips::to_list)).collect();
        let rules = CollapseRules { price: options.price, ..CollapseRules::default() };
        let (parts, skipped) = Part::of_all(drawn, prepared.places(), rules.weld_distance)?;
        let goal = Amount::Ratio(options.base).of(parts.iter().map(Part::triangle_count).sum());
        let all = simplify_all(&parts, TriangleGoal::OfModel(goal), None, rules, observer)?;
        if all.interrupted {
            return Err(Error::Cancelled);
        }
        let stopped = all.stopped;
        let (collapses, done) = (all.summary(&parts)?, all.parts);
        let mut notes = place_notes(prepared, skipped);
        notes.extend(locked_note(collapses.locked_vertices));
        // No mesh can collapse to nothing, so goal 0 means as far as possible.
        let stopped = stopped.filter(|_| goal > 0);
        notes.extend(stopped.map(|stopped| format!("target {}, {stopped}", count(goal))));
        let order = Arc::new(LevelOrder::new(&done));
        let all = parts.into_iter().zip(prepared.parts()).zip(strips).zip(done);
        let parts = all.map(|(((part, prepared), strips), done)| {
            LevelPart::new(part.compact.used, prepared.mesh.vertex_count(), strips, done.sequence)
        });
        let parts: Vec<LevelPart> = parts.collect();
        Ok(Self { order, parts, collapses, notes, options: *options })
    }

    /// Returns the number of collapses. It is also the level of the full mesh.
    pub fn collapse_count(&self) -> usize {
        self.order.collapse_count()
    }

    /// Returns the number of triangles of a level.
    ///
    /// # Errors
    /// [`Error::Level`]: the level does not exist.
    pub fn triangle_count(&self, level: usize) -> Result<usize, Error> {
        let of_parts = self.order.of_parts(level)?;
        let of_part = |(part, level): (&LevelPart, usize)| part.sequence().triangle_count(level);
        Ok(self.parts.iter().zip(of_parts).map(of_part).sum::<Result<usize, _>>()?)
    }

    /// Returns the level that meets a goal.
    ///
    /// # Errors
    /// A level number is greater than the level of the full mesh, or an error or pixel count is
    /// negative or NaN.
    ///
    /// ```
    /// use tristrip::lod::View;
    /// use tristrip_io::{Format, read};
    /// use tristrip_pipeline::{Deviation, levels::LevelGoal};
    /// // A pyramid of height 1 over a square. Without its apex, the error is 1.
    /// let model = read(b"v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n", Format::Obj)?;
    /// let levels = tristrip_pipeline::levels::run(&model, &Default::default(), &())?.model;
    /// let triangles = |goal: LevelGoal| levels.level_of(goal).and_then(|level| levels.triangle_count(level));
    /// assert_eq!(triangles(LevelGoal::Error(Deviation::Units(0.1)))?, 4);
    /// assert_eq!(triangles(LevelGoal::Triangles(3))?, 2);
    /// // From far away the model covers less than a pixel. The coarsest level is one triangle.
    /// let view = View::of_camera(1e6, View::FIELD_OF_VIEW, View::ROWS)?;
    /// assert_eq!(triangles(LevelGoal::Pixels(1.0, view))?, 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn level_of(&self, goal: LevelGoal) -> Result<usize, Error> {
        match goal {
            LevelGoal::Level(level) => level.of(self.collapse_count()),
            LevelGoal::Triangles(count) => self.level_of_triangles(count),
            LevelGoal::Error(error) => self.level_of_error(error.units(self.collapses.diagonal)),
            LevelGoal::Pixels(pixels, view) => self.level_of_error(view.length_of(pixels)),
        }
    }

    /// Returns the finest level with at most this number of triangles, or 0 if there is none.
    ///
    /// # Errors
    /// The levels are inconsistent; no input is known that causes this.
    pub(crate) fn level_of_triangles(&self, triangle_count: usize) -> Result<usize, Error> {
        let full = self.collapse_count();
        let mut left = self.triangle_count(full)?;
        let mut of_parts = self.order.of_parts(full)?;
        for (number, parts) in self.order.parts_from_full().enumerate() {
            if left <= triangle_count {
                return Ok(full - number);
            }
            for &part in parts {
                let level = &mut of_parts[part as usize];
                *level -= 1;
                left -= self.parts[part as usize].sequence().collapse(*level)?.dropped.len();
            }
        }
        Ok(0)
    }

    /// Returns the coarsest level with at most this surface error, in mesh units.
    ///
    /// # Errors
    /// The error is negative or NaN.
    pub(crate) fn level_of_error(&self, error: f32) -> Result<usize, Error> {
        if error.is_nan() || error < 0.0 {
            let (name, found, expected) = ("error", error.to_string(), "0 or more");
            return Err(tristrip::Error::Parameter { name, found, expected }.into());
        }
        let full = self.collapse_count();
        let mut of_parts = self.order.of_parts(full)?;
        for (number, parts) in self.order.parts_from_full().enumerate() {
            for &part in parts {
                let level = &mut of_parts[part as usize];
                *level -= 1;
                if self.parts[part as usize].sequence().error(*level)? > error {
                    return Ok(full - number);
                }
            }
        }
        Ok(0)
    }

    /// Builds, measures and verifies the display strips of a level. The observer is notified of
    /// each stage.
    ///
    /// # Errors
    /// The level does not exist, the display strips fail verification, or the observer cancelled
    /// the operation.
    pub fn display(
        &self,
        level: usize,
        filter: DisplayFilter,
        repair: RepairOptions,
        observer: &dyn Observer,
    ) -> Result<DisplayedLevel, Error> {
        begin(observer, Stage::Filter)?;
        let of_parts = self.order.of_parts(level)?;
        let pairs: Vec<_> = self.parts.iter().zip(&of_parts).collect();
        let strips = map(&pairs, |(part, level)| part.display(**level, filter, repair));
        self.displayed(level, of_parts, strips, observer)
    }

    /// Draws a level with the strips of a level model.
    ///
    /// # Errors
    /// The level does not exist, a part is too large for the model, the strips fail verification,
    /// or the observer cancelled the operation.
    ///
    /// ```
    /// use tristrip::lod::ModelKind;
    /// use tristrip_io::{Format, read};
    /// use tristrip_pipeline::levels;
    /// let corners = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0\n";
    /// let model = read([corners, "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"].concat().as_bytes(), Format::Obj)?;
    /// let levels = levels::run(&model, &levels::Options::default(), &())?.model;
    /// let base = levels.display_of(ModelKind::Sets, 0, &())?;
    /// assert_eq!((base.metrics.triangles, base.proven), (1, true));
    /// # Ok::<(), tristrip_pipeline::Error>(())
    /// ```
    pub fn display_of(
        &self,
        kind: ModelKind,
        level: usize,
        observer: &dyn Observer,
    ) -> Result<DisplayedLevel, Error> {
        begin(observer, Stage::Filter)?;
        let of_parts = self.order.of_parts(level)?;
        let pairs: Vec<_> = self.parts.iter().zip(&of_parts).collect();
        let strips = map(&pairs, |(part, level)| {
            let mut cursor = kind.build(part.strips(), part.sequence())?.start();
            cursor.set_level(**level)?;
            Ok(cursor.strips().clone())
        });
        self.displayed(level, of_parts, strips, observer)
    }

    /// Returns cursors over level models of all parts. They start at the full mesh and move
    /// together.
    ///
    /// # Errors
    /// A part is too large for this kind of model.
    ///
    /// ```
    /// use tristrip::lod::ModelKind;
    /// let model = tristrip_io::read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", tristrip_io::Format::Obj)?;
    /// let levels = tristrip_pipeline::levels::run(&model, &Default::default(), &())?.model;
    /// assert_eq!(levels.cursor(ModelKind::Sets)?.level(), levels.collapse_count());
    /// # Ok::<(), tristrip_pipeline::Error>(())
    /// ```
    pub fn cursor(&self, kind: ModelKind) -> Result<ModelCursor, Error> {
        self.cursor_of(|strips, sequence| kind.build(strips, sequence))
    }

    /// Returns cursors over level models that `build` creates from the strips and collapses of each
    /// part. They start at the full mesh.
    ///
    /// # Errors
    /// `build` fails.
    ///
    /// ```
    /// use std::sync::Arc;
    /// use tristrip::lod::{LevelModel, Sets};
    /// let model = tristrip_io::read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", tristrip_io::Format::Obj)?;
    /// let levels = tristrip_pipeline::levels::run(&model, &Default::default(), &())?.model;
    /// let cursor = levels.cursor_of(|strips, sequence| {
    ///     let model: Arc<dyn LevelModel> = Arc::new(Sets::new(strips, sequence)?);
    ///     Ok(model)
    /// })?;
    /// assert_eq!(cursor.level(), levels.collapse_count());
    /// # Ok::<(), tristrip_pipeline::Error>(())
    /// ```
    pub fn cursor_of(
        &self,
        build: impl Fn(&Strips, &Arc<CollapseSequence>) -> Result<Arc<dyn LevelModel>, tristrip::Error> + Sync,
    ) -> Result<ModelCursor, Error> {
        ModelCursor::new(&self.order, &self.parts, build)
    }

    /// Measures and verifies the display strips of a level.
    fn displayed(
        &self,
        level: usize,
        of_parts: Vec<usize>,
        strips: Vec<Result<Strips, Error>>,
        observer: &dyn Observer,
    ) -> Result<DisplayedLevel, Error> {
        let strips = strips.into_iter().collect::<Result<Vec<_>, Error>>()?;
        begin(observer, Stage::Measure)?;
        let vertex_counts = self.parts.iter().map(LevelPart::vertex_count);
        let measured: Vec<_> = strips.iter().zip(vertex_counts).collect();
        let metrics = StripMetrics::of(&measured, &self.options.stripify)?;
        let errors = self.parts.iter().zip(&of_parts).map(|(part, &level)| part.sequence().error(level));
        let errors = errors.collect::<Result<Vec<f32>, _>>()?;
        let surface_error = errors.into_iter().fold(0.0, f32::max);
        if self.options.verify {
            begin(observer, Stage::Prove)?;
            let all: Vec<_> = self.parts.iter().zip(&of_parts).zip(&strips).collect();
            let proofs = map(&all, |((part, level), strips)| part.prove(**level, strips));
            let proven = proofs.into_iter().collect::<Result<(), Error>>();
            proven.map_err(|error| error.with_metrics(|| UnprovenMetrics::Strips(metrics.clone())))?;
        }
        Ok(DisplayedLevel {
            level,
            of_parts,
            strips,
            metrics,
            surface_error,
            surface_error_percent: percent_of(surface_error.into(), self.collapses.diagonal),
            proven: self.options.verify,
        })
    }

    /// Builds, measures and verifies the display strips for the view of a camera. The observer is
    /// notified of each stage.
    ///
    /// # Errors
    /// The levels belong to another model, a position is not finite, the strips fail verification,
    /// or the observer cancelled the operation.
    ///
    /// ```
    /// use tristrip::lod::{Camera, ViewCriteria};
    /// use tristrip_io::{Format, read};
    /// use tristrip_pipeline::{encode, levels};
    /// let corners = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 1\n";
    /// let model = read([corners, "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"].concat().as_bytes(), Format::Obj)?;
    /// let levels = levels::run(&model, &levels::Options::default(), &())?.model;
    /// let triangles = |height: f32| {
    ///     let camera = Camera::new([1.0, 1.0, height], [1.0, 1.0, 0.0])?;
    ///     let view = levels.view(&model, &camera, &ViewCriteria::default(), &())?;
    ///     let file = levels.encode_view(&model, &view, &encode::Options::new(Format::Glb), &())?;
    ///     Ok::<_, tristrip_pipeline::Error>(file.faces)
    /// };
    /// assert_eq!((triangles(3.0)?, triangles(1e6)?), (Some(4), Some(1)));
    /// # Ok::<(), tristrip_pipeline::Error>(())
    /// ```
    pub fn view(
        &self,
        model: &Model,
        camera: &Camera,
        criteria: &ViewCriteria,
        observer: &dyn Observer,
    ) -> Result<DisplayedView, Error> {
        let options = (&self.options.stripify, self.options.verify);
        view::displayed(&self.parts, model, (camera, criteria), options, observer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tristrip_io::{Format, read};

    #[test]
    fn parts_move_together() {
        // Two pyramids of four triangles and different heights, in one file as two materials.
        let tent = |z: u32| format!("v 0 0 {z}\nv 2 0 {z}\nv 2 2 {z}\nv 0 2 {z}\nv 1 1 {z}.{z}\n");
        let faces = |m: u32, v: u32| {
            let c = v + 4;
            let side = |i: u32| format!("f {} {} {c}\n", v + i, v + (i + 1) % 4);
            format!("usemtl m{m}\n{}", (0..4).map(side).collect::<String>())
        };
        let text = [tent(1), tent(7), faces(0, 1), faces(1, 6)].concat();
        let model = read(text.as_bytes(), Format::Obj).unwrap();
        let levels = run(&model, &Options::default(), &()).unwrap().model;
        assert!(levels.parts.len() == 2 && levels.collapse_count() > 2);
        for kind in ModelKind::ALL {
            let mut cursor = levels.cursor(kind).unwrap();
            let last = levels.collapse_count();
            for level in (0..=last).rev().chain([last, 0, last / 2]) {
                cursor.set_level(level).unwrap();
                let of_parts = levels.order.of_parts(level).unwrap();
                let at: Vec<usize> = cursor.of_parts_mut().iter().map(|part| part.level()).collect();
                assert_eq!((cursor.level(), at), (level, of_parts));
                for (part, own) in cursor.of_parts_mut().iter_mut().zip(&levels.parts) {
                    own.prove(part.level(), part.strips()).unwrap();
                }
            }
            assert!(matches!(cursor.set_level(last + 1), Err(Error::Level { .. })));
            assert!(cursor.model_memory() > 0 && cursor.cursor_memory() > 0);
        }
    }
}
