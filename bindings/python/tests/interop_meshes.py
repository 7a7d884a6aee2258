"""Meshes for the tests of conversions, with faces of different sizes and all attributes."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]

#: Two triangles, two quads and a pentagon, in mixed order. One of the nine vertices is unused.
POLYGONS = [[0, 1, 2], [2, 3, 4, 5], [3, 1, 2], [4, 5, 6, 7, 0], [0, 3, 4, 5]]


def vertices() -> Array:
    return np.random.default_rng(1).random((9, 3)).astype(np.float32)


def attributes() -> dict[str, Any]:
    """Return the arguments with attributes, all with distinct values."""
    normals = vertices() - 0.5
    return {
        "normals": normals / np.linalg.norm(normals, axis=1)[:, None],
        "uv": np.arange(18, dtype=np.float32).reshape(9, 2) / 17,
        "colors": np.arange(36, dtype=np.uint8).reshape(9, 4) * 7,
        "attributes": {"heat": np.arange(9, dtype=np.float32), "ids": np.arange(18, dtype=np.int32).reshape(9, 2)},
    }


def expected_attributes() -> dict[str, Array]:
    given = attributes()
    return {"NORMAL": given["normals"], "TEXCOORD_0": given["uv"], "COLOR_0": given["colors"], **given["attributes"]}


def grid(rows: int) -> tuple[Array, Array]:
    """Return a grid of rows x rows squares as vertices and triangles."""
    x, y = np.meshgrid(np.arange(rows + 1), np.arange(rows + 1))
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]).astype(np.float32)
    corner = (np.arange(rows)[:, None] * (rows + 1) + np.arange(rows)).ravel()
    a, b, c, d = corner, corner + 1, corner + rows + 2, corner + rows + 1
    return points, np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])


def fans(polygons: list[list[int]]) -> list[list[int]]:
    return [[face[0], face[i], face[i + 1]] for face in polygons for i in range(1, len(face) - 1)]
