//! Recovery of levels: how long each level model takes to move between levels, and its memory.
//!
//! The tests are those of Ribelles et al. 1999, as Belmonte et al. 2006 use them: a share of all levels is recovered, from the full mesh down to the base
//! mesh and up again, and the total time is averaged over the moves.
//!
//! ```text
//! linear         full ├──┼──┼──┼──┼──┼──┤ base     equal distances
//! exponential    full ├┼┼─┼──┼────┼─────┤ base     close to each other near the full mesh
//! ```
//! Recovery is the move alone: afterwards the model has the vertices of all its strips. Drawing is not measured.
//!
//! # References
//! Belmonte, Aguado, Sancho: *Triangle Strip Multiresolution Modelling Using Sorted Edges*, 2006, section 4.

mod chart;
mod sweep;

use std::time::Instant;

use serde::Serialize;
use tristrip::lod::ModelKind;
use tristrip_pipeline::text::count;
use tristrip_pipeline::{ModelCursor, ModelLevels, rounded};

use crate::error::Error;
use crate::text::{bytes, table};
pub use chart::draw;
pub use sweep::Sweep;

/// The shares of all levels that the tests recover, in percent.
pub const SHARES: [usize; 6] = [1, 3, 6, 10, 15, 20];

/// What a level model needs.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ModelRecovery {
    /// The name of the model.
    pub model: String,
    /// The memory of the model in bytes, shared by all cursors.
    pub memory: usize,
    /// The memory of a cursor that has drawn the full mesh.
    pub cursor_memory: usize,
    /// The seconds that building takes.
    pub build_seconds: f64,
    /// The tests.
    pub tests: Vec<RecoveryTest>,
}

/// A test of one model: a sweep over a share of all levels, down and up again.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RecoveryTest {
    /// The distances of the levels.
    pub sweep: Sweep,
    /// The share of all levels that is recovered, in percent.
    pub share: usize,
    /// The levels recovered, down and up.
    pub moves: usize,
    /// The mean time of a move in microseconds.
    pub microseconds: f64,
}

/// Measures every level model on all parts of a model, in `rounds` rounds that alternate between the models; times are medians.
///
/// # Errors
/// A part is too large for a model.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_lab::recovery::{Sweep, measure};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n", Format::Obj)?;
/// let levels = tristrip_pipeline::levels(&model, &Default::default())?;
/// let measured = measure(&levels, &[Sweep::Linear], 1)?;
/// assert!(measured.iter().all(|model| model.memory > 0 && model.tests.len() == 6));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn measure(levels: &ModelLevels, sweeps: &[Sweep], rounds: usize) -> Result<Vec<ModelRecovery>, Error> {
    let mut measured = Vec::new();
    let mut cursors = Vec::new();
    for kind in ModelKind::ALL {
        let start = Instant::now();
        let mut cursor = levels.cursor(kind)?;
        let build_seconds = rounded(start.elapsed().as_secs_f64());
        for part in cursor.of_parts_mut() {
            part.strips();
        }
        measured.push(ModelRecovery {
            model: kind.name().into(),
            memory: cursor.model_memory(),
            cursor_memory: cursor.cursor_memory(),
            build_seconds,
            tests: Vec::new(),
        });
        cursors.push(cursor);
    }
    for &sweep in sweeps {
        for share in SHARES {
            let down = sweep.levels(levels.collapse_count(), share);
            let mut times = vec![Vec::new(); cursors.len()];
            for _ in 0..rounds.max(1) {
                for (cursor, times) in cursors.iter_mut().zip(&mut times) {
                    times.push(time(cursor, &down)?);
                }
            }
            for (model, mut times) in measured.iter_mut().zip(times) {
                times.sort_unstable_by(f64::total_cmp);
                let moves = 2 * down.len();
                let mean = times[times.len() / 2] / moves.max(1) as f64;
                let microseconds = rounded(1e6 * mean);
                model.tests.push(RecoveryTest { sweep, share, moves, microseconds });
            }
        }
    }
    Ok(measured)
}

/// Returns the seconds of a sweep down from the full mesh and up again.
fn time(cursor: &mut ModelCursor<'_>, down: &[usize]) -> Result<f64, Error> {
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
    let Some(first) = measured.first() else { return String::new() };
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
    let moves: Vec<String> = first.tests.iter().take(SHARES.len()).map(|test| count(test.moves)).collect();
    let legend = format!("  microseconds per move; moves of a sweep: {}\n", moves.join(", "));
    format!("\n  Recovery of a share of all levels\n{}{legend}", table(&rows, 1..columns))
}
