//! Views from anywhere: whether display strips draw what they are to draw, and whether the surface folds over.

use std::collections::HashMap;
use std::sync::Arc;

use tristrip::lod::{Camera, SkipStrips, SkipView, ViewCriteria};
use tristrip::random::Random;
use tristrip::simplify::{MergeOrder, SimplifyOptions, merge_tree};
use tristrip::{Mesh, Method, StripifyOptions, stripify};
use tristrip_bench::failure::Failure;
use tristrip_bench::models::{Source, load};
use tristrip_bench::targets::Target;
use tristrip_bench::text::Table;

use crate::frames::{cross, dot, sub};
use crate::proof::sorted;

/// The views of each model.
pub(super) const VIEWS: usize = 100;
/// The most models, in the order of their names.
const MODELS: usize = 20;
/// The sizes of models that are looked at, in triangles: large ones would take minutes, small ones have few views.
const SIZES: std::ops::Range<usize> = 2000..150_000;
/// The cosine of the angle between normals below which an edge is folded.
const FOLDED: f64 = -0.9;

/// What was seen of a model.
pub(super) struct ViewFigures {
    name: String,
    triangles: usize,
    exact: usize,
    /// Folded edges per thousand: of the full mesh, of the worst level of as many triangles, of all views, and of the worst view.
    folded: [f64; 4],
}

/// Looks at models from random cameras.
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
        folded: [folded(mesh, &full), 0.0, 0.0, 0.0],
    };
    let (mut random, mut view) = (Random::new(0), model.view());
    for _ in 0..VIEWS {
        let (camera, criteria) = random_view(&mut random, mesh)?;
        view.update(&camera, &criteria)?;
        let triangles = view.renamed_triangles();
        figures.exact += usize::from(is_exact(&view, &triangles));
        let of_view = folded(mesh, &triangles);
        let level = sequence.drawn(sequence.level_of_triangles(triangles.len()))?;
        figures.folded[1] = figures.folded[1].max(folded(mesh, &level));
        figures.folded[2] += of_view / VIEWS as f64;
        figures.folded[3] = figures.folded[3].max(of_view);
    }
    Ok(figures)
}

fn is_exact(view: &SkipView, triangles: &[[u32; 3]]) -> bool {
    view.triangle_count() == triangles.len()
        && sorted(view.display_strips().triangles()) == sorted(triangles.iter().copied())
}

/// Returns a camera within two diagonals of the bounding box that looks at a point of it, and the criteria of its view.
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
    let criteria = ViewCriteria::new([0.1, 0.3, 1.0, 3.0, 10.0][random.below(5)])?;
    let criteria = criteria.with_frustum(random.coin()).with_silhouettes(random.coin());
    Ok((Camera::new(eye, look_at)?, criteria))
}

/// Returns the folded edges of triangles, per thousand edges of two triangles.
fn folded(mesh: &Mesh, triangles: &[[u32; 3]]) -> f64 {
    let at = |v: u32| mesh.positions()[v as usize].map(f64::from);
    let mut normals = HashMap::new();
    let (mut edges, mut folded) = (0_usize, 0_usize);
    for &[a, b, c] in triangles {
        let Some(normal) = unit_normal([a, b, c].map(at)) else { continue };
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

fn unit_normal([a, b, c]: [[f64; 3]; 3]) -> Option<[f64; 3]> {
    let normal = cross(sub(b, a), sub(c, a));
    let length = dot(normal, normal).sqrt();
    (length > 0.0).then(|| normal.map(|x| x / length))
}

/// Compares with the target: every view is exact.
pub(super) fn compare(seen: &[ViewFigures]) -> Vec<Target> {
    let all = VIEWS * seen.len();
    let exact: usize = seen.iter().map(|model| model.exact).sum();
    let what = format!("exact of {all} random views of {} models", seen.len());
    if seen.is_empty() { Vec::new() } else { vec![Target::at_least(what, all as f64, exact as f64, 0)] }
}

/// Returns a row per model.
pub(super) fn table(seen: &[ViewFigures]) -> Table {
    let heads = ["model", "triangles", "exact views", "folded, full", "worst level", "views", "worst view"];
    let mut table = Table::new(1, &heads);
    for model in seen {
        let mut row = vec![model.name.clone(), model.triangles.to_string(), model.exact.to_string()];
        row.extend(model.folded.map(|folded| format!("{folded:.2}")));
        table.push(row);
    }
    table
}
