"""Points that a tracker is unsure of: those whose score is below `minimum_score` count as hidden.

A point without a score is none of them: a person may have set it by hand.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from serpenoid.errors import InputError
from serpenoid.measure.cells import Floats


def sure(floor: Floats, score: Floats, least: float, path: Path) -> Floats:
    """Points (F, M, 2), NaN where their scores (F, M) are below the least. Raises InputError where no point is left."""
    there = np.isfinite(floor).all(axis=2)
    hidden = score < least
    if there.any() and (hidden | ~there).all():
        raise InputError(
            f"{path}: no point has a score of {least:g} or more, the highest is {np.max(score[there]):.3g}: set a "
            "lower `minimum_score` in [motion]."
        )
    return np.where(hidden[..., None], np.nan, floor)
