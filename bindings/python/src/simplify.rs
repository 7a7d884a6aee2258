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

/// A simplified mesh, over the vertices that it uses. It can be unpacked: `vertices, faces = simplified`.
#[pyclass(frozen, module = "tristrip")]
#[derive(Debug)]
pub(crate) struct Simplified {
    mesh: Mesh,
    sources: Vec<u32>,
    figures: Figures,
}

/// What was reached; a dictionary in a pickle.
#[derive(Debug, Clone, FromPyObject, IntoPyObject)]
#[pyo3(from_item_all)]
struct Figures {
    triangles_before: usize,
    surface_error: f32,
    /// The root mean square and the largest of the distances between the surfaces, if they were measured.
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

    /// The normals: float32 of shape (n, 3); None if none were given.
    #[getter]
    fn normals<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        named(py, &self.mesh, NORMAL)
    }

    /// The texture coordinates: float32 of shape (n, 2); None if none were given.
    #[getter]
    fn uv<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        named(py, &self.mesh, UV)
    }

    /// The colours, of the dtype and shape given; None if none were given.
    #[getter]
    fn colors<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        named(py, &self.mesh, COLOUR)
    }

    /// All attributes by their names: "NORMAL", "TEXCOORD_0", "COLOR_0" and those of `attributes`.
    #[getter]
    fn attributes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        all(py, &self.mesh)
    }

    /// The vertex of the input that each vertex is, or is a copy of with another normal or position: uint32 of shape (n,).
    #[getter]
    fn sources<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        PyArray1::from_slice(py, &self.sources)
    }

    /// The greatest error of a collapse, in the units of the positions.
    #[getter]
    fn surface_error(&self) -> f32 {
        self.figures.surface_error
    }

    /// The root mean square of the distances between the surfaces, in the units of the positions; None with `measure=False`.
    #[getter]
    fn rms_deviation(&self) -> Option<f64> {
        self.figures.deviations.map(|(rms, _)| rms)
    }

    /// The largest distance found between the surfaces, in the units of the positions; None with `measure=False`.
    #[getter]
    fn largest_deviation(&self) -> Option<f64> {
        self.figures.deviations.map(|(_, largest)| largest)
    }

    /// The length of the diagonal of the bounding box, of which the percentages of errors are.
    #[getter]
    fn diagonal(&self) -> f64 {
        self.figures.diagonal
    }

    /// A sentence on the goal, if it was not reached: what held it back, and what to try.
    #[getter]
    fn warning(&self) -> Option<&str> {
        self.figures.warning.as_deref()
    }

    /// Whether Ctrl-C ended it: before its goal, or before the fit or the measurement.
    #[getter]
    fn interrupted(&self) -> bool {
        self.figures.interrupted
    }

    /// Notes on what was dropped or is unusual.
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

/// Simplify a mesh by half-edge collapses, the cheapest first.
///
/// Args:
///     vertices: positions of shape (n, 3); they are computed with as 32-bit floats.
///     faces: as of `stripify`; polygons become triangles.
///     ratio: the ratio of triangles to keep, from 0 to 1.
///     triangles: the number of triangles to keep, instead of a ratio.
///     error: the maximum error, in the units of the positions; or of the diagonal of the bounding box, as "0.1%". By default 1 % of the
///         diagonal; "100%" allows any. Whichever goal is reached first ends the simplification.
///     normals: of shape (n, 3), one per vertex.
///     uv: texture coordinates of shape (n, 2).
///     colors: of shape (n, 3) or (n, 4): floats from 0 to 1, or uint8 or uint16.
///     attributes: other values per vertex, by name: arrays of shape (n,) or (n, k). Those that differ at one position make a seam, which stays closed.
///     weight: how much attributes count, as "normal=0.5,uv=2".
///     price: "distance", "planes" (a third of the time, larger distances) or "quadric" (as published in 1997).
///     permissive: whether holes may close, handles vanish, and seams move onto others.
///     lock_borders: whether vertices at borders stay.
///     weld_distance: how far the two sides of a border may be apart to collapse together; as `error`.
///     normals_mode: what happens to normals: "auto", "keep" or "rebuild", as the command's `--normals`.
///     fit: whether the remaining vertices are moved closer to the original surface. Those at borders stay. Without it, all vertices are
///         vertices of the input.
///     measure: whether the distances between the surfaces are measured, which takes as long again.
///     verify: whether the collapses are proven.
///     progress: as of `stripify`; the steps are the triangles removed.
///     on_interrupt: what Ctrl-C does: "raise" an `Interrupted` with the mesh simplified so far as `best`, or "return" it. Stages that have
///         not begun are left out: the fit and the measurement.
///
/// Returns:
///     The simplified mesh.
///
/// Raises:
///     MeshError: the arrays have wrong values or a wrong shape.
///     ArrayTypeError: an array has a type that cannot be used.
///     ParameterError: an option has a wrong value.
///
/// References:
///     Garland, Heckbert: Surface Simplification Using Quadric Error Metrics, 1997 (price "quadric"). The other prices are of this project.
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

/// Reads the goal of a simplification.
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

/// Reads a distance: a number in the units of the positions, or a text in percent of the diagonal.
pub(crate) fn deviation(name: &str, given: &Bound<'_, PyAny>) -> Result<Deviation, Failure> {
    if let Ok(text) = given.extract::<String>() {
        return text.parse().map_err(|why| Failure::Parameter(format!("{name}: {why}")));
    }
    match given.extract::<f64>() {
        Ok(units) if units.is_finite() && units >= 0.0 => Ok(Deviation::Units(units)),
        _ => Err(Failure::option(name, given, "a distance of 0 or more, or a text such as \"0.1%\"")),
    }
}
