//! The updates between levels: index-map slots that vertex splits write, naive and encoded, and the
//! bytes of a refinement.

use std::iter::Sum;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use tristrip::Strips;
use tristrip::lod::{Encoding, ProgressiveStrips};
use tristrip::lod::{LevelCursor, Repair, RepairOptions};
use tristrip_pipeline::{levels::LevelPart, levels::ModelLevels, rounded};

use super::rows::Refinement;
use crate::error::Error;

/// Bytes per position, and per index or index-map slot.
const POSITION_BYTES: usize = 12;
const INDEX_BYTES: usize = 2;
/// Indices per split of a progressive mesh: the two vertices of its edge, and the two opposite
/// vertices of its triangles.
const SPLIT_INDICES: usize = 4;

/// The levels of a model, with the data for counting their updates. This data is built on first
/// use.
#[derive(Debug)]
pub struct TrafficModel<'a> {
    /// The levels.
    pub(super) levels: &'a ModelLevels,
    /// Naive and encoded progressive strips of each part.
    models: Vec<OnceLock<[ProgressiveStrips; 2]>>,
}

impl<'a> TrafficModel<'a> {
    /// Prepares the levels of a model.
    pub fn new(levels: &'a ModelLevels) -> Self {
        Self { levels, models: levels.parts.iter().map(|_| OnceLock::new()).collect() }
    }

    /// Computes the refinement from one level of the model to a higher one.
    ///
    /// # Errors
    /// A level does not exist.
    pub fn refinement(&self, from: usize, to: usize) -> Result<Refinement, Error> {
        let (from, to) = (self.levels.order.of_parts(from)?, self.levels.order.of_parts(to)?);
        let ranges = from.into_iter().zip(to).map(|(from, to)| from..to);
        let parts = self.levels.parts.iter().zip(&self.models).zip(ranges);
        let updates = parts.map(|((part, models), range)| updates(part, models, range));
        let SplitUpdates { splits, vertices, naive, encoded } =
            updates.collect::<Result<Vec<_>, _>>()?.into_iter().sum();
        let average = |slots: usize| rounded(slots as f64 / splits.max(1) as f64);
        let bytes = |indices: usize| POSITION_BYTES * vertices + INDEX_BYTES * indices;
        Ok(Refinement {
            splits,
            updates_naive: average(naive),
            updates_encoded: average(encoded),
            bytes_triangles: bytes(SPLIT_INDICES * vertices),
            bytes_naive: bytes(naive),
            bytes_encoded: bytes(encoded),
        })
    }
}

/// The number of vertex splits, and their writes into the index map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct SplitUpdates {
    splits: usize,
    /// The number of added vertices: one per split, or more on attribute seams.
    vertices: usize,
    /// The number of slots written if collapses write the kept vertex.
    naive: usize,
    /// The number of slots written if collapses write symbols that refer to a nearby slot.
    encoded: usize,
}

impl Sum for SplitUpdates {
    fn sum<I: Iterator<Item = Self>>(counts: I) -> Self {
        counts.fold(Self::default(), |a, b| Self {
            splits: a.splits + b.splits,
            vertices: a.vertices + b.vertices,
            naive: a.naive + b.naive,
            encoded: a.encoded + b.encoded,
        })
    }
}

/// Counts the index-map slots that the vertex splits between two levels of a part write, naive and
/// encoded.
fn updates(
    part: &LevelPart,
    models: &OnceLock<[ProgressiveStrips; 2]>,
    levels: Range<usize>,
) -> Result<SplitUpdates, Error> {
    let sequence = part.sequence();
    let model = |encoding| ProgressiveStrips::new(part.strips(), sequence, encoding);
    if models.get().is_none() {
        // Another thread may have built the same models first.
        let _ = models.set([model(Encoding::Naive)?, model(Encoding::Offsets)?]);
    }
    let slots = |level: usize| models.get().map(|both| both.each_ref().map(|model| model.slot_count(level)));
    let [naive, encoded] = levels.clone().filter_map(slots).fold([0; 2], |[a, b], [c, d]| [a + c, b + d]);
    let renamed = |level| sequence.collapse(level).map(|collapse| collapse.renames.len());
    let vertices = levels.clone().map(renamed).sum::<Result<usize, _>>()?;
    Ok(SplitUpdates { splits: levels.len(), vertices, naive, encoded })
}

/// Counts the vertices that `repair` sends at ascending levels of a part. It follows the collapses
/// from the full mesh.
pub(super) fn sent_by_repair(
    part: &LevelPart,
    levels: &[usize],
    options: RepairOptions,
    verify: bool,
) -> Result<Vec<usize>, Error> {
    let mut repair = Repair::new(Arc::clone(part.sequence()), part.strips(), options)?;
    let mut sent = Vec::with_capacity(levels.len());
    for &level in levels.iter().rev() {
        repair.set_level(level)?;
        if verify {
            part.prove(level, repair.strips())?;
        }
        sent.push(repair.vertices_sent());
    }
    sent.reverse();
    Ok(sent)
}

/// Scans an index map into display strips.
pub(super) fn scanned(scanner: tristrip::lod::Filter, map: &[u32]) -> Strips {
    let mut display = Strips::default();
    scanner.map_to(map, &mut display);
    display
}

#[cfg(test)]
mod tests {
    use super::*;
    use tristrip::{Faces, Mesh};
    use tristrip_io::{Model, Part};
    use tristrip_pipeline::levels;

    #[test]
    fn a_split_writes_the_slots_of_its_vertex() {
        // A flat strip of four triangles, which the collapses shorten.
        let positions: Vec<[f32; 3]> = (0..6).map(|i| [(i / 2) as f32, (i % 2) as f32, 0.0]).collect();
        let faces = Faces::from_triangles(vec![0, 2, 1, 1, 2, 3, 2, 4, 3, 3, 4, 5]).unwrap();
        let mesh = Mesh::new(positions, faces).unwrap();
        let model = Model { parts: vec![Part { mesh, ..Part::default() }], ..Model::default() };
        let levels = levels::run(&model, &levels::Options::default(), &()).unwrap().model;
        let traffic = TrafficModel::new(&levels);
        let all = traffic.refinement(0, levels.collapse_count()).unwrap();
        assert_eq!(all.splits, levels.collapse_count());
        assert!(all.splits > 0 && all.updates_naive >= 1.0 && all.bytes_naive > 0);
        assert!(traffic.refinement(0, all.splits + 1).is_err());
    }
}
