//! Recovery of levels: the memory of each level model, and its time to move between levels.
//!
//! The tests are those of Ribelles et al. 1999, as used by Belmonte et al. 2006: a fraction of all
//! levels is recovered, from the full mesh down to the base mesh and up again. The total time is
//! averaged over the moves.
//!
//! ```text
//! linear         full ├──┼──┼──┼──┼──┼──┤ base     equal distances
//! exponential    full ├┼┼─┼──┼────┼─────┤ base     close to each other near the full mesh
//! ```
//! Recovery is the move alone: after it, the model has the vertices of all its strips. Drawing is
//! not measured.
//!
//! # References
//! Belmonte, Aguado, Sancho: *Triangle Strip Multiresolution Modelling Using Sorted Edges*, 2006,
//! section 4.

mod chart;
mod sweep;

use std::time::{Duration, Instant};

use serde::Serialize;
use tristrip_pipeline::text::count;
use tristrip_pipeline::{levels::ModelCursor, levels::ModelLevels, rounded};

use crate::baselines::ComparedModel;
use crate::error::Error;
pub use chart::draw;
pub use sweep::Sweep;
use tristrip_render::text::{bytes, table};

/// The fractions of all levels that the tests recover, in percent.
pub const SHARES: [usize; 6] = [1, 3, 6, 10, 15, 20];

/// A round that takes longer than this is not repeated.
const LONG_ROUND: Duration = Duration::from_secs(1);

/// The measurements of a level model.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ModelRecovery {
    /// The name of the model.
    pub model: String,
    /// Why the model cannot be built; `None` if it can. If not, nothing else is measured.
    pub error: Option<String>,
    /// The memory of the model in bytes, shared by all cursors.
    pub memory: usize,
    /// The memory of a cursor that has drawn the full mesh.
    pub cursor_memory: usize,
    /// The build time in seconds.
    pub build_seconds: f64,
    /// The tests.
    pub tests: Vec<RecoveryTest>,
}

/// A test of one model: a sweep over a fraction of all levels, down and up again.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RecoveryTest {
    /// The spacing of the levels.
    pub sweep: Sweep,
    /// The fraction of all levels that is recovered, in percent.
    pub share: usize,
    /// The number of recovered levels, down and up.
    pub moves: usize,
    /// The mean time of a move in microseconds.
    pub microseconds: f64,
}

/// Measures every level model on all parts of a model, in `rounds` rounds that alternate between
/// the models. Times are medians. After a round that takes longer than a second, no further round
/// is run.
///
/// # Errors
/// The levels are inconsistent; no input is known that causes this.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_lab::recovery::{Sweep, measure};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n", Format::Obj)?;
/// let levels = tristrip_pipeline::levels::run(&model, &Default::default(), &())?.model;
/// let measured = measure(&levels, &[Sweep::Linear], 1)?;
/// assert!(measured.iter().all(|model| model.memory > 0 && model.tests.len() == 6));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn measure(levels: &ModelLevels, sweeps: &[Sweep], rounds: usize) -> Result<Vec<ModelRecovery>, Error> {
    let (mut measured, mut cursors) = (Vec::new(), Vec::new());
    for kind in ComparedModel::ALL {
        let (of_kind, cursor) = build(levels, kind);
        measured.push(of_kind);
        cursors.push(cursor);
    }
    for &sweep in sweeps {
        for share in SHARES {
            let down = sweep.levels(levels.collapse_count(), share);
            let mut times = vec![Vec::new(); cursors.len()];
            for _ in 0..rounds.max(1) {
                let start = Instant::now();
                for (cursor, times) in cursors.iter_mut().zip(&mut times) {
                    if let Some(cursor) = cursor {
                        times.push(time(cursor, &down)?);
                    }
                }
                if start.elapsed() > LONG_ROUND {
                    break;
                }
            }
            for (model, mut times) in measured.iter_mut().zip(times) {
                times.sort_unstable_by(f64::total_cmp);
                let Some(seconds) = times.get(times.len() / 2) else { continue };
                let moves = 2 * down.len();
                let microseconds = if moves == 0 { 0.0 } else { rounded(1e6 * seconds / moves as f64) };
                model.tests.push(RecoveryTest { sweep, share, moves, microseconds });
            }
        }
    }
    Ok(measured)
}

/// Builds a level model of each part, and draws the full mesh.
fn build(levels: &ModelLevels, kind: ComparedModel) -> (ModelRecovery, Option<ModelCursor>) {
    let start = Instant::now();
    let built = levels.cursor_of(|strips, sequence| kind.build(strips, sequence));
    let mut measured = ModelRecovery {
        model: kind.name().into(),
        error: None,
        memory: 0,
        cursor_memory: 0,
        build_seconds: rounded(start.elapsed().as_secs_f64()),
        tests: Vec::new(),
    };
    let mut cursor = match built {
        Ok(cursor) => cursor,
        Err(error) => {
            measured.error = Some(error.to_string());
            return (measured, None);
        }
    };
    for part in cursor.of_parts_mut() {
        part.strips();
    }
    (measured.memory, measured.cursor_memory) = (cursor.model_memory(), cursor.cursor_memory());
    (measured, Some(cursor))
}

/// Returns the time of a sweep down from the full mesh and up again, in seconds.
fn time(cursor: &mut ModelCursor, down: &[usize]) -> Result<f64, Error> {
    let full = cursor.level();
    let start = Instant::now();
    for &level in down {
        cursor.set_level(level)?;
    }
    for &level in down.iter().rev().skip(1).chain([&full]) {
        cursor.set_level(level)?;
    }
    Ok(start.elapsed().as_secs_f64())
}

/// Formats the measurements as a text table: microseconds per move.
pub fn as_text(measured: &[ModelRecovery]) -> String {
    let mut head: Vec<String> = ["  model", "memory", "cursor", "sweep"].map(String::from).to_vec();
    head.extend(SHARES.map(|share| format!("{share} %")));
    let columns = head.len();
    let mut rows = vec![head];
    for model in measured {
        for tests in model.tests.chunk_by(|a, b| a.sweep == b.sweep) {
            let mut row = vec![format!("  {}", model.model), bytes(model.memory), bytes(model.cursor_memory)];
            row.push(tests.first().map_or("", |test| test.sweep.name()).into());
            row.extend(tests.iter().map(|test| format!("{:.2}", test.microseconds)));
            rows.push(row);
        }
    }
    let tests = measured.iter().map(|model| &model.tests[..]).find(|tests| !tests.is_empty());
    let of_sweep = tests.into_iter().flatten().take(SHARES.len());
    let moves: Vec<String> = of_sweep.map(|test| count(test.moves)).collect();
    let error =
        |model: &ModelRecovery| Some(format!("  {} not measured: {}\n", model.model, model.error.as_ref()?));
    let errors: String = measured.iter().filter_map(error).collect();
    let legend = format!("  microseconds per move; moves of a sweep: {}\n", moves.join(", "));
    format!("\n  Recovery of a share of all levels\n{}{legend}{errors}", table(&rows, 1..columns))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tristrip::Method;
    use tristrip::StripifyOptions;
    use tristrip::lod::ModelKind;
    use tristrip_io::{Format, read};
    use tristrip_pipeline::levels;

    #[test]
    fn a_model_that_refuses_a_mesh_does_not_stop_the_others() {
        // A cone of 4000 triangles, surrounded by one strip.
        let rim = 4000_u32;
        let corner = |i: u32| {
            let angle = f64::from(i) / f64::from(rim) * std::f64::consts::TAU;
            format!("v {:.6} {:.6} 0\n", angle.cos(), angle.sin())
        };
        let face = |i: u32| format!("f {} {} {}\n", i + 1, (i + 1) % rim + 1, rim + 1);
        let text: String =
            (0..rim).map(corner).chain(["v 0 0 1\n".into()]).chain((0..rim).map(face)).collect();
        let model = read(text.as_bytes(), Format::Obj).unwrap();
        let stripify = StripifyOptions::default().with_method(Method::Sequential);
        let levels =
            levels::run(&model, &levels::Options::default().with_stripify(stripify), &()).unwrap().model;
        let measured = measure(&levels, &[Sweep::Linear], 1).unwrap();
        let of = |kind: ComparedModel| measured.iter().find(|model| model.model == kind.name()).unwrap();
        for kind in [ComparedModel::Library(ModelKind::Sets), ComparedModel::Mts] {
            let refused = of(kind);
            assert!(refused.error.as_ref().unwrap().contains("successors of all vertices"), "{kind}");
            assert!(refused.tests.is_empty());
        }
        for kind in [ComparedModel::Library(ModelKind::Progressive), ComparedModel::LodStrips] {
            assert!(of(kind).error.is_none() && of(kind).tests.len() == SHARES.len(), "{kind}");
        }
        assert!(as_text(&measured).contains("sets not measured: "));
    }
}
