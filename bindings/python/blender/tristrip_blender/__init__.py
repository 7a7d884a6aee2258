"""Blender add-on: triangle strips as attributes, simplification, and GLB export with strips.

Install the folder as an add-on, or as an extension in Blender 4.2 or later. Also install the Python
package into Blender's Python; the panel "Tristrip" in the sidebar of the 3D view shows how.
"""

from __future__ import annotations

bl_info = {
    "name": "Triangle strips and levels of detail",
    "author": "The tristrip authors",
    "version": (0, 1, 0),
    "blender": (4, 2, 0),
    "location": "3D View > Sidebar > Tristrip; File > Export > GLB with triangle strips (.glb)",
    "description": "Triangle strips, levels of detail, and GLB files with strips",
    "category": "Mesh",
}


def register() -> None:
    """Register the operators, the panel and the menu entry."""
    from . import interface

    interface.register()


def unregister() -> None:
    """Unregister them."""
    from . import interface

    interface.unregister()
