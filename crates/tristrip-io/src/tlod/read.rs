//! Reads a file section by section. Each section is checked before its numbers are used.

use std::io::Read;

use tristrip::text::counted;
use tristrip::{Attribute, AttributeData, CollapseSequence, Faces, Mesh, Rename, Strips};

use super::limits::{TlodLimits, check};
use super::model::TlodModel;
use super::sections::{ATTRIBUTE_BYTES, Counts, MAGIC, SectionKind, VERSION, empty_values, value_type};
use super::source::{TlodSource, wrong_length};
use crate::error::Error;

/// Reads a model up to the end of the source. Memory is allocated only for bytes that were read.
/// Error positions are offsets in the source.
///
/// # Errors
/// - The source fails or ends too early.
/// - It is not a `.tlod` file, or has another version.
/// - A checksum, a length or a number is wrong, or bytes follow the model.
/// - A limit is exceeded.
///
/// ```
#[doc = include_str!("example.txt")]
/// let mut bytes = Vec::new();
/// tlod::write(&model, &mut bytes)?;
/// let wrong = tlod::read(&bytes[..100], &TlodLimits::default()).unwrap_err();
/// assert_eq!(wrong.to_string(), "byte 100: found the end of the file, expected positions");
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn read(mut source: impl Read, limits: &TlodLimits) -> Result<TlodModel, Error> {
    let source = &mut TlodSource::new(&mut source, limits.bytes);
    read_start(source)?;
    let counts = read_counts(source, limits)?;
    let positions = read_positions(source, counts)?;
    let mut mesh = Mesh::new(positions, Faces::default())?;
    for _ in 0..counts.attributes {
        mesh = mesh.with_attribute(read_attribute(source, counts, limits)?)?;
    }
    let strips = read_strips(source, counts)?;
    let collapses = StoredCollapses::read(source, counts)?;
    source.finish()?;
    let triangles = strips.to_list();
    let sequence =
        CollapseSequence::from_collapses(mesh.vertex_count(), triangles.clone(), collapses.iter())?;
    let mesh = mesh.with_faces(Faces::from_triangles(triangles)?)?;
    Ok(TlodModel { mesh, strips, sequence })
}

fn read_start(source: &mut TlodSource<'_>) -> Result<(), Error> {
    let magic: [u8; 8] = source.bytes("a .tlod file")?;
    if magic != MAGIC {
        return Err(Error::format("byte 0", format!("`{}`", magic.escape_ascii()), "a .tlod file"));
    }
    let version = u32::from_le_bytes(source.bytes("a version")?);
    if version != VERSION {
        return Err(Error::format("byte 8", format!("version {version}"), format!("version {VERSION}")));
    }
    Ok(())
}

fn read_counts(source: &mut TlodSource<'_>, limits: &TlodLimits) -> Result<Counts, Error> {
    source.begin(SectionKind::Head, Some(Counts::BYTES))?;
    let at = source.at();
    let bytes: [u8; Counts::BYTES as usize] = source.bytes("counts")?;
    source.end()?;
    let mut numbers = [0; 7];
    for (number, &bytes) in numbers.iter_mut().zip(bytes.as_chunks().0) {
        *number = u32::from_le_bytes(bytes);
    }
    let counts = Counts::from_numbers(numbers);
    counts.check(at, limits)?;
    Ok(counts)
}

fn read_positions(source: &mut TlodSource<'_>, counts: Counts) -> Result<Vec<[f32; 3]>, Error> {
    source.begin(SectionKind::Positions, counts.section_bytes(SectionKind::Positions))?;
    let position = |bytes: [u8; 12]| {
        let mut position = [0.0; 3];
        for (number, &bytes) in position.iter_mut().zip(bytes.as_chunks().0) {
            *number = f32::from_le_bytes(bytes);
        }
        position
    };
    let positions = source.numbers(counts.vertices.into(), "positions", position)?;
    source.end()?;
    Ok(positions)
}

fn read_attribute(
    source: &mut TlodSource<'_>,
    counts: Counts,
    limits: &TlodLimits,
) -> Result<Attribute, Error> {
    let length_at = source.at() + 4;
    let length = source.begin(SectionKind::Attribute, None)?;
    if length < ATTRIBUTE_BYTES {
        return Err(wrong_length(length_at, "ATTR", length, ATTRIBUTE_BYTES));
    }
    let at = source.at();
    let name_bytes = u32::from_le_bytes(source.bytes("the length of a name")?);
    let [value_number, components, normalized, zero] = source.bytes("the type of an attribute")?;
    check(at, "bytes of a name", name_bytes.into(), limits.name_bytes.into())?;
    let found = format!("type {value_number}, components {components}, normalized {normalized}, {zero}");
    let Some(mut data) =
        empty_values(value_number).filter(|_| components > 0 && normalized <= 1 && zero == 0)
    else {
        let expected = "a type from 0 to 7, components from 1, normalized 0 or 1, and 0";
        return Err(Error::format(format!("byte {}", at + 4), found, expected));
    };
    let value_count = u64::from(counts.vertices) * u64::from(components);
    let expected = ATTRIBUTE_BYTES + u64::from(name_bytes) + value_count * value_type(&data).1;
    if length != expected {
        return Err(wrong_length(length_at, "ATTR", length, expected));
    }
    let name = source.numbers(name_bytes.into(), "the name of an attribute", |[byte]: [u8; 1]| byte)?;
    read_values(source, &mut data)?;
    source.end()?;
    let name = String::from_utf8(name).map_err(|error| {
        let found = format!("`{}`", error.as_bytes().escape_ascii());
        Error::format(format!("byte {}", at + ATTRIBUTE_BYTES), found, "a name in UTF-8")
    })?;
    Ok(Attribute { name, components, normalized: normalized == 1, data })
}

/// Reads the values of an attribute up to the end of its section.
fn read_values(source: &mut TlodSource<'_>, data: &mut AttributeData) -> Result<(), Error> {
    let count = source.left() / value_type(data).1;
    let what = "the values of an attribute";
    match data {
        AttributeData::F32(values) => *values = source.numbers(count, what, f32::from_le_bytes)?,
        AttributeData::F64(values) => *values = source.numbers(count, what, f64::from_le_bytes)?,
        AttributeData::U8(values) => *values = source.numbers(count, what, u8::from_le_bytes)?,
        AttributeData::I8(values) => *values = source.numbers(count, what, i8::from_le_bytes)?,
        AttributeData::U16(values) => *values = source.numbers(count, what, u16::from_le_bytes)?,
        AttributeData::I16(values) => *values = source.numbers(count, what, i16::from_le_bytes)?,
        AttributeData::U32(values) => *values = source.numbers(count, what, u32::from_le_bytes)?,
        AttributeData::I32(values) => *values = source.numbers(count, what, i32::from_le_bytes)?,
    }
    Ok(())
}

fn read_strips(source: &mut TlodSource<'_>, counts: Counts) -> Result<Strips, Error> {
    source.begin(SectionKind::Strips, counts.section_bytes(SectionKind::Strips))?;
    let ends_at = source.at();
    let ends = source.numbers(counts.strips.into(), "the ends of strips", u32::from_le_bytes)?;
    let at = source.at();
    let vertices = source.numbers(counts.strip_vertices.into(), "vertices of strips", u32::from_le_bytes)?;
    source.end()?;
    check_ends("strips", ends_at, &ends, counts.strip_vertices)?;
    check_vertices(at, &vertices, counts.vertices)?;
    let strips = Strips::from_parts(vertices, ends)?;
    let triangle_count = strips.triangles().count();
    if triangle_count != counts.triangles as usize {
        let expected = format!("{}, the declared count", counts.triangles);
        return Err(Error::format(format!("byte {at}"), counted(triangle_count, "triangle"), expected));
    }
    Ok(strips)
}

/// The collapses as stored in the file, from the full mesh on.
struct StoredCollapses {
    errors: Vec<f32>,
    ends: Vec<u32>,
    renames: Vec<Rename>,
}

impl StoredCollapses {
    fn read(source: &mut TlodSource<'_>, counts: Counts) -> Result<Self, Error> {
        source.begin(SectionKind::Collapses, counts.section_bytes(SectionKind::Collapses))?;
        let errors = source.numbers(counts.collapses.into(), "errors of collapses", f32::from_le_bytes)?;
        let at = source.at();
        let ends = source.numbers(counts.collapses.into(), "the ends of collapses", u32::from_le_bytes)?;
        let rename = |[a, b, c, d, e, f, g, h]: [u8; 8]| Rename {
            removed: u32::from_le_bytes([a, b, c, d]),
            kept: u32::from_le_bytes([e, f, g, h]),
        };
        let renames = source.numbers(counts.renames.into(), "renames of collapses", rename)?;
        source.end()?;
        check_ends("collapses", at, &ends, counts.renames)?;
        Ok(Self { errors, ends, renames })
    }

    /// Iterates over the renames and errors.
    fn iter(&self) -> impl Iterator<Item = (&[Rename], f32)> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        let ranges = starts.zip(&self.ends).map(|(start, &end)| start as usize..end as usize);
        ranges.zip(&self.errors).map(|(range, &error)| (&self.renames[range], error))
    }
}

/// Checks that the ends, stored at byte `at`, never decrease, and that the last is the number of
/// items.
fn check_ends(what: &str, at: u64, ends: &[u32], count: u32) -> Result<(), Error> {
    let wrong = ends.windows(2).position(|pair| pair[0] > pair[1]).map(|i| i + 1);
    let last = ends.last().copied().unwrap_or(0);
    let (i, expected) = match wrong {
        Some(i) => (i, format!("at least {}, the previous end", ends[i - 1])),
        None if last != count => (ends.len().saturating_sub(1), format!("{count}, the total number")),
        None => return Ok(()),
    };
    let found = format!("end {} of {what}", ends.get(i).copied().unwrap_or(0));
    Err(Error::format(format!("byte {}", at + 4 * i as u64), found, expected))
}

/// Checks that the strip vertices, stored at byte `at`, exist.
fn check_vertices(at: u64, vertices: &[u32], vertex_count: u32) -> Result<(), Error> {
    let Some(i) = vertices.iter().position(|&v| v >= vertex_count) else { return Ok(()) };
    let found = format!("vertex {}", vertices[i]);
    Err(Error::format(format!("byte {}", at + 4 * i as u64), found, format!("less than {vertex_count}")))
}
