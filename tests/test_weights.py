"""What the elements weigh: a uniform body is uniform per length, and what is not uniform is said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from serpenoid.body import Body
from serpenoid.errors import InputError
from serpenoid.mechanics import functions
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.problem import load
from serpenoid.simulation.problem import simulate
from specimens import uneven

UNEQUAL = (0.1, 0.3, 0.2, 0.4)


def at_edges(body: Body) -> Model:
    return Model(body, Medium(anisotropy_ratio=0.3, dissipation="edge"))


def symbolic_weights(model: Model) -> np.ndarray:
    return functions.element_parameters(model.structure)(model.parameters)[0].full()[:, 0]


@pytest.mark.parametrize("body", [Body(vertices=12), Body(vertices=5, edge_lengths=UNEQUAL)])
def test_edges_of_a_body_without_weights_weigh_as_much_as_they_are_long(body: Body) -> None:
    model = at_edges(body)
    np.testing.assert_allclose(symbolic_weights(model), body.edges, atol=1e-15)
    assert model.body.vertex_weights.sum() == pytest.approx(1)
    assert not [remark for remark in model.remarks if "weigh" in remark]


def test_equal_weights_given_for_edges_burden_the_end_edges_by_half_and_that_is_said() -> None:
    model = at_edges(Body(vertices=12, weights=(1.0,) * 12))
    weights = symbolic_weights(model)
    assert weights[0] / weights[5] == pytest.approx(1.5)
    (remark,) = model.remarks
    assert "1.5 times" in remark


def test_equal_weights_on_unequal_edges_are_said_and_given_ones_are_the_authors() -> None:
    medium = Medium(anisotropy_ratio=0.3)
    (remark,) = Model(Body(vertices=5, edge_lengths=UNEQUAL), medium).remarks
    assert "4 times" in remark
    assert not Model(Body(vertices=5, edge_lengths=UNEQUAL, weights=(1, 2, 2, 1, 1)), medium).remarks
    assert not Model(Body(vertices=12), medium).remarks


def test_edge_weights_by_numbers_and_by_symbols_agree_and_keep_the_sum() -> None:
    model = uneven("edge")
    np.testing.assert_allclose(model.body.edge_weights, symbolic_weights(model), atol=1e-15)
    assert symbolic_weights(model).sum() == pytest.approx(1)


@pytest.mark.parametrize("edges", [(1.0,) * 3, (2.0, 3.0, 3.0, 4.0, 3.0, 2.0), (1.0,) * 20])
def test_drag_in_the_middles_of_edges_says_what_resistance_to_turning_it_leaves_out(edges: tuple[float, ...]) -> None:
    body = Body(vertices=len(edges) + 1, edge_lengths=edges)
    ends = np.concatenate([[0.0], np.cumsum(body.edges)])
    middles = (ends[1:] + ends[:-1]) / 2 - 0.5
    left_out = 1 - 12 * (body.edges * middles**2).sum()  # of a straight rod's 1/12
    remarks = Model(body, Medium(anisotropy_ratio=0.3, dissipation="edge")).remarks
    said = [remark for remark in remarks if "resists turning" in remark]
    assert len(said) == (left_out > 0.02)
    assert all(f"{left_out:.1%}" in remark for remark in said)
    wheels = body.changed(kind="wheeled robot")
    assert not [r for r in Model(wheels, Medium(anisotropy_ratio=0.3, dissipation="edge")).remarks if "turning" in r]
    assert not [r for r in Model(body, Medium(anisotropy_ratio=0.3)).remarks if "turning" in r]


def test_weights_next_to_nothing_are_halved_and_edges_next_to_nothing_refused() -> None:
    """What a file may say of a body holds of all bodies that are made of it."""
    body = Body(vertices=5, edge_lengths=(0.1,) * 4, weights=(0.5, 1e-9, 1e-9, 1e-9, 0.5))
    middles = body.with_middles()
    assert middles.pieces == 1
    share = middles.vertex_weights[1::2] / middles.vertex_weights[1::2].sum()
    np.testing.assert_allclose(share, body.edge_weights, atol=1e-8)
    Body(vertices=4, edge_lengths=(1e-9, 1e-9, 1e3)).uniform()
    with pytest.raises(InputError, match="1e-09 m is too short to have a middle: give lengths in metres"):
        Body(vertices=4, edge_lengths=(0.1, 1e-9, 0.1)).with_middles()


@pytest.mark.parametrize("site", ["vertex", "edge"])
def test_a_vertex_that_holds_the_body_is_asked_about(site: str) -> None:
    weights = [1.0] * 12
    medium = Medium(anisotropy_ratio=0.2, dissipation=site)
    weights[4] = 1e6
    said = Model(Body(vertices=12, weights=tuple(weights)), medium).odd_weight
    if site == "edge":  # its weight is halved between two edges, and neither holds the body against the other
        assert said is None
    else:
        assert said is not None
        assert said.startswith("by `weights` vertex 4 has 9.1e+04 times the drag of all others together")
    assert Model(Body(vertices=12, weights=(1e6,) * 12), medium).odd_weight is None


def test_a_body_that_one_vertex_holds_hardly_goes() -> None:
    """As far as the rest of its drag over eps, to within what a gait makes of it: the reason for the limit."""
    path = Path(__file__).parents[1] / "problems" / "reference.toml"
    plain = simulate(load(path))
    held = simulate(load(path, set=["body.weights=[1, 1, 1, 1, 1e5, 1, 1, 1, 1, 1, 1, 1]"]))
    assert held.trajectory.displacement < 0.01 * plain.trajectory.displacement
