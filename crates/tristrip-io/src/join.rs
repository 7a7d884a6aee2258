//! What the writers share: several parts over one list of vertices, and attributes as plain numbers.
//!
//! Parts that share their vertices (as the primitives of a glTF mesh do) have them written once.

use rustc_hash::FxHashMap;
use tristrip::mesh::MAX_COUNT;
use tristrip::{Attribute, AttributeData, Error as MeshError, Mesh, MeshProblem};

use crate::{Drawing, Error, Model};

/// The vertices of all parts, one block after the other.
#[derive(Debug)]
pub(crate) struct Blocks {
    /// The parts whose vertices are written, in order.
    pub(crate) parts: Vec<usize>,
    /// For each part the one whose vertices it is drawn over: itself, or an earlier part with the same ones.
    pub(crate) owners: Vec<usize>,
    /// For each part the number of vertices before its own.
    pub(crate) bases: Vec<u32>,
    /// Number of vertices in all blocks.
    pub(crate) vertex_count: usize,
}

/// Lays out the vertices of a model.
///
/// # Errors
/// All parts together have more vertices than 32-bit ids can name.
pub(crate) fn blocks(model: &Model) -> Result<Blocks, Error> {
    let mut out = Blocks { parts: Vec::new(), owners: Vec::new(), bases: Vec::new(), vertex_count: 0 };
    let mut seen: FxHashMap<*const [f32; 3], usize> = FxHashMap::default();
    for (i, part) in model.parts.iter().enumerate() {
        let first = *seen.entry(part.mesh.positions().as_ptr()).or_insert(i);
        if first < i && same_vertices(&model.parts[first].mesh, &part.mesh) {
            out.owners.push(first);
            out.bases.push(out.bases[first]);
            continue;
        }
        out.parts.push(i);
        out.owners.push(i);
        out.bases.push(out.vertex_count as u32);
        out.vertex_count += part.mesh.vertex_count();
        if out.vertex_count > MAX_COUNT {
            let (at, found) = ("vertices of all parts".to_owned(), out.vertex_count as u64);
            return Err(Error::LimitExceeded { at, found, limit: MAX_COUNT as u64 });
        }
    }
    Ok(out)
}

fn same_vertices(a: &Mesh, b: &Mesh) -> bool {
    a.shares_vertices(b) || (a.vertex_count() == b.vertex_count() && a.attributes() == b.attributes())
}

/// Names what is around the parts, for formats that hold parts alone.
pub(crate) fn scene_losses(model: &Model) -> impl Iterator<Item = String> {
    let scene = model.scene.iter().flat_map(crate::gltf::Scene::beyond_parts);
    scene.map(|what| format!("not written: {what}"))
}

/// Checks that there is one drawing for each part, over vertices that the part has.
pub(crate) fn check_drawings(model: &Model, drawings: &[Drawing]) -> Result<(), Error> {
    if drawings.len() != model.parts.len() {
        let (found, expected) = (drawings.len(), model.parts.len());
        return Err(Error::Unsupported(format!(
            "drawings: found {found}, expected {expected} (one for each part)"
        )));
    }
    for (part, drawing) in model.parts.iter().zip(drawings) {
        let Drawing::Strips(strips) = drawing else { continue };
        let vertex_count = part.mesh.vertex_count() as u32;
        for (face, strip) in strips.iter().enumerate() {
            if let Some(corner) = strip.iter().position(|&v| v >= vertex_count) {
                let (face, found) = (face as u32, strip[corner]);
                let corner = corner as u32;
                let problem = MeshProblem::VertexIndex { face, corner, found, vertex_count };
                return Err(MeshError::Mesh(problem).into());
            }
        }
    }
    Ok(())
}

/// Gives the attribute of a name with at least so many components.
pub(crate) fn attribute<'a>(mesh: &'a Mesh, name: &str, components: u8) -> Option<&'a Attribute> {
    mesh.attributes().iter().find(|a| a.name == name && a.components >= components)
}

/// Gives value `i` as a float: a normalized integer as the fraction that it stands for.
pub(crate) fn float(attribute: &Attribute, i: usize) -> f32 {
    let fraction =
        |value: f32, most: f32| if attribute.normalized { (value / most).max(-1.0) } else { value };
    match &attribute.data {
        AttributeData::F32(v) => v[i],
        AttributeData::F64(v) => v[i] as f32,
        AttributeData::U8(v) => fraction(v[i].into(), u8::MAX.into()),
        AttributeData::I8(v) => fraction(v[i].into(), i8::MAX.into()),
        AttributeData::U16(v) => fraction(v[i].into(), u16::MAX.into()),
        AttributeData::I16(v) => fraction(v[i].into(), i16::MAX.into()),
        AttributeData::U32(v) => fraction(v[i] as f32, u32::MAX as f32),
        AttributeData::I32(v) => fraction(v[i] as f32, i32::MAX as f32),
    }
}

/// Gives a name that no file format mistakes for its own words: one line, without control characters.
pub(crate) fn clean(name: &str) -> String {
    let name: String = name.trim().chars().map(|c| if c.is_control() { '_' } else { c }).collect();
    match name.strip_suffix('\\') {
        Some(start) => format!("{start}_"),
        None => name,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Part;
    use tristrip::Faces;

    fn part(mesh: &Mesh) -> Part {
        Part { mesh: mesh.clone(), ..Part::default() }
    }

    #[test]
    fn shared_vertices_make_one_block() {
        let shared = Mesh::new(vec![[0.0; 3]; 4], Faces::default()).unwrap();
        let other = Mesh::new(vec![[0.0; 3]; 4], Faces::default()).unwrap();
        let parts = vec![part(&shared), part(&other), part(&shared)];
        let blocks = blocks(&Model { parts, ..Model::default() }).unwrap();
        assert_eq!((blocks.parts, blocks.owners, blocks.bases), (vec![0, 1], vec![0, 1, 0], vec![0, 4, 0]));
    }

    #[test]
    fn drawings_are_checked() {
        let mesh = Mesh::new(vec![[0.0; 3]; 3], Faces::default()).unwrap();
        let model = Model { parts: vec![part(&mesh)], ..Model::default() };
        assert!(check_drawings(&model, &[]).is_err());
        let mut strips = tristrip::Strips::default();
        strips.push(&[0, 1, 3]);
        let wrong = check_drawings(&model, &[Drawing::Strips(&strips)]).unwrap_err();
        assert_eq!(wrong.to_string(), "face 0, corner 2: found vertex index 3, expected less than 3");
    }

    #[test]
    fn names_stay_on_their_line() {
        assert_eq!(clean(" a\nf 1 2 3 \\"), "a_f 1 2 3 _");
    }
}
