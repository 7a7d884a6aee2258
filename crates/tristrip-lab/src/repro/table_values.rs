//! The measured values of the rows of tables.

use super::paper::{PublishedColumn, PublishedRow, Quantity};
use super::recipe::Recipe;
use super::runner::Runner;

/// Returns the recipe for the strips of a measurement; `None` if it needs no strips.
pub(super) fn recipe(quantity: &Quantity) -> Option<Recipe> {
    match quantity {
        Quantity::Strips { flags, steps, .. } => Some(Recipe { flags: flags.clone(), steps: *steps }),
        Quantity::Levels { flags, .. } | Quantity::Recovery { flags, .. } | Quantity::Views { flags, .. } => {
            Some(flags.as_str().into())
        }
        _ => None,
    }
}

/// Returns the measured values of a row. Savings are computed from the other columns.
pub(super) fn measured_values(
    row: &PublishedRow,
    columns: &[PublishedColumn],
    runner: &Runner,
) -> Vec<Option<f64>> {
    let model = row.file.as_ref().and_then(|name| runner.model(name));
    let value = |quantity: &Quantity| match quantity {
        Quantity::Strips { figure, .. } => model?.strips(&recipe(quantity)?, figure),
        Quantity::Levels { figure, .. } => model?.levels(&recipe(quantity)?, figure),
        Quantity::Recovery { figure, .. } => model?.recovery(&recipe(quantity)?, figure),
        Quantity::Views { order, figure, .. } => {
            model?.views(&recipe(quantity)?)?.get(*order, row.detail(), figure)
        }
        Quantity::Mesh(figure) => model?.mesh(figure),
        Quantity::Saving { .. } | Quantity::Unmeasured => None,
    };
    let values: Vec<Option<f64>> = columns.iter().map(|column| value(&column.quantity)).collect();
    let with_savings = columns.iter().zip(&values).map(|(column, value)| match column.quantity {
        Quantity::Saving { of, than } => {
            let (of, than) = (values.get(of).copied()??, values.get(than).copied()??);
            (than > 0.0).then(|| 100.0 * (1.0 - of / than))
        }
        _ => *value,
    });
    with_savings.collect()
}
