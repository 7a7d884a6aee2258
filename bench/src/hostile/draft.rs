//! A mesh under construction: positions, polygons, and the order of its faces.

use tristrip::random::Random;
use tristrip::{Error, Faces, Mesh};

/// The order of faces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// As built.
    Built,
    /// In random order.
    Shuffled,
    /// In the order of bit-reversed face indices: neighbours are far apart at every scale.
    BitReversed,
}

/// The triangulation of quadrilaterals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Cut {
    /// None.
    Quads,
    /// From the first corner to the third.
    Regular,
    /// Along a random diagonal.
    Random,
}

/// A named shape, built from a number of triangles.
pub(super) type Shape = (&'static str, fn(u32) -> Draft);

/// A mesh under construction.
#[derive(Debug, Clone)]
pub struct Draft {
    positions: Vec<[f32; 3]>,
    corners: Vec<u32>,
    offsets: Vec<u32>,
    random: Random,
}

impl Draft {
    pub(super) fn new() -> Self {
        Self { positions: Vec::new(), corners: Vec::new(), offsets: vec![0], random: Random::new(1) }
    }

    /// Adds a vertex. Returns its index.
    pub(super) fn vertex(&mut self, position: [f32; 3]) -> u32 {
        self.positions.push(position);
        self.positions.len() as u32 - 1
    }

    /// Adds `count` vertices at the positions of a function of their index.
    pub(super) fn vertices(&mut self, count: u32, position: impl Fn(u32) -> [f32; 3]) -> u32 {
        let first = self.positions.len() as u32;
        self.positions.extend((0..count).map(position));
        first
    }

    pub(super) fn vertex_count(&self) -> u32 {
        self.positions.len() as u32
    }

    /// Adds a face.
    pub(super) fn face(&mut self, corners: impl IntoIterator<Item = u32>) {
        self.corners.extend(corners);
        self.offsets.push(self.corners.len() as u32);
    }

    /// Adds a quadrilateral, triangulated or not.
    pub(super) fn quad(&mut self, [a, b, c, d]: [u32; 4], cut: Cut) {
        match cut {
            Cut::Quads => self.face([a, b, c, d]),
            Cut::Random if self.below(2) == 1 => {
                self.face([a, b, d]);
                self.face([b, c, d]);
            }
            Cut::Regular | Cut::Random => {
                self.face([a, b, c]);
                self.face([a, c, d]);
            }
        }
    }

    /// Returns a random number below a limit.
    pub(super) fn below(&mut self, limit: u32) -> u32 {
        self.random.below(limit as usize) as u32
    }

    fn face_count(&self) -> usize {
        self.offsets.len() - 1
    }

    fn face_at(&self, face: usize) -> &[u32] {
        &self.corners[self.offsets[face] as usize..self.offsets[face + 1] as usize]
    }

    /// Adds every face `times` more times, reversed if `is_reversed`.
    pub(super) fn repeated(mut self, times: usize, is_reversed: bool) -> Self {
        let count = self.face_count();
        for _ in 0..times {
            for face in 0..count {
                let mut corners = self.face_at(face).to_vec();
                if is_reversed {
                    corners.reverse();
                }
                self.face(corners);
            }
        }
        self
    }

    /// Reverses every second face.
    pub(super) fn with_alternate_winding(mut self) -> Self {
        for pair in self.offsets.windows(2).step_by(2) {
            self.corners[pair[0] as usize..pair[1] as usize].reverse();
        }
        self
    }

    /// Changes the order of the faces.
    pub(super) fn in_order(mut self, order: Order) -> Self {
        let mut faces: Vec<u32> = (0..self.face_count() as u32).collect();
        match order {
            Order::Built => return self,
            Order::BitReversed => faces.sort_by_key(|face| face.reverse_bits()),
            Order::Shuffled => {
                (1..faces.len()).rev().for_each(|i| faces.swap(i, self.random.below(i + 1)));
            }
        }
        let mut ordered = Self { positions: std::mem::take(&mut self.positions), ..Self::new() };
        faces.iter().for_each(|&face| ordered.face(self.face_at(face as usize).iter().copied()));
        ordered
    }

    /// Returns the mesh.
    ///
    /// # Errors
    /// There are too many corners for 32-bit ids.
    pub fn into_mesh(self) -> Result<Mesh, Error> {
        Mesh::new(self.positions, Faces::from_offsets(self.offsets, self.corners)?)
    }
}
