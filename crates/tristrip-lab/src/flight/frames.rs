//! The frames of a flight: the changes of each update, and the resulting view.

use std::cmp::Ordering;
use std::sync::Arc;
use std::time::Instant;

use serde::Serialize;
use tristrip::lod::{Camera, Filter, RESTART, SkipStrips, SkipView, ViewCriteria};
use tristrip_pipeline::rounded;
use tristrip_pipeline::view_model::prove_view;

use crate::error::Error;

/// Options for measuring a flight.
///
/// ```
/// use tristrip::lod::Filter;
/// use tristrip_lab::flight::FlightOptions;
/// assert_eq!((FlightOptions::default().filter, FlightOptions::default().proof_count), (Filter::Dtfs, 20));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlightOptions {
    /// The criteria that decide the detail.
    pub criteria: ViewCriteria,
    /// The filter of the display strips.
    pub filter: Filter,
    /// The maximum number of frames whose display strips are proven. They are evenly spaced and
    /// include the last frame. 0 disables the proofs.
    pub proof_count: usize,
}

impl Default for FlightOptions {
    fn default() -> Self {
        Self { criteria: ViewCriteria::default(), filter: Filter::Dtfs, proof_count: 20 }
    }
}

/// A frame; the keys are those of the JSON report of `tristrip-lab fly`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FrameRow {
    /// The index of the frame, from 0.
    pub frame: usize,
    /// The number of triangles drawn.
    pub triangles: usize,
    /// The number of vertices that have not collapsed.
    pub active_vertices: usize,
    /// The number of collapses.
    pub collapses: usize,
    /// The number of splits.
    pub splits: usize,
    /// The number of collapses whose criteria were evaluated.
    pub looked_at: usize,
    /// The number of strip segments that were scanned.
    pub segments: usize,
    /// The number of indices of the display strips, without restarts.
    pub vertices_sent: usize,
    /// `vertices_sent` divided by `triangles`.
    pub vertices_per_triangle: f64,
    /// The number of display strips.
    pub strips: usize,
    /// The size of the changed ranges of the index buffer, in bytes, with four bytes per index.
    pub bytes_changed: usize,
    /// Whether the update finished within the limit of steps.
    pub complete: bool,
    /// Whether the display strips are proven to draw exactly the triangles of the frame; `None` if
    /// this was not checked.
    pub proven: Option<bool>,
    /// The time of the frame.
    pub seconds: FrameSeconds,
}

/// The time of a frame, in seconds.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct FrameSeconds {
    /// The time of the update in seconds.
    pub update: f64,
}

/// Receives the frames of a flight while it runs.
///
/// ```
/// use tristrip_lab::flight::FlightObserver;
/// assert!(!FlightObserver::is_cancelled(&()));
/// ```
pub trait FlightObserver {
    /// Called for each frame, after its time was measured. An error stops the flight.
    ///
    /// # Errors
    /// The errors of the observer.
    fn frame(&mut self, _row: &FrameRow, _camera: &Camera, _view: &SkipView) -> Result<(), Error> {
        Ok(())
    }

    /// Returns whether to stop the flight with [`Error::Interrupted`].
    fn is_cancelled(&self) -> bool {
        false
    }
}

impl FlightObserver for () {}

/// Moves a view of a model from camera to camera, and measures each frame. The view starts at the
/// base mesh.
///
/// # Errors
/// The model has no positions, a frame is not proven, or the observer failed or cancelled.
///
/// ```
#[doc = include_str!("example.txt")]
/// let rows = fly(&model, &cameras, &FlightOptions::default(), &mut ())?;
/// assert_eq!((rows.len(), rows[0].proven), (20, Some(true)));
/// assert!(rows.iter().all(|row| row.complete && row.vertices_sent >= row.triangles));
/// # Ok::<(), Error>(())
/// ```
pub fn fly(
    model: &Arc<SkipStrips>,
    cameras: &[Camera],
    options: &FlightOptions,
    observer: &mut dyn FlightObserver,
) -> Result<Vec<FrameRow>, Error> {
    let mut view = model.view_by(options.filter);
    let mut rows = Vec::with_capacity(cameras.len());
    for (frame, camera) in cameras.iter().enumerate() {
        if observer.is_cancelled() {
            return Err(Error::Interrupted("flight"));
        }
        let started = Instant::now();
        let update = view.update(camera, &options.criteria)?;
        let seconds = started.elapsed().as_secs_f64();
        let is_checked = is_among(frame, cameras.len(), options.proof_count);
        if is_checked {
            prove(frame, &view)?;
        }
        let vertices_sent = view.indices().iter().filter(|&&index| index != RESTART).count();
        let row = FrameRow {
            frame,
            triangles: view.triangle_count(),
            active_vertices: view.active_vertex_count(),
            collapses: update.collapses,
            splits: update.splits,
            looked_at: update.looked_at,
            segments: update.segments,
            vertices_sent,
            vertices_per_triangle: rounded(vertices_sent as f64 / view.triangle_count().max(1) as f64),
            strips: view.display_strips().len(),
            bytes_changed: size_of::<u32>()
                * update.changed.iter().map(ExactSizeIterator::len).sum::<usize>(),
            complete: update.is_complete,
            proven: is_checked.then_some(true),
            seconds: FrameSeconds { update: rounded(seconds) },
        };
        observer.frame(&row, camera, &view)?;
        rows.push(row);
    }
    Ok(rows)
}

fn unproven(why: String) -> Error {
    tristrip_pipeline::Error::unproven(why).into()
}

/// Proves the display strips of a frame.
fn prove(frame: usize, view: &SkipView) -> Result<(), Error> {
    let Err(error) = prove_view(view, &view.display_strips()) else { return Ok(()) };
    match error {
        tristrip_pipeline::Error::Unproven { why, .. } => Err(unproven(format!("frame {frame}: {why}"))),
        other => Err(other.into()),
    }
}

/// A flight; the keys are those of the JSON report of `tristrip-lab fly`. All values are `None`
/// before the flight.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct FlightReport {
    /// The number of collapses of the model.
    pub collapses: Option<usize>,
    /// The number of triangles of the base mesh.
    pub triangles_base: Option<usize>,
    /// The number of triangles of the full mesh.
    pub triangles_full: Option<usize>,
    /// The height of the vertex tree: the maximum number of collapses on a path from a vertex to a
    /// root.
    pub tree_height: Option<u32>,
    /// The summary of all frames.
    pub summary: Option<FlightSummary>,
    /// The frames.
    pub frames: Option<Vec<FrameRow>>,
}

impl FlightReport {
    /// Returns the counts of a model, before a flight.
    ///
    /// # Errors
    /// Cannot fail for a model that was built by this library.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let frames = fly(&model, &cameras, &FlightOptions::default(), &mut ())?;
    /// let report = FlightReport::of_model(&model)?.with_frames(frames);
    /// assert_eq!(report.triangles_full, Some(128));
    /// assert_eq!(report.frames.map(|frames| frames.len()), Some(20));
    /// # Ok::<(), Error>(())
    /// ```
    pub fn of_model(model: &SkipStrips) -> Result<Self, Error> {
        let levels = model.levels();
        Ok(Self {
            collapses: Some(levels.collapse_count()),
            triangles_base: Some(levels.triangle_count(0)?),
            triangles_full: Some(levels.triangle_count(levels.collapse_count())?),
            tree_height: Some(model.height()),
            summary: None,
            frames: None,
        })
    }

    /// Sets the frames and their summary.
    #[must_use]
    pub fn with_frames(self, frames: Vec<FrameRow>) -> Self {
        Self { summary: Some(FlightSummary::of(&frames)), frames: Some(frames), ..self }
    }
}

/// Checks whether a frame is one of `chosen` evenly spaced frames, which include the last frame.
pub(crate) fn is_among(frame: usize, frame_count: usize, chosen: usize) -> bool {
    (frame + 1) * chosen / frame_count > frame * chosen / frame_count
}

/// Summary values over frames: medians or maxima.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct FrameValues {
    /// The number of triangles drawn.
    pub triangles: usize,
    /// The number of vertices sent per triangle.
    pub vertices_per_triangle: f64,
    /// Collapses and splits, in percent of the vertices that have not collapsed.
    pub changes_percent: f64,
    /// The size of the changed ranges of the index buffer, in bytes.
    pub bytes_changed: usize,
    /// The time of the update.
    pub seconds: FrameSeconds,
}

/// The summary of the frames of a flight.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct FlightSummary {
    /// The number of frames.
    pub frame_count: usize,
    /// The number of proven frames.
    pub frames_proven: usize,
    /// The number of frames that were stopped by the limit of steps.
    pub frames_incomplete: usize,
    /// The first frame, which starts from the base mesh.
    pub first: FrameValues,
    /// The median of each value, over the frames after the first.
    pub median: FrameValues,
    /// The maximum of each value, over the frames after the first.
    pub worst: FrameValues,
}

impl FlightSummary {
    /// Returns the summary of frames. For a single frame, the median and the maximum are its own
    /// values.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let summary = FlightSummary::of(&fly(&model, &cameras, &FlightOptions::default(), &mut
    /// ())?); assert_eq!((summary.frame_count, summary.frames_proven, summary.frames_incomplete),
    /// (20, 20, 0)); assert!(summary.median.triangles <= summary.worst.triangles);
    /// # Ok::<(), Error>(())
    /// ```
    pub fn of(rows: &[FrameRow]) -> Self {
        let Some((first, others)) = rows.split_first() else { return Self::default() };
        let others = if others.is_empty() { rows } else { others };
        let values: Vec<FrameValues> = others.iter().map(FrameValues::of).collect();
        let at = |place: usize| FrameValues {
            triangles: ordered(&values, |v| v.triangles, usize::cmp)[place],
            vertices_per_triangle: ordered(&values, |v| v.vertices_per_triangle, f64::total_cmp)[place],
            changes_percent: ordered(&values, |v| v.changes_percent, f64::total_cmp)[place],
            bytes_changed: ordered(&values, |v| v.bytes_changed, usize::cmp)[place],
            seconds: FrameSeconds { update: ordered(&values, |v| v.seconds.update, f64::total_cmp)[place] },
        };
        Self {
            frame_count: rows.len(),
            frames_proven: rows.iter().filter(|row| row.proven == Some(true)).count(),
            frames_incomplete: rows.iter().filter(|row| !row.complete).count(),
            first: FrameValues::of(first),
            median: at((values.len() - 1) / 2),
            worst: at(values.len() - 1),
        }
    }
}

impl FrameValues {
    fn of(row: &FrameRow) -> Self {
        let changes = (row.collapses + row.splits) as f64;
        Self {
            triangles: row.triangles,
            vertices_per_triangle: row.vertices_per_triangle,
            changes_percent: rounded(100.0 * changes / row.active_vertices.max(1) as f64),
            bytes_changed: row.bytes_changed,
            seconds: row.seconds,
        }
    }
}

/// Returns one of the values of all frames, ascending.
fn ordered<T>(
    values: &[FrameValues],
    of: impl Fn(&FrameValues) -> T,
    order: fn(&T, &T) -> Ordering,
) -> Vec<T> {
    let mut all: Vec<T> = values.iter().map(of).collect();
    all.sort_by(order);
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn proven_frames_are_spread_and_the_last_is_one() {
        let chosen = |count, chosen| (0..count).filter(|&f| is_among(f, count, chosen)).collect::<Vec<_>>();
        assert_eq!(chosen(6, 3), [1, 3, 5]);
        assert_eq!(chosen(2, 20), [0, 1]);
        assert_eq!((chosen(300, 20).len(), chosen(300, 20).last(), chosen(7, 0).len()), (20, Some(&299), 0));
    }

    #[test]
    fn a_summary_leaves_the_first_frame_out() {
        let row = |triangles, update| FrameRow {
            frame: 0,
            triangles,
            active_vertices: 100,
            collapses: 1,
            splits: 2,
            looked_at: 9,
            segments: 4,
            vertices_sent: 2 * triangles,
            vertices_per_triangle: 2.0,
            strips: 1,
            bytes_changed: 16,
            complete: true,
            proven: None,
            seconds: FrameSeconds { update },
        };
        let summary = FlightSummary::of(&[row(9, 8.0), row(3, 0.5), row(7, 0.25), row(5, 1.0)]);
        assert_eq!((summary.first.triangles, summary.median.triangles, summary.worst.triangles), (9, 5, 7));
        let seconds = [summary.first, summary.median, summary.worst].map(|values| values.seconds.update);
        assert_eq!((seconds, summary.median.changes_percent), ([8.0, 0.5, 1.0], 3.0));
        assert_eq!(FlightSummary::of(&[row(9, 8.0)]).worst.triangles, 9);
        assert_eq!(FlightSummary::of(&[]).frame_count, 0);
    }
}
