"""Bodies that coast into a pause: steps there are as short as those of the cycle at first, and grow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from serpenoid.body import Body, Floats
from serpenoid.diagnose.data.shapes.geometry import shapes
from serpenoid.diagnose.data.windows.meshes import COARSER, GROWTH, Mesh, mesh_of
from serpenoid.diagnose.data.windows.windows import predicted_path
from serpenoid.effects.active import ActiveEffect
from serpenoid.group import relative
from serpenoid.measure.schedule import Schedule
from serpenoid.medium import Medium
from serpenoid.model import Model

BODY = Body(vertices=5, kind="swimming robot", edge_lengths=[0.34, 0.18, 0.2, 0.18])
MASS, OFF = 0.066, 1.1  # m of added mass over drag; what a guiding model says of it, in proportion
ROWS, FINER = 40, 8  # rows of a table; steps of the exact path in one of the guiding path's
SEEN = 5e-4  # m: what cameras see of a window


@dataclass(frozen=True)
class Trial:
    """What a mesh asks of a recording."""

    schedule: Schedule
    end: float


def trial(cycle_s: float, pause_s: float, cycles: int = 1) -> Trial:
    """A wave along three joints, and a rest in a bend."""
    turn = 2 * np.pi * np.arange(ROWS)[:, None] / ROWS - np.array([0.0, 1.2, 2.4])
    schedule = Schedule(0.6 * np.cos(turn), cycle_s, cycles, pause_s)
    return Trial(schedule, schedule.whole_s)


def steps_of_fits(mesh: Mesh) -> Floats:
    return np.diff(mesh.time[::COARSER])


@pytest.mark.parametrize(("cycle_s", "pause_s"), [(1.5, 2.0), (4.0, 2.0), (4.0, 0.5), (2.0, 20.0)])
def test_steps_grow_from_those_of_the_cycle(cycle_s: float, pause_s: float) -> None:
    mesh = mesh_of(trial(cycle_s, pause_s, cycles=2))  # type: ignore[arg-type]
    steps, first = steps_of_fits(mesh), int(np.searchsorted(mesh.time[::COARSER], cycle_s - 1e-9))
    last = mesh.bounds[np.searchsorted(mesh.time[mesh.bounds], cycle_s + pause_s - 1e-9)] // COARSER
    resting = steps[first:last]
    assert resting[0] <= steps[first - 1] * (1 + 1e-9)
    assert (resting[1:] / resting[:-1] <= GROWTH**2).all()  # steps of a half are made to fill it
    assert resting.sum() == pytest.approx(pause_s)
    assert np.isclose(mesh.time[mesh.bounds], cycle_s + pause_s / 2).any()
    assert (mesh.bounds % COARSER == 0).all()


def test_a_long_pause_takes_few_steps() -> None:
    """Their number grows with the logarithm of the pause."""
    counts = [len(steps_of_fits(mesh_of(trial(2.0, pause_s)))) for pause_s in (2.0, 20.0, 200.0)]  # type: ignore[arg-type]
    assert counts[2] - counts[1] == pytest.approx(counts[1] - counts[0], abs=6)


def swimmer(mass: float) -> Model:
    water = Medium(anisotropy_ratio=0.08, law="quadratic")
    return Model(BODY, water, (ActiveEffect(name="added_mass", parameters={"relaxation_time": mass}),))


def windows(model: Model, played: Schedule, time: Floats, bounds: np.ndarray) -> Floats:
    """Displacements of windows on a mesh."""
    path = predicted_path(model, shapes(BODY, played.commanded(time)), time, np.zeros(3))
    return relative(path[bounds[:-1]], path[bounds[1:]])


@pytest.mark.parametrize("pause_s", [1.0, 2.0])
def test_a_coasting_swimmer_is_followed_by_the_steps_of_fits(pause_s: float) -> None:
    """The mesh's error is known from a guiding model, and left where a fit moves away from it."""
    r = trial(1.5, pause_s)
    mesh = mesh_of(r)  # type: ignore[arg-type]
    rows, coarse = slice(None, None, COARSER), mesh.bounds // COARSER
    exact = np.interp(np.arange((len(mesh.time) - 1) * FINER + 1) / FINER, np.arange(len(mesh.time)), mesh.time)
    guide = swimmer(OFF * MASS)
    put_back = windows(guide, r.schedule, mesh.time, mesh.bounds) - windows(guide, r.schedule, mesh.time[rows], coarse)
    predicted = windows(swimmer(MASS), r.schedule, mesh.time[rows], coarse) + put_back
    off = predicted - windows(swimmer(MASS), r.schedule, exact, mesh.bounds * FINER)
    assert np.abs(off[~mesh.playing, :2]).max() < SEEN


def test_the_path_of_a_single_shape_is_its_pose() -> None:
    """A trial that was laid anew at its very end plays nothing from there."""
    start = np.array([0.1, -0.2, 0.3])
    for model in (Model(BODY, Medium(anisotropy_ratio=0.2)), swimmer(MASS)):
        path = predicted_path(model, shapes(BODY, np.zeros((1, 3))), np.zeros(1), start)
        np.testing.assert_array_equal(path, start[None])
