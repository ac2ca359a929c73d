"""A servo log beside markers of which some are never seen."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from rehearsal import serpenoid_table, snake
from serpenoid.body import Body
from serpenoid.diagnose.data.cameras.observation import directions
from serpenoid.diagnose.data.recordings.clocks import align
from serpenoid.errors import InputError
from serpenoid.measure import clock
from serpenoid.measure.clock import find_offset
from serpenoid.measure.logs import ServoLog
from serpenoid.measure.schedule import Schedule
from serpenoid.measure.servo_alignment import seen_corners
from serpenoid.measure.servo_zeros import lasting
from serpenoid.measure.shapes.links import chain_vertices
from serpenoid.measure.trial import build_motion, log_covers

SD = 0.001  # of the markers [body lengths]
CLOCK_S = 7.3  # cameras minus log
HERTZ = 60.0


def _trial() -> tuple[Body, np.ndarray, np.ndarray, np.ndarray, ServoLog]:
    """Times (F,), joint angles (F, m), markers (F, N, 2) of three cycles, and the log on its own clock."""
    body = snake().body
    schedule = Schedule(serpenoid_table(50), 2.0, 3, 1.0, start_s=10.0)
    time = np.arange(9.5, 18.5, 1 / HERTZ)
    angles = schedule.commanded(time)
    poses = np.stack([0.02 * time, 0.01 * np.sin(time), 0.1 * np.cos(time)], axis=1)
    rng = np.random.default_rng(3)
    markers = chain_vertices(body, poses, angles) + rng.normal(scale=SD, size=(len(time), body.vertices, 2))
    at = np.arange(9.6, 18.4, 0.02)
    log = ServoLog(at - CLOCK_S, schedule.commanded(at), None, None, None, None, {}, "servo.csv")
    return body, time, angles, markers, log


@pytest.mark.parametrize("never", [[0], [11], [5], [0, 4, 8], [0, 2, 4, 6, 8, 10]], ids=str)
def test_joints_that_cameras_never_show_are_the_servos(never: list[int]) -> None:
    body, time, angles, markers, log = _trial()
    markers[:, never] = np.nan
    motion, servo, notes = build_motion(body, time, markers, log, ((), ()))
    assert servo is not None
    assert servo.offset.offset_s == pytest.approx(CLOCK_S, abs=0.003)  # a fifth of a frame
    inside = (time > 10.0) & (time < 18.0)
    assert motion.measured[inside].mean() > 0.9
    miss = (motion.joint_angles - angles)[inside]
    # markers alone are off by sqrt(6) SD over a link of L / 11: 0.027 rad; servos know better
    assert np.sqrt(np.nanmean(miss**2, axis=0)).max() < 0.027
    named = {note.endswith("not known"): re.search(r"no frame shows joint ([\d, ]+):", note)[1] for note in notes}
    unseen = {j for j in range(1, 11) if {j - 1, j, j + 1} & set(never)}
    assert {int(j) for words in named.values() for j in words.split(", ")} == unseen
    alone = [j for j, end in ((1, 0), (10, 11)) if end in never]  # nothing is seen of its link's other end
    assert named.get(True, "") == ", ".join(map(str, alone))
    assert not motion.jumps  # a start far from the answer ends in another minimum


HALVES = (0.05, 0.05, 0.075, 0.075, 0.075, 0.075, 0.05, 0.05)  # wheels in the middles of four links


def _rolling(shown: list[int], aside: float = 0.0) -> tuple[Body, np.ndarray, np.ndarray, np.ndarray, ServoLog]:
    """The same of three joints, with markers on `shown` alone, so many body lengths to the left of their links."""
    body = Body(vertices=9, joints=(2, 4, 6), edge_lengths=HALVES)
    schedule = Schedule(0.8 * serpenoid_table(50)[:, [1, 4, 7]], 2.0, 3, 1.0, start_s=10.0)
    time, at = np.arange(9.5, 18.5, 1 / HERTZ), np.arange(9.6, 18.4, 0.02)
    angles = schedule.commanded(time)
    poses = np.stack([0.02 * time, 0.01 * np.sin(time), 0.1 * np.cos(time)], axis=1)
    points = chain_vertices(body, poses, angles)
    points += aside * directions(points)[1]
    markers = np.full_like(points, np.nan)
    markers[:, shown] = points[:, shown]
    markers += np.random.default_rng(3).normal(scale=SD, size=markers.shape)
    return body, time, angles, markers, ServoLog(at - CLOCK_S, schedule.commanded(at), *[None] * 4, {}, "servo.csv")


ON_LINKS = [[0, 1, 3, 5, 7, 8], [1, 3, 5, 7], [0, 3, 5, 8], [1, 4, 7], [0, 5, 7]]


@pytest.mark.parametrize("shown", ON_LINKS, ids=str)
def test_markers_in_the_middles_of_links_show_the_clock_of_a_log_without_any_at_joints(shown: list[int]) -> None:
    body, time, angles, markers, log = _rolling(shown)
    motion, servo, _ = build_motion(body, time, markers, log, ((), ()))
    assert servo is not None
    assert servo.offset.offset_s == pytest.approx(CLOCK_S, abs=0.003)  # a fifth of a frame
    inside = (time > 10.0) & (time < 18.0)
    assert motion.measured[inside].mean() > 0.9
    miss = (motion.joint_angles - angles)[inside]
    assert np.sqrt(np.nanmean(miss**2, axis=0)).max() < 0.027  # as above
    assert not motion.jumps  # beside the log no marker is astray, though without it links may be bent to either side


@pytest.mark.parametrize("shown", [[0, 1, 3, 5, 7, 8], [0, 3, 5, 8], [0, 5, 7]], ids=str)
def test_zeros_of_joints_between_markers_on_links_are_told_by_all_of_them(shown: list[int]) -> None:
    body, time, angles, markers, log = _rolling(shown)
    wrong = np.array([0.0, 0.12, -0.05])
    motion, servo, notes = build_motion(body, time, markers, replace(log, position=log.position - wrong), ((), ()))
    assert servo is not None
    np.testing.assert_allclose(servo.joint_zero, wrong, atol=0.004)  # of 540 frames, 0.03 rad each
    assert [note for note in notes if "zero" in note] == [
        "no frame shows joint 1, 2, 3: its angle is the servo log's, its zero what all markers together say"
    ]
    inside = (time > 10.0) & (time < 18.0)
    assert np.nanmean((motion.smooth_angles - angles)[inside], axis=0) == pytest.approx(0, abs=0.004)


@pytest.mark.parametrize("shown", ON_LINKS, ids=str)
@pytest.mark.parametrize("aside", [0.0, 0.02])
def test_a_diagnosis_lays_clocks_over_each_other_by_markers_wherever_they_are(shown: list[int], aside: float) -> None:
    body, time, _, markers, log = _rolling(shown, aside)
    clock = align(body, time, markers, log)
    middle = time.mean()
    assert clock.servo(middle) == pytest.approx(middle - CLOCK_S, abs=0.003)


def test_markers_of_one_link_show_no_bend() -> None:
    body, time, _, markers, log = _rolling([2, 3, 4])
    assert seen_corners(body, markers) == [2, 4]
    with pytest.raises(InputError, match="no joint lies between"):
        align(body, time, markers, log)


def test_the_polygon_of_a_body_whose_joints_are_seen_has_its_corners_there() -> None:
    body, _, _, markers, _ = _rolling(list(range(9)))
    assert seen_corners(body, markers) == list(body.corners)
    markers[:, 4] = np.nan
    assert seen_corners(body, markers) == [0, 2, 3, 5, 6, 8]  # those beside the joint bend in its place


@pytest.mark.parametrize("never", [[0], [5], [1, 3, 5, 7, 9]], ids=str)
def test_without_a_log_a_vertex_that_is_never_seen_is_named(never: list[int]) -> None:
    """The tail may be anywhere about its joint, and a joint be bent to either side."""
    body, time, _, markers, _ = _trial()
    markers[:, never] = np.nan
    words = f"never seen: vertices {', '.join(map(str, never))}; 0 is the tail.*Where a servo log"
    with pytest.raises(InputError, match=words):
        build_motion(body, time, markers, None, ((), ()))


@pytest.mark.parametrize("never", [[0], [5], [3, 8]], ids=str)
@pytest.mark.parametrize("late_s", [0.0, 0.06])
def test_without_a_log_joints_that_cameras_never_show_do_as_the_table_says(never: list[int], late_s: float) -> None:
    """Rigid links allow two places of a hidden vertex; the table says which, and is late as the others are."""
    body, time, _, markers, _ = _trial()
    told = Schedule(serpenoid_table(50), 2.0, 3, 1.0)
    angles = replace(told, start_s=10.0 + late_s).commanded(time)
    markers += chain_vertices(body, np.zeros((len(time), 3)), angles) - chain_vertices(
        body, np.zeros((len(time), 3)), replace(told, start_s=10.0).commanded(time)
    )
    markers[:, never] = np.nan
    motion, servo, notes = build_motion(body, time, markers, None, ((), ()), told=told)
    assert servo is None  # nobody read them
    inside = (time > 10.1) & (time < 18.0)
    assert motion.measured[inside].mean() > 0.9
    miss = (motion.joint_angles - angles)[inside]
    assert np.sqrt(np.nanmean(miss**2, axis=0)).max() < 0.035  # markers alone: 0.027 rad
    unseen = sorted({j for j in range(1, 11) if {j - 1, j, j + 1} & set(never)})
    one = f"no frame shows joint{'s' * (len(unseen) > 1)} {', '.join(map(str, unseen))}, and no servo log"
    assert any(note.startswith(one) and "assumed" in note for note in notes)


def test_errors_that_last_leave_less_in_a_frame() -> None:
    """White readings a sixth as often as frames, joined by lines: what a mean of many frames scatters by."""
    rng, k, count = np.random.default_rng(0), 6, 1200
    frames, at = np.arange(k * count), k * np.arange(count + 1)
    errors = np.stack([np.interp(frames, at, column) for column in rng.normal(size=(40, count + 1))], axis=1)
    own = np.sqrt(errors.var() + np.mean([lasting(one[:, None]) for one in errors.T]))
    assert own == pytest.approx(np.sqrt(len(frames)) * errors.mean(axis=0).std(), rel=0.3)  # of 40 means: 11 %
    assert own == pytest.approx(np.sqrt(k), rel=0.1)
    white = rng.normal(size=(len(frames), 10))
    assert lasting(white) < 0.05  # a pair of lags is known to 0.01


@pytest.mark.parametrize("end_s", [17.0, 13.0, 12.0, 10.5, 9.0])
def test_a_log_that_ends_early_is_laid_over_the_part_that_it_covers(end_s: float) -> None:
    """Three cycles of 4 s with pauses of 1 s, from 2 s on; before, by whole cycles beside it."""
    schedule = Schedule(serpenoid_table(50), 4.0, 3, 1.0, start_s=2.0)
    time, at = np.arange(0.0, 17.0, 0.02), np.arange(0.5, end_s, 0.03)
    seen = schedule.commanded(time)
    seen += 0.003 * np.random.default_rng(0).normal(size=seen.shape)
    found = find_offset(time, seen, at + 100, schedule.commanded(at))
    assert found is not None
    assert found.offset_s == pytest.approx(-100.0, abs=0.002)


@pytest.mark.parametrize(
    ("since", "until", "cut"), [(0, 17, False), (1.5, 16.5, False), (0, 13, True), (0, 12, True), (3, 17, True)]
)
def test_a_log_is_whole_that_is_as_long_as_the_motion_and_at_rest_at_its_ends(
    since: float, until: float, cut: bool
) -> None:
    """Of a whole one no cycles are left out: with a clock that runs fast fewer of them agree better."""
    schedule = Schedule(serpenoid_table(50), 4.0, 3, 1.0, start_s=2.0)
    time = np.arange(0.0, 17.0, 0.02)
    seen = schedule.commanded(time) + 0.003 * np.random.default_rng(0).normal(size=(len(time), 10))
    at = np.arange(since, until, 0.03)
    assert clock.is_cut(time, seen, 1.0064 * at + 100, schedule.commanded(at)) == cut


LATE, EARLY = "begins 1.5 s after the first command", "ends 2 s before the last"


@pytest.mark.parametrize(
    ("first", "stop", "said"), [(0, 200, ""), (75, 200, LATE), (0, 100, EARLY), (75, 100, f"{LATE} and {EARLY}")]
)
def test_a_log_that_leaves_out_a_part_of_the_trial_is_told(first, stop, said):
    schedule = Schedule(np.zeros((4, 2)), 1.0, 3, 0.5, 2.0)  # moves for 4 s
    notes = log_covers(schedule, 2.0 + np.arange(first, stop + 1) / 50)
    assert [note.split(" log ")[1].split(":")[0] for note in notes] == ([said] if said else [])
