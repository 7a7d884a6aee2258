//! Level models that papers compare with, reconstructed: MTS and `LodStrips`. Also selects any
//! level model by name.

mod lod_strips;
mod mts;

use std::fmt;
use std::sync::Arc;

use tristrip::lod::{LevelModel, ModelKind};
use tristrip::{CollapseSequence, Error, Strips};

pub use lod_strips::LodStrips;
pub use mts::Mts;

/// A level model in a comparison: one of the library, or a baseline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ComparedModel {
    /// A level model of the library.
    Library(ModelKind),
    /// [`Mts`].
    Mts,
    /// [`LodStrips`].
    LodStrips,
}

impl ComparedModel {
    /// All models, in the order of reports.
    pub const ALL: [Self; 8] = [
        Self::Library(ModelKind::ProgressiveMesh),
        Self::Library(ModelKind::Naive),
        Self::Library(ModelKind::Progressive),
        Self::Mts,
        Self::Library(ModelKind::Sets),
        Self::LodStrips,
        Self::Library(ModelKind::Blocks),
        Self::Library(ModelKind::Skip),
    ];

    /// Returns the name of the model.
    pub fn name(self) -> &'static str {
        match self {
            Self::Library(kind) => kind.name(),
            Self::Mts => "mts",
            Self::LodStrips => "lod-strips",
        }
    }

    /// Builds the model from strips of the full mesh.
    ///
    /// # Errors
    /// The mesh is too large for the model, or the strips do not match the collapses.
    ///
    /// ```
    #[doc = include_str!("baselines/example.txt")]
    /// let sequence = Arc::new(sequence);
    /// for model in ComparedModel::ALL {
    ///     let mut cursor = model.build(&strips, &sequence)?.start();
    ///     cursor.set_level(1)?;
    ///     assert_eq!(cursor.strips().triangles().count(), 2, "{model}");
    /// }
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn build(
        self,
        strips: &Strips,
        sequence: &Arc<CollapseSequence>,
    ) -> Result<Arc<dyn LevelModel>, Error> {
        Ok(match self {
            Self::Library(kind) => kind.build(strips, sequence)?,
            Self::Mts => Arc::new(Mts::new(strips, sequence)?),
            Self::LodStrips => Arc::new(LodStrips::new(strips, sequence)?),
        })
    }
}

impl fmt::Display for ComparedModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::samples;
    use proptest::prelude::*;

    fn sorted(triangles: impl IntoIterator<Item = [u32; 3]>) -> Vec<[u32; 3]> {
        let rotations = |[a, b, c]: [u32; 3]| [[a, b, c], [b, c, a], [c, a, b]];
        let least = |triangle| rotations(triangle).into_iter().min().unwrap_or(triangle);
        let mut sorted: Vec<_> = triangles.into_iter().map(least).collect();
        sorted.sort_unstable();
        sorted
    }

    #[test]
    fn all_models_of_the_library_are_compared() {
        for kind in ModelKind::ALL {
            assert!(ComparedModel::ALL.contains(&ComparedModel::Library(kind)), "{kind}");
        }
    }

    proptest! {
        /// The oracle is the set of triangles that the sequence leaves.
        #[test]
        fn every_model_draws_every_level(sample in samples(), jumps in prop::collection::vec(any::<usize>(), 1..99)) {
            let sequence = Arc::new(sample.sequence.clone());
            for model in ComparedModel::ALL {
                let model = model.build(&sample.strips, &sequence).unwrap();
                prop_assert_eq!(model.levels().collapse_count(), sequence.len());
                prop_assert!(model.memory() > 0);
                let mut cursor = model.start();
                for jump in jumps.iter().map(|jump| jump % (sequence.len() + 1)) {
                    cursor.set_level(jump).unwrap();
                    prop_assert_eq!(sorted(cursor.strips().triangles()), sorted(sequence.drawn(jump).unwrap()));
                }
                prop_assert!(cursor.set_level(sequence.len() + 1).is_err());
            }
        }
    }
}
