//! Encodes progressive strips: vertices are numbered in sending order, then header, base mesh and
//! records are written.

use std::sync::Arc;

use super::layout::{Header, POSITION_BYTES, Sizes, Width};
use tristrip::CollapseSequence;
use tristrip::Strips;
use tristrip::lod::{
    Encoding, LevelCursor, LevelModel, ProgressiveStrips, RESTART, SlotUpdate, encoded_offset,
};
use tristrip::{Error, MeshProblem};

/// The bytes of progressive strips.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Encoded {
    /// The encoded bytes.
    pub bytes: Vec<u8>,
    /// For each sent vertex, in sending order, the vertex of the mesh.
    pub vertices: Vec<u32>,
    /// The size of each section.
    pub sizes: Sizes,
}

/// Encodes the strips of a mesh and its collapses, with one position per vertex of the sequence.
/// The output is deterministic.
///
/// # Errors
/// The number of positions differs from the number of vertices, a sent position is not finite, a
/// collapse renames no vertex, or [`ProgressiveStrips::new`] fails.
///
/// ```
/// use tristrip::lod::Encoding;
/// use tristrip_lab::wire::{WireDecoder, encode};
/// use tristrip::{CollapseSequence, Rename, Strips};
/// let mut strips = Strips::default();
/// strips.push(&[0, 1, 2, 3]);
/// let rename = [Rename { removed: 3, kept: 2 }];
/// let sequence = CollapseSequence::from_collapses(4, strips.to_list(), [(&rename[..], 0.5)])?;
/// let positions = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]];
///
/// let encoded = encode(&strips, &sequence, &positions, Encoding::Offsets)?;
/// let mut decoder = WireDecoder::default();
/// decoder.update(&encoded.bytes)?;
/// assert_eq!((decoder.level(), decoder.strips().vertices()), (Some(1), &[0, 1, 2, 3][..]));
/// assert_eq!(decoder.positions(), positions);
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn encode(
    strips: &Strips,
    sequence: &CollapseSequence,
    positions: &[[f32; 3]],
    encoding: Encoding,
) -> Result<Encoded, Error> {
    check_count(positions, sequence.vertex_count())?;
    let model = Arc::new(ProgressiveStrips::new(strips, sequence, encoding)?);
    let mut cursor = model.cursor();
    cursor.set_level(0)?;
    let base = cursor.entries();

    let numbers = Numbers::of(base, &model, sequence.vertex_count());
    check_sent(positions, &numbers.vertices)?;
    let restored_count = numbers.vertices.len() - numbers.base_count;
    let header = Header::of_counts([numbers.base_count, base.len(), sequence.len(), restored_count])?;

    let mut bytes = Vec::new();
    header.append(&mut bytes);
    let base_vertices = &numbers.vertices[..numbers.base_count];
    base_vertices.iter().for_each(|&vertex| append_position(positions[vertex as usize], &mut bytes));
    let width = header.entry_width();
    base.iter().for_each(|&entry| width.append(numbers.entry(entry), &mut bytes));
    for level in 0..sequence.len() {
        if let Some(updates) = model.split(level) {
            append_split(updates, level, positions, header.slot_width(), &mut bytes)?;
        }
    }
    let sizes = Sizes::of(&header, numbers.base_count, base.len(), bytes.len() as u64);
    Ok(Encoded { bytes, vertices: numbers.vertices, sizes })
}

/// The order in which vertices are sent.
#[derive(Debug)]
struct Numbers {
    /// The vertices in this order.
    vertices: Vec<u32>,
    /// The number of these vertices that are in the base map.
    base_count: usize,
    /// The new index of each vertex; `RESTART` if it has none.
    number_of: Vec<u32>,
}

impl Numbers {
    fn of(base: &[u32], model: &ProgressiveStrips, vertex_count: usize) -> Self {
        let mut numbers =
            Self { vertices: Vec::new(), base_count: 0, number_of: vec![RESTART; vertex_count] };
        for &entry in base {
            if numbers.number_of.get(entry as usize) == Some(&RESTART) {
                numbers.add(entry);
            }
        }
        numbers.base_count = numbers.vertices.len();
        for level in 0..model.levels().collapse_count() {
            model.split(level).into_iter().flatten().for_each(|update| numbers.add(update.vertex));
        }
        numbers
    }

    fn add(&mut self, vertex: u32) {
        self.number_of[vertex as usize] = self.vertices.len() as u32;
        self.vertices.push(vertex);
    }

    /// Returns an entry with the new index of its vertex.
    fn entry(&self, entry: u32) -> u32 {
        let is_special = entry == RESTART || encoded_offset(entry).is_some();
        if is_special { entry } else { self.number_of[entry as usize] }
    }
}

/// Appends a record per restored vertex.
fn append_split<'a>(
    updates: impl ExactSizeIterator<Item = SlotUpdate<'a>>,
    level: usize,
    positions: &[[f32; 3]],
    width: Width,
    out: &mut Vec<u8>,
) -> Result<(), Error> {
    let count = updates.len();
    if count == 0 {
        let found = format!("none in the collapse to level {level}");
        return Err(Error::Parameter { name: "collapses", found, expected: "a renamed vertex or more" });
    }
    for (number, update) in (1..).zip(updates) {
        append_position(positions[update.vertex as usize], out);
        // The slot that ends the record: the last one, or a reserved one.
        let (last, before) = match (number < count, update.slots.split_last()) {
            (true, _) => (width.goes_on(), update.slots),
            (false, None) => (width.no_slot(), update.slots),
            (false, Some((&last, before))) => (last, before),
        };
        before.iter().for_each(|&slot| width.append(slot << 1, out));
        width.append(last << 1 | 1, out);
    }
    Ok(())
}

fn append_position(position: [f32; 3], out: &mut Vec<u8>) {
    let mut bytes = [0; POSITION_BYTES];
    bytes.chunks_mut(4).zip(position).for_each(|(bytes, x)| bytes.copy_from_slice(&x.to_le_bytes()));
    out.extend_from_slice(&bytes);
}

/// Checks that there is one position per vertex.
fn check_count(positions: &[[f32; 3]], vertex_count: usize) -> Result<(), Error> {
    if positions.len() != vertex_count {
        let (found, expected) = (positions.len() as u64, vertex_count as u64);
        return Err(MeshProblem::AttributeLength { name: "positions".into(), found, expected }.into());
    }
    Ok(())
}

/// Checks the positions of the vertices that are sent.
fn check_sent(positions: &[[f32; 3]], vertices: &[u32]) -> Result<(), Error> {
    for &vertex in vertices {
        if let Some(&found) = positions[vertex as usize].iter().find(|x| !x.is_finite()) {
            return Err(MeshProblem::NotFinite { vertex, found }.into());
        }
    }
    Ok(())
}
