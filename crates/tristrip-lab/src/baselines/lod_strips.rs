//! `LodStrips`: strips as vectors of vertices. Each level has precomputed changes, which are
//! applied and undone in place.
//!
//! # A reconstruction
//! The paper on `LodStrips` was not available. This implementation follows the papers that build on
//! it: each strip is a vector, the changes of all levels are precomputed, and a move to another
//! level applies those in between, one level at a time. Our additions:
//! - A change of a strip lists the slots of its vector that are renamed, and those that are removed
//!   with their vertices. Undoing the change inserts them again. All slots are numbered as before
//!   the collapse.
//! - Vertices are removed as in SETS, which keeps the winding of the triangles; the paper does not
//!   keep it.
//! - It accepts any sequence of collapses; the paper has its own simplification.
//!
//! # References
//! Ramos, Chover: *`LodStrips`: Level of Detail Strips*, 2004. Belmonte, Aguado, Sancho: *Triangle
//! Strip Multiresolution Modelling Using Sorted Edges*, 2006, section 2.
//!
//! # Complexity
//! A move takes one step per changed slot of every level in between. If vertices are removed, the
//! rest of the strip is moved. The bunny's 69,451 triangles take 46 bytes each.

use std::sync::Arc;

use tristrip::lod::strip_graphs::{Csr, NONE, StripState, edits_of};
use tristrip::lod::{LevelCursor, LevelModel, LevelTable};
use tristrip::{CollapseSequence, Error, Rename, Strips};

/// Marks a slot whose vertex is removed. A strip has fewer slots.
const REMOVED: u32 = 1 << 31;

/// Strips at all levels, as vectors and their changes (after Ramos and Chover 2004).
///
/// ```
/// use std::sync::Arc;
/// use tristrip::{CollapseSequence, Rename, Strips};
/// use tristrip::lod::LevelModel;
/// use tristrip_lab::baselines::LodStrips;
/// let mut strips = Strips::default();
/// strips.push(&[0, 1, 2, 3, 4, 5]);
/// let renames = [(2, 3), (0, 1)].map(|(removed, kept)| [Rename { removed, kept }]);
/// let collapses = renames.iter().map(|renames| (&renames[..], 0.5));
/// let sequence = CollapseSequence::from_collapses(6, strips.to_list(), collapses)?;
/// let mut cursor = Arc::new(LodStrips::new(&strips, &sequence)?).start();
/// cursor.set_level(0)?;
/// assert_eq!(cursor.strips().vertices(), [3, 3, 4, 5]);
/// cursor.set_level(1)?;
/// assert_eq!(cursor.strips().vertices(), [0, 1, 3, 3, 4, 5]);
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct LodStrips {
    levels: LevelTable,
    full: Strips,
    /// For each collapse, from the full mesh on, the end of its range of renames and of changes.
    ends: Vec<[u32; 2]>,
    /// The renames of each collapse, sorted by the removed vertex.
    renames: Vec<Rename>,
    /// The strip of each change, and the end of its range of slots.
    changes: Vec<[u32; 2]>,
    places: Vec<Place>,
}

/// A changed slot of the vector of a strip.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Place {
    /// Its index before the collapse, with the bit [`REMOVED`] if it is removed.
    position: u32,
    /// Its vertex before the collapse.
    vertex: u32,
}

impl Place {
    fn position(self) -> usize {
        (self.position & !REMOVED) as usize
    }

    fn is_removed(self) -> bool {
        self.position & REMOVED != 0
    }
}

impl LodStrips {
    /// Builds the model from strips of the full mesh.
    ///
    /// # Errors
    /// A strip has a vertex that is not in the sequence, or the collapses rename too many slots.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let model = Arc::new(LodStrips::new(&strips, &sequence)?);
    /// let mut cursor = model.start();
    /// cursor.set_level(1)?;
    /// assert_eq!(cursor.strips().vertices(), [0, 1, 2, 3]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn new(strips: &Strips, sequence: &CollapseSequence) -> Result<Self, Error> {
        strips.check_vertices(sequence.vertex_count())?;
        if strips.vertices_sent() >= REMOVED as usize {
            let (found, limit) = (strips.vertices_sent() as u64, u64::from(REMOVED));
            return Err(Error::LimitExceeded {
                what: "vertices sent by the strips of lod-strips",
                found,
                limit,
            });
        }
        let edits = edits_of(strips, sequence)?;
        // 1. The slots of each strip, with the step that changes them.
        let mut places: Vec<(u32, (u32, Place))> = Vec::with_capacity(edits.item_count());
        let (mut state, mut live) = (StripState::default(), LiveSlots::default());
        for (number, strip) in (0..).zip(strips.iter()) {
            state.start(strip);
            live.start(strip.len());
            for step in edits.row(number).chunk_by(|a, b| a.step == b.step) {
                for edit in step {
                    let bit = if edit.vertex == NONE { REMOVED } else { 0 };
                    let position = live.count_before(edit.slot as usize) | bit;
                    let vertex = state.vertices[edit.slot as usize];
                    places.push((edit.step - 1, (number, Place { position, vertex })));
                }
                for &edit in step {
                    state.apply(edit);
                    if edit.vertex == NONE {
                        live.remove(edit.slot as usize);
                    }
                }
            }
        }
        // 2. The same slots, grouped by step.
        let by_step = Csr::group_items(places.iter().copied(), sequence.len());
        let mut model = Self {
            levels: LevelTable::of(sequence),
            full: strips.clone(),
            ends: Vec::with_capacity(sequence.len()),
            renames: Vec::new(),
            changes: Vec::new(),
            places: Vec::with_capacity(places.len()),
        };
        for (collapse, row) in sequence.iter().zip(by_step.rows()) {
            let start = model.renames.len();
            model.renames.extend_from_slice(collapse.renames);
            model.renames[start..].sort_unstable_by_key(|rename| rename.removed);
            for change in row.chunk_by(|a, b| a.0 == b.0) {
                model.places.extend(change.iter().map(|&(_, place)| place));
                model.changes.push([change[0].0, model.places.len() as u32]);
            }
            model.ends.push([model.renames.len() as u32, model.changes.len() as u32]);
        }
        Ok(model)
    }

    /// Returns the renames of a collapse and its range of changes, counted from the full mesh.
    fn collapse(&self, number: usize) -> (&[Rename], std::ops::Range<usize>) {
        let start = if number == 0 { [0; 2] } else { self.ends[number - 1] };
        let end = self.ends[number];
        (&self.renames[start[0] as usize..end[0] as usize], start[1] as usize..end[1] as usize)
    }

    /// Returns the strip and the slots of a change.
    fn change(&self, number: usize) -> (usize, &[Place]) {
        let start = if number == 0 { 0 } else { self.changes[number - 1][1] };
        let [strip, end] = self.changes[number];
        (strip as usize, &self.places[start as usize..end as usize])
    }
}

impl LevelModel for LodStrips {
    fn levels(&self) -> &LevelTable {
        &self.levels
    }

    fn memory(&self) -> usize {
        let pairs =
            size_of_val(&self.ends[..]) + size_of_val(&self.changes[..]) + size_of_val(&self.places[..]);
        self.levels.memory() + self.full.memory() + size_of_val(&self.renames[..]) + pairs
    }

    fn start(self: Arc<Self>) -> Box<dyn LevelCursor> {
        Box::new(LodStripsCursor {
            level: self.levels.collapse_count(),
            strips: self.full.iter().map(<[u32]>::to_vec).collect(),
            display: Strips::default(),
            is_current: false,
            model: self,
        })
    }
}

/// The vectors of the strips at one level.
#[derive(Debug, Clone)]
struct LodStripsCursor {
    model: Arc<LodStrips>,
    level: usize,
    strips: Vec<Vec<u32>>,
    display: Strips,
    is_current: bool,
}

impl LodStripsCursor {
    /// Applies the changes of a collapse, counted from the full mesh.
    fn make(&mut self, number: usize) {
        let (renames, changes) = self.model.collapse(number);
        for change in changes {
            let (strip, places) = self.model.change(change);
            let vertices = &mut self.strips[strip];
            let mut removed = 0;
            for (i, place) in places.iter().enumerate() {
                let position = place.position();
                if place.is_removed() {
                    // Shift the kept slots before the next removed slot to the left.
                    let next = places[i + 1..].iter().find(|next| next.is_removed());
                    let end = next.map_or(vertices.len(), |next| next.position());
                    vertices.copy_within(position + 1..end, position - removed);
                    removed += 1;
                } else if let Ok(found) = renames.binary_search_by_key(&place.vertex, |rename| rename.removed)
                {
                    vertices[position - removed] = renames[found].kept;
                }
            }
            vertices.truncate(vertices.len() - removed);
        }
    }

    /// Undoes the changes of a collapse.
    fn undo(&mut self, number: usize) {
        let (_, changes) = self.model.collapse(number);
        for change in changes {
            let (strip, places) = self.model.change(change);
            let vertices = &mut self.strips[strip];
            let mut left = places.iter().filter(|place| place.is_removed()).count();
            let mut end = vertices.len();
            vertices.resize(end + left, 0);
            for place in places.iter().rev().filter(|place| place.is_removed()) {
                let start = place.position() + 1 - left;
                vertices.copy_within(start..end, start + left);
                end = start;
                left -= 1;
            }
            places.iter().for_each(|place| vertices[place.position()] = place.vertex);
        }
    }
}

impl LevelCursor for LodStripsCursor {
    fn levels(&self) -> &LevelTable {
        &self.model.levels
    }

    fn level(&self) -> usize {
        self.level
    }

    fn set_level(&mut self, level: usize) -> Result<(), Error> {
        self.model.levels.check(level)?;
        let full = self.model.levels.collapse_count();
        self.is_current &= level == self.level;
        for number in full - self.level..full - level.min(self.level) {
            self.make(number);
        }
        for number in (full - level.max(self.level)..full - self.level).rev() {
            self.undo(number);
        }
        self.level = level;
        Ok(())
    }

    fn strips(&mut self) -> &Strips {
        if !self.is_current {
            self.display.clear();
            self.strips.iter().filter(|strip| !strip.is_empty()).for_each(|strip| self.display.push(strip));
            self.is_current = true;
        }
        &self.display
    }

    fn memory(&self) -> usize {
        let vectors: usize = self.strips.iter().map(|strip| 4 * strip.capacity()).sum();
        vectors + size_of_val(&self.strips[..]) + self.display.memory()
    }
}

/// The slots of a strip that are not removed, as a Fenwick tree.
#[derive(Debug, Default)]
struct LiveSlots {
    /// Item i counts the present slots in a range that ends with slot i − 1. Its length is the
    /// lowest set bit of i.
    tree: Vec<u32>,
}

impl LiveSlots {
    /// Marks all slots as present.
    fn start(&mut self, slot_count: usize) {
        self.tree.clear();
        self.tree.extend((0..=slot_count).map(|i| (i & i.wrapping_neg()) as u32));
    }

    fn remove(&mut self, slot: usize) {
        let mut i = slot + 1;
        while let Some(count) = self.tree.get_mut(i) {
            *count -= 1;
            i += i & i.wrapping_neg();
        }
    }

    fn count_before(&self, slot: usize) -> u32 {
        let (mut count, mut i) = (0, slot);
        while i > 0 {
            count += self.tree[i];
            i &= i - 1;
        }
        count
    }
}
