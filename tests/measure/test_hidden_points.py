"""Frames that hide a point of an animal: it has two places that links allow, and time knows which."""

import numpy as np
import pytest

from serpenoid.measure.load import load_campaign
from serpenoid.measure.shapes.links import link_directions
from specimens import animal_campaign
from swimmers_by_curves import Curve

FRAMES, BEATS, NOISE = 240, 8, 0.001


@pytest.mark.parametrize("seed", range(4))
def test_a_hidden_point_is_on_the_side_that_its_neighbours_in_time_show(tmp_path, seed):
    """Of five points the others of a frame hardly know: where they alone were asked its mirror image was as good, and
    the body seemed to jump."""
    _, points, mean = Curve(ratio=3.0, waves=0.6, amplitude=0.9, turn=0.4).film(5, FRAMES, BEATS)
    rng = np.random.default_rng(seed)
    seen = points + NOISE * rng.normal(size=points.shape)
    hidden = rng.random(seen.shape[:2]) < 0.05
    hidden[:, [0, -1]] = hidden[[0, -1]] = False  # what lies between others has a mirror image, and frames beside it
    hidden &= hidden.cumsum(axis=1) == 1  # one a frame
    seen[hidden] = np.nan
    (trial,) = load_campaign(animal_campaign(tmp_path, "a", np.arange(FRAMES) / 24, 100 * seen, "mm")).trials
    motion = trial.motion
    assert not motion.jumps
    shown = link_directions(trial.body, motion.poses, motion.joint_angles)[:, 2:]
    off = np.abs((shown - mean + np.pi) % (2 * np.pi) - np.pi)[hidden.any(axis=1)]
    assert off.max() < 0.1  # a mirror image turns a link by twice what the body bends there


def test_a_film_may_begin_unseen_between_two_frames_that_are_nearly_one(tmp_path):
    """Of times that are uneven: no line leads back from a frame that was taken at almost the same moment."""
    time = np.concatenate([[0.0, 0.004, 0.008], 0.04 * np.arange(1, 120)])
    arc = np.linspace(0, 1, 200)
    angle = 0.8 * np.sin(2 * np.pi * (time[:, None] + 1.2 * arc))
    steps = np.stack([np.cos(angle), np.sin(angle)], axis=2) / 200
    points = np.cumsum(steps, axis=1)[:, np.linspace(0, 199, 11).astype(int)]
    points[..., 0] += 0.1 * time[:, None]
    points += np.random.default_rng(1).normal(0, 0.002, points.shape)
    points[:2, [4, 5]] = np.nan
    motion = load_campaign(animal_campaign(tmp_path, "a", time, points, "m")).trials[0].motion
    assert motion.known[3:].all()
