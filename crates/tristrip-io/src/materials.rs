//! The materials of an OBJ file: its material libraries (`.mtl` files) and their images.
//!
//! ```text
//! newmtl wood          start of a material               map_Kd oak.png        colour image
//! Kd r g b, d a        colour and opacity                map_Ke glow.png       emission image
//! Ns e, or Pr r        specular exponent, or             norm oak_n.png        normal map
//!                      roughness from 0 to 1             map_Bump, map_Ks, …   not in glTF
//! Ke r g b, Pm m       emission, metalness
//! ```
//! A line with invalid numbers is ignored. The crate `tobj` is not used, because it panics on lines
//! such as `Kd 1`.
//!
//! # References
//! Wavefront Technologies: *MTL material format*, 1995. Exocortex: *Physically-based rendering
//! extension of MTL*, 2014. Walter, Marschner, Li, Torrance: *Microfacet Models for Refraction
//! through Rough Surfaces*, 2007 (roughness from the specular exponent).

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use tristrip::text::counted;

/// Maximum number of parsed bytes of a library; the rest is ignored.
const LONGEST_LIBRARY: usize = 64 << 20;
/// Maximum number of images of a library.
const MAX_IMAGES: usize = 4096;

/// A file that an OBJ file refers to, directly or through a library.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SideFile {
    /// The path relative to the directory of the OBJ file, without `..`.
    pub name: String,
    /// The bytes, shared by copies of the model.
    pub bytes: Arc<Vec<u8>>,
}

/// The materials of a model that was read from OBJ or will be written as OBJ.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Materials {
    /// The names of the libraries.
    pub libraries: Vec<String>,
    /// The libraries and images that were found.
    pub files: Vec<SideFile>,
    /// Missing or unreadable data, as text.
    pub problems: Vec<String>,
    /// Properties that glTF does not support, as text.
    pub losses: Vec<String>,
    /// Whether the origin of the texture coordinates is at the top of an image, as in glTF. In OBJ
    /// it is at the bottom.
    pub counts_down: bool,
    by_name: BTreeMap<String, ObjMaterial>,
}

/// A material with the properties that both glTF and an OBJ library support. The default is white,
/// rough and not metallic.
#[derive(Debug, Clone, PartialEq)]
pub struct PlainMaterial {
    /// Linear red, green and blue, and the opacity, from 0 to 1.
    pub base_colour: [f32; 4],
    /// The metalness, from 0 to 1.
    pub metalness: f32,
    /// The roughness, from 0 to 1.
    pub roughness: f32,
    /// Whether the material is blended by its opacity.
    pub is_blended: bool,
    /// The bytes of a PNG or JPEG texture that is multiplied with the base colour. It uses
    /// `TEXCOORD_0`.
    pub image: Option<Arc<Vec<u8>>>,
}

impl Default for PlainMaterial {
    fn default() -> Self {
        Self { base_colour: [1.0; 4], metalness: 0.0, roughness: 1.0, is_blended: false, image: None }
    }
}

/// A material with glTF properties.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ObjMaterial {
    pub(crate) colour: [f32; 4],
    pub(crate) emissive: [f32; 3],
    pub(crate) roughness: f32,
    pub(crate) metalness: f32,
    /// Whether the colour image also provides the opacity.
    pub(crate) is_blended: bool,
    /// The names of the colour image, the emission image and the normal map.
    pub(crate) images: [Option<Arc<str>>; 3],
}

impl Materials {
    /// Creates materials with the names of libraries that are not loaded yet.
    pub(crate) fn new(libraries: Vec<String>) -> Self {
        Self { libraries, ..Self::default() }
    }

    /// Returns a material, or `None` if no library has it.
    pub(crate) fn get(&self, name: &str) -> Option<&ObjMaterial> {
        self.by_name.get(name)
    }

    /// Returns whether there are no materials.
    pub fn is_empty(&self) -> bool {
        self.by_name.is_empty()
    }

    /// Returns the width and height in pixels of a material's colour image, or `None` if there is
    /// none or it is not a PNG or JPEG.
    pub fn image_size(&self, material: &str) -> Option<[u32; 2]> {
        image_size(&self.image(self.get(material)?.images[0].as_deref()?)?.bytes)
    }

    /// Adds a material. Returns `false` if a different material has this name.
    ///
    /// ```
    /// use tristrip_io::{Materials, PlainMaterial};
    /// let mut materials = Materials::default();
    /// let red = PlainMaterial { base_colour: [1.0, 0.0, 0.0, 1.0], ..PlainMaterial::default() };
    /// assert!(materials.add_plain("paint", &red) && materials.add_plain("paint", &red));
    /// assert!(!materials.add_plain("paint", &PlainMaterial::default()));
    /// assert_eq!(materials.plain("paint"), Some(red));
    /// ```
    pub fn add_plain(&mut self, name: &str, material: &PlainMaterial) -> bool {
        if let Some(known) = self.plain(name) {
            return known == *material;
        }
        let image = material.image.as_ref().map(|image| self.store(image));
        let colour = material.base_colour;
        let PlainMaterial { metalness, roughness, is_blended, .. } = *material;
        let images = [image, None, None];
        self.add(
            name.to_owned(),
            ObjMaterial { colour, emissive: [0.0; 3], roughness, metalness, is_blended, images },
        )
    }

    /// Returns a material, or `None` if there is none with this name.
    pub fn plain(&self, name: &str) -> Option<PlainMaterial> {
        let known = self.get(name)?;
        let image = known.images[0].as_deref().and_then(|image| self.image(image));
        Some(PlainMaterial {
            base_colour: known.colour,
            metalness: known.metalness,
            roughness: known.roughness,
            is_blended: known.is_blended,
            image: image.map(|image| Arc::clone(&image.bytes)),
        })
    }

    /// Stores an image once and returns its name.
    fn store(&mut self, image: &Arc<Vec<u8>>) -> Arc<str> {
        let known = self.files.iter().find(|file| Arc::ptr_eq(&file.bytes, image) || file.bytes == *image);
        if let Some(known) = known {
            return known.name.as_str().into();
        }
        let name = format!("image_{}.{}", self.files.len(), image_extension(image));
        self.files.push(SideFile { name: name.clone(), bytes: Arc::clone(image) });
        name.into()
    }

    /// Iterates over the names and properties of the materials.
    #[cfg(feature = "fs")]
    pub(crate) fn iter(&self) -> impl Iterator<Item = (&str, &ObjMaterial)> {
        self.by_name.iter().map(|(name, material)| (name.as_str(), material))
    }

    /// Adds a material, unless there is one with this name. Returns whether it was added.
    pub(crate) fn add(&mut self, name: String, material: ObjMaterial) -> bool {
        let is_new = !self.by_name.contains_key(&name);
        if is_new {
            self.by_name.insert(name, material);
        }
        is_new
    }

    /// Returns the image named `name`.
    pub(crate) fn image(&self, name: &str) -> Option<&SideFile> {
        self.files.iter().find(|file| file.name == name)
    }

    /// Parses a library and returns the names of its images, relative to the directory of the OBJ
    /// file. A program without file access loads these images itself and appends them to
    /// [`Materials::files`]. For a model read from a file,
    /// [`load_materials`](crate::load_materials) loads them.
    ///
    /// ```
    /// use std::sync::Arc;
    /// let mut materials = tristrip_io::Materials::default();
    /// let library = b"newmtl wood\nKd 0.5 0.25 0\nmap_Kd oak.png\n".to_vec();
    /// assert_eq!(materials.add_library("maps/a.mtl", Arc::new(library)), ["maps/oak.png"]);
    /// ```
    pub fn add_library(&mut self, name: &str, bytes: Arc<Vec<u8>>) -> Vec<String> {
        let text = String::from_utf8_lossy(&bytes[..bytes.len().min(LONGEST_LIBRARY)]).into_owned();
        self.files.push(SideFile { name: name.to_owned(), bytes });
        let mut images = LibraryImages::of(name);
        let mut lost = BTreeMap::new();
        let mut has_materials = false;
        for material in materials_of(&text) {
            has_materials = true;
            material.count_lost(&mut lost);
            material.images().for_each(|image| drop(images.name(image)));
            let read = ObjMaterial::of(&material, |image| images.name(image));
            self.add(material.name.to_owned(), read);
        }
        if !has_materials {
            self.problems.push(format!("{name}: contains no materials"));
        }
        let lost =
            lost.into_iter().map(|(what, count)| format!("{name}: {what} in {}", counted(count, "material")));
        self.losses.extend(lost);
        if images.by_name.len() > MAX_IMAGES {
            let count = images.by_name.len();
            self.problems.push(format!("{name}: only the first {MAX_IMAGES} of {count} images are read"));
        }
        let mut names: Vec<String> =
            images.by_name.into_values().flatten().map(|image| (*image).into()).collect();
        names.sort_unstable();
        names
    }
}

/// The images of a library, whose names are relative to its directory.
struct LibraryImages<'a> {
    folder: &'a str,
    /// Names relative to the directory of the OBJ file, by name in the library. `None` beyond the
    /// maximum number, because each may be much longer.
    by_name: HashMap<String, Option<Arc<str>>>,
}

impl<'a> LibraryImages<'a> {
    fn of(library: &'a str) -> Self {
        let folder = library.rsplit_once('/').map_or("", |(folder, _)| folder);
        Self { folder, by_name: HashMap::new() }
    }

    /// Returns the name of an image relative to the directory of the OBJ file, or `None` if there
    /// are too many images.
    fn name(&mut self, image: String) -> Option<Arc<str>> {
        let is_read = self.by_name.len() < MAX_IMAGES;
        let folder = self.folder;
        let named = |image: &String| {
            let name = if folder.is_empty() { image.clone() } else { format!("{folder}/{image}") };
            is_read.then(|| name.into())
        };
        self.by_name.entry(image).or_insert_with_key(named).clone()
    }
}

/// Returns the width and height of a PNG or JPEG, or `None` if the bytes are neither or have no
/// size.
pub(crate) fn image_size(bytes: &[u8]) -> Option<[u32; 2]> {
    let size = imagesize::blob_size(bytes).ok()?;
    let side = |side: usize| u32::try_from(side).ok().filter(|&side| side > 0);
    Some([side(size.width)?, side(size.height)?])
}

/// Returns the file name extension of a JPEG or PNG.
pub(crate) fn image_extension(bytes: &[u8]) -> &'static str {
    if bytes.starts_with(b"\xff\xd8\xff") { "jpg" } else { "png" }
}

/// The lines of a material; for a repeated keyword, the last one.
struct MaterialLines<'a> {
    name: &'a str,
    lines: BTreeMap<&'a str, &'a str>,
}

/// Splits a library into materials lazily, because their lines take much more memory than the text.
fn materials_of<'a>(text: &'a str) -> impl Iterator<Item = MaterialLines<'a>> {
    let words = |line: &'a str| line.trim().split_once(char::is_whitespace).unwrap_or_default();
    let mut lines = text.lines().map(words).map(|(keyword, rest)| (keyword, rest.trim()));
    let mut next = lines.find(|(keyword, _)| *keyword == "newmtl");
    std::iter::from_fn(move || {
        let (_, name) = next.take()?;
        let mut material = MaterialLines { name, lines: BTreeMap::new() };
        for (keyword, rest) in lines.by_ref() {
            if keyword == "newmtl" {
                next = Some((keyword, rest));
                break;
            }
            if !keyword.is_empty() && !keyword.starts_with('#') {
                material.lines.insert(keyword, rest);
            }
        }
        Some(material)
    })
}

impl MaterialLines<'_> {
    /// Returns the numbers of a line, or `None` unless all are finite.
    fn numbers<const N: usize>(&self, keyword: &str) -> Option<[f32; N]> {
        let words = self.lines.get(keyword)?.split_whitespace();
        let numbers: Vec<f32> = words.take(N).map_while(|word| word.parse().ok()).collect();
        numbers.try_into().ok().filter(|numbers: &[f32; N]| numbers.iter().all(|x| x.is_finite()))
    }

    fn number(&self, keyword: &str) -> Option<f32> {
        self.numbers(keyword).map(|[x]| x)
    }

    /// Returns the image of the first keyword that has one.
    fn image(&self, keywords: &[&str]) -> Option<String> {
        keywords.iter().find_map(|keyword| image_name(self.lines.get(keyword)?))
    }

    /// Returns all images, including those that glTF does not support.
    fn images(&self) -> impl Iterator<Item = String> {
        let names_image =
            |keyword: &str| keyword.starts_with("map_") || ["norm", "bump", "disp"].contains(&keyword);
        self.lines
            .iter()
            .filter(move |(keyword, _)| names_image(keyword))
            .filter_map(|(_, line)| image_name(line))
    }

    /// Counts the visible properties that glTF does not support.
    fn count_lost(&self, lost: &mut BTreeMap<&'static str, usize>) {
        let opacity = self.image(&["map_d"]);
        let losses = [
            (self.image(&["map_Bump", "map_bump", "bump"]).is_some(), "bump map"),
            (self.image(&["map_Ks", "map_Ns"]).is_some(), "specular map"),
            (opacity.is_some() && opacity != self.image(&["map_Kd"]), "separate opacity map"),
            (self.image(&["map_Pr", "map_Pm"]).is_some(), "roughness or metalness map"),
            (self.image(&["disp"]).is_some(), "displacement map"),
        ];
        losses
            .into_iter()
            .filter(|(is_lost, _)| *is_lost)
            .for_each(|(_, what)| *lost.entry(what).or_default() += 1);
    }
}

impl ObjMaterial {
    /// Converts the lines of a material. `from_obj` returns the name of an image relative to the
    /// directory of the OBJ file.
    fn of(lines: &MaterialLines<'_>, mut from_obj: impl FnMut(String) -> Option<Arc<str>>) -> Self {
        let unit = |x: f32| x.clamp(0.0, 1.0);
        let images = [lines.image(&["map_Kd"]), lines.image(&["map_Ke"]), lines.image(&["norm"])];
        let opacity = lines.number("d").or_else(|| Some(1.0 - lines.number("Tr")?)).map_or(1.0, unit);
        let [r, g, b] = match lines.numbers("Kd") {
            // Black would hide the image.
            Some([0.0, 0.0, 0.0]) | None if images[0].is_some() => [1.0; 3],
            Some(colour) => colour.map(unit),
            None => [0.8; 3],
        };
        // For a specular exponent e: α² = 2 / (e + 2), and the roughness is the square root of α.
        let of_exponent = |e: f32| (2.0 / (e.max(0.0) + 2.0)).sqrt().sqrt();
        let roughness = lines.number("Pr").or_else(|| lines.number("Ns").map(of_exponent)).map_or(1.0, unit);
        let opacity_image = lines.image(&["map_d"]);
        Self {
            colour: [r, g, b, opacity],
            emissive: lines.numbers("Ke").map_or([0.0; 3], |light| light.map(unit)),
            roughness,
            metalness: lines.number("Pm").map_or(0.0, unit),
            is_blended: opacity < 1.0 || opacity_image.is_some() && opacity_image == images[0],
            images: images.map(|image| from_obj(image?)),
        }
    }
}

/// Returns the path of an image after the options of its line, such as `-s 1 1 1`, or `None` if
/// there is none.
fn image_name(text: &str) -> Option<String> {
    let mut rest = text.trim();
    while let Some(option) = rest.strip_prefix('-') {
        let (option, after) = option.split_once(char::is_whitespace)?;
        rest = after.trim_start();
        // `-o`, `-s` and `-t` take one to three numbers, `-mm` two, the others one value.
        let most = match option {
            "o" | "s" | "t" => 3,
            "mm" => 2,
            _ => 1,
        };
        for value in 0..most {
            let Some((word, after)) = rest.split_once(char::is_whitespace) else { break };
            if value > 0 && word.parse::<f32>().is_err() {
                break;
            }
            rest = after.trim_start();
        }
    }
    let name = rest.replace('\\', "/");
    (!name.is_empty()).then_some(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> (Materials, Vec<String>) {
        let mut materials = Materials::default();
        let images = materials.add_library("a.mtl", Arc::new(text.as_bytes().to_vec()));
        (materials, images)
    }

    #[test]
    fn materials_become_those_of_gltf() {
        let (all, images) = read(
            "newmtl wood\nKd 0.5 0.25 0\nd 0.5\nNs 30\nmap_Kd -s 2 2 -o 0.5 1 0 maps\\oak wood.png\nmap_Bump b.png\n\
             newmtl lamp\nKd 0 0 0\nKe 9 1 0.5\nPr 0.25\nPm 1\nmap_Kd glow.jpg\nmap_d glow.jpg\n",
        );
        let wood = all.get("wood").unwrap();
        assert_eq!((wood.colour, wood.metalness, wood.is_blended), ([0.5, 0.25, 0.0, 0.5], 0.0, true));
        assert!((wood.roughness - 0.5).abs() < 1e-6);
        assert_eq!(wood.images, [Some("maps/oak wood.png".into()), None, None]);
        let lamp = all.get("lamp").unwrap();
        assert_eq!((lamp.colour, lamp.emissive), ([1.0; 4], [1.0, 1.0, 0.5]));
        assert_eq!((lamp.roughness, lamp.metalness, lamp.is_blended), (0.25, 1.0, true));
        assert_eq!(images, ["b.png", "glow.jpg", "maps/oak wood.png"]);
        assert_eq!(all.losses, ["a.mtl: bump map in 1 material"]);
    }

    #[test]
    fn wrong_lines_count_as_missing() {
        let (all, images) = read("Kd 1 1 1\n# newmtl no\nmap_Kd a.png\n");
        assert!(all.is_empty() && images.is_empty());
        assert_eq!(all.problems, ["a.mtl: contains no materials"]);
        for line in [
            "Kd 1",
            "Kd 1 x 1",
            "Kd NaN inf -1",
            "d",
            "d nan",
            "Tr",
            "map_Kd",
            "map_Kd -s",
            "map_Kd -",
            "illum x",
        ] {
            let (all, images) = read(&format!("newmtl \u{fffd}\n{line}\n"));
            assert_eq!(all.get("\u{fffd}").map(|m| m.colour), Some([0.8, 0.8, 0.8, 1.0]), "{line}");
            assert!(images.is_empty(), "{line} {images:?}");
        }
    }
}
