"""A recording in which nothing moves is refused at once."""

from __future__ import annotations

from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.measure.consistency.still import nothing_moved


def refuse_still(time_s: Floats, markers: Floats) -> None:
    """InputError where not one of the markers (F, N, 2) moves by more than its noise from frame to frame."""
    if (said := nothing_moved(time_s, markers)) is not None:
        raise InputError(f"{said}.")
