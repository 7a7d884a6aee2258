//! The chart of levels: the vertices that each filter sends from the base mesh to the full mesh,
//! one panel per model.

use super::rows::LevelRow;
use crate::error::Error;
use tristrip_pipeline::levels::DisplayFilter;
use tristrip_render::chart::{Axis, Mark, Panel, Scale, Series, svg};

/// Draws a panel per model, from its name and rows.
///
/// # Errors
/// The drawing library fails; no input is known that causes this.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_lab::traffic::{TrafficModel, draw, measure_levels};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n", Format::Obj)?;
/// let levels = tristrip_pipeline::levels::run(&model, &Default::default(), &())?.model;
/// let rows = measure_levels(&TrafficModel::new(&levels), &levels.order.evenly(9), Default::default(), true)?;
/// assert!(draw(&[("square".into(), &rows)])?.starts_with("<svg"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn draw(models: &[(String, &[LevelRow])]) -> Result<String, Error> {
    let panels: Vec<Panel> = models.iter().map(|(name, rows)| panel(name, rows)).collect();
    Ok(svg(&panels, 1)?)
}

fn panel(name: &str, rows: &[LevelRow]) -> Panel {
    let series = |name: &str, sent: &dyn Fn(&LevelRow) -> usize| {
        let points: Vec<_> = rows.iter().map(|row| (row.percent, sent(row) as f64)).collect();
        Series::new(name, Mark::Line, points)
    };
    let mut all = vec![series("as triangles", &|row| row.vertices_sent.triangles)];
    for (index, filter) in DisplayFilter::ALL.iter().enumerate() {
        all.push(series(filter.name(), &|row| row.vertices_sent.by_filter[index]));
    }
    Panel::new(
        &format!("Vertices sent at every level: {name}"),
        Axis::new("level: undone collapses, percent", Scale::Linear { from_zero: true }),
        Axis::new("vertices sent", Scale::Linear { from_zero: true }),
        all,
    )
}
