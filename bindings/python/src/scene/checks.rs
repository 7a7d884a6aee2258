//! Analyses of scenes: bounds, file statistics, comparison of methods and scenes.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use tristrip::{Effort, StripifyOptions};
use tristrip_pipeline::{Observer, Search, SimplifyProgress, Stage, analyze, bound, compare, verify};

use super::data::SceneData;
use crate::arguments::Arguments;
use crate::errors::{Failure, raise};
use crate::reports::report;
use crate::work::{Ended, Watcher, Watching};

/// Computes lower bounds of a scene.
pub(crate) fn bound<'py>(py: Python<'py>, scene: &SceneData, weld: bool) -> PyResult<Bound<'py, PyDict>> {
    let options = bound::Options::default().with_weld(weld);
    let found = Watching::default().run(py, |watcher| Ok(bound::run(scene.as_read(), &options, watcher)?));
    Ok(report(py, &found?.result()?)?.cast_into()?)
}

/// Reports the stored indices of a scene.
pub(crate) fn statistics<'py>(
    py: Python<'py>,
    scene: &SceneData,
    options: &analyze::Options,
) -> PyResult<Bound<'py, PyDict>> {
    let found = Watching::default().run(py, |watcher| Ok(analyze::run(scene.as_read(), options, watcher)?));
    Ok(report(py, &found?.result()?)?.cast_into()?)
}

/// Runs all methods on a scene. On an interrupt, the best result is the rows so far.
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
    let options = compare::Options::default().with_stripify(options).with_effort(effort);
    let options = options.with_every_variant(arguments.flag("all")?);
    let watching = arguments.interruptible_search()?;
    arguments.finish("compare")?;
    let ended = watching.run(py, |watcher| {
        let methods = MethodTimes { watcher, of_methods: Mutex::default() };
        let mut compared = compare::run(scene.as_read(), &options, &methods)?;
        let times = methods.of_methods.into_inner().unwrap_or_else(PoisonError::into_inner);
        for (row, times) in compared.methods.iter_mut().zip(times) {
            let time_of = |wanted: Stage| {
                let at = times.iter().position(|&(stage, _)| stage == wanted)?;
                Some(times.get(at + 1)?.1.duration_since(times[at].1).as_secs_f64())
            };
            row.seconds.stripify = time_of(Stage::Stripify);
            row.seconds.verify = time_of(Stage::Prove);
        }
        Ok(compared.methods)
    })?;
    Ok(Ended { value: report(py, &ended.value)?.cast_into::<PyList>()?, error: ended.error })
}

/// Records when the stages of each method start. A method without a proven result has no time for
/// its last stage.
struct MethodTimes<'a> {
    watcher: &'a Watcher,
    of_methods: Mutex<Vec<Vec<(Stage, Instant)>>>,
}

impl Observer for MethodTimes<'_> {
    fn stage(&self, stage: Stage) {
        let mut methods = self.of_methods.lock().unwrap_or_else(PoisonError::into_inner);
        if stage == Stage::Stripify {
            methods.push(Vec::new());
        }
        if let Some(last) = methods.last_mut() {
            last.push((stage, Instant::now()));
        }
        self.watcher.stage(stage);
    }

    fn search(&self, options: &StripifyOptions) -> Box<dyn Search + '_> {
        self.watcher.search(options)
    }

    fn simplifies(&self, progress: SimplifyProgress) -> bool {
        self.watcher.simplifies(progress)
    }

    fn is_cancelled(&self) -> bool {
        self.watcher.is_cancelled()
    }
}

/// Proves that `result` draws exactly the faces of `source`.
pub(crate) fn prove<'py>(
    py: Python<'py>,
    source: &SceneData,
    result: &SceneData,
) -> PyResult<Bound<'py, PyDict>> {
    let (source, result) = (source.as_read(), result.as_read());
    let found = Watching::default().run(py, |watcher| Ok(verify::run(source, result, watcher)?))?.result()?;
    if let Some(difference) = &found.difference {
        let error = raise(py, "NotProvenError", &difference.text);
        error.value(py).setattr("difference", report(py, difference)?)?;
        return Err(error);
    }
    let found = report(py, &found)?.cast_into::<PyDict>()?;
    found.del_item("difference")?;
    let notes = |name: &str, notes: &[String]| -> Vec<String> {
        notes.iter().map(|note| format!("{name}: {note}")).collect()
    };
    found.set_item("notes", [notes("source", &source.notes), notes("result", &result.notes)].concat())?;
    Ok(found)
}

/// Takes the options of an analysis.
pub(crate) fn analyze_options(
    vertex_caches: Option<&Bound<'_, PyAny>>,
    flush: bool,
) -> Result<analyze::Options, Failure> {
    let mut options = analyze::Options::default();
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
