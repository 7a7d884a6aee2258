//! The measurement of one model: every method and every rival finds strips, they are proven, and only then timed.
//!
//! # Algorithm
//! 1. Each contender runs once, with its memory counted. Its strips are proven; a result that is wrong stops everything.
//! 2. Rounds follow, in each of which every contender runs once, so that what disturbs the machine disturbs all of them. A
//!    contender that has used up its share of time sits out. Each result must be the one that was proven, index by index.
//! 3. A contender's time is the median of its rounds; its ratio is to the median of the reference, meshoptimizer's strip order and
//!    strips.

use std::time::Instant;

use serde::Serialize;
use tristrip::strip::Metrics;
use tristrip::verify::verify;
use tristrip::{Mesh, Strips, stripify};

use crate::Failure;
use crate::memory::extra_bytes;
use crate::methods::Named;
use crate::models::{Fed, Source, load};
use crate::peers::Peers;
use crate::rivals::{Pipeline, strips_of};

/// Seconds after which a contender runs no further rounds on a model.
const SHARE: f64 = 1.5;

/// How much is measured.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The methods to run.
    pub methods: Vec<Named>,
    /// Rounds of timing at most.
    pub rounds: usize,
}

/// The figures of one contender on one model.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// The method, or the rival.
    pub method: String,
    /// Always true: what is not proven is not shown.
    pub proven: bool,
    /// Strips.
    pub strips: usize,
    /// Strips of one triangle.
    pub isolated: usize,
    /// Repeated vertices.
    pub swaps: usize,
    /// The OpenGL cost.
    pub vertices_sent: usize,
    /// The GL cost.
    pub gl_cost: usize,
    /// Indices with restarts, a triangle.
    pub indices_restart_per_triangle: f64,
    /// Indices with degenerate triangles, a triangle.
    pub indices_degenerate_per_triangle: f64,
    /// Median time from faces to strips.
    pub seconds: f64,
    /// That, by the time of the reference in the same rounds; none for polygons, which the reference does not take.
    pub time_ratio: Option<f64>,
    /// The most bytes in use at once beyond input and result, a triangle; not known of rivals.
    pub extra_bytes_per_triangle: Option<f64>,
}

/// The figures of all contenders on one model, fed in one way.
#[derive(Debug, Clone, Serialize)]
pub struct Outcome {
    /// The model's name.
    pub model: String,
    /// Whether polygons were fed as polygons.
    pub polygons: bool,
    /// Triangles that the faces make.
    pub triangles: usize,
    /// The contenders in the order in which they are shown.
    pub rows: Vec<Row>,
    /// What other programs reach on the same triangles, where that is known.
    pub peers: Option<Peers>,
}

impl Outcome {
    /// Gives the row of a method.
    pub fn row(&self, method: &str) -> Option<&Row> {
        self.rows.iter().find(|row| row.method == method)
    }
}

/// Measures a model as triangles and, where it has polygons, as polygons.
///
/// # Errors
/// The model cannot be read, or a result is not proven.
pub fn measure(source: &Source, plan: &Plan, peers: Option<&Peers>) -> Result<Vec<Outcome>, Failure> {
    let Fed { triangles, polygons } = load(source)?;
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

/// A way to strips and what it was seen to do.
struct Contender<'a> {
    name: String,
    run: Box<dyn Fn() -> Result<Answer, Failure> + 'a>,
    proven: Answer,
    metrics: Metrics,
    extra_bytes: Option<usize>,
    seconds: Vec<f64>,
}

/// What a contender gives, as it gives it, so that no conversion is timed.
#[derive(PartialEq)]
enum Answer {
    Strips(Strips),
    Indices(Vec<u32>),
}

fn contend(mesh: &Mesh, plan: &Plan) -> Result<Vec<Row>, Failure> {
    let mut contenders = Vec::new();
    for Named { name, options } in &plan.methods {
        let run = move || Ok(Answer::Strips(stripify(mesh, options)?));
        contenders.push(prove(mesh, name, Box::new(run), true)?);
    }
    let is_triangles = mesh.faces().as_triangles().is_some();
    for pipeline in Pipeline::ALL.into_iter().filter(|_| is_triangles) {
        let run = move || Ok(Answer::Indices(pipeline.run(mesh)?));
        contenders.push(prove(mesh, pipeline.name(), Box::new(run), false)?);
    }
    for _ in 0..plan.rounds {
        for contender in &mut contenders {
            if contender.seconds.iter().sum::<f64>() > SHARE {
                continue;
            }
            let start = Instant::now();
            let answer = (contender.run)()?;
            contender.seconds.push(start.elapsed().as_secs_f64());
            if answer != contender.proven {
                return Err(format!("{}: a second run gave another answer", contender.name).into());
            }
        }
    }
    let reference = contenders
        .iter()
        .find(|c| c.name == Pipeline::StripCache.name())
        .map(|reference| median(reference.seconds.clone()));
    Ok(contenders.into_iter().map(|c| row(c, reference)).collect())
}

/// Runs a contender for the first time, and proves what it gives.
fn prove<'a>(
    mesh: &Mesh,
    name: &str,
    run: Box<dyn Fn() -> Result<Answer, Failure> + 'a>,
    is_counted: bool,
) -> Result<Contender<'a>, Failure> {
    let (answer, extra) = extra_bytes(&run);
    let answer = answer.map_err(|error| format!("{name}: {error}"))?;
    let split;
    let strips = match &answer {
        Answer::Strips(strips) => strips,
        Answer::Indices(indices) => {
            split = strips_of(indices);
            &split
        }
    };
    verify(mesh, strips).map_err(|error| format!("{name}: not proven: {error}"))?;
    let metrics = Metrics::of(strips);
    let extra_bytes = extra.filter(|_| is_counted);
    Ok(Contender { name: name.into(), run, proven: answer, metrics, extra_bytes, seconds: Vec::new() })
}

fn row(contender: Contender<'_>, reference: Option<f64>) -> Row {
    let m = contender.metrics;
    let seconds = median(contender.seconds);
    Row {
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

/// Gives the middle of some times; of an even number the lower of the two.
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
    fn a_model_of_polygons_is_measured_both_ways() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../testdata/models/fish_control.ply");
        let source = Source { name: "fish_control".into(), path };
        let plan = Plan { methods: main_methods(), rounds: 2 };
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
