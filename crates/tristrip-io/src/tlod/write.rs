//! Writes a file in bounded pieces.

use std::io::Write;

use crc32fast::Hasher;
use tristrip::{Attribute, AttributeData};

use super::model::{TlodModel, strip_ends};
use super::sections::{ATTRIBUTE_BYTES, Counts, MAGIC, PIECE_BYTES, SectionKind, VERSION, value_type};
use crate::error::Error;
use crate::le_bytes;

/// Writes a model. The output is deterministic.
///
/// # Errors
/// The target fails, the public fields of the model are no longer consistent, or a count exceeds 32
/// bits.
///
/// ```
#[doc = include_str!("example.txt")]
/// let (mut bytes, mut again) = (Vec::new(), Vec::new());
/// tlod::write(&model, &mut bytes)?;
/// tlod::write(&model, &mut again)?;
/// assert!(bytes == again && bytes.starts_with(b"\x89TLOD\r\n\x1a"));
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn write(model: &TlodModel, target: &mut impl Write) -> Result<(), Error> {
    model.check()?;
    let counts = counts_of(model)?;
    let target = &mut TlodTarget { writer: target, checksum: Hasher::new(), piece: Vec::new() };
    target.bytes(&MAGIC)?;
    target.bytes(&VERSION.to_le_bytes())?;

    let length = |kind| counts.section_bytes(kind).unwrap_or_default();
    target.begin(SectionKind::Head, length(SectionKind::Head))?;
    target.numbers(&counts.to_numbers(), u32::to_le_bytes)?;
    target.end()?;

    target.begin(SectionKind::Positions, length(SectionKind::Positions))?;
    target.numbers(model.mesh.positions().as_flattened(), f32::to_le_bytes)?;
    target.end()?;

    for attribute in model.mesh.attributes() {
        write_attribute(attribute, target)?;
    }

    target.begin(SectionKind::Strips, length(SectionKind::Strips))?;
    target.each(strip_ends(&model.strips), u32::to_le_bytes)?;
    target.numbers(model.strips.vertices(), u32::to_le_bytes)?;
    target.end()?;

    let collapses = || model.sequence.iter();
    target.begin(SectionKind::Collapses, length(SectionKind::Collapses))?;
    target.each(collapses().map(|collapse| collapse.error), f32::to_le_bytes)?;
    let ends = collapses().scan(0, |end, collapse| {
        *end += collapse.renames.len() as u32;
        Some(*end)
    });
    target.each(ends, u32::to_le_bytes)?;
    let renames = collapses().flat_map(|collapse| collapse.renames);
    target.each(renames.flat_map(|rename| [rename.removed, rename.kept]), u32::to_le_bytes)?;
    target.end()
}

/// Returns the counts of a model.
fn counts_of(model: &TlodModel) -> Result<Counts, Error> {
    let renames = model.sequence.iter().map(|collapse| collapse.renames.len()).sum();
    Ok(Counts {
        vertices: count("vertices", model.mesh.vertex_count())?,
        attributes: count("attributes", model.mesh.attributes().len())?,
        strips: count("strips", model.strips.len())?,
        strip_vertices: count("vertices of strips", model.strips.vertices_sent())?,
        triangles: count("triangles", model.sequence.triangles().len() / 3)?,
        collapses: count("collapses", model.sequence.len())?,
        renames: count("renames", renames)?,
    })
}

fn count(at: &str, found: usize) -> Result<u32, Error> {
    u32::try_from(found).map_err(|_| Error::LimitExceeded {
        at: at.into(),
        found: found as u64,
        limit: u32::MAX.into(),
    })
}

fn write_attribute(attribute: &Attribute, target: &mut TlodTarget<'_>) -> Result<(), Error> {
    let Attribute { name, components, normalized, data } = attribute;
    let (number, value_bytes) = value_type(data);
    let name_bytes = count("bytes of a name", name.len())?;
    let length = ATTRIBUTE_BYTES + name.len() as u64 + data.len() as u64 * value_bytes;
    target.begin(SectionKind::Attribute, length)?;
    target.bytes(&name_bytes.to_le_bytes())?;
    target.bytes(&[number, *components, u8::from(*normalized), 0])?;
    target.bytes(name.as_bytes())?;
    match data {
        AttributeData::F32(values) => target.numbers(values, f32::to_le_bytes),
        AttributeData::F64(values) => target.numbers(values, f64::to_le_bytes),
        AttributeData::U8(values) => target.numbers(values, u8::to_le_bytes),
        AttributeData::I8(values) => target.numbers(values, i8::to_le_bytes),
        AttributeData::U16(values) => target.numbers(values, u16::to_le_bytes),
        AttributeData::I16(values) => target.numbers(values, i16::to_le_bytes),
        AttributeData::U32(values) => target.numbers(values, u32::to_le_bytes),
        AttributeData::I32(values) => target.numbers(values, i32::to_le_bytes),
    }?;
    target.end()
}

/// A stream of sections.
struct TlodTarget<'a> {
    writer: &'a mut dyn Write,
    checksum: Hasher,
    piece: Vec<u8>,
}

impl TlodTarget<'_> {
    fn begin(&mut self, kind: SectionKind, length: u64) -> Result<(), Error> {
        self.checksum = Hasher::new();
        self.bytes(&kind.code())?;
        self.bytes(&length.to_le_bytes())
    }

    fn end(&mut self) -> Result<(), Error> {
        let checksum = self.checksum.clone().finalize();
        self.bytes(&checksum.to_le_bytes())
    }

    fn numbers<T: Copy, const N: usize>(
        &mut self,
        numbers: &[T],
        bytes: impl Fn(T) -> [u8; N] + Copy,
    ) -> Result<(), Error> {
        let mut piece = std::mem::take(&mut self.piece);
        for numbers in numbers.chunks(PIECE_BYTES / N) {
            piece.clear();
            le_bytes::append(&mut piece, numbers, bytes);
            self.bytes(&piece)?;
        }
        self.piece = piece;
        Ok(())
    }

    /// Writes numbers from an iterator.
    fn each<T: Copy, const N: usize>(
        &mut self,
        mut numbers: impl Iterator<Item = T>,
        bytes: impl Fn(T) -> [u8; N] + Copy,
    ) -> Result<(), Error> {
        let mut some = Vec::new();
        loop {
            some.clear();
            some.extend(numbers.by_ref().take(PIECE_BYTES / N));
            if some.is_empty() {
                return Ok(());
            }
            self.numbers(&some, bytes)?;
        }
    }

    fn bytes(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.checksum.update(bytes);
        let written = self.writer.write_all(bytes);
        written.map_err(|source| Error::Io { path: "the target of the model".into(), source })
    }
}
