//! Builds parts from tables: one part per material. Vertices are distinct triples of indices.

use std::collections::HashMap;

use tristrip::{Attribute, AttributeData, Mesh};

use super::tables::{MaterialGroup, ObjTables, OptionalIndex};
use crate::error::Error;
use crate::model::Part;
use crate::polygons::Polygons;

/// The indices of a vertex into the tables.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct IndexTriple {
    position: u32,
    texcoord: OptionalIndex,
    normal: OptionalIndex,
}

/// Builds the parts.
pub(super) fn split(mut tables: ObjTables, notes: &mut Vec<String>) -> Result<Vec<Part>, Error> {
    let mut groups = std::mem::take(&mut tables.groups);
    let has_seams = !tables.texcoord_of.is_empty() || !tables.normal_of.is_empty();
    note_unused(&tables, notes);
    if groups.len() <= 1 && !has_seams {
        let group = groups.pop().unwrap_or_default();
        let mut mesh = Mesh::new(tables.positions, tables.polygons.finish()?)?;
        if !tables.colours.is_empty() {
            let colours = AttributeData::F32(tables.colours.into_flattened());
            mesh = mesh.with_attribute(floats("COLOR_0", 3, colours))?;
        }
        return Ok(vec![Part { name: group.name, material: group.material, mesh, ..Part::default() }]);
    }
    let corner_count = tables.polygons.corners().len();
    for (column, what) in [(&tables.texcoord_of, "texture coordinate"), (&tables.normal_of, "normal")] {
        let missing = column.missing(corner_count);
        if missing > 0 {
            notes.push(format!("corners without a {what}, set to 0: {missing}"));
        }
    }
    let used = used_positions(&tables).iter().filter(|&&used| used).count();
    if used < tables.positions.len() {
        notes.push(format!("unused vertices dropped: {}", tables.positions.len() - used));
    }
    groups.into_iter().map(|group| part(&tables, group)).collect()
}

/// Builds a part from the faces of one material, over the vertices that they use, in order of first
/// use.
fn part(tables: &ObjTables, group: MaterialGroup) -> Result<Part, Error> {
    // The random seed protects against files with colliding indices; the result does not depend on
    // it.
    let mut ids: HashMap<IndexTriple, u32> = HashMap::new();
    let mut vertices: Vec<IndexTriple> = Vec::new();
    let mut polygons = Polygons::default();
    for face in group.runs.iter().flat_map(|&(start, end)| start..end) {
        for corner in tables.polygons.range(face) {
            let vertex = IndexTriple {
                position: tables.polygons.corners()[corner],
                texcoord: tables.texcoord_of.get(corner),
                normal: tables.normal_of.get(corner),
            };
            let id = *ids.entry(vertex).or_insert_with(|| {
                vertices.push(vertex);
                vertices.len() as u32 - 1
            });
            polygons.push(id);
        }
        polygons.end_face();
    }
    drop(ids);
    let positions: Vec<[f32; 3]> = vertices.iter().map(|v| tables.positions[v.position as usize]).collect();
    let mut mesh = Mesh::new(positions, polygons.finish()?)?;
    if vertices.iter().any(|v| v.normal.get().is_some()) {
        let normals = vertices.iter().flat_map(|v| row(&tables.normals, v.normal)).collect();
        mesh = mesh.with_attribute(floats("NORMAL", 3, AttributeData::F32(normals)))?;
    }
    if vertices.iter().any(|v| v.texcoord.get().is_some()) {
        let texcoords = vertices.iter().flat_map(|v| row(&tables.texcoords, v.texcoord)).collect();
        mesh = mesh.with_attribute(floats("TEXCOORD_0", 2, AttributeData::F32(texcoords)))?;
    }
    if !tables.colours.is_empty() {
        let colours = vertices.iter().flat_map(|v| tables.colours[v.position as usize]).collect();
        mesh = mesh.with_attribute(floats("COLOR_0", 3, AttributeData::F32(colours)))?;
    }
    Ok(Part { name: group.name, material: group.material, mesh, ..Part::default() })
}

/// Returns a row of a table, or zeros if there is no index.
fn row<const N: usize>(rows: &[[f32; N]], index: OptionalIndex) -> [f32; N] {
    index.get().and_then(|index| rows.get(index as usize).copied()).unwrap_or([0.0; N])
}

fn floats(name: &str, components: u8, data: AttributeData) -> Attribute {
    Attribute { name: name.to_owned(), components, normalized: false, data }
}

fn used_positions(tables: &ObjTables) -> Vec<bool> {
    let mut used = vec![false; tables.positions.len()];
    for &v in tables.polygons.corners() {
        used[v as usize] = true;
    }
    used
}

/// Adds notes on tables that are dropped because no face refers to them.
fn note_unused(tables: &ObjTables, notes: &mut Vec<String>) {
    if tables.texcoord_of.is_empty() && !tables.texcoords.is_empty() {
        notes.push(format!("unused texture coordinates dropped: {}", tables.texcoords.len()));
    }
    if tables.normal_of.is_empty() && !tables.normals.is_empty() {
        notes.push(format!("unused normals dropped: {}", tables.normals.len()));
    }
}
