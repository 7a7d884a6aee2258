//! Builds the materials of a new document, with their names and the properties from the material
//! libraries of an OBJ.

use std::collections::HashMap;

use serde_json::{Value, json};

use crate::materials::{Materials, ObjMaterial, SideFile};

/// The magic bytes of JPEG.
pub(in crate::gltf) const JPEG: &[u8] = b"\xff\xd8\xff";
/// The magic bytes of PNG.
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Collects the distinct materials of parts.
pub(in crate::gltf) struct MaterialBuilder<'a> {
    known: Option<&'a Materials>,
    /// The materials by name and whether they use images.
    ids: HashMap<(&'a str, bool), usize>,
    materials: Vec<Value>,
    images: Vec<&'a SideFile>,
    /// The textures by image name; `None` if glTF does not support the image.
    textures: HashMap<&'a str, Option<usize>>,
}

impl<'a> MaterialBuilder<'a> {
    pub(in crate::gltf) fn new(known: Option<&'a Materials>) -> Self {
        let (ids, textures) = (HashMap::new(), HashMap::new());
        Self { known, ids, materials: Vec::new(), images: Vec::new(), textures }
    }

    /// Returns the index of a material. A material with images has a second variant without them,
    /// for parts without texture coordinates.
    pub(in crate::gltf) fn id(&mut self, name: &'a str, has_coordinates: bool) -> usize {
        let known = self.known.and_then(|known| known.get(name));
        let shows_images =
            has_coordinates && known.is_some_and(|known| known.images.iter().any(Option::is_some));
        if let Some(&id) = self.ids.get(&(name, shows_images)) {
            return id;
        }
        let material = match known {
            None => json!({ "name": name }),
            Some(known) => self.material(name, known, shows_images),
        };
        self.materials.push(material);
        self.ids.insert((name, shows_images), self.materials.len() - 1);
        self.materials.len() - 1
    }

    fn material(&mut self, name: &str, known: &'a ObjMaterial, shows_images: bool) -> Value {
        let [colour, light, normals] = [0, 1, 2].map(|kind| {
            let image = known.images[kind].as_deref().filter(|_| shows_images)?;
            self.texture(image)
        });
        let mut surface = json!({
            "baseColorFactor": known.colour, "metallicFactor": known.metalness, "roughnessFactor": known.roughness,
        });
        if let Some(texture) = colour {
            surface["baseColorTexture"] = json!({ "index": texture });
        }
        let mut material = json!({ "name": name, "pbrMetallicRoughness": surface });
        if known.emissive.iter().any(|&x| x > 0.0) {
            material["emissiveFactor"] = json!(known.emissive);
        }
        if let Some(texture) = light {
            material["emissiveTexture"] = json!({ "index": texture });
        }
        if let Some(texture) = normals {
            material["normalTexture"] = json!({ "index": texture });
        }
        if known.is_blended {
            material["alphaMode"] = "BLEND".into();
        }
        material
    }

    /// Returns the index of the texture with an image, or `None` if the image is missing or in a
    /// format that glTF does not support.
    fn texture(&mut self, name: &'a str) -> Option<usize> {
        if let Some(&known) = self.textures.get(name) {
            return known;
        }
        let is_known = |image: &&SideFile| image.bytes.starts_with(PNG) || image.bytes.starts_with(JPEG);
        let texture = self.known?.image(name).filter(is_known).map(|image| {
            self.images.push(image);
            self.images.len() - 1
        });
        self.textures.insert(name, texture);
        texture
    }

    /// Adds the materials and their images to a document. `store` stores images and returns their
    /// entries.
    pub(in crate::gltf) fn add_to(self, root: &mut Value, store: impl FnOnce(&[&SideFile]) -> Vec<Value>) {
        if !self.materials.is_empty() {
            root["materials"] = self.materials.into();
        }
        if !self.images.is_empty() {
            root["images"] = store(&self.images).into();
            let texture = |image: usize| json!({ "source": image });
            root["textures"] = (0..self.images.len()).map(texture).collect();
        }
    }
}
