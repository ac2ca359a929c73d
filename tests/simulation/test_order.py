"""The variational integrator is of order two: halving the time step divides the error by four."""

from __future__ import annotations

import numpy as np
import pytest

from serpenoid.model import Model
from serpenoid.simulation import simulate_joint_angles
from specimens import BODIES, serpenoid_table

pytestmark = pytest.mark.usefixtures("virtual_machine")
STEPS = (100, 200, 400, 800, 1600)


@pytest.mark.parametrize("model", BODIES.values(), ids=BODIES)
def test_errors_fall_by_four_when_the_steps_are_halved(model: Model) -> None:
    runs = [simulate_joint_angles(model, serpenoid_table(model, count)) for count in STEPS]
    values = np.array([[*run.net_motion, run.dissipation] for run in runs])
    change = np.diff(values, axis=0)
    ratio = change[:-1] / change[1:]
    # the next term of the error is 1/T^4, so 4 becomes 4 + O(1/T^2); 0.05 is the project's own bound
    assert np.abs(ratio[0] - 4).max() < 0.05
    assert np.abs(ratio[-1] - 4).max() < 0.005  # and the ratio itself converges
    limit = values[-1] + change[-1] / 3  # Richardson
    error = np.abs(values - limit)
    np.testing.assert_allclose(error[:-2] / error[1:-1], 4, atol=0.1)


def test_reference_gait_is_half_a_per_cent_short_of_its_limit_at_fifty_steps() -> None:
    model = BODIES["reference"]
    gait = {"sigma": 1.0, "a": 6.0, "xi": 1.0, "x_c": 0.0, "y_c": 0.0, "theta": 0.0}
    coarse, fine = (simulate_joint_angles(model, serpenoid_table(model, n, **gait)).displacement for n in (50, 800))
    assert 1 - coarse / fine == pytest.approx(0.005, abs=0.0005)  # the statement of problems/reference.toml
