//! The parts of a scene: vertices, faces, attributes and one material each.

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple, PyType};
use tristrip::{Attribute, AttributeData, Faces, Mesh};

use super::materials::{NamedMaterial, dictionary};
use crate::arrays::positions;
use crate::attributes::{
    COLOUR, GivenAttributes, NORMAL, UV, all, named, positions_of, stored_attribute, to_array, triangles_of,
};
use crate::errors::Failure;
use crate::mesh::mesh_of;
use crate::strips::Strips;

/// A part of a scene: a mesh with at most one material.
///
/// A part is one material of an OBJ file, one primitive of a glTF file, or the whole mesh of
/// another file. Created from arrays, or returned by `Scene.parts`.
///
/// Args:
///     vertices: positions of shape (n, 3).
///     faces: see `stripify`: shape (m, 3), (m, k), or a list of lists for polygons of different
///         sizes.
///     normals: unit vectors of shape (n, 3).
///     uv: texture coordinates of shape (n, 2).
///     colors: shape (n, 3) or (n, 4); floats from 0 to 1 in linear light, or 8- or 16-bit
///         integers.
///     attributes: other per-vertex arrays by glTF name ("TEXCOORD_1", "TANGENT", …) or any other
///         name.
///     name: the name of the object.
///     material: the name of a material, or a dictionary with any of "name", "base_color" (three or
///         four numbers from 0 to 1 in linear light), "base_color_image" (the bytes of a PNG or
///         JPEG), "metallic" and "roughness" (0 to 1; default 0 and 1), "blend" (whether to apply
///         the opacity; by default if it is below 1).
///     uv_origin: the image corner with texture coordinates (0, 0): "bottom" left, as in OBJ,
///         Blender, trimesh and OpenGL, or "top" left, as in glTF. Written files use the convention
///         of their format.
///     normalized: the names of normalized integer attributes, which represent fractions of their
///         range. By default those that glTF normalizes: "COLOR_0", …
///
/// Raises:
///     MeshError: an array has an invalid shape or invalid values.
///     ArrayTypeError: an array has an unsupported dtype.
///     ParameterError: a material or name is invalid.
///
/// >>> import tristrip
/// >>> part = tristrip.Part([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], name="triangle", material={"base_color": (1, 0, 0)})
/// >>> part
/// Part('triangle', 3 vertices, 1 face)
/// >>> part.material_properties["base_color"]
/// (1.0, 0.0, 0.0, 1.0)
#[pyclass(frozen, module = "tristrip")]
#[derive(Debug, Clone)]
pub(crate) struct Part {
    pub(crate) inner: tristrip_io::Part,
    pub(crate) material: NamedMaterial,
    /// Whether v runs down from the top edge of the image; `None` if the format does not define it.
    pub(crate) counts_down: Option<bool>,
}

impl Part {
    /// Returns a part without name or material.
    pub(crate) fn of_mesh(mesh: Mesh) -> Self {
        let inner = tristrip_io::Part { mesh, ..tristrip_io::Part::default() };
        Self { inner, material: NamedMaterial::default(), counts_down: None }
    }

    fn mesh(&self) -> &Mesh {
        &self.inner.mesh
    }

    /// Returns the mesh with the given direction of v.
    pub(crate) fn mesh_counting(&self, down: bool) -> Result<Mesh, Failure> {
        let mesh = self.mesh();
        let is_other = self.counts_down.is_some_and(|counts_down| counts_down != down);
        if !is_other || !mesh.attributes().iter().any(|attribute| is_uv(&attribute.name)) {
            return Ok(mesh.clone());
        }
        let mut changed = Mesh::new(mesh.shared_positions(), mesh.faces().clone())?;
        for attribute in mesh.attributes() {
            let mut attribute = attribute.clone();
            if is_uv(&attribute.name) {
                flip(&mut attribute);
            }
            changed = changed.with_attribute(attribute)?;
        }
        Ok(changed)
    }
}

fn is_uv(name: &str) -> bool {
    name.starts_with("TEXCOORD_")
}

#[pymethods]
impl Part {
    #[new]
    #[pyo3(signature = (vertices, faces, *, normals = None, uv = None, colors = None, attributes = None, name = None, material = None, uv_origin = "bottom", normalized = None))]
    #[allow(clippy::too_many_arguments, reason = "keyword arguments of Python")]
    pub(crate) fn new(
        vertices: &Bound<'_, PyAny>,
        faces: &Bound<'_, PyAny>,
        normals: Option<&Bound<'_, PyAny>>,
        uv: Option<&Bound<'_, PyAny>>,
        colors: Option<&Bound<'_, PyAny>>,
        attributes: Option<&Bound<'_, PyDict>>,
        name: Option<String>,
        material: Option<&Bound<'_, PyAny>>,
        uv_origin: &str,
        normalized: Option<Vec<String>>,
    ) -> PyResult<Self> {
        let given = GivenAttributes { normals, uv, colors, others: attributes };
        let mut mesh = given.add_to(mesh_of(vertices, faces)?)?;
        if let Some(names) = &normalized {
            mesh = with_normalized(&mesh, names)?;
        }
        let counts_down = match uv_origin {
            "bottom" => false,
            "top" => true,
            other => {
                return Err(Failure::option("uv_origin", format!("{other:?}"), "'bottom' or 'top'").into());
            }
        };
        let material = NamedMaterial::of(material)?;
        let inner = tristrip_io::Part { name, material: material.name.clone(), mesh, ..Default::default() };
        Ok(Self { inner, material, counts_down: Some(counts_down) })
    }

    /// The name of the object, group or mesh; None if the file has none.
    #[getter]
    fn name(&self) -> Option<&str> {
        self.inner.name.as_deref()
    }

    /// The name of the material; None without one.
    #[getter]
    fn material(&self) -> Option<&str> {
        self.inner.material.as_deref()
    }

    /// The properties of the material, or None if they are unknown.
    ///
    /// A dictionary with "base_color" (four numbers in linear light), "base_color_image" (the bytes
    /// of a PNG or JPEG, or None), "metallic", "roughness" and "blend". `save` also keeps other
    /// properties that a material of a file has.
    #[getter]
    fn material_properties<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        self.material.plain.as_ref().map(|material| dictionary(py, material)).transpose()
    }

    /// The positions, as a copy: float32 of shape (n, 3).
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        positions_of(py, self.mesh())
    }

    /// The faces as triangles, as a copy: uint32 of shape (m, 3). Polygons are split into fans
    /// around their first corner.
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        triangles_of(py, self.mesh())
    }

    /// The faces as polygons, or None if all are triangles.
    ///
    /// A pair of arrays: the start of each face in the corners and the end of the last, int64 of
    /// shape (faces + 1,), and the vertex of each corner, uint32 of shape (corners,).
    #[getter]
    #[allow(clippy::type_complexity, reason = "two arrays")]
    fn polygons<'py>(
        &self,
        py: Python<'py>,
    ) -> Option<(Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<u32>>)> {
        let faces = self.mesh().faces();
        if faces.as_triangles().is_some() {
            return None;
        }
        Some((PyArray1::from_vec(py, offsets(faces)), PyArray1::from_slice(py, faces.corners())))
    }

    /// The attributes by name, as copies: arrays of shape (n, components), or (n,) for one
    /// component.
    #[getter]
    fn attributes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        all(py, self.mesh())
    }

    /// The names of the normalized integer attributes, in which 255 of uint8 stands for 1.
    #[getter]
    fn normalized(&self) -> Vec<&str> {
        let all = self.mesh().attributes().iter();
        all.filter(|attribute| attribute.normalized).map(|attribute| &*attribute.name).collect()
    }

    /// The normals, as a copy of shape (n, 3); None without normals.
    #[getter]
    fn normals<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        named(py, self.mesh(), NORMAL)
    }

    /// The first texture coordinates, of shape (n, 2); None without them.
    ///
    /// v runs up from the lower left corner of the image, as in OBJ, Blender and trimesh.
    /// `attributes` has the stored values.
    #[getter]
    fn uv<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let uv = self.mesh().attributes().iter().find(|attribute| attribute.name == UV);
        let Some(attribute) = uv else { return Ok(None) };
        let mut attribute = attribute.clone();
        if self.counts_down == Some(true) {
            flip(&mut attribute);
        }
        to_array(py, &attribute).map(Some)
    }

    /// The image corner with texture coordinates (0, 0): "bottom" left or "top" left; None if the
    /// format does not define it.
    #[getter]
    fn uv_origin(&self) -> Option<&'static str> {
        self.counts_down.map(|down| if down { "top" } else { "bottom" })
    }

    /// The vertex colours, as a copy of shape (n, 3) or (n, 4); None without colours.
    #[getter]
    fn colors<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        named(py, self.mesh(), COLOUR)
    }

    /// The stored strips of this part; None if it is drawn as a list or as fans. Strips joined by
    /// degenerate triangles are not split.
    #[getter]
    fn strips(&self) -> Option<Strips> {
        let stored = self.inner.stored.as_ref().filter(|stored| !stored.fans)?;
        Some(Strips::new(stored.runs.clone(), None, None))
    }

    fn __repr__(&self) -> String {
        let counted = tristrip_pipeline::text::counted;
        let name = self.inner.name.as_ref().map(|name| format!("'{}', ", name.escape_debug()));
        let vertices = counted(self.mesh().vertex_count(), "vertex");
        let faces = counted(self.mesh().faces().face_count(), "face");
        format!("Part({}{vertices}, {faces})", name.unwrap_or_default())
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let (py, this) = (slf.py(), slf.get());
        let state = PyDict::new(py);
        state.set_item("vertices", this.vertices(py)?)?;
        let faces = this.mesh().faces();
        state.set_item("offsets", faces.as_triangles().is_none().then(|| offsets(faces)))?;
        state.set_item("corners", PyArray1::from_slice(py, faces.corners()))?;
        state.set_item("attributes", this.attributes(py)?)?;
        state.set_item(
            "components",
            this.mesh().attributes().iter().map(|a| a.components).collect::<Vec<_>>(),
        )?;
        state.set_item("normalized", this.normalized())?;
        state.set_item("name", this.name())?;
        state.set_item("material", this.material())?;
        state.set_item("properties", this.material_properties(py)?)?;
        state.set_item("uv_origin", this.uv_origin())?;
        let stored = this.inner.stored.as_ref();
        state.set_item("runs", stored.map(|stored| Strips::new(stored.runs.clone(), None, None)))?;
        state.set_item("fans", stored.map(|stored| (stored.fans, stored.restarts)))?;
        state.set_item("stripped", this.inner.stripped)?;
        Ok((slf.get_type().getattr("_restore")?, PyTuple::new(py, [state])?))
    }

    #[classmethod]
    fn _restore(_: &Bound<'_, PyType>, state: &Bound<'_, PyDict>) -> PyResult<Self> {
        restored(state)
    }
}

/// Returns the start of each face, and the end of the last one.
fn offsets(faces: &Faces) -> Vec<i64> {
    let mut end: u32 = 0;
    let ends = faces.iter().map(|face| {
        // The corner count fits in 32 bits.
        end += face.len() as u32;
        i64::from(end)
    });
    std::iter::once(0).chain(ends).collect()
}

/// Returns the mesh with exactly these integer attributes marked as normalized.
fn with_normalized(mesh: &Mesh, names: &[String]) -> Result<Mesh, Failure> {
    let mut changed = Mesh::new(mesh.shared_positions(), mesh.faces().clone())?;
    for attribute in mesh.attributes() {
        let is_integer = !matches!(attribute.data, AttributeData::F32(_) | AttributeData::F64(_));
        let normalized = is_integer && names.contains(&attribute.name);
        changed = changed.with_attribute(Attribute { normalized, ..attribute.clone() })?;
    }
    if let Some(name) = names.iter().find(|name| mesh.attributes().iter().all(|a| a.name != **name)) {
        return Err(Failure::option("normalized", format!("{name:?}"), "attribute names"));
    }
    Ok(changed)
}

/// Replaces v by 1 − v.
fn flip(attribute: &mut Attribute) {
    fn each<T: Copy>(values: &mut [T], components: usize, flip: impl Fn(T) -> T) {
        values.iter_mut().skip(1).step_by(components).for_each(|x| *x = flip(*x));
    }
    let (components, is_normalized) = (usize::from(attribute.components), attribute.normalized);
    match &mut attribute.data {
        _ if components < 2 => (),
        AttributeData::F32(values) => each(values, components, |x| 1.0 - x),
        AttributeData::F64(values) => each(values, components, |x| 1.0 - x),
        AttributeData::U8(values) if is_normalized => each(values, components, |x| u8::MAX - x),
        AttributeData::U16(values) if is_normalized => each(values, components, |x| u16::MAX - x),
        _ => (),
    }
}

/// Builds a part from the state in a pickle.
fn restored(state: &Bound<'_, PyDict>) -> PyResult<Part> {
    let item = |key: &str| {
        let found = state.get_item(key)?;
        found.ok_or_else(|| PyErr::from(Failure::Parameter(format!("pickle: found no {key:?}"))))
    };
    let optional = |key: &str| PyResult::Ok(item(key)?).map(|value| (!value.is_none()).then_some(value));
    let points = item("vertices")?;
    let points = positions("vertices", &points)?;
    let points: Vec<[f32; 3]> = points.as_slice()?.as_chunks().0.to_vec();
    let corners = crate::arrays::indices_of("corners", &item("corners")?, false)?;
    let faces = match optional("offsets")? {
        None => Faces::from_triangles(corners),
        Some(offsets) => Faces::from_offsets(offsets.extract()?, corners),
    };
    let mut mesh = Mesh::new(points, faces.map_err(Failure::from)?).map_err(Failure::from)?;
    let components: Vec<u8> = item("components")?.extract()?;
    let normalized: Vec<String> = item("normalized")?.extract()?;
    let attributes = item("attributes")?.cast_into::<PyDict>()?;
    for ((name, array), components) in attributes.iter().zip(components) {
        let name: String = name.extract()?;
        let mut read = stored_attribute("attributes", &name, &array)?;
        (read.normalized, read.components) = (normalized.contains(&name), components);
        mesh = mesh.with_attribute(read).map_err(Failure::from)?;
    }
    let properties = optional("properties")?;
    let plain = NamedMaterial::of(properties.as_ref())?.plain;
    let name: Option<String> = item("name")?.extract()?;
    let material: Option<String> = item("material")?.extract()?;
    let stored = match (optional("runs")?, item("fans")?.extract::<Option<(bool, usize)>>()?) {
        (Some(runs), Some((fans, restarts))) => {
            let runs = (**runs.cast::<Strips>()?.get().inner()).clone();
            if runs.vertices().iter().any(|&vertex| vertex as usize >= mesh.vertex_count()) {
                return Err(Failure::Parameter(
                    "pickle: strips use vertices that the part does not have".into(),
                )
                .into());
            }
            Some(tristrip_io::StoredStrips { fans, runs, restarts })
        }
        _ => None,
    };
    let stripped = item("stripped")?.extract()?;
    let origin: Option<String> = item("uv_origin")?.extract()?;
    let inner = tristrip_io::Part { name: name.clone(), material: material.clone(), mesh, stripped, stored };
    let material = NamedMaterial { name: material, plain };
    Ok(Part { inner, material, counts_down: origin.map(|origin| origin == "top") })
}
