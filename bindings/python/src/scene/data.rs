//! The data of a scene: the model as read, and a version that includes materials and images from
//! other files.
//!
//! All files are read when the scene is, so later operations do not depend on them.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use tristrip::Layout;
use tristrip_io::{Drawing, Format, Model, PlainMaterial, ReadFile};
use tristrip_pipeline::{Target, convert};

use crate::errors::Failure;

/// A model and its source.
#[derive(Debug, Default)]
pub(crate) struct SceneData {
    model: Model,
    /// The model including images from other files, if there are any.
    complete: Option<Model>,
    path: Option<PathBuf>,
    format: Option<Format>,
    /// The bytes of a glTF file, shared with the model.
    bytes: Option<Arc<Vec<u8>>>,
    materials: OnceLock<Vec<Option<PlainMaterial>>>,
}

impl SceneData {
    /// Reads a file with its materials and images.
    pub(crate) fn read(path: &Path, format: Option<Format>) -> Result<Self, Failure> {
        let ReadFile { model, bytes, format, .. } = tristrip_io::read_file(path, format)?;
        let path = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        let scene = Self { model, path: Some(path), format: Some(format), ..Self::default() };
        scene.with_files(bytes)
    }

    /// Reads the bytes of a file. Without a format, the content determines it.
    pub(crate) fn of_bytes(bytes: Vec<u8>, format: Option<Format>) -> Result<Self, Failure> {
        let bytes = Arc::new(bytes);
        let format = format.unwrap_or_else(|| Format::from_bytes(&bytes));
        let model = tristrip_io::read_shared(&bytes, format)?;
        let scene = Self { model, format: Some(format), ..Self::default() };
        scene.with_files(bytes)
    }

    /// Wraps a model that was built in memory.
    pub(crate) fn of_model(model: Model) -> Self {
        Self { model, ..Self::default() }
    }

    /// Adds notes of a reader or builder.
    pub(crate) fn with_notes(mut self, notes: impl IntoIterator<Item = String>) -> Self {
        self.model.notes.extend(notes);
        self
    }

    /// Sets the notes and format of an unpickled scene.
    pub(crate) fn restored(mut self, notes: Vec<String>, format: Option<Format>) -> Self {
        if let Some(complete) = &mut self.complete {
            complete.notes.clone_from(&notes);
        }
        self.model.notes = notes;
        Self { format, ..self }
    }

    /// Reads materials and images from other files.
    fn with_files(mut self, bytes: Arc<Vec<u8>>) -> Result<Self, Failure> {
        let path = self.path.as_deref();
        if self.model.scene.is_none() {
            tristrip_io::load_materials(&mut self.model, path, "");
            return Ok(self);
        }
        self.bytes = Some(bytes);
        let mut complete = self.model.clone();
        let images = tristrip_io::embed_images(&mut complete, path)?;
        if images.embedded > 0 || !images.left.is_empty() {
            self.complete = Some(complete);
        }
        Ok(self)
    }

    /// Returns the model as read, without images from other files.
    pub(crate) fn as_read(&self) -> &Model {
        &self.model
    }

    /// Returns the model including images from other files.
    pub(crate) fn model(&self) -> &Model {
        self.complete.as_ref().unwrap_or(&self.model)
    }

    /// Returns the path of the source file.
    pub(crate) fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    pub(crate) fn format(&self) -> Option<Format> {
        self.format
    }

    /// Returns the size of the source file, or `None` for a .gltf file, whose buffers may be in
    /// other files.
    pub(crate) fn file_bytes(&self) -> Option<u64> {
        let path = self.path.as_ref().filter(|_| self.format != Some(Format::Gltf))?;
        Some(std::fs::metadata(path).ok()?.len())
    }

    /// Returns the model for a destination: with embedded images unless the target keeps references
    /// to image files; with a material library for OBJ.
    pub(crate) fn model_for(&self, target: &Target<'_>) -> Cow<'_, Model> {
        let model = if target.takes_images(self.path()) { self.model() } else { self.as_read() };
        let has_library = model.materials.as_ref().is_some_and(|known| !known.libraries.is_empty());
        if target.format != Format::Obj || target.path.is_none() || has_library {
            return Cow::Borrowed(model);
        }
        let mut model = model.clone();
        let stem = target.path.and_then(Path::file_stem).unwrap_or_default();
        tristrip_io::load_materials(&mut model, None, &stem.to_string_lossy());
        Cow::Owned(model)
    }

    /// Returns warnings about images that the output only refers to.
    pub(crate) fn image_notes(&self, target: &Target<'_>) -> Vec<String> {
        let taken = self.complete.as_ref().filter(|_| target.takes_images(self.path()));
        let known = self.model.notes.len();
        taken.map(|complete| complete.notes[known..].to_vec()).unwrap_or_default()
    }

    /// Returns the material of each part; parsed once.
    pub(crate) fn materials(&self) -> Result<&[Option<PlainMaterial>], Failure> {
        if let Some(known) = self.materials.get() {
            return Ok(known);
        }
        let (materials, _) = tristrip_io::plain_materials(self.model())?;
        Ok(self.materials.get_or_init(|| materials))
    }

    /// Returns the bytes of a file that restores the scene: the source file, or a GLB.
    pub(crate) fn self_contained(&self) -> Result<(Arc<Vec<u8>>, Format), Failure> {
        if let (Some(bytes), Some(format), None) = (&self.bytes, self.format, &self.complete)
            && tristrip_io::read_shared(bytes, format).is_ok()
        {
            return Ok((Arc::clone(bytes), format));
        }
        let converted = convert::run(self.model(), &convert::Options::new(Format::Glb), &())?;
        Ok((Arc::new(converted.encoded.bytes), Format::Glb))
    }

    /// Returns the model as a glTF scene for rendering, so that materials are shown.
    pub(crate) fn pictured(&self) -> Result<Cow<'_, Model>, Failure> {
        let model = self.model();
        if model.materials.as_ref().is_none_or(tristrip_io::Materials::is_empty) || model.scene.is_some() {
            return Ok(Cow::Borrowed(model));
        }
        let drawings = vec![Drawing::Faces; model.parts.len()];
        let glb = tristrip_io::write(model, &drawings, Format::Glb, Layout::List)?;
        Ok(Cow::Owned(tristrip_io::read_shared(&Arc::new(glb), Format::Glb)?))
    }
}
