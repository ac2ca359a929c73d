"""An objective and a constraint of your own in the gait NLP, certified like the built-in ones.

Which gait carries the snake robot farthest when the mean squared joint angle (a stand-in for the servos' torque) is
capped, and a gait whose centre lies off the straight shape pays for it?

    python problems/own_objective.py
"""

from __future__ import annotations

import sys
from pathlib import Path

import casadi as ca
import numpy as np

import serpenoid as sp

PROBLEM = Path(__file__).with_name("snake10.toml")
CAP = 0.10  # rad^2, mean over joints and steps
OFFSET_PRICE = 0.01  # body lengths per squared unit of (x_c, y_c)


def gentle(of: sp.Criteria) -> None:
    """Cap the mean squared joint angle; add a price of the offset to -displacement + c * dissipation."""
    angles = of.joint_angles
    of.subject_to(ca.sumsqr(angles) / angles.numel(), 0, CAP)
    of.also_minimise(OFFSET_PRICE * ca.sumsqr(of.gait[1:3]))


def thrifty(of: sp.Criteria) -> None:
    """Replace the objective: dissipation per body length, at least 0.2 body lengths per cycle."""
    of.minimise(of.dissipation / of.displacement)
    of.subject_to(of.displacement, 0.2, 1)


def main() -> None:
    """Solve the plain problem and both variations from the same random starts."""
    problem = sp.load(PROBLEM, set=["task.c=0.5"])
    for name, customise in {"plain": None, "gentle": gentle, "thrifty": thrifty}.items():
        best = sp.solve(problem, starts=3, customise=customise).best
        motion, square = best.trajectory, np.mean(best.table**2)
        sys.stdout.write(
            f"{name:8} {best.status.name.lower():8} displacement {motion.displacement:.4f}"
            f"  dissipation {motion.dissipation:.4f}  mean squared angle {square:.4f}  objective {best.objective:.4f}\n"
        )


if __name__ == "__main__":
    main()
