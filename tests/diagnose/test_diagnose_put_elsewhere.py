"""Robots that are put elsewhere between their cycles, seen or unseen; tracks that are lost, and bodies that rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, make
from blind.folder import write
from serpenoid.diagnose.data.recordings.put_elsewhere import puts_of, with_puts
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.shapes.geometry import placed, register, shapes
from serpenoid.diagnose.diagnose import diagnose
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.start import baseline

MIDDLE = 0.5  # of a pause


@pytest.fixture(scope="module")
def laid(tmp_path_factory: pytest.TempPathFactory) -> tuple[Recording, ...]:
    folder = tmp_path_factory.mktemp("laid")
    write(make(71, [], combinations=COMBINATIONS[:2]), folder)
    return read_recordings(folder)[1]


def moved(r: Recording, cycle: int, by: Sequence[float], takes_s: float = 0.2, hidden: bool = False) -> Recording:
    """With its markers carried by a pose (3,) about the origin of the floor in the pause after a cycle."""
    s = r.schedule
    when = cycle * s.period_s + s.cycle_duration_s + MIDDLE * s.pause_s
    share = np.clip((r.time - when) / takes_s + 0.5, 0.0, 1.0)
    markers = placed(r.markers, share[:, None] * np.array(by))
    if hidden:
        markers[(share > 0) & (share < 1)] = np.nan
    return replace(r, markers=markers)


@pytest.mark.parametrize(("hidden", "takes_s"), [(False, 0.01), (False, 0.5), (True, 0.4)])
def test_what_follows_is_laid_where_the_body_was(laid: tuple[Recording, ...], hidden: bool, takes_s: float) -> None:
    r = laid[0]
    (again,) = with_puts([moved(moved(r, 0, (0.2, -0.1, 0.4), takes_s, hidden), 1, (-0.3, 0.0, -0.2), takes_s, hidden)])
    poses = register(shapes(r.body, r.angles), again.markers)[0]
    puts = puts_of(again, poses)
    assert puts.cycles == (0, 1)
    assert "after cycles 1 and 2 it was put elsewhere" in again.remarks[-1].words
    back, true = puts.laid_back(r.time, poses), register(shapes(r.body, r.angles), r.markers)[0]
    inside = (r.time > 0) & (r.time < r.end)
    known = inside & np.isfinite(back[:, 0])
    assert known.sum() > 0.8 * inside.sum()
    assert np.abs(back - true)[known, :2].max() < 30 * r.marker_noise
    np.testing.assert_allclose((back - puts.away(r.time, back))[known], poses[known], atol=1e-9)


@pytest.mark.parametrize("by", [(0.0, 0.0, 0.0), (0.3, 0.0, 0.0)])
def test_bodies_that_rest_and_tracks_that_are_lost_are_not_carried(laid: tuple[Recording, ...], by) -> None:
    again = with_puts([moved(r, 0, by, 0.2, hidden=any(by)) for r in laid])
    assert not any(puts_of(r).cycles for r in again)
    assert not any("put elsewhere" in remark.words for r in again for remark in r.remarks)


@pytest.mark.parametrize("every", [15, 30, 60])
def test_films_of_few_frames_a_second_show_it_or_do_not(laid: tuple[Recording, ...], every: int) -> None:
    def few(r: Recording) -> Recording:
        return replace(r, time=r.time[::every], markers=r.markers[::every])

    assert not any(puts_of(few(r)).cycles for r in laid)
    assert puts_of(few(moved(laid[0], 0, (0.2, -0.1, 0.4)))).cycles == (0,)


def test_beside_a_gap_that_turned_it_others_carried_it_too(laid: tuple[Recording, ...]) -> None:
    once = moved(laid[0], 0, (0.1, 0.0, 0.5), 0.3, hidden=True)
    little = moved(laid[1], 1, (0.01, 0.0, 0.0), 0.3, hidden=True)
    assert [puts_of(r).cycles for r in with_puts([once, little])] == [(0,), (1,)]


def test_a_push_while_it_plays_is_no_hand_that_lays_it(laid: tuple[Recording, ...]) -> None:
    r = laid[0]
    share = np.clip((r.time - 0.5 * r.schedule.cycle_duration_s) / 0.2, 0.0, 1.0)
    pushed = replace(r, markers=placed(r.markers, share[:, None] * np.array([0.1, 0.0, 0.0])))
    assert puts_of(pushed).cycles == ()


@pytest.mark.slow
@pytest.mark.parametrize("hidden", [False, True])
def test_a_healthy_robot_that_is_put_elsewhere_in_every_pause_is_healthy(hidden: bool, tmp_path: Path) -> None:
    write(make(71, [], combinations=COMBINATIONS[:2]), tmp_path)
    file, recordings = read_recordings(tmp_path)
    rng = np.random.default_rng(1)
    every = []
    for r in recordings:
        for cycle in range(r.schedule.cycles - 1):
            r = moved(r, cycle, rng.uniform([-0.2, -0.2, -0.5], [0.2, 0.2, 0.5]), 0.3, hidden)
        every.append(r)
    still, carried = (
        diagnose(some, Baseline(baseline(None, file, file.body)), lambda text: None)
        for some in (recordings, with_puts(every))
    )
    assert carried.verdict == still.verdict == "nothing"
    assert carried.extension.model.medium.anisotropy_ratio == pytest.approx(
        still.extension.model.medium.anisotropy_ratio, rel=0.01
    )
    assert carried.stages[2].left < 1.5
