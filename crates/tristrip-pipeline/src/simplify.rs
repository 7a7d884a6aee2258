//! Simplification of a whole model. The collapses are verified, and unused vertices are dropped.
//!
//! Parts that the same nodes place and that share positions, such as the materials of one mesh, are
//! simplified as one surface: both sides of their border collapse together. Vertices that touch
//! parts placed by other nodes are kept. Errors and the bounding box are in scene coordinates.

mod fit;
mod groups;
mod normals;
mod order;
mod parts;
pub(crate) mod touching;
mod vanishing;
mod warning;

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use tristrip::StripifyOptions;
use tristrip_io::gltf::Rounding;
use tristrip_io::{Drawing, Format, Model, NewValues, Redrawn};

use crate::collapses::{Collapses, percent_of};
use crate::encode::{self, kept_vertices, true_or_null};
use crate::error::{Error, UnprovenMetrics};
use crate::figures::MeshProperties;
use crate::goal::Goal;
use crate::metrics::rounded;
use crate::observer::{Observer, SearchStop, SimplifyProgress, Stage, begin};
use crate::parts::map;
use crate::prepared::{PreparedModel, Survey};
use crate::surface_change::{ChangedSurface, SurfaceChange, surface_change};
use crate::text::counted;
use fit::Fitted;
pub use groups::CollapseRules;
pub(crate) use groups::{TriangleGoal, simplify_all};
use normals::{Copies, Rebuilding, RebuiltPart, kept_notes, redraw};
pub use normals::{Normals, PartNormals};
pub use order::LevelOrder;
pub(crate) use order::PartCollapses;
pub(crate) use parts::{Compact, Part, UsedVertices, diagonal};
pub(crate) use warning::warning;

/// The number of points for comparing the result with the original, in each direction.
const POINTS: usize = 5_000;

/// Options for simplifying a model.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Options {
    /// The number of triangles to keep, and the maximum error.
    pub goal: Goal,
    /// The constraints on collapses, and their cost function.
    pub rules: CollapseRules,
    /// Whether normals are kept or rebuilt.
    pub normals: Normals,
    /// The values that are rounded when a GLB is packed. The default rounds joint weights to 16
    /// bits.
    pub rounding: Rounding,
    /// Whether the remaining vertices are moved closer to the original surface; see
    /// [`Options::with_fit`].
    pub fit: bool,
    /// Whether the result is compared with the original. This takes as long as the collapses.
    pub measure: bool,
    /// Whether the collapses, and the bytes of a file, are verified.
    pub verify: bool,
    /// The format that the result will be written in. In a scene written as GLB, unused vertices
    /// are kept if other data of the scene may refer to them by index.
    pub format: Format,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            goal: Goal::default(),
            rules: CollapseRules::default(),
            normals: Normals::default(),
            rounding: Rounding::Weights,
            fit: false,
            measure: true,
            verify: true,
            format: Format::Ply,
        }
    }
}

impl Options {
    tristrip::setters! {
        /// Sets the number of triangles to keep, and the maximum error.
        with_goal(goal: Goal);

        /// Sets the constraints on collapses, and their cost function.
        with_rules(rules: CollapseRules);

        /// Sets whether normals are kept or rebuilt.
        with_normals(normals: Normals);

        /// Sets what is rounded when a GLB is packed.
        with_rounding(rounding: Rounding);

        /// Sets whether the remaining vertices are moved closer to the original surface. On curved
        /// surfaces, this reduces the mean distance by a third or more. The moved vertices are no
        /// longer vertices of the source, so levels of detail cannot share them.
        ///
        /// Vertices do not move at borders, where they touch parts placed by other nodes, and in
        /// parts whose positions a GLB cannot change. A note gives the reasons for such parts.
        ///
        /// ```
        /// use tristrip_io::{Format, read};
        /// use tristrip_pipeline::simplify;
        /// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj)?;
        /// let fitted = simplify::run(&model, &simplify::Options::default().with_fit(true), &())?;
        /// assert_eq!(fitted.redrawn.model.parts[0].mesh.positions()[1], [1.0, 0.0, 0.0], "at a border");
        /// assert_eq!(fitted.moved_positions, Some(0));
        /// # Ok::<(), tristrip_pipeline::Error>(())
        /// ```
        with_fit(fit: bool);

        /// Sets whether the result is compared with the original.
        with_measure(measure: bool);

        /// Sets whether the collapses are verified.
        with_verify(verify: bool);

        /// Sets the format that the result will be written in.
        with_format(format: Format);
    }
}

/// A simplified model. The field names are the keys of the JSON report.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Outcome {
    /// The model with fewer triangles, over the vertices that it uses.
    #[serde(skip)]
    pub redrawn: Redrawn,
    /// Whether replaying the collapses removes exactly the recorded triangles, and a written file
    /// draws exactly the remaining triangles when it is read back; `null` in reports if
    /// verification was disabled.
    #[serde(serialize_with = "true_or_null")]
    #[cfg_attr(feature = "schema", schemars(with = "Option<bool>"))]
    pub proven: bool,
    /// The results of the collapses.
    #[serde(flatten)]
    pub collapses: Collapses,
    /// The number of vertices in use in the input.
    pub vertices_before: usize,
    /// The number of vertices in use in the result.
    pub vertices_after: usize,
    /// The number of positions that were moved closer to the original surface; only if a fit was
    /// requested. A position that several vertices or parts share counts once.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub moved_positions: Option<usize>,
    /// The distance of the surface from the original; `None` if it was not measured.
    #[serde(flatten, serialize_with = "deviations_or_nulls")]
    #[cfg_attr(feature = "schema", schemars(schema_with = "deviations_schema"))]
    pub deviations: Option<Deviations>,
    /// The number of parts per treatment of their normals. Parts without normals are not counted.
    pub normals: PartNormals,
    /// The number of parts: glTF primitives or OBJ materials.
    pub parts: usize,
    /// A warning that explains why the goal was not reached, and what to try; `None` if it was
    /// reached.
    pub warning: Option<String>,
    /// Human-readable notes on data that was read, dropped, changed or unusual, on locked vertices,
    /// and on an interruption.
    pub notes: Vec<String>,
    /// The vertex, edge and face counts of the source mesh.
    #[serde(skip)]
    pub mesh: MeshProperties,
    /// Whether the observer stopped the simplification. The result then has fewer collapses than
    /// requested, or the fit or the comparison is missing. See [`Observer::simplifies`].
    #[serde(skip)]
    pub interrupted: bool,
    #[serde(skip)]
    rounding: Rounding,
    /// For each part, the vertices that were added for new normals and positions.
    #[serde(skip)]
    copies: Vec<Option<Copies>>,
}

/// The distances between a simplified surface and the original, rounded to six decimals. The field
/// names are the keys of the JSON report.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Deviations {
    /// The maximum distance found between the original and the result, in mesh units, over 5,000
    /// points of each surface and as many removed vertices; `None` if the surfaces were not
    /// compared.
    pub largest_deviation: f64,
    /// `largest_deviation` in percent of `diagonal`.
    pub largest_deviation_percent: f64,
    /// The root mean square of the distances of the points, in both directions, in mesh units.
    pub rms_deviation: f64,
    /// `rms_deviation` in percent of `diagonal`.
    pub rms_deviation_percent: f64,
    /// The root mean square of the angles between the normals at a point and at the nearest point
    /// of the result. Vertex normals are interpolated; a triangle without vertex normals has its
    /// face normal.
    pub normal_deviation_degrees: f64,
    /// The root mean square of the distances between texture coordinates (`TEXCOORD_0`), in percent
    /// of the size of the texture; `None` if there are none.
    pub uv_deviation_percent: Option<f64>,
    /// The root mean square of these distances in texels, over the parts with a base colour
    /// texture; `None` if there are none.
    pub uv_deviation_texels: Option<f64>,
    /// The unrounded values.
    #[serde(skip)]
    pub change: SurfaceChange,
}

impl Deviations {
    const KEYS: [&str; 7] = [
        "largest_deviation",
        "largest_deviation_percent",
        "rms_deviation",
        "rms_deviation_percent",
        "normal_deviation_degrees",
        "uv_deviation_percent",
        "uv_deviation_texels",
    ];

    fn of(change: SurfaceChange, diagonal: f64) -> Self {
        Self {
            largest_deviation: rounded(change.largest),
            largest_deviation_percent: percent_of(change.largest, diagonal),
            rms_deviation: rounded(change.rms),
            rms_deviation_percent: percent_of(change.rms, diagonal),
            normal_deviation_degrees: rounded(change.normal_degrees),
            uv_deviation_percent: change.uv.map(|uv| rounded(100.0 * uv)),
            uv_deviation_texels: change.uv_texels.map(rounded),
            change,
        }
    }
}

/// Serializes deviations, or `null` for every key if they were not measured.
#[expect(clippy::ref_option, reason = "the signature that serde calls")]
fn deviations_or_nulls<S: Serializer>(found: &Option<Deviations>, serializer: S) -> Result<S::Ok, S::Error> {
    if let Some(found) = found {
        return found.serialize(serializer);
    }
    let mut map = serializer.serialize_map(Some(Deviations::KEYS.len()))?;
    for key in Deviations::KEYS {
        map.serialize_entry(key, &None::<f64>)?;
    }
    map.end()
}

/// Describes the output of [`deviations_or_nulls`]: every key may be `null`.
#[cfg(feature = "schema")]
fn deviations_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
    let mut schema = <Deviations as schemars::JsonSchema>::json_schema(generator);
    for key in Deviations::KEYS {
        if let Some(kind) = schema.pointer_mut(&format!("/properties/{key}/type")) {
            *kind = ["number", "null"].into();
        }
    }
    schema
}

/// Simplifies a model by half-edge collapses, cheapest first. Borders between the parts of a mesh
/// collapse on both sides. Vertices that touch parts placed by other nodes are kept.
///
/// # Errors
/// The maximum error is negative or NaN, a part is too large, the collapses fail verification, or
/// the observer cancelled the operation.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::{Amount, Deviation, Goal, simplify};
/// // A flat fan of four triangles around a vertex. One collapse removes the vertex.
/// let corners = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0\n";
/// let model = read([corners, "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"].concat().as_bytes(), Format::Obj)?;
/// let goal = Goal { amount: Some(Amount::Triangles(2)), deviation: Deviation::Percent(1.0) };
/// let simplified = simplify::run(&model, &simplify::Options::default().with_goal(goal), &())?;
/// assert_eq!((simplified.collapses.triangles_after, simplified.vertices_after, simplified.proven), (2, 4, true));
/// assert!(simplified.collapses.surface_error <= 0.03);
/// assert_eq!(simplified.encode(Format::Glb, true, &())?.faces, Some(2));
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn run(model: &Model, options: &Options, observer: &dyn Observer) -> Result<Outcome, Error> {
    let goal = |count| {
        options.goal.amount.map_or(TriangleGoal::Fewest, |amount| TriangleGoal::OfModel(amount.of(count)))
    };
    simplify_to(model, options, goal, observer)
}

/// Simplifies each part to its own number of triangles. The number of triangles of the goal is
/// ignored. Parts of a mesh that share positions are simplified to the sum of their numbers. Use
/// this function to compare the result with the result of another program.
///
/// # Errors
/// The length of `triangles` differs from the number of parts, or [`run`] would fail.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::simplify;
/// let corners = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0\n";
/// let model = read([corners, "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"].concat().as_bytes(), Format::Obj)?;
/// let options = simplify::Options::default();
/// assert_eq!(simplify::run_parts(&model, &[2], &options, &())?.collapses.triangles_after, 2);
/// assert!(simplify::run_parts(&model, &[2, 2], &options, &()).is_err());
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn run_parts(
    model: &Model,
    triangles: &[usize],
    options: &Options,
    observer: &dyn Observer,
) -> Result<Outcome, Error> {
    if triangles.len() != model.parts.len() {
        let found = format!("{} for {}", triangles.len(), counted(model.parts.len(), "part"));
        let expected = "a number of triangles for each part";
        return Err(tristrip::Error::Parameter { name: "triangles", found, expected }.into());
    }
    simplify_to(model, options, |_| TriangleGoal::OfParts(triangles), observer)
}

/// Simplifies a model to a goal for its number of triangles.
fn simplify_to<'a>(
    model: &Model,
    options: &Options,
    goal: impl FnOnce(usize) -> TriangleGoal<'a>,
    observer: &dyn Observer,
) -> Result<Outcome, Error> {
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
    let left = collapses.triangles_after;
    let progress = SimplifyProgress { before: count, left, goal: collapses.target_triangles.unwrap_or(0) };
    let goes_on = || observer.simplifies(progress);
    let mut interrupted = ended(all.interrupted, observer, progress)?;
    if options.normals == Normals::Auto {
        normals.choose_unfit(model, options.format, &parts, &done)?;
    }
    let of_parts = place_notes.into_iter().chain(locked_note(collapses.locked_vertices));
    notes.extend(normals.notes.iter().cloned().chain(of_parts));
    let warning = warning(&collapses, options.goal.deviation, options.rules.lock_borders);

    // 3. The proof of the collapses.
    if options.verify {
        prove(&done, &collapses, observer)?;
        interrupted = ended(interrupted, observer, progress)?;
    }

    // 4. Move the remaining vertices closer to the original.
    let (mut fitted, mut moved_positions) = (vec![None; parts.len()], None);
    if options.fit && !interrupted {
        begin(observer, Stage::Fit)?;
        let fixed = tristrip_io::fixed_vertices(model, NewValues::Positions, options.format)?;
        let is_fixed: Vec<bool> = fixed.iter().map(Option::is_some).collect();
        let Fitted { meshes, moved } = fit::fit(&parts, &done, &is_fixed, &goes_on)?;
        (fitted, moved_positions) = (meshes, Some(moved));
        notes.extend(kept_notes("positions", fixed.into_iter().flatten()));
        interrupted = ended(interrupted, observer, progress)?;
    }

    // 5. The model without unused vertices.
    begin(observer, Stage::Rebuild)?;
    let rebuilt = normals.rebuild(&parts, &done, &fitted)?;
    let base = |(part, done): (&Part<'_>, &PartCollapses)| {
        let mut corners = done.sequence.drawn(0)?.into_flattened();
        part.compact.used.outward(&mut corners);
        Ok(corners)
    };
    let triangles = parts.iter().zip(&done).map(base).collect::<Result<_, Error>>()?;
    let (redrawn, copies) = redraw(model, &parts, &rebuilt, triangles, options.format)?;

    // 6. The distance between the result and the original.
    let mut measured = None;
    if options.measure && !interrupted {
        begin(observer, Stage::Compare)?;
        let change = change(&parts, &done, &rebuilt, &texture_sizes(model))?;
        measured = Some(Deviations::of(change, collapses.diagonal));
    }
    if interrupted {
        notes.push(SearchStop::Interrupt.note().into());
    }
    Ok(Outcome {
        proven: options.verify,
        vertices_before: mesh.vertices - mesh.unreferenced_vertices,
        vertices_after: redrawn.used,
        parts: redrawn.model.parts.len(),
        redrawn,
        copies,
        collapses,
        deviations: measured,
        moved_positions,
        normals: normals.counts(&parts),
        warning,
        mesh,
        notes,
        interrupted,
        rounding: options.rounding,
    })
}

/// Returns whether an observer has stopped a simplification, or stops it now.
///
/// # Errors
/// The observer cancelled the operation.
fn ended(interrupted: bool, observer: &dyn Observer, progress: SimplifyProgress) -> Result<bool, Error> {
    let interrupted = interrupted || !observer.simplifies(progress);
    if interrupted && observer.is_cancelled() { Err(Error::Cancelled) } else { Ok(interrupted) }
}

impl Outcome {
    /// Returns the source vertex of each vertex of a part. A vertex with a new normal or position
    /// is a copy of its source vertex.
    ///
    /// # Errors
    /// The part does not exist.
    ///
    /// ```
    /// use tristrip_io::{Format, read};
    /// use tristrip_pipeline::{Amount, Goal, simplify};
    /// let corners = "v 1 1 0\nv 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\n";
    /// let model = read([corners, "f 2 3 1\nf 3 4 1\nf 4 5 1\nf 5 2 1\n"].concat().as_bytes(), Format::Obj)?;
    /// let goal = Goal { amount: Some(Amount::Triangles(2)), ..Goal::default() };
    /// let simplified = simplify::run(&model, &simplify::Options::default().with_goal(goal), &())?;
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

    /// Encodes the simplified model as triangle lists, and verifies the bytes if requested. A scene
    /// that was simplified for GLB keeps its unused vertices in other formats, too.
    ///
    /// # Errors
    /// The format cannot store the model, the bytes fail verification, or the observer cancelled
    /// the operation.
    pub fn encode(
        &self,
        format: Format,
        verify: bool,
        observer: &dyn Observer,
    ) -> Result<encode::Outcome, Error> {
        let model = &self.redrawn.model;
        let drawings: Vec<Drawing<'_>> = model.parts.iter().map(|_| Drawing::Faces).collect();
        let options = encode::Options::new(format).with_layout(tristrip::Layout::List);
        let options = options.with_pack(Some(self.rounding)).with_verify(verify);
        let encoded = encode::run(model, &drawings, &options, observer);
        let mut encoded =
            encoded.map_err(|error| error.with_metrics(|| UnprovenMetrics::Simplified(self.collapses)))?;
        encoded.notes.splice(0..0, kept_vertices(&self.redrawn));
        Ok(encoded)
    }
}

/// Verifies the collapses of all parts.
pub(crate) fn prove(
    done: &[PartCollapses],
    collapses: &Collapses,
    observer: &dyn Observer,
) -> Result<(), Error> {
    begin(observer, Stage::Prove)?;
    let proofs = map(done, |done| done.sequence.check());
    proofs.into_iter().collect::<Result<(), _>>().map_err(|why| {
        Error::unproven(why.to_string()).with_metrics(|| UnprovenMetrics::Simplified(*collapses))
    })
}

/// Returns the triangles of all parts, with polygons as fans around their first corner, and the
/// number of instances that were not compared.
pub(crate) fn fans<'a>(
    prepared: &PreparedModel<'a>,
    rules: CollapseRules,
) -> Result<(Vec<Part<'a>>, usize), Error> {
    let triangles = map(prepared.parts(), |part| part.surface.faces().fans().into_owned());
    let meshes = prepared.parts().iter().map(|part| part.mesh);
    Ok(Part::of_all(meshes.zip(triangles).collect(), prepared.places(), rules.weld_distance)?)
}

/// Returns the width and height of each part's base colour texture, if it uses the first texture
/// coordinates and its size is known.
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

/// Measures the distance between the parts and their originals.
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

/// Returns notes on nodes that could not be evaluated, and on instances that were not compared.
pub(crate) fn place_notes(prepared: &PreparedModel<'_>, skipped: usize) -> Vec<String> {
    let not_compared = "not compared with other parts: gaps may open there";
    let skipped = (skipped > 0).then(|| format!("{} {not_compared}", counted(skipped, "instance")));
    prepared.places().note().into_iter().chain(skipped).collect()
}

/// Returns a note on the locked vertices; `None` if there are none.
pub(crate) fn locked_note(locked: usize) -> Option<String> {
    (locked > 0).then(|| format!("locked {} that touch parts of other nodes", counted(locked, "vertex")))
}
