//! What can be found out about scenes: bounds, statistics of files, a comparison of methods, and whether two scenes draw the same.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use serde::Serialize;
use tristrip::{Effort, StripifyOptions};
use tristrip_pipeline::{
    AnalyzeOptions, Bounded, DifferenceReport, MethodRow, Observer, PreparedModel, Survey, analyze,
    bound_observed, compared_methods, verify,
};

use super::data::SceneData;
use crate::arguments::Arguments;
use crate::errors::{Failure, raise};
use crate::reports::report;
use crate::work::{Ended, Watcher, Watching};

/// Computes lower bounds of a scene.
pub(crate) fn bound<'py>(py: Python<'py>, scene: &SceneData, weld: bool) -> PyResult<Bound<'py, PyDict>> {
    let found = Watching::default().run(py, |watcher| Ok(bound_observed(scene.as_read(), weld, watcher)?));
    let bounded: Bounded = found?.result()?;
    let found = PyDict::new(py);
    found.set_item("mesh", report(py, &bounded.mesh)?)?;
    found.set_item("parts", bounded.parts.len())?;
    found.set_item("bound", report(py, &bounded.bounds)?)?;
    let sequential: Vec<bool> = bounded.parts.iter().map(|part| part.sequential).collect();
    found.set_item("sequential", sequential)?;
    found.set_item("components", report(py, &bounded.components())?)?;
    found.set_item("notes", &bounded.notes)?;
    Ok(found)
}

/// Analyzes the indices of a scene as its file has them.
pub(crate) fn statistics<'py>(
    py: Python<'py>,
    scene: &SceneData,
    options: &AnalyzeOptions,
    flushed: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let model = scene.as_read();
    let analysis = Watching::default().run(py, |_| Ok(analyze(model, options)))?.result()?;
    let found = report(py, &analysis.figures)?.cast_into::<PyDict>()?;
    found.set_item("indices_per_triangle", analysis.indices_per_triangle())?;
    found.set_item("lengths", report(py, &analysis.lengths.bins())?)?;
    found.set_item("flushed", flushed)?;
    found.set_item("vertex_caches", report(py, &analysis.cache_reports())?)?;
    found.set_item("parts", model.parts.len())?;
    found.set_item("by_part", report(py, &analysis.part_reports(model))?)?;
    found.set_item("notes", &model.notes)?;
    Ok(found)
}

#[derive(Debug, Default, Serialize)]
struct Seconds {
    stripify: Option<f64>,
    verify: Option<f64>,
}

/// Runs all methods on a scene. An interrupt has the rows so far as its best result.
pub(crate) fn compare<'py>(
    scene: &SceneData,
    arguments: &Arguments<'py>,
) -> PyResult<Ended<Bound<'py, PyList>>> {
    let py = arguments.py();
    let effort = arguments.extract::<i64>("effort")?.map(|level| {
        let effort = u8::try_from(level).ok().and_then(Effort::new);
        effort.ok_or_else(|| Failure::option("effort", level, "0 to 9"))
    });
    let effort = effort.transpose()?;
    let mut options = StripifyOptions::default().with_weld(arguments.flag("weld")?);
    options = options.with_seed(arguments.extract("seed")?.unwrap_or(0));
    if let Some(cost) = arguments.extract::<String>("cost")? {
        options = options.with_cost(cost.parse().map_err(Failure::from)?);
    }
    let every_variant = arguments.flag("all")?;
    let watching = arguments.interruptible_search()?;
    arguments.finish("compare")?;
    let rows = Mutex::new(Vec::new());
    let ended = watching.run(py, |watcher| {
        let survey = Survey::new(scene.as_read(), options, watcher)?;
        for options in compared_methods(options, effort, every_variant) {
            if watcher.is_interrupted() {
                break;
            }
            let row = row(&survey.prepared, &options.with_weld(survey.options.weld), watcher);
            rows.lock().unwrap_or_else(PoisonError::into_inner).push(row);
        }
        Ok(())
    })?;
    let rows = rows.into_inner().unwrap_or_else(PoisonError::into_inner);
    Ok(Ended { value: report(py, &rows)?.cast_into::<PyList>()?, error: ended.error })
}

/// Runs one method; its row has figures only if the result is proven.
fn row(prepared: &PreparedModel<'_>, options: &StripifyOptions, watcher: &Watcher) -> MethodRow<Seconds> {
    let mut seconds = Seconds::default();
    let watch = watcher.search(options);
    let started = Instant::now();
    let found = prepared.find_strips(options, &*watch);
    seconds.stripify = Some(started.elapsed().as_secs_f64());
    let figures = found.and_then(|strips| {
        let started = Instant::now();
        prepared.prove(&strips)?;
        seconds.verify = Some(started.elapsed().as_secs_f64());
        prepared.figures(&strips, options)
    });
    MethodRow::new(options, seconds, watch.stopped(), figures.map_err(|error| error.to_string()))
}

/// Proves that a scene draws exactly the faces of another.
pub(crate) fn prove<'py>(
    py: Python<'py>,
    source: &SceneData,
    result: &SceneData,
) -> PyResult<Bound<'py, PyDict>> {
    let (source, result) = (source.as_read(), result.as_read());
    let verdict = Watching::default().run(py, |_| Ok(verify(source, result)?))?.result()?;
    if let Err(difference) = verdict {
        let error = raise(py, "NotProvenError", &difference.to_string());
        error.value(py).setattr("difference", report(py, &DifferenceReport::of(&difference))?)?;
        return Err(error);
    }
    let found = PyDict::new(py);
    found.set_item("proven", true)?;
    let faces: usize = source.parts.iter().map(|part| part.mesh.faces().face_count()).sum();
    found.set_item("faces", faces)?;
    let triangles: usize = result.parts.iter().map(|part| part.mesh.faces().triangle_count()).sum();
    found.set_item("triangles", triangles)?;
    let notes = |name: &str, notes: &[String]| -> Vec<String> {
        notes.iter().map(|note| format!("{name}: {note}")).collect()
    };
    found.set_item("notes", [notes("source", &source.notes), notes("result", &result.notes)].concat())?;
    Ok(found)
}

/// Reads the options of an analysis.
pub(crate) fn analyze_options(
    vertex_caches: Option<&Bound<'_, PyAny>>,
    flush: bool,
) -> Result<AnalyzeOptions, Failure> {
    let mut options = AnalyzeOptions::default();
    if let Some(given) = vertex_caches {
        let text = match given.extract::<String>() {
            Ok(text) => text,
            Err(_) => given.extract::<Vec<String>>()?.join(","),
        };
        let list = text.parse().map_err(|why| Failure::Parameter(format!("vertex_caches: {why}")))?;
        options = options.with_vertex_caches(list);
    }
    if flush {
        options = options.with_flush_policy(tristrip::vertex_cache::FlushPolicy::Flush);
    }
    Ok(options)
}
