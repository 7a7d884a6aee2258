//! The statistics of claims: one number over several models.

use std::collections::BTreeSet;

use tristrip::vertex_cache::{FlushPolicy, Replacement};

use super::identity::{Identity, identify};
use super::measured::{CACHE_ENTRIES, MeasuredModel, ONE_STRIP_COMPONENTS};
use super::paper::{ChartKind, ModelSet, Paper, PublishedRow, SavingOver, Statistic};
use super::recipe::Recipe;
use super::runner::Runner;
use super::table_values::measured_values;

/// The value of a statistic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Computed {
    pub(super) value: f64,
    /// The number of models, and how many of them may not be a model of the paper.
    pub(super) models: usize,
    pub(super) stand_ins: usize,
}

/// Requests the measurements of a statistic on its models, or on another set of models.
pub(super) fn request(statistic: &Statistic, other: Option<ModelSet>, paper: &Paper, runner: &mut Runner) {
    let mut request_set =
        |flags: &str, set: &ModelSet| request_set(flags, other.unwrap_or(*set), paper, runner);
    match statistic {
        Statistic::Saving { flags, than, models, .. } => {
            [flags, than].into_iter().for_each(|flags| request_set(flags, models));
        }
        Statistic::Excess { flags, models, .. }
        | Statistic::Mean { flags, models, .. }
        | Statistic::Exponent { flags, models, .. } => request_set(flags, models),
        Statistic::Rank { among, models, .. } => {
            among.flags().iter().for_each(|flags| request_set(flags, models));
        }
        Statistic::Levels { flags, models, .. } => request_levels(flags, *models, paper, runner),
        Statistic::LevelsOf { flags, model, .. } => runner.request_levels(flags.as_str().into(), model),
        Statistic::RecoveryOf { flags, model, .. } => {
            runner.request_recovery(flags.as_str().into(), model);
        }
        Statistic::ViewsOf { flags, order, model, .. } => {
            runner.request_views(flags.as_str().into(), model, *order);
        }
        Statistic::Mesh { model, .. } => runner.request_mesh(model),
        Statistic::StripsOf { flags, than, model, .. } => {
            let all = std::iter::once(flags).chain(than);
            all.for_each(|flags| runner.request(flags.as_str().into(), model));
        }
        Statistic::OneStripComponents { flags, model } => {
            runner.request_components(flags.as_str().into(), model);
        }
        // The tables and charts request their own measurements.
        Statistic::Columns { .. }
        | Statistic::LruSaving { .. }
        | Statistic::SavedBy { .. }
        | Statistic::Speed { .. } => (),
    }
}

fn request_set(flags: &str, set: ModelSet, paper: &Paper, runner: &mut Runner) {
    if matches!(set, ModelSet::Table | ModelSet::Own) {
        let rows = paper.tables.iter().flat_map(|table| &table.rows);
        rows.filter_map(|row| row.file.as_ref()).for_each(|file| runner.request(flags.into(), file));
    } else {
        runner.request_set(flags.into(), set);
    }
}

/// Requests levels of detail of the models of the paper's tables. For all models they would take
/// too long.
fn request_levels(flags: &str, set: ModelSet, paper: &Paper, runner: &mut Runner) {
    let rows = paper.tables.iter().flat_map(|table| &table.rows).filter(|_| set == ModelSet::Table);
    rows.filter_map(|row| row.file.as_ref()).for_each(|file| runner.request_levels(flags.into(), file));
}

/// Checks whether a file is a model of the paper's tables.
fn is_own(name: &str, paper: &Paper, runner: &Runner) -> bool {
    let rows = paper.tables.iter().flat_map(|table| &table.rows);
    rows.filter(|row| row.file.as_deref() == Some(name))
        .any(|row| matches!(identify(row, runner), Identity::Same { .. }))
}

/// Returns the measured models of a set with their names, except empty meshes.
fn models<'a>(set: ModelSet, paper: &Paper, runner: &'a Runner) -> Vec<(&'a str, &'a MeasuredModel)> {
    let chosen = runner.models().filter(|(name, measured)| match set {
        ModelSet::Table => is_own(name, paper, runner),
        ModelSet::Own => measured.has_polygons && is_own(name, paper, runner),
        ModelSet::Polygons => measured.has_polygons,
        ModelSet::All => true,
    });
    // Statistics divide by the number of triangles.
    chosen.filter(|(_, measured)| measured.size.triangles > 0).collect()
}

/// Computes a statistic on its models, or on another set of models; `None` if there is no model.
pub(super) fn compute(
    statistic: &Statistic,
    other: Option<ModelSet>,
    paper: &Paper,
    runner: &Runner,
) -> Option<Computed> {
    let (value, models) = value(statistic, other, paper, runner)?;
    Some(Computed { value, models, stand_ins: stand_ins(statistic, other, paper, runner) })
}

/// Counts the models of a statistic that may not be a model of the paper.
fn stand_ins(statistic: &Statistic, other: Option<ModelSet>, paper: &Paper, runner: &Runner) -> usize {
    let is_other = |name: &str| !is_own(name, paper, runner);
    match statistic {
        Statistic::Saving { models: set, .. }
        | Statistic::Excess { models: set, .. }
        | Statistic::Mean { models: set, .. }
        | Statistic::Exponent { models: set, .. }
        | Statistic::Rank { models: set, .. }
        | Statistic::Levels { models: set, .. } => {
            let names = models(other.unwrap_or(*set), paper, runner);
            names.into_iter().filter(|(name, _)| is_other(name)).count()
        }
        Statistic::LevelsOf { model, .. }
        | Statistic::RecoveryOf { model, .. }
        | Statistic::ViewsOf { model, .. }
        | Statistic::Mesh { model, .. }
        | Statistic::StripsOf { model, .. }
        | Statistic::OneStripComponents { model, .. }
        | Statistic::Speed { model, .. } => usize::from(is_other(model)),
        Statistic::Columns { table, of, than, .. } => {
            let files = cells(table, (of, than), paper, runner).into_iter().map(|(file, _)| file);
            files.collect::<BTreeSet<_>>().into_iter().filter(|file| is_other(file)).count()
        }
        // These statistics skip stand-ins.
        Statistic::LruSaving { .. } | Statistic::SavedBy { .. } => 0,
    }
}

/// Returns the value of a statistic and the number of its models; `None` if there is no model.
fn value(
    statistic: &Statistic,
    other: Option<ModelSet>,
    paper: &Paper,
    runner: &Runner,
) -> Option<(f64, usize)> {
    let chosen = |set: ModelSet| models(other.unwrap_or(set), paper, runner);
    let figures = |flags: &str, figure: &str, set: ModelSet| -> Vec<(f64, f64)> {
        let recipe = Recipe::from(flags);
        chosen(set)
            .into_iter()
            .filter_map(|(_, model)| Some((model.size.triangles as f64, model.strips(&recipe, figure)?)))
            .collect()
    };
    match statistic {
        Statistic::Saving { over, figure, flags, than, models } => {
            let [ours, theirs] = [flags, than].map(|flags| Recipe::from(flags.as_str()));
            let pairs: Vec<_> = chosen(*models)
                .into_iter()
                .filter_map(|(_, model)| {
                    let triangles = model.size.triangles as f64;
                    let [a, b] = [&ours, &theirs].map(|recipe| model.strips(recipe, figure));
                    Some((a? / triangles, b? / triangles))
                })
                .collect();
            saving(&pairs, *over).map(|saving| (saving, pairs.len()))
        }
        Statistic::Excess { figure, flags, models } => {
            let pairs = figures(flags, figure, *models);
            let excess = pairs.iter().map(|(triangles, cost)| 100.0 * (cost / (triangles + 2.0) - 1.0));
            mean(excess)
        }
        Statistic::Mean { figure, flags, models } => {
            mean(figures(flags, figure, *models).into_iter().map(|(_, value)| value))
        }
        Statistic::Exponent { figure, flags, models } => {
            let pairs = figures(flags, figure, *models);
            slope(&pairs).map(|slope| (slope, pairs.len()))
        }
        Statistic::Rank { figure, flags, among, models } => {
            let total = |flags: &str| figures(flags, figure, *models).iter().map(|(t, f)| f / t).sum::<f64>();
            let count = figures(flags, figure, *models).len();
            let own = total(flags);
            let before = among.flags().iter().filter(|other| total(other) < own).count();
            (count > 0).then_some((1.0 + before as f64, count))
        }
        Statistic::Levels { figure, flags, models: set } => {
            let recipe = Recipe::from(flags.as_str());
            mean(chosen(*set).into_iter().filter_map(|(_, model)| model.levels(&recipe, figure)))
        }
        Statistic::LevelsOf { figure, flags, model } => {
            Some((runner.model(model)?.levels(&flags.as_str().into(), figure)?, 1))
        }
        Statistic::RecoveryOf { figure, flags, model } => {
            Some((runner.model(model)?.recovery(&flags.as_str().into(), figure)?, 1))
        }
        Statistic::ViewsOf { figure, flags, order, model } => {
            let views = runner.model(model)?.views(&flags.as_str().into())?;
            Some((views.get(*order, None, figure)?, 1))
        }
        Statistic::Columns { over, table, of, than } => {
            let (files, pairs): (BTreeSet<_>, Vec<_>) =
                cells(table, (of, than), paper, runner).into_iter().unzip();
            saving(&pairs, *over).map(|saving| (saving, files.len()))
        }
        Statistic::Mesh { figure, model } => Some((runner.model(model)?.mesh(figure)?, 1)),
        Statistic::StripsOf { figure, flags, than, model } => {
            let of = |flags: &String| runner.model(model)?.strips(&flags.as_str().into(), figure);
            let than = than.as_ref().map_or(Some(1.0), of)?;
            Some((of(flags)? / than, 1))
        }
        Statistic::OneStripComponents { flags, model } => {
            Some((runner.model(model)?.strips(&flags.as_str().into(), ONE_STRIP_COMPONENTS)?, 1))
        }
        Statistic::LruSaving { chart, entries, flush_policy } => {
            let savings = transmitted(chart, *flush_policy, paper, runner).into_iter().map(|(lru, fifo)| {
                let of_size = CACHE_ENTRIES.zip(lru.iter().zip(&fifo));
                let of_size = of_size.filter(|(size, _)| (entries.0..=entries.1).contains(size));
                mean(of_size.map(|(_, (lru, fifo))| 100.0 * (1.0 - lru / fifo))).map_or(0.0, |mean| mean.0)
            });
            mean(savings)
        }
        Statistic::SavedBy { chart, entries, flush_policy } => {
            let at = CACHE_ENTRIES.into_iter().position(|size| size == *entries)?;
            let shares =
                transmitted(chart, *flush_policy, paper, runner).into_iter().filter_map(|(lru, _)| {
                    let (first, last) = (lru.first()?, lru.last()?);
                    (last < first).then(|| 100.0 * (first - lru[at]) / (first - last))
                });
            mean(shares)
        }
        Statistic::Speed { chart, model } => speed(chart, model, paper, runner).map(|times| (times, 1)),
    }
}

/// Returns the measured cells of two columns of a table, with the file of each row. Rows with a
/// missing cell are skipped.
fn cells<'a>(
    table: &str,
    (of, than): (&str, &str),
    paper: &'a Paper,
    runner: &Runner,
) -> Vec<(&'a str, (f64, f64))> {
    let Some(table) = paper.tables.iter().find(|known| known.name == table) else { return Vec::new() };
    let at = |name: &str| table.columns.iter().position(|column| column.name == name);
    let (Some(of), Some(than)) = (at(of), at(than)) else { return Vec::new() };
    let cells = |row: &'a PublishedRow| {
        let values = measured_values(row, &table.columns, runner);
        Some((row.file.as_deref()?, (values[of]?, values[than]?)))
    };
    table.rows.iter().filter_map(cells).collect()
}

/// Returns the transmitted vertices by vertex-cache size, for LRU and FIFO, of each measured model
/// of a chart, without stand-ins.
fn transmitted(
    chart: &str,
    flush_policy: FlushPolicy,
    paper: &Paper,
    runner: &Runner,
) -> Vec<(Vec<f64>, Vec<f64>)> {
    let charts = paper.charts.iter().filter(|data| data.name == chart);
    let mut costs = Vec::new();
    for data in charts {
        if let ChartKind::VertexCaches { flags, models, .. } = &data.kind {
            let recipe = Recipe::from(flags.as_str());
            let own = models.iter().filter(|name| is_own(name, paper, runner));
            let measured = own.filter_map(|name| runner.model(name)).filter(|model| model.size.triangles > 0);
            let both = |model: &MeasuredModel| {
                let of = |rule| model.transmitted(&recipe, rule, flush_policy);
                (of(Replacement::Lru), of(Replacement::Fifo))
            };
            costs.extend(measured.map(both).filter(|(lru, _)| !lru.is_empty()));
        }
    }
    costs
}

/// Returns the steps of the first series divided by those after which the second series has as few
/// strips.
fn speed(chart: &str, model: &str, paper: &Paper, runner: &Runner) -> Option<f64> {
    let data = paper.charts.iter().find(|data| data.name == chart)?;
    let ChartKind::Convergence { steps, series, .. } = &data.kind else { return None };
    let [slow, fast] = series.as_slice() else { return None };
    let model = runner.model(model)?;
    let progress = |flags: &str| model.progress(&Recipe { flags: flags.into(), steps: Some(*steps) });
    let (slow_steps, strips) = progress(&slow.flags).last()?;
    let fast_steps = progress(&fast.flags).iter().find(|(_, left)| left <= strips)?.0;
    Some(*slow_steps as f64 / fast_steps as f64)
}

/// Returns the mean and the number of values; `None` without values.
fn mean(values: impl Iterator<Item = f64>) -> Option<(f64, usize)> {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| (sum / count as f64, count))
}

/// Returns the percentage by which the first values of pairs are below the second values.
fn saving(pairs: &[(f64, f64)], over: SavingOver) -> Option<f64> {
    let percent = |(a, b): (f64, f64)| if b == 0.0 { 0.0 } else { 100.0 * (1.0 - a / b) };
    match over {
        SavingOver::Mean => mean(pairs.iter().copied().map(percent)).map(|mean| mean.0),
        SavingOver::Least => pairs.iter().copied().map(percent).min_by(f64::total_cmp),
        SavingOver::Greatest => pairs.iter().copied().map(percent).max_by(f64::total_cmp),
        SavingOver::Sum if pairs.is_empty() => None,
        SavingOver::Sum => {
            Some(percent(pairs.iter().fold((0.0, 0.0), |sum, pair| (sum.0 + pair.0, sum.1 + pair.1))))
        }
    }
}

/// Returns the slope of the regression line (least squares) of the logarithms of pairs.
pub(super) fn slope(pairs: &[(f64, f64)]) -> Option<f64> {
    let pairs = pairs.iter().filter(|pair| pair.0 > 0.0 && pair.1 > 0.0);
    let logs: Vec<(f64, f64)> = pairs.map(|pair| (libm::log(pair.0), libm::log(pair.1))).collect();
    let (x_mean, _) = mean(logs.iter().map(|pair| pair.0))?;
    let (y_mean, _) = mean(logs.iter().map(|pair| pair.1))?;
    let along = |(x, y): &(f64, f64)| ((x - x_mean) * (x - x_mean), (x - x_mean) * (y - y_mean));
    let (xx, xy) = logs.iter().map(along).fold((0.0, 0.0), |sum, term| (sum.0 + term.0, sum.1 + term.1));
    (xx > 0.0).then(|| xy / xx)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn savings_are_combined() {
        let pairs = [(90.0, 100.0), (100.0, 200.0)];
        assert_eq!(saving(&pairs, SavingOver::Mean).map(f64::round), Some(30.0));
        assert_eq!(saving(&pairs, SavingOver::Greatest), Some(50.0));
        assert_eq!(saving(&pairs, SavingOver::Least).map(f64::round), Some(10.0));
        assert_eq!(saving(&pairs, SavingOver::Sum).map(f64::round), Some(37.0));
        assert!(
            [SavingOver::Mean, SavingOver::Least, SavingOver::Greatest, SavingOver::Sum]
                .iter()
                .all(|&over| saving(&[], over).is_none())
        );
        assert_eq!(saving(&[(1.0, 0.0)], SavingOver::Mean), Some(0.0));
    }

    #[test]
    fn the_slope_is_the_exponent_of_growth() {
        let power = |p: f64| [1.0, 2.0, 8.0].map(|x: f64| (x, 3.0 * x.powf(p)));
        assert!((slope(&power(1.0)).unwrap() - 1.0).abs() < 1e-9);
        assert!((slope(&power(2.0)).unwrap() - 2.0).abs() < 1e-9);
        assert_eq!(slope(&[(1.0, 2.0), (1.0, 2.0), (0.0, 1.0)]), None);
    }
}
