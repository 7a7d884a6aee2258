//! Simplification of arrays: the function `simplify` and the class `Simplified`.

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple, PyType};
use tristrip::Mesh;
use tristrip_pipeline::simplify::{CollapseRules, Options};
use tristrip_pipeline::{Amount, Deviation, Goal, Ratio};

use crate::arrays::indices_of;
use crate::attributes::{COLOUR, GivenAttributes, NORMAL, UV, all, named, positions_of, triangles_of};
use crate::errors::Failure;
use crate::mesh::{mesh_of, one_part};
use crate::scene::part::Part;
use crate::work::Watching;

/// A simplified mesh, without unused vertices. It unpacks: `vertices, faces = simplified`.
#[pyclass(frozen, module = "tristrip")]
#[derive(Debug)]
pub(crate) struct Simplified {
    mesh: Mesh,
    sources: Vec<u32>,
    figures: Figures,
}

/// The metrics of a result; a dictionary in a pickle.
#[derive(Debug, Clone, FromPyObject, IntoPyObject)]
#[pyo3(from_item_all)]
struct Figures {
    triangles_before: usize,
    surface_error: f32,
    /// The root mean square and the maximum distance between the surfaces, if measured.
    deviations: Option<(f64, f64)>,
    diagonal: f64,
    warning: Option<String>,
    notes: Vec<String>,
    interrupted: bool,
}

#[pymethods]
impl Simplified {
    /// The positions: float32 of shape (n, 3).
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        positions_of(py, &self.mesh)
    }

    /// The triangles: uint32 of shape (m, 3).
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        triangles_of(py, &self.mesh)
    }

    /// The normals: float32 of shape (n, 3). None if none were passed.
    #[getter]
    fn normals<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        named(py, &self.mesh, NORMAL)
    }

    /// The texture coordinates: float32 of shape (n, 2). None if none were passed.
    #[getter]
    fn uv<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        named(py, &self.mesh, UV)
    }

    /// The colours, with the dtype and shape that were passed. None if none were passed.
    #[getter]
    fn colors<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        named(py, &self.mesh, COLOUR)
    }

    /// All attributes by name: "NORMAL", "TEXCOORD_0", "COLOR_0" and the names in `attributes`.
    #[getter]
    fn attributes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        all(py, &self.mesh)
    }

    /// The input vertex of each vertex: uint32 of shape (n,). A vertex can be a copy with a
    /// different normal or position.
    #[getter]
    fn sources<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        PyArray1::from_slice(py, &self.sources)
    }

    /// The maximum collapse error, in mesh units.
    #[getter]
    fn surface_error(&self) -> f32 {
        self.figures.surface_error
    }

    /// The root mean square distance between the surfaces, in mesh units. None with
    /// `measure=False`.
    #[getter]
    fn rms_deviation(&self) -> Option<f64> {
        self.figures.deviations.map(|(rms, _)| rms)
    }

    /// The maximum measured distance between the surfaces, in mesh units. None with
    /// `measure=False`.
    #[getter]
    fn largest_deviation(&self) -> Option<f64> {
        self.figures.deviations.map(|(_, largest)| largest)
    }

    /// The diagonal of the bounding box, in mesh units. Error percentages are relative to it.
    #[getter]
    fn diagonal(&self) -> f64 {
        self.figures.diagonal
    }

    /// A message if the target was missed: the reason and what to try. None if it was reached.
    #[getter]
    fn warning(&self) -> Option<&str> {
        self.figures.warning.as_deref()
    }

    /// Whether Ctrl-C stopped the simplification early, or before the fit or measurement.
    #[getter]
    fn interrupted(&self) -> bool {
        self.figures.interrupted
    }

    /// Notes on dropped or unusual data.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.figures.notes.clone()
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let both = PyTuple::new(py, [self.vertices(py)?.into_any(), self.faces(py)?.into_any()])?;
        Ok(both.as_any().try_iter()?.into_any())
    }

    fn __repr__(&self) -> String {
        let counted = tristrip_pipeline::text::counted;
        let (before, after) = (self.figures.triangles_before, self.mesh.faces().triangle_count());
        let (vertices, error) = (counted(self.mesh.vertex_count(), "vertex"), self.figures.surface_error);
        let before = tristrip_pipeline::text::count(before);
        format!(
            "Simplified({} of {before}, {vertices}, surface error {error:.3e})",
            counted(after, "triangle")
        )
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("tristrip._notebook")?.call_method1("simplified_html", (slf,))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let (py, this) = (slf.py(), slf.get());
        let state = (Part::of_mesh(this.mesh.clone()), this.sources(py), this.figures.clone());
        Ok((slf.get_type().getattr("_restore")?, state.into_pyobject(py)?))
    }

    #[classmethod]
    fn _restore(
        _: &Bound<'_, PyType>,
        part: &Bound<'_, Part>,
        sources: &Bound<'_, PyAny>,
        figures: Figures,
    ) -> PyResult<Self> {
        let mesh = part.get().inner.mesh.clone();
        let sources = indices_of("sources", sources, false)?;
        if sources.len() != mesh.vertex_count() {
            let (found, expected) = (sources.len(), mesh.vertex_count());
            return Err(Failure::Parameter(format!(
                "pickle: found {}, expected {expected}",
                tristrip::text::counted(found, "source")
            ))
            .into());
        }
        Ok(Self { mesh, sources, figures })
    }
}

/// Simplify a mesh by half-edge collapses.
///
/// The cheapest collapses come first. Simplification ends when the triangle target or the error
/// limit is reached.
///
/// Args:
///     vertices: positions of shape (n, 3). They are converted to 32-bit floats.
///     faces: see `stripify`. Polygons are triangulated.
///     ratio: the ratio of triangles to keep, from 0 to 1.
///     triangles: the number of triangles to keep, instead of a ratio.
///     error: the maximum error in mesh units, or in percent of the bounding-box diagonal, such as
///         "0.1%". The default is "1%"; "100%" disables the limit.
///     normals: shape (n, 3), one per vertex.
///     uv: texture coordinates of shape (n, 2).
///     colors: shape (n, 3) or (n, 4); floats from 0 to 1, uint8 or uint16.
///     attributes: other per-vertex values by name, of shape (n,) or (n, k). Different values at
///         one position form a seam, which stays closed.
///     weight: the weights of attributes, such as "normal=0.5,uv=2".
///     price: the cost function: "distance", "planes" (takes a third of the time, with larger
///         distances) or "quadric" (as published in 1997).
///     permissive: whether holes may close, handles may vanish and seams may merge.
///     lock_borders: whether to keep border vertices in place.
///     weld_distance: the maximum gap between two borders that collapse together; same units as
///         `error`.
///     normals_mode: the treatment of normals: "auto", "keep" or "rebuild"; see `tristrip simplify
///         --normals`.
///     fit: whether to move the remaining vertices closer to the original surface, except at
///         borders. Without it, every vertex keeps its input position.
///     measure: whether to measure the distance between the surfaces. This doubles the time.
///     verify: whether to verify the collapses.
///     progress: see `stripify`. The steps are triangles removed.
///     on_interrupt: the effect of Ctrl-C: "raise" raises `Interrupted` with the mesh so far as
///         `best`; "return" returns that mesh. Pending stages (fit, measurement) are skipped.
///
/// Returns:
///     The simplified mesh.
///
/// Raises:
///     MeshError: an array has invalid values or an invalid shape.
///     ArrayTypeError: an array has an unsupported type.
///     ParameterError: an option has an invalid value.
///
/// References:
///     Garland, Heckbert: Surface Simplification Using Quadric Error Metrics, 1997 (price
///         "quadric"). The other prices were developed for this project.
///
/// >>> import numpy, tristrip
/// >>> x, y = numpy.meshgrid(numpy.arange(20), numpy.arange(20))
/// >>> vertices = numpy.column_stack([x.ravel(), y.ravel(), numpy.zeros(400)])
/// >>> corner = (numpy.arange(19)[:, None] * 20 + numpy.arange(19)).ravel()
/// >>> faces = numpy.column_stack([corner, corner + 1, corner + 21, corner + 20])
/// >>> small = tristrip.simplify(vertices, faces, ratio=0.1)
/// >>> small.faces.shape, small.surface_error < 1e-5
/// ((72, 3), True)
#[pyfunction]
#[pyo3(signature = (
    vertices, faces, *, ratio = None, triangles = None, error = None, normals = None, uv = None, colors = None,
    attributes = None, weight = None, price = "distance", permissive = false, lock_borders = false,
    weld_distance = None, normals_mode = "auto", fit = false, measure = true, verify = true, progress = None,
    on_interrupt = "raise"
))]
#[allow(
    clippy::too_many_arguments,
    clippy::fn_params_excessive_bools,
    reason = "keyword arguments of Python"
)]
pub(crate) fn simplify<'py>(
    py: Python<'py>,
    vertices: &Bound<'py, PyAny>,
    faces: &Bound<'py, PyAny>,
    ratio: Option<f64>,
    triangles: Option<i64>,
    error: Option<&Bound<'py, PyAny>>,
    normals: Option<&Bound<'py, PyAny>>,
    uv: Option<&Bound<'py, PyAny>>,
    colors: Option<&Bound<'py, PyAny>>,
    attributes: Option<&Bound<'py, PyDict>>,
    weight: Option<&str>,
    price: &str,
    permissive: bool,
    lock_borders: bool,
    weld_distance: Option<&Bound<'py, PyAny>>,
    normals_mode: &str,
    fit: bool,
    measure: bool,
    verify: bool,
    progress: Option<Bound<'py, PyAny>>,
    on_interrupt: &str,
) -> PyResult<Bound<'py, Simplified>> {
    let goal = goal(ratio, triangles, error)?;
    let mut rules = CollapseRules { permissive, lock_borders, ..CollapseRules::default() };
    rules.price = price.parse().map_err(Failure::from)?;
    if let Some(weight) = weight {
        rules.weights = weight.parse().map_err(Failure::from)?;
    }
    if let Some(distance) = weld_distance {
        rules.weld_distance = deviation("weld_distance", distance)?;
    }
    let options = Options::default().with_goal(goal).with_rules(rules).with_verify(verify);
    let options = options
        .with_normals(normals_mode.parse().map_err(|why| Failure::Parameter(format!("normals_mode: {why}")))?)
        .with_fit(fit)
        .with_measure(measure);
    let watching = Watching::new(py, progress, None, on_interrupt)?.keeping_best();
    let given = GivenAttributes { normals, uv, colors, others: attributes };
    let model = one_part(given.add_to(mesh_of(vertices, faces)?)?);
    let ended = watching.run(py, move |watcher| {
        let done = tristrip_pipeline::simplify::run(&model, &options, watcher)?;
        let sources = done.source_vertices(0)?;
        let mesh = done.redrawn.model.parts.into_iter().next().map(|part| part.mesh).unwrap_or_default();
        let figures = Figures {
            triangles_before: done.collapses.triangles_before,
            surface_error: done.collapses.surface_error,
            deviations: done.deviations.map(|found| (found.change.rms, found.change.largest)),
            diagonal: done.collapses.diagonal,
            warning: done.warning,
            notes: done.notes,
            interrupted: done.interrupted,
        };
        Ok(Simplified { mesh, sources, figures })
    });
    ended?.object(py, |simplified| simplified)
}

/// Reads the target of a simplification.
pub(crate) fn goal(
    ratio: Option<f64>,
    triangles: Option<i64>,
    error: Option<&Bound<'_, PyAny>>,
) -> Result<Goal, Failure> {
    let amount = match (ratio, triangles) {
        (Some(_), Some(_)) => return Err(Failure::Parameter("ratio: cannot be used with triangles".into())),
        (Some(found), None) => {
            let ratio =
                Ratio::new(found).ok_or_else(|| Failure::option("ratio", found, "a number from 0 to 1"))?;
            Some(Amount::Ratio(ratio))
        }
        (None, Some(found)) => {
            let count =
                usize::try_from(found).map_err(|_| Failure::option("triangles", found, "0 or more"))?;
            Some(Amount::Triangles(count))
        }
        (None, None) => None,
    };
    let deviation = error.map(|error| deviation("error", error)).transpose()?.unwrap_or_default();
    Ok(Goal { amount, deviation })
}

/// Reads a distance: a number in mesh units, or a string in percent of the diagonal.
pub(crate) fn deviation(name: &str, given: &Bound<'_, PyAny>) -> Result<Deviation, Failure> {
    if let Ok(text) = given.extract::<String>() {
        return text.parse().map_err(|why| Failure::Parameter(format!("{name}: {why}")));
    }
    match given.extract::<f64>() {
        Ok(units) if units.is_finite() && units >= 0.0 => Ok(Deviation::Units(units)),
        _ => Err(Failure::option(name, given, "a distance of 0 or more, or a string such as \"0.1%\"")),
    }
}
