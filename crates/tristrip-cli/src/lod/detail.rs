//! A part at any level: its strips with renamed vertices, filtered, and the proof that they draw what the collapses leave.

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
use crate::simplify::Compact;
use crate::values::FilterName;

/// A part with the strips of its full mesh and its collapses.
pub(crate) struct Detail<'a> {
    compact: Compact<'a>,
    sequence: CollapseSequence,
    /// Over the vertices of `compact`, as the collapses are.
    strips: Strips,
    /// Naive and encoded, made where places are counted.
    models: OnceLock<[ProgressiveStrips; 2]>,
}

impl<'a> Detail<'a> {
    /// Takes a part, the strips of its full mesh over its own vertices, and its simplification.
    pub(crate) fn new(compact: Compact<'a>, strips: &Strips, simplification: Simplification) -> Self {
        let strips = mapped(strips, |strip| compact.inward(strip));
        let sequence = simplification.sequence;
        Self { compact, sequence, strips, models: OnceLock::new() }
    }

    /// Gives the strips of the full mesh, over the vertices of the collapses.
    pub(crate) fn strips(&self) -> &Strips {
        &self.strips
    }

    pub(crate) fn sequence(&self) -> &CollapseSequence {
        &self.sequence
    }

    /// Gives the index map at a level: the strips with the vertices that stand in them, and restarts between them.
    pub(crate) fn map(&self, level: usize) -> Vec<u32> {
        let now = self.sequence.renaming(level);
        let renamed = |v: u32| if v == RESTART { RESTART } else { now[v as usize] };
        self.strips.to_restart(RESTART).into_iter().map(renamed).collect()
    }

    /// Gives the display strips of a level, whose index map this is.
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

    /// Counts the places that vertex splits write from one level to another, without symbols and with them.
    pub(crate) fn updates(&self, levels: Range<usize>) -> Result<Updates, Error> {
        let model = |encoding| ProgressiveStrips::new(&self.strips, &self.sequence, encoding);
        if self.models.get().is_none() {
            // Whoever was faster has made the same.
            let _ = self.models.set([model(Encoding::Naive)?, model(Encoding::Offsets)?]);
        }
        let places = |level: usize| {
            self.models.get().map(|both| both.each_ref().map(|model| model.place_count(level)))
        };
        let [naive, encoded] =
            levels.clone().filter_map(places).fold([0; 2], |[a, b], [c, d]| [a + c, b + d]);
        let vertices = levels.clone().map(|level| self.sequence.collapse(level).renames.len()).sum();
        Ok(Updates { splits: levels.len(), vertices, naive, encoded })
    }

    /// Gives strips over the part's own vertices.
    pub(crate) fn outward(&self, strips: &Strips) -> Strips {
        mapped(strips, |strip| self.compact.outward(strip))
    }

    /// Gives the triangles that the collapses leave at a level, over the part's own vertices.
    pub(crate) fn left(&self, level: usize) -> Vec<u32> {
        let mut corners = self.sequence.drawn(level).into_flattened();
        self.compact.outward(&mut corners);
        corners
    }

    /// Counts the vertices that `repair` sends at rising levels, where it follows the collapses from the full mesh down.
    pub(crate) fn repaired(
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

    /// Proves that display strips draw what the collapses leave at a level.
    pub(crate) fn prove(&self, level: usize, display: &Strips) -> Result<(), Failure> {
        let left = Faces::from_triangles(self.sequence.drawn(level).into_flattened())?;
        let drawn: Vec<[u32; 3]> = display.triangles().collect();
        verify_drawing(&left, &drawn).map_err(|why| Failure::Unproven(format!("level {level}: {why}")))?;
        Ok(())
    }
}

/// What vertex splits write into the index map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Updates {
    pub(crate) splits: usize,
    /// Vertices that come back: one for each split, and more on attribute seams.
    pub(crate) vertices: usize,
    /// Places written where collapses write the kept vertex.
    pub(crate) naive: usize,
    /// Places written where collapses write symbols that refer to a place nearby.
    pub(crate) encoded: usize,
}

impl Sum for Updates {
    fn sum<I: Iterator<Item = Self>>(counts: I) -> Self {
        counts.fold(Self::default(), |a, b| Self {
            splits: a.splits + b.splits,
            vertices: a.vertices + b.vertices,
            naive: a.naive + b.naive,
            encoded: a.encoded + b.encoded,
        })
    }
}

/// Gives strips with other vertices.
fn mapped(strips: &Strips, map: impl Fn(&mut [u32])) -> Strips {
    let (mut out, mut other) = (Strips::default(), Vec::new());
    for strip in strips.iter() {
        other.clear();
        other.extend_from_slice(strip);
        map(&mut other);
        out.push(&other);
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
    fn every_filter_draws_what_is_left_and_nothing_else_is_proven() {
        let mesh =
            Mesh::new((0..6).map(|i| [i as f32, 0.0, 0.0]).collect::<Vec<_>>(), Faces::default()).unwrap();
        let mut strips = Strips::default();
        strips.push(&[0, 1, 2, 3, 4, 5]);
        let rename = [Rename { removed: 3, kept: 2 }];
        let sequence = CollapseSequence::from_collapses(6, strips.to_list(), [(&rename[..], 1.0)]).unwrap();
        let compact = Compact::new(&mesh, &strips.to_list()).unwrap();
        let detail = Detail::new(compact, &strips, Simplification { sequence, stopped: None });
        assert_eq!(detail.map(1), strips.vertices());
        let map = detail.map(0);
        assert_eq!(map, [0, 1, 2, 2, 4, 5]);
        assert_eq!(detail.updates(0..1).unwrap(), Updates { splits: 1, vertices: 1, naive: 1, encoded: 1 });
        for &filter in FilterName::value_variants() {
            let display = detail.display(0, &map, filter, repair::Options::default()).unwrap();
            detail.prove(0, &display).unwrap();
            assert!(matches!(detail.prove(1, &display), Err(Failure::Unproven(_))));
        }
        assert_eq!(detail.left(0), [0, 1, 2, 4, 2, 5]);
    }
}
