"""Edges of other lengths than told are told apart from markers beside their places."""

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
from serpenoid.diagnose.data.observation import Observation
from serpenoid.diagnose.data.reading import read_recordings
from serpenoid.diagnose.inference.finding import Stage
from serpenoid.diagnose.stages.choose_observation import choose_observation

RULER = 0.012  # of a length: what it is told wrong by
COUNT = SNAKE10.vertices


def seen(folder: Path, hidden: list[Effect], told: np.ndarray | None = None, protocol: Protocol | None = None) -> Stage:
    """The stage of observation of a campaign whose edges are told as they are, or otherwise."""
    write(make(3, hidden, "short", COMBINATIONS[:2], protocol=protocol), folder)
    if told is not None:
        toml = folder / "campaign.toml"
        lengths = f"edge_lengths = [{', '.join(f'{e:.6f}' for e in told)}]"
        toml.write_text(re.sub(r"edge_lengths = .*", lengths, toml.read_text()))
    recordings = read_recordings(folder)[1]
    return choose_observation(recordings, Observation.neutral(recordings[0].body))[0]


def test_lengths_that_are_told_wrong_are_found_and_offsets_are_said_to_stand_for_them(tmp_path: Path) -> None:
    off = np.exp(RULER * np.random.default_rng(1).normal(size=len(SNAKE10.edges)))
    stage = seen(tmp_path / "short", [], SNAKE10.edges * off)
    assert stage.named
    assert all(n.stand_in for n in stage.named)
    assert any("edges of other lengths than told" in w for w in stage.words)
    said = stage.mend
    assert "mend `edge_lengths`" in said
    found = np.array([float(x) for x in re.findall(r"[\d.]+", said[said.index("[") : said.index("]")])])
    np.testing.assert_allclose(found, 1e3 * SNAKE10.edges, atol=0.1)  # mm; the ruler is off by a millimetre


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
        [Effect("marker_offset", 4, {"along": 4e-3, "left": 0.0})],
        [Effect("marker_offset", 4, {"along": 3e-3, "left": 2e-3}), Effect("length_scale", None, {"error": 0.02})],
    ],
)
def test_markers_beside_their_places_and_a_scale_are_what_they_are(tmp_path: Path, hidden: list[Effect]) -> None:
    stage = seen(tmp_path / "short", hidden)
    assert {n.effect.name for n in stage.named} == {e.name for e in hidden}
    assert not any(n.stand_in for n in stage.named)
    assert stage.settled, stage.words


def test_all_markers_may_be_to_one_side(tmp_path: Path) -> None:
    hidden = [Effect("marker_offset", k, {"along": 0.0, "left": 4e-3}) for k in range(COUNT)]
    stage = seen(tmp_path / "short", hidden)
    assert {n.effect.key for n in stage.named} == {("marker_offset", k) for k in range(COUNT)}
    np.testing.assert_allclose([n.effect.parameters["left"] for n in stage.named], 4e-3, atol=2e-4)
    assert stage.settled, stage.words
