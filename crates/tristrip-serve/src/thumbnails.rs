//! Thumbnails of models for the gallery: PNG with a transparent background, drawn by the rasterizer
//! of `tristrip-render`.
//!
//! A progressive file is drawn at a level with few triangles, so a large model takes no longer than
//! a small one. Other models that are too large are shown as a cube: models with too many
//! triangles, counted once per instance in the scene, and models with too much overdraw.

use tristrip::Layout;
use tristrip_io::gltf::ProgressiveGlb;
use tristrip_io::{Drawing, Format, Model};
use tristrip_pipeline::{unpack, unpack::StreamGoal};
use tristrip_render::images::{Mode, RenderOptions, TexturedModel};

use crate::deadline::Deadline;
use crate::folder::Folder;
use crate::packing::Source;

/// The width and height in pixels.
const SIZE: [u32; 2] = [320, 240];
/// The number of triangles of the level of a progressive file, and the maximum for other models. At
/// this level, edges are shorter than a pixel.
const LEVEL_TRIANGLES: usize = 200_000;
const MAX_TRIANGLES: usize = 4_000_000;
/// The maximum number of samples that are tested for a thumbnail: about 800 per sample of the
/// image, a few seconds.
const MAX_SAMPLES: u64 = 1 << 30;

/// The options that a thumbnail depends on, for cache keys.
pub(crate) const OPTIONS: &str = "thumbnail 3 320x240";

/// Draws a file of a directory.
pub(crate) fn of_source(
    source: &Source,
    folder: &Folder,
    most_bytes: u64,
    deadline: Deadline,
) -> Result<Vec<u8>, String> {
    if source.format == Format::Glb {
        let bytes = folder.read(&source.path, most_bytes).map_err(|error| error.to_string())?;
        deadline.check()?;
        if let Some(model) = level(bytes)? {
            deadline.check()?;
            return of_model(&model);
        }
    }
    let model = source.read(folder, most_bytes)?;
    deadline.check()?;
    of_model(&model)
}

/// Draws a GLB.
pub(crate) fn of_glb(bytes: &[u8]) -> Result<Vec<u8>, String> {
    if let Some(model) = level(bytes.to_vec())? {
        return of_model(&model);
    }
    of_model(&tristrip_io::read(bytes, Format::Glb).map_err(|error| error.to_string())?)
}

/// Reads a level of a progressive file; returns `None` for other files.
fn level(bytes: Vec<u8>) -> Result<Option<Model>, String> {
    let opened = ProgressiveGlb::open(bytes).map_err(|error| error.to_string())?;
    let Some(glb) = opened else { return Ok(None) };
    let options = unpack::Options::default().with_goal(StreamGoal::Triangles(LEVEL_TRIANGLES));
    let unpacked = unpack::run(&glb, &options, &());
    unpacked.map(|unpacked| Some(unpacked.model)).map_err(|error| error.to_string())
}

fn of_model(model: &Model) -> Result<Vec<u8>, String> {
    if drawn_triangles(model)? > MAX_TRIANGLES {
        return cube();
    }
    let options = RenderOptions::default().with_size(SIZE[0], SIZE[1]).with_background(None);
    let picture = |model: &Model| {
        let mode = if is_coloured(model) { Mode::Textured } else { Mode::Shaded };
        let draw = || {
            let textured = TexturedModel::new(model)?;
            let is_small = textured.sample_count(&options)? <= MAX_SAMPLES;
            if is_small { textured.picture(mode, &options).map(Some) } else { Ok(None) }
        };
        draw().map_err(|error: tristrip_render::Error| error.to_string())
    };
    // The materials of an OBJ are drawn as glTF materials.
    if model.scene.is_none() && model.materials.as_ref().is_some_and(|materials| !materials.is_empty()) {
        let faces = vec![Drawing::Faces; model.parts.len()];
        let glb = tristrip_io::write(model, &faces, Format::Glb, Layout::List)
            .and_then(|glb| tristrip_io::read(&glb, Format::Glb));
        // If images cannot be drawn, the plain model is drawn.
        if let Some(drawn) = glb.ok().and_then(|glb| picture(&glb).ok()) {
            return drawn.map_or_else(cube, Ok);
        }
    }
    picture(model)?.map_or_else(cube, Ok)
}

/// Counts the triangles of a model, once per instance in its scene.
fn drawn_triangles(model: &Model) -> Result<usize, String> {
    let counts = model.parts.iter().map(|part| part.mesh.faces().triangle_count());
    // The number of triangles of the parts before each part, then of all parts.
    let mut before = vec![0_usize];
    before.extend(counts.scan(0, |sum: &mut usize, count| {
        *sum += count;
        Some(*sum)
    }));
    let Some(scene) = &model.scene else { return Ok(before[model.parts.len()]) };
    let placements = scene.placements().map_err(|error| error.to_string())?;
    let of_place = |place: &tristrip_io::gltf::Placement| {
        let [start, end] = [place.parts.start, place.parts.end].map(|part| before.get(part).copied());
        end.zip(start).map_or(0, |(end, start)| end - start)
    };
    Ok(placements.iter().map(of_place).fold(0, usize::saturating_add))
}

/// Checks whether a scene has colours: of textures, materials or vertices. A white model is drawn
/// in grey, so it is visible on a white page.
fn is_coloured(model: &Model) -> bool {
    let Some(appearance) = model.scene.as_ref().and_then(|scene| scene.appearance().ok()) else {
        return false;
    };
    let is_white = |colour: [f32; 4]| colour[..3].iter().all(|channel| *channel > 0.9);
    let colours = appearance
        .materials
        .iter()
        .any(|material| material.texture.is_some() || !is_white(material.base_colour));
    let mut attributes = model.parts.iter().flat_map(|part| part.mesh.attributes());
    colours || attributes.any(|attribute| attribute.name == "COLOR_0")
}

/// Draws a cube, for models that are too large.
fn cube() -> Result<Vec<u8>, String> {
    const CUBE: &[u8] = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    of_model(&tristrip_io::read(CUBE, Format::Obj).map_err(|error| error.to_string())?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_is_drawn() {
        let png = cube().unwrap();
        assert!(png.starts_with(b"\x89PNG") && png.len() > 500);
        assert_eq!(png[16..24], [0, 0, 1, 64, 0, 0, 0, 240]);
        assert_eq!(png, cube().unwrap());
    }

    #[test]
    fn triangles_that_hide_one_another_too_often_are_a_cube() {
        let stacked = |faces: usize| {
            let obj = format!("v 0 0 0\nv 9 0 0\nv 0 9 0\n{}", "f 1 2 3\n".repeat(faces));
            of_model(&tristrip_io::read(obj.as_bytes(), Format::Obj).unwrap()).unwrap()
        };
        assert_ne!(stacked(1), cube().unwrap());
        assert_eq!(stacked(20_000), cube().unwrap());
    }

    #[test]
    fn triangles_count_in_each_place() {
        let nodes = [r#"{"mesh":0}"#; 9].join(",");
        let gltf = format!(
            r#"{{"asset":{{"version":"2.0"}},"nodes":[{nodes}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
            "accessors":[{{"componentType":5126,"count":6,"type":"VEC3"}}]}}"#
        );
        let model = tristrip_io::read(gltf.as_bytes(), Format::Gltf).unwrap();
        assert_eq!(drawn_triangles(&model), Ok(18));
    }
}
