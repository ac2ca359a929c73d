"""One HTML file that needs nothing else: tables, figures, and an animation one can scrub. No network, no libraries."""

from __future__ import annotations

import base64
import html
import json
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from serpenoid.compare.three import Comparison
from serpenoid.files import write_text

FRAMES = 160  # of an animation: smooth enough to scrub, small enough to mail


def write_report(
    path: Path, title: str, lead: Sequence[str], sections: Sequence[tuple[str, str]], comparisons: Sequence[Comparison]
) -> None:
    """Write the report: `lead` paragraphs, then (heading, HTML) sections, then the animation."""
    page = (files("serpenoid.compare") / "report.html").read_text(encoding="utf-8")
    body = [f"<p>{html.escape(text)}</p>" for text in lead]
    body += [f"<h2>{html.escape(heading)}</h2>\n{content}" for heading, content in sections]
    data = json.dumps([animation_data(c) for c in comparisons], separators=(",", ":")).replace("</", "<\\/")
    page = page.replace("{{title}}", html.escape(title)).replace("{{body}}", "\n".join(body)).replace("{{data}}", data)
    write_text(path, page)


def figure(path: Path, text: str) -> str:
    """An SVG file as an image inside the page."""
    data = base64.b64encode(path.read_bytes()).decode()
    alt = html.escape(text, quote=True)
    image = f'<img alt="{alt}" src="data:image/svg+xml;base64,{data}">'
    return f"<figure>{image}<figcaption>{html.escape(text)}</figcaption></figure>"


def table(header: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    """A table; numbers are shortened to four significant digits and aligned right, the heads of their columns too."""
    numbers = [any(isinstance(row[column], int | float) for row in rows) for column in range(len(header))]
    head = "".join(_head(cell, number) for cell, number in zip(header, numbers, strict=True))
    lines = ["<tr>" + "".join(_cell(cell) for cell in row) + "</tr>" for row in rows]
    return f'<div class="wide"><table><thead><tr>{head}</tr></thead><tbody>{"".join(lines)}</tbody></table></div>'


def _head(text: str, number: bool) -> str:
    kind = ' class="number"' if number else ""
    return f"<th{kind}>{html.escape(text)}</th>"


def _cell(value: Any) -> str:
    if isinstance(value, int):
        return f'<td class="number">{value}</td>'
    if isinstance(value, float):
        return f'<td class="number">{value:.4g}</td>' if np.isfinite(value) else "<td></td>"
    return f"<td>{html.escape(str(value))}</td>"


def animation_data(comparison: Comparison) -> dict[str, Any]:
    """Bodies at up to FRAMES moments, rounded to a tenth of a thousandth of a body length."""
    rows = np.unique(np.linspace(0, len(comparison.time_s) - 1, FRAMES).round().astype(int))
    classes = {"Exp": comparison.exp, "Sim": comparison.sim, "Resim": comparison.resim}
    return {
        "name": f"{comparison.trial}, cycle {comparison.cycle + 1}",
        "time": (comparison.time_s[rows] - comparison.time_s[0]).round(3).tolist(),
        "classes": {
            name: {"bodies": path.vertices[rows].round(4).tolist(), "path": path.poses[rows, :2].round(4).tolist()}
            for name, path in classes.items()
            if path is not None
        },
    }
