"""How far held-out gaits are expected to be off: as far as fits to draws of the other gaits' noise are."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from serpenoid.diagnose.data.chance import SYSTEMATIC
from serpenoid.diagnose.data.paths import strays
from serpenoid.diagnose.inference.held_out import first_order, left_open, part
from serpenoid.diagnose.inference.medium import Fit, linearised, with_values
from serpenoid.diagnose.report import words

DRAWS = 8


def test_what_other_gaits_leave_open_is_how_far_fits_to_them_scatter(
    diagnosed: tuple[Any, dict[str, Any], Any],
) -> None:
    found = diagnosed[0].motion.selection
    motion, best = found.motion, found.settled
    rng, squares = np.random.default_rng(3), []
    roots = np.linalg.cholesky(best.evidence.matrix)
    for _ in range(DRAWS):
        pull = np.einsum("gij,gj->gi", roots, rng.normal(size=roots.shape[:2]))  # of noise on each gait
        drawn: Fit = replace(best, evidence=replace(best.evidence, vector=pull))
        for label in sorted(set(motion.labels)):
            model = with_values(best.model, best.effects, first_order(motion, drawn, label), motion.held)
            index = [i for i, own in enumerate(motion.labels) if own == label]
            unseen = linearised(part(motion, index), model, best.effects)[1]
            for i, p in zip(index, unseen, strict=True):
                known = best.predictions[i].displacement
                squares.append(strays(motion.tracks[i], known, (p.displacement - known)[..., None]))
    # a value that only one gait tells is drawn to neutral, which scatters less than it is in doubt
    assert np.sqrt(np.mean(squares)) * SYSTEMATIC == pytest.approx(left_open(motion, best), rel=0.3)


@pytest.mark.parametrize(("open_m", "said"), [(2e-3, " (2 mm expected: what the other gaits leave open)"), (5e-4, "")])
def test_it_is_told_where_it_is_more_than_noise(open_m: float, said: str) -> None:
    record = {"left_open_m": open_m, "noise_level_m": 1e-3, "length_unit": "m", "drag_ratio": None}
    assert words.left_open(record) == said
