"""How far held-out gaits are expected to be off: as far as fits to draws of the other gaits' noise are."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from serpenoid.diagnose.data.chance import SYSTEMATIC
from serpenoid.diagnose.data.noise.paths import strays, total
from serpenoid.diagnose.inference.fits.held_out import first_order, left_open, of_each_gait, part
from serpenoid.diagnose.inference.fits.medium import Fit, linearised, with_values
from serpenoid.diagnose.report import next_trial
from serpenoid.diagnose.report.cards import cards
from serpenoid.diagnose.report.words import shown

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
    assert np.sqrt(np.mean(squares)) * SYSTEMATIC == pytest.approx(total(left_open(motion, best)), rel=0.3)


def test_it_is_said_of_each_gait(diagnosed: tuple[Any, dict[str, Any], Any]) -> None:
    found, record, _ = diagnosed
    trials = found.motion.selection.motion.tracks
    by_gait = record["left_open_by_gait_m"]
    each = [by_gait[t.recording.gait] for t in trials]
    assert len(by_gait) == len({t.recording.gait for t in trials}) > 1
    assert total(each) == pytest.approx(record["left_open_m"])


def test_where_no_gaits_are_held_out_none_is_named(diagnosed: tuple[Any, dict[str, Any], Any]) -> None:
    motion = diagnosed[0].motion.selection.motion
    each_trial = replace(motion, labels=tuple(range(len(motion.tracks))))
    assert of_each_gait(each_trial, np.ones(len(motion.tracks))) == {}


@pytest.mark.parametrize(
    ("open_m", "said"),
    [
        (2e-3, ["2 mm is expected, as the other gaits tell too little"]),
        (5e-4, []),
        (4e9, ["a larger error is expected, as the other gaits tell too little"]),  # first order goes where nothing can
    ],
)
def test_it_is_told_where_it_is_more_than_noise(open_m: float, said: list[str]) -> None:
    assert next_trial.left_open(opened(open_m)) == said


def opened(open_m: float, **by_gait: float) -> dict[str, Any]:
    """As much of a record as is read."""
    open_by = {"left_open_m": open_m, "left_open_by_gait_m": by_gait}
    gain = {"path_rms_m": {"before": 1e-2, "after": 1e-3}}
    return open_by | {"noise_level_m": 1e-3, "length_unit": "m", "drag_ratio": None, "gain": gain}


def test_gaits_that_alone_tell_a_value_are_named(diagnosed: tuple[Any, dict[str, Any], Any]) -> None:
    record = opened(2e-3, tail=5e-3, head=4e-4)
    assert next_trial.left_open(record) == [
        "2 mm is expected, as the other gaits tell too little of tail: play more of that kind"
    ]
    record = diagnosed[1] | record | {"gain": diagnosed[1]["gain"]}
    most = max(record["gain"]["path_rms_m"][side] for side in ("before", "after"))
    for open_m, much in ((0.9 * most, shown(0.9 * most, "m")), (9 * most, "A larger error")):
        record |= {"left_open_m": open_m, "left_open_by_gait_m": {"tail": open_m}, "noise_level_m": 1e-6}
        told = f"{much} is expected, as the other gaits tell too little of tail: play more of that kind."
        assert told in cards(record)[2].sentences
    record |= {"left_open_m": 1e-7}
    assert not any("is expected" in text for text in cards(record)[2].sentences)
