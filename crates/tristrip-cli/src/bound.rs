//! `tristrip bound`: lower bounds on strips, vertices and indices, and how they were found.

use serde::Serialize;
use tristrip::strip::Cost;
use tristrip::stripify::bound::{Bound, BoundMethod, sequential_strip};
use tristrip::{Method, StripifyOptions};

use crate::batch::{self, InputReport, Outcome};
use crate::console::Console;
use crate::failure::Failure;
use crate::figures::{Figures, MeshFigures};
use crate::stages::{Pool, Prepared, Seconds, timed};
use crate::survey::{Loaded, Surveyed};
use crate::task::{BoundTask, Input};
use crate::text::{count, counted, table};

/// The lower bounds of a model, summed over its parts; the keys are those of the JSON report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub(crate) struct Bounds {
    pub(crate) strips: usize,
    pub(crate) vertices_sent: usize,
    pub(crate) gl_cost: usize,
    pub(crate) indices_restart: usize,
    pub(crate) indices_degenerate: usize,
}

/// The gap between the result of a search and its lower bound.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct BoundGap {
    /// The key of the minimized figure.
    pub(crate) figure: &'static str,
    pub(crate) found: usize,
    /// No cover has a lower figure.
    pub(crate) bound: usize,
    pub(crate) gap: usize,
    /// Whether the result meets the bound.
    pub(crate) optimal: bool,
}

/// The report of one input; the keys are those of the JSON output.
#[derive(Debug, Default, Serialize)]
struct BoundReport {
    file: String,
    seconds: Seconds,
    mesh: Option<MeshFigures>,
    parts: Option<usize>,
    bound: Option<Bounds>,
    /// For each part, whether one strip without swaps draws it completely.
    sequential: Vec<bool>,
    components: Vec<ComponentReport>,
    notes: Vec<String>,
    error: Option<String>,
}

#[derive(Debug, Serialize)]
struct ComponentReport {
    part: usize,
    triangles: usize,
    strips: usize,
    vertices_sent: usize,
    proof: &'static str,
}

impl Bounds {
    /// Sums the bounds of all parts. The parts share one index buffer with restarts, as in [`Figures`].
    pub(crate) fn of(pool: &Pool, parts: &[Prepared<'_>]) -> Self {
        Self::sum(&pool.map(parts, |part| Bound::of_prepared(&part.surface, &part.graph)))
    }

    fn sum(bounds: &[Bound]) -> Self {
        let mut sum = Self::default();
        for bound in bounds {
            sum.strips += bound.strips;
            sum.vertices_sent += bound.vertices_sent;
            sum.gl_cost += bound.gl_cost;
            sum.indices_degenerate += bound.indices_degenerate;
        }
        sum.indices_restart = sum.vertices_sent + sum.strips.saturating_sub(1);
        sum
    }

    /// Compares the figure that the method minimizes with its bound; returns `None` for methods that do not search.
    pub(crate) fn gap(&self, options: &StripifyOptions, figures: &Figures) -> Option<BoundGap> {
        let (figure, found, bound) = match (options.method(), options.cost()) {
            (Method::Fewest, _) => ("strips", figures.strips, self.strips),
            (Method::Auto | Method::Best, Cost::Restart) => {
                ("indices_restart", figures.indices_restart, self.indices_restart)
            }
            (Method::Auto | Method::Best, Cost::OpenGl) => {
                ("vertices_sent", figures.vertices_sent, self.vertices_sent)
            }
            (Method::Auto | Method::Best, Cost::Degenerate) => {
                ("indices_degenerate", figures.indices_degenerate, self.indices_degenerate)
            }
            (Method::Auto | Method::Best, Cost::Gl) => ("gl_cost", figures.gl_cost, self.gl_cost),
            _ => return None,
        };
        Some(BoundGap { figure, found, bound, gap: found.saturating_sub(bound), optimal: found <= bound })
    }
}

impl BoundGap {
    /// Returns a line on the gap.
    pub(crate) fn line(&self) -> String {
        let (one, many) = match self.figure {
            "strips" => ("strip", "strips"),
            "vertices_sent" | "gl_cost" => ("vertex", "vertices"),
            _ => ("index", "indices"),
        };
        let (found, bound) = (count(self.found), count(self.bound));
        let what = if self.found == 1 { one } else { many };
        if self.optimal {
            return format!("optimal: {found} {what}, no cover of the dual graph has fewer");
        }
        let percent = 100.0 * self.gap as f64 / self.bound.max(1) as f64;
        format!("{found} {what}, lower bound {bound}: gap {} ({percent:.1} %)", count(self.gap))
    }
}

impl InputReport for BoundReport {
    fn outcome(&mut self) -> Outcome<'_> {
        Outcome { file: &self.file, proven: None, error: &mut self.error }
    }
}

/// Bounds all inputs in order; returns whether all succeeded.
pub(crate) fn run(task: &BoundTask, pool: &Pool, console: &mut Console) -> bool {
    let new_report = |input: &Input| BoundReport { file: input.name(), ..BoundReport::default() };
    let process = |input: &Input, console: &mut Console, report: &mut BoundReport| {
        bound(input, &task.options, pool, console, report)
    };
    let show = |_: &Input, report: &BoundReport, _: &str, console: &mut Console| {
        console.result(&report.as_text(), true);
    };
    let reports = batch::process_all(&task.inputs, None, console, new_report, process, show);
    batch::finish(reports, console)
}

fn bound(
    input: &Input,
    options: &StripifyOptions,
    pool: &Pool,
    console: &Console,
    report: &mut BoundReport,
) -> Result<(), Failure> {
    let loaded = Loaded::new(input, *options, console)?;
    let Surveyed { parts, mesh, notes, seconds } = loaded.survey(pool, console);
    (report.seconds, report.notes) = (seconds, notes);
    (report.parts, report.mesh) = (Some(parts.len()), Some(mesh));

    console.doing("bound");
    let (found, seconds) = timed(|| {
        pool.map(&parts, |part| {
            let triangles = part.surface.faces().as_triangles().is_some();
            let sequential = triangles && sequential_strip(&part.graph).is_some();
            (Bound::of_prepared(&part.surface, &part.graph), sequential)
        })
    });
    let (bounds, sequential): (Vec<Bound>, Vec<bool>) = found.into_iter().unzip();
    report.seconds.stripify = Some(seconds);
    for (part, bound) in bounds.iter().enumerate() {
        report.components.extend(bound.components.iter().map(|component| ComponentReport {
            part,
            triangles: component.triangles,
            strips: component.strips,
            vertices_sent: component.vertices_sent,
            proof: proof_name(component.method),
        }));
    }
    console.stage("bound", &counted(report.components.len(), "component"), Some(seconds));
    report.bound = Some(Bounds::sum(&bounds));
    report.sequential = sequential;
    Ok(())
}

fn proof_name(proof: BoundMethod) -> &'static str {
    match proof {
        BoundMethod::Leaves => "leaves",
        BoundMethod::Matching => "matching",
        BoundMethod::Subproblems => "subproblems",
        BoundMethod::Exact => "exact",
        _ => "one-strip",
    }
}

/// Returns a line on how a bound was found.
fn proof_text(proof: &str) -> &'static str {
    match proof {
        "leaves" => "faces with at most one neighbour are ends of strips",
        "matching" => "maximum matching in each block, and the bridges between blocks",
        "subproblems" => "matching, and small subproblems solved exactly",
        "exact" => "solved exactly: the bound can be reached",
        _ => "at least one strip",
    }
}

impl BoundReport {
    fn as_text(&self) -> String {
        let Some(bound) = self.bound else { return String::new() };
        let row = |name: &str, n: usize| vec![format!("  {name}"), count(n)];
        let rows = [
            vec![self.file.clone(), "lower bound".into()],
            row("strips", bound.strips),
            row("vertices sent (OpenGL)", bound.vertices_sent),
            row("with free swaps (GL)", bound.gl_cost),
            row("indices, restart", bound.indices_restart),
            row("indices, degenerate", bound.indices_degenerate),
        ];
        let proofs =
            ["exact", "subproblems", "matching", "leaves", "one-strip"].into_iter().filter_map(|proof| {
                let proven_so = || self.components.iter().filter(|component| component.proof == proof);
                let components = proven_so().count();
                let strips = counted(proven_so().map(|component| component.strips).sum(), "strip");
                let components = (components > 0).then(|| counted(components, "component"))?;
                Some(format!("  {components}, {strips}: {}\n", proof_text(proof)))
            });
        let sequential = !self.sequential.is_empty() && self.sequential.iter().all(|&sequential| sequential);
        let sequential =
            sequential.then(|| "  sequential: one strip without swaps draws the model\n".to_owned());
        table(&rows, 1..2) + &proofs.chain(sequential).collect::<String>()
    }
}
