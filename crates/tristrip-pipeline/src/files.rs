//! Reads the companion files of a source, such as materials and images, and writes results with
//! their companion files.
//!
//! ```text
//! source ─ materials of an OBJ, images of a .gltf ─▶ model ─▶ … ─▶ encoded ─┬▶ one file
//!                                                                           ├▶ .gltf, .bin
//!                                                                           └▶ OBJ, MTL, images
//! ```
//! A file is written under a temporary name and then renamed. If writing fails, the old file stays
//! unchanged.

use std::fs;
use std::io::{Error as SystemError, ErrorKind};
use std::path::{Path, PathBuf};

use tristrip::Layout;
use tristrip_io::{EmbeddedImages, Error as FileError, Format, Model, SideFile};

use crate::encode::{self, default_layout};
use crate::error::Error;

/// The formats that the pipeline can write.
pub const WRITTEN_FORMATS: [Format; 4] = [Format::Glb, Format::Gltf, Format::Ply, Format::Obj];

/// The destination of a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Target<'a> {
    /// The path; `None` for bytes in memory or a stream.
    pub path: Option<&'a Path>,
    /// The format. For a `.gltf` this is GLB, which is then split into two files.
    pub format: Format,
    /// Whether the result is a `.gltf` with its buffer in a separate file.
    pub separate: bool,
    /// Whether a missing directory of the file is created.
    pub creates_folder: bool,
}

/// The files that were written.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct WrittenFiles {
    /// The size of the result in bytes, without the materials and images of an OBJ.
    pub bytes: usize,
    /// The material libraries and images that were written for an OBJ.
    pub beside: Vec<PathBuf>,
    /// One warning per file that was not replaced.
    pub warnings: Vec<String>,
}

/// Returns the format of a file to write: the requested format, or the format of the extension.
///
/// # Errors
/// The format is unknown or cannot be written. The message has the file name.
///
/// ```
/// use std::path::Path;
/// use tristrip_io::Format;
/// use tristrip_pipeline::format_to_write;
/// assert_eq!(format_to_write(Path::new("a.gltf"), None), Ok(Format::Gltf));
/// assert_eq!(format_to_write(Path::new("a.dat"), Some(Format::Ply)), Ok(Format::Ply));
/// assert!(format_to_write(Path::new("a.stl"), None).is_err());
/// ```
pub fn format_to_write(path: &Path, format: Option<Format>) -> Result<Format, String> {
    let name = path.display();
    let format = match (format, Format::from_path(path)) {
        (Some(format), _) | (None, Some(format)) if WRITTEN_FORMATS.contains(&format) => format,
        (Some(format), _) | (None, Some(format)) => {
            return Err(format!("{name}: cannot write {}; use .glb, .gltf, .ply or .obj", format.name()));
        }
        (None, None) => {
            return Err(format!("{name}: unknown extension; use .glb, .gltf, .ply or .obj, or --to"));
        }
    };
    if format == Format::Gltf && path.extension().is_some_and(|extension| extension == "bin") {
        return Err(format!("{name}: glTF has its buffer in this file; use .gltf for the document"));
    }
    Ok(format)
}

/// Returns the requested layout, or the default layout of a format.
///
/// # Errors
/// The format has no strips.
///
/// ```
/// use tristrip::Layout;
/// use tristrip_io::Format;
/// use tristrip_pipeline::layout_to_write;
/// assert_eq!(layout_to_write(Format::Ply, None), Ok(Layout::Restart));
/// assert!(layout_to_write(Format::Obj, Some(Layout::Restart)).is_err());
/// ```
pub fn layout_to_write(format: Format, layout: Option<Layout>) -> Result<Layout, String> {
    match (format, layout) {
        (Format::Obj, None | Some(Layout::List)) => Ok(Layout::List),
        (Format::Obj, Some(_)) => Err("OBJ has no strips, only --layout list; use .glb or .ply".into()),
        (_, Some(layout)) => Ok(layout),
        (_, None) => Ok(default_layout(format)),
    }
}

impl<'a> Target<'a> {
    /// Creates a target for a file in a format that can be written, or for bytes in memory.
    pub fn new(path: Option<&'a Path>, format: Format) -> Self {
        let separate = format == Format::Gltf;
        let format = if separate { Format::Glb } else { format };
        Self { path, format, separate, creates_folder: false }
    }

    /// Returns whether this result needs the material libraries of an OBJ, either to embed or to
    /// copy them.
    pub fn takes_materials(&self, model: &Model) -> bool {
        match self.format {
            Format::Obj => self.path.is_some(),
            Format::Glb => model.scene.is_none() && model.materials.is_some(),
            _ => false,
        }
    }

    /// Returns whether this result embeds or copies the images that its source has in separate
    /// files. A `.gltf` in the directory of the source refers to them instead.
    pub fn takes_images(&self, source: Option<&Path>) -> bool {
        self.format == Format::Glb && !(self.separate && same_folder(source, self.path))
    }

    /// Loads data that this result needs from the directory of its source into the model: the
    /// materials of an OBJ and its libraries, and the images of a glTF in separate files. For an
    /// OBJ result, the materials of a glTF become a library. Returns which images were embedded.
    ///
    /// # Errors
    /// The image lists of a document are invalid.
    ///
    /// ```
    /// use std::path::Path;
    /// use tristrip_io::Format;
    /// use tristrip_pipeline::Target;
    /// let json = br#"{"asset":{"version":"2.0"},"images":[{"uri":"none.png"}]}"#;
    /// let mut model = tristrip_io::read(json, Format::Gltf)?;
    /// let glb = Target::new(Some(Path::new("out.glb")), Format::Glb);
    /// assert_eq!(glb.complete(&mut model, Some(Path::new("in/a.gltf")))?.left.len(), 1);
    /// # Ok::<(), tristrip_io::Error>(())
    /// ```
    pub fn complete(&self, model: &mut Model, source: Option<&Path>) -> Result<EmbeddedImages, FileError> {
        if self.takes_materials(model) {
            let stem = self.path.and_then(Path::file_stem).unwrap_or_default();
            tristrip_io::load_materials(model, source, &stem.to_string_lossy());
        }
        if self.takes_images(source) {
            return tristrip_io::embed_images(model, source);
        }
        Ok(EmbeddedImages::default())
    }

    /// Writes a result and its companion files. Existing companion files of an OBJ with other
    /// content are kept, with a warning, unless they are named after the OBJ.
    ///
    /// # Errors
    /// The target has no path, a file cannot be written, or the separate files of a `.gltf` fail
    /// verification.
    ///
    /// ```
    /// use tristrip_io::{Drawing, Format, read};
    /// use tristrip_pipeline::{Error, Target, encode};
    /// # let path = std::env::temp_dir().join("no such folder").join("a.ply");
    /// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj)?;
    /// let encoded = encode::run(&model, &[Drawing::Faces], &encode::Options::new(Format::Ply), &())?;
    /// let written = Target::new(Some(&path), Format::Ply).write(&encoded);
    /// assert!(matches!(written, Err(Error::Format(tristrip_io::Error::Io { .. }))));
    /// # Ok::<(), Error>(())
    /// ```
    pub fn write(&self, encoded: &encode::Outcome) -> Result<WrittenFiles, Error> {
        let Some(path) = self.path else {
            return Err(FileError::Unsupported("found no path, expected the path of a file".into()).into());
        };
        if !self.separate {
            self.write_bytes(path, &encoded.bytes)?;
            let written = WrittenFiles { bytes: encoded.bytes.len(), ..WrittenFiles::default() };
            return write_side_files(path, &encoded.files, written);
        }
        let buffer_path = path.with_extension("bin");
        let Some(name) = buffer_path.file_name().and_then(|name| name.to_str()) else {
            let message = "a .gltf needs a name in UTF-8 for its buffer";
            return Err(system(path, SystemError::new(ErrorKind::InvalidInput, message)));
        };
        let files = encoded.separate(name)?;
        // Write the buffer first: a document must never be without it.
        if !files.buffer.is_empty() {
            self.write_bytes(&buffer_path, &files.buffer)?;
        }
        self.write_bytes(path, &files.json)?;
        Ok(WrittenFiles { bytes: files.json.len() + files.buffer.len(), ..WrittenFiles::default() })
    }

    /// Writes the bytes of one file.
    ///
    /// # Errors
    /// The file or its directory cannot be written.
    pub fn write_bytes(&self, path: &Path, bytes: &[u8]) -> Result<(), Error> {
        if let Some(folder) = path.parent().filter(|folder| self.creates_folder && !folder.exists()) {
            // Create only the directory itself: a missing parent is more likely a typing error.
            fs::create_dir(folder).map_err(|error| system(folder, error))?;
        }
        Ok(tristrip_io::replace_file(path, bytes)?)
    }
}

/// Returns the file name of a level: the path with the level number before its extension.
///
/// ```
/// use std::path::Path;
/// assert_eq!(tristrip_pipeline::path_of_level(Path::new("a/b.ply"), 2), Path::new("a/b_2.ply"));
/// ```
pub fn path_of_level(path: &Path, level: usize) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!("_{level}"));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

/// Writes the material libraries and images of an OBJ into its directory.
fn write_side_files(
    path: &Path,
    files: &[SideFile],
    mut written: WrittenFiles,
) -> Result<WrittenFiles, Error> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    for file in files {
        let target = folder.join(&file.name);
        match fs::read(&target) {
            Ok(bytes) if bytes == **file.bytes => continue,
            Ok(_) if !file.name.starts_with(&*stem) => {
                let warning = format!("{} exists with other content and was not replaced", target.display());
                written.warnings.push(warning);
                continue;
            }
            _ => (),
        }
        if let Some(folder) = target.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            fs::create_dir_all(folder).map_err(|error| system(folder, error))?;
        }
        tristrip_io::replace_file(&target, &file.bytes)?;
        written.beside.push(target);
    }
    Ok(written)
}

/// Returns whether two files are in the same directory, after following links.
fn same_folder(a: Option<&Path>, b: Option<&Path>) -> bool {
    let folder = |path: Option<&Path>| match path?.parent()? {
        here if here.as_os_str().is_empty() => Path::new(".").canonicalize().ok(),
        parent => parent.canonicalize().ok(),
    };
    folder(a).is_some_and(|a| folder(b).is_some_and(|b| a == b))
}

fn system(path: &Path, source: SystemError) -> Error {
    FileError::Io { path: path.display().to_string(), source }.into()
}
