"""HTML representations of results for notebooks: a table, and an image if there are positions."""

from __future__ import annotations

from base64 import b64encode
from html import escape
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Mapping

    from ._native import Chain, Decoder, Levels, Scene, Simplified, SimplifiedScene, StrippedScene, Strips

_SHOWN = {
    "triangles": "triangles",
    "strips": "strips",
    "indices_restart": "indices with restarts",
    "indices_restart_per_triangle": "per triangle",
    "indices_degenerate": "indices with degenerate joins",
    "acmr_fifo_16": "ACMR, FIFO 16",
}


def table(title: str, rows: dict[str, Any]) -> str:
    """Return a table of names and values as HTML."""
    cells = "".join(
        f'<tr><th style="text-align:left">{escape(name)}</th><td>{escape(_text(value))}</td></tr>'
        for name, value in rows.items()
    )
    return f"<table><caption>{escape(title)}</caption>{cells}</table>"


def _text(value: Any) -> str:
    if isinstance(value, bool) or value is None:
        return str(value)
    if isinstance(value, int):
        return f"{value:,}"
    return f"{value:.3f}" if isinstance(value, float) else str(value)


def simplified_html(simplified: Simplified) -> str:
    """Return the summary of a simplified mesh."""
    rows: dict[str, Any] = {
        "triangles": len(simplified.faces),
        "vertices": len(simplified.vertices),
        "surface error": simplified.surface_error,
    }
    if simplified.rms_deviation is not None:
        rows["RMS deviation"] = simplified.rms_deviation
        rows["largest deviation"] = simplified.largest_deviation
    if simplified.warning:
        rows["warning"] = simplified.warning
    return table("simplified mesh", rows)


def levels_html(levels: Levels) -> str:
    """Return the summary of levels of detail."""
    rows: dict[str, Any] = {
        "level model": levels.model,
        "level": levels.level,
        "last level": levels.last_level,
        "triangles": levels.triangle_count,
        "surface error": levels.surface_error,
        "bytes of the model": levels.memory["model"],
    }
    return table("levels of detail", rows)


def strips_html(strips: Strips) -> str:
    """Return the summary of strips."""
    metrics: dict[str, Any] = dict(strips.metrics())
    rows = {name: metrics[key] for key, name in _SHOWN.items()}
    return table(strips.method or "strips", rows)


def report_html(title: str, report: Mapping[str, Any]) -> str:
    """Return the numbers and strings of a report."""
    rows = {key.replace("_", " "): value for key, value in report.items() if isinstance(value, (int, float, str))}
    return table(title, rows)


def decoder_html(decoder: Decoder) -> str:
    """Return the state of a decoder."""
    rows: dict[str, Any] = {
        "bytes": decoder.offset,
        "of": decoder.chunk_end,
        "chunks": decoder.chunk_count,
        "level": decoder.level,
        "full level": decoder.full_level,
        "triangles": decoder.triangle_count,
        "full triangles": decoder.full_triangle_count,
        "error": decoder.error,
    }
    return table("decoder", {name: value for name, value in rows.items() if value is not None})


#: Larger scenes are shown without an image, because rendering would take seconds.
_MAX_DRAWN = 1_000_000


def picture(png: bytes) -> str:
    """Return an image as HTML."""
    return f'<img src="data:image/png;base64,{b64encode(png).decode()}" style="max-width:100%">'


def _drawn(triangles: int, draw: Any) -> str:
    from ._errors import TristripError

    if triangles > _MAX_DRAWN:
        return ""
    try:
        return picture(draw())
    except TristripError as error:
        return f"<p>{escape(str(error))}</p>"


def _notes(notes: list[str]) -> str:
    return "".join(f"<li>{escape(note)}</li>" for note in notes[:20]).join(("<ul>", "</ul>")) if notes else ""


def scene_html(scene: Scene) -> str:
    """Return the summary of a scene."""
    parts = scene.parts
    triangles = sum(len(part.faces) for part in parts)
    rows: dict[str, Any] = {
        "format": (scene.format or "arrays").upper(),
        "parts": len(parts),
        "triangles": triangles,
        "materials": len({part.material for part in parts if part.material is not None}),
    }
    drawn = _drawn(triangles, lambda: scene.picture(600, 450))
    return table("scene", rows) + drawn + _notes(scene.notes)


def stripped_html(stripped: StrippedScene) -> str:
    """Return the summary of the strips of a scene."""
    metrics: dict[str, Any] = dict(stripped.metrics())
    rows = {name: metrics[key] for key, name in _SHOWN.items()}
    if stripped.bound is not None:
        rows["lower bound"] = stripped.bound["bound"]
    rows["proven"] = stripped.proven
    drawn = _drawn(metrics["triangles"], lambda: stripped.picture(600, 450))
    return table(stripped.method, rows) + drawn + _notes(stripped.notes)


def simplified_scene_html(simplified: SimplifiedScene) -> str:
    """Return the summary of a simplified scene."""
    report: dict[str, Any] = dict(simplified.report)
    shown = {
        "triangles_before": "triangles before",
        "triangles_after": "triangles after",
        "surface_error": "surface error",
        "surface_error_percent": "percent of the diagonal",
        "rms_deviation": "RMS deviation",
        "normal_deviation_degrees": "normal deviation, degrees",
    }
    rows = {name: report[key] for key, name in shown.items() if report[key] is not None}
    if simplified.warning:
        rows["warning"] = simplified.warning
    drawn = _drawn(report["triangles_before"], lambda: simplified.picture(128))
    return table("simplified scene", rows) + drawn + _notes(simplified.notes)


def chain_html(chain: Chain) -> str:
    """Return the summary of a chain of levels."""
    heads = ["level", "triangles", "vertices", "error, % of the diagonal", "minimum screen coverage"]
    keys = ["level", "triangles", "vertices", "surface_error_percent", "screen_coverage"]
    head = "".join(f"<th>{escape(text)}</th>" for text in heads)
    levels: list[dict[str, Any]] = [dict(level) for level in chain.levels]
    cells = ("".join(f"<td>{escape(_text(level[key]))}</td>" for key in keys) for level in levels)
    rows = "".join(f"<tr>{row}</tr>" for row in cells)
    warning = f"<p>{escape(chain.warning)}</p>" if chain.warning else ""
    return f"<table><caption>chain of levels</caption><tr>{head}</tr>{rows}</table>{warning}{_notes(chain.notes)}"
