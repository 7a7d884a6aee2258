//! The rows as a stream of numbers, with one interface for text and both byte orders.

use super::fixed_rows::FixedRows;
use super::header::{Element, Property, Scalar};
use crate::error::Error;
use crate::polygons::Polygons;
use crate::text::{Text, integer, quote};
use tristrip::text::counted;

/// Reads numbers in file order. 64-bit floats represent the numbers of every PLY type exactly.
pub(super) trait Rows {
    /// Reads the next number.
    fn value(&mut self, kind: Scalar, name: &str) -> Result<f64, Error>;
    /// Describes the position of the last number.
    fn position(&self) -> String;
    /// Reads `row_count` rows of fixed size at once. Only for binary rows that are completely
    /// present.
    fn fixed_rows(&mut self, _properties: &[Property], _row_count: usize) -> Option<FixedRows<'_>> {
        None
    }
    /// Appends a list of 32-bit binary vertex indices that are all below `bound`. Returns false,
    /// without reading anything, if the list is not of this form.
    fn push_indices(&mut self, _kind: Scalar, _count: usize, _bound: u32, _out: &mut Polygons) -> bool {
        false
    }
    /// Reads up to `most` rows that are triangles in the most common form: an 8-bit binary count
    /// and 32-bit indices, all below `bound`. Returns their number.
    fn push_triangles(&mut self, _list: &Property, _most: u64, _bound: u32, _out: &mut Polygons) -> u64 {
        0
    }
    /// Reads the indices of a row of strips under the conditions of [`Rows::push_indices`]. All
    /// bits of a restart are set.
    fn strip_row(&mut self, _kind: Scalar, _count: usize, _bound: u32) -> Option<Vec<u32>> {
        None
    }
    /// Ends a row.
    fn end_row(&mut self, element: &Element) -> Result<(), Error>;
    /// Returns the maximum number of values in the remaining bytes.
    fn values_left(&self, kind: Scalar) -> u64;
    /// Returns the maximum number of rows, of at least one property, in the remaining bytes.
    fn rows_left(&self, properties: &[Property]) -> u64;
    /// Returns the number of remaining bytes.
    fn bytes_left(&self) -> usize;
    /// Checks that only padding follows. Anything else means that a count is too small.
    fn end(&mut self) -> Result<(), Error>;
}

/// Rows of text: each starts on a new line and may continue on the following lines.
pub(super) struct AsciiRows<'a> {
    text: Text<'a>,
}

impl<'a> AsciiRows<'a> {
    pub(super) fn new(bytes: &'a [u8], line: u64) -> Self {
        Self { text: Text::new(bytes).with_first_line(line) }
    }
}

impl Rows for AsciiRows<'_> {
    fn value(&mut self, kind: Scalar, name: &str) -> Result<f64, Error> {
        let Some(word) = self.text.word_on_any_line() else {
            return Err(self.text.missing(&format!("a number for `{name}`")));
        };
        let range = match kind {
            Scalar::F32 => return self.float(fast_float2::parse::<f32, _>(word).map(f64::from), word, name),
            Scalar::F64 => return self.float(fast_float2::parse::<f64, _>(word), word, name),
            Scalar::I8 => i64::from(i8::MIN)..=i64::from(i8::MAX),
            Scalar::U8 => 0..=i64::from(u8::MAX),
            Scalar::I16 => i64::from(i16::MIN)..=i64::from(i16::MAX),
            Scalar::U16 => 0..=i64::from(u16::MAX),
            Scalar::I32 => i64::from(i32::MIN)..=i64::from(i32::MAX),
            Scalar::U32 => 0..=i64::from(u32::MAX),
        };
        match integer(word) {
            Some(value) if range.contains(&value) => Ok(value as f64),
            _ => {
                let expected = format!("an integer from {} to {} for `{name}`", range.start(), range.end());
                Err(Error::format(self.position(), quote(word), expected))
            }
        }
    }

    fn position(&self) -> String {
        self.text.position()
    }

    fn end_row(&mut self, element: &Element) -> Result<(), Error> {
        match self.text.word() {
            None => Ok(()),
            Some(word) => {
                let expected = format!("the end of the row of element `{}`", element.name);
                Err(Error::format(self.position(), quote(word), expected))
            }
        }
    }

    fn values_left(&self, _: Scalar) -> u64 {
        self.text.words_left() as u64
    }

    fn rows_left(&self, properties: &[Property]) -> u64 {
        self.text.words_left() as u64 / properties.len().max(1) as u64
    }

    fn bytes_left(&self) -> usize {
        self.text.bytes_left()
    }

    fn end(&mut self) -> Result<(), Error> {
        match self.text.word_on_any_line() {
            None => Ok(()),
            Some(word) => Err(Error::format(
                self.position(),
                quote(word),
                "the end of the file, as the header's counts require",
            )),
        }
    }
}

impl AsciiRows<'_> {
    fn float<E>(&self, value: Result<f64, E>, word: &[u8], name: &str) -> Result<f64, Error> {
        value.map_err(|_| Error::format(self.position(), quote(word), format!("a number for `{name}`")))
    }
}

/// Checks whether numbers have 32 bits and can be compared with `bound` as unsigned ones. Negative
/// numbers are then above it.
fn are_32_bit_indices(kind: Scalar, bound: u32) -> bool {
    matches!(kind, Scalar::I32 | Scalar::U32) && bound <= 1 << 31
}

/// The number of rows that are checked before they are read; small enough to stay in the CPU
/// caches.
const ROWS_PER_BLOCK: usize = 1024;

/// Rows of binary numbers.
pub(super) struct BinaryRows<'a, const BIG: bool> {
    bytes: &'a [u8],
    at: usize,
    /// The offset of the last number.
    last: usize,
}

impl<'a, const BIG: bool> BinaryRows<'a, BIG> {
    pub(super) fn new(bytes: &'a [u8], at: usize) -> Self {
        Self { bytes, at, last: at }
    }

    fn take<const N: usize>(&mut self, name: &str) -> Result<[u8; N], Error> {
        self.last = self.at;
        match self.bytes.get(self.at..).and_then(|left| left.first_chunk::<N>()) {
            Some(&(mut chunk)) => {
                if BIG {
                    chunk.reverse();
                }
                self.at += N;
                Ok(chunk)
            }
            None => Err(self.end_of_file(N, name)),
        }
    }

    /// Returns the next numbers without consuming them, if they may be 32-bit indices.
    fn indices(&self, kind: Scalar, count: usize, bound: u32) -> Option<&'a [[u8; 4]]> {
        let bytes = self.bytes.get(self.at..)?.get(..count.checked_mul(4)?)?;
        are_32_bit_indices(kind, bound).then_some(bytes.as_chunks::<4>().0)
    }

    fn index(bytes: [u8; 4]) -> u32 {
        if BIG { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) }
    }

    #[cold]
    fn end_of_file(&self, size: usize, name: &str) -> Error {
        let found = match self.bytes_left() {
            0 => "the end of the file".to_owned(),
            left => format!("the end of the file after {}", counted(left, "byte")),
        };
        Error::format(self.position(), found, format!("{} for `{name}`", counted(size, "byte")))
    }
}

impl<const BIG: bool> Rows for BinaryRows<'_, BIG> {
    #[inline]
    fn value(&mut self, kind: Scalar, name: &str) -> Result<f64, Error> {
        Ok(match kind {
            Scalar::I8 => i8::from_le_bytes(self.take(name)?).into(),
            Scalar::U8 => u8::from_le_bytes(self.take(name)?).into(),
            Scalar::I16 => i16::from_le_bytes(self.take(name)?).into(),
            Scalar::U16 => u16::from_le_bytes(self.take(name)?).into(),
            Scalar::I32 => i32::from_le_bytes(self.take(name)?).into(),
            Scalar::U32 => u32::from_le_bytes(self.take(name)?).into(),
            Scalar::F32 => f32::from_le_bytes(self.take(name)?).into(),
            Scalar::F64 => f64::from_le_bytes(self.take(name)?),
        })
    }

    fn position(&self) -> String {
        format!("byte {}", self.last)
    }

    fn end_row(&mut self, _: &Element) -> Result<(), Error> {
        Ok(())
    }

    #[inline]
    fn values_left(&self, kind: Scalar) -> u64 {
        // Sizes are powers of two.
        (self.bytes_left() >> kind.size().trailing_zeros()) as u64
    }

    fn fixed_rows(&mut self, properties: &[Property], row_count: usize) -> Option<FixedRows<'_>> {
        if properties.iter().any(|property| property.count.is_some()) {
            return None;
        }
        let size: usize = properties.iter().map(|property| property.value.size()).sum();
        let start = self.at;
        let rows = self.bytes.get(start..start.checked_add(row_count.checked_mul(size)?)?)?;
        self.at += rows.len();
        Some(FixedRows::new(start, rows, properties, BIG))
    }

    #[inline]
    fn push_indices(&mut self, kind: Scalar, count: usize, bound: u32, out: &mut Polygons) -> bool {
        let Some(indices) = self.indices(kind, count, bound) else { return false };
        if !indices.iter().all(|bytes| Self::index(*bytes) < bound) {
            return false;
        }
        out.extend(indices.iter().map(|bytes| Self::index(*bytes)));
        self.at += 4 * count;
        true
    }

    fn push_triangles(&mut self, list: &Property, most: u64, bound: u32, out: &mut Polygons) -> u64 {
        if list.count != Some(Scalar::U8) || !are_32_bit_indices(list.value, bound) {
            return 0;
        }
        let triangle = |row: &[u8; 13]| {
            let &[_, a0, a1, a2, a3, b0, b1, b2, b3, c0, c1, c2, c3] = row;
            [[a0, a1, a2, a3], [b0, b1, b2, b3], [c0, c1, c2, c3]].map(Self::index)
        };
        let is_valid = |row: &[u8; 13]| row[0] == 3 && triangle(row).into_iter().fold(0, u32::max) < bound;
        let rows = self.bytes.get(self.at..).unwrap_or_default().as_chunks::<13>().0;
        let rows = &rows[..rows.len().min(usize::try_from(most).unwrap_or(usize::MAX))];
        let mut read = 0;
        for block in rows.chunks(ROWS_PER_BLOCK) {
            let valid = block.iter().take_while(|row| is_valid(row)).count();
            out.push_triangles(block[..valid].iter().map(triangle));
            read += valid;
            if valid < block.len() {
                break;
            }
        }
        self.at += 13 * read;
        read as u64
    }

    fn strip_row(&mut self, kind: Scalar, count: usize, bound: u32) -> Option<Vec<u32>> {
        let row: Vec<u32> =
            self.indices(kind, count, bound)?.iter().map(|bytes| Self::index(*bytes)).collect();
        if !row.iter().all(|&index| index < bound || index == u32::MAX) {
            return None;
        }
        self.at += 4 * count;
        Some(row)
    }

    fn rows_left(&self, properties: &[Property]) -> u64 {
        let row: usize = properties.iter().map(|p| p.count.unwrap_or(p.value).size()).sum();
        self.bytes_left() as u64 / row.max(1) as u64
    }

    fn bytes_left(&self) -> usize {
        self.bytes.len() - self.at
    }

    fn end(&mut self) -> Result<(), Error> {
        let left = &self.bytes[self.at..];
        if left.iter().all(|&byte| byte == 0 || byte.is_ascii_whitespace()) {
            return Ok(());
        }
        let found = format!("{} after the last row", counted(left.len(), "byte"));
        Err(Error::format(
            format!("byte {}", self.at),
            found,
            "the end of the file, as the header's counts require",
        ))
    }
}
