//! Binary rows of fixed size, decoded column by column: the type of a property is looked up once
//! instead of once per row.

use super::header::{Property, Scalar};

/// Consecutive rows of numbers.
pub(super) struct FixedRows<'a> {
    /// The offset of the first row in the file.
    start: usize,
    bytes: &'a [u8],
    is_big_endian: bool,
    /// The size of a row in bytes.
    size: usize,
    /// The offset of each property in the row, and its type.
    columns: Vec<(usize, Scalar)>,
}

impl<'a> FixedRows<'a> {
    /// Splits bytes into rows of these properties, none of which is a list.
    pub(super) fn new(start: usize, bytes: &'a [u8], properties: &[Property], is_big_endian: bool) -> Self {
        let mut size = 0;
        let columns = properties.iter().map(|property| {
            size += property.value.size();
            (size - property.value.size(), property.value)
        });
        let columns = columns.collect();
        Self { start, bytes, is_big_endian, size, columns }
    }

    /// Returns the offset of a value in the file.
    pub(super) fn offset(&self, row: usize, property: usize) -> usize {
        self.start + row * self.size + self.columns[property].0
    }

    /// Returns the type of a property.
    pub(super) fn kind(&self, property: usize) -> Scalar {
        self.columns[property].1
    }

    /// Appends the values of properties of the same type, row by row.
    pub(super) fn gather<T, const N: usize>(
        &self,
        properties: &[usize],
        out: &mut Vec<T>,
        read: impl Fn([u8; N]) -> T,
    ) {
        let offsets: Vec<usize> = properties.iter().map(|&property| self.columns[property].0).collect();
        out.reserve_exact(offsets.len() * (self.bytes.len() / self.size));
        for row in self.bytes.chunks_exact(self.size) {
            out.extend(offsets.iter().map(|&offset| read(self.value(row, offset))));
        }
    }

    /// Returns the values of properties of the same type, row by row.
    pub(super) fn gather_arrays<T, const N: usize, const K: usize>(
        &self,
        properties: [usize; K],
        read: impl Fn([u8; N]) -> T,
    ) -> Vec<[T; K]> {
        let offsets = properties.map(|property| self.columns[property].0);
        let rows = self.bytes.chunks_exact(self.size);
        rows.map(|row| offsets.map(|offset| read(self.value(row, offset)))).collect()
    }

    /// Returns the bytes of a value in a row, in little-endian order.
    fn value<const N: usize>(&self, row: &[u8], offset: usize) -> [u8; N] {
        let mut bytes = row[offset..].first_chunk::<N>().copied().unwrap_or([0; N]);
        if self.is_big_endian {
            bytes.reverse();
        }
        bytes
    }

    /// Returns the values of a property as 64-bit floats, which represent every type exactly.
    pub(super) fn wide(&self, property: usize) -> Vec<f64> {
        let mut out = Vec::new();
        let from = &[property];
        match self.kind(property) {
            Scalar::I8 => self.gather(from, &mut out, |b| i8::from_le_bytes(b).into()),
            Scalar::U8 => self.gather(from, &mut out, |b| u8::from_le_bytes(b).into()),
            Scalar::I16 => self.gather(from, &mut out, |b| i16::from_le_bytes(b).into()),
            Scalar::U16 => self.gather(from, &mut out, |b| u16::from_le_bytes(b).into()),
            Scalar::I32 => self.gather(from, &mut out, |b| i32::from_le_bytes(b).into()),
            Scalar::U32 => self.gather(from, &mut out, |b| u32::from_le_bytes(b).into()),
            Scalar::F32 => self.gather(from, &mut out, |b| f32::from_le_bytes(b).into()),
            Scalar::F64 => self.gather(from, &mut out, f64::from_le_bytes),
        }
        out
    }
}
