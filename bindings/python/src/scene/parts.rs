//! Conversion between scenes and parts.

use tristrip_io::{Materials, Model};

use super::data::SceneData;
use super::materials::NamedMaterial;
use super::part::Part;
use crate::errors::Failure;

/// Returns the parts of a scene.
pub(crate) fn parts_of(scene: &SceneData) -> Result<Vec<Part>, Failure> {
    let model = scene.model();
    let counts_down = match (&model.scene, &model.materials) {
        (Some(_), _) => Some(true),
        (None, Some(materials)) => Some(materials.counts_down),
        (None, None) => None,
    };
    let parts = model.parts.iter().zip(scene.materials()?).map(|(part, plain)| Part {
        inner: part.clone(),
        material: NamedMaterial { name: part.material.clone(), plain: plain.clone() },
        counts_down,
    });
    Ok(parts.collect())
}

/// Builds a scene of parts. Unnamed materials get a name; equal materials are merged.
pub(crate) fn scene_of(parts: &[Part]) -> Result<SceneData, Failure> {
    // The scene takes its texture origin from the first part that defines one.
    let counts_down = parts.iter().find_map(|part| part.counts_down);
    let mut materials = Materials::default();
    materials.counts_down = counts_down.unwrap_or_default();
    let mut model = Model::default();
    let mut notes = Vec::new();
    for (number, part) in parts.iter().enumerate() {
        let NamedMaterial { name, plain } = &part.material;
        let name = match (name, plain) {
            (None, None) => None,
            (Some(name), None) => Some(name.clone()),
            (Some(name), Some(plain)) => {
                if !materials.add_plain(name, plain) {
                    let found = format!("another one named {name:?} in part {number}");
                    return Err(Failure::option("material", found, "a unique name per material"));
                }
                Some(name.clone())
            }
            (None, Some(plain)) => {
                let free = |n: &usize| materials.add_plain(&format!("material_{n}"), plain);
                (0..=number).find(free).map(|n| format!("material_{n}"))
            }
        };
        let mesh = part.mesh_counting(materials.counts_down)?;
        let has_uv = mesh.attributes().iter().any(|attribute| attribute.name == "TEXCOORD_0");
        if !has_uv && plain.as_ref().is_some_and(|plain| plain.image.is_some()) {
            notes.push(format!(
                "part {number}: the image of its material is not shown: no texture coordinates"
            ));
        }
        model.parts.push(tristrip_io::Part { material: name, mesh, ..part.inner.clone() });
    }
    model.materials = (counts_down.is_some() || !materials.is_empty()).then_some(materials);
    Ok(SceneData::of_model(model).with_notes(notes))
}
