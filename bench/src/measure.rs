//! Measurement of one model: the strips of every method and of meshoptimizer are proven first, and
//! then timed.
//!
//! # Algorithm
//! 1. Each contender runs once while its memory is counted. Its strips are proven; a wrong result
//!    stops the benchmark.
//! 2. In each of the following rounds, every contender runs once, which spreads other load on the
//!    machine over all of them. A contender that has used up its time limit is skipped. Each result
//!    must equal the proven one, index by index.
//! 3. The time of a contender is the median of its rounds. Its ratio is relative to the median of
//!    the reference: meshoptimizer's strip-friendly order with its strips.

use std::time::Instant;

use serde::Serialize;
use tristrip::Metrics;
use tristrip::verify::verify;
use tristrip::{Mesh, Strips, stripify};

use crate::failure::Failure;
use crate::memory::extra_bytes;
use crate::meshoptimizer::{Pipeline, strips_of};
use crate::methods::NamedMethod;
use crate::models::{LoadedModel, Source, load};
use crate::peers::Peers;

/// The time in seconds after which a contender runs no further rounds on a model.
const SHARE: f64 = 1.5;

/// The methods and rounds of a measurement.
#[derive(Debug, Clone)]
pub struct MeasurePlan {
    /// The methods to run.
    pub methods: Vec<NamedMethod>,
    /// The maximum number of timed rounds.
    pub rounds: usize,
}

/// The metrics of one contender on one model.
#[derive(Debug, Clone, Serialize)]
pub struct MethodRow {
    /// The name of the method, or of the meshoptimizer pipeline.
    pub method: String,
    /// Always true: results that are not proven are not shown.
    pub proven: bool,
    /// The number of strips.
    pub strips: usize,
    /// The number of strips of one triangle.
    pub isolated: usize,
    /// The number of swaps: vertices repeated within a strip.
    pub swaps: usize,
    /// The OpenGL cost.
    pub vertices_sent: usize,
    /// The GL cost.
    pub gl_cost: usize,
    /// The number of indices with restarts per triangle.
    pub indices_restart_per_triangle: f64,
    /// The number of indices with degenerate triangles per triangle.
    pub indices_degenerate_per_triangle: f64,
    /// The median time from faces to strips, in seconds.
    pub seconds: f64,
    /// This time relative to the reference in the same rounds; `None` for polygons, which the
    /// reference does not accept.
    pub time_ratio: Option<f64>,
    /// The peak bytes in use beyond input and result, per triangle; `None` for meshoptimizer.
    pub extra_bytes_per_triangle: Option<f64>,
}

/// The metrics of all contenders on one model, as triangles or as polygons.
#[derive(Debug, Clone, Serialize)]
pub struct Outcome {
    /// The model's name.
    pub model: String,
    /// Whether the input was polygons.
    pub polygons: bool,
    /// The number of triangles of the faces.
    pub triangles: usize,
    /// The contenders in display order.
    pub rows: Vec<MethodRow>,
    /// The results of other programs on the same triangles; `None` if they are unknown.
    pub peers: Option<Peers>,
}

impl Outcome {
    /// Returns the row of a method.
    pub fn row(&self, method: &str) -> Option<&MethodRow> {
        self.rows.iter().find(|row| row.method == method)
    }
}

/// Measures a model as triangles and, if it has polygons, as polygons.
///
/// # Errors
/// The model cannot be read, or a result is not proven.
pub fn measure(source: &Source, plan: &MeasurePlan, peers: Option<&Peers>) -> Result<Vec<Outcome>, Failure> {
    let LoadedModel { triangles, polygons } = load(source)?;
    let count = triangles.faces().face_count();
    if let Some(peers) = peers.filter(|peers| peers.triangles != count) {
        return Err(
            format!("{}: found {count} triangles, the peers had {}", source.name, peers.triangles).into()
        );
    }
    let mut outcomes = Vec::new();
    for (mesh, is_polygons) in [(Some(&triangles), false), (polygons.as_ref(), true)] {
        let Some(mesh) = mesh else { continue };
        let rows = contend(mesh, plan).map_err(|error| format!("{}: {error}", source.name))?;
        outcomes.push(Outcome {
            model: source.name.clone(),
            polygons: is_polygons,
            triangles: mesh.faces().triangle_count(),
            rows,
            peers: peers.filter(|_| !is_polygons).cloned(),
        });
    }
    Ok(outcomes)
}

/// A method or pipeline under measurement.
struct Contender<'a> {
    name: String,
    run: Box<dyn Fn() -> Result<Output, Failure> + 'a>,
    proven: Output,
    metrics: Metrics,
    extra_bytes: Option<usize>,
    seconds: Vec<f64>,
}

/// The result of a contender in its own form, which avoids timing a conversion.
#[derive(PartialEq)]
enum Output {
    Strips(Strips),
    Indices(Vec<u32>),
}

fn contend(mesh: &Mesh, plan: &MeasurePlan) -> Result<Vec<MethodRow>, Failure> {
    let mut contenders = Vec::new();
    for NamedMethod { name, options } in &plan.methods {
        let run = move || Ok(Output::Strips(stripify(mesh, options)?));
        contenders.push(prove(mesh, name, Box::new(run), true)?);
    }
    let is_triangles = mesh.faces().as_triangles().is_some();
    for pipeline in Pipeline::ALL.into_iter().filter(|_| is_triangles) {
        let run = move || Ok(Output::Indices(pipeline.run(mesh)?));
        contenders.push(prove(mesh, pipeline.name(), Box::new(run), false)?);
    }
    for _ in 0..plan.rounds {
        for contender in &mut contenders {
            if contender.seconds.iter().sum::<f64>() > SHARE {
                continue;
            }
            let start = Instant::now();
            let output = (contender.run)()?;
            contender.seconds.push(start.elapsed().as_secs_f64());
            if output != contender.proven {
                return Err(format!("{}: a second run gave a different result", contender.name).into());
            }
        }
    }
    let reference = contenders
        .iter()
        .find(|c| c.name == Pipeline::StripCache.name())
        .map(|reference| median(reference.seconds.clone()));
    Ok(contenders.into_iter().map(|c| row(c, reference)).collect())
}

/// Runs a contender for the first time, and proves its result.
fn prove<'a>(
    mesh: &Mesh,
    name: &str,
    run: Box<dyn Fn() -> Result<Output, Failure> + 'a>,
    is_counted: bool,
) -> Result<Contender<'a>, Failure> {
    let (output, extra) = extra_bytes(&run);
    let output = output.map_err(|error| format!("{name}: {error}"))?;
    let split;
    let strips = match &output {
        Output::Strips(strips) => strips,
        Output::Indices(indices) => {
            split = strips_of(indices);
            &split
        }
    };
    verify(mesh, strips).map_err(|error| format!("{name}: not proven: {error}"))?;
    let metrics = Metrics::of(strips);
    let extra_bytes = extra.filter(|_| is_counted);
    Ok(Contender { name: name.into(), run, proven: output, metrics, extra_bytes, seconds: Vec::new() })
}

fn row(contender: Contender<'_>, reference: Option<f64>) -> MethodRow {
    let m = contender.metrics;
    let seconds = median(contender.seconds);
    MethodRow {
        method: contender.name,
        proven: true,
        strips: m.strips,
        isolated: m.isolated,
        swaps: m.swaps,
        vertices_sent: m.vertices_sent,
        gl_cost: m.gl_cost,
        indices_restart_per_triangle: m.indices_restart_per_triangle(),
        indices_degenerate_per_triangle: m.indices_degenerate_per_triangle(),
        seconds,
        time_ratio: reference.map(|reference| seconds / reference),
        extra_bytes_per_triangle: contender.extra_bytes.map(|bytes| bytes as f64 / m.triangles.max(1) as f64),
    }
}

/// Returns the median, which is the lower of the two middle values for an even number of values.
pub fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get(times.len().saturating_sub(1) / 2).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::main_methods;
    use std::path::Path;

    #[test]
    fn polygons_are_measured_as_polygons_and_as_triangles() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../testdata/models/fish_control.ply");
        let source = Source { name: "fish_control".into(), path };
        let plan = MeasurePlan { methods: main_methods(), rounds: 2 };
        let outcomes = measure(&source, &plan, None).unwrap();
        assert_eq!(
            outcomes.iter().map(|o| (o.polygons, o.triangles)).collect::<Vec<_>>(),
            [(false, 220), (true, 220)]
        );
        assert_eq!(outcomes[0].rows.len(), plan.methods.len() + Pipeline::ALL.len());
        assert!(outcomes[0].rows.iter().all(|row| row.seconds > 0.0 && row.time_ratio.is_some()));
        assert_eq!(outcomes[1].rows.len(), plan.methods.len());
    }

    #[test]
    fn the_median_is_in_the_middle() {
        assert!((median(vec![5.0, 1.0, 2.0]) - 2.0).abs() < f64::EPSILON);
        assert!(median(vec![]).is_nan());
    }
}
