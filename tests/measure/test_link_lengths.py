"""Lengths between markers with a joint between them are known where a servo log says how the joint turns."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from serpenoid.body import Body
from serpenoid.measure.link_lengths import hidden_lengths
from serpenoid.measure.shapes.links import chain_vertices

EDGES = [0.055, 0.055, 0.065, 0.065, 0.05, 0.05, 0.075, 0.075, 0.06, 0.06, 0.07, 0.07]
MIDDLES = [0, 1, 3, 5, 7, 9, 11, 12]
JOINTS = (2, 4, 6, 8, 10)
NOISE = 0.0004  # m


def robot(edges: list[float]) -> Body:
    return Body(vertices=13, joints=JOINTS, edge_lengths=tuple(edges))


def trials(edges: list[float], told: Body, seed: int = 0, zeros: float = 0.03, size: float = 0.6) -> list:
    """Two films of a robot of these edges, in lengths of the body that is told, beside what its servos read."""
    true, rng, made = robot(edges), np.random.default_rng(seed), []
    for gait in (1.1, -0.7):
        angles = size * np.sin(np.linspace(0, 15, 300)[:, None] + gait * np.arange(5))
        poses = np.stack([np.linspace(0, 0.5, 300), np.zeros(300), np.linspace(0, 1, 300)], axis=1)
        points = true.total_length_m * chain_vertices(true, poses, angles + rng.normal(0, zeros, 5))
        markers = np.full_like(points, np.nan)
        markers[:, MIDDLES] = points[:, MIDDLES] + rng.normal(0, NOISE, (300, len(MIDDLES), 2))
        markers[rng.random((300, 13)) < 0.02] = np.nan
        read = angles + rng.normal(0, 0.005, angles.shape)
        made.append(
            SimpleNamespace(
                motion=SimpleNamespace(markers=markers / told.total_length_m),
                servo=SimpleNamespace(angles=read),
                servo_log=object(),
            )
        )
    return made


@pytest.mark.parametrize("link", range(1, 5))
@pytest.mark.parametrize("off", [0.01, -0.005])
def test_a_link_that_is_told_wrong_is_said_with_both_lengths(link, off):
    told = EDGES.copy()
    told[2 * link] += off
    told[2 * link + 1] += off
    said = hidden_lengths(robot(told), trials(EDGES, robot(told)))
    true = EDGES[2 * link] + EDGES[2 * link + 1]
    assert f"from vertex {2 * link} to vertex {2 * link + 2}" in said
    assert f"`edge_lengths` says {true + 2 * off:.4g}" in said
    assert float(said.split(" show ")[1].split(" m ")[0]) == pytest.approx(true, abs=abs(off) / 5)


@pytest.mark.parametrize("seed", range(10))
def test_nothing_is_said_of_a_body_that_is_as_told(seed):
    assert hidden_lengths(robot(EDGES), trials(EDGES, robot(EDGES), seed)) == ""


def test_joints_that_hardly_turn_say_nothing_of_links():
    told = [edge + 0.01 * (k in (6, 7)) for k, edge in enumerate(EDGES)]
    assert hidden_lengths(robot(told), trials(EDGES, robot(told), size=0.0)) == ""


def test_where_markers_show_the_joints_or_no_log_is_there_it_is_not_asked():
    told = robot([edge + 0.01 * (k in (6, 7)) for k, edge in enumerate(EDGES)])
    films = trials(EDGES, told)
    for film in films:
        film.servo_log = None
    assert hidden_lengths(told, films) == ""
