//! The levels of a model: the collapses of all its parts, merged into one order.

use std::collections::BTreeMap;

use tristrip::CollapseSequence;

use crate::error::Error;

/// The collapses of a part.
#[derive(Debug, Clone)]
pub(crate) struct PartCollapses {
    /// The collapses, with errors in the scene at the largest scale of the part.
    pub(crate) sequence: CollapseSequence,
    /// The first part of its group, which is simplified as one surface.
    pub(crate) group: usize,
    /// For each collapse, the index of its step in the group.
    pub(crate) steps: Vec<u32>,
    /// For each collapse, the maximum cost so far of the steps of the group, in the scene.
    pub(crate) costs: Vec<f64>,
}

impl PartCollapses {
    /// Returns the collapses to a level, which becomes the base mesh.
    pub(crate) fn with_base(mut self, level: usize) -> Result<Self, Error> {
        self.sequence = self.sequence.with_base(level)?;
        self.steps.truncate(self.sequence.len());
        self.costs.truncate(self.sequence.len());
        Ok(self)
    }
}

/// The merged order of the collapses of all parts of a model. They are sorted by cost, so all parts
/// have about the same error at every level. Collapses of several parts that close a border
/// together form one level, so no level has gaps.
///
/// Memory: 8 bytes per collapse.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct LevelOrder {
    /// The number of collapses of each part.
    lengths: Vec<usize>,
    /// The parts of each collapse, from the full mesh to the base mesh.
    parts: Vec<u32>,
    /// For each collapse, the end of its range in `parts`.
    ends: Vec<u32>,
}

impl LevelOrder {
    /// Orders the collapses of all parts.
    pub(crate) fn new(done: &[PartCollapses]) -> Self {
        let mut groups: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
        (0..).zip(done).for_each(|(part, done)| groups.entry(done.group).or_default().push(part));
        // Each collapse with its cost, and its parts in `flat`.
        let (mut steps, mut flat): (Vec<(f64, u32, u32)>, Vec<u32>) = (Vec::new(), Vec::new());
        for group in groups.into_values() {
            let mut of_group: Vec<(u32, u32, f64)> = Vec::new();
            for part in group {
                let PartCollapses { steps, costs, .. } = &done[part as usize];
                of_group.extend(steps.iter().zip(costs).map(|(&step, &cost)| (step, part, cost)));
            }
            of_group.sort_unstable_by_key(|&(step, part, _)| (step, part));
            for together in of_group.chunk_by(|a, b| a.0 == b.0) {
                let start = flat.len() as u32;
                flat.extend(together.iter().map(|&(_, part, _)| part));
                steps.push((together[0].2, start, flat.len() as u32));
            }
        }
        steps.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut parts, mut ends) = (Vec::with_capacity(flat.len()), Vec::with_capacity(steps.len()));
        for (_, start, end) in steps {
            parts.extend_from_slice(&flat[start as usize..end as usize]);
            ends.push(parts.len() as u32);
        }
        Self { lengths: done.iter().map(|done| done.sequence.len()).collect(), parts, ends }
    }

    /// Returns the number of collapses, which is the level of the full model.
    pub(crate) fn collapse_count(&self) -> usize {
        self.ends.len()
    }

    /// Returns the level of each part at a level of the model, in linear time.
    ///
    /// # Errors
    /// [`Error::Level`]: the model does not have this level.
    pub fn of_parts(&self, level: usize) -> Result<Vec<usize>, Error> {
        let last = self.collapse_count();
        let undone = last.checked_sub(level).ok_or(Error::Level { found: level, last })?;
        let mut levels = self.lengths.clone();
        let end = if undone == 0 { 0 } else { self.ends[undone - 1] as usize };
        self.parts[..end].iter().for_each(|&part| levels[part as usize] -= 1);
        Ok(levels)
    }

    /// Returns the highest level with at most this number of triangles, or 0 if there is none.
    /// Takes linear time.
    pub(crate) fn level_of_triangles(
        &self,
        done: &[PartCollapses],
        triangle_count: usize,
    ) -> Result<usize, Error> {
        let full = done.iter().zip(&self.lengths).map(|(done, &level)| done.sequence.triangle_count(level));
        let mut left = full.sum::<Result<usize, _>>()?;
        let (mut levels, mut level) = (self.lengths.clone(), self.collapse_count());
        for parts in self.parts_from_full() {
            if left <= triangle_count {
                break;
            }
            for &part in parts {
                let part = part as usize;
                levels[part] -= 1;
                left -= done[part].sequence.collapse(levels[part])?.dropped.len();
            }
            level -= 1;
        }
        Ok(level)
    }

    /// Returns the parts of a collapse, counted from the full model. The collapse must exist.
    pub(crate) fn parts_of(&self, number: usize) -> &[u32] {
        let start = if number == 0 { 0 } else { self.ends[number - 1] as usize };
        &self.parts[start..self.ends[number] as usize]
    }

    /// Iterates over the parts of each collapse, from the full model to the base meshes.
    pub fn parts_from_full(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(&0).chain(&self.ends);
        starts.zip(&self.ends).map(|(&start, &end)| &self.parts[start as usize..end as usize])
    }

    /// Returns the levels at the ends of `steps` equal steps from the base mesh to the full mesh,
    /// without repeats. At least one step is used.
    pub fn evenly(&self, steps: usize) -> Vec<usize> {
        let (steps, last) = (steps.max(1), self.collapse_count());
        let mut levels: Vec<usize> = (0..=steps).map(|step| (last * step + steps / 2) / steps).collect();
        levels.dedup();
        levels
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tristrip::{CollapseSequence, Rename};

    /// Returns a part of a group, with collapses along the rim of a fan that have the given costs.
    fn fan(costs: &[f64], group: usize, steps: Option<&[u32]>) -> PartCollapses {
        let corners = costs.len() as u32 + 3;
        let triangles = (0..corners - 1).flat_map(|i| [i, i + 1, corners]).collect();
        let renames: Vec<[Rename; 1]> =
            (0..costs.len() as u32).map(|i| [Rename { removed: i, kept: i + 1 }]).collect();
        let collapses = renames.iter().map(|rename| (&rename[..], 0.0));
        let sequence = CollapseSequence::from_collapses(corners as usize + 1, triangles, collapses).unwrap();
        let all: Vec<u32> = (0..costs.len() as u32).collect();
        let steps = steps.unwrap_or(&all).to_vec();
        PartCollapses { sequence, group, steps, costs: costs.to_vec() }
    }

    #[test]
    fn collapses_of_all_parts_are_ordered_by_cost() {
        let levels = LevelOrder::new(&[fan(&[1.0, 4.0, 4.0], 0, None), fan(&[2.0, 3.0, 5.0], 1, None)]);
        let all: Vec<_> = (0..=6).rev().map(|level| levels.of_parts(level).unwrap()).collect();
        assert_eq!(all, [[3, 3], [2, 3], [2, 2], [2, 1], [1, 1], [0, 1], [0, 0]]);
        assert!(matches!(levels.of_parts(7), Err(Error::Level { found: 7, last: 6 })));
        assert_eq!(levels.evenly(3), [0, 2, 4, 6]);
        assert_eq!(levels.evenly(20), [0, 1, 2, 3, 4, 5, 6]);
        assert_eq!(LevelOrder::new(&[]).evenly(20), [0]);
    }

    #[test]
    fn collapses_that_close_a_border_together_are_one_level() {
        // Step 1 of the group of parts 0 and 2 collapses in both.
        let levels = LevelOrder::new(&[
            fan(&[1.0, 4.0], 0, Some(&[0, 1])),
            fan(&[2.0], 1, None),
            fan(&[4.0, 4.0], 0, Some(&[1, 2])),
        ]);
        let all: Vec<_> = (0..=4).rev().map(|level| levels.of_parts(level).unwrap()).collect();
        assert_eq!(all, [[2, 1, 2], [1, 1, 2], [1, 0, 2], [0, 0, 1], [0, 0, 0]]);
        assert_eq!(levels.parts_from_full().collect::<Vec<_>>(), [&[0][..], &[1], &[0, 2], &[2]]);
    }
}
