"""Places on the floor that are asked about: all that something came near, however far apart they are."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from serpenoid.diagnose.inference.search.scans import on_offer

STEPS, BODY = 60, np.column_stack([np.linspace(-0.45, 0.45, 12), np.zeros(12)])


def track(begin: tuple[float, float]) -> SimpleNamespace:
    """A straight body of 0.9 m that goes 0.5 m along x from `begin`."""
    poses = np.column_stack([begin[0] + np.linspace(0, 0.5, STEPS), np.full(STEPS, begin[1]), np.zeros(STEPS)])
    body = SimpleNamespace(total_length_m=0.9)
    vertices = np.broadcast_to(BODY, (STEPS, 12, 2))
    return SimpleNamespace(
        poses=poses,
        on_floor=poses,
        vertices=vertices,
        boundaries=np.arange(0, STEPS, 10),
        recording=SimpleNamespace(body=body),
    )


def offered(*begins: tuple[float, float]):
    motion = SimpleNamespace(tracks=[track(b) for b in begins], untestable=frozenset())
    return on_offer(motion, SimpleNamespace(effects=()))


def test_trials_far_apart_ask_about_the_floor_below_them_and_not_between():
    """Two animals in one dish, 20 lengths apart: the floor between them is a hundred times as large as theirs."""
    grids = offered((0.0, 0.0), (18.0, 18.0))
    asked = [candidate for grid in grids for candidate in grid.candidates]
    assert 100 < len(asked) < 0.02 * sum(len(grid.grid.values) for grid in grids)
    for candidate in asked:
        values = candidate.parameters
        away = min(
            np.hypot(max(x0 - 0.45 - values["x"], values["x"] - x0 - 0.95, 0.0), values["y"] - y0)
            for x0, y0 in ((0.0, 0.0), (18.0, 18.0))
        )
        assert away < 4 * values["radius"]


def test_where_one_body_went_every_size_is_asked_about():
    for grid in offered((0.0, 0.0)):
        radius = grid.grid.values[0]["radius"]
        for x in np.linspace(0.0, 0.5, 11):
            assert min(np.hypot(c.parameters["x"] - x, c.parameters["y"]) for c in grid.candidates) < 1.1 * radius
