//! Draws the figures of papers from measured values.

use tristrip::vertex_cache::{FlushPolicy, Replacement};

use super::measured::CACHE_ENTRIES;
use super::paper::{ChartData, ChartKind, CorpusPanel, LevelPanel, LevelSeries, MethodSeries, ModelSet};
use super::paper_report::{ChartReport, PanelReport, SeriesReport};
use super::recipe::Recipe;
use super::runner::Runner;
use super::view_figures::PANEL;
use crate::error::Error;
use tristrip_render::chart::{Axis, Mark, Panel, Scale, Series, svg};
use tristrip_render::images::sheet;

/// Requests the measurements of a chart.
pub(super) fn request(chart: &ChartData, runner: &mut Runner) {
    match &chart.kind {
        ChartKind::Corpus { series, .. } => {
            series.iter().for_each(|s| runner.request_set(s.flags.as_str().into(), ModelSet::All));
        }
        ChartKind::VertexCaches { flags, models, .. } => {
            models.iter().for_each(|model| runner.request_generalized(flags.as_str().into(), model));
        }
        ChartKind::Levels { model, panels, .. } => {
            panels.iter().for_each(|panel| runner.request_levels(panel.flags.as_str().into(), model));
        }
        ChartKind::Convergence { models, steps, series } => {
            for model in models {
                series.iter().for_each(|s| runner.request(searched(s, *steps), model));
            }
        }
        ChartKind::Views { model, flags, order, panels } => {
            let requests = runner.request_views(flags.as_str().into(), model, *order);
            requests.pictures.insert(chart.file.clone(), panels.clone());
        }
    }
}

fn searched(series: &MethodSeries, steps: u64) -> Recipe {
    Recipe { flags: series.flags.clone(), steps: Some(steps) }
}

/// The data of a panel.
struct PanelData {
    title: String,
    x: Axis,
    y: Axis,
    mark: Mark,
    /// Whether the last value of each series is labelled.
    label_last: bool,
    series: Vec<SeriesReport>,
}

/// Draws a chart.
pub(super) fn draw(chart: &ChartData, runner: &Runner) -> Result<ChartReport, Error> {
    let (data, columns) = match &chart.kind {
        ChartKind::Corpus { panels, series } => {
            (panels.iter().map(|panel| corpus(panel, series, runner)).collect(), 1)
        }
        ChartKind::VertexCaches { flags, models, columns } => {
            let data: Vec<_> = models.iter().filter_map(|name| by_cache_size(name, flags, runner)).collect();
            (data, *columns)
        }
        ChartKind::Levels { model, panels, axis, series } => {
            let data = panels.iter().filter_map(|panel| by_level(model, panel, axis, series, runner));
            (data.collect(), 1)
        }
        ChartKind::Convergence { models, steps, series } => {
            let data = models.iter().filter_map(|name| convergence(name, *steps, series, runner));
            (data.collect(), models.len())
        }
        ChartKind::Views { model, flags, .. } => return picture(chart, model, flags, runner),
    };
    let panels: Vec<Panel> = data.iter().map(PanelData::panel).collect();
    let report = |panel: PanelData| PanelReport { title: panel.title, series: panel.series };
    Ok(ChartReport {
        name: chart.name.clone(),
        file: chart.file.clone(),
        is_measured: data.iter().flat_map(|panel| &panel.series).any(|series| !series.points.is_empty()),
        contents: svg(&panels, columns)?.into_bytes(),
        panels: data.into_iter().map(report).collect(),
    })
}

/// Returns the image of views; an empty one if the model is missing.
fn picture(chart: &ChartData, model: &str, flags: &str, runner: &Runner) -> Result<ChartReport, Error> {
    let views = runner.model(model).and_then(|model| model.views(&flags.into()));
    let drawn = views.and_then(|views| views.picture(&chart.file));
    Ok(ChartReport {
        name: chart.name.clone(),
        file: chart.file.clone(),
        is_measured: drawn.is_some(),
        contents: drawn.map_or_else(|| sheet(&[], PANEL), |drawn| Ok(drawn.to_vec()))?,
        panels: Vec::new(),
    })
}

impl PanelData {
    fn panel(&self) -> Panel {
        let series = self.series.iter().map(|s| {
            let series = Series::new(&s.name, self.mark, s.points.clone());
            if self.label_last { series.with_labels(last_label(&s.points)) } else { series }
        });
        Panel::new(&self.title, self.x.clone(), self.y.clone(), series.collect())
    }
}

/// Returns labels that are empty except for the last.
fn last_label(points: &[(f64, f64)]) -> Vec<String> {
    let label = |(index, point): (usize, &(f64, f64))| {
        if index + 1 == points.len() { format!("{:.0}", point.1) } else { String::new() }
    };
    points.iter().enumerate().map(label).collect()
}

/// Returns one point per model, with its number of triangles as x.
fn corpus(panel: &CorpusPanel, series: &[MethodSeries], runner: &Runner) -> PanelData {
    let points = |variant: &MethodSeries| {
        let recipe = Recipe::from(variant.flags.as_str());
        let mut points: Vec<(f64, f64)> = runner
            .models()
            .filter_map(|(_, model)| {
                let triangles = model.size.triangles as f64;
                let value = model.strips(&recipe, &panel.figure)?;
                Some((triangles, if panel.per_triangle { value / triangles.max(1.0) } else { value }))
            })
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        points
    };
    let series = series.iter().map(|variant| SeriesReport {
        name: variant.name.clone(),
        flags: Some(variant.flags.clone()),
        points: points(variant),
    });
    PanelData {
        title: panel.title.clone(),
        x: Axis::new("triangles", Scale::Log10),
        y: Axis::new(
            &panel.axis,
            if panel.per_triangle { Scale::Linear { from_zero: false } } else { Scale::Log10 },
        ),
        mark: Mark::Points,
        label_last: false,
        series: series.collect(),
    }
}

/// Returns the number of transmitted vertices by the size of the vertex cache.
fn by_cache_size(name: &str, flags: &str, runner: &Runner) -> Option<PanelData> {
    let model = runner.model(name)?;
    let of = |rule, flush_policy| -> Vec<(f64, f64)> {
        let transmitted = model.transmitted(&Recipe::from(flags), rule, flush_policy);
        CACHE_ENTRIES.map(f64::from).zip(transmitted).collect()
    };
    let least = [CACHE_ENTRIES.start(), CACHE_ENTRIES.end()]
        .map(|&size| (f64::from(size), model.used_vertices() as f64));
    let series = |name: &str, points| SeriesReport { name: name.into(), flags: Some(flags.into()), points };
    Some(PanelData {
        title: name.into(),
        x: Axis::new("vertex-cache entries", Scale::Log2),
        y: Axis::new("vertices transmitted", Scale::Linear { from_zero: true }),
        mark: Mark::Line,
        label_last: false,
        series: vec![
            series("FIFO", of(Replacement::Fifo, FlushPolicy::Flush)),
            series("LRU", of(Replacement::Lru, FlushPolicy::Flush)),
            series("FIFO, kept", of(Replacement::Fifo, FlushPolicy::Keep)),
            series("LRU, kept", of(Replacement::Lru, FlushPolicy::Keep)),
            SeriesReport { name: "vertices".into(), flags: None, points: least.to_vec() },
        ],
    })
}

/// Returns metrics of levels, from the base mesh to the full mesh.
fn by_level(
    name: &str,
    panel: &LevelPanel,
    axis: &str,
    series: &[LevelSeries],
    runner: &Runner,
) -> Option<PanelData> {
    let model = runner.model(name)?;
    let recipe = Recipe::from(panel.flags.as_str());
    let series = series.iter().map(|s| SeriesReport {
        name: s.name.clone(),
        flags: Some(panel.flags.clone()),
        points: model.level_curve(&recipe, &s.figure),
    });
    Some(PanelData {
        title: panel.title.clone(),
        x: Axis::new("level: undone collapses, percent", Scale::Linear { from_zero: true }),
        y: Axis::new(axis, Scale::Linear { from_zero: true }),
        mark: Mark::Line,
        label_last: false,
        series: series.collect(),
    })
}

/// Returns the number of strips by node accesses.
fn convergence(name: &str, steps: u64, series: &[MethodSeries], runner: &Runner) -> Option<PanelData> {
    let model = runner.model(name)?;
    let points = |variant: &MethodSeries| {
        let progress = model.progress(&searched(variant, steps)).iter();
        progress.map(|&(steps, strips)| (steps as f64, strips as f64)).collect()
    };
    let series = series.iter().map(|variant| SeriesReport {
        name: variant.name.clone(),
        flags: Some(variant.flags.clone()),
        points: points(variant),
    });
    Some(PanelData {
        title: name.into(),
        x: Axis::new("node accesses", Scale::Log10),
        y: Axis::new("strips", Scale::Log10),
        mark: Mark::Line,
        label_last: true,
        series: series.collect(),
    })
}
