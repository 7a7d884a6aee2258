//! Conversion of vertex attributes to and from arrays. Each attribute type has its own dtype.

use numpy::{Element, PyArray1, PyArray2, PyArrayDescrMethods, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use tristrip::text::counted;
use tristrip::{Attribute, AttributeData, Mesh};

use crate::arrays::{as_array, shape_text};
use crate::errors::Failure;

/// glTF attribute names; all formats use them.
pub(crate) const NORMAL: &str = "NORMAL";
pub(crate) const UV: &str = "TEXCOORD_0";
pub(crate) const COLOUR: &str = "COLOR_0";

/// Attributes passed by the user: those with their own arguments, and others by name.
#[derive(Default)]
pub(crate) struct GivenAttributes<'a, 'py> {
    pub(crate) normals: Option<&'a Bound<'py, PyAny>>,
    pub(crate) uv: Option<&'a Bound<'py, PyAny>>,
    pub(crate) colors: Option<&'a Bound<'py, PyAny>>,
    pub(crate) others: Option<&'a Bound<'py, PyDict>>,
}

impl GivenAttributes<'_, '_> {
    /// Adds the attributes to a mesh.
    pub(crate) fn add_to(&self, mut mesh: Mesh) -> Result<Mesh, Failure> {
        let named = [
            ("normals", NORMAL, self.normals, 3..=3),
            ("uv", UV, self.uv, 2..=2),
            ("colors", COLOUR, self.colors, 3..=4),
        ];
        for (argument, name, given, components) in named {
            let Some(given) = given else { continue };
            let attribute = attribute(argument, name, given)?;
            if !components.contains(&attribute.components) {
                let found = counted(attribute.components, "column");
                let expected = match name {
                    NORMAL => "3",
                    UV => "2",
                    _ => "3 or 4",
                };
                return Err(Failure::mesh(argument, found, expected));
            }
            mesh = with(mesh, argument, attribute)?;
        }
        for (name, given) in self.others.into_iter().flat_map(PyDictMethods::iter) {
            let name: String =
                name.extract().map_err(|_| Failure::option("attributes", name, "strings as names"))?;
            let argument = format!("attributes[{name:?}]");
            if mesh.attributes().iter().any(|known| known.name == name) || name == "POSITION" {
                return Err(Failure::Parameter(format!("{argument}: given twice")));
            }
            mesh = with(mesh, &argument, attribute(&argument, &name, &given)?)?;
        }
        Ok(mesh)
    }
}

fn with(mesh: Mesh, argument: &str, attribute: Attribute) -> Result<Mesh, Failure> {
    let (found, expected) =
        (attribute.data.len() / usize::from(attribute.components.max(1)), mesh.vertex_count());
    if found != expected {
        return Err(Failure::Mesh(format!(
            "{argument}: found {}, expected {expected}, one per vertex",
            counted(found, "row")
        )));
    }
    Ok(mesh.with_attribute(attribute)?)
}

/// Prefixes of glTF attribute names. These attributes are 32-bit floats or normalized integers.
const OF_GLTF: [&str; 5] = [NORMAL, "TANGENT", "TEXCOORD_", "COLOR_", "WEIGHTS_"];

/// Reads an attribute: an array of shape (n,) or (n, k). 8- and 16-bit integers of a glTF
/// attribute, such as colours, are normalized.
fn attribute(argument: &str, name: &str, given: &Bound<'_, PyAny>) -> Result<Attribute, Failure> {
    let array = as_array(argument, given)?;
    // Lists of Python integers have 64 bits; these are not normalized.
    let is_whole = matches!(array.dtype().kind(), b'i' | b'u') && array.dtype().itemsize() == 8;
    let is_float = [NORMAL, "TANGENT", "TEXCOORD_"].iter().any(|start| name.starts_with(start));
    let floats = (is_whole && is_float).then(|| array.call_method1("astype", ("float32",))).transpose()?;
    let mut attribute = stored_attribute(argument, name, floats.as_ref().unwrap_or(given))?;
    if OF_GLTF.iter().any(|start| name.starts_with(start)) {
        attribute.normalized = !matches!(attribute.data, AttributeData::F32(_) | AttributeData::F64(_));
        if let AttributeData::F64(wide) = &attribute.data {
            attribute.data = AttributeData::F32(wide.iter().map(|&x| x as f32).collect());
        }
    }
    check_finite(argument, &attribute.data, attribute.components.into())?;
    Ok(attribute)
}

/// Reads an attribute with its dtype; integers are not normalized.
pub(crate) fn stored_attribute(
    argument: &str,
    name: &str,
    given: &Bound<'_, PyAny>,
) -> Result<Attribute, Failure> {
    let array = as_array(argument, given)?;
    let columns = match array.shape() {
        [_] => 1,
        [_, columns] => *columns,
        shape => return Err(Failure::mesh(argument, shape_text(shape), "shape (n,) or (n, k)")),
    };
    let components = u8::try_from(columns)
        .ok()
        .filter(|&columns| columns > 0)
        .ok_or_else(|| Failure::mesh(argument, format!("{columns} columns"), "1 to 255"))?;
    let (kind, size) = (array.dtype().kind(), array.dtype().itemsize());
    let data = match (kind, size) {
        (b'f', 2 | 4) => AttributeData::F32(values(&array, "float32")?),
        (b'f', 8) => AttributeData::F64(values(&array, "float64")?),
        (b'u', 1) => AttributeData::U8(values(&array, "uint8")?),
        (b'i', 1) => AttributeData::I8(values(&array, "int8")?),
        (b'u', 2) => AttributeData::U16(values(&array, "uint16")?),
        (b'i', 2) => AttributeData::I16(values(&array, "int16")?),
        (b'u', 4) => AttributeData::U32(values(&array, "uint32")?),
        (b'i', 4) => AttributeData::I32(values(&array, "int32")?),
        _ => {
            let found = array.getattr("dtype")?;
            let expected = "16-, 32- or 64-bit floats, or 8-, 16- or 32-bit integers";
            return Err(Failure::Type(format!("{argument}: found dtype {found}, expected {expected}")));
        }
    };
    Ok(Attribute { name: name.into(), components, normalized: false, data })
}

fn check_finite(argument: &str, data: &AttributeData, columns: usize) -> Result<(), Failure> {
    let wrong = match data {
        AttributeData::F32(values) => values.iter().position(|x| !x.is_finite()),
        AttributeData::F64(values) => values.iter().position(|x| !x.is_finite()),
        _ => None,
    };
    match wrong {
        Some(at) => {
            let found = format!("a non-finite number at vertex {}, column {}", at / columns, at % columns);
            Err(Failure::mesh(argument, found, "finite numbers"))
        }
        None => Ok(()),
    }
}

/// Copies the values of an array in row order.
fn values<T: Element + Copy>(array: &Bound<'_, PyAny>, dtype: &str) -> Result<Vec<T>, Failure> {
    let flat = array.call_method1("astype", (dtype,))?.call_method1("reshape", (-1,))?;
    let flat = flat
        .cast_into::<PyArray1<T>>()
        .map_err(|_| Failure::Type(format!("expected an array of {dtype}")))?;
    Ok(flat.to_vec().map_err(PyErr::from)?)
}

/// Returns the values of an attribute with shape (n, k), or (n,) for one component.
pub(crate) fn to_array<'py>(py: Python<'py>, attribute: &Attribute) -> PyResult<Bound<'py, PyAny>> {
    fn rows<'py, T: Element + Copy>(
        py: Python<'py>,
        values: &[T],
        columns: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let flat = PyArray1::from_slice(py, values);
        if columns == 1 {
            return Ok(flat.into_any());
        }
        Ok(flat.reshape([values.len() / columns, columns])?.into_any())
    }
    let columns = usize::from(attribute.components.max(1));
    match &attribute.data {
        AttributeData::F32(values) => rows(py, values, columns),
        AttributeData::F64(values) => rows(py, values, columns),
        AttributeData::U8(values) => rows(py, values, columns),
        AttributeData::I8(values) => rows(py, values, columns),
        AttributeData::U16(values) => rows(py, values, columns),
        AttributeData::I16(values) => rows(py, values, columns),
        AttributeData::U32(values) => rows(py, values, columns),
        AttributeData::I32(values) => rows(py, values, columns),
    }
}

/// Returns the attribute with a name, or `None`.
pub(crate) fn named<'py>(py: Python<'py>, mesh: &Mesh, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
    mesh.attributes()
        .iter()
        .find(|attribute| attribute.name == name)
        .map(|found| to_array(py, found))
        .transpose()
}

/// Returns all attributes of a mesh by name.
pub(crate) fn all<'py>(py: Python<'py>, mesh: &Mesh) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    for attribute in mesh.attributes() {
        all.set_item(PyString::new(py, &attribute.name), to_array(py, attribute)?)?;
    }
    Ok(all)
}

/// Returns the positions of a mesh as a float32 array of shape (n, 3).
pub(crate) fn positions_of<'py>(py: Python<'py>, mesh: &Mesh) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let rows = mesh.vertex_count();
    PyArray1::from_slice(py, mesh.positions().as_flattened()).reshape([rows, 3])
}

/// Returns the triangles of a mesh as a uint32 array of shape (n, 3). Polygons are split into fans.
pub(crate) fn triangles_of<'py>(py: Python<'py>, mesh: &Mesh) -> PyResult<Bound<'py, PyArray2<u32>>> {
    let corners = mesh.faces().fans();
    let rows = corners.len() / 3;
    PyArray1::from_slice(py, &corners).reshape([rows, 3])
}
