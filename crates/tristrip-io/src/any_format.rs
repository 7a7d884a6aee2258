//! Reads and writes models in a format selected at run time.

use std::sync::Arc;

use tristrip::Layout;

use crate::error::Error;
use crate::format::Format;
use crate::gltf::BufferFiles;
use crate::materials::PlainMaterial;
use crate::model::{Drawing, Model, Part};
use crate::{gltf, obj, off, ply, stl, tlod};

/// Reads a model from the bytes of a file. A glTF file must contain its buffers;
/// [`read_path`](crate::read_path) also finds separate buffer files.
///
/// # Errors
/// The bytes are not a valid file of this format ([`Error::Format`]), or a count or size exceeds a
/// limit ([`Error::LimitExceeded`]).
///
/// ```
/// use tristrip_io::{Format, read};
/// let off = b"OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";
/// let model = read(off, Format::from_bytes(off))?;
/// assert_eq!(model.parts[0].mesh.faces().get(0), Some(&[0, 1, 2, 3][..]));
/// let wrong = read(b"v 0 0 zero\n", Format::Obj).unwrap_err();
/// assert_eq!(wrong.to_string(), "line 1: found `zero`, expected a number for z");
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn read(bytes: &[u8], format: Format) -> Result<Model, Error> {
    match format {
        Format::Gltf | Format::Glb => read_shared(&Arc::new(bytes.to_vec()), format),
        _ => read_other(bytes, format),
    }
}

/// Reads a model like [`read`], but does not copy the bytes of a glTF file: the model shares them.
///
/// # Errors
/// The bytes are not a valid file of this format ([`Error::Format`]), or a count or size exceeds a
/// limit ([`Error::LimitExceeded`]).
///
/// ```
/// use std::sync::Arc;
/// use tristrip_io::{Format, read_shared};
/// let bytes = Arc::new(br#"{"asset":{"version":"2.0"}}"#.to_vec());
/// let model = read_shared(&bytes, Format::Gltf)?;
/// drop(model);
/// assert!(Arc::try_unwrap(bytes).is_ok());
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn read_shared(bytes: &Arc<Vec<u8>>, format: Format) -> Result<Model, Error> {
    read_with_files(bytes, format, &mut BufferFiles::new(&[]))
}

/// Reads a model whose external buffers, if any, are in `files`.
pub(crate) fn read_with_files(
    bytes: &Arc<Vec<u8>>,
    format: Format,
    files: &mut BufferFiles<'_>,
) -> Result<Model, Error> {
    match format {
        Format::Gltf | Format::Glb if !bytes.is_empty() && !tlod::is_tlod(bytes) => {
            gltf::read_with_files(Arc::clone(bytes), files)
        }
        _ => read_other(bytes, format),
    }
}

/// Reads a model in a format whose models do not share the bytes of the file.
fn read_other(bytes: &[u8], format: Format) -> Result<Model, Error> {
    match format {
        _ if bytes.is_empty() => {
            Err(Error::format("byte 0", "an empty file", format!("a non-empty {} file", format.name())))
        }
        _ if tlod::is_tlod(bytes) => {
            Err(Error::format("byte 0", "a view-dependent .tlod model", "a mesh or a scene"))
        }
        Format::Obj => obj::read(bytes),
        Format::Ply => ply::read(bytes),
        Format::Off => off::read(bytes),
        Format::Stl => stl::read(bytes),
        Format::Gltf | Format::Glb => gltf::read(bytes, None),
    }
}

/// Writes a model. Each part is written as its faces, or as strips of its vertices in the given
/// layout.
///
/// - OBJ has no strips. In every layout, the triangles of strips are written in strip order.
/// - PLY has the `tristrips` element. [`Layout::Restart`] writes all strips to one row, with −1
///   between them. [`Layout::Separate`] writes one row per strip, and [`Layout::Degenerate`] writes
///   one row per part. [`Layout::List`] writes the triangles as faces. The file is little-endian
///   binary.
/// - GLB keeps the scene that the model was read with: only indices and modes of its triangle
///   primitives change, and [`Drawing::Faces`] leaves a triangle list unchanged. For a model
///   without a scene, the writer builds a minimal document. It contains one mesh and one node per
///   run of parts with the same name, one primitive per part, and one material per material name.
///
/// # Errors
/// The format cannot be written, the number of drawings differs from the number of parts, a strip
/// uses a vertex that its part does not have, or there are too many vertices for 32-bit ids.
///
/// ```
/// use tristrip_io::{Drawing, Format, read, write};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 4 3\n", Format::Obj)?;
/// let mut strips = tristrip::Strips::default();
/// strips.push(&[0, 1, 2, 3]);
/// let ply = write(&model, &[Drawing::Strips(&strips)], Format::Ply, tristrip::Layout::Restart)?;
/// assert_eq!(read(&ply, Format::Ply)?.parts[0].mesh.faces().face_count(), 2);
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn write(model: &Model, drawings: &[Drawing], format: Format, layout: Layout) -> Result<Vec<u8>, Error> {
    match format {
        Format::Obj => obj::write(model, drawings),
        Format::Ply => ply::write(model, drawings, layout),
        Format::Glb => gltf::write_glb(model, drawings, layout),
        Format::Off | Format::Stl | Format::Gltf => {
            Err(Error::Unsupported(format!("{} cannot be written; use .obj, .ply or .glb", format.name())))
        }
    }
}

/// Lists how materials change in appearance when a model is written to a given format. Load the
/// materials first with [`load_materials`](crate::load_materials) if the model was read from OBJ,
/// or if a glTF model is written as OBJ.
///
/// ```
/// use tristrip_io::{Format, material_losses, read};
/// let model = read(b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n", Format::Obj)?;
/// let lost = material_losses(&model, Format::Ply);
/// assert_eq!(lost, ["materials are not written: PLY does not support them"]);
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn material_losses(model: &Model, format: Format) -> Vec<String> {
    let of_scene = model.scene.as_ref().is_some_and(gltf::Scene::has_materials);
    match (&model.materials, format) {
        (_, Format::Glb | Format::Gltf) if model.scene.is_some() => Vec::new(),
        (Some(materials), Format::Glb | Format::Gltf) => {
            materials.problems.iter().chain(&materials.losses).cloned().collect()
        }
        (Some(materials), Format::Obj) => materials.problems.clone(),
        (None, Format::Obj) if of_scene => {
            vec!["materials are not written: no material library was created for the OBJ".into()]
        }
        (Some(materials), _) if of_scene || !materials.libraries.is_empty() || !materials.is_empty() => {
            vec![format!("materials are not written: {} does not support them", format.name())]
        }
        (None, Format::Ply) if of_scene => {
            vec![format!("materials are not written: {} does not support them", format.name())]
        }
        _ => Vec::new(),
    }
}

/// Returns the material of each part, reduced to the common properties of glTF and OBJ, and notes
/// on omitted properties. The entry is `None` for a part without a material. For a model read from
/// OBJ, load the materials first with [`load_materials`](crate::load_materials).
///
/// # Errors
/// The materials, textures or images of a scene are not valid glTF 2.0.
///
/// ```
/// use tristrip_io::{Format, Materials, PlainMaterial, plain_materials, read};
/// let mut model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n", Format::Obj)?;
/// let red = PlainMaterial { base_colour: [1.0, 0.0, 0.0, 1.0], ..PlainMaterial::default() };
/// model.materials.get_or_insert_default().add_plain("red", &red);
/// assert_eq!(plain_materials(&model)?.0, [Some(red.clone())]);
/// let drawings = [tristrip_io::Drawing::Faces];
/// let glb = tristrip_io::write(&model, &drawings, Format::Glb, tristrip::Layout::List)?;
/// assert_eq!(plain_materials(&read(&glb, Format::Glb)?)?.0, [Some(red)]);
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn plain_materials(model: &Model) -> Result<(Vec<Option<PlainMaterial>>, Vec<String>), Error> {
    let Some(scene) = &model.scene else {
        let known = |part: &Part| model.materials.as_ref()?.plain(part.material.as_deref()?);
        return Ok((model.parts.iter().map(known).collect(), Vec::new()));
    };
    let surfaces = scene.surfaces()?;
    let images: Vec<Arc<Vec<u8>>> =
        surfaces.images.iter().map(|image| Arc::new(image.bytes().to_vec())).collect();
    let mut notes = surfaces.notes;
    let mut elsewhere = 0;
    let plain = |(part, material): (&Part, &gltf::Material)| {
        if part.material.is_none() && *material == gltf::Material::default() {
            return None;
        }
        elsewhere += usize::from(material.texture.is_some_and(|texture| texture.coordinates != 0));
        let image = material.texture.filter(|texture| texture.coordinates == 0);
        Some(PlainMaterial {
            base_colour: material.base_colour,
            metalness: material.metalness,
            roughness: material.roughness,
            is_blended: material.is_blended,
            image: image.and_then(|texture| images.get(texture.image).cloned()),
        })
    };
    let materials = model.parts.iter().zip(&surfaces.materials).map(plain).collect();
    if elsewhere > 0 {
        notes.push(format!("textures skipped because they do not use TEXCOORD_0: {elsewhere}"));
    }
    Ok((materials, notes))
}

/// Lists the data of a model and its scene that a format cannot store, with counts. `drawings` has
/// one entry per part. The writers of OBJ and PLY add the same lines to the file as comments.
///
/// ```
/// use tristrip_io::{Drawing, Format, losses, read};
/// let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 1 3 2\n";
/// let model = read(obj, Format::Obj)?;
/// let lost = losses(&model, &[Drawing::Faces; 2], Format::Ply);
/// assert_eq!(lost, ["parts joined into one: 2", "material names not written: 2"]);
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn losses(model: &Model, drawings: &[Drawing], format: Format) -> Vec<String> {
    match format {
        Format::Obj => obj::losses(model, drawings),
        Format::Ply => ply::losses(model),
        Format::Glb => gltf::losses(model, drawings),
        Format::Off | Format::Stl | Format::Gltf => Vec::new(),
    }
}
