//! From tables to parts: one for each material, with vertices that are distinct triples of indices.

use rustc_hash::FxHashMap;
use tristrip::{Attribute, AttributeData, Mesh};

use super::read::{Group, NONE, Tables};
use crate::polygons::Polygons;
use crate::{Error, Part};

/// Makes the parts.
pub(super) fn split(mut tables: Tables, notes: &mut Vec<String>) -> Result<Vec<Part>, Error> {
    // Colours and corner tables stop where the last value stood.
    let corner_count = tables.polygons.corners().len();
    if !tables.texcoord_of.is_empty() {
        tables.texcoord_of.resize(corner_count, NONE);
    }
    if !tables.normal_of.is_empty() {
        tables.normal_of.resize(corner_count, NONE);
    }
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
        return Ok(vec![Part {
            name: group.name,
            material: group.material,
            mesh,
            stripped: false,
            stored: None,
        }]);
    }
    let missing = |column: &[u32]| column.iter().filter(|&&i| i == NONE).count();
    for (column, what) in [(&tables.texcoord_of, "texture coordinate"), (&tables.normal_of, "normal")] {
        if missing(column) > 0 {
            notes.push(format!("corners without a {what}, 0 in its place: {}", missing(column)));
        }
    }
    let used = used_positions(&tables).iter().filter(|&&used| used).count();
    if used < tables.positions.len() {
        notes.push(format!("vertices that no face uses dropped: {}", tables.positions.len() - used));
    }
    groups.into_iter().map(|group| part(&tables, group)).collect()
}

/// Makes a part of the faces of one material, over the vertices that they use, in order of first use.
fn part(tables: &Tables, group: Group) -> Result<Part, Error> {
    let column = |column: &[u32], corner: usize| column.get(corner).copied().unwrap_or(NONE);
    let mut ids: FxHashMap<[u32; 3], u32> = FxHashMap::default();
    let mut vertices: Vec<[u32; 3]> = Vec::new();
    let mut polygons = Polygons::default();
    for face in group.runs.iter().flat_map(|&(start, end)| start..end) {
        for corner in tables.polygons.range(face) {
            let vertex = [
                tables.polygons.corners()[corner],
                column(&tables.texcoord_of, corner),
                column(&tables.normal_of, corner),
            ];
            let id = *ids.entry(vertex).or_insert_with(|| {
                vertices.push(vertex);
                vertices.len() as u32 - 1
            });
            polygons.push(id);
        }
        polygons.end_face();
    }
    drop(ids);
    let positions: Vec<[f32; 3]> = vertices.iter().map(|v| tables.positions[v[0] as usize]).collect();
    let mut mesh = Mesh::new(positions, polygons.finish()?)?;
    if vertices.iter().any(|v| v[2] != NONE) {
        let normals = vertices.iter().flat_map(|v| row(&tables.normals, v[2])).collect();
        mesh = mesh.with_attribute(floats("NORMAL", 3, AttributeData::F32(normals)))?;
    }
    if vertices.iter().any(|v| v[1] != NONE) {
        let texcoords = vertices.iter().flat_map(|v| row(&tables.texcoords, v[1])).collect();
        mesh = mesh.with_attribute(floats("TEXCOORD_0", 2, AttributeData::F32(texcoords)))?;
    }
    if !tables.colours.is_empty() {
        let colours = vertices.iter().flat_map(|v| tables.colours[v[0] as usize]).collect();
        mesh = mesh.with_attribute(floats("COLOR_0", 3, AttributeData::F32(colours)))?;
    }
    Ok(Part { name: group.name, material: group.material, mesh, stripped: false, stored: None })
}

fn row<const N: usize>(rows: &[[f32; N]], index: u32) -> [f32; N] {
    rows.get(index as usize).copied().unwrap_or([0.0; N])
}

fn floats(name: &str, components: u8, data: AttributeData) -> Attribute {
    Attribute { name: name.to_owned(), components, normalized: false, data }
}

fn used_positions(tables: &Tables) -> Vec<bool> {
    let mut used = vec![false; tables.positions.len()];
    for &v in tables.polygons.corners() {
        used[v as usize] = true;
    }
    used
}

/// Says which tables no face names, and so are not kept.
fn note_unused(tables: &Tables, notes: &mut Vec<String>) {
    if tables.texcoord_of.is_empty() && !tables.texcoords.is_empty() {
        notes.push(format!("texture coordinates that no face uses dropped: {}", tables.texcoords.len()));
    }
    if tables.normal_of.is_empty() && !tables.normals.is_empty() {
        notes.push(format!("normals that no face uses dropped: {}", tables.normals.len()));
    }
}
