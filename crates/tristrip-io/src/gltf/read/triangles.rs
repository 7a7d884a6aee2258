//! The triangles of primitives: each index array is decoded once, and copied for other primitives
//! with the same indices.

use std::collections::HashMap;

use tristrip::{Faces, Mesh};

use crate::error::Error;
use crate::gltf::document::Located;
use crate::gltf::document::accessor::{AccessorResolver, StripIndices};
use crate::gltf::document::budget::{DecodeBudget, DrawBudget};
use crate::gltf::document::spec::{TRIANGLE_FAN, TRIANGLE_STRIP, TRIANGLES};
use crate::model::{Part, StoredStrips};

/// Maximum number of indices per triangle in a strip layout that this crate writes: an isolated
/// triangle with degenerate joins.
const INDICES_PER_TRIANGLE: u64 = 6;

/// Reads the triangles of primitives.
#[derive(Default)]
pub(in crate::gltf) struct TriangleReader {
    /// By indices and mode.
    known: HashMap<(IndexSource, u64), KnownTriangles>,
    draws: DrawBudget,
    /// Counts of all primitives.
    pub(in crate::gltf) counts: TriangleCounts,
}

/// The source of a primitive's indices.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum IndexSource {
    Accessor(usize),
    /// Every vertex in order, with the number of vertices.
    AllVertices(usize),
}

/// The triangles of an earlier primitive.
struct KnownTriangles {
    part: usize,
    /// Their weight in the budget.
    weight: u64,
    counts: TriangleCounts,
}

/// Counts for the notes.
#[derive(Clone, Copy, Default)]
pub(in crate::gltf) struct TriangleCounts {
    pub(in crate::gltf) degenerate: u64,
    pub(in crate::gltf) restarts: u64,
    pub(in crate::gltf) incomplete_indices: u64,
}

impl TriangleCounts {
    fn add(&mut self, other: Self) {
        self.degenerate += other.degenerate;
        self.restarts += other.restarts;
        self.incomplete_indices += other.incomplete_indices;
    }
}

/// The corners of a primitive's triangles, and its indices if these are strips or fans.
struct DecodedTriangles {
    corners: Vec<u32>,
    stored: Option<StoredStrips>,
    weight: u64,
    counts: TriangleCounts,
}

impl TriangleReader {
    /// Reads the triangles of a primitive over its vertices; `parts` contains the parts of earlier
    /// primitives.
    pub(in crate::gltf) fn read<'a>(
        &mut self,
        resolver: &AccessorResolver<'a>,
        primitive: &Located<'a>,
        mode: u64,
        vertices: &Mesh,
        parts: &[Part],
        budget: &mut DecodeBudget,
    ) -> Result<(Mesh, Option<StoredStrips>), Error> {
        let vertex_count = vertices.vertex_count();
        let indices = primitive.field("indices");
        let source = match &indices {
            Some(accessor) => IndexSource::Accessor(accessor.size()?),
            None => IndexSource::AllVertices(vertex_count),
        };
        if let Some(known) = self.known.get(&(source, mode))
            && fits(&parts[known.part], vertex_count)
        {
            self.draws.charge(&primitive.at, known.weight, false)?;
            self.counts.add(known.counts);
            let first = &parts[known.part];
            return Ok((vertices.with_faces(first.mesh.faces().clone())?, first.stored.clone()));
        }
        let decoded = match &indices {
            Some(accessor) => from_accessor(resolver, accessor, mode, vertex_count, budget)?,
            None => from_all_vertices(primitive, mode, vertex_count, budget)?,
        };
        let DecodedTriangles { corners, stored, weight, counts } = decoded;
        self.draws.charge(&primitive.at, weight, true)?;
        self.counts.add(counts);
        self.known.insert((source, mode), KnownTriangles { part: parts.len(), weight, counts });
        Ok((vertices.with_faces(Faces::from_triangles(corners)?)?, stored))
    }
}

/// Checks whether all indices of a part are below `vertex_count`.
fn fits(part: &Part, vertex_count: usize) -> bool {
    let indices = part.stored.as_ref().map_or(part.mesh.faces().corners(), |stored| stored.runs.vertices());
    indices.iter().all(|&v| (v as usize) < vertex_count)
}

fn from_accessor<'a>(
    resolver: &AccessorResolver<'a>,
    accessor: &Located<'a>,
    mode: u64,
    vertex_count: usize,
    budget: &mut DecodeBudget,
) -> Result<DecodedTriangles, Error> {
    let values = resolver.values(accessor)?;
    if mode == TRIANGLES {
        return Ok(from_list(values.list_indices(vertex_count, budget)?));
    }
    let indices = values.strip_indices(vertex_count, budget)?;
    budget.charge(&values.at, indices.len(), 3 * size_of::<u32>())?;
    Ok(from_strips(indices, mode))
}

fn from_all_vertices(
    primitive: &Located<'_>,
    mode: u64,
    vertex_count: usize,
    budget: &mut DecodeBudget,
) -> Result<DecodedTriangles, Error> {
    let numbers_each = if mode == TRIANGLES { 1 } else { 4 };
    budget.charge(&primitive.at, vertex_count, numbers_each * size_of::<u32>())?;
    Ok(if mode == TRIANGLES {
        from_list((0..vertex_count as u32).collect())
    } else {
        from_strips(StripIndices::all_vertices(vertex_count), mode)
    })
}

fn from_list(mut corners: Vec<u32>) -> DecodedTriangles {
    let incomplete = corners.len() % 3;
    corners.truncate(corners.len() - incomplete);
    let weight = corners.len() as u64 / 3;
    let counts = TriangleCounts { incomplete_indices: incomplete as u64, ..TriangleCounts::default() };
    DecodedTriangles { corners, stored: None, weight, counts }
}

/// Expands strips or fans; degenerate triangles are dropped.
fn from_strips(indices: StripIndices, mode: u64) -> DecodedTriangles {
    debug_assert!(mode == TRIANGLE_FAN || mode == TRIANGLE_STRIP);
    let mut corners = Vec::with_capacity(3 * indices.len());
    let mut counts = TriangleCounts::default();
    for (r, run) in indices.runs().enumerate() {
        counts.restarts = r as u64;
        for i in 2..run.len() {
            let [a, b, c] = if mode == TRIANGLE_FAN {
                [run[0], run[i - 1], run[i]]
            } else if i % 2 == 0 {
                [run[i - 2], run[i - 1], run[i]]
            } else {
                [run[i - 1], run[i - 2], run[i]]
            };
            if a == b || b == c || a == c {
                counts.degenerate += 1;
            } else {
                corners.extend([a, b, c]);
            }
        }
    }
    let triangles = corners.len() as u64 / 3;
    let weight = triangles.max((indices.len() as u64).div_ceil(INDICES_PER_TRIANGLE));
    let fans = mode == TRIANGLE_FAN;
    let stored = Some(match counts.restarts {
        0 => StoredStrips::from_run(indices.into_indices(), fans),
        _ => StoredStrips::from_runs(indices.runs(), fans),
    });
    DecodedTriangles { corners, stored, weight, counts }
}
