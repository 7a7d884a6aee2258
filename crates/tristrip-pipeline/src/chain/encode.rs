//! Files of a chain: one scene with all levels, or one file per level. Parts are drawn as strips or
//! cache-ordered lists, and the bytes are verified.
//!
//! Verification reads the bytes back. For each level, it compares the drawn meshes with the
//! triangles that remain after the collapses of the source. Positions are compared by their bits.

use std::collections::HashSet;
use std::sync::Arc;

use tristrip::verify::verify_models;
use tristrip::{Faces, Mesh, Method, StripifyOptions};
use tristrip_io::{Format, Model, SceneLevels};

use super::{Chain, coverage};
use crate::drawing::choose;
use crate::encode;
use crate::error::Error;
use crate::observer::{Observer, Stage, begin};
use crate::parts::meshes;
use crate::prepared::PreparedModel;
use crate::text::counted;

/// A file with all levels of a chain.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct File {
    /// The encoded file.
    pub encoded: encode::Outcome,
    /// The size in bytes of the indices and vertices that each level uses, the finest level first.
    pub level_bytes: Vec<usize>,
}

impl Chain {
    /// Encodes all levels as one GLB. The nodes of a mesh refer to their lower levels by
    /// `MSFT_lod`. If requested, the bytes are verified level by level. `model` must be the model
    /// that the chain was built from.
    ///
    /// # Errors
    /// The format is not GLB, the scene already has levels of detail, the bytes fail verification,
    /// or the observer cancelled the operation.
    ///
    /// ```
    /// use tristrip_io::{Format, read};
    /// use tristrip_pipeline::{chain, encode};
    /// let corners = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0\n";
    /// let model = read([corners, "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"].concat().as_bytes(), Format::Obj)?;
    /// let options = chain::Options::new("100%,50%".parse().unwrap_or_default(), Format::Glb);
    /// let built = chain::run(&model, &options, &())?;
    /// let file = built.chain.encode(&model, &encode::Options::new(Format::Glb), &())?;
    /// assert_eq!((file.encoded.faces, file.level_bytes.len()), (Some(4 + 2), 2));
    /// # Ok::<(), tristrip_pipeline::Error>(())
    /// ```
    pub fn encode(
        &self,
        model: &Model,
        options: &encode::Options,
        observer: &dyn Observer,
    ) -> Result<File, Error> {
        if options.format != Format::Glb {
            let message = "only a GLB can have several levels of detail; write one file per level";
            return Err(tristrip_io::Error::Unsupported(message.into()).into());
        }
        self.check_format(*options)?;
        let coverage = |parts: &[usize]| {
            let extents: Vec<_> = parts.iter().map(|&part| &self.extents[part]).collect();
            coverage::coverages(&extents)
        };
        let scene = self.leveled.scene(&coverage)?;
        let mut encoded = self.strip_and_encode(&scene.model, *options, observer)?;
        let (level_bytes, faces) = self.prove_scene(model, &scene, &mut encoded.bytes, *options, observer)?;
        encoded.faces = faces;
        // A model without a scene gets one here, and may lose data that glTF cannot store.
        let drawings = vec![tristrip_io::Drawing::Faces; model.parts.len()];
        encoded.notes.extend(tristrip_io::losses(&self.leveled.model, &drawings, options.format));
        if scene.nodes_without > 0 {
            let nodes = counted(scene.nodes_without, "node");
            encoded.notes.push(format!(
                "{nodes} without lower levels: KHR_animation_pointer animates their morph weights"
            ));
        }
        Ok(File { encoded, level_bytes })
    }

    /// Encodes one level as a separate file with only the vertices that it uses, and verifies the
    /// bytes if requested. `model` must be the model that the chain was built from.
    ///
    /// # Errors
    /// The level does not exist, the format cannot store it, the bytes fail verification, or the
    /// observer cancelled the operation.
    ///
    /// ```
    /// use tristrip_io::{Format, read};
    /// use tristrip_pipeline::{chain, encode};
    /// let corners = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0\n";
    /// let model = read([corners, "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"].concat().as_bytes(), Format::Obj)?;
    /// let options = chain::Options::new("100%,50%".parse().unwrap_or_default(), Format::Ply);
    /// let built = chain::run(&model, &options, &())?;
    /// let half = built.chain.encode_level(&model, 1, &encode::Options::new(Format::Ply), &())?;
    /// assert_eq!(half.faces, Some(2));
    /// # Ok::<(), tristrip_pipeline::Error>(())
    /// ```
    pub fn encode_level(
        &self,
        model: &Model,
        level: usize,
        options: &encode::Options,
        observer: &dyn Observer,
    ) -> Result<encode::Outcome, Error> {
        self.check_format(*options)?;
        let last = self.expected.len().saturating_sub(1);
        let triangles = self.leveled.triangles.get(level).ok_or(Error::Level { found: level, last })?;
        let smaller = tristrip_io::with_triangles(&self.leveled.model, triangles.clone(), options.format)?;
        let mut encoded = self.strip_and_encode(&smaller.model, *options, observer)?;
        if options.verify {
            begin(observer, Stage::ReadBack)?;
            let shared = Arc::new(std::mem::take(&mut encoded.bytes));
            let again =
                tristrip_io::read_shared(&shared, options.format).map_err(|error| unproven(&error))?;
            encoded.faces = Some(self.prove_level(model, level, &meshes(&again))?);
            drop(again);
            encoded.bytes = Arc::unwrap_or_clone(shared);
        }
        Ok(encoded)
    }

    /// Checks that a file has the format that the vertices were ordered for.
    fn check_format(&self, options: encode::Options) -> Result<(), Error> {
        let (found, expected) = (options.format, self.options.format);
        if found == expected {
            return Ok(());
        }
        let message =
            format!("format: found {}, expected {}, the format of the chain", found.name(), expected.name());
        Err(tristrip_io::Error::Unsupported(message).into())
    }

    /// Builds strips, or a cache-ordered triangle list, and encodes the model. The bytes are
    /// not verified here.
    fn strip_and_encode(
        &self,
        model: &Model,
        options: encode::Options,
        observer: &dyn Observer,
    ) -> Result<encode::Outcome, Error> {
        let stripify: StripifyOptions = self.options.stripify;
        begin(observer, Stage::Prepare)?;
        let prepared = PreparedModel::new(model, stripify.weld);
        let (strips, stopped) = prepared.search(&stripify, observer)?;
        begin(observer, Stage::Measure)?;
        let (_, of_parts) = prepared.metrics_with_parts(&strips, &stripify)?;
        if options.verify {
            begin(observer, Stage::Prove)?;
            prepared.prove(&strips)?;
        }
        drop(prepared);
        let keep_found = stripify.method == Method::Cache;
        let drawn = choose(model, (&strips, &of_parts), options, keep_found);
        let mut encoded = encode::run(model, &drawn.drawings, &options.with_verify(false), observer)?;
        encoded.notes.extend(stopped.map(|stopped| stopped.note().to_owned()));
        Ok(encoded)
    }

    /// Reads a scene back. Returns the bytes that each level uses, and the number of verified
    /// faces.
    fn prove_scene(
        &self,
        model: &Model,
        scene: &SceneLevels,
        bytes: &mut Vec<u8>,
        options: encode::Options,
        observer: &dyn Observer,
    ) -> Result<(Vec<usize>, Option<usize>), Error> {
        begin(observer, Stage::ReadBack)?;
        let shared = Arc::new(std::mem::take(bytes));
        let again = tristrip_io::read_shared(&shared, options.format).map_err(|error| unproven(&error))?;
        let Some(found) = &again.scene else { return Err(Error::unproven("found no scene")) };
        let mesh_of_parts = found.mesh_of_parts();
        let (mut level_bytes, mut faces) = (Vec::new(), 0);
        for (level, drawn) in scene.meshes.iter().enumerate() {
            level_bytes.push(found.bytes_of_meshes(drawn)?);
            if options.verify {
                let drawn: HashSet<usize> = drawn.iter().copied().collect();
                let parts = again.parts.iter().zip(&mesh_of_parts);
                let of_level = parts.filter(|(_, mesh)| drawn.contains(mesh)).map(|(part, _)| &part.mesh);
                faces += self.prove_level(model, level, &of_level.collect::<Vec<_>>())?;
            }
        }
        drop(again);
        *bytes = Arc::unwrap_or_clone(shared);
        Ok((level_bytes, options.verify.then_some(faces)))
    }

    /// Verifies that meshes draw a level, and returns its number of triangles.
    fn prove_level(&self, model: &Model, level: usize, found: &[&Mesh]) -> Result<usize, Error> {
        let expected = model
            .parts
            .iter()
            .zip(&self.expected[level])
            .map(|(part, triangles)| part.mesh.with_faces(Faces::from_triangles(triangles.clone())?));
        let expected: Vec<Mesh> = expected.collect::<Result<_, tristrip::Error>>()?;
        match verify_models(&expected.iter().collect::<Vec<_>>(), found)? {
            Ok(proof) => Ok(proof.faces),
            Err(why) => Err(Error::unproven(format!("level {level}: {why}"))),
        }
    }
}

fn unproven(error: &tristrip_io::Error) -> Error {
    Error::unproven(error.to_string())
}
