//! The constants of the format, and the counts in the first section.

use tristrip::AttributeData;
use tristrip::text::counted;

use super::limits::{TlodLimits, check};
use crate::error::Error;

pub(super) const MAGIC: [u8; 8] = *b"\x89TLOD\r\n\x1a";
pub(super) const VERSION: u32 = 1;
/// The number of bytes read or written at a time.
pub(super) const PIECE_BYTES: usize = 1 << 16;
/// The number of bytes in an attribute section before the name.
pub(super) const ATTRIBUTE_BYTES: u64 = 8;

/// The kind of a section.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SectionKind {
    Head,
    Positions,
    Attribute,
    Strips,
    Collapses,
}

impl SectionKind {
    pub(super) const ALL: [Self; 5] =
        [Self::Head, Self::Positions, Self::Attribute, Self::Strips, Self::Collapses];

    pub(super) fn code(self) -> [u8; 4] {
        *match self {
            Self::Head => b"HEAD",
            Self::Positions => b"POSN",
            Self::Attribute => b"ATTR",
            Self::Strips => b"STRP",
            Self::Collapses => b"COLL",
        }
    }
}

/// All counts of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Counts {
    pub(super) vertices: u32,
    pub(super) attributes: u32,
    pub(super) strips: u32,
    pub(super) strip_vertices: u32,
    pub(super) triangles: u32,
    pub(super) collapses: u32,
    pub(super) renames: u32,
}

impl Counts {
    pub(super) const BYTES: u64 = 28;

    pub(super) fn to_numbers(self) -> [u32; 7] {
        let Self { vertices, attributes, strips, strip_vertices, triangles, collapses, renames } = self;
        [vertices, attributes, strips, strip_vertices, triangles, collapses, renames]
    }

    pub(super) fn from_numbers(numbers: [u32; 7]) -> Self {
        let [vertices, attributes, strips, strip_vertices, triangles, collapses, renames] = numbers;
        Self { vertices, attributes, strips, strip_vertices, triangles, collapses, renames }
    }

    /// Checks the counts, stored at byte `at`. Counts without their own limit are limited by the
    /// file size.
    pub(super) fn check(self, at: u64, limits: &TlodLimits) -> Result<(), Error> {
        let limited = [
            (0, "vertices", self.vertices, limits.vertices),
            (1, "attributes", self.attributes, limits.attributes),
            (4, "triangles", self.triangles, limits.triangles),
            (5, "collapses", self.collapses, limits.collapses),
        ];
        limited
            .into_iter()
            .try_for_each(|(i, what, found, limit)| check(at + 4 * i, what, found.into(), limit.into()))?;
        // Each rename removes a different vertex.
        if self.renames > self.vertices {
            let expected = format!("at most {}, one per vertex", self.vertices);
            return Err(Error::format(
                format!("byte {}", at + 24),
                counted(self.renames, "rename"),
                expected,
            ));
        }
        Ok(())
    }

    /// Returns the length of a section if the counts determine it.
    pub(super) fn section_bytes(self, kind: SectionKind) -> Option<u64> {
        let [vertices, _, strips, strip_vertices, _, collapses, renames] = self.to_numbers().map(u64::from);
        match kind {
            SectionKind::Head => Some(Self::BYTES),
            SectionKind::Positions => Some(12 * vertices),
            SectionKind::Attribute => None,
            SectionKind::Strips => Some(4 * (strips + strip_vertices)),
            SectionKind::Collapses => Some(8 * (collapses + renames)),
        }
    }
}

/// Returns the type code of an attribute's values and the size of a value in bytes.
pub(super) fn value_type(data: &AttributeData) -> (u8, u64) {
    match data {
        AttributeData::F32(_) => (0, 4),
        AttributeData::F64(_) => (1, 8),
        AttributeData::U8(_) => (2, 1),
        AttributeData::I8(_) => (3, 1),
        AttributeData::U16(_) => (4, 2),
        AttributeData::I16(_) => (5, 2),
        AttributeData::U32(_) => (6, 4),
        AttributeData::I32(_) => (7, 4),
    }
}

/// Returns an empty list of the type with this code.
pub(super) fn empty_values(value_type: u8) -> Option<AttributeData> {
    Some(match value_type {
        0 => AttributeData::F32(Vec::new()),
        1 => AttributeData::F64(Vec::new()),
        2 => AttributeData::U8(Vec::new()),
        3 => AttributeData::I8(Vec::new()),
        4 => AttributeData::U16(Vec::new()),
        5 => AttributeData::I16(Vec::new()),
        6 => AttributeData::U32(Vec::new()),
        7 => AttributeData::I32(Vec::new()),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_have_numbers_of_their_own() {
        for number in 0..8 {
            assert_eq!(empty_values(number).map(|values| value_type(&values).0), Some(number));
        }
        assert_eq!(empty_values(8), None);
    }
}
