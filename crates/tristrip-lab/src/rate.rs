//! Rate and distortion of streams: the error of the levels against the bytes that lead to them.

use crate::chart::{Axis, Mark, Panel, Scale, Series, svg};
use crate::error::Error;

/// Draws the error after each chunk against the bytes up to its end, for each named file; with errors of 0 left out.
///
/// # Errors
/// The drawing library fails; no input is known that causes this.
///
/// ```
/// let chunks = vec![(1_000, 0.1), (3_000, 0.05), (7_000, 0.02)];
/// assert!(tristrip_lab::rate::draw(&[("bunny.glb".to_owned(), chunks)])?.contains("bunny.glb"));
/// # Ok::<(), tristrip_lab::Error>(())
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

/// Draws how far from the full mesh what is shown of it is, against the seconds since the download began: steps for each named file, from its first picture on. Distances are in percent of
/// the diagonal; those of 0 are left out.
///
/// # Errors
/// The drawing library fails; no input is known that causes this.
///
/// ```
/// let curves = [("progressive".to_owned(), vec![(0.1, 1.0), (0.5, 0.1)]), ("whole".to_owned(), vec![(2.0, 0.1)])];
/// assert!(tristrip_lab::rate::draw_arrival("bunny", &curves)?.contains("progressive"));
/// # Ok::<(), tristrip_lab::Error>(())
/// ```
pub fn draw_arrival(title: &str, curves: &[(String, Vec<(f64, f64)>)]) -> Result<String, Error> {
    let series = |(name, points): &(String, Vec<(f64, f64)>)| {
        let mark = if points.len() > 1 { Mark::Steps } else { Mark::Points };
        Series::new(name, mark, points.iter().copied().filter(|&(_, rms)| rms > 0.0).collect())
    };
    let panel = Panel::new(
        &format!("Distance against time: {title}"),
        Axis::new("seconds since the download began", Scale::Linear { from_zero: true }),
        Axis::new("RMS distance, % of the diagonal", Scale::Log10),
        curves.iter().map(series).collect(),
    );
    svg(&[panel], 1)
}
