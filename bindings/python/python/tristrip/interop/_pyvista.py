"""Meshes of PyVista (VTK), and pictures of strips."""

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
#: The names under which VTK's readers store colours.
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
    """Convert a mesh, strips or a scene for PyVista.

    Args:
        mesh: a `Scene`, one of its parts, a `StrippedScene`, a `SimplifiedScene`, a `Simplified`, a pair of vertices
            and faces or strips, or vertices of shape (n, 3).
        faces: with vertices only: faces as of `stripify`, or `Strips`.
        normals: of shape (n, 3), one per vertex.
        uv: texture coordinates of shape (n, 2), v upwards.
        colors: of shape (n, 3) or (n, 4): floats from 0 to 1, or uint8 or uint16.
        attributes: other values per vertex, by name: arrays of shape (n,) or (n, k).

    Returns:
        A `pyvista.PolyData`. Polygons stay polygons, in their order; `Strips` become its `strips`, one cell each.
        Normals and texture coordinates are the active ones, other attributes point data under their names. Of a
        `Scene`, a `pyvista.MultiBlock` with a block per part, placed as its nodes place them; texture coordinates
        count upwards, as VTK's do. Materials are left out, as they are no part of such meshes.

    Raises:
        ImportError: PyVista is not installed.
        MeshError, ArrayTypeError: the arrays have wrong values or a wrong shape.

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
    # A copy, so that no change of the one mesh is one of the other.
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
        mesh: a `pyvista.PolyData`, another dataset, of which the surface is taken, or a `pyvista.MultiBlock`.
        name: the name of a single mesh.

    Returns:
        A `Scene` with a part per block. Polygons stay polygons, in their order; strips follow as triangles, see also
        `strips_from_pyvista`. Active normals and texture coordinates, colours ("RGB", "RGBA" or "COLOR_0") and other
        point data are kept.

    Raises:
        ImportError: PyVista is not installed.
        ArrayTypeError: the argument is no dataset of PyVista.

    Warns:
        ConversionWarning: data of cells, vertices, lines or point data that are no numbers are left out.
    """
    return scene_of(parts_of_pyvista(mesh, name=name))


def parts_of_pyvista(mesh: Any, *, name: str | None = None) -> list[Part]:
    """Take the arrays of each block."""
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
    named += [f"data of cells: {', '.join(mesh.cell_data.keys())}"] if len(mesh.cell_data) else []
    data = mesh.point_data
    names = dict.fromkeys(_COLOUR_NAMES, COLOUR) | {
        data.active_normals_name: NORMAL,
        data.active_texture_coordinates_name: UV,
    }
    attributes = attributes_of({key: data[key] for key in data}, names, named)
    if named:
        warn(f"left out {'; '.join(named)}")
    polygons = _faces(mesh.GetPolys(), mesh.n_points, "faces")
    if mesh.n_strips:
        triangles = Faces.of("strips", strips_from_pyvista(mesh).triangles().astype(np.int64))
        polygons = Faces(
            np.concatenate([polygons.offsets, triangles.offsets[1:] + polygons.offsets[-1]]),
            np.concatenate([polygons.corners, triangles.corners]),
        )
    return [Part(np.asarray(mesh.points), polygons, attributes, name)]


def _faces(cells: Any, point_count: int, name: str) -> Faces:
    """Copy the cells of VTK."""
    pyvista = required("pyvista")
    arrays = [pyvista.convert_array(array) for array in (cells.GetOffsetsArray(), cells.GetConnectivityArray())]
    offsets, corners = (np.array(array, np.int64) for array in arrays)
    check_range(name, corners, point_count)
    return Faces(offsets if len(offsets) else np.zeros(1, np.int64), corners)


def strips_from_pyvista(mesh: Any) -> Strips:
    """Take the strips of a `pyvista.PolyData`, as `pyvista.PolyData.strip` or `to_pyvista` makes them.

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
    """Return a colour per strip: shape (count, 3). Colours of consecutive strips differ clearly."""
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
    """Draw strips with PyVista, each in a colour of its own.

    Args:
        vertices: positions of shape (n, 3).
        strips: strips over these vertices.
        plotter: a `pyvista.Plotter` to draw into; by default a new one.
        off_screen: whether a new plotter draws without a window, for `screenshot`.
        window_size: width and height in pixels of a new plotter.
        **options: options of `pyvista.Plotter.add_mesh`, such as `show_edges=True`.

    Returns:
        The plotter, of which `show()` opens a window and `screenshot("strips.png")` writes a picture.

    Raises:
        ImportError: PyVista is not installed.
        MeshError: a strip has a vertex that does not exist.
    """
    pyvista = required("pyvista")
    if not isinstance(strips, Strips):
        raise ArrayTypeError(f"strips: found {type(strips).__name__}, expected Strips")
    if plotter is not None and off_screen is not None:
        raise ParameterError("off_screen: cannot be used with plotter, which has it already")
    mesh = _poly_data(pyvista, part_of(vertices, strips))
    if mesh.n_strips == 0:
        raise MeshError("strips: found none, expected one or more to draw")
    mesh.cell_data["strip colour"] = strip_colours(mesh.n_strips)
    if plotter is None:
        plotter = pyvista.Plotter(off_screen=off_screen, window_size=list(window_size))
        plotter.background_color = "white"
    # A strip is drawn flat: its vertices have no normals, and those of a smooth surface would hide where strips meet.
    shown = {"scalars": "strip colour", "rgb": True, "smooth_shading": False, **options}
    plotter.add_mesh(mesh, **shown)
    return plotter
