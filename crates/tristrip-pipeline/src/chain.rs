//! Level-of-detail chains: a model at a few chosen sizes over one vertex buffer. Every level uses a
//! prefix of the vertices.
//!
//! ```text
//! Model ─ one sequence of collapses per part ─▶ levels ─▶ vertices in reverse order of removal
//!                                                  │                 │
//!    proof of each level from the bytes ◀─ encode ─┴─ strips/lists ◀─┘
//! ```
//! # Algorithm
//! 1. Every part is simplified once, down to the coarsest level or the error limit. Parts that
//!    share a border are simplified together. The collapses of all parts are merged into one order,
//!    by cost. A level is the first point in this order at which the number of triangles is at most
//!    the requested number. Each level is therefore a simplification of the next finer one.
//! 2. Vertices are numbered in reverse order of removal, after the vertices of the coarsest level.
//!    A level, and any point between two levels, uses a prefix of the vertices. A program can load
//!    a coarse level first and append vertices to its buffer. The vertices of coarse levels are
//!    spread over the surface, and their memory order has no locality.
//! 3. Each level gets its own strips or triangle list. Vertices keep their normals in all levels,
//!    because a repaired normal would need a new vertex.
//!
//! # Complexity
//! One simplification, plus the strips of all levels.

mod collapsed;
mod coverage;
mod encode;
mod ratios;

use serde::Serialize;
use tristrip::StripifyOptions;
use tristrip_io::{Format, LeveledModel, Model, PartLevel};

use crate::collapses::{Collapses, percent_of};
use crate::encode::{kept_groups, true_or_null};
use crate::error::Error;
use crate::figures::MeshProperties;
use crate::goal::{Amount, Deviation, Ratio};
use crate::method::MethodDescription;
use crate::observer::{Observer, Stage, begin};
use crate::prepared::Survey;
use crate::simplify::{
    CollapseRules, Part, PartCollapses, TriangleGoal, diagonal, fans, locked_note, place_notes, prove,
    simplify_all, warning,
};
use collapsed::CollapsedLevel;
use coverage::{PartExtent, coverages};
pub use encode::File;
pub use ratios::ChainRatios;

/// Options for building a chain.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Options {
    /// The ratios of triangles that the levels keep.
    pub ratios: ChainRatios,
    /// The maximum error of a collapse. Levels that need a larger error are not reached.
    pub deviation: Deviation,
    /// The constraints on collapses, and their cost function.
    pub rules: CollapseRules,
    /// The method that builds the strips, or orders the triangles of lists.
    pub stripify: StripifyOptions,
    /// The format that the levels will be written in.
    pub format: Format,
    /// Whether the collapses are verified.
    pub verify: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self::new(ChainRatios::default(), Format::Glb)
    }
}

impl Options {
    /// Creates options for these levels and this format, with a maximum error of 1 % of the
    /// diagonal.
    pub fn new(ratios: ChainRatios, format: Format) -> Self {
        Self {
            ratios,
            deviation: Deviation::default(),
            rules: CollapseRules::default(),
            stripify: StripifyOptions::default(),
            format,
            verify: true,
        }
    }

    tristrip::setters! {
        /// Sets the maximum error of a collapse.
        with_deviation(deviation: Deviation);

        /// Sets the constraints on collapses, and their cost function.
        with_rules(rules: CollapseRules);

        /// Sets the method that builds the strips.
        with_stripify(stripify: StripifyOptions);

        /// Sets whether the collapses are verified.
        with_verify(verify: bool);

        /// Sets the format that the levels will be written in.
        with_format(format: Format);
    }
}

/// A level of a chain. The field names are the keys of the JSON report.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ChainLevel {
    /// The index of the level; 0 is the finest.
    #[serde(rename = "level")]
    pub number: usize,
    /// The requested ratio of triangles, from 0 to 1.
    pub ratio: Ratio,
    /// The requested number of triangles.
    pub target_triangles: usize,
    /// The number of triangles drawn.
    pub triangles: usize,
    /// The number of vertices that the level uses: the first vertices of each part.
    pub vertices: usize,
    /// The maximum error of the collapses of the level, in mesh units.
    pub surface_error: f32,
    /// `surface_error` in percent of `diagonal`.
    pub surface_error_percent: f64,
    /// The minimum screen coverage at which the level is drawn: the fraction of the screen area
    /// that the bounding sphere of the model covers. In a glTF file, `MSFT_screencoverage` of each
    /// node has the coverage for its own mesh.
    pub screen_coverage: f64,
    /// Whether there are at most `target_triangles` triangles.
    pub reached: bool,
    /// The size of the level's file in bytes. In a file with all levels, the size of the indices
    /// and vertices that the level uses. `None` if no file was written.
    pub bytes: Option<usize>,
    /// The file of the level; `None` if one file has all levels, or if no file was written.
    pub output: Option<String>,
}

/// A model at several levels of detail, ready to be encoded.
#[derive(Debug, Default)]
pub struct Chain {
    options: Options,
    leveled: LeveledModel,
    /// The triangles of each part at each level, over the vertices of the source.
    expected: Vec<Vec<Vec<u32>>>,
    extents: Vec<PartExtent>,
}

/// The levels of a model. The field names are the keys of the JSON report.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Outcome {
    /// The model at all levels.
    #[serde(skip)]
    pub chain: Chain,
    /// The collapses to the coarsest level.
    #[serde(skip)]
    pub collapses: Collapses,
    /// The vertex, edge and face counts of the source mesh.
    #[serde(skip)]
    pub mesh: MeshProperties,
    /// The method of the strips and the options that it uses.
    #[serde(flatten)]
    pub method: MethodDescription,
    /// Whether replaying the collapses removes exactly the recorded triangles, and every level of
    /// every written file draws exactly the remaining triangles; `null` in reports if verification
    /// was disabled.
    #[serde(serialize_with = "true_or_null")]
    #[cfg_attr(feature = "schema", schemars(with = "Option<bool>"))]
    pub proven: bool,
    /// The maximum error of a collapse, in mesh units: the requested one, or 1 % of `diagonal`.
    /// `None` for no limit.
    pub target_error: Option<f32>,
    /// The number of triangles of the input; a polygon counts as a fan.
    pub triangles_before: usize,
    /// The number of vertices in use in the input.
    pub vertices_before: usize,
    /// The length of the diagonal of the bounding box of all triangles in the scene.
    pub diagonal: f64,
    /// The levels, the finest first.
    #[serde(rename = "chain")]
    pub levels: Vec<ChainLevel>,
    /// The number of vertices that were kept because they touch a part placed by other nodes.
    pub locked_vertices: usize,
    /// The number of parts: glTF primitives or OBJ materials.
    pub parts: usize,
    /// A warning that names the levels that were not reached, the cause, and what to try; `None` if
    /// all were reached.
    pub warning: Option<String>,
    /// Human-readable notes on data that was read, dropped or changed, on locked vertices, and on
    /// vertices that kept their order.
    pub notes: Vec<String>,
}

/// Builds the levels of a chain.
///
/// # Errors
/// The maximum error is negative or NaN, a part is too large, the collapses fail verification, or
/// the observer cancelled the operation.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::{Deviation, chain};
/// // A fan of four triangles around a vertex. One collapse removes the vertex.
/// let fan = |height: u32| {
///     let corners = format!("v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 {height}\n");
///     read([&corners, "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"].concat().as_bytes(), Format::Obj)
/// };
/// let options = chain::Options::new("100%,50%".parse().unwrap_or_default(), Format::Glb);
/// let flat = chain::run(&fan(0)?, &options, &())?;
/// let sizes: Vec<_> = flat.levels.iter().map(|level| (level.triangles, level.vertices, level.reached)).collect();
/// assert_eq!(sizes, [(4, 5, true), (2, 4, true)]);
/// let steep = chain::run(&fan(9)?, &options.with_deviation(Deviation::Units(0.5)), &())?;
/// assert_eq!((steep.levels[1].triangles, steep.levels[1].reached, steep.warning.is_some()), (4, false, true));
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn run(model: &Model, options: &Options, observer: &dyn Observer) -> Result<Outcome, Error> {
    // 1. The triangles of each part.
    let surveyed = Survey::new(model, options.stripify, observer)?;
    let (parts, skipped) = fans(&surveyed.prepared, options.rules)?;
    let place_notes = place_notes(&surveyed.prepared, skipped);
    let (mesh, mut notes) = (surveyed.mesh, surveyed.notes);

    // 2. The collapses of all levels.
    begin(observer, Stage::Simplify)?;
    let (collapses, done) = collapse(&parts, options, observer)?;
    let levels = collapsed::levels(&parts, &done, &options.ratios)?;
    let warning = warn(&levels, &collapses, options);
    if options.verify {
        prove(&done, &collapses, observer)?;
    }

    // 3. The vertices in reverse order of removal.
    begin(observer, Stage::Reorder)?;
    let extents = (0..parts.len()).map(|part| collapsed::extent(&parts[part], part, &done, &levels));
    let extents = extents.collect::<Result<Vec<PartExtent>, Error>>()?;
    drop(parts);
    let (figures, of_parts): (Vec<_>, Vec<Vec<PartLevel>>) = levels
        .into_iter()
        .map(|level| ((level.target_triangles, level.triangles, level.is_reached()), level.parts))
        .unzip();
    let leveled = tristrip_io::in_level_order(model, &of_parts, options.format)?;
    let locked = locked_note(collapses.locked_vertices);
    notes.extend(place_notes.into_iter().chain(locked).chain(kept_groups(&leveled.groups)));

    // 4. The metrics of the levels.
    let coverage = coverages(&extents.iter().collect::<Vec<_>>());
    let figures = figures.into_iter().zip(options.ratios.as_slice()).zip(coverage).enumerate();
    let levels =
        figures.map(|(number, (((target_triangles, triangles, reached), &ratio), screen_coverage))| {
            let surface_error = extents.iter().map(|extent| extent.errors[number]).fold(0.0, f32::max);
            let surface_error_percent = percent_of(surface_error.into(), collapses.diagonal);
            let vertices = leveled.vertex_count(number)?;
            Ok(ChainLevel {
                number,
                ratio,
                target_triangles,
                triangles,
                vertices,
                surface_error,
                surface_error_percent,
                screen_coverage,
                reached,
                bytes: None,
                output: None,
            })
        });
    let levels = levels.collect::<Result<Vec<ChainLevel>, Error>>()?;
    let expected = of_parts.into_iter().map(|parts| parts.into_iter().map(|part| part.triangles).collect());
    let expected = expected.collect();
    let options = Options { stripify: surveyed.options, ..options.clone() };
    Ok(Outcome {
        method: MethodDescription::of(&options.stripify),
        proven: options.verify,
        target_error: collapses.target_error,
        triangles_before: collapses.triangles_before,
        vertices_before: mesh.vertices - mesh.unreferenced_vertices,
        diagonal: collapses.diagonal,
        levels,
        locked_vertices: collapses.locked_vertices,
        parts: model.parts.len(),
        warning,
        notes,
        chain: Chain { options, leveled, expected, extents },
        collapses,
        mesh,
    })
}

/// Simplifies all parts to the coarsest level.
fn collapse(
    parts: &[Part<'_>],
    options: &Options,
    observer: &dyn Observer,
) -> Result<(Collapses, Vec<PartCollapses>), Error> {
    let goal = Amount::Ratio(options.ratios.last()).of(parts.iter().map(Part::triangle_count).sum());
    let target_error = options.deviation.units(diagonal(parts));
    let all = simplify_all(parts, TriangleGoal::OfModel(goal), Some(target_error), options.rules, observer)?;
    if all.interrupted {
        return Err(Error::Cancelled);
    }
    Ok((all.summary(parts)?, all.parts))
}

/// Returns a warning about the levels that were not reached. These are always the coarsest ones.
fn warn(levels: &[CollapsedLevel], collapses: &Collapses, options: &Options) -> Option<String> {
    let first = levels.iter().position(|level| !level.is_reached())?;
    let last = levels.len() - 1;
    let which = if first == last { format!("level {last}") } else { format!("levels {first} to {last}") };
    let why = warning(collapses, options.deviation, options.rules.lock_borders)?;
    Some(format!("{which} not reached: {why}"))
}
