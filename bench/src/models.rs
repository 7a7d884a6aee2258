//! Models to measure: found in a directory, and converted to the index buffers that the peers read.
//!
//! Peers accept only index buffers of triangles. Polygons become fans, and triangles that repeat a
//! vertex are dropped. An OBJ is read by its positions: seams of texture coordinates and normals do
//! not split vertices. A GLB is flattened: every node with a mesh adds the mesh's primitives, one
//! after the other, each with its own vertices.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use tristrip::{Faces, Mesh};
use tristrip_io::{Format, Model};

use crate::failure::Failure;

/// A model file.
#[derive(Debug, Clone)]
pub struct Source {
    /// The file name without its extension.
    pub name: String,
    /// Its path.
    pub path: PathBuf,
}

/// A model as triangles and as polygons.
#[derive(Debug, Clone)]
pub struct LoadedModel {
    /// The index buffer that the peers read.
    pub triangles: Mesh,
    /// The faces of the file; `None` if all are triangles.
    pub polygons: Option<Mesh>,
}

/// Returns the model directory next to the checkout, or the repository's own if there is none.
pub fn default_folder() -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let shared = root.join("../shared/models");
    if shared.is_dir() { shared } else { root.join("testdata/models") }
}

/// Returns the models of a directory, sorted by name.
///
/// # Errors
/// The directory cannot be read.
pub fn find(folder: &Path) -> Result<Vec<Source>, Failure> {
    let entries = fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut sources = Vec::new();
    for entry in entries {
        let path = entry?.path();
        let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
        if let (Some(name), Some(_)) = (name, Format::from_path(&path)) {
            sources.push(Source { name, path });
        }
    }
    sources.sort_by(|a, b| a.name.cmp(&b.name));
    if sources.is_empty() {
        return Err(format!("{}: found no model", folder.display()).into());
    }
    Ok(sources)
}

/// The flags that select models.
#[derive(Debug, clap::Args)]
pub struct ModelArgs {
    /// The directory of models [default: ../shared/models next to the checkout, else
    /// testdata/models]
    models: Option<PathBuf>,
    /// Measure only this model; repeatable
    #[arg(long, value_name = "NAME")]
    model: Vec<String>,
}

impl ModelArgs {
    /// Returns the models of the directory with one of the names, or all models if there are no
    /// names.
    ///
    /// # Errors
    /// The directory cannot be read.
    pub fn sources(&self) -> Result<Vec<Source>, Failure> {
        let mut sources = find(&self.models.clone().unwrap_or_else(default_folder))?;
        sources.retain(|source| self.model.is_empty() || self.model.contains(&source.name));
        Ok(sources)
    }
}

/// Reads a model as triangles and as polygons.
///
/// # Errors
/// The file cannot be read.
pub fn load(source: &Source) -> Result<LoadedModel, Failure> {
    let say = |error: Failure| format!("{}: {error}", source.path.display());
    let mesh = joined(&source.path).map_err(say)?;
    let triangles = Mesh::new(mesh.shared_positions(), fans(mesh.faces())?)?;
    let polygons = mesh.faces().as_triangles().is_none().then_some(mesh);
    Ok(LoadedModel { triangles, polygons })
}

/// Triangulates every face as a fan, and drops triangles that repeat a vertex.
fn fans(faces: &Faces) -> Result<Faces, tristrip::Error> {
    let mut corners = Vec::with_capacity(3 * faces.triangle_count());
    for face in faces.iter().filter(|face| face.len() >= 3) {
        for pair in face[1..].windows(2) {
            let triangle = [face[0], pair[0], pair[1]];
            if triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0] {
                corners.extend(triangle);
            }
        }
    }
    Faces::from_triangles(corners)
}

/// Reads a file as one mesh.
fn joined(path: &Path) -> Result<Mesh, Failure> {
    match Format::from_path(path) {
        Some(Format::Obj) => {
            let model = tristrip_io::read(&positions_only(&fs::read(path)?), Format::Obj)?;
            join(&model, 0..model.parts.len())
        }
        Some(Format::Glb) => {
            let bytes = fs::read(path)?;
            let model = tristrip_io::read(&bytes, Format::Glb)?;
            let order = instances(&bytes)?;
            join(&model, order.into_iter())
        }
        _ => {
            let model = tristrip_io::read_path(path)?;
            join(&model, 0..model.parts.len())
        }
    }
}

/// Concatenates parts, each with its own vertices.
fn join(model: &Model, order: impl ExactSizeIterator<Item = usize>) -> Result<Mesh, Failure> {
    if model.parts.len() == 1 && order.len() == 1 {
        return Ok(model.parts[0].mesh.clone());
    }
    let (mut positions, mut offsets, mut corners) = (Vec::new(), vec![0], Vec::new());
    for part in order {
        let mesh = &model.parts.get(part).ok_or("a node refers to a primitive that was not read")?.mesh;
        let base = positions.len() as u32;
        positions.extend_from_slice(mesh.positions());
        for face in mesh.faces().iter() {
            corners.extend(face.iter().map(|&v| base + v));
            offsets.push(corners.len() as u32);
        }
    }
    Ok(Mesh::new(positions, Faces::from_offsets(offsets, corners)?)?)
}

/// Reduces an OBJ to its positions and its faces by position.
fn positions_only(bytes: &[u8]) -> Vec<u8> {
    let text = String::from_utf8_lossy(bytes);
    let mut out = String::with_capacity(text.len());
    for line in text.lines() {
        if line.starts_with("v ") {
            out.push_str(line);
            out.push('\n');
        } else if let Some(face) = line.strip_prefix("f ") {
            out.push('f');
            for corner in face.split_whitespace() {
                out.push(' ');
                out.push_str(corner.split('/').next().unwrap_or_default());
            }
            out.push('\n');
        }
    }
    out.into_bytes()
}

/// Returns the parts that the scene of a GLB draws, once per node with their mesh.
fn instances(glb: &[u8]) -> Result<Vec<usize>, Failure> {
    let length = glb.get(12..16).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes).unwrap_or_default();
    let json: Value =
        serde_json::from_slice(glb.get(20..20 + length as usize).ok_or("the JSON chunk is cut off")?)?;
    let items = |value: &Value, key: &str| value[key].as_array().cloned().unwrap_or_default();
    let number = |value: &Value| value.as_u64().map(|n| n as usize);
    let mut parts_of_mesh = Vec::new();
    let mut part_count = 0;
    for mesh in items(&json, "meshes") {
        let drawn =
            items(&mesh, "primitives").iter().filter(|p| p["mode"].as_u64().unwrap_or(4) >= 4).count();
        parts_of_mesh.push(part_count..part_count + drawn);
        part_count += drawn;
    }
    let nodes = items(&json, "nodes");
    let scene = number(&json["scene"]).unwrap_or(0);
    let mut waiting: Vec<usize> = items(&json["scenes"][scene], "nodes").iter().filter_map(number).collect();
    waiting.reverse();
    let (mut order, mut seen) = (Vec::new(), vec![false; nodes.len()]);
    while let Some(at) = waiting.pop() {
        let Some(node) = nodes.get(at).filter(|_| !std::mem::replace(&mut seen[at], true)) else { continue };
        if let Some(parts) = number(&node["mesh"]).and_then(|mesh| parts_of_mesh.get(mesh)) {
            order.extend(parts.clone());
        }
        waiting.extend(items(node, "children").iter().filter_map(number).rev());
    }
    Ok(order)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_obj_loses_its_seams() {
        let obj =
            b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 1\nusemtl a\nf 1/1 2/1 3/2\nusemtl b\nf 1/2 3/1 2/2\n";
        assert_eq!(positions_only(obj), b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 3 2\n");
    }

    #[test]
    fn fans_drop_degenerate_triangles() {
        let faces = Faces::from_polygons([vec![0, 1, 2, 2, 3], vec![4, 4, 5], vec![6, 7]]).unwrap();
        assert_eq!(fans(&faces).unwrap().corners(), [0, 1, 2, 0, 2, 3]);
    }

    #[test]
    fn a_scene_is_flattened() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../testdata/models");
        let path = folder.join("milktruck.glb");
        let fed = load(&Source { name: "milktruck".into(), path }).unwrap();
        assert_eq!(fed.triangles.faces().face_count(), 3624);
        let names: Vec<String> = find(&folder).unwrap().into_iter().map(|s| s.name).collect();
        assert_eq!(names[0], "catmark_bishop");
    }
}
