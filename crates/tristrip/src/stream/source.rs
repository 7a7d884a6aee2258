//! The input of an encoder: a mesh on its grids, and the batches of its splits.

use super::grid::{Channel, Grid};
use super::options::StreamOptions;
use super::plan::Plan;
use crate::collapse::CollapseSequence;
use crate::error::Error;
use crate::mesh::Mesh;
use crate::text::counted;

/// The number of last batches whose positions have all bits.
const EXACT_BATCHES: usize = 2;
/// The maximum error of a position, as a share of the error of its level.
const PRECISION: f64 = 0.5;

/// The input of an encoder.
pub(super) struct StreamSource<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) sequence: &'a CollapseSequence,
    pub(super) plan: Plan,
    pub(super) grid: Grid,
    pub(super) position_bits: u32,
    /// Whether positions have all bits at every level.
    pub(super) is_exact: bool,
    pub(super) channels: Vec<Channel>,
    /// The start and end of each batch, as numbers of collapses from the full mesh, in stream
    /// order.
    pub(super) batches: Vec<[usize; 2]>,
}

impl<'a> StreamSource<'a> {
    pub(super) fn new(
        mesh: &'a Mesh,
        sequence: &'a CollapseSequence,
        level_ends: &[u32],
        options: &StreamOptions,
    ) -> Result<Self, Error> {
        options.check()?;
        if sequence.vertex_count() != mesh.vertex_count() {
            let found = format!("collapses over {}", counted(sequence.vertex_count(), "vertex"));
            return Err(Error::Parameter { name: "sequence", found, expected: "the vertices of the mesh" });
        }
        let plan = Plan::new(sequence);
        let count = sequence.len();
        let mut ends: Vec<usize> = level_ends.iter().map(|&end| (end as usize).min(count)).collect();
        ends.push(count);
        ends.sort_unstable();
        ends.dedup();
        let starts = [0].into_iter().chain(ends.iter().copied());
        let batches = starts
            .zip(&ends)
            .map(|(start, &end)| [start, end])
            .filter(|&[start, end]| plan.end(start) < plan.end(end));
        let mut batches: Vec<[usize; 2]> = batches.collect();
        batches.reverse();
        let used = plan.vertices.iter().map(|&v| mesh.positions()[v as usize]);
        let bounds = options.bounds.into_iter().flatten();
        let grid = Grid::new(used.chain(bounds), options.position_bits);
        if !grid.is_finite(options.position_bits) {
            let found = format!("positions from {:?} on, {} per step", grid.origin, grid.step);
            return Err(Error::Parameter {
                name: "positions",
                found,
                expected: "a grid of finite positions",
            });
        }
        let channels =
            mesh.attributes().iter().map(|attribute| Channel::new(attribute, options.attribute_bits));
        let channels = channels.collect::<Result<Vec<_>, _>>()?;
        if channels.len() > 64 || channels.iter().any(|channel| channel.name.len() > 256) {
            let found = counted(channels.len(), "attribute");
            return Err(Error::Parameter {
                name: "attributes",
                found,
                expected: "at most 64, with names of at most 256 bytes",
            });
        }
        let &StreamOptions { position_bits, exact_positions: is_exact, .. } = options;
        Ok(Self { mesh, sequence, plan, grid, position_bits, is_exact, channels, batches })
    }

    pub(super) fn values(&self, vertex: u32) -> Vec<Vec<i32>> {
        let channels = self.channels.iter().zip(self.mesh.attributes());
        channels.map(|(channel, attribute)| channel.integers(attribute, vertex as usize)).collect()
    }

    pub(super) fn place(&self, fan: u32) -> [i32; 3] {
        self.grid.place(self.mesh.positions()[self.plan.vertices[fan as usize] as usize], self.position_bits)
    }

    /// Returns the error of the surface after this many collapses from the full mesh.
    pub(super) fn error(&self, collapses: usize) -> f32 {
        self.sequence.error(self.sequence.len() - collapses).unwrap_or(0.0)
    }

    /// Returns the number of position bits that are not sent yet in a batch.
    pub(super) fn unknown_bits(&self, batch: usize) -> u32 {
        if self.is_exact || batch + EXACT_BATCHES >= self.batches.len() {
            return 0;
        }
        // Uses the mean error of the collapses that the batch undoes: few places have the largest
        // one.
        let [start, end] = self.batches[batch];
        let level = |collapse: usize| self.sequence.len() - 1 - collapse;
        let errors = (start..end).filter_map(|collapse| self.sequence.collapse(level(collapse)).ok());
        let sum: f64 = errors.map(|collapse| f64::from(collapse.error)).sum();
        let error = sum / (end - start) as f64 * PRECISION;
        let is_enough = |bits: &u32| f64::from(self.grid.error(*bits)) <= error;
        (0..self.position_bits - 3).rev().find(is_enough).unwrap_or(0)
    }
}
