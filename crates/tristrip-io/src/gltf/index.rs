//! Index buffers for drawings: which runs of indices to draw in which mode, and in how many bits.

use tristrip::strip::strip_triangles;
use tristrip::{Layout, Mesh, Strips};

use super::accessor::Component;
use super::document::format_error;
use super::{TRIANGLE_STRIP, TRIANGLES};
use crate::error::Error;
use crate::model::Drawing;

/// The restart index, before it takes the width of the others.
const RESTART: u32 = u32::MAX;

/// What one primitive draws.
pub(super) struct Run {
    pub(super) mode: u64,
    /// At least one index; [`RESTART`] between strips.
    indices: Vec<u32>,
    /// Highest index, restarts aside.
    highest: u32,
}

impl Run {
    fn new(mode: u64, indices: Vec<u32>) -> Self {
        let highest = indices.iter().copied().filter(|&i| i != RESTART).max().unwrap_or(0);
        Self { mode, indices, highest }
    }

    pub(super) fn count(&self) -> usize {
        self.indices.len()
    }

    pub(super) fn restarts(&self) -> bool {
        self.indices.contains(&RESTART)
    }

    /// Chooses the smallest type in which no index has the highest value.
    pub(super) fn component(&self) -> Component {
        match self.highest {
            0..0xFF => Component::U8,
            0xFF..0xFFFF => Component::U16,
            _ => Component::U32,
        }
    }

    /// Adds the indices at the end, in the type chosen.
    pub(super) fn pack(&self, out: &mut Vec<u8>) {
        // Truncation turns the restart index into the highest value of the type.
        match self.component() {
            Component::U8 => out.extend(self.indices.iter().map(|&i| i as u8)),
            Component::U16 => out.extend(self.indices.iter().flat_map(|&i| (i as u16).to_le_bytes())),
            _ => out.extend(self.indices.iter().flat_map(|i| i.to_le_bytes())),
        }
    }
}

/// Lays a drawing out: one run, or with [`Layout::Separate`] one for each strip; at least one.
pub(super) fn runs(
    part: usize,
    mesh: &Mesh,
    drawing: Drawing<'_>,
    layout: Layout,
) -> Result<Vec<Run>, Error> {
    let mut runs = match drawing {
        Drawing::Faces => vec![Run::new(TRIANGLES, face_triangles(mesh))],
        Drawing::Strips(strips) => {
            check(part, mesh, strips)?;
            match layout {
                Layout::Restart => vec![Run::new(TRIANGLE_STRIP, to_restart(strips))],
                Layout::Degenerate => vec![Run::new(TRIANGLE_STRIP, strips.to_degenerate())],
                Layout::List => vec![Run::new(TRIANGLES, strips.to_list())],
                Layout::Separate => {
                    drawn(strips).map(|strip| Run::new(TRIANGLE_STRIP, strip.to_vec())).collect()
                }
            }
        }
    };
    runs.retain(|run| !run.indices.is_empty());
    if runs.is_empty() {
        runs.push(Run::new(TRIANGLES, vec![0; 3]));
    }
    Ok(runs)
}

fn check(part: usize, mesh: &Mesh, strips: &Strips) -> Result<(), Error> {
    match strips.vertices().iter().enumerate().find(|&(_, &v)| v as usize >= mesh.vertex_count()) {
        None => Ok(()),
        Some((at, vertex)) => Err(format_error(
            format!("strips of part {part}, vertex {at}"),
            format!("index {vertex}"),
            format!("less than {}, the number of vertices", mesh.vertex_count()),
        )),
    }
}

/// Walks over the strips that draw anything.
fn drawn(strips: &Strips) -> impl Iterator<Item = &[u32]> {
    strips.iter().filter(|strip| strip_triangles(strip).next().is_some())
}

fn to_restart(strips: &Strips) -> Vec<u32> {
    let mut kept = Strips::default();
    if drawn(strips).count() == strips.len() {
        return strips.to_restart(RESTART);
    }
    drawn(strips).for_each(|strip| kept.push(strip));
    kept.to_restart(RESTART)
}

/// Turns faces into triangles, polygons as fans around their first corner.
fn face_triangles(mesh: &Mesh) -> Vec<u32> {
    match mesh.faces().as_triangles() {
        Some(corners) => corners.to_vec(),
        None => mesh
            .faces()
            .iter()
            .flat_map(|face| (2..face.len()).flat_map(|i| [face[0], face[i - 1], face[i]]))
            .collect(),
    }
}
