"""Results that are short to print and show a picture in Jupyter."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DPI = 110


class Shown:
    """A class says `summary()`, and `figure()` where there is something to draw."""

    def summary(self) -> str:
        """One line about what was found."""
        raise NotImplementedError

    def figure(self) -> Figure | None:
        """A picture of it."""
        return None

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.summary()}>"

    def _repr_png_(self) -> bytes | None:
        """What Jupyter shows."""
        figure = self.figure()
        if figure is None:
            return None
        stream = io.BytesIO()
        figure.savefig(stream, format="png", dpi=DPI)
        return stream.getvalue()
