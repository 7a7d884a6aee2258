//! A grid of cells that finds the positions within a distance of a given position.
//!
//! In files from scanners and CAD programs, the positions on the two sides of a border differ
//! slightly. To find the other side, each position is looked up in the grid before it is inserted.
//!
//! # Complexity
//! Constant time per position. A cell is [`CELL`] times as wide as the distance, so most lookups
//! visit one cell and a few visit up to eight. At most [`MAX_IN_CELL`] positions are compared per
//! cell. About 60 bytes per position.

use std::collections::HashMap;

use crate::error::Error;
use crate::ids::{OptionalId, check_count};

/// Width of a cell, in multiples of the distance.
const CELL: f64 = 16.0;

/// Maximum number of positions compared per cell, latest first. A cell contains more only if the
/// distance is several times the spacing of the positions.
const MAX_IN_CELL: usize = 1024;

/// Positions that can be looked up by distance.
///
/// ```
/// use tristrip::NearPositions;
/// let mut grid = NearPositions::new(0.5)?;
/// grid.insert(7, [1.0, 0.0, 0.0])?;
/// assert_eq!(grid.near([1.0, 0.0, 0.25]).collect::<Vec<_>>(), [(0.25, 7)]);
/// assert_eq!(grid.near([1.0, 0.0, 0.75]).count(), 0);
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug)]
pub struct NearPositions {
    distance: f64,
    /// The latest position of each cell. A random hash seed protects against files with colliding
    /// cells; no result depends on it.
    latest: HashMap<[u64; 3], OptionalId>,
    entries: Vec<CellEntry>,
}

#[derive(Debug)]
struct CellEntry {
    number: u32,
    position: [f32; 3],
    /// The previous entry of the same cell.
    before: OptionalId,
}

impl NearPositions {
    /// Creates an empty grid for a distance, in the unit of the positions.
    ///
    /// # Errors
    /// The distance is not a positive finite number.
    ///
    /// ```
    /// use tristrip::NearPositions;
    /// assert!(NearPositions::new(1e-6).is_ok() && NearPositions::new(0.0).is_err());
    /// ```
    pub fn new(distance: f32) -> Result<Self, Error> {
        if !distance.is_finite() || distance <= 0.0 {
            let (found, expected) = (distance.to_string(), "a finite number above 0");
            return Err(Error::Parameter { name: "distance", found, expected });
        }
        Ok(Self { distance: distance.into(), latest: HashMap::new(), entries: Vec::new() })
    }

    /// Adds a position with a number chosen by the caller.
    ///
    /// # Errors
    /// There are too many positions for 32-bit indices.
    ///
    /// ```
    /// let mut grid = tristrip::NearPositions::new(2.0)?;
    /// [0.0, 1.0, 9.0].into_iter().zip(0..).try_for_each(|(x, number)| grid.insert(number, [x, 0.0, 0.0]))?;
    /// assert_eq!(grid.near([0.0; 3]).count(), 2);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn insert(&mut self, number: u32, position: [f32; 3]) -> Result<(), Error> {
        check_count("positions", self.entries.len() + 1)?;
        let entry = OptionalId::some(self.entries.len() as u32);
        let before = self.latest.insert(position.map(|x| self.cell(x.into())), entry);
        self.entries.push(CellEntry { number, position, before: before.unwrap_or(OptionalId::NONE) });
        Ok(())
    }

    /// Iterates over the positions within the distance, as pairs of a distance and a number, in no
    /// particular order. In cells with more than 1024 positions, only the latest 1024 are compared.
    ///
    /// ```
    /// let mut grid = tristrip::NearPositions::new(1.0)?;
    /// grid.insert(3, [0.0; 3])?;
    /// assert_eq!(grid.near([0.0, 1.0, 0.0]).min_by(|a, b| a.0.total_cmp(&b.0)), Some((1.0, 3)));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn near(&self, position: [f32; 3]) -> impl Iterator<Item = (f64, u32)> {
        let p = position.map(f64::from);
        // One cell along each axis, or two if a border between cells is within the distance.
        let [x, y, z] = p.map(|x| {
            let [low, high] = [x - self.distance, x + self.distance].map(|x| self.cell(x));
            std::iter::once(low).chain((high != low).then_some(high))
        });
        let cells = x.flat_map(move |x| {
            let z = z.clone();
            y.clone().flat_map(move |y| z.clone().map(move |z| [x, y, z]))
        });
        cells.flat_map(|cell| self.entries_of(cell)).filter_map(move |entry| {
            let other = entry.position.map(f64::from);
            let square: f64 = (0..3).map(|k| (p[k] - other[k]).powi(2)).sum();
            let distance = square.sqrt();
            (distance <= self.distance).then_some((distance, entry.number))
        })
    }

    /// Iterates over the latest positions of a cell.
    fn entries_of(&self, cell: [u64; 3]) -> impl Iterator<Item = &CellEntry> {
        let entry = |id: OptionalId| Some(&self.entries[id.get()? as usize]);
        let latest = self.latest.get(&cell).copied().and_then(entry);
        std::iter::successors(latest, move |at| entry(at.before)).take(MAX_IN_CELL)
    }

    /// Returns the cell of a coordinate. Where cells are narrower than the spacing of floats, each
    /// coordinate has its own cell.
    fn cell(&self, x: f64) -> u64 {
        // Adding 0.0 turns −0.0 into 0.0.
        ((x / (CELL * self.distance)).floor() + 0.0).to_bits()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn grid(distance: f32, positions: &[[f32; 3]]) -> NearPositions {
        let mut grid = NearPositions::new(distance).unwrap();
        positions.iter().zip(0..).for_each(|(&p, number)| grid.insert(number, p).unwrap());
        grid
    }

    fn found(grid: &NearPositions, position: [f32; 3]) -> Vec<u32> {
        let mut found: Vec<u32> = grid.near(position).map(|(_, number)| number).collect();
        found.sort_unstable();
        found
    }

    proptest! {
        #[test]
        fn finds_what_a_search_of_all_finds(
            positions in prop::collection::vec([-40..40_i8, -40..40, -1..1].prop_map(|p| p.map(|x| f32::from(x) / 4.0)), 1..60),
            distance in 1..80_u8,
        ) {
            let distance = f32::from(distance) / 16.0;
            let grid = grid(distance, &positions);
            for p in &positions {
                let near = |q: &[f32; 3]| {
                    let square: f32 = (0..3).map(|k| (p[k] - q[k]).powi(2)).sum();
                    square <= distance * distance
                };
                let expected: Vec<u32> = (0..).zip(&positions).filter(|(_, q)| near(q)).map(|(i, _)| i).collect();
                prop_assert_eq!(found(&grid, *p), expected);
            }
        }
    }

    #[test]
    fn extreme_distances_and_positions_are_found() {
        let far = [f32::MAX, f32::MIN, 0.0];
        for distance in [f32::from_bits(1), 1e-30, 1.0, f32::MAX] {
            let grid = grid(distance, &[far, [0.0; 3], [-0.0; 3]]);
            assert!(found(&grid, far).contains(&0), "{distance}");
            assert!(found(&grid, [0.0; 3]).ends_with(&[1, 2]), "{distance}");
        }
        for wrong in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert!(NearPositions::new(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn crowded_cells_take_linear_time() {
        let positions: Vec<[f32; 3]> = (0..30_000).map(|i| [i as f32 / 30_000.0, 0.0, 0.0]).collect();
        let grid = grid(1.0, &positions);
        assert!(positions.iter().all(|&p| grid.near(p).count() <= 8 * MAX_IN_CELL));
    }
}
