//! Replay: the entries of an index map at a level, and the records by which collapses and splits rename them.

use super::index_map::RESTART;
use crate::error::Error;

/// The most places that a model may have for each entry of its map, on the average over all collapses: meshes have about
/// five, a hostile sequence has as many as there are collapses.
const MOST_PLACES_PER_ENTRY: usize = 256;

/// What a vertex split writes: one vertex, at some places of the index map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Update<'a> {
    /// The vertex that comes back.
    pub vertex: u32,
    /// Its places in the index map, counted from 0, rising.
    pub places: &'a [u32],
}

/// Entries of a map at a level, and what leads to other levels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Replay {
    pub(super) entries: Vec<u32>,
    pub(super) level: usize,
    pub(super) records: Records,
}

impl Replay {
    pub(super) fn refine(&mut self) -> bool {
        if self.level == self.records.len() {
            return false;
        }
        for update in self.records.split(self.level) {
            update.places.iter().for_each(|&place| self.entries[place as usize] = update.vertex);
        }
        self.level += 1;
        true
    }

    pub(super) fn coarsen(&mut self) -> bool {
        if self.level == 0 {
            return false;
        }
        self.level -= 1;
        let range = self.records.places_of(self.level);
        for (&place, &entry) in self.records.places[range.clone()].iter().zip(&self.records.coarse[range]) {
            self.entries[place as usize] = entry;
        }
        true
    }

    pub(super) fn go_to(&mut self, level: usize) {
        assert!(level <= self.records.len(), "level {level} of {}", self.records.len());
        while self.level < level {
            self.refine();
        }
        while self.level > level {
            self.coarsen();
        }
    }
}

/// What the collapses write, and over what, in the order from the full mesh to the base mesh.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Records {
    /// End of each collapse among the vertices.
    vertex_ends: Vec<u32>,
    /// The vertices removed.
    pub(super) vertices: Vec<u32>,
    /// End of each vertex among the places.
    place_ends: Vec<u32>,
    pub(super) places: Vec<u32>,
    /// What the collapse writes at each place.
    coarse: Vec<u32>,
}

impl Records {
    pub(super) fn len(&self) -> usize {
        self.vertex_ends.len()
    }

    pub(super) fn vertices_of(&self, level: usize) -> std::ops::Range<usize> {
        range(&self.vertex_ends, self.len() - 1 - level)
    }

    pub(super) fn places_of(&self, level: usize) -> std::ops::Range<usize> {
        let vertices = self.vertices_of(level);
        let end = |i: usize| if i == 0 { 0 } else { self.place_ends[i - 1] as usize };
        end(vertices.start)..end(vertices.end)
    }

    pub(super) fn split(&self, level: usize) -> impl ExactSizeIterator<Item = Update<'_>> {
        self.vertices_of(level)
            .map(|i| Update { vertex: self.vertices[i], places: &self.places[range(&self.place_ends, i)] })
    }

    /// Adds a removed vertex and what is written over it, places rising, to the collapse that is not ended yet.
    pub(super) fn push(&mut self, vertex: u32, written: impl Iterator<Item = (u32, u32)>) {
        self.vertices.push(vertex);
        for (place, entry) in written {
            self.places.push(place);
            self.coarse.push(entry);
        }
        self.place_ends.push(self.places.len() as u32);
    }

    /// Ends a collapse, unless there are too many places for a map of so many entries.
    pub(super) fn end(&mut self, entry_count: usize) -> Result<(), Error> {
        self.vertex_ends.push(self.vertices.len() as u32);
        let limit = entry_count.saturating_mul(MOST_PLACES_PER_ENTRY).min(u32::MAX as usize);
        if self.places.len() > limit {
            let (found, limit) = (self.places.len() as u64, limit as u64);
            return Err(Error::LimitExceeded { what: "places of all collapses", found, limit });
        }
        Ok(())
    }
}

fn range(ends: &[u32], i: usize) -> std::ops::Range<usize> {
    if i == 0 { 0..ends[0] as usize } else { ends[i - 1] as usize..ends[i] as usize }
}

/// The places of each vertex, as lists through the map, to be taken and joined.
pub(super) struct Places {
    /// First place of each vertex, plus one; 0 where there is none.
    first: Vec<u32>,
    /// The next place of the same vertex after each one, plus one.
    next: Vec<u32>,
}

impl Places {
    /// Lists the places of a map that pass a test.
    pub(super) fn of(map: &[u32], vertex_count: usize, is_listed: impl Fn(usize) -> bool) -> Self {
        let mut places = Self { first: vec![0; vertex_count], next: vec![0; map.len()] };
        for (place, &vertex) in map.iter().enumerate().rev() {
            if vertex != RESTART && is_listed(place) {
                places.add(vertex, place as u32);
            }
        }
        places
    }

    pub(super) fn add(&mut self, vertex: u32, place: u32) {
        self.next[place as usize] = std::mem::replace(&mut self.first[vertex as usize], place + 1);
    }

    /// Takes all places of a vertex, rising.
    pub(super) fn take(&mut self, vertex: u32, taken: &mut Vec<u32>) {
        taken.clear();
        let mut place = std::mem::take(&mut self.first[vertex as usize]);
        while place > 0 {
            taken.push(place - 1);
            place = self.next[place as usize - 1];
        }
        taken.sort_unstable();
    }
}
