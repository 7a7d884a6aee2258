//! The chart of a flight: triangles and vertices sent, and the time of each frame.

use super::frames::FrameRow;
use crate::error::Error;
use tristrip_render::chart::{Axis, Mark, Panel, Scale, Series, svg};

/// The maximum number of points of a curve. With more frames, each point is the maximum of several
/// frames.
const POINTS: usize = 600;

/// Draws the frames of a named flight.
///
/// # Errors
/// The drawing library fails; no input is known that causes this.
///
/// ```
#[doc = include_str!("example.txt")]
/// let rows = fly(&model, &cameras, &FlightOptions::default(), &mut ())?;
/// assert!(draw("grid", &rows)?.starts_with("<svg"));
/// # Ok::<(), Error>(())
/// ```
pub fn draw(name: &str, rows: &[FrameRow]) -> Result<String, Error> {
    let stride = rows.len().div_ceil(POINTS).max(1);
    let series = |name: &str, value: &dyn Fn(&FrameRow) -> f64| {
        let point =
            |frames: &[FrameRow]| (frames[0].frame as f64, frames.iter().map(value).fold(0.0, f64::max));
        Series::new(name, Mark::Line, rows.chunks(stride).map(point).collect())
    };
    let axis = |title: &str| Axis::new(title, Scale::Linear { from_zero: true });
    let drawn = vec![
        series("triangles", &|row| row.triangles as f64),
        series("vertices sent", &|row| row.vertices_sent as f64),
    ];
    // Skip the first frame: it starts from the base mesh, and would dominate the scale.
    let updates = rows.iter().skip(usize::from(rows.len() > 1));
    let updates: Vec<&FrameRow> = updates.collect();
    let point = |frames: &[&FrameRow]| {
        let slowest = frames.iter().map(|row| 1e3 * row.seconds.update).fold(0.0, f64::max);
        (frames[0].frame as f64, slowest)
    };
    let times = Series::new("milliseconds", Mark::Line, updates.chunks(stride).map(point).collect());
    let panels = [
        Panel::new(&format!("Drawn per frame: {name}"), axis("frame"), axis("count"), drawn),
        Panel::new("Time of an update, without the first", axis("frame"), axis("milliseconds"), vec![times]),
    ];
    Ok(svg(&panels, 1)?)
}
