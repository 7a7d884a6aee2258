//! Transforms of nodes: a matrix, or translation, rotation and scale.

use crate::error::Error;
use crate::gltf::document::Located;

/// An affine transform: the rows of a linear map, each with its translation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::gltf) struct Transform([[f64; 4]; 3]);

impl Transform {
    pub(in crate::gltf) const IDENTITY: Self =
        Self([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);

    /// Returns the transform of a matrix in the order of files, column after column; the last row of a matrix there is 0 0 0 1.
    pub(in crate::gltf) fn of_columns(columns: [f64; 16]) -> Self {
        Self([0, 1, 2].map(|row| [0, 1, 2, 3].map(|column| columns[4 * column + row])))
    }

    /// Returns the transform that applies `inner` first.
    pub(in crate::gltf) fn of(&self, inner: &Self) -> Self {
        Self(self.0.map(|row| {
            std::array::from_fn(|column| {
                let linear: f64 = (0..3).map(|k| row[k] * inner.0[k][column]).sum();
                if column == 3 { linear + row[3] } else { linear }
            })
        }))
    }

    /// Returns whether all numbers are finite: products of finite ones may not be.
    pub(in crate::gltf) fn is_finite(&self) -> bool {
        self.0.iter().flatten().all(|x| x.is_finite())
    }

    pub(in crate::gltf) fn rows(self) -> [[f64; 4]; 3] {
        self.0
    }
}

/// Returns the transform of a node.
pub(in crate::gltf) fn of_node(node: &Located<'_>) -> Result<Transform, Error> {
    if let Some(matrix) = node.field("matrix") {
        return Ok(Transform::of_columns(matrix.numbers()?));
    }
    let [tx, ty, tz] = node.field("translation").map_or(Ok([0.0; 3]), |t| t.numbers())?;
    let [x, y, z, w] = node.field("rotation").map_or(Ok([0.0, 0.0, 0.0, 1.0]), |r| r.numbers())?;
    let [sx, sy, sz] = node.field("scale").map_or(Ok([1.0; 3]), |s| s.numbers())?;
    Ok(Transform([
        [sx * (1.0 - 2.0 * (y * y + z * z)), sy * (2.0 * (x * y - z * w)), sz * (2.0 * (x * z + y * w)), tx],
        [sx * (2.0 * (x * y + z * w)), sy * (1.0 - 2.0 * (x * x + z * z)), sz * (2.0 * (y * z - x * w)), ty],
        [sx * (2.0 * (x * z - y * w)), sy * (2.0 * (y * z + x * w)), sz * (1.0 - 2.0 * (x * x + y * y)), tz],
    ]))
}
