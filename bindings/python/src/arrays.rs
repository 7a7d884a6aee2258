//! Conversion of arguments to meshes: faces of any integer dtype and shape, positions and
//! attributes.
//!
//! A C-contiguous `uint32` array is borrowed; every other array is converted once. Values are
//! checked before the conversion, because a negative or large index would wrap around to another
//! vertex.

use numpy::{
    PyArray1, PyArray2, PyArrayDescrMethods, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};
use tristrip::text::counted;
use tristrip::{Faces, Layout, MAX_COUNT, Strips};

use crate::errors::Failure;

/// The maximum length of an array that repeats items (stride 0).
const MAX_REPEATED: usize = 1 << 20;

/// Faces passed by the user.
pub(crate) enum GivenFaces<'py> {
    /// Three corners per face.
    Triangles(PyReadonlyArray1<'py, u32>),
    /// Faces of any size.
    Polygons(Faces),
}

impl<'py> GivenFaces<'py> {
    /// Reads faces: an array of shape (n, 3), an array of shape (n, k) for polygons with k corners,
    /// a flat array with three indices per triangle, or a sequence of sequences for polygons of
    /// different sizes.
    pub(crate) fn of(name: &str, given: &Bound<'py, PyAny>) -> Result<Self, Failure> {
        if is_ragged(given)? {
            return Ok(Self::Polygons(polygons(name, given)?));
        }
        let array = as_array(name, given)?;
        let shape = array.shape().to_vec();
        let corners = match shape[..] {
            [_] | [0, _] => 3,
            [_, corners] if corners >= 3 => corners,
            _ => {
                return Err(Failure::mesh(
                    name,
                    shape_text(&shape),
                    "shape (n, 3), (n, k) with k ≥ 3, or (3 n,)",
                ));
            }
        };
        if shape.len() == 1 && shape[0] % 3 != 0 {
            let found = counted(shape[0], "index");
            return Err(Failure::mesh(name, found, "three per triangle"));
        }
        let flat = indices(name, &array)?;
        if corners == 3 {
            return Ok(Self::Triangles(flat));
        }
        let slice = flat
            .as_slice()
            .map_err(|_| Failure::Type(format!("{name}: found an array that is not contiguous")))?;
        Ok(Self::Polygons(Faces::from_polygons(slice.chunks_exact(corners))?))
    }

    /// Copies the faces.
    pub(crate) fn to_faces(&self) -> Result<Faces, Failure> {
        match self {
            Self::Triangles(_) => Ok(Faces::from_triangles(self.corners().to_vec())?),
            Self::Polygons(faces) => Ok(faces.clone()),
        }
    }

    /// Returns the corners of all faces.
    pub(crate) fn corners(&self) -> &[u32] {
        match self {
            Self::Triangles(array) => array.as_slice().unwrap_or_default(),
            Self::Polygons(faces) => faces.corners(),
        }
    }
}

/// Checks whether an argument is a list or tuple of sequences of different lengths.
fn is_ragged(given: &Bound<'_, PyAny>) -> PyResult<bool> {
    if !given.is_instance_of::<PyList>() && !given.is_instance_of::<PyTuple>() {
        return Ok(false);
    }
    let mut size = None;
    for face in given.try_iter()? {
        let Ok(len) = face?.len() else { return Ok(false) };
        if *size.get_or_insert(len) != len {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Reads polygons of different sizes.
fn polygons(name: &str, given: &Bound<'_, PyAny>) -> Result<Faces, Failure> {
    let (mut offsets, mut corners) = (vec![0], Vec::new());
    for (number, face) in given.try_iter()?.enumerate() {
        let name = format!("{name}[{number}]");
        let array = as_array(&name, &face?)?;
        if array.ndim() != 1 {
            return Err(Failure::mesh(&name, shape_text(array.shape()), "the indices of one face"));
        }
        let face = indices(&name, &array)?;
        corners.extend_from_slice(face.as_slice().unwrap_or_default());
        let end = corners.len();
        if end > MAX_COUNT {
            return Err(Failure::mesh(&name, format!("{end} corners up to here"), "at most 2^32 − 2"));
        }
        offsets.push(end as u32);
    }
    Ok(Faces::from_offsets(offsets, corners)?)
}

/// Converts an argument to an array of any dtype. Rejects arrays with masked values: the conversion
/// would expose them.
pub(crate) fn as_array<'py>(
    name: &str,
    given: &Bound<'py, PyAny>,
) -> Result<Bound<'py, PyUntypedArray>, Failure> {
    let py = given.py();
    let numpy = py.import("numpy")?;
    let masked = numpy.getattr("ma")?;
    if given.is_instance(&masked.getattr("MaskedArray")?)?
        && masked.call_method1("is_masked", (given,))?.extract()?
    {
        return Err(Failure::mesh(name, "masked values", "an array without masked values"));
    }
    let array = numpy.call_method1("asarray", (given,)).map_err(|error| {
        if error.is_instance_of::<pyo3::exceptions::PyValueError>(py)
            || error.is_instance_of::<pyo3::exceptions::PyTypeError>(py)
        {
            Failure::Type(format!(
                "{name}: found {}, expected an array: {}",
                type_name(given),
                error.value(py)
            ))
        } else {
            error.into()
        }
    })?;
    let array = array.cast_into::<PyUntypedArray>();
    let array = array.map_err(|_| Failure::Type(format!("{name}: expected an array")))?;
    // NumPy wraps an unknown object in a 0-dimensional object array.
    if array.ndim() == 0 && !given.is_instance_of::<PyUntypedArray>() {
        return Err(Failure::Type(format!("{name}: found {}, expected an array", type_name(given))));
    }
    check_memory(name, &array)?;
    Ok(array)
}

/// Rejects a large view with repeated items (stride 0), because a copy would allocate its full
/// size.
fn check_memory(name: &str, array: &Bound<'_, PyUntypedArray>) -> Result<(), Failure> {
    let repeats = array.shape().iter().zip(array.strides()).any(|(&size, &stride)| size > 1 && stride == 0);
    if repeats && array.len() > MAX_REPEATED {
        let found = format!("a view that repeats items, of {} items", array.len());
        return Err(Failure::mesh(name, found, "an array with memory for each item"));
    }
    Ok(())
}

pub(crate) fn type_name(given: &Bound<'_, PyAny>) -> String {
    given.get_type().name().map_or_else(|_| "an object".into(), |name| name.to_string())
}

/// Returns the indices as one contiguous `uint32` array, without a copy where possible.
fn indices<'py>(
    name: &str,
    array: &Bound<'py, PyUntypedArray>,
) -> Result<PyReadonlyArray1<'py, u32>, Failure> {
    indices_up_to(name, array, MAX_COUNT as u64 - 1)
}

fn indices_up_to<'py>(
    name: &str,
    array: &Bound<'py, PyUntypedArray>,
    limit: u64,
) -> Result<PyReadonlyArray1<'py, u32>, Failure> {
    let py = array.py();
    let dtype = array.dtype();
    let (kind, size) = (dtype.kind(), array.len());
    if size == 0 {
        return Ok(PyArray1::<u32>::from_vec(py, Vec::new()).readonly());
    }
    if !matches!(kind, b'i' | b'u') {
        let found = array.getattr("dtype")?;
        return Err(Failure::Type(format!("{name}: found dtype {found}, expected an integer dtype")));
    }
    if size > MAX_COUNT {
        return Err(Failure::mesh(name, format!("{size} indices"), "at most 2^32 − 2"));
    }
    let is_wide = kind == b'i' || dtype.itemsize() > 4;
    if is_wide {
        let lowest = array.call_method0("min")?;
        if lowest.lt(0)? {
            return Err(Failure::mesh(
                name,
                format!("index {lowest}{}", first_at(array, &lowest)?),
                "0 or more",
            ));
        }
        let highest = array.call_method0("max")?;
        if highest.gt(limit)? {
            let expected = "a 32-bit index";
            return Err(Failure::mesh(
                name,
                format!("index {highest}{}", first_at(array, &highest)?),
                expected,
            ));
        }
    }
    let flat = contiguous(array.as_any(), "uint32")?.call_method1("reshape", (-1,))?;
    let flat =
        flat.cast_into::<PyArray1<u32>>().map_err(|_| Failure::Type(format!("{name}: expected indices")))?;
    let flat = flat.try_readonly().map_err(PyErr::from)?;
    flat.as_slice().map_err(PyErr::from)?;
    Ok(flat)
}

/// Returns an array whose items form a slice. Copies only if the dtype, byte order, layout or
/// alignment requires it.
fn contiguous<'py>(array: &Bound<'py, PyAny>, dtype: &str) -> PyResult<Bound<'py, PyAny>> {
    array.py().import("numpy")?.call_method1("require", (array, dtype, ["C_CONTIGUOUS", "ALIGNED"]))
}

/// Reads an index buffer. With restarts, the maximum of its dtype becomes the `u32` restart value.
pub(crate) fn indices_of(
    name: &str,
    given: &Bound<'_, PyAny>,
    has_restarts: bool,
) -> Result<Vec<u32>, Failure> {
    let array = as_array(name, given)?;
    if array.ndim() != 1 {
        return Err(Failure::mesh(name, shape_text(array.shape()), "shape (n,)"));
    }
    let restart = match (array.dtype().kind(), array.dtype().itemsize()) {
        (b'u', 1) => u32::from(u8::MAX),
        (b'u', 2) => u32::from(u16::MAX),
        _ => u32::MAX,
    };
    let limit = if has_restarts { u64::from(u32::MAX) } else { MAX_COUNT as u64 - 1 };
    let flat = indices_up_to(name, &array, limit)?;
    let widen = |&index: &u32| if has_restarts && index == restart { u32::MAX } else { index };
    Ok(flat.as_slice().unwrap_or_default().iter().map(widen).collect())
}

/// Returns the position of a value as text for an error.
fn first_at(array: &Bound<'_, PyUntypedArray>, value: &Bound<'_, PyAny>) -> PyResult<String> {
    let numpy = array.py().import("numpy")?;
    let place = numpy.call_method1("equal", (array, value))?.call_method0("argmax")?;
    let place: usize = place.extract()?;
    Ok(match array.shape() {
        [_, columns] if *columns > 0 => format!(" at face {}, corner {}", place / columns, place % columns),
        _ => format!(" at {place}"),
    })
}

pub(crate) fn shape_text(shape: &[usize]) -> String {
    let sizes: Vec<String> = shape.iter().map(ToString::to_string).collect();
    match sizes.len() {
        1 => format!("shape ({},)", sizes[0]),
        _ => format!("shape ({})", sizes.join(", ")),
    }
}

/// Reads positions, an array of shape (n, 3) of any number dtype, as finite 32-bit floats.
pub(crate) fn positions<'py>(
    name: &str,
    given: &Bound<'py, PyAny>,
) -> Result<PyReadonlyArray2<'py, f32>, Failure> {
    let floats = floats(name, given)?;
    let shape = floats.shape().to_vec();
    if shape[1] != 3 {
        return Err(Failure::mesh(name, shape_text(&shape), "shape (n, 3)"));
    }
    if let Some(at) = floats.as_slice().unwrap_or_default().iter().position(|x| !x.is_finite()) {
        let given = as_array(name, given)?.get_item((at / 3, at % 3))?;
        let found = format!("{given} at vertex {}, coordinate {}", at / 3, at % 3);
        return Err(Failure::mesh(name, found, "a finite 32-bit float"));
    }
    Ok(floats)
}

/// Reads a two-dimensional array as contiguous 32-bit floats.
pub(crate) fn floats<'py>(
    name: &str,
    given: &Bound<'py, PyAny>,
) -> Result<PyReadonlyArray2<'py, f32>, Failure> {
    let array = as_array(name, given)?;
    let py = array.py();
    if !matches!(array.dtype().kind(), b'f' | b'i' | b'u') {
        let found = array.getattr("dtype")?;
        return Err(Failure::Type(format!("{name}: found dtype {found}, expected numbers")));
    }
    let array = if array.ndim() == 1 && array.len() == 0 {
        array.call_method1("reshape", (0, 3))?
    } else {
        array.into_any()
    };
    let array = array
        .cast_into::<PyUntypedArray>()
        .map_err(|_| Failure::Type(format!("{name}: expected an array")))?;
    if array.ndim() != 2 {
        return Err(Failure::mesh(name, shape_text(array.shape()), "two dimensions"));
    }
    if array.shape()[0] > MAX_COUNT {
        return Err(Failure::mesh(name, format!("{} rows", array.shape()[0]), "at most 2^32 − 2"));
    }
    let numpy = py.import("numpy")?;
    // Values beyond the 32-bit range become infinite. That is an error below and needs no warning.
    let ignoring = PyDict::new(py);
    ignoring.set_item("all", "ignore")?;
    let state = numpy.call_method("errstate", (), Some(&ignoring))?;
    state.call_method0("__enter__")?;
    let converted = contiguous(&array, "float32");
    state.call_method1("__exit__", (py.None(), py.None(), py.None()))?;
    let converted = converted?.cast_into::<PyArray2<f32>>();
    let converted = converted.map_err(|_| Failure::Type(format!("{name}: expected numbers")))?;
    let converted = converted.try_readonly().map_err(PyErr::from)?;
    converted.as_slice().map_err(PyErr::from)?;
    Ok(converted)
}

/// Returns the index buffer of strips with 8-, 16- or 32-bit indices.
pub(crate) fn indices_to_array<'py>(
    py: Python<'py>,
    strips: &Strips,
    layout: Layout,
    bits: u8,
) -> Result<Bound<'py, PyAny>, Failure> {
    Ok(match bits {
        8 => PyArray1::from_vec(py, py.detach(|| strips.to_indices::<u8>(layout))?).into_any(),
        16 => PyArray1::from_vec(py, py.detach(|| strips.to_indices::<u16>(layout))?).into_any(),
        _ => PyArray1::from_vec(py, py.detach(|| strips.to_indices::<u32>(layout))?).into_any(),
    })
}

/// Returns triangles, three vertices each, as an array of shape (n, 3).
pub(crate) fn triangle_rows(py: Python<'_>, triangles: Vec<u32>) -> PyResult<Bound<'_, PyArray2<u32>>> {
    let rows = triangles.len() / 3;
    PyArray1::from_vec(py, triangles).reshape([rows, 3])
}
