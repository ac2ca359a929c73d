"""A marker beside its joint is known by the lengths of links, without a servo log; links of other lengths are none."""

from __future__ import annotations

import re
from types import SimpleNamespace

import numpy as np
import pytest

from serpenoid.body import Body
from serpenoid.diagnose.data.shapes.geometry import placed, shapes
from serpenoid.diagnose.stages.actuation.choose_actuation import _unlike
from serpenoid.diagnose.stages.actuation.displaced_markers import displaced_marker

EDGES = (0.08, 0.1, 0.1, 0.11, 0.1, 0.08)
FRAMES, NOISE = 600, 1e-3


def filmed(joint: int = 0, along: float = 0.0, across: float = 0.0, ahead: bool = False, edges=EDGES, scale=1.0):
    """A trial of a body whose links are as EDGES, filmed with noise; the marker at a joint (1 .. m) fixed beside it to
    the link behind it or ahead; edges: what is stated."""
    rng = np.random.default_rng(3)
    phase = 2 * np.pi * (np.arange(FRAMES)[:, None] / 120 - np.arange(5) / 5)
    true = Body(vertices=7, edge_lengths=EDGES)
    poses = np.stack([np.linspace(0, 0.3, FRAMES), np.zeros(FRAMES), np.linspace(0, 1, FRAMES)], axis=1)
    points = placed(shapes(true, 0.6 * np.sin(phase)), poses)
    if joint:
        link = points[:, joint + 1] - points[:, joint] if ahead else points[:, joint] - points[:, joint - 1]
        unit = link / np.linalg.norm(link, axis=1, keepdims=True)
        points[:, joint] += along * unit + across * np.stack([-unit[:, 1], unit[:, 0]], axis=1)
    body = Body(vertices=7, edge_lengths=tuple(edges))
    return SimpleNamespace(body=body, markers=scale * points + rng.normal(0, NOISE, points.shape), by_servos=False)


@pytest.mark.parametrize(("along", "across"), [(0.006, 0.004), (0.0, 0.008), (-0.006, 0.0)])
@pytest.mark.parametrize("ahead", [False, True])
def test_a_displaced_marker_is_found_with_its_distance_from_joints_beside_it_too(along, across, ahead):
    trial = filmed(3, along, across, ahead, scale=1.004)
    for joint in (2, 3, 4):
        found = displaced_marker([trial], joint)
        assert found.joint == 3
        assert found.distance_m == pytest.approx(np.hypot(along, across), abs=5e-4)  # noise and the scale


def test_nothing_is_found_where_nothing_is_hidden():
    assert [displaced_marker([filmed()], joint) for joint in range(1, 6)] == [None] * 5
    assert displaced_marker([filmed(3, 3e-4)], 3) is None  # less than noise
    assert displaced_marker([filmed(1, 0.006)], 4) is None  # not what this joint is shown by


def test_links_of_other_lengths_are_no_displaced_marker():
    stated = np.array(EDGES) + [0.0, 0.004, 0.003, -0.006, 0.0, 0.002]
    assert [displaced_marker([filmed(edges=stated)], joint) for joint in range(1, 6)] == [None] * 5


def test_then_no_servo_is_accused():
    trial = filmed(3, 0.006, 0.004)
    said = _unlike(SimpleNamespace(data=SimpleNamespace(recordings=(trial,))), 2, 2.5)
    assert said.startswith("the bend that markers show at joint 3 is off its command by 2.5 times its noise, and no")
    assert re.search(r"the marker at joint 3 is 7\.[0-4] mm beside its place$", said)
    found = displaced_marker([trial], 3)
    assert [found.beside(joint) for joint in range(1, 6)] == [False, True, True, True, False]
    assert re.match(r"the marker at joint 3 is 7\.[0-4] mm beside its place: put it right, or log", found.remedy)
