"""Joint angles for a controller of one's own: rows at its pace, in its unit, with its signs and zeros.

    command_j = zero_j + sign_j * angle_j        joint_1 next to the tail; angles counter-clockwise seen from above

Between the rows of a table joints turn at constant rates, as everywhere here: rows between them are laid on straight
lines.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from serpenoid.errors import InputError
from serpenoid.measure.formats.columns import RADIANS
from serpenoid.wording import counted

UNITS = ("deg", "rad")
DECIMALS = {"deg": 4, "rad": 6}  # far below what any servo resolves
MOST_ROWS = 1_000_000
Floats = NDArray[np.float64]


def paced(angles: Floats, closed: bool, duration_s: float, rate_hz: float) -> Floats:
    """A table (T, m) [rad], of a transient (T + 1, m), as rows that are `1 / rate_hz` apart.

    InputError where the duration [s] of a cycle (or transient) is no whole number of rows, three or more.
    """
    if not (np.isfinite(rate_hz) and 0 < rate_hz * duration_s <= MOST_ROWS):
        raise InputError(f"--rate must be above 0 rows a second, and {MOST_ROWS} rows at most, got {rate_hz:g}.")
    exact = duration_s * rate_hz
    rows = round(exact)
    if rows < 3 or abs(exact - rows) > 1e-6 * rows:
        fitting = f"{max(3, int(exact)) / rate_hz:g} or {(max(3, int(exact)) + 1) / rate_hz:g}"
        raise InputError(
            f"--rate {rate_hz:g}: {duration_s:g} s are {exact:g} rows, and a cycle has a whole number, three or more. "
            f"Give --cycle-duration {fitting}, or another rate."
        )
    ends = np.vstack([angles, angles[:1]]) if closed else angles
    steps = len(ends) - 1
    places = np.arange(rows + (not closed)) * steps / rows
    before = np.minimum(places.astype(int), steps - 1)
    share = (places - before)[:, None]
    return (1 - share) * ends[before] + share * ends[before + 1]


def commands(angles: Floats, unit: str, signs: Sequence[float], zeros: Sequence[float]) -> Floats:
    """What the controller is told, shape (R, m): angles (R, m) [rad] in `unit`, with signs (m,) about zeros (m,)."""
    return np.round(np.asarray(zeros) + np.asarray(signs) * angles / RADIANS[unit], DECIMALS[unit])


def of_each(text: str, joints: int, option: str) -> list[float]:
    """Numbers with commas, one for each joint or one for all; InputError else."""
    try:
        values = [float(word) for word in text.split(",")]
    except ValueError:
        values = []
    if len(values) not in (1, joints) or not np.isfinite(values).all():
        raise InputError(f"{option} must be one number, or {counted(joints, 'number')} with commas, got {text!r}.")
    return values * joints if len(values) == 1 else values


def signs_of(text: str, joints: int) -> list[float]:
    """The same, each 1 or -1."""
    signs = of_each(text, joints, "--signs")
    if not set(signs) <= {1.0, -1.0}:
        raise InputError(f"--signs must be 1 or -1 (as --signs=-1), got {text!r}.")
    return signs
