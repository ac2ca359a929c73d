"""A tracked point beside an animal's midline is told by the bends that it makes, and smooth postures make none."""

from __future__ import annotations

import numpy as np
import pytest

from serpenoid.measure.animals.beside_midline import beside_midline, said

EDGES = np.array([0.08, 0.12, 0.1, 0.09, 0.11, 0.13, 0.07, 0.1, 0.1, 0.1])
FRAMES, SWING, SCATTER = 200, 0.4, 0.03


def bends(rng: np.random.Generator, held: float = 0.0, along: float = 0.0) -> np.ndarray:
    """Of a body that beats about a posture whose curvature is `held` in the middle and changes by `along`."""
    over, arcs = (EDGES[1:] + EDGES[:-1]) / 2, np.cumsum(EDGES)[:-1]
    phases = 2 * np.pi * (np.arange(FRAMES)[:, None] / 23 - 1.2 * arcs)
    posture = over * (held + along * (arcs - 0.5))
    return np.asarray(posture + SWING * np.sin(phases) + rng.normal(0, SCATTER, (FRAMES, len(over))))


def shown(seen: np.ndarray, vertex: int, left: float) -> np.ndarray:
    """The same bends where one point is seen beside the midline: of the points themselves."""
    directions = np.cumsum(np.column_stack([np.zeros(len(seen)), seen]), axis=1)
    steps = EDGES[:, None] * np.stack([np.cos(directions), np.sin(directions)], axis=2)
    points = np.concatenate([np.zeros((len(seen), 1, 2)), np.cumsum(steps, axis=1)], axis=1)
    along = points[:, vertex + 1] - points[:, vertex - 1]
    along /= np.linalg.norm(along, axis=1)[:, None]
    points[:, vertex] += left * np.stack([-along[:, 1], along[:, 0]], axis=1)
    edges = np.diff(points, axis=1)
    return np.asarray(np.diff(np.unwrap(np.arctan2(edges[..., 1], edges[..., 0]), axis=1), axis=1))


@pytest.mark.parametrize("vertex", [2, 4, 8])
@pytest.mark.parametrize("left", [0.02, -0.04])
def test_a_point_beside_the_midline_is_found_with_its_side_and_size(vertex: int, left: float) -> None:
    """To first order of the angle by which its edges turn, up to 0.5 here; medians of a beating body add scatter."""
    found = beside_midline(EDGES, shown(bends(np.random.default_rng(1), 0.8, 0.5), vertex, left))
    assert found is not None
    assert found.vertex == vertex
    assert found.left == pytest.approx(left, rel=0.25)
    words = said(found, EDGES)
    assert f"point {vertex + 1} from the tail" in words
    assert ("left" if left > 0 else "right") in words


def test_bodies_that_are_held_bent_show_no_point_beside_their_midline() -> None:
    """False alarms at the stated error of 1 %: of 200, no more than 7 but in one of a thousand such tests."""
    rng = np.random.default_rng(2)
    found = [beside_midline(EDGES, bends(rng, *rng.normal(0, 2, 2))) for _ in range(200)]
    assert sum(f is not None for f in found) <= 7


def test_a_head_that_is_held_bent_is_no_point_beside_the_midline() -> None:
    seen = bends(np.random.default_rng(5))
    seen[:, -1] += 0.5
    assert beside_midline(EDGES, seen) is None
    assert beside_midline(EDGES, shown(bends(np.random.default_rng(5)), 9, 0.03)) is None


def test_too_few_points_and_none_that_are_seen_tell_nothing() -> None:
    seen = bends(np.random.default_rng(3))
    assert beside_midline(EDGES[:4], seen[:, :3]) is None
    assert beside_midline(EDGES, np.full_like(seen, np.nan)) is None
