//! A part at any level: its strips with renamed vertices, filtered, and the proof that they draw exactly the triangles of the level.

use std::iter::Sum;
use std::ops::Range;
use std::sync::OnceLock;

use tristrip::lod::RESTART;
use tristrip::lod::filter::{Repair, repair};
use tristrip::lod::progressive::{Encoding, ProgressiveStrips};
use tristrip::simplify::Simplification;
use tristrip::strip::verify_drawing;
use tristrip::{CollapseSequence, Error, Faces, Strips};

use crate::failure::Failure;
use crate::simplify::{Compact, Part};
use crate::values::FilterName;

/// A part: the strips of its full mesh, and its collapses.
pub(crate) struct LodPart<'a> {
    compact: Compact<'a>,
    sequence: CollapseSequence,
    /// Over the vertices of `compact`, like the collapses.
    strips: Strips,
    /// Naive and encoded; built when updates are counted for the first time.
    models: OnceLock<[ProgressiveStrips; 2]>,
}

impl<'a> LodPart<'a> {
    /// Builds all parts of a model, from the strips of the full meshes and the simplifications, in the same order.
    pub(crate) fn all(
        parts: Vec<Part<'a>>,
        strips: &[Strips],
        simplifications: Vec<Simplification>,
    ) -> Vec<Self> {
        let all = parts.into_iter().zip(strips).zip(simplifications);
        all.map(|((part, strips), simplification)| Self::new(part.compact, strips, simplification)).collect()
    }

    /// Builds a part from the strips of its full mesh, over its own vertices, and its simplification.
    pub(crate) fn new(compact: Compact<'a>, strips: &Strips, simplification: Simplification) -> Self {
        let strips = mapped(strips, |strip| compact.inward(strip));
        let sequence = simplification.sequence;
        Self { compact, sequence, strips, models: OnceLock::new() }
    }

    /// Returns the strips of the full mesh, over the vertices of the collapses.
    pub(crate) fn strips(&self) -> &Strips {
        &self.strips
    }

    pub(crate) fn sequence(&self) -> &CollapseSequence {
        &self.sequence
    }

    /// Returns the index map at a level: the strips with renamed vertices, and restarts between them.
    pub(crate) fn index_map(&self, level: usize) -> Vec<u32> {
        let renaming = self.sequence.renaming(level);
        let renamed = |v: u32| if v == RESTART { RESTART } else { renaming[v as usize] };
        self.strips.to_restart(RESTART).into_iter().map(renamed).collect()
    }

    /// Returns the display strips of a level with the given index map.
    pub(crate) fn display(
        &self,
        level: usize,
        map: &[u32],
        filter: FilterName,
        repair: repair::Options,
    ) -> Result<Strips, Error> {
        let Some(scanner) = filter.scanner() else {
            return Ok(Repair::at(&self.sequence, &self.strips, level, repair)?.strips());
        };
        let mut display = Strips::default();
        scanner.map_to(map, &mut display);
        Ok(display)
    }

    /// Counts the index-map slots that the vertex splits between two levels write, naive and encoded.
    pub(crate) fn updates(&self, levels: Range<usize>) -> Result<SplitUpdates, Error> {
        let model = |encoding| ProgressiveStrips::new(&self.strips, &self.sequence, encoding);
        if self.models.get().is_none() {
            // Another thread may have built the same models first.
            let _ = self.models.set([model(Encoding::Naive)?, model(Encoding::Offsets)?]);
        }
        let slots = |level: usize| {
            self.models.get().map(|both| both.each_ref().map(|model| model.place_count(level)))
        };
        let [naive, encoded] = levels.clone().filter_map(slots).fold([0; 2], |[a, b], [c, d]| [a + c, b + d]);
        let vertices = levels.clone().map(|level| self.sequence.collapse(level).renames.len()).sum();
        Ok(SplitUpdates { splits: levels.len(), vertices, naive, encoded })
    }

    /// Returns strips over the part's own vertices.
    pub(crate) fn outward(&self, strips: &Strips) -> Strips {
        mapped(strips, |strip| self.compact.outward(strip))
    }

    /// Returns the triangles of a level, over the part's own vertices.
    pub(crate) fn triangles(&self, level: usize) -> Vec<u32> {
        let mut corners = self.sequence.drawn(level).into_flattened();
        self.compact.outward(&mut corners);
        corners
    }

    /// Counts the vertices that `repair` sends at ascending levels, when it follows the collapses from the full mesh.
    pub(crate) fn sent_by_repair(
        &self,
        levels: &[usize],
        options: repair::Options,
        verify: bool,
    ) -> Result<Vec<usize>, Failure> {
        let mut repair = Repair::new(&self.sequence, &self.strips, options)?;
        let mut sent = Vec::with_capacity(levels.len());
        for &level in levels.iter().rev() {
            repair.go_to(level);
            if verify {
                self.prove(level, &repair.strips())?;
            }
            sent.push(repair.vertices_sent());
        }
        sent.reverse();
        Ok(sent)
    }

    /// Proves that display strips draw exactly the triangles of a level.
    pub(crate) fn prove(&self, level: usize, display: &Strips) -> Result<(), Failure> {
        let expected = Faces::from_triangles(self.sequence.drawn(level).into_flattened())?;
        let drawn: Vec<[u32; 3]> = display.triangles().collect();
        verify_drawing(&expected, &drawn)
            .map_err(|why| Failure::Unproven(format!("level {level}: {why}")))?;
        Ok(())
    }
}

/// The number of vertex splits, and what they write into the index map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct SplitUpdates {
    pub(crate) splits: usize,
    /// Vertices that are added: one per split, more on attribute seams.
    pub(crate) vertices: usize,
    /// Slots written if collapses write the kept vertex.
    pub(crate) naive: usize,
    /// Slots written if collapses write symbols that refer to a nearby slot.
    pub(crate) encoded: usize,
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

/// Returns strips with mapped vertices.
fn mapped(strips: &Strips, map: impl Fn(&mut [u32])) -> Strips {
    let (mut out, mut mapped) = (Strips::default(), Vec::new());
    for strip in strips.iter() {
        mapped.clear();
        mapped.extend_from_slice(strip);
        map(&mut mapped);
        out.push(&mapped);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::ValueEnum;
    use tristrip::Mesh;
    use tristrip::simplify::Rename;

    #[test]
    fn every_filter_draws_exactly_the_triangles_of_the_level() {
        let mesh =
            Mesh::new((0..6).map(|i| [i as f32, 0.0, 0.0]).collect::<Vec<_>>(), Faces::default()).unwrap();
        let mut strips = Strips::default();
        strips.push(&[0, 1, 2, 3, 4, 5]);
        let rename = [Rename { removed: 3, kept: 2 }];
        let sequence = CollapseSequence::from_collapses(6, strips.to_list(), [(&rename[..], 1.0)]).unwrap();
        let compact = Compact::new(&mesh, &strips.to_list()).unwrap();
        let part = LodPart::new(compact, &strips, Simplification { sequence, stopped: None });
        assert_eq!(part.index_map(1), strips.vertices());
        let map = part.index_map(0);
        assert_eq!(map, [0, 1, 2, 2, 4, 5]);
        assert_eq!(
            part.updates(0..1).unwrap(),
            SplitUpdates { splits: 1, vertices: 1, naive: 1, encoded: 1 }
        );
        for &filter in FilterName::value_variants() {
            let display = part.display(0, &map, filter, repair::Options::default()).unwrap();
            part.prove(0, &display).unwrap();
            assert!(matches!(part.prove(1, &display), Err(Failure::Unproven(_))));
        }
        assert_eq!(part.triangles(0), [0, 1, 2, 4, 2, 5]);
    }
}
