"""From the serpenoid curve to vertices and dissipation elements, against plain integrals and the oracle's chain."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import quad

from oracle import chain, integrator
from serpenoid.gaits import EllipseGait
from serpenoid.mechanics import functions, kinematics
from serpenoid.simulation.rollout import body_frame, body_poses
from serpenoid.simulation.steps import elements_of_vertices, shape_rows
from specimens import BODIES, random_table, reference, serpenoid_table

pytestmark = pytest.mark.usefixtures("virtual_machine")
ROUNDING = 1e-13


def test_joint_angle_is_the_curvature_integrated_between_the_midpoints_of_its_links() -> None:
    model, w1, w2, xi = reference(), 3.0, -2.0, 1.3

    def curvature(s: float) -> float:
        return w1 * np.sin(2 * np.pi * xi * s) + w2 * np.cos(2 * np.pi * xi * s)

    symbols = kinematics.serpenoid_joint_angles(ca.SX([w1, w2, xi]), ca.SX(model.body.edges), model.structure)
    found = ca.evalf(symbols).full()[:, 0]
    middles = (np.arange(11) + 0.5) / 11
    expected = [quad(curvature, a, b, epsabs=1e-14)[0] for a, b in zip(middles[:-1], middles[1:], strict=True)]
    np.testing.assert_allclose(found, expected, atol=ROUNDING)


@pytest.mark.parametrize("name", BODIES)
def test_joint_table_of_the_ellipse_is_the_oracles(name: str) -> None:
    model = BODIES[name]
    q = [0.6, 1.0, -1.5, 0.4, 6.0, 0.9]  # sigma, x_c, y_c, theta, a, xi: the specimen gait
    angles = functions.gait_joint_angles(model.structure, EllipseGait().of(model.body.joint_count, 1))
    found = [angles(q, t / 20, model.parameters).full()[:, 0] for t in range(20)]
    np.testing.assert_allclose(found, serpenoid_table(model), atol=ROUNDING)


@pytest.mark.parametrize("name", BODIES)
def test_vertices_and_elements_are_the_oracles_chain(name: str) -> None:
    model, rng = BODIES[name], np.random.default_rng(6)
    table = random_table(model, rng, 7)
    body = model.body
    vertices, elements = shape_rows(model, table)
    expected = chain.shape_vertices(table, body.edges, body.vertex_weights, body.joint_vertices)
    np.testing.assert_allclose(vertices, expected, atol=ROUNDING)
    oracle = integrator.vertex_elements if model.medium.dissipation == "vertex" else integrator.edge_elements
    places = [oracle(p) for p in expected]
    wanted = np.vstack([np.concatenate([p for p, _ in places]).T, np.concatenate([t for _, t in places]).T])
    np.testing.assert_allclose(elements, wanted, atol=ROUNDING)
    np.testing.assert_allclose(elements_of_vertices(model, vertices), wanted, atol=ROUNDING)


@pytest.mark.parametrize("name", BODIES)
def test_body_frame_sits_at_the_weighted_centroid_along_the_mean_edge_angle(name: str) -> None:
    model, rng = BODIES[name], np.random.default_rng(7)
    vertices, _ = shape_rows(model, random_table(model, rng, 5))
    np.testing.assert_allclose(body_poses(model, vertices), np.zeros((5, 3)), atol=ROUNDING)
    poses = rng.normal(size=(5, 3))
    placed = np.array([chain.place(pose, shape) for pose, shape in zip(poses, vertices, strict=True)])
    found = body_poses(model, placed)
    np.testing.assert_allclose(np.exp(1j * found[:, 2]), np.exp(1j * poses[:, 2]), atol=ROUNDING)
    np.testing.assert_allclose(found[:, :2], poses[:, :2], atol=ROUNDING)
    np.testing.assert_allclose(body_frame(model, placed), vertices, atol=ROUNDING)


def test_public_functions_name_their_inputs_and_keep_the_documented_shapes() -> None:
    structure = reference().structure
    wanted = {
        functions.shape: (
            {"joint_angles": (10, 1), "parameters": (24, 1)},
            {"vertices": (2, 12), "elements": (4, 12)},
        ),
        functions.step_energy: (
            {"before": (4, 12), "after": (4, 12), "pose": (3, 1), "parameters": (24, 1)},
            {"energy": (1, 1)},
        ),
        functions.step: (
            {"before": (4, 12), "after": (4, 12), "guess": (1, 1), "parameters": (24, 1)},
            {"pose": (3, 1), "residual": (1, 1), "curvature": (1, 1), "energy": (1, 1)},
        ),
    }
    for make, (inputs, outputs) in wanted.items():
        function = make(structure)
        assert {n: function.size_in(n) for n in function.name_in()} == inputs
        assert {n: function.size_out(n) for n in function.name_out()} == outputs


def test_a_saved_function_is_the_same_function(tmp_path) -> None:  # type: ignore[no-untyped-def]
    model = reference()
    step = functions.step(model.structure)
    step.save(str(tmp_path / "step.casadi"))
    again = ca.Function.load(str(tmp_path / "step.casadi"))
    table = serpenoid_table(model)
    before, after = (functions.shape(model.structure)(row, model.parameters)[1] for row in table[:2])
    pair = [f(before, after, 0, model.parameters)[0].full() for f in (step, again)]
    np.testing.assert_array_equal(*pair)
