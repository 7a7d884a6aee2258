"""The operators, the panel and the menu entry. The other modules of the add-on do the work."""

# Blender requires these class and method names, and shows docstrings without a period.
# ruff: noqa: ARG001, ARG002, BLE001, D102, D415, N801, RUF012

import tempfile
from pathlib import Path
from typing import Any

import bpy
from bpy_extras.io_utils import ExportHelper

from . import levels, mesh_data, strips, wheel


def _active_mesh(context: Any) -> Any:
    active = context.active_object
    return active.data if active is not None and active.type == "MESH" else None


def _can_change(cls: Any, context: Any) -> bool:
    if _active_mesh(context) is None:
        cls.poll_message_set("Select a mesh object")
    elif context.mode != "OBJECT":
        cls.poll_message_set("Leave edit mode first")
    elif wheel.problem() is not None:
        cls.poll_message_set(wheel.problem())
    else:
        return True
    return False


class TRISTRIP_OT_strips(bpy.types.Operator):  # type: ignore[misc]
    """Compute triangle strips of the active mesh, and store the strip of each face"""

    bl_idname = "tristrip.strips"
    bl_label = "Triangle strips"
    bl_options = {"REGISTER", "UNDO"}

    effort: bpy.props.IntProperty(  # type: ignore[valid-type]
        name="Effort", description="Search effort: higher finds fewer indices", default=2, min=0, max=9
    )
    color: bpy.props.BoolProperty(  # type: ignore[valid-type]
        name="Color", description='Store a color per strip as the attribute "strip_color"', default=True
    )

    @classmethod
    def poll(cls, context: Any) -> bool:
        return _can_change(cls, context)

    def execute(self, context: Any) -> set[str]:
        mesh = _active_mesh(context)
        vertices, corners, offsets = mesh_data.polygons(mesh)
        triangles, faces = mesh_data.triangles(mesh)
        try:
            found = strips.face_strips(vertices, corners, offsets, corners[triangles], faces, effort=self.effort)
        except Exception as error:
            return _failed(self, error)
        mesh_data.write_strips(mesh, found.strip, found.order, strips.colours(found.strip) if self.color else None)
        mesh[mesh_data.FIGURES] = {key: value for key, value in found.metrics.items() if isinstance(value, int | float)}
        for note in found.notes:
            self.report({"WARNING"}, note)
        self.report({"INFO"}, strips.sentence(found.metrics))
        return {"FINISHED"}


class TRISTRIP_OT_simplify(bpy.types.Operator):  # type: ignore[misc]
    """Replace the active mesh by a level of detail that keeps UVs, colors and materials"""

    bl_idname = "tristrip.simplify"
    bl_label = "Simplify by levels"
    bl_options = {"REGISTER", "UNDO"}

    goal: bpy.props.EnumProperty(  # type: ignore[valid-type]
        name="Goal",
        items=[
            ("RATIO", "Ratio", "Keep a ratio of the triangles"),
            ("ERROR", "Error", "Keep as few triangles as the error allows"),
        ],
        default="RATIO",
    )
    ratio: bpy.props.FloatProperty(  # type: ignore[valid-type]
        name="Ratio", description="The ratio of triangles to keep", default=0.5, min=0.0, max=1.0, subtype="FACTOR"
    )
    error: bpy.props.FloatProperty(  # type: ignore[valid-type]
        name="Error",
        description="The maximum error in percent of the bounding-box diagonal",
        default=0.1,
        min=0.0,
        soft_max=5.0,
        max=100.0,
        precision=3,
    )

    @classmethod
    def poll(cls, context: Any) -> bool:
        return _can_change(cls, context)

    def draw(self, context: Any) -> None:
        self.layout.prop(self, "goal", expand=True)
        self.layout.prop(self, "ratio" if self.goal == "RATIO" else "error")

    def execute(self, context: Any) -> set[str]:
        mesh = _active_mesh(context)
        if mesh.shape_keys is not None:
            self.report({"ERROR"}, "The mesh has shape keys, which would be lost; remove or apply them first")
            return {"CANCELLED"}
        if not mesh.polygons:
            self.report({"ERROR"}, "The mesh has no faces")
            return {"CANCELLED"}
        try:
            whole = levels.levels_of(mesh_data.corner_mesh(mesh))
            goal = {"ratio": self.ratio} if self.goal == "RATIO" else {"error": self.error}
            level = whole.level(**goal)
        except Exception as error:
            return _failed(self, error)
        lost = mesh_data.replace(mesh, level.triangles)
        count, full = len(level.triangles), whole.full_count
        self.report({"INFO"}, f"{count:,} of {full:,} triangles, error {level.error:.3g}")
        if lost:
            self.report({"WARNING"}, f"Dropped attributes: {', '.join(lost)}")
        if self.goal == "RATIO" and count > max(full * self.ratio, 1) * 1.01:
            self.report({"WARNING"}, f"Stopped at {count:,} triangles to preserve the surface and its seams")
        return {"FINISHED"}


class TRISTRIP_OT_export(bpy.types.Operator, ExportHelper):  # type: ignore[misc]
    """Export a GLB with triangle strips, proven to draw the same triangles"""

    bl_idname = "export_scene.tristrip_glb"
    bl_label = "Export GLB with triangle strips"

    filename_ext = ".glb"
    filter_glob: bpy.props.StringProperty(default="*.glb", options={"HIDDEN"})  # type: ignore[valid-type]
    use_selection: bpy.props.BoolProperty(  # type: ignore[valid-type]
        name="Selected objects", description="Export only selected objects", default=False
    )
    apply_modifiers: bpy.props.BoolProperty(  # type: ignore[valid-type]
        name="Apply modifiers",
        description="Apply modifiers to the exported meshes; drops shape keys",
        default=True,
    )
    effort: bpy.props.IntProperty(  # type: ignore[valid-type]
        name="Effort", description="Search effort: higher finds fewer indices", default=2, min=0, max=9
    )
    layout_name: bpy.props.EnumProperty(  # type: ignore[valid-type]
        name="Strips",
        items=[
            ("degenerate", "Joined", "One strip per mesh, joined by degenerate triangles; works in every viewer"),
            (
                "restart",
                "Restarts",
                "Fewer indices, but needs a draft glTF extension that few programs support; Blender does not",
            ),
        ],
        default="degenerate",
    )

    def execute(self, context: Any) -> set[str]:
        found = wheel.problem()
        if found is not None:
            self.report({"ERROR"}, found)
            return {"CANCELLED"}
        try:
            notes = export(
                self.filepath,
                effort=self.effort,
                layout=self.layout_name,
                use_selection=self.use_selection,
                export_apply=self.apply_modifiers,
            )
        except Exception as error:
            return _failed(self, error)
        for note in notes[1:]:
            self.report({"WARNING"}, note)
        self.report({"INFO"}, notes[0])
        return {"FINISHED"}


def export(path: str, *, effort: int | None = None, layout: Any = "degenerate", **options: Any) -> list[str]:
    """Export the scene with Blender's own exporter, then rewrite the file with strips.

    Returns:
        A line about the strips, then notes on dropped or changed data.
    """
    import tristrip

    with tempfile.TemporaryDirectory() as folder:
        plain = Path(folder) / "plain.glb"
        result = bpy.ops.export_scene.gltf(filepath=str(plain), export_format="GLB", **options)
        if result != {"FINISHED"}:
            raise RuntimeError("Blender's glTF export did not finish")
        stripped = tristrip.load(plain).strip(effort=effort)
        report = stripped.save(path, layout=layout)
    return [strips.sentence(dict(stripped.metrics())), *stripped.notes, *report.get("notes", [])]


def _failed(operator: Any, error: Exception) -> set[str]:
    operator.report({"ERROR"}, f"{type(error).__name__}: {error}")
    return {"CANCELLED"}


class TRISTRIP_OT_copy_command(bpy.types.Operator):  # type: ignore[misc]
    """Copy the command that installs tristrip into Blender's Python"""

    bl_idname = "tristrip.copy_command"
    bl_label = "Copy command"

    def execute(self, context: Any) -> set[str]:
        context.window_manager.clipboard = wheel.command()
        self.report({"INFO"}, "Run the command in a clone of tristrip, then restart Blender")
        return {"FINISHED"}


class TRISTRIP_PT_panel(bpy.types.Panel):  # type: ignore[misc]
    """The panel in the sidebar of the 3D view."""

    bl_idname = "TRISTRIP_PT_panel"
    bl_label = "Tristrip"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Tristrip"

    def draw(self, context: Any) -> None:
        layout = self.layout
        if wheel.problem() is not None:
            column = layout.column(align=True)
            column.label(text="tristrip is not installed in Blender's Python.", icon="ERROR")
            column.label(text="Run in a clone of tristrip, then restart Blender:")
            column.label(text=wheel.command())
            column.operator(TRISTRIP_OT_copy_command.bl_idname)
            return
        layout.operator(TRISTRIP_OT_strips.bl_idname)
        layout.operator(TRISTRIP_OT_simplify.bl_idname)
        layout.operator(TRISTRIP_OT_export.bl_idname)
        mesh = _active_mesh(context)
        found = mesh.get(mesh_data.FIGURES) if mesh is not None else None
        if found and "strip" in mesh.attributes:
            column = layout.column(align=True)
            column.label(text=f"{found['strips']:,} strips of {found['triangles']:,} triangles")
            column.label(text=f"{found['indices_restart']:,} indices with restarts")
            column.label(text=f"{found['indices_restart_per_triangle']:.3f} per triangle")


def _menu(menu: Any, context: Any) -> None:
    menu.layout.operator(TRISTRIP_OT_export.bl_idname, text="GLB with triangle strips (.glb)")


_CLASSES = (TRISTRIP_OT_strips, TRISTRIP_OT_simplify, TRISTRIP_OT_export, TRISTRIP_OT_copy_command, TRISTRIP_PT_panel)


def register() -> None:
    """Register all classes, and add the entry to the menu File > Export."""
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.TOPBAR_MT_file_export.append(_menu)


def unregister() -> None:
    """Unregister them."""
    bpy.types.TOPBAR_MT_file_export.remove(_menu)
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
