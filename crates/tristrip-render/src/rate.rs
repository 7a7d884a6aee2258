//! Rate-distortion charts of streams: error against bytes read.

use crate::chart::{Axis, Mark, Panel, Scale, Series, svg};
use crate::error::Error;

/// Draws one curve per named file: the error after each chunk, against the file offset at which the
/// chunk ends. Errors of 0 are omitted.
///
/// # Errors
/// The drawing library fails. No known input causes this.
///
/// ```
/// let chunks = vec![(1_000, 0.1), (3_000, 0.05), (7_000, 0.02)];
/// let svg = tristrip_render::rate::draw(&[("bunny.glb".to_owned(), chunks)])?;
/// assert!(svg.contains("bunny.glb"));
/// # Ok::<(), tristrip_render::Error>(())
/// ```
pub fn draw(files: &[(String, Vec<(usize, f32)>)]) -> Result<String, Error> {
    let panel = |(name, chunks): &(String, Vec<(usize, f32)>)| {
        let points = chunks.iter().map(|&(end, error)| (end as f64 / 1000.0, f64::from(error)));
        Panel::new(
            &format!("Error against bytes: {name}"),
            Axis::new("kilobytes of the file", Scale::Linear { from_zero: true }),
            Axis::new("error in mesh units", Scale::Log10),
            vec![Series::new("error", Mark::Steps, points.collect())],
        )
    };
    svg(&files.iter().map(panel).collect::<Vec<_>>(), 1)
}
