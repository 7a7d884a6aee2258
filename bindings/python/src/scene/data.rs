//! What a scene holds: the model as it was read, and the same with the materials and images that it has in other files.
//!
//! These are read when the scene is: nothing later depends on the files.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use tristrip::Layout;
use tristrip_io::{Drawing, Format, Model, PlainMaterial, ReadFile};
use tristrip_pipeline::{Target, convert};

use crate::errors::Failure;

/// A model, and where it is from.
#[derive(Debug, Default)]
pub(crate) struct SceneData {
    model: Model,
    /// The model with its images, if it has any in other files.
    complete: Option<Model>,
    path: Option<PathBuf>,
    format: Option<Format>,
    /// The file of a glTF, which the model shares.
    bytes: Option<Arc<Vec<u8>>>,
    materials: OnceLock<Vec<Option<PlainMaterial>>>,
}

impl SceneData {
    /// Reads a file, with the materials and images that belong to it.
    pub(crate) fn read(path: &Path, format: Option<Format>) -> Result<Self, Failure> {
        let ReadFile { model, bytes, format, .. } = tristrip_io::read_file(path, format)?;
        let path = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        let scene = Self { model, path: Some(path), format: Some(format), ..Self::default() };
        scene.with_files(bytes)
    }

    /// Reads the bytes of a file; without a format, that of their content.
    pub(crate) fn of_bytes(bytes: Vec<u8>, format: Option<Format>) -> Result<Self, Failure> {
        let bytes = Arc::new(bytes);
        let format = format.unwrap_or_else(|| Format::from_bytes(&bytes));
        let model = tristrip_io::read_shared(&bytes, format)?;
        let scene = Self { model, format: Some(format), ..Self::default() };
        scene.with_files(bytes)
    }

    /// Takes over a model that was built here.
    pub(crate) fn of_model(model: Model) -> Self {
        Self { model, ..Self::default() }
    }

    /// Adds a note of the reader or builder.
    pub(crate) fn with_notes(mut self, notes: impl IntoIterator<Item = String>) -> Self {
        self.model.notes.extend(notes);
        self
    }

    /// Sets the notes and the format that a pickled scene had.
    pub(crate) fn restored(mut self, notes: Vec<String>, format: Option<Format>) -> Self {
        if let Some(complete) = &mut self.complete {
            complete.notes.clone_from(&notes);
        }
        self.model.notes = notes;
        Self { format, ..self }
    }

    /// Reads the materials and images that are in other files.
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

    /// The model as its file has it: images in other files stay there.
    pub(crate) fn as_read(&self) -> &Model {
        &self.model
    }

    /// The model with the images that its file has in others.
    pub(crate) fn model(&self) -> &Model {
        self.complete.as_ref().unwrap_or(&self.model)
    }

    /// The file that was read.
    pub(crate) fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    pub(crate) fn format(&self) -> Option<Format> {
        self.format
    }

    /// The size of the file that was read; none of a .gltf, whose buffers may be in other files.
    pub(crate) fn file_bytes(&self) -> Option<u64> {
        let path = self.path.as_ref().filter(|_| self.format != Some(Format::Gltf))?;
        Some(std::fs::metadata(path).ok()?.len())
    }

    /// The model for a destination: with images unless these stay in their files, with a library for an OBJ.
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

    /// Warnings on images that a destination only refers to.
    pub(crate) fn image_notes(&self, target: &Target<'_>) -> Vec<String> {
        let taken = self.complete.as_ref().filter(|_| target.takes_images(self.path()));
        let known = self.model.notes.len();
        taken.map(|complete| complete.notes[known..].to_vec()).unwrap_or_default()
    }

    /// The material of each part, read once.
    pub(crate) fn materials(&self) -> Result<&[Option<PlainMaterial>], Failure> {
        if let Some(known) = self.materials.get() {
            return Ok(known);
        }
        let (materials, _) = tristrip_io::plain_materials(self.model())?;
        Ok(self.materials.get_or_init(|| materials))
    }

    /// The bytes of a file from which the scene can be read again: the one that was read, or a GLB.
    pub(crate) fn self_contained(&self) -> Result<(Arc<Vec<u8>>, Format), Failure> {
        if let (Some(bytes), Some(format), None) = (&self.bytes, self.format, &self.complete)
            && tristrip_io::read_shared(bytes, format).is_ok()
        {
            return Ok((Arc::clone(bytes), format));
        }
        let converted = convert::run(self.model(), &convert::Options::new(Format::Glb), &())?;
        Ok((Arc::new(converted.encoded.bytes), Format::Glb))
    }

    /// The model as a picture shows it: a scene, so that materials are seen.
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
