//! Recovery of levels as in Belmonte et al. 2006, tables 2 and 3: the memory of the models, and the
//! entries that their moves read.
//!
//! The paper prints times, which pages do not contain. The number of list entries that a move reads
//! (`Sets::accesses`) replaces its time, as the mean over the moves of a sweep. The published times
//! include drawing; this number does not.
//!
//! Metrics:
//! - `mb_…`: the memory of a model in 2²⁰ bytes;
//! - `accesses_MODEL_SWEEP_SHARE`, for `sets` and `mts`: entries per move, at a recovered share of
//!   all levels in percent;
//! - `ratio_SWEEP_SHARE`: entries per move of SETS relative to MTS; `ratio_mb`: memory of SETS
//!   relative to MTS;
//! - `fall_MODEL_SWEEP`: entries per move at 20 % of the levels, in percent of those at 1 %;
//! - `exponential_MODEL_SHARE`: entries per move of the exponential sweep, in percent of the linear
//!   sweep;
//! - `faster`: by how many percent MTS reads more than SETS, in the best case;
//! - `triangles_SWEEP_SHARE`: triangles per recovered level;
//! - `drawn_SHARE`: triangles per recovered level of the exponential sweep, in percent of the
//!   linear sweep.

use std::collections::BTreeMap;

use tristrip::lod::Sets;
use tristrip::{Error as CoreError, Strips};
use tristrip_pipeline::{PreparedModel, Ratio, levels, levels::ModelLevels};

use crate::baselines::{ComparedModel, Mts};
use crate::error::Error;
use crate::recovery::{SHARES, Sweep};

/// The published megabytes have 2²⁰ bytes.
const MEGABYTE: f64 = 1_048_576.0;

/// Measures the recovery of all levels, drawn with the strips of the full mesh.
///
/// # Errors
/// A model cannot be built.
pub(super) fn measure(
    prepared: &PreparedModel<'_>,
    strips: &[Strips],
    options: levels::Options,
) -> Result<BTreeMap<String, f64>, Error> {
    let levels = ModelLevels::from_strips(prepared, strips, &options.with_base(Ratio::ZERO), &())?;
    let mut figures = BTreeMap::new();

    // 1. Memory.
    for kind in ComparedModel::ALL {
        let built = levels.parts.iter().map(|part| kind.build(part.strips(), part.sequence()));
        let built = built.collect::<Result<Vec<_>, _>>().map_err(tristrip_pipeline::Error::from)?;
        let bytes: usize = built.iter().map(|model| model.memory()).sum();
        figures.insert(format!("mb_{kind}"), bytes as f64 / MEGABYTE);
    }
    add_relative(&mut figures, "ratio_mb", "mb_sets", "mb_mts", 1.0);

    // 2. Moves.
    let core = |error: CoreError| Error::from(tristrip_pipeline::Error::from(error));
    let (mut sets, mut mts) = (Vec::new(), Vec::new());
    for part in &levels.parts {
        sets.push(Sets::new(part.strips(), part.sequence()).map_err(core)?);
        mts.push(Mts::new(part.strips(), part.sequence()).map_err(core)?);
    }
    for sweep in Sweep::ALL {
        for share in SHARES {
            let down = sweep.levels(levels.collapse_count(), share);
            let full = levels.collapse_count();
            let path =
                [full].into_iter().chain(down.iter().copied()).chain(down.iter().rev().skip(1).copied());
            let path = path.chain([full]).map(|level| levels.order.of_parts(level));
            let path: Vec<Vec<usize>> = path.collect::<Result<_, _>>()?;
            let moves = path.len() - 1;
            let (mut read, mut drawn) = ([0_u64; 2], 0_usize);
            for pair in path.windows(2) {
                for part in 0..levels.parts.len() {
                    let (from, to) = (pair[0][part], pair[1][part]);
                    read[0] += sets[part].accesses(from, to).map_err(core)?;
                    read[1] += mts[part].accesses(from, to).map_err(core)?;
                    drawn += levels.parts[part].sequence().triangle_count(to).map_err(core)?;
                }
            }
            let per_move = |count: u64| count as f64 / moves.max(1) as f64;
            for (model, read) in ["sets", "mts"].into_iter().zip(read) {
                figures.insert(format!("accesses_{model}_{sweep}_{share}"), per_move(read));
            }
            figures.insert(format!("triangles_{sweep}_{share}"), per_move(drawn as u64));
            let [of, than] = ["sets", "mts"].map(|model| format!("accesses_{model}_{sweep}_{share}"));
            add_relative(&mut figures, &format!("ratio_{sweep}_{share}"), &of, &than, 1.0);
        }
    }

    // 3. The statements of the paper.
    for model in ["sets", "mts"] {
        for sweep in Sweep::ALL {
            let [few, most] = [1, 20].map(|share| format!("accesses_{model}_{sweep}_{share}"));
            add_relative(&mut figures, &format!("fall_{model}_{sweep}"), &most, &few, 100.0);
        }
        for share in SHARES {
            let [linear, exponential] = Sweep::ALL.map(|sweep| format!("accesses_{model}_{sweep}_{share}"));
            let name = format!("exponential_{model}_{share}");
            add_relative(&mut figures, &name, &exponential, &linear, 100.0);
        }
    }
    for share in SHARES {
        let [linear, exponential] = Sweep::ALL.map(|sweep| format!("triangles_{sweep}_{share}"));
        add_relative(&mut figures, &format!("drawn_{share}"), &exponential, &linear, 100.0);
    }
    let ratios =
        figures.iter().filter(|(name, _)| name.starts_with("ratio_linear") || name.starts_with("ratio_exp"));
    let least = ratios.map(|(_, ratio)| *ratio).fold(f64::INFINITY, f64::min);
    if least.is_finite() && least > 0.0 {
        figures.insert("faster".into(), 100.0 * (1.0 / least - 1.0));
    }
    Ok(figures)
}

/// Adds one metric relative to another, times a factor.
fn add_relative(figures: &mut BTreeMap<String, f64>, name: &str, of: &str, than: &str, factor: f64) {
    if let (Some(&of), Some(&than)) = (figures.get(of), figures.get(than))
        && than > 0.0
    {
        figures.insert(name.into(), factor * of / than);
    }
}
