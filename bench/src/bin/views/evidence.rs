//! Checks views from random cameras: whether display strips draw the correct triangles, and whether
//! the surface folds over.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use tristrip::lod::{Camera, SkipStrips, SkipView, ViewCriteria};
use tristrip::random::Random;
use tristrip::simplify::{MergeOrder, SimplifyOptions, merge_tree};
use tristrip::{CollapseSequence, Mesh, Method, StripifyOptions, stripify};
use tristrip_bench::failure::Failure;
use tristrip_bench::meshoptimizer::adapter;
use tristrip_bench::models::{Source, load};
use tristrip_bench::targets::Target;
use tristrip_bench::text::Table;

use crate::frames::{cross, dot, sub};
use crate::proof::{from_lowest, sorted};

/// The number of views per model.
pub(super) const VIEWS: usize = 100;
/// The maximum number of models, in order of their names.
const MODELS: usize = 20;
/// The range of model sizes, in triangles. Larger models would take minutes, smaller ones have few
/// views.
const SIZES: std::ops::Range<usize> = 2000..150_000;
/// An edge is folded if the cosine of the angle between its normals is below this value.
const FOLDED: f64 = -0.9;

/// The results of a model.
pub(super) struct ViewFigures {
    name: String,
    triangles: usize,
    exact: usize,
    /// The number of triangles in all views that no level of the merge tree has.
    foreign: usize,
    /// Triangles that face away from the full mesh: of the full mesh, and of the worst view.
    turned: [usize; 2],
    /// Folded edges per thousand: of the full mesh, of the worst level of as many triangles, of all
    /// views, and of the worst view.
    folded: [f64; 4],
}

/// Checks models from random cameras.
pub(super) fn look_all(sources: &[Source]) -> Result<Vec<ViewFigures>, Failure> {
    let mut seen = Vec::new();
    for source in sources {
        let mesh = load(source)?.triangles;
        if SIZES.contains(&mesh.faces().face_count()) && seen.len() < MODELS {
            seen.push(look(&source.name, &mesh)?);
        }
    }
    Ok(seen)
}

fn look(name: &str, mesh: &Mesh) -> Result<ViewFigures, Failure> {
    let strips = stripify(mesh, &StripifyOptions::default().with_method(Method::Sequential))?;
    let options = SimplifyOptions::default();
    let sequence = merge_tree(mesh, strips.to_list(), MergeOrder::default(), &options)?.sequence;
    let model = Arc::new(SkipStrips::new(&strips, &sequence, mesh.positions())?);
    let full = sequence.drawn(sequence.len())?;
    let mut figures = ViewFigures {
        name: name.into(),
        triangles: full.len(),
        exact: 0,
        foreign: 0,
        turned: [0; 2],
        folded: [folded(mesh, &full), 0.0, 0.0, 0.0],
    };
    let known = triangles_of_levels(&sequence)?;
    let surface = FullSurface::of(mesh, &full)?;
    figures.turned[0] = surface.turned(mesh, &full, &surface.normals);
    let (mut random, mut view) = (Random::new(0), model.view());
    for _ in 0..VIEWS {
        let (camera, criteria) = random_view(&mut random, mesh)?;
        view.update(&camera, &criteria)?;
        let triangles = view.renamed_triangles();
        figures.exact += usize::from(is_exact(&view, &triangles));
        figures.foreign +=
            triangles.iter().filter(|&&triangle| !known.contains(&from_lowest(triangle))).count();
        let of_corners = surface.normals_of_corners(&sequence, &view)?;
        figures.turned[1] = figures.turned[1].max(surface.turned(mesh, &triangles, &of_corners));
        let of_view = folded(mesh, &triangles);
        let level = sequence.drawn(sequence.level_of_triangles(triangles.len()))?;
        figures.folded[1] = figures.folded[1].max(folded(mesh, &level));
        figures.folded[2] += of_view / VIEWS as f64;
        figures.folded[3] = figures.folded[3].max(of_view);
    }
    Ok(figures)
}

/// Returns every triangle that is drawn at some level of a sequence.
fn triangles_of_levels(sequence: &CollapseSequence) -> Result<HashSet<[u32; 3]>, Failure> {
    let mut drawn = sequence.drawn(sequence.len())?;
    // The indices of the triangles at each vertex. Entries are never removed, but degenerate
    // triangles are not drawn.
    let mut around = HashMap::<u32, Vec<usize>>::new();
    for (number, triangle) in drawn.iter().enumerate() {
        triangle.iter().for_each(|&v| around.entry(v).or_default().push(number));
    }
    let mut known: HashSet<[u32; 3]> = drawn.iter().map(|&triangle| from_lowest(triangle)).collect();
    for collapse in sequence.iter() {
        let mut changed = Vec::new();
        for rename in collapse.renames {
            let moved = around.remove(&rename.removed).unwrap_or_default();
            for &number in &moved {
                drawn[number].iter_mut().filter(|v| **v == rename.removed).for_each(|v| *v = rename.kept);
            }
            changed.extend_from_slice(&moved);
            let kept = around.entry(rename.kept).or_default();
            kept.extend(moved);
            kept.retain(|&number| !is_degenerate(drawn[number]));
        }
        let changed = changed.into_iter().map(|number| drawn[number]);
        known.extend(changed.filter(|&triangle| !is_degenerate(triangle)).map(from_lowest));
    }
    Ok(known)
}

/// The full mesh by position: vertices on a seam are one point.
struct FullSurface {
    /// For each vertex, the first vertex at its position.
    first: Vec<u32>,
    /// For each of these, the sum of the area-weighted normals of its triangles.
    normals: Vec<[f64; 3]>,
}

impl FullSurface {
    fn of(mesh: &Mesh, triangles: &[[u32; 3]]) -> Result<Self, Failure> {
        let first = meshopt::generate_position_remap(&adapter(mesh.positions())?);
        let mut normals = vec![[0.0; 3]; first.len()];
        for triangle in triangles {
            let normal = normal_of(mesh, *triangle);
            triangle.iter().for_each(|&v| add(&mut normals[first[v as usize] as usize], normal));
        }
        Ok(Self { first, normals })
    }

    /// Returns, for each point that a view draws, the sum of the normals of all points that
    /// collapsed to it.
    fn normals_of_corners(
        &self,
        sequence: &CollapseSequence,
        view: &SkipView,
    ) -> Result<Vec<[f64; 3]>, Failure> {
        let mut sums = self.normals.clone();
        for collapse in view.collapses_done() {
            let renames = sequence.collapse(sequence.len() - 1 - collapse)?.renames;
            let Some(rename) = renames.first() else { continue };
            // A removed point represents nothing afterwards.
            let [removed, kept] = [rename.removed, rename.kept].map(|v| self.first[v as usize] as usize);
            let sum = sums[removed];
            add(&mut sums[kept], sum);
        }
        Ok(sums)
    }

    /// Counts the triangles that face away from the sum of the normals at one of their corners.
    fn turned(&self, mesh: &Mesh, triangles: &[[u32; 3]], sums: &[[f64; 3]]) -> usize {
        let faces_away = |triangle: &&[u32; 3]| {
            let normal = normal_of(mesh, **triangle);
            triangle.iter().any(|&v| dot(normal, sums[self.first[v as usize] as usize]) < 0.0)
        };
        triangles.iter().filter(faces_away).count()
    }
}

fn normal_of(mesh: &Mesh, triangle: [u32; 3]) -> [f64; 3] {
    let [a, b, c] = triangle.map(|v| mesh.positions()[v as usize].map(f64::from));
    cross(sub(b, a), sub(c, a))
}

fn add(sum: &mut [f64; 3], more: [f64; 3]) {
    (0..3).for_each(|k| sum[k] += more[k]);
}

fn is_degenerate([a, b, c]: [u32; 3]) -> bool {
    a == b || b == c || c == a
}

fn is_exact(view: &SkipView, triangles: &[[u32; 3]]) -> bool {
    view.triangle_count() == triangles.len()
        && sorted(view.display_strips().triangles()) == sorted(triangles.iter().copied())
}

/// Returns a random camera within two diagonals of the bounding box that looks at a point of the
/// box, and the criteria of its view.
fn random_view(random: &mut Random, mesh: &Mesh) -> Result<(Camera, ViewCriteria), Failure> {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for position in mesh.positions() {
        low = [0, 1, 2].map(|k| low[k].min(position[k]));
        high = [0, 1, 2].map(|k| high[k].max(position[k]));
    }
    let size = [0, 1, 2].map(|k| high[k] - low[k]);
    let diagonal = size.iter().map(|x| x * x).sum::<f32>().sqrt();
    let mut share = || random.below(1001) as f32 / 1000.0;
    let look_at = [0, 1, 2].map(|k| low[k] + share() * size[k]);
    let eye = [0, 1, 2].map(|k| look_at[k] + (share() - 0.5) * 2.0 * diagonal);
    let criteria = ViewCriteria::default().with_pixels([0.1, 0.3, 1.0, 3.0, 10.0][random.below(5)]);
    let criteria = criteria.with_frustum(random.coin()).with_silhouettes(random.coin());
    Ok((Camera::new(eye, look_at)?, criteria))
}

/// Returns the number of folded edges per thousand edges of two triangles.
fn folded(mesh: &Mesh, triangles: &[[u32; 3]]) -> f64 {
    let mut normals = HashMap::new();
    let (mut edges, mut folded) = (0_usize, 0_usize);
    for &[a, b, c] in triangles {
        let Some(normal) = unit(normal_of(mesh, [a, b, c])) else { continue };
        for (from, to) in [(a, b), (b, c), (c, a)] {
            if let Some(other) = normals.remove(&(to, from)) {
                edges += 1;
                folded += usize::from(dot(normal, other) < FOLDED);
            } else {
                normals.insert((from, to), normal);
            }
        }
    }
    1000.0 * folded as f64 / edges.max(1) as f64
}

fn unit(normal: [f64; 3]) -> Option<[f64; 3]> {
    let length = dot(normal, normal).sqrt();
    (length > 0.0).then(|| normal.map(|x| x / length))
}

/// Compares with the targets: every view is exact, and no view folds over.
pub(super) fn compare(seen: &[ViewFigures]) -> Vec<Target> {
    let all = VIEWS * seen.len();
    let exact: usize = seen.iter().map(|model| model.exact).sum();
    let what = format!("exact of {all} random views of {} models", seen.len());
    if seen.is_empty() {
        return Vec::new();
    }
    let foreign: usize = seen.iter().map(|model| model.foreign).sum();
    let folding = seen.iter().filter(|model| model.turned[1] > model.turned[0]).count();
    vec![
        Target::at_least(what, all as f64, exact as f64, 0),
        Target::at_most("triangles of these views that no level has".into(), 0.0, foreign as f64, 0),
        Target::at_most(
            "models with more turned triangles in a view than in the full mesh".into(),
            0.0,
            folding as f64,
            0,
        ),
    ]
}

/// Returns a row per model.
pub(super) fn table(seen: &[ViewFigures]) -> Table {
    let heads = [
        "model",
        "triangles",
        "exact views",
        "of no level",
        "turned, full",
        "turned, worst view",
        "folded, full",
        "worst level",
        "views",
        "worst view",
    ];
    let mut table = Table::new(1, &heads);
    for model in seen {
        let mut row = vec![
            model.name.clone(),
            model.triangles.to_string(),
            model.exact.to_string(),
            model.foreign.to_string(),
        ];
        row.extend(model.turned.map(|turned| turned.to_string()));
        row.extend(model.folded.map(|folded| format!("{folded:.2}")));
        table.push(row);
    }
    table
}
