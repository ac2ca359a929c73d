"""Results that are short to print and show a picture in Jupyter."""

from __future__ import annotations

import importlib
import io

DPI = 110


class Shown:
    """A class says `summary()`; `plot.previews` may have a picture of it."""

    def summary(self) -> str:
        """One line about what was found."""
        raise NotImplementedError

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.summary()}>"

    def _repr_png_(self) -> bytes | None:
        """What Jupyter shows; pictures are looked up by name, so that results know nothing of drawing."""
        figure = importlib.import_module("serpenoid.plot.previews").preview(self)
        if figure is None:
            return None
        stream = io.BytesIO()
        figure.savefig(stream, format="png", dpi=DPI)
        return stream.getvalue()
