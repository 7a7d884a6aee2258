//! The state of each fan of a mesh during refinement: its position, and a summary of the fans
//! around it.

use super::surface::NONE;

/// A position on the grid of the stream.
pub(super) type GridPlace = [i32; 3];

/// Returns the squared distance of two positions.
#[inline]
pub(super) fn square_distance(a: GridPlace, b: GridPlace) -> u64 {
    let square = |j: usize| {
        let difference = i64::from(a[j] - b[j]);
        (difference * difference).cast_unsigned()
    };
    square(0) + square(1) + square(2)
}

/// The state of a fan. Two of them fit into a cache line: decoding spends most of its time on
/// fetching them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(align(32))]
pub(super) struct SurfaceFan {
    /// Its position, in steps of the current precision.
    place: [u16; 3],
    /// The number of neighbouring fans, modulo 2¹⁶, and the sum of their positions, modulo 2³².
    pub(super) count: u16,
    sum: [i32; 3],
    /// The fan that a batch visits next, or [`NONE`].
    pub(super) next: u32,
    /// The batch that created it, modulo 2⁸; 0 for the base mesh.
    pub(super) born: u8,
    /// The number of corners that a batch has used, at most 255, and the index of that batch.
    used: u8,
    used_in: u32,
    pub(super) is_open: bool,
}

impl SurfaceFan {
    /// Creates a fan in a batch, without neighbours.
    #[inline]
    pub(super) fn new(place: GridPlace, batch: u32, is_open: bool) -> Self {
        let mut fan = Self {
            place: [0; 3],
            count: 0,
            sum: [0; 3],
            next: NONE,
            born: batch as u8,
            used: 0,
            used_in: batch,
            is_open,
        };
        fan.set_place(place);
        fan
    }

    #[inline]
    pub(super) fn place(&self) -> GridPlace {
        let [x, y, z] = self.place;
        [x.into(), y.into(), z.into()]
    }

    #[inline]
    pub(super) fn set_place(&mut self, place: GridPlace) {
        for j in 0..3 {
            self.place[j] = place[j].cast_unsigned() as u16;
        }
    }

    /// Removes all neighbours from the summary.
    pub(super) fn clear(&mut self) {
        (self.sum, self.count) = ([0; 3], 0);
    }

    /// Adds the summed positions of some neighbours, and their number.
    #[inline]
    pub(super) fn add(&mut self, places: GridPlace, count: u32) {
        for j in 0..3 {
            self.sum[j] = self.sum[j].wrapping_add(places[j]);
        }
        self.count = self.count.wrapping_add(count as u16);
    }

    /// Returns the number of corners that a batch has used, at most 255.
    #[inline]
    pub(super) fn used(&self, batch: u32) -> u32 {
        if self.used_in == batch { self.used.into() } else { 0 }
    }

    /// Adds corners that a batch has used, and subtracts those that were counted before.
    #[inline]
    pub(super) fn use_corners(&mut self, batch: u32, count: u32, too_many: u32) {
        self.used = (self.used(batch) + count).min(255).saturating_sub(too_many) as u8;
        self.used_in = batch;
    }

    /// Returns the difference of the position from the mean of its neighbours, times their number.
    #[inline]
    pub(super) fn laplacian(&self) -> GridPlace {
        let mut laplacian = [0; 3];
        for j in 0..3 {
            laplacian[j] = i32::from(self.place[j]).wrapping_mul(self.count.into()).wrapping_sub(self.sum[j]);
        }
        laplacian
    }
}
