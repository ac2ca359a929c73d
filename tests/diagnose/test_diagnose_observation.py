"""The observation model's play is the law of `loose_joint`; a loose joint is named alone, its interval covers it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, make
from blind.catalogue import Effect
from blind.folder import write
from serpenoid.body import Body
from serpenoid.diagnose.data.cameras.columns import all_keys, columns_of
from serpenoid.diagnose.data.cameras.observation import Observation, across, lying
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.shapes.geometry import register, shapes, turn
from serpenoid.diagnose.stages.ladder import observation_step
from serpenoid.diagnose.stages.observation.choose_observation import choose_observation
from serpenoid.diagnose.stages.observation.marker_evidence import evidence, misfit, misfit_beside, sample
from serpenoid.effects.active import ActiveEffect
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.simulation.servos import realise


@pytest.fixture
def readings() -> np.ndarray:
    time = np.linspace(0, 9, 400)
    return 0.4 * np.sin(np.outer(time, [1.0, 2.0, 3.1]) + [0.0, 1.0, 2.0])


def test_angles_of_a_loose_joint_are_those_of_the_effect(readings: np.ndarray) -> None:
    body = Body(vertices=5, edge_lengths=(0.1,) * 4)
    gaps, zeros = np.array([0.0, 0.13, 0.0]), np.array([0.02, 0.0, 0.0])
    seen = replace(Observation.neutral(body), gaps=gaps, zeros=zeros)
    effects = (ActiveEffect.of("loose_joint", 2, width=0.13), ActiveEffect.of("zero_offset", 1, offset=0.02))
    model = Model(body, Medium(anisotropy_ratio=0.2), effects)
    np.testing.assert_allclose(
        seen.angles(readings), realise(model, readings, np.linspace(0, 9, 400)).angles, atol=1e-14
    )


def test_the_slope_of_play_is_its_difference(readings: np.ndarray) -> None:
    link, slope = across(readings[:, 1], 0.13)
    wider, _ = across(readings[:, 1], 0.13 + 1e-7)
    np.testing.assert_allclose((wider - link) / 1e-7, slope, atol=1e-6)
    assert set(np.unique(slope)) == {-0.5, 0.0, 0.5}


def test_derivatives_of_what_is_seen_are_its_differences() -> None:
    body = Body(
        vertices=7, edge_lengths=(0.04, 0.08, 0.07, 0.06, 0.08, 0.05), weights=tuple(range(1, 8)), joints=(2, 3, 5)
    )
    rng = np.random.default_rng(4)
    angles, slopes = rng.uniform(-0.8, 0.8, (9, 3)), rng.choice([-0.5, 0.0, 0.5], (9, 3))
    beside, ahead = rng.uniform(-0.01, 0.01, (7, 2)), rng.uniform(-0.01, 0.01, (3, 2))
    now = Observation(np.zeros(3), beside, np.zeros(3), ahead, 0.1, np.zeros(4), np.array([0.02, -0.03]))
    columns = [c for name, place in all_keys(body) for c in columns_of(body, name, place)]
    assert sorted(columns) == list(range(3 + 14 + 1 + 3 + 6 + 2 + 4))
    headings = rng.uniform(-np.pi, np.pi, 9)
    found = now.derivatives(body, angles, lambda joint: slopes[:, joint], columns, headings)

    def moved(column: int, step: float) -> np.ndarray:
        bent = angles.copy()
        if column < 3:
            bent[:, column] += step
        elif 18 <= column < 21:
            bent[:, column - 18] += step * slopes[:, column - 18]
        elif 27 <= column < 29:  # it moves markers on the floor, not the chain: as much, the other way
            there = now.stretched(turn(headings[:, None], now.seen(body, angles)))
            return -turn(-headings[:, None], now.with_column(column, step).unstretched(there))
        else:
            return now.with_column(column, step).seen(body, angles)
        return now.seen(body, bent)

    for column, own in zip(columns, found, strict=True):
        np.testing.assert_allclose(own, (moved(column, 1e-6) - moved(column, -1e-6)) / 2e-6, atol=1e-9)


def test_evidence_of_some_columns_is_part_of_the_whole(tmp_path: Path) -> None:
    write(
        make(64, [Effect("marker_offset", 3, {"along": 0.003, "left": -0.002})], combinations=COMBINATIONS[:1]),
        tmp_path,
    )
    recordings = read_recordings(tmp_path)[1]
    body, data = recordings[0].body, sample(recordings)
    now = Observation.neutral(body).with_column(3, 0.02)
    whole, some = evidence(data, now), [2, 17, 32, 35]
    few = evidence(data, now, some)
    np.testing.assert_allclose(few.matrix, whole.matrix[:, some][:, :, some], rtol=1e-12)
    np.testing.assert_allclose(few.vector, whole.vector[:, some], rtol=1e-12)
    assert misfit(data, now) == pytest.approx(whole.constant.sum(), rel=1e-12)
    assert data.count == whole.count.sum()
    step = whole.solve([3])[0]
    assert misfit(data, now.with_column(3, float(step[0]))) == pytest.approx(whole.chi2([3]), rel=0.01)


@pytest.mark.parametrize(
    ("seed", "place", "width"),
    [
        (61, 4, 0.02),
        pytest.param(62, 10, 0.09, marks=pytest.mark.slow),
        pytest.param(63, 1, 0.15, marks=pytest.mark.slow),
    ],
)
def test_a_loose_joint_is_named_alone_and_its_interval_covers_it(
    seed: int, place: int, width: float, tmp_path: Path
) -> None:
    write(make(seed, [Effect("loose_joint", place, {"width": width})], combinations=COMBINATIONS[:1]), tmp_path)
    recordings = read_recordings(tmp_path)[1]
    stage, _ = choose_observation(recordings, Observation.neutral(recordings[0].body))
    assert [(n.effect.name, n.effect.place) for n in stage.named] == [("loose_joint", place)]
    assert stage.settled
    assert not stage.rivals
    low, high = stage.named[0].intervals["width"]
    assert low is not None
    assert high is not None
    assert low < width < high


def test_what_one_joint_does_by_itself_is_no_misfit_where_it_is_free_and_play_of_another_joint_is(
    tmp_path: Path,
) -> None:
    loose = Effect("loose_joint", 8, {"width": 0.1})
    write(make(9, [loose], combinations=COMBINATIONS[:1]), tmp_path)
    _, recordings = read_recordings(tmp_path)
    data, now = sample(recordings[:1]), Observation.neutral(recordings[0].body)
    rng = np.random.default_rng(5)
    bent = data.readings + 0.06 * rng.choice([-1, 1], len(data.readings))[:, None] * (np.arange(10) == 4)
    pose, _ = register(shapes(data.body, data.readings), data.markers)
    turned = turn(pose[:, None, 2], shapes(data.body, bent) - shapes(data.body, data.readings))
    pushed = replace(data, markers=data.markers + turned)
    gaps = np.where(np.arange(10) == 7, 0.1, 0.0)
    known = replace(now, gaps=gaps)
    # a free angle takes one number of each frame; bends of 0.06 are free to first order only: half as much again
    assert misfit(pushed, known) > 100 * data.count
    free = misfit_beside(pushed, known, [4])
    assert free == pytest.approx(data.count - len(data.markers), rel=0.5)
    assert misfit_beside(pushed, now, [4]) - free > 5 * data.count  # the play of joint 8, which that hides from nobody
    assert misfit_beside(pushed, known, []) == pytest.approx(misfit(pushed, known), rel=1e-6)


@pytest.mark.parametrize("seen_as", [0.3, pytest.param(3.0, marks=pytest.mark.slow)])
def test_a_scale_beyond_its_bound_is_no_finding(seen_as: float, tmp_path: Path) -> None:
    write(make(64, [], combinations=COMBINATIONS[:1]), tmp_path)
    recordings = [replace(r, markers=seen_as * r.markers) for r in read_recordings(tmp_path)[1]]
    stage, taken_out = choose_observation(recordings, Observation.neutral(recordings[0].body))
    assert taken_out.scale == pytest.approx(seen_as - 1, rel=1e-3)
    assert "length_scale" not in [n.effect.name for n in stage.named]
    assert not stage.settled
    assert any("length_scale takes away" in word and "beyond its bound" in word for word in stage.words)


@pytest.mark.parametrize(
    ("name", "place"),
    [
        pytest.param("marker_offset", 4, marks=pytest.mark.slow),
        ("marker_offset_ahead", 4),
        pytest.param("marker_offset_ahead", 10, marks=pytest.mark.slow),
    ],
)
def test_a_displaced_marker_is_named_on_the_link_that_it_rides_on(name: str, place: int, tmp_path: Path) -> None:
    moved = {"along": 8e-3, "left": 5e-3}
    write(make(66, [Effect(name, place, moved)], combinations=COMBINATIONS[:1]), tmp_path)
    recordings = read_recordings(tmp_path)[1]
    stage, _ = choose_observation(recordings, Observation.neutral(recordings[0].body))
    assert [(n.effect.name, n.effect.place) for n in stage.named] == [(name, place)]
    assert not stage.rivals
    assert stage.settled
    for parameter, true in moved.items():
        low, high = stage.named[0].intervals[parameter]
        assert low is not None
        assert high is not None
        assert low < true < high


@pytest.mark.parametrize(
    "places", [pytest.param((4,), marks=pytest.mark.slow), pytest.param((11,), marks=pytest.mark.slow), (3, 4, 5)]
)
def test_markers_that_sway_with_the_bend_are_named_as_such(places: tuple[int, ...], tmp_path: Path) -> None:
    """Each was a pair of offsets against one another, on the link behind and on that ahead; at the head a load."""
    sway = -6e-3
    hidden = [Effect("marker_sway", place, {"sway": sway}) for place in places]
    write(make(66, hidden, combinations=COMBINATIONS[:1]), tmp_path)
    recordings = read_recordings(tmp_path)[1]
    stage, _ = choose_observation(recordings, Observation.neutral(recordings[0].body))
    assert {n.effect.key for n in stage.named} == {("marker_sway", place) for place in places}
    assert stage.settled
    for named in stage.named:
        low, high = named.intervals["sway"]
        assert low is not None
        assert high is not None
        assert low < sway < high
        assert not named.stand_in


def test_a_marker_that_rides_on_both_links_at_once_follows_no_law_of_the_catalogue(tmp_path: Path) -> None:
    half = {"along": 4e-3, "left": 3e-3}
    hidden = [Effect(name, 4, half) for name in ("marker_offset", "marker_offset_ahead")]
    write(make(66, hidden, combinations=COMBINATIONS[:1]), tmp_path)
    recordings = read_recordings(tmp_path)[1]
    stage, _ = choose_observation(recordings, Observation.neutral(recordings[0].body))
    assert {n.effect.key for n in stage.named} == {(e.name, e.place) for e in hidden}
    assert all(n.stand_in for n in stage.named)
    assert [w for w in stage.words if "vertex 4 rides on neither link" in w]


@pytest.mark.parametrize("begun", [-0.065, -0.02, 0.03, 0.065])
def test_where_a_link_lies_in_its_gap_at_the_start_is_read_off_the_markers(readings: np.ndarray, begun: float) -> None:
    gap, noise = 0.13, 0.004
    still = np.concatenate([np.repeat(readings[:1, 1], 40), readings[:, 1]])
    link, _ = across(still, gap, begun)
    shown = link + np.random.default_rng(8).normal(0, noise, len(link))
    shown[3:20] = np.nan
    # the mean of some twenty angles, and a fortieth of the gap
    assert lying(still, shown, gap) == pytest.approx(begun, abs=3 * noise / np.sqrt(23) + gap / 40)
    assert lying(still, np.full(len(still), np.nan), gap) == 0.0
    assert abs(lying(still, shown, 1e-4)) < 1e-4 / 2  # a gap that noise does not tell about


def test_a_loose_joint_that_lay_against_its_stop_is_named_with_its_width(tmp_path: Path) -> None:
    loose = ActiveEffect.of("loose_joint", 5, width=0.12)
    write(make(66, [], combinations=COMBINATIONS[:1]), tmp_path)
    recordings, off = read_recordings(tmp_path)[1], np.random.default_rng(2).choice([-0.06, 0.06], 3)
    at = 4

    def loosened(r: Recording, begun: float) -> Recording:
        bent = r.angles.copy()
        bent[:, at] = across(bent[:, at], 0.12, begun)[0]
        pose, _ = register(shapes(r.body, r.angles), r.markers)
        return replace(r, markers=r.markers + turn(pose[:, None, 2], shapes(r.body, bent) - shapes(r.body, r.angles)))

    known = [loosened(r, begun) for r, begun in zip(recordings, off, strict=False)]
    stage, seen = choose_observation(known, Observation.neutral(known[0].body))
    assert [n.effect.key for n in stage.named] == [loose.key]
    assert stage.settled
    low, high = stage.named[0].intervals["width"]
    assert low is not None
    assert high is not None
    assert low < 0.12 < high
    step = observation_step(known, seen).error  # beside the noise, not beside another history of the gap
    assert step.before > 3 * step.noise_level
    assert step.after == pytest.approx(step.noise_level, rel=0.1)
