//! Index buffers of drawings: runs of indices with their modes and index types.

use std::borrow::Cow;

use serde_json::{Value, json};
use tristrip::strip_triangles;
use tristrip::{Layout, Mesh, Strips};

use crate::gltf::document::spec::ComponentType;
use crate::gltf::document::spec::{TRIANGLE_STRIP, TRIANGLES};
use crate::le_bytes::append;
use crate::model::Drawing;

/// The restart index as a 32-bit number, before it is truncated to the index type.
const RESTART: u32 = u32::MAX;

/// The indices of one primitive.
pub(in crate::gltf) struct IndexRun<'a> {
    pub(in crate::gltf) mode: u64,
    /// At least one index. [`RESTART`] separates strips.
    indices: Cow<'a, [u32]>,
    /// The highest index other than restarts.
    highest: u32,
}

impl<'a> IndexRun<'a> {
    fn new(mode: u64, indices: impl Into<Cow<'a, [u32]>>) -> Self {
        let indices = indices.into();
        // No branch, so the loop vectorizes.
        let highest = indices.iter().fold(0, |highest, &i| highest.max(if i == RESTART { 0 } else { i }));
        Self { mode, indices, highest }
    }

    pub(in crate::gltf) fn count(&self) -> usize {
        self.indices.len()
    }

    pub(in crate::gltf) fn has_restarts(&self) -> bool {
        self.indices.contains(&RESTART)
    }

    /// Returns the smallest type whose highest value no index has.
    pub(in crate::gltf) fn component(&self) -> ComponentType {
        match self.highest {
            0..0xFF => ComponentType::U8,
            0xFF..0xFFFF => ComponentType::U16,
            _ => ComponentType::U32,
        }
    }

    /// Builds the accessor of the indices, `offset` bytes after the start of a buffer view.
    pub(in crate::gltf) fn accessor(&self, view: usize, offset: usize) -> Value {
        let mut accessor = json!({
            "bufferView": view,
            "componentType": self.component().code(),
            "count": self.count(),
            "type": "SCALAR",
        });
        if offset > 0 {
            accessor["byteOffset"] = offset.into();
        }
        accessor
    }

    /// Appends the indices in their type.
    fn pack(&self, out: &mut Vec<u8>) {
        // Truncation maps the restart index to the highest value of the type.
        match self.component() {
            ComponentType::U8 => append(out, &self.indices, |i| [i as u8]),
            ComponentType::U16 => append(out, &self.indices, |i| (i as u16).to_le_bytes()),
            _ => append(out, &self.indices, u32::to_le_bytes),
        }
    }
}

/// Appends the indices of runs, each aligned to four bytes. Returns the offset of each from the
/// previous end of `out`.
pub(in crate::gltf) fn pack_runs(runs: &[IndexRun<'_>], out: &mut Vec<u8>) -> Vec<usize> {
    let start = out.len();
    let mut offsets = Vec::with_capacity(runs.len());
    for run in runs {
        out.resize(out.len().next_multiple_of(4), 0);
        offsets.push(out.len() - start);
        run.pack(out);
    }
    offsets
}

/// Returns the runs of a drawing: one, or one per strip with [`Layout::Separate`]. There is at
/// least one. The caller has checked the drawing's indices.
pub(in crate::gltf) fn runs<'a>(mesh: &'a Mesh, drawing: Drawing<'a>, layout: Layout) -> Vec<IndexRun<'a>> {
    let mut runs = match drawing {
        Drawing::Faces => vec![IndexRun::new(TRIANGLES, face_triangles(mesh))],
        Drawing::Strips(strips) => match layout {
            Layout::Restart => vec![IndexRun::new(TRIANGLE_STRIP, to_restart(strips))],
            Layout::Degenerate => vec![IndexRun::new(TRIANGLE_STRIP, strips.to_degenerate())],
            Layout::List => vec![IndexRun::new(TRIANGLES, strips.to_list())],
            Layout::Separate => visible(strips).map(|strip| IndexRun::new(TRIANGLE_STRIP, strip)).collect(),
        },
    };
    runs.retain(|run| !run.indices.is_empty());
    if runs.is_empty() {
        runs.push(IndexRun::new(TRIANGLES, vec![0; 3]));
    }
    runs
}

/// Iterates over the strips with at least one triangle.
fn visible(strips: &Strips) -> impl Iterator<Item = &[u32]> {
    strips.iter().filter(|strip| strip_triangles(strip).next().is_some())
}

fn to_restart(strips: &Strips) -> Vec<u32> {
    let mut kept = Strips::default();
    if visible(strips).count() == strips.len() {
        return strips.to_restart(RESTART);
    }
    visible(strips).for_each(|strip| kept.push(strip));
    kept.to_restart(RESTART)
}

/// Returns faces as triangles; polygons become fans around their first corner.
fn face_triangles(mesh: &Mesh) -> Cow<'_, [u32]> {
    match mesh.faces().as_triangles() {
        Some(corners) => corners.into(),
        None => mesh
            .faces()
            .iter()
            .flat_map(|face| (2..face.len()).flat_map(|i| [face[0], face[i - 1], face[i]]))
            .collect(),
    }
}
