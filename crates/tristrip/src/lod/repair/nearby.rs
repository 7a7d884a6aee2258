//! Finds the triangles near a change, where `repair` starts its local searches.

use crate::cover::priced::PricedPaths;

/// Collects the triangles near a change in breadth-first order.
#[derive(Debug, Clone, Default)]
pub(super) struct NearbyTriangles {
    pub(super) triangles: Vec<u32>,
    /// The last search that reached each triangle.
    marks: Vec<u32>,
    search: u32,
}

impl NearbyTriangles {
    /// Prepares searches among this many triangles.
    pub(super) fn among(triangle_count: usize) -> Self {
        Self { marks: vec![0; triangle_count], ..Self::default() }
    }

    /// Prepares searches among more triangles.
    pub(super) fn grow(&mut self, triangle_count: usize) {
        self.marks.resize(triangle_count, self.search);
    }

    /// Returns the memory in bytes.
    pub(super) fn memory(&self) -> usize {
        size_of_val(&self.marks[..]) + size_of_val(&self.triangles[..])
    }

    /// Finds up to `most` triangles nearest to the start triangles, including these.
    pub(super) fn find(&mut self, paths: &PricedPaths, mut start: impl Iterator<Item = u32>, most: usize) {
        self.search = self.search.wrapping_add(1);
        self.triangles.clear();
        // The start can be all triangles around a vertex of high valence.
        while self.triangles.len() < most
            && let Some(t) = start.next()
        {
            self.add(t);
        }
        let mut seen = 0;
        while seen < self.triangles.len() && self.triangles.len() < most {
            let t = self.triangles[seen];
            (0..3).filter_map(|e| paths.twin(4 * t + e)).for_each(|h| self.add(h / 4));
            seen += 1;
        }
        self.triangles.truncate(most);
    }

    fn add(&mut self, t: u32) {
        if std::mem::replace(&mut self.marks[t as usize], self.search) != self.search {
            self.triangles.push(t);
        }
    }
}
