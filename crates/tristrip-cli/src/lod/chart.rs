//! The chart of levels: the vertices that each filter sends from the base mesh to the full mesh, one panel per model.

use clap::ValueEnum;

use super::rows::LevelRow;
use crate::chart::{Axis, Mark, Panel, Scale, Series, svg};
use crate::failure::Failure;
use crate::values::FilterName;

/// Draws a panel per model, from its name and rows.
pub(crate) fn draw(models: &[(String, &[LevelRow])]) -> Result<String, Failure> {
    let panels: Vec<Panel> = models.iter().map(|(name, rows)| panel(name, rows)).collect();
    svg(&panels, 1)
}

fn panel(name: &str, rows: &[LevelRow]) -> Panel {
    let series = |name: &str, sent: &dyn Fn(&LevelRow) -> usize| {
        let points: Vec<_> = rows.iter().map(|row| (row.percent, sent(row) as f64)).collect();
        Series::new(name, Mark::Line, points)
    };
    let mut all = vec![series("as triangles", &|row| row.vertices_sent.triangles)];
    for (index, filter) in FilterName::value_variants().iter().enumerate() {
        all.push(series(&filter.name(), &|row| row.vertices_sent.by_filter[index]));
    }
    Panel::new(
        &format!("Vertices sent at every level: {name}"),
        Axis::new("level: undone collapses, percent", Scale::Linear { from_zero: true }),
        Axis::new("vertices sent", Scale::Linear { from_zero: true }),
        all,
    )
}
