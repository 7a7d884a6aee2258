//! Checks of the levels of detail of one real model: every representation draws the same triangles
//! as the oracle with every filter, and refinement restores the full mesh.
//!
//! The oracle renames the vertices of all triangles of the full mesh and drops the degenerate ones.
//! Drawn triangles are compared by their number and two sums of hashes. Each triangle is first
//! rotated to start with its lowest vertex. A different winding or triangle changes both sums.

use std::hash::{DefaultHasher, Hash, Hasher};

use std::sync::Arc;

use tristrip::Effort;
use tristrip::lod::{Encoding, ProgressiveMesh, ProgressiveStrips};
use tristrip::lod::{Filter, LevelCursor};
use tristrip::lod::{Repair, RepairOptions};
use tristrip::random::Random;
use tristrip::simplify::{self, simplify_triangles};
use tristrip::{CollapseSequence, Mesh, Method, StripifyOptions, Strips, stripify};
use tristrip_lab::baselines::ComparedModel;

use crate::failure::Failure;

/// Meshes with at most this number of triangles are checked at every level.
pub const SMALL: usize = 8_000;
/// The number of checked levels of larger meshes.
pub const LEVELS: usize = 200;
/// The number of levels of larger meshes that are checked with repaired strips.
const REPAIRED_LEVELS: usize = 20;

/// The result of checking a mesh.
#[derive(Debug, Default)]
pub struct CheckedLevels {
    /// The number of levels whose drawn triangles matched the oracle.
    pub levels: usize,
    /// The number of compared sets of drawn triangles.
    pub drawings: usize,
    /// Descriptions of the problems found.
    pub problems: Vec<String>,
    /// One line per representation: its name and a hash over all levels; empty unless requested.
    pub hashes: Vec<String>,
}

/// The hash of each representation over all levels.
#[derive(Default)]
struct LevelHashes(Option<Vec<(String, DefaultHasher)>>);

impl LevelHashes {
    fn add(&mut self, kind: &str, value: impl Hash) {
        let Some(kinds) = &mut self.0 else { return };
        if !kinds.iter().any(|(each, _)| each == kind) {
            kinds.push((kind.into(), DefaultHasher::new()));
        }
        kinds.iter_mut().filter(|(each, _)| each == kind).for_each(|(_, hasher)| value.hash(hasher));
    }

    fn lines(self) -> impl Iterator<Item = String> {
        let line = |(kind, hasher): (String, DefaultHasher)| format!("{kind}\t{:016x}", hasher.finish());
        self.0.into_iter().flatten().map(line)
    }
}

/// Simplifies the triangles of STRIPE's strips as far as the topology allows, and compares all
/// representations at the levels.
///
/// With `hashes`, all representations are also hashed.
///
/// # Errors
/// The mesh has too many triangles.
pub fn check(mesh: &Mesh, hashes: bool) -> Result<CheckedLevels, Failure> {
    let strips = stripify(mesh, &StripifyOptions::default().with_method(Method::STRIPE))?;
    let sequence =
        simplify_triangles(mesh, strips.to_list(), &simplify::SimplifyOptions::default())?.sequence;
    if let Err(error) = sequence.check() {
        let problems = vec![format!("the collapse sequence is inconsistent: {error}")];
        return Ok(CheckedLevels { problems, ..CheckedLevels::default() });
    }
    let mut check = LevelCheck {
        strips: &strips,
        sequence: &sequence,
        checked: CheckedLevels::default(),
        hashes: LevelHashes(hashes.then(Vec::new)),
    };
    for collapse in sequence.iter() {
        check.hashes.add("collapses", (collapse.renames, collapse.error.to_bits()));
    }
    let small = strips.triangles().count() <= SMALL;
    check.representations(if small { sequence.len() } else { LEVELS })?;
    check.level_models(if small { sequence.len() } else { LEVELS })?;
    check.repaired(if small { sequence.len() } else { REPAIRED_LEVELS })?;
    let LevelCheck { mut checked, hashes, .. } = check;
    checked.hashes = hashes.lines().collect();
    Ok(checked)
}

/// Iterates over `count` + 1 levels from the full mesh to the base mesh.
fn levels(sequence: &CollapseSequence, count: usize) -> impl Iterator<Item = usize> + use<> {
    let (len, count) = (sequence.len(), count.clamp(1, sequence.len().max(1)));
    (0..=count).rev().map(move |step| len * step / count)
}

/// The check of one mesh: the compared data, and the results so far.
struct LevelCheck<'a> {
    strips: &'a Strips,
    sequence: &'a CollapseSequence,
    checked: CheckedLevels,
    hashes: LevelHashes,
}

impl LevelCheck<'_> {
    /// Compares the drawn triangles of a level with those of the oracle.
    fn compare(&mut self, level: usize, what: &str, drawn: &DrawingSum, oracle: &DrawingSum) {
        self.checked.drawings += 1;
        if drawn != oracle {
            self.checked
                .problems
                .push(format!("level {level}: {what} draws other triangles than the oracle"));
        }
    }

    /// Compares the progressive mesh and both progressive strips with every filter.
    fn representations(&mut self, count: usize) -> Result<(), Failure> {
        let (strips, sequence) = (self.strips, self.sequence);
        let mut mesh = Arc::new(ProgressiveMesh::new(sequence)?).cursor();
        let cursor = |encoding| -> Result<_, Failure> {
            Ok(Arc::new(ProgressiveStrips::new(strips, sequence, encoding)?).cursor())
        };
        let mut cursors = [cursor(Encoding::Naive)?, cursor(Encoding::Offsets)?];
        let full = cursors.each_ref().map(|cursor| cursor.entries().to_vec());
        let (mut maps, mut display) = ([Vec::new(), Vec::new()], Strips::default());
        for level in levels(sequence, count) {
            let oracle = DrawingSum::of(sequence.drawn(level)?.into_iter());
            mesh.set_level(level)?;
            let drawn = DrawingSum::of(mesh.corners().chunks_exact(3).map(|t| [t[0], t[1], t[2]]));
            self.compare(level, "the progressive mesh", &drawn, &oracle);
            for (cursor, map) in cursors.iter_mut().zip(&mut maps) {
                cursor.set_level(level)?;
                cursor.decode_to(map);
            }
            self.hashes.add("progressive mesh", mesh.corners());
            self.hashes.add("index map", &maps[0]);
            for (number, filter) in Filter::ALL.into_iter().enumerate() {
                display.clear();
                filter.map_to(&maps[0], &mut display);
                self.compare(level, &format!("{filter:?}"), &DrawingSum::of(display.triangles()), &oracle);
                self.hashes.add(&format!("filter {number}"), display.to_restart(u32::MAX));
            }
            if maps[0] != maps[1] {
                self.checked
                    .problems
                    .push(format!("level {level}: the encoded strips differ from the naive ones"));
            }
            self.checked.levels += 1;
        }
        for (cursor, full) in cursors.iter_mut().zip(full) {
            cursor.set_level(sequence.len())?;
            if cursor.entries() != full {
                let problem =
                    format!("{}: refining does not restore the full mesh", cursor.model().encoding());
                self.checked.problems.push(problem);
            }
        }
        Ok(())
    }

    /// Compares every level model at `count` levels in random order.
    fn level_models(&mut self, count: usize) -> Result<(), Failure> {
        let mut random = Random::new(0);
        let mut jumps: Vec<usize> = levels(self.sequence, count).collect();
        (1..jumps.len()).rev().for_each(|i| jumps.swap(i, random.below(i + 1)));
        let oracles: Vec<DrawingSum> = jumps
            .iter()
            .map(|&level| Ok(DrawingSum::of(self.sequence.drawn(level)?.into_iter())))
            .collect::<Result<_, Failure>>()?;
        let sequence = Arc::new(self.sequence.clone());
        for kind in ComparedModel::ALL {
            let mut cursor = kind.build(self.strips, &sequence)?.start();
            for (&level, oracle) in jumps.iter().zip(&oracles) {
                cursor.set_level(level)?;
                let strips = cursor.strips();
                self.hashes.add(kind.name(), strips.to_restart(u32::MAX));
                self.compare(level, kind.name(), &DrawingSum::of(strips.triangles()), oracle);
            }
        }
        Ok(())
    }

    /// Compares the strips that are repaired step by step, down to the base mesh and back.
    fn repaired(&mut self, count: usize) -> Result<(), Failure> {
        let options = RepairOptions::default().with_effort(Effort::new(1).unwrap_or_default());
        let mut repair = Repair::new(self.sequence.clone(), self.strips, options)?;
        let down: Vec<usize> = levels(self.sequence, count).collect();
        let up = down.iter().rev().step_by(10);
        for &level in down.iter().chain(up) {
            repair.set_level(level)?;
            let strips = repair.strips();
            self.hashes.add("repair", strips.to_restart(u32::MAX));
            let oracle = DrawingSum::of(self.sequence.drawn(level)?.into_iter());
            self.compare(level, "repair", &DrawingSum::of(strips.triangles()), &oracle);
        }
        Ok(())
    }
}

/// A fingerprint of a set of triangles, independent of their order.
#[derive(Debug, PartialEq, Eq)]
struct DrawingSum {
    count: usize,
    sums: [u64; 2],
}

impl DrawingSum {
    fn of(triangles: impl Iterator<Item = [u32; 3]>) -> Self {
        let mut drawing = Self { count: 0, sums: [0; 2] };
        for triangle in triangles {
            let [a, b, c] = canonical_triangle(triangle).map(u64::from);
            for (sum, seed) in drawing.sums.iter_mut().zip([0x9e37_79b9_7f4a_7c15, 0xc2b2_ae3d_27d4_eb4f]) {
                *sum = sum.wrapping_add(mixed(mixed(mixed(seed ^ a) ^ b) ^ c));
            }
            drawing.count += 1;
        }
        drawing
    }
}

fn canonical_triangle([a, b, c]: [u32; 3]) -> [u32; 3] {
    [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap_or([a, b, c])
}

/// Mixes 64 bits: each result bit depends on all input bits.
fn mixed(x: u64) -> u64 {
    let x = (x ^ x >> 32).wrapping_mul(0xd6e8_feb8_6659_fd93);
    (x ^ x >> 32).wrapping_mul(0xd6e8_feb8_6659_fd93)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn a_small_model_passes_at_every_level() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../testdata/models/fish_control.ply");
        let model = tristrip_io::read_path(path).unwrap();
        let checked = check(&model.parts[0].mesh, false).unwrap();
        assert_eq!(checked.problems, Vec::<String>::new());
        assert!(checked.levels > 100 && checked.drawings > 6 * checked.levels);
    }

    #[test]
    fn sums_depend_on_winding_and_not_on_order() {
        let drawing = |triangles: &[[u32; 3]]| DrawingSum::of(triangles.iter().copied());
        assert_eq!(drawing(&[[0, 1, 2], [2, 1, 3]]), drawing(&[[1, 3, 2], [2, 0, 1]]));
        assert_ne!(drawing(&[[0, 1, 2]]), drawing(&[[0, 2, 1]]));
        assert_ne!(drawing(&[[0, 1, 2], [0, 1, 2]]), drawing(&[[0, 1, 2]]));
    }
}
