"""Conversions for PyVista (VTK), and plots of strips."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from tristrip._errors import ArrayTypeError, MeshError, ParameterError
from tristrip._native import Strips

from ._arrays import COLOUR, NORMAL, UV, Faces, Part, attributes_of, check_range, part_of, required, warn
from ._scenes import is_scene, placed_parts, scene_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from tristrip._native import Scene

_NORMALS = "Normals"
_COORDINATES = "Texture Coordinates"
#: The names that VTK readers use for colours.
_COLOUR_NAMES = (COLOUR, "RGBA", "RGB")


def to_pyvista(
    mesh: Any,
    faces: Any = None,
    *,
    normals: Any = None,
    uv: Any = None,
    colors: Any = None,
    attributes: Mapping[str, Any] | None = None,
) -> Any:
    """Convert a mesh, strips or a scene to PyVista.

    Args:
        mesh: a `Scene`, one of its parts, a `StrippedScene`, a `SimplifiedScene`, a `Simplified`, a
            pair of vertices and faces or strips, or vertices of shape (n, 3).
        faces: only with vertices: faces (see `stripify`), or `Strips`.
        normals: shape (n, 3), one per vertex.
        uv: texture coordinates of shape (n, 2), v up.
        colors: shape (n, 3) or (n, 4); floats from 0 to 1, uint8 or uint16.
        attributes: other per-vertex values by name, of shape (n,) or (n, k).

    Returns:
        A `pyvista.PolyData`, or for a `Scene` a `pyvista.MultiBlock` with one block per part,
        transformed by its nodes. Polygons are kept in order; `Strips` become `strips` cells.
        Normals and texture coordinates (v up) are active; other attributes are point data under
        their names. Materials are dropped.

    Raises:
        ImportError: PyVista is not installed.
        MeshError, ArrayTypeError: an array has invalid values, shape or type.

    >>> import tristrip
    >>> strips = tristrip.stripify([[0, 1, 2], [2, 1, 3]])
    >>> mesh = tristrip.to_pyvista([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], strips)
    >>> mesh.n_strips, mesh.strips.tolist()
    (1, [4, 3, 2, 1, 0])
    """
    pyvista = required("pyvista")
    if is_scene(mesh):
        blocks = pyvista.MultiBlock()
        for number, part in enumerate(placed_parts(mesh)):
            blocks.append(_poly_data(pyvista, part), part.name or f"part_{number}")
        return blocks
    return _poly_data(pyvista, part_of(mesh, faces, normals=normals, uv=uv, colors=colors, attributes=attributes))


def _poly_data(pyvista: Any, part: Part) -> Any:
    kept, points = part.faces, part.vertices
    # Copy, so that the meshes do not share memory.
    points = points.astype(np.float64 if points.dtype.itemsize == 8 else np.float32, copy=True)
    corners = kept.vertices if isinstance(kept, Strips) else kept.corners
    cells = pyvista.CellArray.from_arrays(kept.offsets, corners.astype(np.int64), deep=True)
    mesh = pyvista.PolyData(points, **{"strips" if isinstance(kept, Strips) else "faces": cells})
    for name, values in part.attributes.items():
        if name == NORMAL:
            mesh.point_data[_NORMALS] = values
            mesh.point_data.active_normals_name = _NORMALS
        elif name == UV:
            mesh.point_data[_COORDINATES] = values
            mesh.point_data.active_texture_coordinates_name = _COORDINATES
        else:
            mesh.point_data.set_array(values, name)
    return mesh


def from_pyvista(mesh: Any, *, name: str | None = None) -> Scene:
    """Convert a mesh of PyVista.

    Args:
        mesh: a `pyvista.PolyData`, a `pyvista.MultiBlock`, or another dataset, whose surface is
            extracted.
        name: the name of a single mesh.

    Returns:
        A `Scene` with one part per block. Polygons are kept in order. Strips become triangles after
        them; see also `strips_from_pyvista`. Active normals and texture coordinates, colours
        ("RGB", "RGBA" or "COLOR_0") and other point data are kept.

    Raises:
        ImportError: PyVista is not installed.
        ArrayTypeError: the argument is not a PyVista dataset.

    Warns:
        ConversionWarning: cell data, vertex or line cells, or non-numeric point data were dropped.
    """
    return scene_of(parts_of_pyvista(mesh, name=name))


def parts_of_pyvista(mesh: Any, *, name: str | None = None) -> list[Part]:
    """Read the arrays of each block."""
    pyvista = required("pyvista")
    if isinstance(mesh, pyvista.MultiBlock):
        blocks = [(key, block) for key, block in zip(mesh.keys(), mesh, strict=True) if block is not None]
        return [part for key, block in blocks for part in parts_of_pyvista(block, name=key)]
    if not isinstance(mesh, pyvista.DataSet):
        raise ArrayTypeError(f"mesh: found {type(mesh).__name__}, expected a PolyData, a MultiBlock or another dataset")
    if not isinstance(mesh, pyvista.PolyData):
        mesh = mesh.extract_surface(algorithm="dataset_surface", pass_pointid=False, pass_cellid=False)
    left_out = {"vertices": mesh.n_verts, "lines": mesh.n_lines}
    named = [f"{count} {what}" for what, count in left_out.items() if count]
    named += [f"cell data: {', '.join(mesh.cell_data.keys())}"] if len(mesh.cell_data) else []
    data = mesh.point_data
    names = dict.fromkeys(_COLOUR_NAMES, COLOUR) | {
        data.active_normals_name: NORMAL,
        data.active_texture_coordinates_name: UV,
    }
    attributes = attributes_of({key: data[key] for key in data}, names, named)
    if named:
        warn(f"dropped {'; '.join(named)}")
    polygons = _faces(mesh.GetPolys(), mesh.n_points, "faces")
    if mesh.n_strips:
        triangles = Faces.of("strips", strips_from_pyvista(mesh).triangles().astype(np.int64))
        polygons = Faces(
            np.concatenate([polygons.offsets, triangles.offsets[1:] + polygons.offsets[-1]]),
            np.concatenate([polygons.corners, triangles.corners]),
        )
    return [Part(np.asarray(mesh.points), polygons, attributes, name)]


def _faces(cells: Any, point_count: int, name: str) -> Faces:
    """Copy VTK cells."""
    pyvista = required("pyvista")
    arrays = [pyvista.convert_array(array) for array in (cells.GetOffsetsArray(), cells.GetConnectivityArray())]
    offsets, corners = (np.array(array, np.int64) for array in arrays)
    check_range(name, corners, point_count)
    return Faces(offsets if len(offsets) else np.zeros(1, np.int64), corners)


def strips_from_pyvista(mesh: Any) -> Strips:
    """Return the strips of a `pyvista.PolyData` made by `PolyData.strip` or `to_pyvista`.

    >>> import tristrip
    >>> strips = tristrip.stripify([[0, 1, 2], [2, 1, 3]])
    >>> mesh = tristrip.to_pyvista([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], strips)
    >>> [strip.tolist() for strip in tristrip.strips_from_pyvista(mesh)]
    [[3, 2, 1, 0]]
    """
    pyvista = required("pyvista")
    if not isinstance(mesh, pyvista.PolyData):
        raise ArrayTypeError(f"mesh: found {type(mesh).__name__}, expected a PolyData")
    cells = _faces(mesh.GetStrips(), mesh.n_points, "strips")
    restarts = np.insert(cells.corners, cells.offsets[1:-1], np.iinfo(np.uint32).max)
    return Strips.from_indices(restarts.astype(np.uint32), "restart")


def strip_colours(count: int) -> npt.NDArray[np.uint8]:
    """Return a colour per strip, shape (count, 3), clearly different for consecutive strips."""
    numbers = np.arange(count)
    hue = (numbers * 0.61803398875) % 1.0
    value = 0.65 + 0.35 * ((numbers * 0.7548776662) % 1.0)
    saturation = 0.45 + 0.4 * ((numbers * 0.5698402910) % 1.0)
    # The colour of a hue: three trapezoids, a third of the circle apart.
    wave = np.clip(np.abs((hue[:, None] * 6 + [0, 4, 2]) % 6 - 3) - 1, 0, 1)
    colours: npt.NDArray[np.uint8] = np.rint(255 * value[:, None] * (1 - saturation[:, None] * (1 - wave))).astype(
        np.uint8
    )
    return colours


def plot_strips(
    vertices: Any,
    strips: Strips,
    *,
    plotter: Any = None,
    off_screen: bool | None = None,
    window_size: tuple[int, int] = (1024, 768),
    **options: Any,
) -> Any:
    """Draw strips with PyVista, one colour per strip.

    Args:
        vertices: positions of shape (n, 3).
        strips: strips over these vertices.
        plotter: a `pyvista.Plotter` to draw into. By default a new one.
        off_screen: whether a new plotter renders without a window, for `screenshot`.
        window_size: the width and height of a new plotter, in pixels.
        **options: options of `pyvista.Plotter.add_mesh`, such as `show_edges=True`.

    Returns:
        The plotter. `show()` opens a window; `screenshot("strips.png")` writes an image.

    Raises:
        ImportError: PyVista is not installed.
        MeshError: a strip refers to a vertex that does not exist.
    """
    pyvista = required("pyvista")
    if not isinstance(strips, Strips):
        raise ArrayTypeError(f"strips: found {type(strips).__name__}, expected Strips")
    if plotter is not None and off_screen is not None:
        raise ParameterError("off_screen: cannot be used with plotter, which already has this setting")
    mesh = _poly_data(pyvista, part_of(vertices, strips))
    if mesh.n_strips == 0:
        raise MeshError("strips: found none, expected one or more to draw")
    mesh.cell_data["strip colour"] = strip_colours(mesh.n_strips)
    if plotter is None:
        plotter = pyvista.Plotter(off_screen=off_screen, window_size=list(window_size))
        plotter.background_color = "white"
    # Use flat shading: smooth normals would hide the borders of strips.
    shown = {"scalars": "strip colour", "rgb": True, "smooth_shading": False, **options}
    plotter.add_mesh(mesh, **shown)
    return plotter
