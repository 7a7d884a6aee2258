//! Incremental decoding of a progressive GLB: the classes `Decoder` and `StreamedPart`.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use tristrip::stream::{StreamLimits, StreamPart};
use tristrip_io::gltf::{ArrivalLimits, ArrivingGlb};
use tristrip_pipeline::text::{count, counted};

use crate::arrays::triangle_rows;
use crate::attributes;
use crate::errors::Failure;
use crate::input::bytes_of;
use crate::numbers::Count;
use crate::scene::class::Scene;
use crate::scene::data::SceneData;
use crate::strips::Strips;

/// Bytes decoded between two checks for signals.
const PIECE_BYTES: usize = 1 << 16;

/// State shared by a decoder and its parts.
type Shared = Arc<Mutex<ArrivingGlb>>;

fn lock(state: &Shared) -> MutexGuard<'_, ArrivingGlb> {
    state.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Incremental decoder for a progressive GLB, or for any GLB.
///
/// `update` accepts the bytes in pieces of any size. The part received so far can be drawn at any
/// time.
///
/// Several threads may use one decoder. `copy.copy` makes an independent copy.
///
/// Args:
///     strips: whether to maintain triangle strips during refinement, for `StreamedPart.strips`.
///         Decoding is then about five times slower.
///     max_bytes: the maximum number of bytes before the first chunk, or of a whole file without a
///         stream. All these bytes are kept in memory. The default is 2^30.
///     max_triangles: the maximum number of triangles of all meshes. The default, 2^26, is also the
///         upper limit. A stream is also limited to 2^18 triangles plus 32 per byte received.
///
/// >>> import numpy, tristrip
/// >>> x, y = numpy.meshgrid(numpy.arange(30), numpy.arange(30))
/// >>> lines = [f"v {a} {b} {a * b % 3}" for a, b in zip(x.ravel(), y.ravel())]
/// >>> lines += [f"f {i + 1} {i + 2} {i + 32} {i + 31}" for i in range(869) if i % 30 != 29]
/// >>> packed = tristrip.pack("\n".join(lines).encode(), format="obj")
/// >>> decoder = tristrip.Decoder()
/// >>> for start in range(0, len(packed.bytes), 1000):
/// ...     chunks = decoder.update(packed.bytes[start : start + 1000])
/// >>> decoder.is_complete, decoder.triangle_count, decoder.parts[0].faces.shape
/// (True, 1682, (1682, 3))
#[pyclass(frozen, module = "tristrip")]
#[derive(Debug)]
pub(crate) struct Decoder {
    state: Shared,
}

impl Decoder {
    /// Reads the state. Releases the GIL while it waits for other threads.
    fn with<T: Send>(&self, py: Python<'_>, look: impl FnOnce(&ArrivingGlb) -> T + Send) -> T {
        py.detach(|| look(&lock(&self.state)))
    }

    fn sum(&self, py: Python<'_>, of: fn(&StreamPart) -> usize) -> usize {
        self.with(py, |glb| glb.parts().map(|(_, part)| of(part)).sum())
    }
}

#[pymethods]
impl Decoder {
    #[new]
    #[pyo3(signature = (*, strips = false, max_bytes = None, max_triangles = None))]
    fn new(strips: bool, max_bytes: Option<Count>, max_triangles: Option<Count>) -> Self {
        let mut limits = ArrivalLimits::default();
        if let Some(Count(most)) = max_bytes {
            limits.kept_bytes = most as u64;
        }
        if let Some(Count(most)) = max_triangles {
            let triangles = most.min(StreamLimits::default().triangles);
            limits.stream = StreamLimits { triangles, ..limits.stream };
        }
        let glb = ArrivingGlb::new(limits);
        let glb = if strips { glb.keeping_strips() } else { glb };
        Self { state: Arc::new(Mutex::new(glb)) }
    }

    /// Decode the next bytes of the file.
    ///
    /// Complete chunks are decoded at once; an incomplete chunk is buffered.
    ///
    /// Args:
    ///     data: bytes, or an object with the buffer protocol such as a bytearray or memoryview.
    ///
    /// Returns:
    ///     The number of chunks decoded.
    ///
    /// Raises:
    ///     FormatError: the bytes are not a GLB, or a chunk is damaged. The part decoded before the
    ///         error remains; later bytes are rejected.
    ///     LimitError: the file exceeds the limits.
    ///     ArrayTypeError: the argument has no buffer of bytes.
    ///     KeyboardInterrupt: Ctrl-C was pressed; `offset` is the number of bytes decoded.
    ///
    /// >>> import tristrip
    /// >>> decoder = tristrip.Decoder()
    /// >>> decoder.update(b"PK")
    /// Traceback (most recent call last):
    /// tristrip.FormatError: byte 0: found "PK", expected `glTF` of a GLB
    fn update(&self, py: Python<'_>, data: &Bound<'_, PyAny>) -> PyResult<usize> {
        let Some(bytes) = bytes_of(data)? else {
            let found = data.get_type().name()?;
            return Err(Failure::Type(format!("data: found {found}, expected bytes")).into());
        };
        let bytes = bytes.as_bytes();
        if bytes.is_empty() {
            // Returns the error of an earlier call.
            return py.detach(|| lock(&self.state).update(&[])).map_err(|error| Failure::from(error).into());
        }
        let mut decoded = 0;
        for piece in bytes.chunks(PIECE_BYTES) {
            decoded += py.detach(|| lock(&self.state).update(piece)).map_err(Failure::from)?;
            py.check_signals()?;
        }
        Ok(decoded)
    }

    /// Check that the file is complete. Call this after the last bytes.
    ///
    /// Raises:
    ///     FormatError: the file is truncated or damaged.
    ///
    /// >>> import tristrip
    /// >>> tristrip.Decoder().finish()
    /// Traceback (most recent call last):
    /// tristrip.FormatError: file: found the end of the file after 0 bytes, expected the header and the JSON of a GLB
    fn finish(&self, py: Python<'_>) -> PyResult<()> {
        self.with(py, ArrivingGlb::finish).map_err(|error| Failure::from(error).into())
    }

    /// The number of bytes received so far. This is the file offset of the next byte, where an HTTP
    /// range request resumes.
    #[getter]
    fn offset(&self, py: Python<'_>) -> u64 {
        self.with(py, ArrivingGlb::offset)
    }

    /// Whether everything has arrived: all chunks, or all bytes of a file without a stream.
    #[getter]
    fn is_complete(&self, py: Python<'_>) -> bool {
        self.with(py, ArrivingGlb::is_complete)
    }

    /// Whether the base meshes and textures before the first chunk have arrived.
    #[getter]
    fn has_base(&self, py: Python<'_>) -> bool {
        self.with(py, ArrivingGlb::has_base)
    }

    /// The file offset of the first chunk. None before the JSON has arrived, and for a file without
    /// a stream.
    #[getter]
    fn chunk_start(&self, py: Python<'_>) -> Option<u64> {
        self.with(py, |glb| glb.chunk_range().map(|range| range.bytes().start))
    }

    /// The file offset after the last chunk. None before the JSON has arrived, and for a file
    /// without a stream.
    #[getter]
    fn chunk_end(&self, py: Python<'_>) -> Option<u64> {
        self.with(py, |glb| glb.chunk_range().map(|range| range.bytes().end))
    }

    /// The number of chunks decoded so far.
    #[getter]
    fn chunk_count(&self, py: Python<'_>) -> usize {
        self.with(py, |glb| glb.decoder().map_or(0, tristrip::stream::Decoder::chunk_count))
    }

    /// The meshes whose first chunk has arrived, ordered by index. Each object follows the decoder.
    #[getter]
    fn parts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let numbers: Vec<u32> = self.with(py, |glb| glb.parts().map(|(number, _)| number).collect());
        let part = |number| StreamedPart { state: Arc::clone(&self.state), number };
        let parts = numbers.into_iter().map(|number| Bound::new(py, part(number)));
        PyList::new(py, parts.collect::<PyResult<Vec<_>>>()?)
    }

    /// The current level: the number of collapses undone in all meshes.
    #[getter]
    fn level(&self, py: Python<'_>) -> usize {
        self.sum(py, StreamPart::level)
    }

    /// The level of the full meshes, counting the meshes whose first chunk has arrived.
    #[getter]
    fn full_level(&self, py: Python<'_>) -> usize {
        self.sum(py, StreamPart::full_level)
    }

    /// The current number of triangles of all meshes.
    #[getter]
    fn triangle_count(&self, py: Python<'_>) -> usize {
        self.sum(py, StreamPart::triangle_count)
    }

    /// The number of triangles of the full meshes, as declared by the stream. Counts the meshes
    /// whose first chunk has arrived.
    #[getter]
    fn full_triangle_count(&self, py: Python<'_>) -> usize {
        self.sum(py, StreamPart::full_triangle_count)
    }

    /// The maximum error over all meshes, each in its own units. None before the first chunk.
    #[getter]
    fn error(&self, py: Python<'_>) -> Option<f32> {
        self.with(py, |glb| glb.parts().map(|(_, part)| part.error()).reduce(f32::max))
    }

    /// Return the scene as received so far, with materials, textures and nodes.
    ///
    /// Meshes without decoded chunks are at their base meshes. The result is None before the base
    /// meshes have arrived.
    ///
    /// Raises:
    ///     FormatError: the glTF document is invalid.
    fn scene(&self, py: Python<'_>) -> PyResult<Option<Scene>> {
        let model = self.with(py, |glb| glb.model(None)).map_err(Failure::from)?;
        Ok(model.map(|model| Scene::new(SceneData::of_model(model))))
    }

    fn __copy__(&self, py: Python<'_>) -> Self {
        Self { state: Arc::new(Mutex::new(self.with(py, ArrivingGlb::clone))) }
    }

    fn __deepcopy__(&self, py: Python<'_>, _memo: &Bound<'_, PyAny>) -> Self {
        self.__copy__(py)
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let (found, full) = (self.triangle_count(py), self.full_triangle_count(py));
        let (offset, end) = (self.offset(py) as usize, self.chunk_end(py));
        let of = end.map(|end| format!(" of {}", count(end as usize))).unwrap_or_default();
        format!("Decoder({} of {}, {}{of} bytes)", count(found), counted(full, "triangle"), count(offset))
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("tristrip._notebook")?.call_method1("decoder_html", (slf,))
    }
}

/// A mesh of a `Decoder` as received so far. Its values change when a chunk is decoded.
#[pyclass(frozen, module = "tristrip")]
#[derive(Debug)]
pub(crate) struct StreamedPart {
    state: Shared,
    number: u32,
}

impl StreamedPart {
    /// Reads the mesh. A decoder never removes a mesh.
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        look: impl FnOnce(&StreamPart) -> T + Send,
    ) -> Result<T, Failure> {
        let found = py.detach(|| {
            let glb = lock(&self.state);
            let part = glb.decoder().and_then(|decoder| decoder.part(self.number as usize));
            part.map(look)
        });
        found.ok_or_else(|| Failure::Panic(format!("mesh {} of the stream is gone", self.number)))
    }
}

#[pymethods]
impl StreamedPart {
    /// The index of the mesh in the stream.
    #[getter]
    fn number(&self) -> u32 {
        self.number
    }

    /// The current level: the number of collapses undone.
    #[getter]
    fn level(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.with(py, StreamPart::level)?)
    }

    /// The level of the full mesh, as declared by the stream.
    #[getter]
    fn full_level(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.with(py, StreamPart::full_level)?)
    }

    /// The current number of triangles.
    #[getter]
    fn triangle_count(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.with(py, StreamPart::triangle_count)?)
    }

    /// The number of triangles of the full mesh, as declared by the stream.
    #[getter]
    fn full_triangle_count(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.with(py, StreamPart::full_triangle_count)?)
    }

    /// The current number of vertices.
    #[getter]
    fn vertex_count(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.with(py, StreamPart::vertex_count)?)
    }

    /// The number of vertices of the full mesh, as declared by the stream.
    #[getter]
    fn full_vertex_count(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.with(py, StreamPart::full_vertex_count)?)
    }

    /// The error of the current level in mesh units, including the rounding of positions.
    #[getter]
    fn error(&self, py: Python<'_>) -> PyResult<f32> {
        Ok(self.with(py, StreamPart::error)?)
    }

    /// The number of bits per coordinate received so far.
    #[getter]
    fn position_bits(&self, py: Python<'_>) -> PyResult<u32> {
        Ok(self.with(py, |part| part.position_bits()[0])?)
    }

    /// The current positions, in mesh space: float32 of shape (n, 3).
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let positions = self.with(py, StreamPart::positions)?;
        let rows = positions.len();
        PyArray1::from_vec(py, positions.into_flattened()).reshape([rows, 3])
    }

    /// The current triangles: uint32 of shape (m, 3).
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        triangle_rows(py, self.with(py, StreamPart::triangles)?)
    }

    /// The current attributes by name: "NORMAL", "TEXCOORD_0", … If the mesh combines several
    /// primitives, "part" has the primitive index of each vertex.
    #[getter]
    fn attributes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let mesh = self.with(py, StreamPart::mesh)?.map_err(Failure::from)?;
        attributes::all(py, &mesh)
    }

    /// Return strips that draw every current triangle exactly once, with its original winding.
    ///
    /// Raises:
    ///     ParameterError: the decoder was created without `strips=True`.
    fn strips(&self, py: Python<'_>) -> PyResult<Strips> {
        let strips = self.with(py, StreamPart::strips)?;
        let strips = strips.ok_or_else(|| Failure::option("strips", "False", "True in the decoder"))?;
        Ok(Strips::new(strips, None, None))
    }

    /// A checksum of the mesh so far. Decoders that agree have the same value after each chunk (see
    /// docs/formats/progressive-glb.md).
    #[getter]
    fn fingerprint(&self, py: Python<'_>) -> PyResult<u32> {
        Ok(self.with(py, StreamPart::fingerprint)?)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let (number, found, full) = (self.number, self.triangle_count(py)?, self.full_triangle_count(py)?);
        let (error, full) = (self.error(py)?, counted(full, "triangle"));
        Ok(format!("StreamedPart(mesh {number}, {} of {full}, error {error:.3e})", count(found)))
    }
}
