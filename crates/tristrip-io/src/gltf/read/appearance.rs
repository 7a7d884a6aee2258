//! The appearance of a scene for rendering: the instances of its parts, and the base colours of its
//! materials.
//!
//! ```text
//! scene ─▶ nodes ─▶ mesh ─▶ primitives: one instance per part, transformed by the nodes
//!                └▶ skin ─▶ the matrices of its joints
//! part ─▶ material ─▶ base colour factor, texture ─▶ sampler: wrapping
//!                                                 └▶ image ─▶ buffer view, data URI or file
//! ```
//! The pose is the rest pose of the file ([`Skin`], [`Scene::morph_reader`]); animations are not
//! applied. As the specification requires, the transform of a node with a skin is ignored. Images
//! are located but not decoded.
//!
//! # Complexity
//! Linear in nodes, instances and materials; an image in a buffer is shared, not copied. The number
//! of instances is limited, because many nodes that share a mesh of many primitives could produce
//! more instances than the file has bytes.

use std::path::Path;

use crate::error::Error;
use crate::gltf::BufferFiles;
use crate::gltf::document::accessor::AccessorResolver;
use crate::gltf::document::buffer::decode_data_uri;
use crate::gltf::document::byte_ranges::{SharedBytes, whole_of};
use crate::gltf::document::scene::Scene;
use crate::gltf::document::{Located, array};
use crate::gltf::read::placements::Placement;
use crate::gltf::read::pose::{Skin, SkinReader};
use crate::materials::image_size;

/// The extension that transforms texture coordinates.
const TEXTURE_TRANSFORM: &str = "KHR_texture_transform";

/// Maximum number of instances of a scene, plus [`INSTANCES_PER_NODE`] per node with a mesh.
const FREE_INSTANCES: usize = 1 << 20;

/// Additional instances allowed per node with a mesh.
const INSTANCES_PER_NODE: usize = 4;

/// The appearance of a scene.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Appearance {
    /// The instances of the parts, in the order of the scene's nodes. If the scene has no meshes,
    /// each part has one instance.
    pub instances: Vec<Instance>,
    /// The distinct skins of the instances.
    pub skins: Vec<Skin>,
    /// The material of each part, in the order of the parts.
    pub materials: Vec<Material>,
    /// The distinct images of the materials.
    pub images: Vec<Image>,
    /// The differences between this appearance and the file, as text.
    pub notes: Vec<String>,
}

/// An instance of a part in the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instance {
    /// The index of the part.
    pub part: usize,
    /// The rows of the affine transform from the part to the scene: three columns of the linear
    /// map, then the translation.
    pub transform: [[f64; 4]; 3],
    /// The index of the node; `None` if the document has no node with a mesh.
    pub node: Option<usize>,
    /// The index in [`Appearance::skins`] of the skin that deforms the vertices.
    pub skin: Option<usize>,
}

/// A material. Maps other than the base colour are omitted. The default is that of glTF: white
/// metal without a texture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Red, green and blue in linear light, and alpha.
    pub base_colour: [f32; 4],
    /// The texture that is multiplied with the base colour.
    pub texture: Option<Texture>,
    /// The metalness factor, from 0 to 1.
    pub metalness: f32,
    /// The roughness factor, from 0 to 1.
    pub roughness: f32,
    /// Whether the material is blended with the background by the alpha of its base colour.
    pub is_blended: bool,
}

impl Default for Material {
    fn default() -> Self {
        Self { base_colour: [1.0; 4], texture: None, metalness: 1.0, roughness: 1.0, is_blended: false }
    }
}

/// A texture of a material.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Texture {
    /// The index in [`Appearance::images`].
    pub image: usize,
    /// The set of texture coordinates: 0 for `TEXCOORD_0`.
    pub coordinates: u32,
    /// The wrapping modes in u and v.
    pub wrap: [Wrap; 2],
}

/// The wrapping mode of a texture for texture coordinates less than 0 or greater than 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wrap {
    /// The image repeats.
    #[default]
    Repeat,
    /// The image repeats, and every other copy is mirrored.
    Mirror,
    /// Coordinates are clamped to the edge of the image.
    Clamp,
}

/// An encoded image: PNG or JPEG.
#[derive(Debug, Clone)]
pub struct Image {
    /// Its location in the document, for messages: `images[3]`.
    pub at: String,
    bytes: SharedBytes,
}

impl Image {
    /// Returns the encoded bytes.
    pub fn bytes(&self) -> &[u8] {
        self.bytes.as_slice()
    }

    /// Returns the width and height in pixels, or `None` if the bytes do not contain the size of a
    /// PNG or JPEG.
    pub fn size(&self) -> Option<[u32; 2]> {
        image_size(self.bytes())
    }
}

impl Scene {
    /// Counts the materials with other maps than the base colour, or with emission.
    #[cfg(feature = "fs")]
    pub(crate) fn shaded_material_count(&self) -> usize {
        const MORE: [&str; 4] = ["normalTexture", "occlusionTexture", "emissiveTexture", "emissiveFactor"];
        let is_shaded = |material: &&crate::gltf::document::json::Value| {
            let surface = material.get("pbrMetallicRoughness");
            MORE.iter().any(|key| material.get(key).is_some())
                || surface.is_some_and(|surface| surface.get("metallicRoughnessTexture").is_some())
        };
        array(&self.document.root, "materials").unwrap_or_default().iter().filter(is_shaded).count()
    }

    /// Returns whether the document has materials.
    pub(crate) fn has_materials(&self) -> bool {
        array(&self.document.root, "materials").is_ok_and(|materials| !materials.is_empty())
    }

    /// Returns the instances of the parts, with their materials and images.
    ///
    /// If an image file cannot be read, a note is added and its materials have no texture.
    ///
    /// # Errors
    /// The nodes, materials, textures or images used by the scene are not valid glTF 2.0, or there
    /// are too many instances.
    ///
    /// ```
    /// let json = br#"{"asset":{"version":"2.0"},
    ///     "scenes":[{"nodes":[0]}],"nodes":[{"translation":[1,2,3]}]}"#;
    /// let model = tristrip_io::gltf::read(json.to_vec(), None)?;
    /// let appearance = model.scene.unwrap_or_default().appearance()?;
    /// assert!(appearance.instances.is_empty() && appearance.images.is_empty());
    /// # Ok::<(), tristrip_io::Error>(())
    /// ```
    pub fn appearance(&self) -> Result<Appearance, Error> {
        let mut appearance = self.surfaces()?;
        let mut skins = SkinReader::new(self);
        appearance.instances = self.instances(&mut skins)?;
        let SkinReader { skins, notes, .. } = skins;
        appearance.notes.extend(notes);
        Ok(Appearance { skins, ..appearance })
    }

    /// Returns the instances of the parts.
    fn instances(&self, skins: &mut SkinReader<'_>) -> Result<Vec<Instance>, Error> {
        let placements = self.placements()?;
        let found = placements.iter().map(|place| place.parts.len()).fold(0, usize::saturating_add);
        let limit = FREE_INSTANCES + INSTANCES_PER_NODE * placements.len();
        if found > limit {
            let at = "nodes, instances of parts".into();
            return Err(Error::LimitExceeded { at, found: found as u64, limit: limit as u64 });
        }
        let of_place = |Placement { parts, transform, node }| {
            let skin = node.and_then(|node| skins.of_node(node));
            parts.map(move |part| Instance { part, transform, node, skin })
        };
        Ok(placements.into_iter().flat_map(of_place).collect())
    }

    /// Returns the appearance without instances.
    pub(crate) fn surfaces(&self) -> Result<Appearance, Error> {
        let folders: Vec<&Path> = self.folders.iter().map(std::path::PathBuf::as_path).collect();
        let root = &self.document.root;
        let mut reader = MaterialReader {
            resolver: AccessorResolver { root, buffers: &self.buffers },
            files: BufferFiles::new(&folders),
            images: Vec::new(),
            known_images: vec![KnownImage::NotLookedFor; array(root, "images")?.len()],
            moved: 0,
            notes: Vec::new(),
        };
        let known = Located::entries(root, "materials")?.map(|material| reader.material(&material));
        let known = known.collect::<Result<Vec<Material>, Error>>()?;
        let materials = self.materials(&known)?;
        let MaterialReader { images, moved, mut notes, .. } = reader;
        if moved > 0 {
            notes.push(format!("textures whose {TEXTURE_TRANSFORM} is not applied: {moved}"));
        }
        Ok(Appearance { materials, images, notes, ..Appearance::default() })
    }

    /// Returns the material of each part.
    fn materials(&self, known: &[Material]) -> Result<Vec<Material>, Error> {
        let root = &self.document.root;
        let mut materials = Vec::with_capacity(self.primitives.len());
        let meshes: Vec<Located<'_>> = Located::entries(root, "meshes")?.collect();
        for source in &self.primitives {
            let primitive = meshes.get(source.mesh).and_then(|mesh| {
                let value = mesh.value.get("primitives")?.as_array()?.get(source.primitive)?;
                Some(Located { value, at: format!("{}.primitives[{}]", mesh.at, source.primitive) })
            });
            let material = match primitive.and_then(|primitive| primitive.field("material")) {
                None => Material::default(),
                Some(material) => known.get(material.size()?).copied().ok_or_else(|| {
                    material.wrong(format!("less than {}, the number of materials", known.len()))
                })?,
            };
            materials.push(material);
        }
        Ok(materials)
    }
}

/// The state of an image of the document.
#[derive(Debug, Clone, Copy)]
enum KnownImage {
    NotLookedFor,
    Unreadable,
    /// The index in the list of found images.
    Found(usize),
}

/// Reads materials and locates their images.
struct MaterialReader<'a> {
    resolver: AccessorResolver<'a>,
    files: BufferFiles<'a>,
    images: Vec<Image>,
    /// The state of each image of the document.
    known_images: Vec<KnownImage>,
    /// The number of textures with a transform.
    moved: usize,
    notes: Vec<String>,
}

impl<'a> MaterialReader<'a> {
    fn material(&mut self, material: &Located<'a>) -> Result<Material, Error> {
        let is_blended = material.field("alphaMode").is_some_and(|mode| mode.value.as_str() == Some("BLEND"));
        let mut read = Material { is_blended, ..Material::default() };
        let Some(base) = material.field("pbrMetallicRoughness") else { return Ok(read) };
        if let Some(factor) = base.field("baseColorFactor") {
            read.base_colour = factor.numbers()?.map(|x| x.clamp(0.0, 1.0) as f32);
        }
        for (name, value) in
            [("metallicFactor", &mut read.metalness), ("roughnessFactor", &mut read.roughness)]
        {
            if let Some(factor) = base.field(name) {
                *value = factor.number()?.clamp(0.0, 1.0) as f32;
            }
        }
        if let Some(texture) = base.field("baseColorTexture") {
            read.texture = self.texture(&texture)?;
        }
        Ok(read)
    }

    fn texture(&mut self, info: &Located<'a>) -> Result<Option<Texture>, Error> {
        let root = self.resolver.root;
        if info.field("extensions").is_some_and(|all| all.field(TEXTURE_TRANSFORM).is_some()) {
            self.moved += 1;
        }
        let at = info.field("texCoord");
        let coordinates = at.map_or(Ok(0), |at| {
            u32::try_from(at.whole()?).map_err(|_| at.wrong("the index of a set of texture coordinates"))
        })?;
        let texture = info.need("index")?.target(root, "textures")?;
        let mut wrap = [Wrap::Repeat; 2];
        if let Some(sampler) = texture.field("sampler") {
            let sampler = sampler.target(root, "samplers")?;
            for (name, wrap) in ["wrapS", "wrapT"].into_iter().zip(&mut wrap) {
                let Some(code) = sampler.field(name) else { continue };
                *wrap = match code.whole()? {
                    10497 => Wrap::Repeat,
                    33648 => Wrap::Mirror,
                    33071 => Wrap::Clamp,
                    _ => return Err(code.wrong("10497, 33648 or 33071")),
                };
            }
        }
        // An extension may refer to an image in another format instead.
        let Some(source) = texture.field("source") else {
            self.notes.push(format!("{}: no PNG or JPEG image; drawn without a texture", texture.at));
            return Ok(None);
        };
        let image = self.image(&source)?;
        Ok(image.map(|image| Texture { image, coordinates, wrap }))
    }

    /// Locates an image, once for all textures that use it.
    fn image(&mut self, source: &Located<'a>) -> Result<Option<usize>, Error> {
        let image = source.target(self.resolver.root, "images")?;
        let number = source.size()?;
        match self.known_images[number] {
            KnownImage::NotLookedFor => {}
            KnownImage::Unreadable => return Ok(None),
            KnownImage::Found(known) => return Ok(Some(known)),
        }
        let found = match (image.field("bufferView"), image.field("uri")) {
            (Some(view), _) => Some(self.resolver.shared_view(&view)?),
            (None, Some(uri)) => self.at_uri(&uri)?,
            (None, None) => return Err(Error::format(image.at, "nothing", "a `bufferView` or `uri`")),
        };
        let found = found.map(|bytes| {
            self.images.push(Image { at: image.at, bytes });
            self.images.len() - 1
        });
        self.known_images[number] = found.map_or(KnownImage::Unreadable, KnownImage::Found);
        Ok(found)
    }

    /// Returns the bytes at a URI. If a file cannot be read, a note is added.
    fn at_uri(&mut self, uri: &Located<'a>) -> Result<Option<SharedBytes>, Error> {
        let owner = match uri.text()?.strip_prefix("data:") {
            Some(data) => std::sync::Arc::new(decode_data_uri(uri, data)?),
            None => match self.files.load(uri) {
                Ok(bytes) => bytes,
                Err(error) => {
                    self.notes.push(format!("drawn without an image: {error}"));
                    return Ok(None);
                }
            },
        };
        let (owner, range) = whole_of(owner);
        Ok(Some(SharedBytes { owner, range }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gltf::read::placements::Transform;

    /// Returns the appearance of a document with a triangle in mesh 0 and these additional members.
    fn appearance(members: &str) -> Result<Appearance, Error> {
        let json = format!(
            r#"{{"asset":{{"version":"2.0"}},
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"material":0}},{{"attributes":{{"POSITION":0}}}}]}}],
            "accessors":[{{"componentType":5126,"count":3,"type":"VEC3"}}],{members}}}"#
        );
        crate::gltf::read(json.into_bytes(), None)?.scene.unwrap_or_default().appearance()
    }

    const MATERIAL: &str = r#""materials":[{"pbrMetallicRoughness":{"baseColorFactor":[0.5,1,0,1],
        "baseColorTexture":{"index":0,"texCoord":1}}}]"#;

    #[test]
    fn transforms_of_nodes_are_multiplied_from_the_root_down() {
        let nodes = r#""nodes":[{"children":[1],"translation":[10,20,30]},
            {"mesh":0,"rotation":[0,0,0.7071067811865476,0.7071067811865476],"scale":[2,3,4]},
            {"mesh":0,"skin":0,"scale":[9,9,9]},{"mesh":0,"matrix":[1,2,3,0,4,5,6,0,7,8,9,0,10,11,12,1]},{"mesh":0}]"#;
        let found =
            |scene: &str| appearance(&format!(r#"{scene}{nodes},"materials":[{{}}]"#)).unwrap().instances;
        let all = found("");
        assert_eq!(all.iter().map(|instance| instance.part).collect::<Vec<_>>(), [0, 1, 0, 1, 0, 1, 0, 1]);
        // A quarter turn around z maps x, scaled by 2, to y.
        let expected = [[0.0, -3.0, 0.0, 10.0], [2.0, 0.0, 0.0, 20.0], [0.0, 0.0, 4.0, 30.0]];
        for (found, expected) in all[0].transform.iter().flatten().zip(expected.iter().flatten()) {
            assert!((found - expected).abs() < 1e-12, "{all:?}");
        }
        assert_eq!(all[2].transform, Transform::IDENTITY.rows());
        let matrix = [[1.0, 4.0, 7.0, 10.0], [2.0, 5.0, 8.0, 11.0], [3.0, 6.0, 9.0, 12.0]];
        assert_eq!(all[4].transform, matrix);
        let listed = found(r#""scene":1,"scenes":[{"nodes":[0]},{"nodes":[4]}],"#);
        assert_eq!(listed.len(), 2);
        // Nodes without meshes: the document is a library.
        assert_eq!(found(r#""scenes":[{}],"#).len(), 2);
    }

    #[test]
    fn materials_have_factors_textures_and_images() {
        let textures = r#""textures":[{"source":1,"sampler":0}],"samplers":[{"wrapS":33071,"wrapT":33648}],
            "images":[{"uri":"data:image/png;base64,AA=="},{"uri":"data:image/png;base64,AQID"}]"#;
        let found = appearance(&format!("{MATERIAL},{textures}")).unwrap();
        let texture = Texture { image: 0, coordinates: 1, wrap: [Wrap::Clamp, Wrap::Mirror] };
        assert_eq!(
            found.materials[0],
            Material { base_colour: [0.5, 1.0, 0.0, 1.0], texture: Some(texture), ..Material::default() }
        );
        assert_eq!(found.materials[1], Material::default());
        assert_eq!(
            (found.images.len(), found.images[0].bytes(), &*found.images[0].at),
            (1, &[1, 2, 3][..], "images[1]")
        );
        assert_eq!(found.images[0].size(), None);
        let header = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x02\0\0\0\0\x40\x08\x02\0\0\0".to_vec();
        let (owner, range) = whole_of(std::sync::Arc::new(header));
        let image = Image { at: String::new(), bytes: SharedBytes { owner, range } };
        assert_eq!(image.size(), Some([512, 64]));
    }

    #[test]
    fn an_image_file_that_is_not_there_is_noted_and_wrong_documents_are_refused() {
        let with = |members: &str| appearance(&format!("{MATERIAL},{members}"));
        let found = with(r#""textures":[{"source":0}],"images":[{"uri":"none.png"}]"#).unwrap();
        assert_eq!((found.materials[0].texture, found.images.len(), found.notes.len()), (None, 0, 1));
        assert!(found.notes[0].starts_with("drawn without an image: images[0].uri: "), "{:?}", found.notes);
        for (members, message) in [
            (
                r#""textures":[{"source":0}],"images":[{}]"#,
                "images[0]: found nothing, expected a `bufferView` or `uri`",
            ),
            (r#""textures":[{"source":1}],"images":[{}]"#, "less than 1, the number of images"),
            (
                r#""textures":[{"source":0}],"images":[{"bufferView":0}]"#,
                "less than 0, the number of bufferViews",
            ),
            (
                r#""textures":[{"sampler":0}],"samplers":[{"wrapS":1}]"#,
                "samplers[0].wrapS: found 1, expected 10497",
            ),
            (r#""nodes":[{"mesh":2}],"textures":[{}]"#, "nodes[0].mesh: found 2, expected less than 1"),
            (r#""nodes":[{"matrix":[1]}],"textures":[{}]"#, "nodes[0].matrix: found 1 number, expected 16"),
            (
                r#""scenes":[{"nodes":[0,1]}],"nodes":[{"children":[1]},{}],"textures":[{}]"#,
                "nodes[1]: found a node with two parents, expected a tree",
            ),
        ] {
            let error = with(members).unwrap_err().to_string();
            assert!(error.contains(message), "{error}");
        }
    }
}
