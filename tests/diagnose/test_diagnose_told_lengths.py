"""Edges of other lengths than told, markers beside their places and a stretched camera are told apart."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, make
from blind.catalogue import Effect
from blind.folder import write
from blind.protocol import Protocol
from blind.random_protocols import draw_protocol
from blind.snake import SNAKE10
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.inference.fits.finding import Named, Stage
from serpenoid.diagnose.stages.observation.choose_observation import choose_observation

RULER = 0.012  # of a length: what it is told wrong by
COUNT = SNAKE10.vertices


def seen(
    folder: Path,
    hidden: list[Effect],
    told: np.ndarray | None = None,
    protocol: Protocol | None = None,
    *,
    camera: np.ndarray | None = None,
    middles: bool = False,
    gaits: int = 1,
) -> Stage:
    """The stage of observation of a campaign whose edges are told as they are, or otherwise; camera (2, 2): what it
    makes of places on the floor; middles: whether edges have vertices in their middles."""
    made = make(3, hidden, "short", COMBINATIONS[:gaits], protocol=protocol)
    if camera is not None:
        films = [replace(t.film, markers=t.film.markers @ camera.T) for t in made.trials]
        made = replace(made, trials=tuple(replace(t, film=f) for t, f in zip(made.trials, films, strict=True)))
    write(made, folder)
    if told is not None:
        toml = folder / "campaign.toml"
        lengths = f"edge_lengths = [{', '.join(f'{e:.6f}' for e in told)}]"
        toml.write_text(re.sub(r"edge_lengths = .*", lengths, toml.read_text()))
    recordings = read_recordings(folder)[1]
    if middles:
        recordings = tuple(r.with_middles() for r in recordings)
    return choose_observation(recordings, Observation.neutral(recordings[0].body))[0]


@pytest.mark.slow
def test_lengths_that_are_told_wrong_are_found_and_offsets_are_said_to_stand_for_them(tmp_path: Path) -> None:
    off = np.exp(RULER * np.random.default_rng(1).normal(size=len(SNAKE10.edges)))
    stage = seen(tmp_path / "short", [], SNAKE10.edges * off)
    assert stage.named
    assert all(n.stand_in for n in stage.named)
    assert any("edges of other lengths than told" in w for w in stage.words)
    said = stage.mend
    assert "mend `edge_lengths`" in said
    told = re.findall(r"entry (\d+) is ([\d.]+) mm, not ([\d.]+)", said)
    assert {int(k) for k, *_ in told} >= {k + 1 for k in np.flatnonzero(np.abs(off - 1) > 0.005)}
    for k, shown, stated in told:
        assert float(shown) == pytest.approx(1e3 * SNAKE10.edges[int(k) - 1], abs=0.1)  # a ruler's millimetre is more
        assert float(stated) == pytest.approx(1e3 * (SNAKE10.edges * off)[int(k) - 1], abs=0.06)


@pytest.mark.slow
def test_lengths_that_are_told_from_head_to_tail_are_said_to_be(tmp_path: Path) -> None:
    drawn = draw_protocol(29)  # three joints, played twice, with a log
    edges = 0.15 * np.linspace(0.95, 1.05, 4)
    protocol = replace(drawn, robot=replace(drawn.robot, edges=edges))
    stage = seen(tmp_path / "short", [], edges[::-1], protocol)
    assert any("read from head to tail" in w for w in stage.words)
    assert "turn them round" in stage.mend


@pytest.mark.parametrize(
    "hidden",
    [
        pytest.param([Effect("marker_offset", 4, {"along": 4e-3, "left": 0.0})], marks=pytest.mark.slow),
        [Effect("marker_offset", 4, {"along": 3e-3, "left": 2e-3}), Effect("length_scale", None, {"error": 0.02})],
    ],
)
def test_markers_beside_their_places_and_a_scale_are_what_they_are(tmp_path: Path, hidden: list[Effect]) -> None:
    stage = seen(tmp_path / "short", hidden)
    assert {n.effect.name for n in stage.named} == {e.name for e in hidden}
    assert not any(n.stand_in for n in stage.named)
    assert stage.settled, stage.words


@pytest.mark.slow
def test_all_markers_may_be_to_one_side(tmp_path: Path) -> None:
    hidden = [Effect("marker_offset", k, {"along": 0.0, "left": 4e-3}) for k in range(COUNT)]
    stage = seen(tmp_path / "short", hidden, gaits=2)
    assert {n.effect.key for n in stage.named} == {("marker_offset", k) for k in range(COUNT)}
    np.testing.assert_allclose([n.effect.parameters["left"] for n in stage.named], 4e-3, atol=2e-4)
    assert stage.settled, stage.words


STRETCH = np.array([[0.006, 0.004], [0.004, -0.002]])  # by 2 mm a metre everywhere, by 4 along x, by 4 along 45 degrees


@pytest.mark.slow
def test_a_stretched_camera_is_no_wrong_links(tmp_path: Path) -> None:
    stage = seen(tmp_path / "short", [], camera=np.eye(2) + STRETCH, gaits=2)
    found = {n.effect.name: n for n in stage.named}
    assert set(found) == {"camera_stretch", "length_scale"}
    _holds(found["camera_stretch"], longer=0.008 / 1.002, shear=0.008 / 1.002)
    _holds(found["length_scale"], error=0.002)
    assert not any(n.stand_in for n in stage.named)
    assert not stage.rivals
    assert stage.settled, stage.words


def _holds(named: Named, **true: float) -> None:
    for parameter, value in true.items():
        low, high = named.intervals[parameter]
        assert low is not None
        assert high is not None
        assert low < value < high
        assert high - low < 1e-3


@pytest.mark.slow
def test_an_axis_that_is_too_long_is_told_by_half_a_scale_beside_it(tmp_path: Path) -> None:
    stage = seen(tmp_path / "short", [], protocol=draw_protocol(29), camera=np.diag([1.01, 1.0]))
    found = {n.effect.name: n.effect.parameters for n in stage.named}
    assert set(found) == {"camera_stretch", "length_scale"}
    assert found["camera_stretch"]["longer"] == pytest.approx(0.01, abs=5e-4)
    assert found["length_scale"]["error"] == pytest.approx(0.005, abs=5e-4)
    assert stage.settled, stage.words


def test_no_camera_is_stretched_that_sees_all_directions_alike(tmp_path: Path) -> None:
    stage = seen(tmp_path / "short", [], camera=1.01 * np.eye(2))
    assert [n.effect.name for n in stage.named] == ["length_scale"]


@pytest.mark.slow
def test_perspective_is_no_stretched_camera(tmp_path: Path) -> None:
    """What a stretch takes away of it is less than what it leaves."""
    made = make(3, [], "short", COMBINATIONS[:2])
    films = [replace(t.film, markers=t.film.markers * (1 + 0.1 * t.film.markers[..., 1:])) for t in made.trials]
    write(replace(made, trials=tuple(replace(t, film=f) for t, f in zip(made.trials, films, strict=True))), tmp_path)
    recordings = read_recordings(tmp_path)[1]
    stage, _ = choose_observation(recordings, Observation.neutral(recordings[0].body))
    assert not any(n.effect.effect.marks == "axes" and not n.stand_in for n in stage.named)
    assert not stage.settled


@pytest.mark.slow  # each by itself: above and below
def test_a_stretched_camera_and_a_wrong_link_are_told_as_both(tmp_path: Path) -> None:
    off = np.where(np.arange(len(SNAKE10.edges)) == 2, 1.03, 1.0)
    stage = seen(tmp_path / "short", [], SNAKE10.edges * off, camera=np.diag([1.01, 1.0]), gaits=2)
    sure = {n.effect.name: n for n in stage.named if not n.stand_in}
    assert set(sure) == {"camera_stretch", "length_scale"}
    _holds(sure["camera_stretch"], longer=0.01 / 1.005, shear=0.0)
    _holds(sure["length_scale"], error=0.005)
    told = re.findall(r"entry (\d+) is [\d.]+ mm, not [\d.]+ \(([-+][\d.]+) %\)", stage.mend)
    assert told == [("3", "-2.9")], stage.mend
    assert "the others are as told" in stage.mend


@pytest.mark.slow
@pytest.mark.parametrize("middles", [False, True])
def test_the_one_edge_that_differs_is_told_of_those_that_are_written(tmp_path: Path, middles: bool) -> None:
    """Not the whole list, nor halves of edges where drag sits in their middles."""
    protocol = draw_protocol(29)
    off = np.where(np.arange(len(protocol.robot.edges)) == 2, 1.03, 1.0)
    stage = seen(tmp_path / "short", [], protocol.robot.edges * off, protocol, middles=middles)
    told = re.findall(r"entry (\d+) is [\d.]+ mm, not [\d.]+ \(([-+][\d.]+) %\)", stage.mend)
    assert [k for k, _ in told] == ["3"], stage.mend
    assert float(told[0][1]) == pytest.approx(100 / 1.03 - 100, abs=0.1)
    assert "the others are as told" in stage.mend
