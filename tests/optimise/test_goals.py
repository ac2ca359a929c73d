"""Goals, obstacles, families: published problems, proven clearance, a toy family, statuses where nothing is found."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from types import SimpleNamespace
from typing import ClassVar, Literal

import casadi as ca
import numpy as np
import pytest

from oracle.integrator import Run
from serpenoid.body import Body, Floats
from serpenoid.errors import InputError
from serpenoid.gaits import Gait, GaitBounds, GaitFamily, TableGait, families
from serpenoid.gaits.ellipse import EllipseBounds, EllipseGait
from serpenoid.gaits.fourier import FourierGait
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.objectives import demands, terms
from serpenoid.objectives.criteria import NEAR, Gaps
from serpenoid.objectives.obstacles import Box, Disc, HalfPlane
from serpenoid.optimise.asked import asked as criteria_of
from serpenoid.optimise.clear.between import Between, GapField
from serpenoid.optimise.clear.clearance import RESOLUTION, clearance
from serpenoid.optimise.easier import Easier, easier
from serpenoid.optimise.ladder import FAMILIES, Step, climb, unlike_cycles
from serpenoid.optimise.outcomes import fine_clear_of_obstacles
from serpenoid.optimise.solution import Solution
from serpenoid.optimise.solve import solve, solve_from
from serpenoid.problem import Problem, load
from serpenoid.results import solution_record
from serpenoid.simulation.problem import on_meshes
from serpenoid.simulation.rollout import Batch
from serpenoid.status import Status
from specimens import PROBLEMS, oracle_run, problem

HELD = 'effects=[{name="stuck_joint", place=2, angle=0.785}]'
SMALL = ("body.vertices=6", "task.steps=40")


def asked(name: str, *changes: str, **task: object) -> Problem:
    """A problem file with another task."""
    found = problem(name, *changes)
    data = found.model_dump(exclude_unset=True) | {}
    data["task"] = data["task"] | task
    return Problem.model_validate(data)


def test_every_kind_in_the_folders_is_offered_in_problem_files() -> None:
    expected = {"displacement", "position", "heading", "effort", "bending", "transport"}
    assert expected <= {t.model_fields["kind"].default for t in terms()}
    assert {"reach", "travel", "disc", "box", "half_plane"} <= {d.model_fields["kind"].default for d in demands()}
    assert {"ellipse", "fourier", "fourier-joints", "spline", "table"} == set(families())


class ToyBounds(GaitBounds):
    family: Literal["toy"] = "toy"


class ToyGait(Gait):
    """A travelling wave along the joints with one parameter, its amplitude."""

    Bounds: ClassVar[type[GaitBounds]] = ToyBounds
    family: Literal["toy"] = "toy"
    amplitude: float = 0.3

    def of(self, joints: int, rows: int, bounds: GaitBounds | None = None, closed: bool = True) -> ToyFamily:
        return ToyFamily(self, joints, rows, bounds or ToyBounds(), closed)


@dataclass(frozen=True)
class ToyFamily(GaitFamily):
    """Nothing but this class is needed: NLP, start, certificates and results ask it."""

    names: ClassVar[tuple[str, ...]] = ("amplitude",)
    units: ClassVar[tuple[str, ...]] = ("rad",)
    limits: ClassVar[tuple[Floats, Floats]] = (np.zeros(1), np.ones(1))
    widths: ClassVar[Floats] = np.full(1, 0.02)

    @cached_property
    def data(self) -> Floats:
        return np.arange(self.rows)[:, None] / self.rows

    def at(self, p: ca.SX, data: ca.SX) -> ca.SX:
        joints = ca.DM(np.arange(self.joints) / self.joints)
        return p[0] * ca.cos(2 * ca.pi * (data[0] + joints))

    def start(self) -> Floats:
        return np.array([self.like.amplitude if isinstance(self.like, ToyGait) else 0.3])

    def sample(self, rng: np.random.Generator) -> Floats:
        return rng.uniform(0.1, 0.9, 1)

    def scaled(self, p: Floats, factor: float) -> Floats:
        return p * factor

    def gait(self, p: Floats) -> ToyGait:
        return ToyGait(amplitude=float(p[0]))


def test_a_family_of_ones_own_is_one_class() -> None:
    wanted = asked("reach", "body.vertices=6", "task.steps=16", objectives=({"kind": "displacement"},), c=0.5)
    found = solve_from(wanted.model_copy(update={"gait": ToyGait()}), ToyGait())
    assert found.status is Status.SOLVED
    assert found.names == ("amplitude",)
    assert found.polishing_gain is not None
    best = min(amplitude_cost(wanted, a) for a in np.linspace(0.2, 1.0, 33))
    assert found.cost <= best + 1e-9
    assert best - found.cost < 1e-3  # the grid's spacing


def amplitude_cost(wanted: Problem, amplitude: float) -> float:
    family = ToyGait(amplitude=amplitude).of(4, 16)
    table = amplitude * np.cos(2 * np.pi * (family.data + np.arange(4) / 4))
    if np.abs(table).max() > np.deg2rad(63):
        return np.inf
    run = oracle_run(wanted.model, table)
    return float(-run.displacement + 0.5 * run.dissipation)


def test_a_broken_joint_is_held_and_the_rest_goes_on() -> None:
    found = solve(problem("broken-joint", *SMALL, "task.c=0.3", HELD), starts=1, seed=2).best
    assert found.residuals.largest <= 1e-8
    assert found.resimulation_error <= 1e-8
    assert np.hypot(*(found.trajectory.poses[-1, :2] - [1.3, 0])) < 0.2


TURN = {"objectives": ({"kind": "heading", "target_rad": 1.0, "weight": 5.0},), "c": 0.3}


NO_LEAPS = (  # a free table without a speed limit leaps through walls from one row to the next
    "body.joint_speed_limit_rpm=12.0", "task.cycle_duration_s=10.0", "task.constraints.joint_speed_limits=true",
)  # fmt: skip


@pytest.mark.parametrize("seed", range(2))
def test_a_box_is_kept_at_every_time_and_place(seed: int) -> None:
    box = {"kind": "box", "half_widths": (0.52, 0.24), "inside": True}
    changes = "body.vertices=6", "task.steps=24", *NO_LEAPS
    found = solve(asked("turn-in-a-box", *changes, **TURN, demands=(box,)), starts=1, seed=seed).best
    assert found.status is Status.SOLVED
    assert found.trajectory.heading_change > 0.9  # of the 1 that is asked
    assert found.clearance is not None
    assert found.clearance.proven >= 0
    run = oracle_run(found.problem.model, found.table)
    assert (between(run, found) <= np.array([0.52, 0.24]) + 1e-9).all()
    fine = found.fine_clearance
    assert fine is not None
    assert fine == fine_clear_of_obstacles(found.problem, found.table, on_meshes(found.problem, found.table)[-1])
    assert solution_record(found)["fine_clearance"] == {"least": fine.least, "proven": fine.proven}
    closed = np.concatenate([found.table, found.table[:1]])
    finer = np.array([np.interp(np.arange(96) / 4, np.arange(25), angles) for angles in closed.T]).T
    room = (np.array([0.52, 0.24]) - np.abs(oracle_run(found.problem.model, finer).vertices)).min()
    assert fine.proven <= room + 1e-9
    assert min(fine.least, 0.0) <= min(room, 0.0) + RESOLUTION  # what is proven to be above 0 is not looked at again
    assert fine.least > room - 0.01  # vertices move less than that between two of 96 rows


def between(run: Run, found: Solution) -> Floats:
    """|x|, |y| of the vertices at ten moments of every step, by the oracle's vertices and straight lines of poses."""
    from serpenoid import group
    from serpenoid.simulation.steps import shape_rows

    assert np.abs(run.poses - found.trajectory.poses).max() < 1e-9
    table = np.concatenate([found.table, found.table[:1]])
    share = np.linspace(0, 1, 11)[:, None, None]
    angles = ((1 - share) * table[:-1] + share * table[1:]).reshape(-1, table.shape[1])
    poses = ((1 - share) * run.poses[:-1] + share * run.poses[1:]).reshape(-1, 3)
    return np.abs(group.place(poses, shape_rows(found.problem.model, angles)[0]))


def gaps_of(obstacle: Disc, convex: bool = True) -> GapField:
    return GapField((Gaps(lambda p: ca.vec(obstacle.distances(p)), convex),))


def test_proven_clearance_is_a_lower_bound_that_sees_between_rows_and_vertices() -> None:
    model = Model(Body(vertices=3), Medium(anisotropy_ratio=0.5))
    poses, straight = np.array([[0.0, 0, 0], [1.0, 0, 0]]), np.zeros((2, 1))
    ahead = Disc(kind="disc", centre=(0.25, 0.3), radius=0.1)  # beside the middle of an edge on the way
    found = clearance(Between(model, poses[None], straight[None]), gaps_of(ahead), wanted=0.19)
    assert 0.19 <= found.proven <= 0.2 <= found.least + 1e-12
    hit = Disc(kind="disc", centre=(1.75, 0.0), radius=0.1)  # beyond every vertex of both rows
    found = clearance(Between(model, poses[None] * [3, 1, 1], straight[None]), gaps_of(hit))
    assert found.proven < -0.09


@pytest.mark.parametrize("obstacle", [
    Disc(centre=(0.2, -0.1), radius=0.4), Box(half_widths=(0.3, 0.5), angle_rad=0.7),
    HalfPlane(point=(0.1, 0), normal=(3, 4)),
    Box(half_widths=(0.3, 0.5), inside=True),
])  # fmt: skip
def test_signed_distances_are_convex_and_grow_no_faster_than_points_move(obstacle: Disc) -> None:
    rng = np.random.default_rng(1)
    points = rng.uniform(-1, 1, (400, 2))
    steps = 0.05 * rng.normal(size=(400, 2))
    before, middle, after = (gaps_of(obstacle).at(points + share * steps)[0] for share in (0.0, 0.5, 1.0))
    assert (np.abs(after - before) <= np.hypot(*steps.T)[:, None] + 1e-8).all()
    assert (middle <= (before + after) / 2 + 1e-8).all()


def test_free_tables_are_first_looked_for_on_few_rows_and_obstacles_come_last() -> None:
    for name, changes, chain in (
        ("reach", (), [(20, 0)]),
        ("reach", ("task.steps=82",), []),
        ("reach", ("task.steps=40",), []),
        ("disc-obstacle", (), [(50, 1), (50, 0)]),
        ("disc-obstacle", ("task.steps=50",), [(50, 0)]),
    ):
        wanted, found = problem(name, *changes), []
        while (way := easier(wanted, wanted.family_of(), given=False)) is not None:
            wanted = way.problem
            found.append((wanted.task.steps, len(wanted.task.demands)))
        assert found == chain
    assert easier(problem("disc-obstacle"), problem("disc-obstacle").family_of(), given=True) is None
    table, way = np.arange(24.0).reshape(8, 3), Easier(problem("reach"), fewer=4)
    np.testing.assert_array_equal(way.to(table.ravel(), TableGait().of(3, 8)).reshape(-1, 3), table[::4])
    np.testing.assert_array_equal(way.back(table[::4].ravel(), TableGait().of(3, 2)).reshape(-1, 3)[::4], table[::4])


def test_the_displacement_is_smooth_where_a_body_comes_back_and_exact_beyond() -> None:
    here = problem("reach", 'task.demands=[{kind="reach",target=[0.0,0.0]}]')
    criteria = criteria_of(here.task, here.family_of()).criteria
    assert criteria.in_place
    assert not criteria_of(problem("reach").task, here.family_of()).criteria.in_place
    end = criteria.poses[:2, -1]
    hessian, slope = ca.hessian(criteria.displacement, criteria.moved)
    of = ca.Function("of", [end], [criteria.displacement, slope[-3], hessian[-3, -3]])
    assert [float(v) for v in of([0.0, 0.0])[:2]] == [0.0, 0.0]
    inside, outside = (np.ravel(of([NEAR * (1 + sign * 1e-9), 0.0])) for sign in (-1, 1))
    np.testing.assert_allclose(inside, outside, rtol=1e-7, atol=1e-7 / NEAR)  # second derivatives are of 1 / NEAR
    assert float(of([3e-3, 4e-3])[0]) == pytest.approx(5e-3, rel=1e-15)


def test_a_heading_is_not_reached_by_a_step_of_a_whole_turn() -> None:
    """Poses a whole turn apart are one: an NLP would turn the other way and leap (it did, in the box, two of three)."""
    wanted = asked("turn-in-a-box", "body.vertices=5", "task.steps=8", demands=())
    criteria = criteria_of(wanted.task, wanted.family_of())
    turning, table = np.linspace(0, -np.pi, 9), np.zeros((1, 8, 3))
    leaping = turning + 2 * np.pi * (np.arange(9) > 3)
    for heading, allowed in ((turning, True), (leaping, False)):
        poses = np.column_stack([np.zeros((9, 2)), heading])[None]
        motion = Batch(poses, np.zeros(1), np.zeros(1), np.ones(1, bool))
        assert (criteria.evaluate(motion, table, table.reshape(1, -1), 0.0)[1][0] == 0) == allowed


def test_a_transient_runs_from_shape_to_shape_and_is_not_closed() -> None:
    found = solve(asked("reach", *SMALL, transient=True, c=0.3), starts=1, seed=4).best
    assert found.table.shape == (41, 4)
    assert found.residuals.largest <= 1e-8
    assert found.resimulation_error <= 1e-8
    assert not np.allclose(found.table[0], found.table[-1])


def test_least_effort_for_a_given_way_is_least_where_the_multiplier_says() -> None:
    gait = EllipseGait(sigma=0.6, a=5.0, xi=1.0)
    free = solve_from(asked("reference-optimum", c=1.0), gait)
    way = free.trajectory.displacement
    given = {"objectives": ({"kind": "effort"},), "demands": ({"kind": "travel", "least": way},), "c": 0.0}
    found = solve_from(asked("reference-optimum", **given), gait)
    assert found.status is Status.SOLVED
    assert found.trajectory.displacement == pytest.approx(way, abs=1e-7)
    assert found.trajectory.dissipation == pytest.approx(free.trajectory.dissipation, abs=1e-6)


def test_least_cost_of_transport_is_the_optimum_of_the_c_that_is_one_over_it() -> None:
    """Where (idle + D) / way is stationary, dD = cost d way: the optimum of -way + c D with c = 1 / cost."""
    given = {"objectives": ({"kind": "transport", "idle": 0.3},), "c": 0.0}
    found = solve_from(asked("reference-optimum", **given), EllipseGait(sigma=0.6, a=5.0, xi=1.0))
    assert found.status is Status.SOLVED
    run = oracle_run(found.problem.model, found.table)
    assert found.cost == pytest.approx((0.3 + run.dissipation) / run.displacement, abs=1e-9)
    swept = solve_from(asked("reference-optimum", c=1 / found.cost), found.gait)
    assert swept.trajectory.displacement == pytest.approx(found.trajectory.displacement, abs=1e-6)
    assert swept.trajectory.dissipation == pytest.approx(found.trajectory.dissipation, abs=1e-6)


def test_the_place_after_several_cycles_is_where_they_lead() -> None:
    place = {"kind": "position", "target": (0.5, 0.3), "cycles": 3}
    found = solve(asked("reference-optimum", objectives=(place,), c=0.05), starts=2, seed=0).best
    table = np.tile(found.table, (3, 1))
    run = oracle_run(found.problem.model, table)
    value = np.sum((run.poses[-1, :2] - [0.5, 0.3]) ** 2) + 0.05 * found.trajectory.dissipation
    assert found.cost == pytest.approx(value, abs=1e-9)


def test_demands_alone_are_met_by_any_gait_that_meets_them() -> None:
    found = solve(problem("steer", "body.vertices=6", "task.steps=12", "task.objectives=[]", "task.c=0"), starts=1).best
    assert found.residuals.largest <= 1e-8
    assert found.cost == 0
    assert found.trajectory.heading_change == pytest.approx(0.3, abs=1e-8)


def test_faults_in_objectives_name_their_place() -> None:
    path = PROBLEMS / "reach.toml"
    with pytest.raises(InputError, match="unknown key"):
        load(path, ['task.objectives=[{kind="position", target=[1.0, 0.0], weigth=2.0}]'])
    with pytest.raises(InputError, match="objectives"):
        load(path, ['task.objectives=[{kind="nowhere"}]'])
    with pytest.raises(InputError, match=r"\[task\.bounds\] sigma: unknown key"):
        load(path, ["task.bounds.sigma=[0.0, 1.0]"])


@pytest.mark.slow
def test_each_step_up_the_ladder_is_at_least_as_good_and_dissipates_no_more() -> None:
    wanted = problem("reference-optimum", "body.vertices=7", "task.c=0.5")
    climbed = climb(wanted, starts=3)
    assert len(climbed) == FAMILIES  # a family that fails in between is told, too
    steps = [step for step in climbed if step.ok]
    assert steps[0].name == "ellipse"
    assert steps[-1].name == "free table"
    costs = [s.solution.cost for s in steps]
    assert (np.diff(costs) <= 1e-8).all()
    spent = [s.solution.trajectory.dissipation for s in steps]
    assert max(spent) <= spent[0] + 1e-8


def test_a_ladder_says_where_cycles_have_other_numbers_of_undulations() -> None:
    phase = 2 * np.pi * (np.arange(40) / 40)[:, None] + np.array([0.0, 1.0, 2.0])

    def step(name: str, table: np.ndarray) -> Step:
        return Step(name, SimpleNamespace(table=table))  # type: ignore[arg-type]

    once = step("ellipse", np.sin(phase)), step("free table", np.sin(phase) + 0.4 * np.sin(2 * phase))
    assert unlike_cycles(once) is None
    said = unlike_cycles([*once, step("Fourier", 0.3 * np.sin(phase) + np.sin(2 * phase))])
    assert said is not None
    assert said.startswith("undulations in a cycle: 1 in `ellipse` and `free table`, 2 in `Fourier`; ")


def test_families_keep_bounds_of_their_own() -> None:
    bounds = EllipseBounds(a=(1.0, 2.0))
    lower, upper = EllipseGait().of(5, 10, bounds).limits
    assert (lower[4], upper[4]) == (1.0, 2.0)
    assert FourierGait().of(5, 10).size == 1 + 2 * 5
    assert TableGait().of(3, 7).size == 21
