//! What is said of one input: as JSON, whose keys are kept from version to version (FORMAT.md), and as text.

use serde::Serialize;
use tristrip::strip::Buffer;

use crate::bound::Reached;
use crate::figures::{Figures, MeshFigures};
use crate::lod::rows::{FilterTotal, LevelRow};
use crate::method::{Chosen, MethodReport};
use crate::pareto::Point;
use crate::reorder::GroupReport;
use crate::search::Stopped;
use crate::task::LodTask;
use crate::text::{count, counted, table};

/// Times in seconds; `null` for a stage that did not run.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub(crate) struct Seconds {
    pub(crate) load: Option<f64>,
    pub(crate) dual: Option<f64>,
    pub(crate) stripify: Option<f64>,
    pub(crate) verify: Option<f64>,
    pub(crate) write: Option<f64>,
}

/// What `tristrip strip` says of one input.
#[derive(Debug, Serialize)]
pub(crate) struct StripReport {
    pub(crate) file: String,
    #[serde(flatten)]
    pub(crate) method: MethodReport,
    /// The methods that were taken, and for how many parts; `null` where none was reached.
    pub(crate) chosen: Option<Chosen>,
    /// `null` where the proof was not asked for, or not reached.
    pub(crate) proven: Option<bool>,
    pub(crate) seconds: Seconds,
    #[serde(flatten)]
    pub(crate) figures: Option<Figures>,
    /// Why the search ended before its time, if it did.
    pub(crate) stopped: Option<Stopped>,
    /// How far the result of a search is from its bound; `null` for the methods that do not search.
    pub(crate) bound: Option<Reached>,
    pub(crate) mesh: Option<MeshFigures>,
    pub(crate) parts: Option<usize>,
    pub(crate) notes: Vec<String>,
    pub(crate) output: Option<String>,
    pub(crate) layout: Option<&'static str>,
    /// Where each vertex went; `null` unless that was asked for.
    pub(crate) vertex_order: Option<Vec<GroupReport>>,
    /// What every method makes of the model; `null` unless that was asked for.
    pub(crate) pareto: Option<Vec<Point>>,
    pub(crate) error: Option<String>,
}

/// What `tristrip compare` says of one input.
#[derive(Debug, Serialize)]
pub(crate) struct CompareReport {
    pub(crate) file: String,
    pub(crate) seconds: Seconds,
    pub(crate) mesh: Option<MeshFigures>,
    pub(crate) parts: Option<usize>,
    pub(crate) notes: Vec<String>,
    pub(crate) methods: Vec<MethodRow>,
    pub(crate) error: Option<String>,
}

/// One method in a comparison.
#[derive(Debug, Serialize)]
pub(crate) struct MethodRow {
    #[serde(flatten)]
    pub(crate) method: MethodReport,
    pub(crate) chosen: Option<Chosen>,
    pub(crate) proven: bool,
    pub(crate) seconds: Seconds,
    #[serde(flatten)]
    pub(crate) figures: Option<Figures>,
    pub(crate) stopped: Option<Stopped>,
    pub(crate) error: Option<String>,
}

/// What `tristrip verify` says.
#[derive(Debug, Serialize)]
pub(crate) struct VerifyReport {
    pub(crate) source: String,
    pub(crate) result: String,
    /// `null` where a file could not be read.
    pub(crate) proven: Option<bool>,
    pub(crate) seconds: Seconds,
    /// Faces of the source.
    pub(crate) faces: Option<usize>,
    /// Triangles of the result.
    pub(crate) triangles: Option<usize>,
    pub(crate) difference: Option<DifferenceReport>,
    pub(crate) notes: Vec<String>,
    pub(crate) error: Option<String>,
}

/// Where a result differs from its source.
#[derive(Debug, Default, Serialize)]
pub(crate) struct DifferenceReport {
    /// `triangles`, `outside`, `count` or `boundary`.
    pub(crate) kind: &'static str,
    pub(crate) missing: Option<usize>,
    pub(crate) extra: Option<usize>,
    pub(crate) flipped: Option<usize>,
    /// The face of the source, counted from 0 over all parts.
    pub(crate) face: Option<u32>,
    /// The positions of the first place at fault.
    pub(crate) first: Vec<[f32; 3]>,
}

/// What `tristrip convert` says of one input.
#[derive(Debug, Serialize)]
pub(crate) struct ConvertReport {
    pub(crate) file: String,
    pub(crate) proven: Option<bool>,
    pub(crate) seconds: Seconds,
    pub(crate) faces: Option<usize>,
    pub(crate) triangles: Option<usize>,
    pub(crate) strips: Option<usize>,
    pub(crate) parts: Option<usize>,
    pub(crate) notes: Vec<String>,
    pub(crate) output: Option<String>,
    pub(crate) layout: Option<&'static str>,
    pub(crate) error: Option<String>,
}

/// Times of `tristrip simplify` in seconds; `null` for a stage that did not run.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub(crate) struct SimplifySeconds {
    pub(crate) load: Option<f64>,
    pub(crate) dual: Option<f64>,
    pub(crate) simplify: Option<f64>,
    pub(crate) verify: Option<f64>,
    pub(crate) write: Option<f64>,
}

/// What `tristrip simplify` says of one input.
#[derive(Debug, Default, Serialize)]
pub(crate) struct SimplifyReport {
    pub(crate) file: String,
    pub(crate) proven: Option<bool>,
    pub(crate) seconds: SimplifySeconds,
    /// What was asked for; `null` for no limit.
    pub(crate) target_triangles: Option<usize>,
    /// In mesh units.
    pub(crate) target_error: Option<f32>,
    /// Whether each part has as few triangles as it should have.
    pub(crate) reached: Option<bool>,
    pub(crate) triangles_before: Option<usize>,
    pub(crate) triangles_after: Option<usize>,
    /// Vertices in use.
    pub(crate) vertices_before: Option<usize>,
    pub(crate) vertices_after: Option<usize>,
    pub(crate) collapses: Option<usize>,
    /// The greatest error of a collapse, in mesh units.
    pub(crate) surface_error: Option<f32>,
    pub(crate) surface_error_percent: Option<f64>,
    /// Of the model's bounding box, in mesh units.
    pub(crate) diagonal: Option<f64>,
    pub(crate) locked_vertices: Option<usize>,
    pub(crate) parts: Option<usize>,
    pub(crate) notes: Vec<String>,
    pub(crate) output: Option<String>,
    pub(crate) error: Option<String>,
}

/// Times of `tristrip lod` in seconds; `null` for a stage that did not run.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub(crate) struct LodSeconds {
    pub(crate) load: Option<f64>,
    pub(crate) dual: Option<f64>,
    pub(crate) stripify: Option<f64>,
    pub(crate) simplify: Option<f64>,
    pub(crate) filter: Option<f64>,
    pub(crate) verify: Option<f64>,
    pub(crate) write: Option<f64>,
}

/// What `tristrip lod` says of one input.
#[derive(Debug, Serialize)]
pub(crate) struct LodReport {
    pub(crate) file: String,
    #[serde(flatten)]
    pub(crate) method: MethodReport,
    pub(crate) chosen: Option<Chosen>,
    pub(crate) model: String,
    pub(crate) filter: String,
    /// Of the filter that searches.
    pub(crate) filter_effort: u8,
    pub(crate) proven: Option<bool>,
    pub(crate) seconds: LodSeconds,
    /// The collapses, which is the highest level.
    pub(crate) levels: Option<usize>,
    pub(crate) triangles_base: Option<usize>,
    pub(crate) triangles_full: Option<usize>,
    /// The level that was drawn.
    pub(crate) level: Option<usize>,
    pub(crate) surface_error: Option<f32>,
    pub(crate) surface_error_percent: Option<f64>,
    pub(crate) diagonal: Option<f64>,
    /// Of the display strips.
    #[serde(flatten)]
    pub(crate) figures: Option<Figures>,
    pub(crate) table: Option<Vec<LevelRow>>,
    /// Sums over all levels.
    pub(crate) compare: Option<Vec<FilterTotal>>,
    /// What the picture shows.
    #[serde(skip)]
    pub(crate) rows: Vec<LevelRow>,
    pub(crate) plot: Option<String>,
    pub(crate) stopped: Option<Stopped>,
    pub(crate) parts: Option<usize>,
    pub(crate) notes: Vec<String>,
    pub(crate) output: Option<String>,
    pub(crate) layout: Option<&'static str>,
    pub(crate) error: Option<String>,
}

impl LodReport {
    /// Begins the report of an input.
    pub(crate) fn new(file: String, method: MethodReport, task: &LodTask) -> Self {
        Self {
            file,
            method,
            chosen: None,
            model: task.model.name(),
            filter: task.filter.name(),
            filter_effort: task.filter_effort.level(),
            proven: None,
            seconds: LodSeconds::default(),
            levels: None,
            triangles_base: None,
            triangles_full: None,
            level: None,
            surface_error: None,
            surface_error_percent: None,
            diagonal: None,
            figures: None,
            table: None,
            compare: None,
            rows: Vec::new(),
            plot: None,
            stopped: None,
            parts: None,
            notes: Vec::new(),
            output: None,
            layout: None,
            error: None,
        }
    }
}

impl Figures {
    /// Says what strips cost, next to the plain triangle list.
    pub(crate) fn summary(&self) -> String {
        let per_triangle = |n: usize| n as f64 / self.triangles.max(1) as f64;
        let row =
            |name: &str, n: usize, remark: String| vec![format!("  {name}"), count(n), String::new(), remark];
        let ratio = |name: &str, n: usize, remark: String| {
            vec![format!("  {name}"), count(n), format!("{:.3}", per_triangle(n)), remark]
        };
        let list = 3 * self.triangles;
        let of_list = |n: usize| format!("{:.1} % of the list", 100.0 * n as f64 / list.max(1) as f64);
        let triangles_each = self.triangles as f64 / self.strips.max(1) as f64;
        let mut rows = vec![
            vec![String::new(), "total".into(), "a triangle".into(), String::new()],
            row("triangles", self.triangles, String::new()),
            ratio("indices, plain list", list, String::new()),
            ratio("indices, restart", self.indices_restart, of_list(self.indices_restart)),
            ratio("indices, degenerate", self.indices_degenerate, of_list(self.indices_degenerate)),
            ratio("vertices sent (OpenGL)", self.vertices_sent, String::new()),
            ratio("with free swaps (GL)", self.gl_cost, String::new()),
            row("strips", self.strips, format!("{triangles_each:.1} triangles each")),
            row("isolated triangles", self.isolated, String::new()),
            row("swaps", self.swaps, String::new()),
            ratio("misses, FIFO 16 (ACMR)", self.misses_fifo_16, format!("ATVR {:.3}", self.atvr_fifo_16)),
            ratio("misses, FIFO 32 (ACMR)", self.misses_fifo_32, format!("ATVR {:.3}", self.atvr_fifo_32)),
        ];
        if let (Some((buffer, misses)), Some(atvr)) = (self.respected, self.atvr)
            && ![Buffer::fifo(16), Buffer::fifo(32)].contains(&buffer)
        {
            rows.push(ratio(&format!("misses, {buffer} (ACMR)"), misses, format!("ATVR {atvr:.3}")));
        }
        table(&rows, 1..3)
    }
}

impl MeshFigures {
    /// Says in one line what a mesh is like.
    pub(crate) fn line(&self, parts: usize) -> String {
        let mut words = Vec::new();
        if parts != 1 {
            words.push(counted(parts, "part"));
        }
        words.push(counted(self.components, "component"));
        words.push(match self.boundary_edges {
            0 => "closed".into(),
            n => counted(n, "boundary edge"),
        });
        if self.non_manifold_edges > 0 {
            words.push(counted(self.non_manifold_edges, "non-manifold edge"));
        }
        if self.inconsistent_edges > 0 {
            words.push(counted(self.inconsistent_edges, "inconsistently wound edge"));
        }
        words.join(", ")
    }

    /// Says what was left out, changed or is odd, each in one line.
    pub(crate) fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        let mut say = |n: usize, noun: &str, rest: &str| {
            if n > 0 {
                remarks.push(format!("{}{rest}", counted(n, noun)));
            }
        };
        say(self.degenerate_faces, "degenerate face", " left out: they draw nothing");
        say(self.duplicate_faces, "duplicate face", ", drawn as often as they come");
        say(self.cut_polygons, "polygon", " not convex, cut into triangles beforehand");
        say(self.fanned_polygons, "polygon", " could not be cut by ears and became fans");
        say(self.welded_vertices, "vertex", " welded to others with the same bits");
        say(self.unreferenced_vertices, "vertex", " used by no face");
        remarks
    }
}
