//! The types of the numbers in a buffer.

use crate::error::Error;
use crate::gltf::document::Located;

/// The type of the numbers in a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::gltf) enum ComponentType {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl ComponentType {
    pub(in crate::gltf) fn from_code(code: &Located<'_>) -> Result<Self, Error> {
        Ok(match code.whole()? {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return Err(code.wrong("5120, 5121, 5122, 5123, 5125 or 5126")),
        })
    }

    pub(in crate::gltf) fn code(self) -> u32 {
        match self {
            Self::I8 => 5120,
            Self::U8 => 5121,
            Self::I16 => 5122,
            Self::U16 => 5123,
            Self::U32 => 5125,
            Self::F32 => 5126,
        }
    }

    pub(in crate::gltf) fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// Reads an index; there are enough bytes.
    pub(in crate::gltf) fn index(self, raw: &[u8]) -> u32 {
        raw[..self.bytes()].iter().rev().fold(0, |index, &b| index << 8 | u32::from(b))
    }
}
