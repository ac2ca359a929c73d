"""The gait NLP in a solver of your own: an objective with a variable of its own, IPOPT's options, KKT conditions.

Which gait carries the body 0.3 body lengths with the least peak torque? The peak is a variable more, which no torque
of any joint exceeds in any step: an objective that `customise=` cannot have. The torque of a joint in a step is the
slope of the step's energy in its angle, times T [drag level x body lengths^2 per cycle]; 0.3 per cycle is a demand.

    python problems/own_solver.py
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

import serpenoid as sp

PROBLEM = Path(__file__).with_name("reference-optimum.toml")
SET = ["task.steps=40", "body.vertices=6", 'task.demands=[{kind="travel", least=0.3}]', "task.c=0.0"]
OPTIONS = {  # any of IPOPT; another `linear_solver` (ma57, ...) where its library is installed
    "ipopt.tol": 1e-10,
    "ipopt.bound_relax_factor": 0.0,  # or IPOPT widens every limit by 1e-8, and the certificate refuses the gait
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "print_time": False,
}


def torques(problem: sp.Problem, nlp: Any) -> ca.MX:
    """Torque of every joint in every step, shape (m, T), as symbols of the NLP."""
    step, model = sp.step_functions(problem.model), problem.model.parameters
    m, steps = problem.body.joint_count, problem.task.steps
    before, after, g, h = ca.MX.sym("before", m), ca.MX.sym("after", m), ca.MX.sym("g", 3), ca.MX.sym("h", 3)
    c, s, way = ca.cos(g[2]), ca.sin(g[2]), h[:2] - g[:2]
    pose = ca.vertcat(c * way[0] + s * way[1], c * way[1] - s * way[0], h[2] - g[2])  # seen from the row before
    energy = step["step_energy"](step["shape"](before, model)[1], step["shape"](after, model)[1], pose, model)
    one = ca.Function("torque", [before, after, g, h], [steps * ca.gradient(energy, after)])
    table, poses = nlp.joint_angles, nlp.poses
    return one.map(steps)(table, ca.horzcat(table[:, 1:], table[:, 0]), poses[:, :-1], poses[:, 1:])


def least_peak(problem: sp.Problem, gait: Any = None) -> dict[str, Any]:
    """The NLP with the peak as a variable more, solved from `gait` (default the problem's)."""
    asked: dict[str, Any] = {"problem": problem, "gait": gait, "path_rows": problem.task.steps}
    nlp = sp.gait_nlp(**asked, portable=True)  # its symbols can be differentiated by CasADi
    numbers = sp.nlp_arguments(**asked)
    x, p, peak, every = nlp.variables, nlp.parameters, ca.MX.sym("peak"), ca.vec(torques(problem, nlp))
    g = ca.vertcat(nlp.functions()["g"](x, p), peak - every, peak + every)
    stated = {"x": ca.vertcat(x, peak), "p": p, "f": peak, "g": g}
    first = np.abs(ca.Function("torques", [x, p], [every])(numbers["x0"], numbers["p"]).full()).max()
    more = np.zeros(2 * every.numel())
    arguments = numbers | {
        "x0": np.append(numbers["x0"], first),
        "lbx": np.append(numbers["lbx"], 0.0),
        "ubx": np.append(numbers["ubx"], np.inf),
        "lbg": np.append(numbers["lbg"], more),
        "ubg": np.append(numbers["ubg"], more + np.inf),
    }
    solver = ca.nlpsol("least_peak", "ipopt", stated, OPTIONS)
    found = {name: value.full()[:, 0] for name, value in solver(**arguments).items()}
    poses, q = nlp.split(found["x"][:-1])
    table = ca.Function("table", [x, p], [nlp.joint_angles.T])(found["x"][:-1], numbers["p"]).full()
    return {
        "status": solver.stats()["return_status"],
        "first": first,
        "peak": found["x"][-1],
        "gait": nlp.family.gait(q),
        "curvature": least_curvature(stated, found, arguments),
        "certificate": sp.certify_table(problem, table, poses),
    }


def least_curvature(stated: dict[str, Any], found: dict[str, Any], arguments: dict[str, Any]) -> float:
    """Least curvature of the Lagrangian along ways that keep every active constraint: above 0, a strict minimum."""
    x, p, g = stated["x"], stated["p"], stated["g"]
    multipliers = ca.MX.sym("multipliers", g.numel())
    hessian, _ = ca.hessian(stated["f"] + ca.dot(multipliers, g), x)
    asked = ca.Function("second", [x, p, multipliers], [hessian, ca.jacobian(g, x)])
    second, rows = (value.full() for value in asked(found["x"], arguments["p"], found["lam_g"]))
    equal = arguments["lbg"] == arguments["ubg"]
    active = np.vstack(
        [rows[equal | (np.abs(found["lam_g"]) > 1e-6)], np.eye(x.numel())[np.abs(found["lam_x"]) > 1e-6]]
    )
    _, sizes, ways = np.linalg.svd(active)
    free = ways[int((sizes > 1e-9 * sizes[0]).sum()) :].T
    return float(np.linalg.eigvalsh(free.T @ second @ free).min()) if free.size else np.inf


def main() -> None:
    """From the file's own gait."""
    found = least_peak(sp.load(PROBLEM, set=SET))
    sys.stdout.write(
        f"{found['status']}: peak torque {found['first']:.5f} -> {found['peak']:.5f}, least curvature "
        f"{found['curvature']:.2g}\n{found['certificate']}\n"
    )


if __name__ == "__main__":
    main()
