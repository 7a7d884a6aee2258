//! Constants, types and names of the glTF specification and its extensions that several modules
//! use.

use crate::error::Error;
use crate::gltf::document::Located;

/// The primitive mode of a triangle list.
pub(in crate::gltf) const TRIANGLES: u64 = 4;
pub(in crate::gltf) const TRIANGLE_STRIP: u64 = 5;
pub(in crate::gltf) const TRIANGLE_FAN: u64 = 6;

/// The `target` of a buffer view with vertex attributes.
pub(in crate::gltf) const ARRAY_BUFFER: u32 = 34962;
/// The `target` of a buffer view with indices.
pub(in crate::gltf) const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// The extension that allows integer positions.
pub(in crate::gltf) const QUANTIZATION: &str = "KHR_mesh_quantization";

/// Extensions that compress the bytes of a buffer view; the second succeeds the first and has the
/// same structure.
pub(in crate::gltf) const COMPRESSIONS: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// The extension that allows the restart index.
pub(in crate::gltf) const RESTART_EXTENSION: &str = "KHR_mesh_primitive_restart";

/// The extension that lists the nodes or materials of lower levels of detail. It contains no other
/// references.
pub(in crate::gltf) const LEVELS_OF_DETAIL: &str = "MSFT_lod";

/// The extras of a node with levels of detail: the screen coverage below which each level is
/// replaced by the next.
pub(in crate::gltf) const SCREEN_COVERAGE: &str = "MSFT_screencoverage";

/// Extensions that describe the order of indices and become invalid when the indices change.
pub(in crate::gltf) const ORDER_EXTENSIONS: [&str; 3] =
    ["EXT_mesh_manifold", "EXT_mesh_primitive_edge_visibility", "EXT_mesh_primitive_restart"];

/// The type of numbers in a buffer.
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

    /// Reads an index; `raw` must have at least [`Self::bytes`] bytes.
    pub(in crate::gltf) fn index(self, raw: &[u8]) -> u32 {
        raw[..self.bytes()].iter().rev().fold(0, |index, &b| index << 8 | u32::from(b))
    }
}
