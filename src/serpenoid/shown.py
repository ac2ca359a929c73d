"""Results that are short to print, show a picture in Jupyter, and can be compared."""

from __future__ import annotations

import dataclasses
import importlib
import io
from typing import Any

DPI = 110


class Shown:
    """A frozen dataclass (with `eq=False`: arrays have no one truth) says `summary()`; `plot.previews` may have a
    picture of it.
    """

    def summary(self) -> str:
        """One line about what was found."""
        raise NotImplementedError

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.summary()}>"

    def __eq__(self, other: object) -> bool:
        """Number by number."""
        return all(_same(a, b) for a, b in _fields(self, other)) if type(self) is type(other) else NotImplemented

    __hash__ = None  # type: ignore[assignment]  # arrays have none

    def _repr_png_(self) -> bytes | None:
        """What Jupyter shows; pictures are looked up by name, so that results know nothing of drawing."""
        figure = importlib.import_module("serpenoid.plot.previews").preview(self)
        if figure is None:
            return None
        stream = io.BytesIO()
        figure.savefig(stream, format="png", dpi=DPI)
        return stream.getvalue()


def _same(one: Any, other: Any) -> bool:
    """Whether two values are equal, arrays and what holds them number by number; what is no number equals itself."""
    if type(one) is not type(other):
        return bool(one == other)
    if dataclasses.is_dataclass(one):
        return all(_same(a, b) for a, b in _fields(one, other))
    if isinstance(one, tuple | list):
        return len(one) == len(other) and all(map(_same, one, other))
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(_same(value, other[key]) for key, value in one.items())
    if hasattr(one, "shape"):
        return one.shape == other.shape and bool(((one == other) | ((one != one) & (other != other))).all())
    return bool(one == other or (one != one and other != other))


def _fields(one: Any, other: Any) -> list[tuple[Any, Any]]:
    names = [field.name for field in dataclasses.fields(one) if field.compare]
    return [(getattr(one, name), getattr(other, name)) for name in names]
