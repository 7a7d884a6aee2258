//! The checks of one real model's levels of detail: every model of a level of detail, through every filter, draws what the oracle draws,
//! and what was refined again is what it was.
//!
//! The oracle renames the vertices of all triangles of the full mesh and leaves out the degenerate ones. Drawings are compared by the
//! number of their triangles and two sums of hashes over them, each triangle rotated to begin with its lowest vertex: a winding or a triangle
//! that differs changes both sums.

use std::hash::{DefaultHasher, Hash, Hasher};

use tristrip::lod::Filter;
use tristrip::lod::progressive::{Encoding, ProgressiveMesh, ProgressiveStrips};
use tristrip::lod::{Repair, RepairOptions};
use tristrip::simplify::{self, simplify};
use tristrip::stripify::Effort;
use tristrip::{CollapseSequence, Mesh, Method, StripifyOptions, Strips, stripify};

use crate::Failure;

/// Meshes of at most so many triangles are checked at every level.
pub const SMALL: usize = 8_000;
/// Levels at which larger ones are checked.
pub const LEVELS: usize = 200;
/// Levels at which the repaired strips of larger ones are checked.
const REPAIRED_LEVELS: usize = 20;

/// What was checked of a mesh.
#[derive(Debug, Default)]
pub struct Checked {
    /// Levels at which all drawings were the oracle's.
    pub levels: usize,
    /// Drawings that were compared.
    pub drawings: usize,
    /// What went wrong, in words.
    pub faults: Vec<String>,
    /// One line per kind of drawing: what it is, and a hash over all levels; empty unless asked for.
    pub hashes: Vec<String>,
}

/// Hashes drawings of one kind over all levels, one after the other.
#[derive(Default)]
struct Hashes(Option<Vec<(String, DefaultHasher)>>);

impl Hashes {
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

/// Simplifies the triangles that STRIPE's strips draw as far as the topology allows, and compares all drawings at the levels.
///
/// With `hashes` all drawings are hashed, too.
///
/// # Errors
/// The mesh has too many triangles.
pub fn check(mesh: &Mesh, hashes: bool) -> Result<Checked, Failure> {
    let strips = stripify(mesh, &StripifyOptions::default().with_method(Method::STRIPE))?;
    let sequence = simplify(mesh, strips.to_list(), &simplify::SimplifyOptions::default())?.sequence;
    let mut checked = Checked::default();
    if let Err(error) = sequence.check() {
        checked.faults.push(format!("the collapses are not what they say: {error}"));
        return Ok(checked);
    }
    let mut hashes = Hashes(hashes.then(Vec::new));
    for collapse in sequence.iter() {
        hashes.add("collapses", (collapse.renames, collapse.error.to_bits()));
    }
    let small = strips.triangles().count() <= SMALL;
    drawings(&strips, &sequence, if small { sequence.len() } else { LEVELS }, &mut checked, &mut hashes)?;
    repaired(
        &strips,
        &sequence,
        if small { sequence.len() } else { REPAIRED_LEVELS },
        &mut checked,
        &mut hashes,
    )?;
    checked.hashes = hashes.lines().collect();
    Ok(checked)
}

/// Gives levels from the full mesh to the base mesh, so many and one.
fn levels(sequence: &CollapseSequence, count: usize) -> impl Iterator<Item = usize> {
    let (len, count) = (sequence.len(), count.clamp(1, sequence.len().max(1)));
    (0..=count).rev().map(move |step| len * step / count)
}

/// Compares the progressive mesh and both progressive strips, each through every filter.
fn drawings(
    strips: &Strips,
    sequence: &CollapseSequence,
    count: usize,
    checked: &mut Checked,
    hashes: &mut Hashes,
) -> Result<(), Failure> {
    let mut mesh = ProgressiveMesh::new(sequence)?;
    let naive = ProgressiveStrips::new(strips, sequence, Encoding::Naive)?;
    let mut models = [naive, ProgressiveStrips::new(strips, sequence, Encoding::Offsets)?];
    let full = models.clone();
    let (mut maps, mut display) = ([Vec::new(), Vec::new()], Strips::default());
    for level in levels(sequence, count) {
        let oracle = Drawing::of(sequence.drawn(level).into_iter());
        let mut compare = |drawn: Drawing, what: &str| {
            checked.drawings += 1;
            if drawn != oracle {
                checked.faults.push(format!("level {level}: {what} draws other triangles than the oracle"));
            }
        };
        mesh.go_to(level);
        compare(
            Drawing::of(mesh.corners().chunks_exact(3).map(|t| [t[0], t[1], t[2]])),
            "the progressive mesh",
        );
        for (model, map) in models.iter_mut().zip(&mut maps) {
            model.go_to(level);
            model.decode_to(map);
        }
        hashes.add("progressive mesh", mesh.corners());
        hashes.add("index map", &maps[0]);
        for (number, filter) in Filter::ALL.into_iter().enumerate() {
            display.clear();
            filter.map_to(&maps[0], &mut display);
            compare(Drawing::of(display.triangles()), &format!("{filter:?}"));
            hashes.add(&format!("filter {number}"), display.to_restart(u32::MAX));
        }
        if maps[0] != maps[1] {
            checked.faults.push(format!("level {level}: the encoded strips are not the naive ones"));
        }
        checked.levels += 1;
    }
    for (model, full) in models.iter_mut().zip(full) {
        model.go_to(sequence.len());
        if *model != full {
            checked.faults.push(format!("{:?}: refined, it is not what it was", model.encoding()));
        }
    }
    Ok(())
}

/// Compares the strips that are repaired step by step, toward the base mesh and back.
fn repaired(
    strips: &Strips,
    sequence: &CollapseSequence,
    count: usize,
    checked: &mut Checked,
    hashes: &mut Hashes,
) -> Result<(), Failure> {
    let options = RepairOptions::default().with_effort(Effort::new(1).unwrap_or_default());
    let mut repair = Repair::new(sequence, strips, options)?;
    let there: Vec<usize> = levels(sequence, count).collect();
    let back = there.iter().rev().step_by(10);
    for &level in there.iter().chain(back) {
        repair.go_to(level);
        checked.drawings += 1;
        hashes.add("repair", repair.strips().to_restart(u32::MAX));
        if Drawing::of(repair.strips().triangles()) != Drawing::of(sequence.drawn(level).into_iter()) {
            checked
                .faults
                .push(format!("level {level}: repaired strips draw other triangles than the oracle"));
        }
    }
    Ok(())
}

/// Triangles without their order.
#[derive(Debug, PartialEq, Eq)]
struct Drawing {
    count: usize,
    sums: [u64; 2],
}

impl Drawing {
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

/// Mixes 64 bits so that each hangs on all.
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
        assert_eq!(checked.faults, Vec::<String>::new());
        assert!(checked.levels > 100 && checked.drawings > 6 * checked.levels);
    }

    #[test]
    fn drawings_differ_by_a_winding_and_not_by_an_order() {
        let drawing = |triangles: &[[u32; 3]]| Drawing::of(triangles.iter().copied());
        assert_eq!(drawing(&[[0, 1, 2], [2, 1, 3]]), drawing(&[[1, 3, 2], [2, 0, 1]]));
        assert_ne!(drawing(&[[0, 1, 2]]), drawing(&[[0, 2, 1]]));
        assert_ne!(drawing(&[[0, 1, 2], [0, 1, 2]]), drawing(&[[0, 1, 2]]));
    }
}
