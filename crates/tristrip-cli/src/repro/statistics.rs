//! The statistics of claims: one number over many models.

use tristrip::strip::Replacement;

use super::judge::{Identity, identify};
use super::lab::{Lab, Measured, PLACES, Recipe};
use super::paper::{Kind, ModelSet, Over, Paper, Statistic, Strips};

/// Asks for what a statistic needs.
pub(super) fn want(statistic: &Statistic, paper: &Paper, lab: &mut Lab) {
    match statistic {
        Statistic::Saving { flags, than, models, .. } => {
            [flags, than].into_iter().for_each(|flags| want_set(flags, *models, paper, lab));
        }
        Statistic::Excess { flags, models, .. }
        | Statistic::Mean { flags, models, .. }
        | Statistic::Exponent { flags, models, .. } => want_set(flags, *models, paper, lab),
        Statistic::Rank { among, models, .. } => {
            among.flags().iter().for_each(|flags| want_set(flags, *models, paper, lab));
        }
        Statistic::Levels { flags, models, .. } => want_levels(flags, *models, paper, lab),
        Statistic::LevelsOf { flags, model, .. } => lab.want_levels(flags.as_str().into(), model),
        Statistic::Mesh { model, .. } => lab.want_mesh(model),
        // What charts need is asked for by them.
        Statistic::LruSaving { .. } | Statistic::SavedBy { .. } | Statistic::Speed { .. } => (),
    }
}

fn want_set(flags: &str, set: ModelSet, paper: &Paper, lab: &mut Lab) {
    if set == ModelSet::Table {
        let rows = paper.tables.iter().flat_map(|table| &table.rows);
        rows.filter_map(|row| row.file.as_ref()).for_each(|file| lab.want(flags.into(), file));
    } else {
        lab.want_set(flags.into(), set);
    }
}

/// Asks for levels of detail of the models of the paper's tables; they take too long for all.
fn want_levels(flags: &str, set: ModelSet, paper: &Paper, lab: &mut Lab) {
    let rows = paper.tables.iter().flat_map(|table| &table.rows).filter(|_| set == ModelSet::Table);
    rows.filter_map(|row| row.file.as_ref()).for_each(|file| lab.want_levels(flags.into(), file));
}

/// Lists the models of a set that are here.
fn models<'a>(set: ModelSet, paper: &Paper, lab: &'a Lab) -> Vec<&'a Measured> {
    let is_table = |name: &str| {
        let rows = paper.tables.iter().flat_map(|table| &table.rows);
        rows.filter(|row| row.file.as_deref() == Some(name))
            .any(|row| matches!(identify(row, lab), Identity::Same { .. }))
    };
    let chosen = lab.models().filter(|(name, measured)| match set {
        ModelSet::Table => is_table(name),
        ModelSet::Polygons => measured.has_polygons,
        ModelSet::All => true,
    });
    // Nothing divides by the triangles of an empty mesh.
    chosen.map(|(_, measured)| measured).filter(|measured| measured.triangles > 0).collect()
}

/// Computes a statistic, and how many models it is over; none where no model is here.
pub(super) fn compute(statistic: &Statistic, paper: &Paper, lab: &Lab) -> Option<(f64, usize)> {
    let figures = |flags: &str, figure: &str, set| -> Vec<(f64, f64)> {
        let recipe = Recipe::from(flags);
        let pairs = models(set, paper, lab).into_iter();
        pairs.filter_map(|model| Some((model.triangles as f64, model.strips(&recipe, figure)?))).collect()
    };
    match statistic {
        Statistic::Saving { over, figure, flags, than, models } => {
            let (ours, theirs) = (figures(flags, figure, *models), figures(than, figure, *models));
            let pairs: Vec<_> = ours.iter().zip(&theirs).map(|(a, b)| (a.1 / a.0, b.1 / b.0)).collect();
            saving(&pairs, *over).map(|saving| (saving, pairs.len()))
        }
        Statistic::Excess { figure, flags, models } => {
            let pairs = figures(flags, figure, *models);
            let excess = pairs.iter().map(|(triangles, cost)| 100.0 * (cost / (triangles + 2.0) - 1.0));
            mean(excess)
        }
        Statistic::Mean { figure, flags, models } => {
            mean(figures(flags, figure, *models).into_iter().map(|(_, figure)| figure))
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
            mean(models(*set, paper, lab).into_iter().filter_map(|model| model.levels(&recipe, figure)))
        }
        Statistic::LevelsOf { figure, flags, model } => {
            Some((lab.model(model)?.levels(&flags.as_str().into(), figure)?, 1))
        }
        Statistic::Mesh { figure, model } => Some((lab.model(model)?.mesh(figure)?, 1)),
        Statistic::LruSaving { chart, places, between } => {
            let savings = buffers(chart, *between, paper, lab).into_iter().map(|(lru, fifo)| {
                let of_size = PLACES.zip(lru.iter().zip(&fifo));
                let of_size = of_size.filter(|(size, _)| (places.0..=places.1).contains(size));
                mean(of_size.map(|(_, (lru, fifo))| 100.0 * (1.0 - lru / fifo))).map_or(0.0, |mean| mean.0)
            });
            mean(savings)
        }
        Statistic::SavedBy { chart, places, between } => {
            let at = PLACES.into_iter().position(|size| size == *places)?;
            let shares = buffers(chart, *between, paper, lab).into_iter().filter_map(|(lru, _)| {
                let (first, last) = (lru.first()?, lru.last()?);
                (last < first).then(|| 100.0 * (first - lru[at]) / (first - last))
            });
            mean(shares)
        }
        Statistic::Speed { chart, model } => speed(chart, model, paper, lab).map(|times| (times, 1)),
    }
}

/// Gives the costs by size of a chart's models that are here, LRU and FIFO.
fn buffers(chart: &str, between: Strips, paper: &Paper, lab: &Lab) -> Vec<(Vec<f64>, Vec<f64>)> {
    let charts = paper.charts.iter().filter(|data| data.name == chart);
    let mut costs = Vec::new();
    for data in charts {
        if let Kind::Buffers { flags, models, .. } = &data.kind {
            let recipe = Recipe::from(flags.as_str());
            let here = models.iter().filter_map(|name| lab.model(name)).filter(|model| model.triangles > 0);
            let both = |model: &Measured| {
                let of = |rule| model.transmitted(&recipe, rule, between);
                (of(Replacement::Lru), of(Replacement::Fifo))
            };
            costs.extend(here.map(both).filter(|(lru, _)| !lru.is_empty()));
        }
    }
    costs
}

/// Gives how many times as many steps the first series takes for the strips that it ends with, as the second does.
fn speed(chart: &str, model: &str, paper: &Paper, lab: &Lab) -> Option<f64> {
    let data = paper.charts.iter().find(|data| data.name == chart)?;
    let Kind::Convergence { steps, series, .. } = &data.kind else { return None };
    let [slow, fast] = series.as_slice() else { return None };
    let model = lab.model(model)?;
    let progress = |flags: &str| model.progress(&Recipe { flags: flags.into(), steps: Some(*steps) });
    let (slow_steps, strips) = progress(&slow.flags).last()?;
    let fast_steps = progress(&fast.flags).iter().find(|(_, left)| left <= strips)?.0;
    Some(*slow_steps as f64 / fast_steps as f64)
}

fn mean(figures: impl Iterator<Item = f64>) -> Option<(f64, usize)> {
    let (sum, count) = figures.fold((0.0, 0), |(sum, count), figure| (sum + figure, count + 1));
    (count > 0).then(|| (sum / count as f64, count))
}

/// Gives how many percent the first of pairs are below the second.
fn saving(pairs: &[(f64, f64)], over: Over) -> Option<f64> {
    let percent = |(a, b): (f64, f64)| if b == 0.0 { 0.0 } else { 100.0 * (1.0 - a / b) };
    match over {
        Over::Mean => mean(pairs.iter().copied().map(percent)).map(|mean| mean.0),
        Over::Greatest => pairs.iter().copied().map(percent).max_by(f64::total_cmp),
        Over::Sum if pairs.is_empty() => None,
        Over::Sum => {
            Some(percent(pairs.iter().fold((0.0, 0.0), |sum, pair| (sum.0 + pair.0, sum.1 + pair.1))))
        }
    }
}

/// Gives the slope of the straight line that is nearest to the logarithms of pairs.
fn slope(pairs: &[(f64, f64)]) -> Option<f64> {
    let pairs = pairs.iter().filter(|pair| pair.0 > 0.0 && pair.1 > 0.0);
    let logs: Vec<(f64, f64)> = pairs.map(|pair| (pair.0.ln(), pair.1.ln())).collect();
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
    fn savings_become_one_number() {
        let pairs = [(90.0, 100.0), (100.0, 200.0)];
        assert_eq!(saving(&pairs, Over::Mean).map(f64::round), Some(30.0));
        assert_eq!(saving(&pairs, Over::Greatest), Some(50.0));
        assert_eq!(saving(&pairs, Over::Sum).map(f64::round), Some(37.0));
        assert!([Over::Mean, Over::Greatest, Over::Sum].iter().all(|&over| saving(&[], over).is_none()));
        assert_eq!(saving(&[(1.0, 0.0)], Over::Mean), Some(0.0));
    }

    #[test]
    fn a_slope_is_the_exponent_of_growth() {
        let power = |p: f64| [1.0, 2.0, 8.0].map(|x: f64| (x, 3.0 * x.powf(p)));
        assert!((slope(&power(1.0)).unwrap() - 1.0).abs() < 1e-9);
        assert!((slope(&power(2.0)).unwrap() - 2.0).abs() < 1e-9);
        assert_eq!(slope(&[(1.0, 2.0), (1.0, 2.0), (0.0, 1.0)]), None);
    }
}
