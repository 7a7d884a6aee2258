"""What notebooks show of results: a table, and a picture where there are positions."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Mapping

    from ._native import Decoder, Levels, Simplified, Strips

_SHOWN = {
    "triangles": "triangles",
    "strips": "strips",
    "indices_restart": "indices with restarts",
    "indices_restart_per_triangle": "per triangle",
    "indices_degenerate": "indices joined",
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
    """Return the numbers and texts of a report."""
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
