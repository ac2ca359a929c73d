"""HTML pages from templates: one file that needs nothing else, no network, no libraries.

Python gives values, templates/ has the markup. Everything is escaped where it is put in (also names that come from a
campaign), and a value that a template asks for and does not get is an error.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from serpenoid.files.writing import write_text
from serpenoid.report.glossary import glossed

if TYPE_CHECKING:
    from jinja2 import Environment


@dataclass(frozen=True)
class Table:
    """A head and rows; columns with numbers in them are aligned right."""

    header: Sequence[str]
    rows: Sequence[Sequence[Any]]

    @property
    def numeric(self) -> list[bool]:
        """Of every column: whether a row has a number there."""
        return [any(isinstance(row[k], int | float) for row in self.rows) for k in range(len(self.header))]


@dataclass(frozen=True)
class Card:
    """One question of the lead and its answer; tone: "good", "warn" or "plain"; rows: (name, value)."""

    about: str
    answer: str
    sentences: Sequence[str] = ()
    rows: Sequence[tuple[str, str]] = ()
    tone: str = "plain"


@dataclass(frozen=True)
class Picture:
    """An image as a data URI, and what it shows."""

    source: str
    caption: str

    @classmethod
    def of(cls, path: Path, caption: str) -> Picture:
        """An SVG file as an image inside the page (scripts in an image do not run)."""
        return cls(f"data:image/svg+xml;base64,{base64.b64encode(path.read_bytes()).decode()}", caption)


def write_page(path: Path, template: str, **values: Any) -> None:
    """Write `path` from templates/`template`; what a page needs: the head of its template and of `page.html`."""
    write_text(path, _environment().get_template(template).render(values))


def prepare(template: str) -> None:
    """Read and compile templates/`template` while its values are still awaited."""
    _environment().get_template(template)


@cache
def _environment() -> Environment:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    found = Environment(
        loader=PackageLoader("serpenoid", "report/templates"), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    found.filters["shortened"] = _shortened
    found.filters["glossed"] = glossed
    return found


def _shortened(number: float) -> str:
    """Whole numbers as they are, others with four significant digits; nothing for what is not finite."""
    if isinstance(number, int):
        return str(number)
    return f"{number:.4g}" if math.isfinite(number) else ""
