//! Simplification of a whole model: the collapses proven, the vertices that become unused dropped.
//!
//! Parts that the same nodes place and that share positions, such as the materials of one mesh, are simplified as one surface: both sides of their
//! border collapse together. Vertices that touch parts in other places of the scene stay. Errors and the bounding box are those in the scene.

mod fit;
mod groups;
mod normals;
mod order;
mod parts;
mod report;
pub(crate) mod touching;
mod vanishing;
mod warning;

use tristrip::StripifyOptions;
use tristrip_io::gltf::Rounding;
use tristrip_io::{Drawing, Format, Model, NewValues, Redrawn};

use crate::collapses::Collapses;
use crate::encode::{EncodeOptions, Encoded, encode_observed, kept_vertices};
use crate::error::Error;
use crate::figures::MeshFigures;
use crate::goal::Goal;
use crate::observer::{Event, Observer, SimplifyProgress, Stage, Stopped, begin};
use crate::parts::map;
use crate::prepared::{PreparedModel, Survey};
use crate::surface_change::{ChangedSurface, SurfaceChange, surface_change};
use crate::text::counted;
use fit::Fitted;
pub use groups::CollapseRules;
pub(crate) use groups::{TriangleGoal, simplify_all};
use normals::{Copies, Rebuilding, RebuiltPart, kept_notes, redraw};
pub use normals::{NormalCounts, Normals};
pub use order::LevelOrder;
pub(crate) use order::PartCollapses;
pub(crate) use parts::{Compact, Part, UsedVertices, diagonal};
pub use report::{SimplifyFigures, StoppedReport};
pub(crate) use warning::warning;

/// The number of points at which the result is compared with the original, in each direction.
const POINTS: usize = 5_000;

/// How a model is simplified.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct SimplifyOptions {
    /// The number of triangles to keep, and the maximum error.
    pub goal: Goal,
    /// What collapses may do, and what they cost.
    pub rules: CollapseRules,
    /// Whether normals are kept or rebuilt.
    pub normals: Normals,
    /// What is rounded when a GLB is packed into few bytes; by default weights of joints to 16 bits.
    pub rounding: Rounding,
    /// Whether the vertices that are left are moved closer to the original surface: see [`SimplifyOptions::with_fit`].
    pub fit: bool,
    /// Whether the result is compared with the original, which takes as long as the collapses.
    pub measure: bool,
    /// Whether the collapses, and the bytes of a file, are proven.
    pub verify: bool,
    /// The format in which the result will be written. A scene that is written as GLB keeps the unused vertices that other parts of it
    /// may refer to by number.
    pub format: Format,
}

impl SimplifyOptions {
    /// Sets the goal.
    pub fn new(goal: Goal) -> Self {
        let (rules, normals) = (CollapseRules::default(), Normals::default());
        Self {
            goal,
            rules,
            normals,
            rounding: Rounding::Weights,
            fit: false,
            measure: true,
            verify: true,
            format: Format::Ply,
        }
    }

    /// Sets what collapses may do, and what they cost.
    #[must_use]
    pub fn with_rules(self, rules: CollapseRules) -> Self {
        Self { rules, ..self }
    }

    /// Sets whether normals are kept or rebuilt.
    #[must_use]
    pub fn with_normals(self, normals: Normals) -> Self {
        Self { normals, ..self }
    }

    /// Sets what is rounded when a GLB is packed into few bytes.
    #[must_use]
    pub fn with_rounding(self, rounding: Rounding) -> Self {
        Self { rounding, ..self }
    }

    /// Sets whether the vertices that are left are moved closer to the original surface, which lowers the mean distance by a third or more where
    /// it is curved. They are no vertices of the source any more, so that levels of detail cannot share them. Vertices at borders stay, those that
    /// touch parts in other places of the scene, and those of parts whose positions a GLB cannot change, which a note names.
    ///
    /// ```
    /// use tristrip_io::{Format, read};
    /// use tristrip_pipeline::{Goal, SimplifyOptions, simplify};
    /// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj)?;
    /// let fitted = simplify(&model, &SimplifyOptions::new(Goal::default()).with_fit(true))?;
    /// assert_eq!(fitted.redrawn.model.parts[0].mesh.positions()[1], [1.0, 0.0, 0.0], "at a border");
    /// assert_eq!(fitted.moved_positions, Some(0));
    /// # Ok::<(), tristrip_pipeline::Error>(())
    /// ```
    #[must_use]
    pub fn with_fit(self, fit: bool) -> Self {
        Self { fit, ..self }
    }

    /// Sets whether the result is compared with the original.
    ///
    /// ```
    /// use tristrip_io::{Format, read};
    /// use tristrip_pipeline::{Goal, SimplifyOptions, simplify};
    /// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj)?;
    /// let options = SimplifyOptions::new(Goal::default()).with_measure(false);
    /// assert!(simplify(&model, &options)?.change.is_none());
    /// # Ok::<(), tristrip_pipeline::Error>(())
    /// ```
    #[must_use]
    pub fn with_measure(self, measure: bool) -> Self {
        Self { measure, ..self }
    }

    /// Sets whether the collapses are proven.
    #[must_use]
    pub fn with_verify(self, verify: bool) -> Self {
        Self { verify, ..self }
    }

    /// Sets the format in which the result will be written.
    #[must_use]
    pub fn with_format(self, format: Format) -> Self {
        Self { format, ..self }
    }
}

/// A simplified model.
#[derive(Debug)]
#[non_exhaustive]
pub struct Simplified {
    /// The model with fewer triangles, over the vertices that it uses.
    pub redrawn: Redrawn,
    /// The collapses, and how they ended.
    pub collapses: Collapses,
    /// How far the surface is from the original; `None` if it was not measured.
    pub change: Option<SurfaceChange>,
    /// The number of positions that the fit moved; `None` if nothing was fitted.
    pub moved_positions: Option<usize>,
    /// What happened to the normals of the parts.
    pub normals: NormalCounts,
    /// A sentence on the goal, if it was not reached: what held it back, and what to try.
    pub warning: Option<String>,
    /// The counts of the source mesh.
    pub mesh: MeshFigures,
    /// Notes of the reader, on what was dropped, and on locked vertices.
    pub notes: Vec<String>,
    /// Whether the collapses are proven.
    pub proven: bool,
    /// Whether the observer ended it: with fewer collapses than requested, or without the fit or the comparison. See [`Observer::simplifies`].
    pub interrupted: bool,
    options: SimplifyOptions,
    /// The vertices of each part that were added for new normals and positions.
    copies: Vec<Option<Copies>>,
}

/// Simplifies a model by half-edge collapses, the cheapest first. Borders between the parts of a mesh collapse on both sides; vertices that touch parts
/// in other places of the scene stay.
///
/// # Errors
/// As of [`simplify_observed`].
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::{Amount, Goal, SimplifyOptions, simplify};
/// // A flat fan of four triangles around a vertex, which one collapse removes.
/// let corners = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0\n";
/// let model = read([corners, "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"].concat().as_bytes(), Format::Obj)?;
/// let goal = Goal { amount: Some(Amount::Triangles(2)), ..Goal::default() };
/// let simplified = simplify(&model, &SimplifyOptions::new(goal))?;
/// assert_eq!((simplified.collapses.triangles_after, simplified.redrawn.used, simplified.proven), (2, 4, true));
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn simplify(model: &Model, options: &SimplifyOptions) -> Result<Simplified, Error> {
    simplify_observed(model, options, &())
}

/// Does the same, and reports each stage to an observer.
///
/// # Errors
/// The maximum error is negative or not a number, a part is too large, the collapses are not proven, or the observer cancelled.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::{Deviation, Goal, SimplifyOptions, simplify_observed};
/// let corners = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0\n";
/// let model = read([corners, "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"].concat().as_bytes(), Format::Obj)?;
/// let goal = Goal { amount: None, deviation: Deviation::Percent(1.0) };
/// let simplified = simplify_observed(&model, &SimplifyOptions::new(goal), &())?;
/// assert!(simplified.collapses.surface_error <= 0.03);
/// assert_eq!(simplified.encode(&())?.faces, Some(simplified.collapses.triangles_after));
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn simplify_observed(
    model: &Model,
    options: &SimplifyOptions,
    observer: &dyn Observer,
) -> Result<Simplified, Error> {
    let goal = |count| {
        options.goal.amount.map_or(TriangleGoal::Fewest, |amount| TriangleGoal::OfModel(amount.of(count)))
    };
    simplify_to(model, options, goal, observer)
}

/// Simplifies each part to a number of triangles of its own, instead of the amount of the goal. Parts of a mesh that share positions are simplified
/// to the sum of theirs. This compares with the result of another program.
///
/// # Errors
/// There is not one number per part, or as of [`simplify_observed`].
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::{Goal, SimplifyOptions, simplify_parts};
/// let corners = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0\n";
/// let model = read([corners, "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"].concat().as_bytes(), Format::Obj)?;
/// let options = SimplifyOptions::new(Goal::default());
/// assert_eq!(simplify_parts(&model, &[2], &options)?.collapses.triangles_after, 2);
/// assert!(simplify_parts(&model, &[2, 2], &options).is_err());
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn simplify_parts(
    model: &Model,
    triangles: &[usize],
    options: &SimplifyOptions,
) -> Result<Simplified, Error> {
    if triangles.len() != model.parts.len() {
        let found = format!("{} for {}", triangles.len(), counted(model.parts.len(), "part"));
        let expected = "a number of triangles for each part";
        return Err(tristrip::Error::Parameter { name: "triangles", found, expected }.into());
    }
    simplify_to(model, options, |_| TriangleGoal::OfParts(triangles), &())
}

/// Simplifies a model to the goal for its number of triangles.
fn simplify_to<'a>(
    model: &Model,
    options: &SimplifyOptions,
    goal: impl FnOnce(usize) -> TriangleGoal<'a>,
    observer: &dyn Observer,
) -> Result<Simplified, Error> {
    // 1. The triangles of each part.
    let surveyed = Survey::new(model, StripifyOptions::default(), observer)?;
    let (mut parts, skipped) = fans(&surveyed.prepared, options.rules)?;
    let place_notes = place_notes(&surveyed.prepared, skipped);
    let (mesh, mut notes) = (surveyed.mesh, surveyed.notes);
    let mut normals = Rebuilding::choose(options.normals, model, options.format, &mut parts)?;

    // 2. The collapses.
    begin(observer, Stage::Simplify)?;
    let count = parts.iter().map(Part::triangle_count).sum();
    let target_error = options.goal.deviation.units(diagonal(&parts));
    let all = simplify_all(&parts, goal(count), Some(target_error), options.rules, observer)?;
    let (collapses, done) = (all.summary(&parts)?, all.parts);
    observer.event(Event::Simplified(&collapses));
    let left = collapses.triangles_after;
    let progress = SimplifyProgress { before: count, left, goal: collapses.target_triangles.unwrap_or(0) };
    let goes_on = || observer.simplifies(progress);
    let mut interrupted = ended(all.interrupted, observer, progress)?;
    if options.normals == Normals::Auto {
        normals.choose_unfit(model, options.format, &parts, &done)?;
    }
    let of_parts = place_notes.into_iter().chain(locked_note(collapses.locked_vertices));
    let new_notes = normals.notes.iter().cloned().chain(of_parts).collect();
    let mut add_notes = |new: Vec<String>| {
        new.iter().for_each(|note| observer.event(Event::Note(note)));
        notes.extend(new);
    };
    add_notes(new_notes);
    let warning = warning(&collapses, options.goal.deviation, options.rules.lock_borders);
    warning.iter().for_each(|warning| observer.event(Event::Warning(warning)));

    // 3. The proof of the collapses.
    if options.verify {
        prove(&done, &collapses, observer)?;
        interrupted = ended(interrupted, observer, progress)?;
    }

    // 4. The vertices that are left, closer to the original.
    let (mut fitted, mut moved_positions) = (vec![None; parts.len()], None);
    if options.fit && !interrupted {
        begin(observer, Stage::Fit)?;
        let fixed = tristrip_io::fixed_vertices(model, NewValues::Positions, options.format)?;
        let is_fixed: Vec<bool> = fixed.iter().map(Option::is_some).collect();
        let Fitted { meshes, moved } = fit::fit(&parts, &done, &is_fixed, &goes_on)?;
        (fitted, moved_positions) = (meshes, Some(moved));
        observer.event(Event::Fitted { positions: moved });
        add_notes(kept_notes("positions", fixed.into_iter().flatten()));
        interrupted = ended(interrupted, observer, progress)?;
    }

    // 5. The model without the vertices that became unused.
    let rebuilt = normals.rebuild(&parts, &done, &fitted)?;
    let base = |(part, done): (&Part<'_>, &PartCollapses)| {
        let mut corners = done.sequence.drawn(0)?.into_flattened();
        part.compact.used.outward(&mut corners);
        Ok(corners)
    };
    let triangles = parts.iter().zip(&done).map(base).collect::<Result<_, Error>>()?;
    let (redrawn, copies) = redraw(model, &parts, &rebuilt, triangles, options.format)?;

    // 6. How far the result is from the original.
    let mut measured = None;
    if options.measure && !interrupted {
        begin(observer, Stage::Compare)?;
        let change = change(&parts, &done, &rebuilt, &texture_sizes(model))?;
        observer.event(Event::Compared(&change));
        measured = Some(change);
    }
    if interrupted {
        add_notes(vec![Stopped::Interrupt.note().into()]);
    }
    Ok(Simplified {
        redrawn,
        copies,
        collapses,
        change: measured,
        moved_positions,
        normals: normals.counts(&parts),
        warning,
        mesh,
        notes,
        proven: options.verify,
        interrupted,
        options: *options,
    })
}

/// Returns whether an observer has ended a simplification, or ends it now.
///
/// # Errors
/// It cancels.
fn ended(interrupted: bool, observer: &dyn Observer, progress: SimplifyProgress) -> Result<bool, Error> {
    let interrupted = interrupted || !observer.simplifies(progress);
    if interrupted && observer.is_cancelled() { Err(Error::Cancelled) } else { Ok(interrupted) }
}

impl Simplified {
    /// Returns the vertex of the source model that each vertex of a part is, or is a copy of with another normal or position.
    ///
    /// # Errors
    /// There is no such part.
    ///
    /// ```
    /// use tristrip_io::{Format, read};
    /// use tristrip_pipeline::{Amount, Goal, SimplifyOptions, simplify};
    /// let corners = "v 1 1 0\nv 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\n";
    /// let model = read([corners, "f 2 3 1\nf 3 4 1\nf 4 5 1\nf 5 2 1\n"].concat().as_bytes(), Format::Obj)?;
    /// let goal = Goal { amount: Some(Amount::Triangles(2)), ..Goal::default() };
    /// let simplified = simplify(&model, &SimplifyOptions::new(goal))?;
    /// assert_eq!(simplified.source_vertices(0)?, [1, 2, 3, 4]);
    /// # Ok::<(), tristrip_pipeline::Error>(())
    /// ```
    pub fn source_vertices(&self, part: usize) -> Result<Vec<u32>, Error> {
        let mut vertices = self.redrawn.old_vertices(part)?;
        if let Some(Some(Copies { first, sources })) = self.copies.get(part) {
            for vertex in &mut vertices {
                let source = vertex.checked_sub(*first).and_then(|copy| sources.get(copy as usize));
                *vertex = source.copied().unwrap_or(*vertex);
            }
        }
        Ok(vertices)
    }

    /// Encodes the simplified model as a triangle list in the format of the options, and proves the bytes if requested.
    ///
    /// # Errors
    /// The format cannot store the model, the bytes are not proven, or the observer cancelled.
    pub fn encode(&self, observer: &dyn Observer) -> Result<Encoded, Error> {
        self.encode_as(self.options.format, self.options.verify, observer)
    }

    /// Does the same in another format, and with or without the proof of the bytes. A scene that was simplified for a GLB keeps its unused vertices.
    ///
    /// # Errors
    /// As of [`Simplified::encode`].
    pub fn encode_as(&self, format: Format, verify: bool, observer: &dyn Observer) -> Result<Encoded, Error> {
        let model = &self.redrawn.model;
        let mut notes = kept_vertices(&self.redrawn, observer);
        let drawings: Vec<Drawing<'_>> = model.parts.iter().map(|_| Drawing::Faces).collect();
        let options = EncodeOptions::new(format).with_layout(tristrip::Layout::List);
        let options = options.with_pack(Some(self.options.rounding)).with_verify(verify);
        let encoded = encode_observed(model, &drawings, &options, observer)?;
        notes.extend(encoded.notes);
        Ok(Encoded { notes, ..encoded })
    }
}

/// Proves the collapses of all parts.
pub(crate) fn prove(
    done: &[PartCollapses],
    collapses: &Collapses,
    observer: &dyn Observer,
) -> Result<(), Error> {
    begin(observer, Stage::Prove)?;
    let proofs = map(done, |done| done.sequence.check());
    proofs.into_iter().collect::<Result<(), _>>().map_err(|why| Error::Unproven(why.to_string()))?;
    observer.event(Event::Proven { faces: collapses.triangles_after });
    Ok(())
}

/// Returns the triangles of all parts, polygons as fans around their first corner, and the number of places that were not compared.
pub(crate) fn fans<'a>(
    prepared: &PreparedModel<'a>,
    rules: CollapseRules,
) -> Result<(Vec<Part<'a>>, usize), Error> {
    let triangles = map(prepared.parts(), |part| part.surface.faces().fans().into_owned());
    let meshes = prepared.parts().iter().map(|part| part.mesh);
    Ok(Part::of_all(meshes.zip(triangles).collect(), prepared.places(), rules.weld_distance)?)
}

/// Returns the width and height of the texture of each part's base colour at the first texture coordinates, where they are known.
fn texture_sizes(model: &Model) -> Vec<Option<[u32; 2]>> {
    if let (None, Some(materials)) = (&model.scene, &model.materials) {
        return model.parts.iter().map(|part| materials.image_size(part.material.as_deref()?)).collect();
    }
    let appearance = model.scene.as_ref().and_then(|scene| scene.appearance().ok());
    let size = |part: usize| {
        let appearance = appearance.as_ref()?;
        let texture = appearance.materials.get(part)?.texture.filter(|texture| texture.coordinates == 0)?;
        appearance.images.get(texture.image)?.size()
    };
    (0..model.parts.len()).map(size).collect()
}

/// Measures how far the parts are from what they were.
fn change(
    parts: &[Part<'_>],
    done: &[PartCollapses],
    rebuilt: &[Option<RebuiltPart>],
    textures: &[Option<[u32; 2]>],
) -> Result<SurfaceChange, Error> {
    let drawn = |(done, rebuilt): (&PartCollapses, &Option<RebuiltPart>)| match rebuilt {
        Some(rebuilt) => Ok(rebuilt.triangles_of_mesh()),
        None => Ok(done.sequence.drawn(0)?.into_flattened()),
    };
    let after = done.iter().zip(rebuilt).map(drawn).collect::<Result<Vec<_>, Error>>()?;
    let mesh = |(part, rebuilt): (&'_ Part<'_>, &Option<RebuiltPart>)| {
        let mesh = rebuilt.as_ref().map_or(&*part.compact.mesh, |rebuilt| &rebuilt.mesh);
        Ok(part.shown(mesh)?.into_owned())
    };
    let shown = parts.iter().zip(rebuilt).map(mesh).collect::<Result<Vec<_>, Error>>()?;
    let surfaces: Vec<ChangedSurface<'_>> = parts
        .iter()
        .zip(&after)
        .zip(&shown)
        .zip(textures)
        .map(|(((part, after), mesh), &texels)| ChangedSurface {
            mesh,
            before: part.triangles(),
            after,
            texels,
        })
        .collect();
    surface_change(&surfaces, POINTS)
}

/// Returns notes on nodes that could not be followed, and on places that were not compared.
pub(crate) fn place_notes(prepared: &PreparedModel<'_>, skipped: usize) -> Vec<String> {
    let not_compared = "not compared with other parts, gaps may open there";
    let skipped = (skipped > 0).then(|| format!("{} of a part {not_compared}", counted(skipped, "copy")));
    prepared.places().note().into_iter().chain(skipped).collect()
}

/// Returns a note on the locked vertices, if there are any.
pub(crate) fn locked_note(locked: usize) -> Option<String> {
    (locked > 0).then(|| {
        format!("locked {} that touch parts in other places of the scene", counted(locked, "vertex"))
    })
}
