"""Blender add-on of tristrip: triangle strips as attributes, simplification by levels, and GLB files with strips.

Install the folder as an add-on, or as an extension of Blender 4.2 and newer; and the wheel of tristrip into Blender's
Python, as the panel "Tristrip" in the sidebar of the 3D view says.
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
    """Add the operators, the panel and the entry of the menu to Blender."""
    from . import interface

    interface.register()


def unregister() -> None:
    """Remove them."""
    from . import interface

    interface.unregister()
