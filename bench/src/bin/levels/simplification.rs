//! Simplification compared with meshoptimizer: times, and the distances of both results from the
//! full mesh.

use std::hint::black_box;
use std::time::Instant;

use tristrip::Mesh;
use tristrip::simplify::{Price, Simplification, SimplifyOptions, simplify_triangles};
use tristrip_bench::failure::Failure;
use tristrip_bench::measure::median;
use tristrip_bench::memory::extra_bytes;
use tristrip_bench::text::Table;
use tristrip_pipeline::{ChangedSurface, surface_change};

/// The number of sample points in each direction for the distance between two surfaces.
pub(crate) const POINTS: usize = 40_000;
/// The goal for both programs.
#[derive(Clone, Copy)]
pub(crate) struct SimplificationGoal {
    /// The reduction factor: one in `share` triangles is kept.
    pub(crate) share: usize,
    /// Whether the topology may change.
    pub(crate) permissive: bool,
    /// The cost of our collapses.
    pub(crate) price: Price,
}

impl SimplificationGoal {
    pub(crate) fn with_share(self, share: usize) -> Self {
        Self { share, ..self }
    }
}

/// The metrics of a model that both programs simplified to the same number of triangles.
pub(crate) struct ComparedSimplification {
    pub(crate) model: String,
    pub(crate) before: usize,
    /// The number of triangles at which our program and meshoptimizer stop.
    pub(crate) after: [usize; 2],
    /// Times, in seconds.
    pub(crate) times: [f64; 2],
    /// The root mean square and maximum distances from the full mesh, as fractions of the diagonal.
    pub(crate) rms: [f64; 2],
    pub(crate) largest: [f64; 2],
    pub(crate) bytes_per_triangle: f64,
}

impl ComparedSimplification {
    /// Checks whether both results have about the same number of triangles.
    pub(crate) fn is_alike(&self) -> bool {
        self.after[0].abs_diff(self.after[1]) <= 2 + self.after[0] / 100
    }
}

/// Simplifies with both programs in alternation.
pub(crate) fn measure(
    name: &str,
    mesh: &Mesh,
    goal: &SimplificationGoal,
    rounds: usize,
) -> Result<ComparedSimplification, Failure> {
    let triangles = mesh.faces().as_triangles().ok_or("a model of triangles was expected")?;
    let target = triangles.len() / 3 / goal.share;
    let bytes: Vec<u8> = mesh.positions().iter().flatten().flat_map(|x| x.to_ne_bytes()).collect();
    let adapter = meshopt::VertexDataAdapter::new(&bytes, 12, 0)?;
    let peer = || {
        let options = if goal.permissive {
            meshopt::SimplifyOptions::Permissive
        } else {
            meshopt::SimplifyOptions::empty()
        };
        meshopt::simplify(black_box(triangles), &adapter, 3 * target, f32::MAX, options, None)
    };
    let mut theirs = peer();
    // Our program stops at the count of meshoptimizer. With other counts, the distances would not
    // be comparable.
    let target = theirs.len() / 3;
    let options = SimplifyOptions::default().with_triangles(target).with_permissive(goal.permissive);
    let options = options.with_price(goal.price);
    let (mut times, mut ours) = ([Vec::new(), Vec::new()], None);
    for _ in 0..rounds {
        let input = triangles.to_vec();
        let start = Instant::now();
        let done = simplify_triangles(mesh, black_box(input), &options)?;
        times[0].push(start.elapsed().as_secs_f64());
        ours = Some(done);
        let start = Instant::now();
        theirs = peer();
        times[1].push(start.elapsed().as_secs_f64());
    }
    let input = triangles.to_vec();
    let (result, extra) = extra_bytes(|| simplify_triangles(mesh, input, &options));
    result?;
    let Simplification { sequence, .. } = ours.ok_or("no round was requested")?;
    sequence.check()?;
    let drawn = sequence.drawn(0)?.concat();
    let diagonal = diagonal(mesh);
    let distances = |indices: &[u32]| {
        let surface = ChangedSurface { mesh, before: triangles, after: indices, texels: None };
        let change = surface_change(&[surface], POINTS)?;
        Ok::<_, Failure>([change.rms / diagonal, change.largest / diagonal])
    };
    let (our_distances, their_distances) = (distances(&drawn)?, distances(&theirs)?);
    Ok(ComparedSimplification {
        model: name.into(),
        before: triangles.len() / 3,
        after: [drawn.len() / 3, theirs.len() / 3],
        times: times.map(median),
        rms: [our_distances[0], their_distances[0]],
        largest: [our_distances[1], their_distances[1]],
        bytes_per_triangle: extra
            .map_or(f64::NAN, |extra| extra as f64 / (triangles.len() / 3).max(1) as f64),
    })
}

/// Returns the diagonal of the bounding box of the drawn vertices.
fn diagonal(mesh: &Mesh) -> f64 {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for &v in mesh.faces().iter().flatten() {
        for (k, &x) in mesh.positions()[v as usize].iter().enumerate() {
            (low[k], high[k]) = (low[k].min(x.into()), high[k].max(x.into()));
        }
    }
    (0..3).map(|k| (high[k] - low[k]).max(0.0).powi(2)).sum::<f64>().sqrt()
}

/// Returns a sentence about the metrics of all models.
pub(crate) fn summary(price: Price, figures: &[ComparedSimplification]) -> String {
    let alike: Vec<_> = figures.iter().filter(|figures| figures.is_alike()).collect();
    let ratio = |[ours, theirs]: [f64; 2]| ours / theirs;
    let mean = |of: fn(&ComparedSimplification) -> [f64; 2]| {
        // If both results are the full mesh, there is no ratio.
        let logarithms: Vec<f64> =
            alike.iter().map(|f| ratio(of(f)).ln()).filter(|ratio| ratio.is_finite()).collect();
        (logarithms.iter().sum::<f64>() / logarithms.len() as f64).exp()
    };
    let times = median(alike.iter().map(|figures| ratio(figures.times)).collect());
    let large = alike.iter().filter(|figures| figures.before > 5000);
    let slowest = large.map(|figures| ratio(figures.times)).fold(0.0, f64::max);
    let nearer = alike.iter().filter(|figures| figures.largest[0] <= figures.largest[1]).count();
    format!(
        "By {price}, {} models with as many triangles, relative to meshoptimizer: RMS {:.3} and largest {:.3} (geometric means; the largest is at most \
         meshoptimizer's on {nearer}); time {times:.2} (median) and {slowest:.2} (most, above 5000 triangles).",
        alike.len(),
        mean(|figures| figures.rms),
        mean(|figures| figures.largest),
    )
}

pub(crate) fn simplification_table(simplified: &[ComparedSimplification]) -> Table {
    let heads = [
        "model",
        "triangles",
        "ours",
        "meshoptimizer",
        "ms",
        "meshoptimizer ms",
        "ratio",
        "RMS %",
        "meshoptimizer RMS %",
        "ratio",
        "largest %",
        "meshoptimizer largest %",
        "ratio",
        "bytes/T",
    ];
    let mut table = Table::new(1, &heads);
    for s in simplified {
        let same = s.is_alike();
        let ratio = |[ours, theirs]: [f64; 2]| {
            if theirs > 0.0 { format!("{:.2}", ours / theirs) } else { "–".into() }
        };
        table.push(vec![
            s.model.clone(),
            s.before.to_string(),
            s.after[0].to_string(),
            s.after[1].to_string(),
            format!("{:.1}", 1e3 * s.times[0]),
            format!("{:.1}", 1e3 * s.times[1]),
            if same { ratio(s.times) } else { "–".into() },
            format!("{:.4}", 100.0 * s.rms[0]),
            format!("{:.4}", 100.0 * s.rms[1]),
            if same { ratio(s.rms) } else { "–".into() },
            format!("{:.3}", 100.0 * s.largest[0]),
            format!("{:.3}", 100.0 * s.largest[1]),
            if same { ratio(s.largest) } else { "–".into() },
            format!("{:.0}", s.bytes_per_triangle),
        ]);
    }
    table
}
