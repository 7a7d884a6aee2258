//! Complete models: placed parts with normals, texture coordinates, colours and textures.

use tristrip::Mesh;
use tristrip_io::Model;
use tristrip_io::gltf::{Appearance, Instance, Material};

use super::attributes::values;
use super::camera::Camera;
use super::colours::PLAIN;
use super::encoding::encode;
use super::options::{Mode, RenderOptions};
use super::pose::{Pose, Poses};
use super::raster;
use super::scene::{Facet, Paint, corner_normals, normal, position};
use super::shader::Shader;
use super::surfaces::{Corners, Surfaces};
use super::tones::Tones;
use super::vector::{Vector, unit};
use crate::error::Error;

/// How often the triangles of a model may be drawn on average, and the number of triangles that are
/// always allowed.
const MAX_COPIES: usize = 16;
const FREE_TRIANGLES: usize = 1 << 20;

/// A model prepared for rendering: its triangles in scene axes, and its textures.
#[derive(Debug)]
pub struct TexturedModel {
    facets: Vec<Facet>,
    surfaces: Surfaces,
    low: Vector,
    high: Vector,
    notes: Vec<String>,
}

impl TexturedModel {
    /// Places the parts of a model as in its scene, in the rest pose, and decodes its textures.
    /// Polygons are drawn as fans around their first corner.
    ///
    /// Skins and morph weights are applied, animations are not. Every material is opaque. Models
    /// without a scene are drawn in grey.
    ///
    /// # Errors
    /// The scene is invalid, an image is not a PNG or JPEG or is too large, a coordinate is not
    /// finite, or the scene repeats its parts too often.
    ///
    /// ```
    /// use tristrip_io::{Format, read};
    /// use tristrip_render::images::{Mode, TexturedModel, compare};
    /// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj)?;
    /// let model = TexturedModel::new(&model)?;
    /// assert_eq!(compare(&model, &model, Mode::Shaded)?.different, 0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(model: &Model) -> Result<Self, Error> {
        let appearance = match &model.scene {
            Some(scene) => scene.appearance().map_err(|error| Error::Image(error.to_string()))?,
            None => without_scene(model),
        };
        let surfaces = Surfaces::of(&appearance)?;
        check_count(model, &appearance.instances)?;
        let (low, high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        let mut textured = Self { facets: Vec::new(), surfaces, low, high, notes: appearance.notes };
        let mut poses = Poses::new(model, &appearance.skins);
        for instance in &appearance.instances {
            let Some(part) = model.parts.get(instance.part) else { continue };
            let pose = poses.of(&part.mesh, instance);
            let texture = appearance.materials.get(instance.part).and_then(|material| material.texture);
            let coordinates = format!("TEXCOORD_{}", texture.map_or(0, |texture| texture.coordinates));
            textured.add(&part.mesh, &pose, instance.part, &coordinates)?;
        }
        textured.notes.extend(poses.into_notes());
        for corner in textured.facets.iter().flat_map(|facet| facet.corners) {
            for axis in 0..3 {
                textured.low[axis] = textured.low[axis].min(corner[axis]);
                textured.high[axis] = textured.high[axis].max(corner[axis]);
            }
        }
        Ok(textured)
    }

    /// Returns the differences between images and the file, as text.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Returns the number of drawn triangles. A part counts once per instance; triangles without
    /// area are not drawn.
    pub fn triangle_count(&self) -> usize {
        self.facets.len()
    }

    /// Returns the number of samples that [`picture`](Self::picture) tests: the samples in the
    /// bounding boxes of all triangles, including hidden ones. This number dominates its time.
    ///
    /// # Errors
    /// A size is 0 or too large, or the view has no direction.
    ///
    /// ```
    /// use tristrip_io::{Format, read};
    /// use tristrip_render::images::{RenderOptions, TexturedModel};
    /// let count = |faces: usize| {
    ///     let obj = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{}", "f 1 2 3\n".repeat(faces));
    ///     let model = TexturedModel::new(&read(obj.as_bytes(), Format::Obj)?)?;
    ///     let count = model.sample_count(&RenderOptions::default())?;
    ///     Ok::<_, Box<dyn std::error::Error>>(count)
    /// };
    /// assert_eq!(count(7)?, 7 * count(1)?);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn sample_count(&self, options: &RenderOptions) -> Result<u64, Error> {
        options.check()?;
        let Some(camera) = self.camera(options)? else { return Ok(0) };
        self.facets
            .iter()
            .map(|facet| Ok(raster::tested_samples(camera.facet(facet)?.corners, options)))
            .sum()
    }

    /// Draws the model from the view direction in perspective, as large as the image allows.
    /// Returns the bytes of a PNG file.
    ///
    /// # Errors
    /// A size is 0 or too large, or the view has no direction.
    ///
    /// ```
    /// use tristrip_io::{Format, read};
    /// use tristrip_render::images::{Mode, RenderOptions, TexturedModel};
    /// let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    /// let model = TexturedModel::new(&read(obj, Format::Obj)?)?;
    /// let png = model.picture(Mode::Shaded, &RenderOptions::default().with_size(64, 48))?;
    /// assert!(png.starts_with(b"\x89PNG"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn picture(&self, mode: Mode, options: &RenderOptions) -> Result<Vec<u8>, Error> {
        options.check()?;
        if let Some(camera) = self.camera(options)? {
            return encode(&self.seen(&camera, mode, options)?, options);
        }
        let alpha = if options.background.is_some() { 255 } else { 0 };
        let [red, green, blue] = options.background.unwrap_or_default();
        encode(&vec![[red, green, blue, alpha]; (options.width * options.height) as usize], options)
    }

    /// Returns the perspective camera for which the bounding box fills the image, or `None` without
    /// triangles.
    pub(super) fn camera(&self, options: &RenderOptions) -> Result<Option<Camera>, Error> {
        if self.facets.is_empty() {
            return Ok(None);
        }
        Camera::around(self.low, self.high, options).map(Some)
    }

    /// Draws the model from a camera. Returns the pixels in the order of [`raster::draw`].
    pub(super) fn seen(
        &self,
        camera: &Camera,
        mode: Mode,
        options: &RenderOptions,
    ) -> Result<Vec<[u8; 4]>, Error> {
        let facets = self.facets.iter().map(|facet| camera.facet(facet)).collect::<Result<Vec<_>, _>>()?;
        Ok(raster::draw(&facets, &Shader::textured(camera, &self.surfaces, mode), options))
    }

    /// Adds a part in a pose.
    fn add(&mut self, mesh: &Mesh, pose: &Pose<'_>, part: usize, coordinates: &str) -> Result<(), Error> {
        let attribute = |name: &str| mesh.attributes().iter().find(|attribute| attribute.name == name);
        let (normals, coordinates, colours) =
            (attribute("NORMAL"), attribute(coordinates), attribute("COLOR_0"));
        let corners = mesh.faces().fans();
        let (triangles, _) = corners.as_chunks::<3>();
        let mut placed = Vec::with_capacity(triangles.len());
        for triangle in triangles {
            let mut found = [Vector::default(); 3];
            for (corner, &vertex) in found.iter_mut().zip(triangle) {
                *corner = pose.point(position(mesh.positions(), vertex)?, vertex)?;
            }
            placed.push(found);
        }
        let smooth = match normals {
            Some(_) => placed.iter().map(|&corners| unit(normal(corners)).map(|flat| [flat; 3])).collect(),
            None => corner_normals(&placed),
        };
        for ((triangle, corners), fallback) in triangles.iter().zip(placed).zip(smooth) {
            let Some(fallback) = fallback else { continue };
            let number = self.surfaces.push(Corners {
                coordinates: triangle.map(|vertex| coordinates.map_or([0.0; 2], |all| values(all, vertex))),
                colours: triangle.map(|vertex| colours.map_or([1.0; 3], |all| values(all, vertex))),
                material: part as u32,
            });
            let mut facet = Facet { corners, normals: fallback, paint: Paint::Corners(number) };
            for (corner, &vertex) in facet.normals.iter_mut().zip(triangle) {
                let of_file =
                    normals.and_then(|normals| pose.normal(values(normals, vertex).map(f64::from), vertex));
                *corner = of_file.unwrap_or(*corner);
            }
            self.facets.push(facet);
        }
        Ok(())
    }
}

/// Returns the appearance of a model without a scene: each part once, grey.
fn without_scene(model: &Model) -> Appearance {
    let transform = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let [red, green, blue] = Tones::new().linear(PLAIN);
    let grey = Material { base_colour: [red, green, blue, 1.0], ..Material::default() };
    let place = |part| Instance { part, transform, node: None, skin: None };
    let mut appearance = Appearance::default();
    appearance.instances = (0..model.parts.len()).map(place).collect();
    appearance.materials = vec![grey; model.parts.len()];
    appearance
}

/// Checks that a scene does not repeat its parts more often than the limit.
fn check_count(model: &Model, instances: &[Instance]) -> Result<(), Error> {
    let count = |part: usize| model.parts.get(part).map_or(0, |part| part.mesh.faces().triangle_count());
    let stored: usize = (0..model.parts.len()).map(count).sum();
    let limit = stored.saturating_mul(MAX_COPIES).saturating_add(FREE_TRIANGLES);
    let mut drawn = 0_usize;
    for instance in instances {
        drawn = drawn.saturating_add(count(instance.part));
        if drawn > limit {
            return Err(Error::Image(format!(
                "scene: found more than {limit} triangles to draw, expected at most {MAX_COPIES} per stored triangle ({stored}) plus {FREE_TRIANGLES}"
            )));
        }
    }
    Ok(())
}
