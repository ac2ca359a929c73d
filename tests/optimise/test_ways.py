"""Motions from shape to shape, along lines, and in corridors."""

from __future__ import annotations

import numpy as np
import pytest

from serpenoid import group
from serpenoid.errors import InputError
from serpenoid.objectives.path import Corridor
from serpenoid.objectives.term import Played
from serpenoid.optimise.asked import asked
from serpenoid.optimise.solution import Solution
from serpenoid.optimise.solve import solve
from serpenoid.simulation.steps import shape_rows
from serpenoid.status import Status
from specimens import oracle_run, problem

SMALL = "body.vertices=6", "task.steps=40", "task.c=0.3"


def played(found: Solution) -> Played:
    return Played(found.trajectory.poses, found.trajectory.vertices, found.table)


def test_a_motion_from_rest_to_rest_has_the_shapes_of_the_file() -> None:
    end = 'task.demands=[{kind="shape",still=true},{kind="shape",at=1.0,angles=[0.3,0.2,0.1,0.0],still=true}]'
    found = solve(problem("reach", *SMALL, "task.transient=true", end), starts=1).best
    assert found.status is Status.SOLVED
    np.testing.assert_allclose(found.table[:2], 0, atol=1e-9)
    np.testing.assert_allclose(found.table[-2:], [[0.3, 0.2, 0.1, 0.0]] * 2, atol=1e-9)
    assert found.trajectory.displacement > 0.5  # of the one that is asked


def test_the_head_keeps_to_its_line_over_several_cycles() -> None:
    line = 'task.objectives=[{kind="path",line=[[0.0,0.0],[0.5,0.0],[1.0,0.3]],point="head",cycles=2,weight=20.0},'
    found = solve(
        problem(
            "reach",
            "body.vertices=6",
            "task.steps=20",
            "task.c=0.3",
            line + '{kind="position",target=[1.0,0.3],cycles=2,weight=5.0}]',
        ),
        1,
    ).best
    assert found.residuals.largest <= 1e-8
    run = oracle_run(found.problem.model, np.tile(found.table, (2, 1)))
    shapes = shape_rows(found.problem.model, np.concatenate([np.tile(found.table, (2, 1)), found.table[:1]]))[0]
    head = group.place(run.poses, shapes)[1:, -1]
    apart = np.array([min(distance(p, (0, 0), (0.5, 0)), distance(p, (0.5, 0), (1, 0.3))) for p in head])
    place = np.sum((run.poses[-1, :2] - [1.0, 0.3]) ** 2)
    value = 20 * np.mean(apart**2) + 5 * place + 0.3 * found.trajectory.dissipation
    assert found.cost == pytest.approx(value, abs=1e-9)
    term = found.problem.task.objectives[0]
    assert term.outcome(played(found)).split()[5] == f"{np.sqrt(np.mean(apart**2)):.4f}"


def distance(point: np.ndarray, begin: tuple[float, float], end: tuple[float, float]) -> float:
    """From a piece of a line, by trying its points."""
    share = np.linspace(0, 1, 100_001)[:, None]
    return float(np.hypot(*(point - (1 - share) * begin - share * end).T).min())


def test_a_corridor_is_kept_round_its_bend() -> None:
    bend = 'task.demands=[{kind="corridor",line=[[-1.0,0.0],[0.6,0.0],[1.5,0.4]],half_width=0.15}]'
    goal = 'task.objectives=[{kind="bending",weight=0.01},{kind="position",target=[0.7,0.1],weight=5.0}]'
    found = solve(
        problem("reach", "body.vertices=6", "task.steps=40", "task.c=0.3", "task.transient=true", bend, goal), 1
    )
    assert found.best.status is Status.SOLVED
    assert found.best.clearance is not None
    assert found.best.clearance.proven >= 0
    corridor = found.best.problem.task.demands[0]
    assert isinstance(corridor, Corridor)
    assert corridor.gap(found.best.trajectory.vertices.reshape(-1, 2)).min() > 0


@pytest.mark.parametrize("demand", ['{kind="shape",angles=[0.1]}', '{kind="swing",joint=9}'])
def test_demands_that_do_not_fit_the_body_are_refused(demand: str) -> None:
    with pytest.raises(InputError, match=r"reach\.toml: .*\[\[task.demands\]\]"):
        problem("reach", *SMALL, f"task.demands=[{demand}]")


def test_a_drawing_is_no_line_to_follow() -> None:
    corners = ",".join(f"[{i / 100},0.0]" for i in range(1001))
    with pytest.raises(InputError, match=r"line: takes 1000 entries at most, got 1001\."):
        problem("reach", *SMALL, f'task.demands=[{{kind="corridor",line=[{corners}],half_width=0.3}}]')


def test_points_of_a_body_whose_servos_do_something_else_are_not_promised() -> None:
    line = 'task.objectives=[{kind="path",line=[[0.0,0.0],[1.0,0.0]],point="head"}]'
    wanted = problem("reach", *SMALL, line, 'effects=[{name="stuck_joint",place=2,angle=0.3}]')
    with pytest.raises(InputError, match="stuck_joint"):
        asked(wanted.task, wanted.family_of(), model=wanted.model)
