//! The picture of levels: what each filter sends from the base mesh to the full one, a panel a model.

use clap::ValueEnum;

use super::measure::Row;
use crate::chart::{Axis, Mark, Panel, Scale, Series, svg};
use crate::failure::Failure;
use crate::values::FilterName;

/// Draws the rows of each model, by name, one below the other.
pub(crate) fn draw(models: &[(String, &[Row])]) -> Result<String, Failure> {
    let panels: Vec<Panel> = models.iter().map(|(name, rows)| panel(name, rows)).collect();
    svg(&panels, 1)
}

fn panel(name: &str, rows: &[Row]) -> Panel {
    let series = |name: &str, sent: &dyn Fn(&Row) -> usize| {
        let points: Vec<_> = rows.iter().map(|row| (row.percent, sent(row) as f64)).collect();
        Series::new(name, Mark::Line, points)
    };
    let mut all = vec![series("as triangles", &|row| row.vertices_sent.triangles)];
    for (number, filter) in FilterName::value_variants().iter().enumerate() {
        all.push(series(&filter.name(), &|row| row.vertices_sent.by_filter[number]));
    }
    Panel::new(
        &format!("Vertices sent at every level: {name}"),
        Axis::new("level: collapses undone, percent", Scale::Linear { from_zero: true }),
        Axis::new("vertices sent", Scale::Linear { from_zero: true }),
        all,
    )
}
