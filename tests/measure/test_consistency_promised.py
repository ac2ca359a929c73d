"""What is promised to stand still speaks for no other wiring, and who is weak is said of those who are to move."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from serpenoid.measure.consistency.check import check
from serpenoid.measure.consistency.claim import Claim
from serpenoid.measure.consistency.hypotheses import resolved
from serpenoid.measure.consistency.signals import Signal
from serpenoid.measure.schedule import Schedule

TICK = 2 * np.pi / 4096


def gait(moving: list[int], joints: int = 5) -> np.ndarray:
    """Some joints of a wave move, the others stand at 0."""
    phase = 2 * np.pi * np.arange(40)[:, None] / 40 + 1.1 * np.arange(joints)
    rows = 0.5 * np.cos(phase) + 0.1 * np.cos(2 * phase)
    return np.where(np.isin(np.arange(joints), moving), rows, 0.0)


def witnesses(rows: np.ndarray, gains: np.ndarray, witness: str, read: np.ndarray | None = None) -> Claim:
    """A trial of a table `rows`, of which `gains` are seen by a witness, or another table `read`."""
    schedule = Schedule(rows, 3.0, 2, 0.5)
    time = np.arange(-0.5, schedule.end_s + 0.5, 1 / 50)
    seen = gains * Schedule(rows if read is None else read, 3.0, 2, 0.5).commanded(time)
    noise = np.random.default_rng(1).normal(0, 0.002, seen.shape)
    signals = {
        "commands": Signal(time + 3, seen),
        "servos": Signal(time + 3, TICK * np.round((seen + noise) / TICK)),
        "cameras": Signal(time + 8, seen + noise),
    }
    return Claim("t", "gait", schedule, **{witness: signals[witness]})


@pytest.mark.parametrize("witness", ["commands", "servos", "cameras"])
@pytest.mark.parametrize("moving", [[0], [3], [0, 2, 4], [0, 1, 2, 4]])
def test_joints_that_stand_still_contradict_nothing(witness, moving):
    verdict = check([witnesses(gait(moving), np.ones(5), witness)], {"gait": gait(moving)})
    assert verdict.contradictions == ()
    assert verdict.remarks == ()


@pytest.mark.parametrize("witness", ["commands", "servos", "cameras"])
def test_a_joint_that_stands_still_and_was_exchanged_for_one_that_moves_is_found(witness):
    rows, told = gait([0, 1, 2, 4]), gait([0, 1, 2, 4])[:, [0, 1, 2, 4, 3]]
    found = check([witnesses(told, np.ones(5), witness, rows)], {"gait": told}).contradictions
    assert ["`joint_4` and `joint_5` exchanged" in one.words for one in found] == [True]


@pytest.mark.parametrize("trials", [pytest.param(1, marks=pytest.mark.slow), 2])
def test_a_film_that_holds_more_trials_than_one_is_told_to_be_cut(trials: int) -> None:
    schedule = Schedule(gait([0, 1, 2, 3, 4]), 3.0, 2, 0.5)
    time = np.arange(-0.5, schedule.end_s + 0.5, 1 / 50)
    another = Schedule(np.random.default_rng(1).normal(0, 0.5, (40, 5)), 2.2, 2, 0.5).commanded(time)
    film = np.concatenate([another] * trials)
    claim = Claim("t", "gait", schedule, cameras=Signal(np.arange(len(film)) / 50, film))
    (found,) = check([claim], {"gait": schedule.table}).contradictions
    assert "is the file of another trial named here?" in found.cure
    assert ("Does it show more trials than this one? Give each its part by `from_s` and `to_s`" in found.cure) == (
        trials > 1
    )


@pytest.mark.parametrize(
    ("witness", "gains", "said"),
    [
        ("cameras", [0.7] * 5, "joints move 0.70 times as far as promised, all alike (weak servos?)"),
        ("cameras", [0.7, 1, 0.7, 1, 0.7], "`joint_1`, `joint_3`, `joint_5` move 0.70 times as far as promised (weak"),
        ("cameras", [0.5, 1, 0.7, 1, 0.6], "`joint_1`, `joint_3`, `joint_5` move 0.50 to 0.70 times as far"),
        ("commands", [0.9] * 5, "joints are told to move 0.90 times as far as promised, all alike (another table"),
    ],
)
def test_who_moves_less_than_promised_is_named_with_what_that_may_be(witness, gains, said):
    moving = [0, 1, 2, 3, 4]
    (remark,) = check([witnesses(gait(moving), np.array(gains), witness)], {"gait": gait(moving)}).remarks
    assert said in remark[1]


@pytest.mark.parametrize("witness", ["commands", "servos"])
def test_who_is_led_to_the_first_row_and_away_from_the_last_is_not_weak(witness):
    claim = witnesses(gait([0, 1, 2, 3, 4]), np.ones(5), witness)
    told = claim.commands or claim.servos
    time = np.arange(-2.0, claim.schedule.end_s + 2.0, 1 / 50)
    ramp = np.clip(np.minimum(time + 1.2, claim.schedule.end_s + 1.2 - time) / 1.2, 0.0, 1.0)[:, None]
    led = Signal(time + 3, ramp * claim.schedule.commanded(time))
    assert told is not None
    assert check([replace(claim, **{witness: led})], {"gait": claim.schedule.table}).remarks == ()


@pytest.mark.slow
def test_nobody_is_weak_of_whom_hardly_a_frame_shows_all_joints():
    """Markers that are often hidden leave bouts of few frames, which many gains meet."""
    claim = witnesses(gait([0, 1, 2, 3, 4]), np.ones(5), "cameras")
    seen, said = claim.cameras, []
    assert seen is not None
    for seed in range(20):
        rng, known = np.random.default_rng(seed), np.zeros(len(seen.time_s), dtype=bool)
        for begin in rng.integers(0, len(known) - 4, 3):
            known[begin : begin + 4] = True
        values = np.where(known[:, None], seen.values + rng.normal(0, 0.03, seen.values.shape), np.nan)
        verdict = check([replace(claim, cameras=Signal(seen.time_s, values))], {"gait": claim.schedule.table})
        said += [words for _, words in verdict.remarks if "as far as promised" in words]
    assert said == []


UNITS = {"rad": 1.0, "deg": np.pi / 180, "ticks": TICK}


@pytest.mark.parametrize("witness", ["commands", "servos"])
@pytest.mark.parametrize(("written", "read", "size"), [
    ("rad", "deg", 1.0), ("deg", "rad", 0.08), ("rad", "ticks", 1.0), ("deg", "ticks", 1.0),
])  # fmt: skip
def test_a_log_in_another_unit_of_angles_is_told_with_it(witness, written, read, size):
    rows = size * gait([0, 1, 2, 4])
    gains = np.array([0.9, 1.0, 0.8, 1.0, 1.1]) * UNITS[read] / UNITS[written]
    claim = replace(witnesses(rows, gains, "commands"), angle_unit=read)
    if witness == "servos":
        claim = replace(claim, commands=None, servos=claim.commands)
    (found,) = check([claim], {"gait": rows}).contradictions
    assert found.kind == "angle_unit"
    assert found.cure == f'set `angle_unit = "{written}"` in [servo_log]'


@pytest.mark.parametrize("gains", [[0.02, 1, 0.02, 1, 0.02], [0.1] * 5, [0.0] * 4 + [0.5]])
def test_servos_that_are_weak_or_stuck_are_no_other_unit(gains):
    claim = replace(witnesses(gait([0, 1, 2, 3, 4]), np.array(gains), "servos"), angle_unit="deg")
    assert "angle_unit" not in [one.kind for one in check([claim], {}).contradictions]


@pytest.mark.parametrize(
    ("seconds", "each", "told"),
    [
        (0.9992, 0.025, "1"),
        (0.9634, 1 / 30, "0.96"),
        (12.345, 0.025, "12.3"),
        (0.004, 0.025, "0"),
        (1.583, 1e-3, "1.58"),
    ],
)
def test_a_time_is_told_as_exactly_as_rows_resolve_it(seconds, each, told):
    assert resolved(seconds, each) == told


@pytest.mark.parametrize("duration", [3.0, 4.0, 5.3])
def test_a_pause_that_was_not_kept_is_told_alike_of_all_cycles(duration):
    rows = gait([0, 1, 2, 3, 4])
    played = Schedule(rows, duration, 2, 1.0)
    time = np.arange(-0.5, played.end_s + 0.5, 1 / 40)
    told = Claim("t", "gait", Schedule(rows, duration, 2, 2.0), commands=Signal(time + 3.1, played.commanded(time)))
    found = check([told], {"gait": rows}).contradictions
    assert [one.cure for one in found] == ["set `pause_s = 1`"]


@pytest.mark.parametrize(("witness", "promised"), [("commands", 0.5), ("commands", 0.0), ("cameras", 0.0)])
def test_another_pause_is_found_where_a_table_of_few_rows_is_held_row_by_row(witness: str, promised: float) -> None:
    played = Schedule(np.array([[5, 0, -3], [3, 4, 0], [-2, 5, 3], [-5, 0, 4], [-3, -4, 0], [2, -5, -3]]) / 10, 3.0, 2,
                      0.5, held=True)  # fmt: skip
    time = np.arange(-0.5, played.end_s + 0.5, 1 / 40)
    seen = played.commanded(time) + np.random.default_rng(1).normal(0, 0.001, (len(time), 3))
    told = replace(played, pause_s=promised, held=False)
    found = check([Claim("t", "gait", told, **{witness: Signal(time + 3, seen)})], {"gait": told.table})
    says = ["a pause of 0.5 s after every cycle, and `pause_s` says 0" in one.words for one in found.contradictions]
    assert says == ([] if promised else [True])
