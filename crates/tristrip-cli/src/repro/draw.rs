//! The figures of papers, drawn anew from what was measured.

use tristrip::strip::Replacement;

use super::judge::{ChartReport, PanelReport, SeriesReport};
use super::lab::{Lab, PLACES, Recipe};
use super::paper::{ChartData, CorpusPanel, Kind, LevelsPanel, LevelsSeries, ModelSet, Strips, Variant};
use crate::chart::{Axis, Mark, Panel, Scale, Series, svg};
use crate::failure::Failure;

/// Asks for what a chart needs.
pub(super) fn want(chart: &ChartData, lab: &mut Lab) {
    match &chart.kind {
        Kind::Corpus { series, .. } => {
            series.iter().for_each(|s| lab.want_set(s.flags.as_str().into(), ModelSet::All));
        }
        Kind::Buffers { flags, models, .. } => {
            models.iter().for_each(|model| lab.want_buffers(flags.as_str().into(), model));
        }
        Kind::Levels { model, panels, .. } => {
            panels.iter().for_each(|panel| lab.want_levels(panel.flags.as_str().into(), model));
        }
        Kind::Convergence { models, steps, series } => {
            for model in models {
                series.iter().for_each(|s| lab.want(searched(s, *steps), model));
            }
        }
    }
}

fn searched(series: &Variant, steps: u64) -> Recipe {
    Recipe { flags: series.flags.clone(), steps: Some(steps) }
}

/// What a panel shows before it is drawn.
struct Sketch {
    title: String,
    x: Axis,
    y: Axis,
    mark: Mark,
    /// Whether the last figure of a series is written beside it.
    ends: bool,
    series: Vec<SeriesReport>,
}

/// Draws a chart.
pub(super) fn draw(chart: &ChartData, lab: &Lab) -> Result<ChartReport, Failure> {
    let (sketches, columns) = match &chart.kind {
        Kind::Corpus { panels, series } => {
            (panels.iter().map(|panel| corpus(panel, series, lab)).collect(), 1)
        }
        Kind::Buffers { flags, models, columns } => {
            let sketches: Vec<_> = models.iter().filter_map(|name| buffers(name, flags, lab)).collect();
            (sketches, *columns)
        }
        Kind::Levels { model, panels, axis, series } => {
            let sketches = panels.iter().filter_map(|panel| by_level(model, panel, axis, series, lab));
            (sketches.collect(), 1)
        }
        Kind::Convergence { models, steps, series } => {
            let sketches = models.iter().filter_map(|name| convergence(name, *steps, series, lab));
            (sketches.collect(), models.len())
        }
    };
    let panels: Vec<Panel> = sketches.iter().map(Sketch::panel).collect();
    let report = |sketch: Sketch| PanelReport { title: sketch.title, series: sketch.series };
    Ok(ChartReport {
        name: chart.name.clone(),
        file: chart.file.clone(),
        svg: svg(&panels, columns)?,
        panels: sketches.into_iter().map(report).collect(),
    })
}

impl Sketch {
    fn panel(&self) -> Panel {
        let series = self.series.iter().map(|s| {
            let series = Series::new(&s.name, self.mark, s.points.clone());
            if self.ends { series.with_labels(end_label(&s.points)) } else { series }
        });
        Panel::new(&self.title, self.x.clone(), self.y.clone(), series.collect())
    }
}

/// Labels the last point alone.
fn end_label(points: &[(f64, f64)]) -> Vec<String> {
    let label = |(number, point): (usize, &(f64, f64))| {
        if number + 1 == points.len() { format!("{:.0}", point.1) } else { String::new() }
    };
    points.iter().enumerate().map(label).collect()
}

/// A point a model, by its triangles.
fn corpus(panel: &CorpusPanel, series: &[Variant], lab: &Lab) -> Sketch {
    let points = |variant: &Variant| {
        let recipe = Recipe::from(variant.flags.as_str());
        let mut points: Vec<(f64, f64)> = lab
            .models()
            .filter_map(|(_, model)| {
                let triangles = model.triangles as f64;
                let figure = model.strips(&recipe, &panel.figure)?;
                Some((triangles, if panel.per_triangle { figure / triangles.max(1.0) } else { figure }))
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
    Sketch {
        title: panel.title.clone(),
        x: Axis::new("triangles", Scale::Log10),
        y: Axis::new(
            &panel.axis,
            if panel.per_triangle { Scale::Linear { from_zero: false } } else { Scale::Log10 },
        ),
        mark: Mark::Points,
        ends: false,
        series: series.collect(),
    }
}

/// The cost by the size of the buffer.
fn buffers(name: &str, flags: &str, lab: &Lab) -> Option<Sketch> {
    let model = lab.model(name)?;
    let of = |rule, between| -> Vec<(f64, f64)> {
        let costs = model.transmitted(&Recipe::from(flags), rule, between);
        PLACES.map(f64::from).zip(costs).collect()
    };
    let least = [PLACES.start(), PLACES.end()].map(|&size| (f64::from(size), model.vertices_in_use()));
    let series = |name: &str, points| SeriesReport { name: name.into(), flags: Some(flags.into()), points };
    Some(Sketch {
        title: name.into(),
        x: Axis::new("places of the buffer", Scale::Log2),
        y: Axis::new("vertices transmitted", Scale::Linear { from_zero: true }),
        mark: Mark::Line,
        ends: false,
        series: vec![
            series("FIFO", of(Replacement::Fifo, Strips::Flush)),
            series("LRU", of(Replacement::Lru, Strips::Flush)),
            series("FIFO, kept", of(Replacement::Fifo, Strips::Keep)),
            series("LRU, kept", of(Replacement::Lru, Strips::Keep)),
            SeriesReport { name: "vertices".into(), flags: None, points: least.to_vec() },
        ],
    })
}

/// Figures of levels, from the base mesh to the full one.
fn by_level(
    name: &str,
    panel: &LevelsPanel,
    axis: &str,
    series: &[LevelsSeries],
    lab: &Lab,
) -> Option<Sketch> {
    let model = lab.model(name)?;
    let recipe = Recipe::from(panel.flags.as_str());
    let series = series.iter().map(|s| SeriesReport {
        name: s.name.clone(),
        flags: Some(panel.flags.clone()),
        points: model.curve(&recipe, &s.figure),
    });
    Some(Sketch {
        title: panel.title.clone(),
        x: Axis::new("level: collapses undone, percent", Scale::Linear { from_zero: true }),
        y: Axis::new(axis, Scale::Linear { from_zero: true }),
        mark: Mark::Line,
        ends: false,
        series: series.collect(),
    })
}

/// Strips left by accesses to nodes.
fn convergence(name: &str, steps: u64, series: &[Variant], lab: &Lab) -> Option<Sketch> {
    let model = lab.model(name)?;
    let points = |variant: &Variant| {
        let progress = model.progress(&searched(variant, steps)).iter();
        progress.map(|&(steps, strips)| (steps as f64, strips as f64)).collect()
    };
    let series = series.iter().map(|variant| SeriesReport {
        name: variant.name.clone(),
        flags: Some(variant.flags.clone()),
        points: points(variant),
    });
    Some(Sketch {
        title: name.into(),
        x: Axis::new("accesses to nodes", Scale::Log10),
        y: Axis::new("strips", Scale::Log10),
        mark: Mark::Line,
        ends: true,
        series: series.collect(),
    })
}
