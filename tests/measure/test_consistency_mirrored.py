"""One film that shows left for right, or the body from its other end, where the others do not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from serpenoid.measure.consistency.check import check
from serpenoid.measure.consistency.claim import Claim
from serpenoid.measure.consistency.signals import Signal
from serpenoid.measure.schedule import Schedule

PHASE = 2 * np.pi * np.arange(40)[:, None] / 40 - 1.2 * np.arange(5)
HALF_TURN = 0.5 * np.cos(PHASE)  # its other half is the first, mirrored
UNEVEN = HALF_TURN + 0.15 * np.cos(2 * PHASE) + 0.1
MIRRORED = "is this film `mirrored`? Set `mirrored = true` in the trial"


def trials(rows: np.ndarray, mirrored: list[int], logs: bool, count: int = 4) -> list[Claim]:
    """Trials of one table, some of whose films show left for right."""
    schedule, rng = Schedule(rows, 3.0, 2, 0.5), np.random.default_rng(2)
    time = np.arange(-0.5, schedule.end_s + 0.5, 1 / 50)
    angles = schedule.commanded(time)
    made = []
    for k in range(count):
        seen, read = angles + rng.normal(0, 0.005, angles.shape), angles + rng.normal(0, 0.001, angles.shape)
        film = Signal(time + 7, -seen if k in mirrored else seen)
        made.append(Claim(f"t{k}", "gait", schedule, film, Signal(time, read) if logs else None))
    return made


@pytest.mark.parametrize("logs", [False, True])
@pytest.mark.parametrize("mirrored", [[2], pytest.param([1, 3], marks=pytest.mark.slow)])
def test_single_films_that_are_mirrored_are_told_as_such(mirrored, logs):
    found = check(trials(UNEVEN, mirrored, logs), {"gait": UNEVEN}).contradictions
    assert [(one.trial, one.cure) for one in found] == [(f"t{k}", MIRRORED) for k in mirrored]


@pytest.mark.slow
def test_where_a_mirrored_film_looks_like_half_a_cycle_later_both_are_told():
    (found,) = check(trials(HALF_TURN, [2], logs=False, count=3), {"gait": HALF_TURN}).contradictions
    assert found.cure == f"{MIRRORED}; or begin the table there: the body rests in its row 20"


@pytest.mark.parametrize("logs", [False, True])
def test_films_that_are_all_mirrored_are_told_once_for_all(logs):
    found = check(trials(UNEVEN, [0, 1], logs, count=2), {"gait": UNEVEN}).contradictions
    assert len(found) == 2
    assert all("`up_axis`" in one.cure and "this film" not in one.cure for one in found)


@pytest.mark.parametrize(
    ("kind", "sign", "cure"),
    [("order", 1, "head to tail in this film, and is it `mirrored`"), ("ends", -1, "`first_point`) in the trial")],
)
def test_a_single_film_that_shows_the_body_from_its_other_end_is_told(kind, sign, cure):
    claims = trials(UNEVEN, [], logs=True)
    film = claims[1].cameras
    assert film is not None
    claims[1] = replace(claims[1], cameras=Signal(film.time_s, sign * film.values[:, ::-1]))
    (found,) = check(claims, {"gait": UNEVEN}).contradictions
    assert (found.trial, found.kind) == ("t1", f"{kind}, in one film")
    assert cure in found.cure


@pytest.mark.parametrize("commands", [False, True])
def test_a_single_trial_that_was_played_mirrored_is_told_as_another_gait(commands):
    """Log and film agree: the robot did what it was told, and that is not what the campaign names."""
    claims = trials(UNEVEN, [2], logs=True)
    for k, (claim, sign) in enumerate(zip(claims, (1, 1, -1, 1), strict=True)):
        log = claim.servos
        assert log is not None
        assert claim.schedule is not None
        told = Signal(log.time_s, sign * claim.schedule.commanded(log.time_s)) if commands else None
        claims[k] = replace(claim, servos=Signal(log.time_s, sign * log.values), commands=told)
    (found,) = check(claims, {"gait": UNEVEN}).contradictions
    assert (found.trial, found.kind) == ("t2", "signs, in one trial")
    assert found.cure == "was another gait than `gait` played in this trial? Name in `joint_table` what was"


def test_a_log_whose_signs_are_flipped_in_every_trial_is_told_once_for_all():
    claims = trials(UNEVEN, [], logs=True, count=2)
    claims = [replace(c, servos=Signal(c.servos.time_s, -c.servos.values)) for c in claims if c.servos is not None]
    found = check(claims, {"gait": UNEVEN}).contradictions
    assert len(found) == 2
    assert all("in this trial" not in one.cure and "flip the signs" in one.cure for one in found)
