//! Writes OBJ: the vertices of all parts, then the faces of each part with its material. Strips are
//! written as triangles.

use std::fmt::Write;

use tristrip::{Attribute, Mesh};

use crate::error::Error;
use crate::join::{self, attribute, clean, material_name};
use crate::model::{Drawing, Model, Part};

/// Writes an OBJ file.
pub(crate) fn write(model: &Model, drawings: &[Drawing]) -> Result<Vec<u8>, Error> {
    model.check_drawings(drawings)?;
    let blocks = join::blocks(model)?;
    if blocks.vertex_count == 0 {
        let message = "nothing to write: the model has no vertices, and an OBJ file needs at least one";
        return Err(Error::Unsupported(message.into()));
    }
    let mut out = String::new();
    for loss in losses(model, drawings) {
        out.push_str("# ");
        out.push_str(&loss);
        out.push('\n');
    }
    for library in model.materials.iter().flat_map(|materials| &materials.libraries) {
        out.push_str("mtllib ");
        out.push_str(&clean(library));
        out.push('\n');
    }
    // Texture coordinates of a scene have their origin at the top, those of OBJ at the bottom.
    let counts_down = model.materials.as_ref().is_some_and(|materials| materials.counts_down);
    let flips = model.scene.is_some() || counts_down;
    // Texture coordinates and normals are counted separately, because a block may lack them.
    let mut bases = vec![[0u64; 2]; model.parts.len()];
    let mut next = [0u64; 2];
    for &part in &blocks.parts {
        let mesh = &model.parts[part].mesh;
        bases[part] = next;
        write_vertices(mesh, flips, &mut out);
        for (next, attribute) in next.iter_mut().zip([texcoord(mesh), normal(mesh)]) {
            *next += if attribute.is_some() { mesh.vertex_count() as u64 } else { 0 };
        }
    }
    for (i, (part, drawing)) in model.parts.iter().zip(drawings).enumerate() {
        write_names(part, i, model.parts.len(), &mut out);
        let [vt, vn] = bases[blocks.owners[i]];
        let indices = IndexBases {
            base: u64::from(blocks.bases[i]) + 1,
            texcoord: texcoord(&part.mesh).map(|_| vt + 1),
            normal: normal(&part.mesh).map(|_| vn + 1),
        };
        match drawing {
            Drawing::Faces => part
                .mesh
                .faces()
                .iter()
                .filter(|face| face.len() >= 3)
                .for_each(|face| indices.write_face(face, &mut out)),
            Drawing::Strips(strips) => strips.triangles().for_each(|t| indices.write_face(&t, &mut out)),
        }
    }
    Ok(out.into_bytes())
}

/// Lists the data of a model that OBJ cannot represent.
pub(crate) fn losses(model: &Model, drawings: &[Drawing]) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    for attribute in model.parts.iter().flat_map(|part| part.mesh.attributes()) {
        let kept = match attribute.name.as_str() {
            "NORMAL" | "COLOR_0" => attribute.components >= 3,
            "TEXCOORD_0" => attribute.components >= 2,
            _ => false,
        };
        let loss = match (kept, attribute.name.as_str(), attribute.components) {
            (true, "COLOR_0", 4..) => "alpha of COLOR_0 not written".to_owned(),
            (true, ..) => continue,
            (false, name, _) => format!("attribute {} not written", clean(name)),
        };
        if !out.contains(&loss) {
            out.push(loss);
        }
    }
    let small = |part: &Part| part.mesh.faces().iter().filter(|face| face.len() < 3).count();
    let small: usize = join::drawn_by_faces(model, drawings).map(small).sum();
    if small > 0 {
        out.push(format!("faces of fewer than three corners not written: {small}"));
    }
    out.extend(join::scene_losses(model));
    out
}

fn texcoord(mesh: &Mesh) -> Option<&Attribute> {
    attribute(mesh, "TEXCOORD_0", 2)
}

fn normal(mesh: &Mesh) -> Option<&Attribute> {
    attribute(mesh, "NORMAL", 3)
}

fn write_vertices(mesh: &Mesh, flips: bool, out: &mut String) {
    let colour = attribute(mesh, "COLOR_0", 3);
    for (vertex, position) in mesh.positions().iter().enumerate() {
        out.push('v');
        for &x in position {
            write_number(x, out);
        }
        if let Some(colour) = colour {
            write_values(colour, vertex, 3, false, out);
        }
        out.push('\n');
    }
    for (keyword, attribute, components) in [("vt", texcoord(mesh), 2), ("vn", normal(mesh), 3)] {
        let Some(attribute) = attribute else { continue };
        for vertex in 0..mesh.vertex_count() {
            out.push_str(keyword);
            write_values(attribute, vertex, components, flips && keyword == "vt", out);
            out.push('\n');
        }
    }
}

/// Writes the first values of a vertex; `flips` subtracts the second value from 1.
fn write_values(attribute: &Attribute, vertex: usize, components: usize, flips: bool, out: &mut String) {
    let first = vertex * usize::from(attribute.components);
    for i in first..first + components {
        let value = attribute.float(i).filter(|value| value.is_finite());
        let value = value.unwrap_or(0.0);
        write_number(if flips && i == first + 1 { 1.0 - value } else { value }, out);
    }
}

/// Writes the shortest decimal that parses to the same 32-bit float.
fn write_number(value: f32, out: &mut String) {
    let size = value.abs();
    // Writing to a string cannot fail.
    let _ = if size == 0.0 || (1e-4..1e9).contains(&size) {
        write!(out, " {value}")
    } else {
        write!(out, " {value:e}")
    };
}

/// Writes the names of a part.
fn write_names(part: &Part, index: usize, part_count: usize, out: &mut String) {
    let name = part.name.as_deref().map(clean).filter(|name| !name.is_empty());
    let material = material_name(part, index, part_count);
    for (keyword, name) in [("o", name), ("usemtl", material)] {
        if let Some(name) = name {
            let _ = writeln!(out, "{keyword} {name}");
        }
    }
}

/// The offsets added to the indices of a part.
struct IndexBases {
    base: u64,
    texcoord: Option<u64>,
    normal: Option<u64>,
}

impl IndexBases {
    fn write_face(&self, face: &[u32], out: &mut String) {
        out.push('f');
        for &v in face {
            let v = u64::from(v);
            let _ = match (self.texcoord, self.normal) {
                (None, None) => write!(out, " {}", v + self.base),
                (Some(t), None) => write!(out, " {}/{}", v + self.base, v + t),
                (None, Some(n)) => write!(out, " {}//{}", v + self.base, v + n),
                (Some(t), Some(n)) => write!(out, " {}/{}/{}", v + self.base, v + t, v + n),
            };
        }
        out.push('\n');
    }
}
