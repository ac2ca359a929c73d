"""Joints that give way in proportion to the torque of drag are told from others that give way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.inference.doubt.law_error import LAW_ERROR
from serpenoid.diagnose.inference.fits.finding import Stage
from serpenoid.diagnose.stages.motion.refuted import by_markers, shapes_believed
from serpenoid.diagnose.stages.observation.beyond_readings import beyond
from serpenoid.diagnose.stages.observation.elastic import elastic, torques

JOINT = 7  # from 0
YIELDED = 0.08  # rad, RMS


def torque_by_hand(r):
    """About the joint, of the robot's own law, from where the markers of the head's side go in a tenth of a second."""
    step = max(round(0.05 / r.frame_s), 1)
    x = r.markers
    speed = np.full_like(x, np.nan)
    speed[step:-step] = (x[2 * step :] - x[: -2 * step]) / (2 * step * r.frame_s)
    eps, weights = 0.2, r.body.vertex_weights
    vertex = r.body.joint_vertices[JOINT]
    total = np.zeros(len(x))
    for v in range(vertex + 1, r.body.vertices):
        ahead = x[:, min(v + 1, r.body.vertices - 1)] - x[:, v]
        behind = x[:, v] - x[:, v - 1]
        edges = [e / np.linalg.norm(e, axis=1, keepdims=True) for e in (ahead, behind) if np.abs(e[0]).max() > 0]
        t = np.sum(edges, axis=0)
        t /= np.linalg.norm(t, axis=1, keepdims=True)
        along = (speed[:, v] * t).sum(axis=1, keepdims=True) * t
        force = -weights[v] * (speed[:, v] - (1 - eps) * along)
        arm = x[:, v] - x[:, vertex]
        total += arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]
    known = np.isfinite(total)
    return np.interp(r.time, r.time[known], total[known])


def given_way(recordings, beyond):
    """Recordings whose servo reads less than its joint is bent by, by YIELDED in the mean of squares."""
    amounts = [beyond(r) for r in recordings]
    size = YIELDED / max(np.sqrt(np.mean(np.concatenate(amounts) ** 2)), 1e-12)

    def read(r, amount):
        position = r.position.copy()
        position[:, JOINT] -= size * np.interp(r.read_at, r.time, amount)
        return replace(r, position=position)

    return [read(r, amount) for r, amount in zip(recordings, amounts, strict=True)]


def of(recordings):
    seen = Observation.neutral(recordings[0].body)
    trials = [beyond(r, seen) for r in recordings]
    return elastic(trials, by_markers(trials, seen, [JOINT]).recordings, seen, [JOINT])


def test_a_joint_that_gives_way_in_proportion_to_the_torque_is_elastic(healthy):
    recordings, _ = healthy
    ((joint, share),) = of(given_way(recordings, torque_by_hand))
    assert joint == JOINT
    assert share < LAW_ERROR / 2


def against(r):
    return -torque_by_hand(r)


def unlike(r):
    return np.sin(2 * np.pi * r.time / r.schedule.cycle_duration_s + 1.0)


def crept(r):
    return np.clip(r.time / r.end, 0.0, 1.0)


def nothing(r):
    return np.zeros(len(r.time))


@pytest.mark.parametrize("beyond", [against, unlike, crept, nothing])
def test_what_does_otherwise_is_not(healthy, beyond):
    recordings, _ = healthy
    assert not of(given_way(recordings, beyond))


def test_the_torques_on_both_sides_of_a_joint_are_one_wherever_it_is(healthy):
    """Of what drags on the whole body nothing is left, so the shorter side may be taken."""
    recordings, _ = healthy
    r = recordings[0]
    seen = Observation.neutral(r.body)
    mine = torques(r, seen)[:, JOINT] @ [1.0, 0.2]
    by_hand = torque_by_hand(r)
    inside = (r.time > 0.2) & (r.time < r.end - 0.2) & np.isfinite(mine)
    assert np.corrcoef(mine[inside], by_hand[inside])[0, 1] > 0.95


def test_the_answer_says_that_it_is_elastic(healthy):
    recordings, known = healthy
    joints = recordings[0].body.joint_count
    squares = [9.0 if j == JOINT else 0.0 for j in range(joints)]
    stage = Stage("observation", words=("markers do not show it",), squares=(*squares, 1.0))
    given = given_way(recordings, torque_by_hand)
    found = shapes_believed(given, Observation.neutral(recordings[0].body), stage, known)
    assert f"joint {JOINT + 1} gives way in proportion to the torque" in found.words
    assert not found.named
