//! Builds a material library with the base colours of a glTF scene, or of materials that a program
//! added.

use std::fmt::Write;
use std::sync::Arc;

use crate::gltf::document::scene::Scene;
use crate::gltf::read::appearance::Appearance;
use crate::join::{clean, material_name};
use crate::materials::{Materials, ObjMaterial, SideFile, image_extension};
use crate::model::Part;

/// Builds the library and collects its images. `stem` is the name of the OBJ file without
/// extension.
pub(crate) fn library_of(scene: &Scene, parts: &[Part], stem: &str) -> Materials {
    let library = format!("{stem}.mtl");
    let appearance = match scene.surfaces() {
        Ok(appearance) => appearance,
        Err(error) => {
            let mut out = Materials::new(Vec::new());
            out.problems.push(error.to_string());
            return out;
        }
    };
    let mut out = Materials::new(vec![library.clone()]);
    let mut images = Vec::with_capacity(appearance.images.len());
    for (number, image) in appearance.images.iter().enumerate() {
        images.push(format!("{stem}_{number}.{}", image_extension(image.bytes())));
        out.files.push(SideFile { name: images[number].clone(), bytes: Arc::new(image.bytes().to_vec()) });
    }
    let text = text_of(&appearance, &images, parts, &mut out);
    out.files.push(SideFile { name: library, bytes: Arc::new(text.into_bytes()) });
    out.problems.extend(appearance.notes);
    let shaded = scene.shaded_material_count();
    if shaded > 0 {
        let which = "materials with maps or emission, written with only their base colours";
        out.problems.push(format!("{which}: {shaded}"));
    }
    out
}

/// Builds the library of materials that a program added. Its images are named after the OBJ file.
pub(crate) fn library_of_added(materials: &Materials, stem: &str) -> Materials {
    let library = format!("{stem}.mtl");
    let mut out = Materials::new(vec![library.clone()]);
    out.counts_down = materials.counts_down;
    for (number, file) in materials.files.iter().enumerate() {
        let name = format!("{stem}_{number}.{}", image_extension(&file.bytes));
        out.files.push(SideFile { name, bytes: Arc::clone(&file.bytes) });
    }
    let mut text = String::new();
    for (name, material) in materials.iter() {
        let [r, g, b, opacity] = material.colour;
        let number =
            materials.files.iter().position(|file| material.images[0].as_deref() == Some(&*file.name));
        let image = number.map(|number| out.files[number].name.clone());
        let (name, roughness, metalness) = (clean(name), material.roughness, material.metalness);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "newmtl {name}\nKd {r} {g} {b}\nd {opacity}\nPr {roughness}\nPm {metalness}");
        if let Some(image) = &image {
            let _ = writeln!(text, "map_Kd {}", clean(image));
        }
        let images = [image.map(Into::into), None, None];
        out.add(name, ObjMaterial { images, ..material.clone() });
    }
    out.files.push(SideFile { name: library, bytes: Arc::new(text.into_bytes()) });
    out
}

/// Writes the materials and adds them to `out`.
fn text_of(appearance: &Appearance, images: &[String], parts: &[Part], out: &mut Materials) -> String {
    let mut text = String::new();
    for (number, (part, material)) in parts.iter().zip(&appearance.materials).enumerate() {
        let Some(name) = material_name(part, number, parts.len()) else { continue };
        let [r, g, b, opacity] = material.base_colour;
        let image = material.texture.and_then(|texture| images.get(texture.image));
        let known = ObjMaterial {
            colour: [r, g, b, opacity],
            emissive: [0.0; 3],
            roughness: 1.0,
            metalness: 0.0,
            is_blended: opacity < 1.0,
            images: [image.map(|image| image.as_str().into()), None, None],
        };
        if out.add(name.clone(), known) {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "newmtl {name}\nKd {r} {g} {b}\nd {opacity}");
            if let Some(image) = image {
                let _ = writeln!(text, "map_Kd {}", clean(image));
            }
        }
    }
    text
}
