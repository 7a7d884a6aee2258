//! Progress and cancellation while a model is processed.
//!
//! The pipeline does not read the clock. A caller that reports times measures them itself: a stage
//! ends when the next one starts or the operation returns.

use std::fmt;

use serde::Serialize;
use tristrip::StripifyOptions;
use tristrip::stripify::Watch;

use crate::error::Error;

/// A stage of the processing of a model. The variants are in the usual order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Stage {
    /// The caller reads the model. The pipeline reads and writes no files, so it never starts this
    /// stage or [`Stage::Write`].
    Load,
    /// Chunks of a stream are decoded.
    Decode,
    /// The indices of a file are counted and vertex caches simulated.
    Analyze,
    /// Faces are prepared and dual graphs built.
    Prepare,
    /// The mesh is measured.
    Survey,
    /// Strips are built.
    Stripify,
    /// The strips are measured.
    Measure,
    /// Lower bounds are computed.
    Bound,
    /// A result is verified in memory.
    Prove,
    /// Half-edges are collapsed.
    Simplify,
    /// Vertices are moved closer to the original surface.
    Fit,
    /// The simplified model is built, with new normals and without unused vertices.
    Rebuild,
    /// The simplified surface is compared with the original.
    Compare,
    /// Strips of a level of detail are filtered.
    Filter,
    /// Vertices are reordered.
    Reorder,
    /// The file is encoded.
    Encode,
    /// The bytes are read back and verified.
    ReadBack,
    /// The caller writes the bytes to files.
    Write,
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Load => "load",
            Self::Decode => "decode",
            Self::Analyze => "analyze",
            Self::Prepare => "dual graph",
            Self::Survey => "mesh",
            Self::Stripify => "stripify",
            Self::Measure => "measure",
            Self::Bound => "bound",
            Self::Prove | Self::ReadBack => "verify",
            Self::Simplify | Self::Rebuild => "simplify",
            Self::Fit => "fit",
            Self::Compare => "compare",
            Self::Filter => "filter",
            Self::Reorder => "reorder",
            Self::Encode | Self::Write => "write",
        })
    }
}

/// Why a search stopped early.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum SearchStop {
    /// The time budget was used up.
    Budget,
    /// The user interrupted.
    Interrupt,
}

impl SearchStop {
    /// Returns a note for a report.
    ///
    /// ```
    /// assert!(tristrip_pipeline::SearchStop::Budget.note().contains("budget"));
    /// ```
    pub fn note(self) -> &'static str {
        match self {
            Self::Budget => "the time budget ended the search: another run may give a different result",
            Self::Interrupt => "interrupted: this is the best result found so far",
        }
    }
}

/// Watches the searches of all parts of a model, which may run concurrently. The watch is dropped
/// when the searches end.
pub trait Search: Watch {
    /// Returns why the searches were stopped; `None` if they were not.
    fn stopped(&self) -> Option<SearchStop>;
}

/// Never stops a search.
impl Search for () {
    fn stopped(&self) -> Option<SearchStop> {
        None
    }
}

/// The progress of a simplification.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct SimplifyProgress {
    /// The number of triangles of the model.
    pub before: usize,
    /// The number of remaining triangles.
    pub left: usize,
    /// The number of triangles at which the simplification stops; 0 without a limit.
    pub goal: usize,
}

/// Receives stages and progress, and can stop or cancel an operation. The default methods do
/// nothing.
///
/// ```
/// use std::sync::Mutex;
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::{Observer, Stage, strip};
/// #[derive(Default)]
/// struct Stages(Mutex<Vec<Stage>>);
/// impl Observer for Stages {
///     fn stage(&self, stage: Stage) {
///         if let Ok(mut stages) = self.0.lock() {
///             stages.push(stage);
///         }
///     }
/// }
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj)?;
/// let stages = Stages::default();
/// strip::run(&model, &strip::Options::default(), &stages)?;
/// let seen = stages.0.into_inner().unwrap_or_default();
/// assert_eq!(seen, [Stage::Prepare, Stage::Survey, Stage::Stripify, Stage::Measure, Stage::Prove]);
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub trait Observer: Sync {
    /// Called when a stage starts, on the thread that called the pipeline.
    fn stage(&self, _stage: Stage) {}

    /// Returns a watch for searches with these options. Called before the searches start.
    fn search(&self, _options: &StripifyOptions) -> Box<dyn Search + '_> {
        Box::new(())
    }

    /// Receives the progress of [`Stage::Simplify`], from any thread, about every 1/16 of the
    /// triangles. Return `false` to stop and keep the collapses so far.
    ///
    /// The result is then a valid simplification, but stages that have not started are skipped.
    /// This method is called again before and during the fit, and before the comparison. If the
    /// observer also cancels, the operation returns [`Error::Cancelled`] instead. Levels and chains
    /// return this error whenever they are stopped, because they need all collapses.
    ///
    /// ```
    /// use tristrip_io::{Format, read};
    /// use tristrip_pipeline::{Amount, Goal, Observer, SimplifyProgress, simplify};
    /// struct Impatient;
    /// impl Observer for Impatient {
    ///     fn simplifies(&self, progress: SimplifyProgress) -> bool {
    ///         progress.left > progress.before / 2
    ///     }
    /// }
    /// // A strip of 40,000 flat squares, two triangles each.
    /// let mut text: String = (0..=40_000).flat_map(|x| [format!("v {x} 0 0\n"), format!("v {x} 1 0\n")]).collect();
    /// text.extend((0..40_000).map(|x| 2 * x + 1).map(|v| format!("f {v} {} {} {}\n", v + 2, v + 3, v + 1)));
    /// let model = read(text.as_bytes(), Format::Obj)?;
    /// let goal = Goal { amount: Some(Amount::Triangles(2)), ..Goal::default() };
    /// let simplified = simplify::run(&model, &simplify::Options::default().with_goal(goal), &Impatient)?;
    /// assert!(simplified.interrupted && (2..=40_000).contains(&simplified.collapses.triangles_after));
    /// # Ok::<(), tristrip_pipeline::Error>(())
    /// ```
    fn simplifies(&self, _progress: SimplifyProgress) -> bool {
        !self.is_cancelled()
    }

    /// Returns whether to cancel. Called at the start of each stage, and by `pack` before each
    /// mesh, from any thread. The operation then returns [`Error::Cancelled`].
    fn is_cancelled(&self) -> bool {
        false
    }
}

/// Observes nothing.
impl Observer for () {}

/// Starts a stage, unless the observer cancels.
pub(crate) fn begin(observer: &dyn Observer, stage: Stage) -> Result<(), Error> {
    if observer.is_cancelled() {
        return Err(Error::Cancelled);
    }
    observer.stage(stage);
    Ok(())
}
