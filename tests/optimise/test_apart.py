"""A body that keeps off itself: distances of edges, what is proven between rows, a stroke whose links would cross."""

from __future__ import annotations

import time

import numpy as np
import pytest

from serpenoid.body import Body, Floats
from serpenoid.errors import InputError
from serpenoid.gaits import EllipseGait
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.objectives import Criteria
from serpenoid.optimise.clear.apart import Near, Pairs, keep_apart
from serpenoid.optimise.robust import solver_of
from serpenoid.optimise.solve import solve, starts_of
from serpenoid.optimise.solver import GaitSolver
from serpenoid.problem import Task
from serpenoid.simulation.steps import shape_rows
from serpenoid.status import Status
from specimens import nlp_of, problem

MODEL = Model(Body(vertices=6), Medium(anisotropy_ratio=0.3))
STROKE = ("body.vertices=7", "body.joints=[2,4]", "task.steps=40", "body.joint_limit_deg=150.0")


def by_hand(chain: Floats, between: int) -> float:
    """Smallest distance of points spread over edges that are not neighbours."""
    share = np.linspace(0, 1, 41)[:, None]
    edges = [(1 - share) * a + share * b for a, b in zip(chain[:-1], chain[1:], strict=True)]
    apart = [
        np.linalg.norm(edges[i][:, None] - edges[j][None], axis=-1).min()
        for i in range(len(edges))
        for j in range(i + between + 1, len(edges))
    ]
    return float(min(apart))


@pytest.mark.parametrize("seed", range(3))
def test_distances_are_those_of_points_on_the_edges(seed: int) -> None:
    angles = np.random.default_rng(seed).uniform(-1.5, 1.5, (4, 4))
    pairs = Pairs(MODEL, 1)
    chains = pairs.chains(angles, np.arange(3), np.zeros(3))
    np.testing.assert_allclose(chains, shape_rows(MODEL, angles[:3])[0], atol=1e-12)
    found = pairs.distances(chains)[0].min(1)
    expected = [by_hand(chain, 1) for chain in chains]
    np.testing.assert_allclose(found, expected, atol=5e-3)  # points are 0.005 apart


@pytest.mark.parametrize(("between", "pieces"), [(1, 5), (3, 9), (6, 8), (9, 5)])
def test_links_that_are_cut_into_edges_are_few_pieces_and_as_near_as_all_their_edges(between: int, pieces: int) -> None:
    """Pieces: ten edges of two neighbouring links end at most five times; all edges of far links are one piece."""
    model = Model(Body(vertices=16, joints=(5, 10)), Medium(anisotropy_ratio=0.3, dissipation="edge"))
    angles = np.random.default_rng(between).uniform(-2.0, 2.0, (9, 2))
    pairs = Pairs(model, between)
    assert pairs.ends.shape[1] == pieces
    chains = pairs.chains(angles, np.arange(8), np.zeros(8))
    links = np.arange(15) // 5
    first, second = np.triu_indices(15, k=between + 1)
    first, second = (x[links[first] != links[second]] for x in (first, second))  # of one link they keep their distance
    single = Pairs(Model(Body(vertices=16), Medium(anisotropy_ratio=0.3)), between)
    where = np.flatnonzero([(links[a] != links[c]) for a, _, c, _ in single.ends.T])
    np.testing.assert_array_equal(single.ends[0][where], first)
    expected = single.distances(chains)[0][:, where].min(1)
    np.testing.assert_allclose(pairs.distances(chains)[0].min(1), expected, atol=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_what_is_proven_holds_between_rows(seed: int) -> None:
    angles = np.random.default_rng(seed).uniform(-1.2, 1.2, (4, 4))
    pairs = Pairs(MODEL, 1)
    share = np.tile(np.linspace(0, 1, 40, endpoint=False), 3)
    seen = pairs.distances(pairs.chains(angles, np.repeat(np.arange(3), 40), share))[0].min()
    proven = pairs.clearance(angles, 1.0)
    assert proven.proven <= seen + 1e-12
    assert proven.proven >= seen - 2e-3  # what is between 40 times


def test_edges_that_cross_between_two_rows_alone_are_found() -> None:
    """Three links fold into a triangle: its ends pass one another at both rows, and cross half-way between."""
    pairs = Pairs(Model(Body(vertices=4), Medium(anisotropy_ratio=0.3)), 1)
    angles = np.array([[2.9, 1.4], [1.4, 2.9]])
    rows, half_way = (pairs.distances(pairs.chains(angles, np.zeros(1, int), np.full(1, x)))[0] for x in (0.0, 0.5))
    assert rows.min() > 0.02
    assert half_way.min() == 0.0
    assert pairs.clearance(angles, 0.01).proven <= 0.0


def test_a_stroke_keeps_off_itself_at_every_time() -> None:
    wanted = problem("purcell-stroke", *STROKE)
    free = GaitSolver(wanted)
    pairs, answer = Pairs(wanted.model, 2), free.solve(starts_of(free, 1, 0)[0], 0.0)
    table = free.table(answer.q)
    assert pairs.least(np.concatenate([table, table[:1]])[None])[0] == 0.0  # links cross
    kept = 'task.demands=[{kind="swing"},{kind="self",distance=0.08,between=2}]'
    found = solve(problem("purcell-stroke", *STROKE, kept), starts=1).best
    assert found.status is Status.SOLVED
    assert found.polishing_gain is not None
    assert found.self_clearance is not None
    assert found.self_clearance.proven >= 0.08
    table = np.concatenate([found.table, found.table[:1]])
    share = np.tile([0.0, 0.5], 40)
    chains = pairs.chains(table, np.repeat(np.arange(40), 2), share)
    assert min(by_hand(chain, 2) for chain in chains) >= 0.08


def test_what_a_hundred_joints_watch_is_derived_at_once() -> None:
    """No single call lasts: an interrupt is heard between calls. All in one expression took 20 s."""
    long = Model(Body(vertices=102), Medium(anisotropy_ratio=0.3))
    watched = tuple(Near(0.5 * (k % 2), k % 50, k % 20, 72 + k % 20, 73 + k % 20) for k in range(60))

    def own(of: Criteria) -> None:
        keep_apart(of, long, watched, 0.1)

    begin = time.process_time()
    nlp_of(long, 50, 0, EllipseGait(), own, Task()).functions()
    assert time.process_time() - begin < 6.0  # 0.4 s where nothing else runs


def test_cases_and_keeping_off_are_not_combined() -> None:
    both = 'task.demands=[{kind="self",distance=0.05}]', "task.robust={anisotropy_ratio=[0.1, 0.4]}"
    with pytest.raises(InputError, match="off itself"):
        solver_of(problem("reference-optimum", *both))


def test_a_distance_that_no_shape_keeps_is_refused_when_the_file_is_read() -> None:
    """Of five edges of 0.2 two with one between them are never farther apart than that one reaches."""
    five = "reference-optimum", "body.vertices=6"
    with pytest.raises(InputError, match=r"1 \(self\) distance must be at most 0\.2, .* got 0\.4"):
        problem(*five, 'task.demands=[{kind="self",distance=0.4}]')
    problem(*five, 'task.demands=[{kind="self",distance=0.2}]')
    problem(*five, 'task.demands=[{kind="self",distance=0.4,between=2}]')
