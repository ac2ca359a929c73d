"""Free gaits: the robot-snake problems of Inverse Geometric Locomotion from random tables, and L-BFGS beside the NLP.

Every joint angle of every row is free. A seed counts as certified if its KKT conditions hold, step-by-step simulation
agrees, the mesh is fine enough and (obstacles) the clearance is proven; it reaches the best if its objective is within
1e-6 of the best found. L-BFGS-B minimises the same objective over the same angles within the same limits, by the
compiled simulation with adjoint gradients (one sparse solve with the transposed step equations), from the same seeds,
until it is within 1e-6 of the NLP's objective or gives up, as many seeds as 45 s allow. The free gait of
problems/snake10.toml begins at the ellipse optimum, perturbed by a hundredth of a radian per seed, with joint limits
and a bending term.

Every seed is kept in results/benchmarks/free_gaits.json as soon as it is done, with a hash of the package: an
interrupted run goes on, and a seed of another version of the package is run again. Words of the command line choose
problems ("box", "disc").
"""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

import numpy as np
from bench import REPORTS, clock, in_units, report, table
from scipy.optimize import minimize
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from serpenoid.gaits import TableGait
from serpenoid.optimise.multistart import as_solution
from serpenoid.optimise.program.prepared import Carried
from serpenoid.optimise.solve import solve
from serpenoid.optimise.solver import GaitSolver
from serpenoid.optimise.starts import random_gaits
from specimens import problem

SEEDS, RIVALS, CLOSE = 20, 20, 1e-6
PATIENCE = 45.0  # seconds: when L-BFGS has used more, no further seed is begun
SLOW = ("body.joint_speed_limit_rpm=12.0", "task.cycle_duration_s=10.0", "task.constraints.joint_speed_limits=true")
FREE = "free gait from the ellipse"
PROBLEMS = {
    "reach, w = 10": ("reach",),
    "reach, w = 100": ("reach", "task.c=1.25"),
    "broken joint": ("broken-joint",),
    FREE: ("snake10", "task.c=0.5", 'task.objectives=[{kind="displacement"}, {kind="bending", weight=0.001}]'),
    "turn in a box": ("turn-in-a-box",),
    "turn in a box, 12 rpm": ("turn-in-a-box", *SLOW),
    "disc obstacle": ("disc-obstacle",),
}
FEWER = {"broken joint": 10, FREE: 10, "turn in a box": 10, "turn in a box, 12 rpm": 5, "disc obstacle": 5}


@dataclass
class Run:
    """Processor seconds of the solve and of the certificate, iterations, objective (None: not certified), status."""

    seconds: float
    certificate: float
    iterations: int
    objective: float | None
    word: str


def package_hash() -> str:
    """Of all sources of the package and of this file."""
    root = Path(__file__).parents[1]
    files = sorted((root / "src").rglob("*.py")) + sorted((root / "problems").glob("*.toml"))
    return hashlib.sha256(b"".join(f.read_bytes() for f in [*files, Path(__file__)])).hexdigest()[:12]


class Kept:
    """Results by key, in a file that is written after every one."""

    def __init__(self, path: Path) -> None:
        self.path, self.package = path, package_hash()
        stored = json.loads(path.read_text()) if path.exists() else {}
        self.found = stored.get("found", {}) if stored.get("package") == self.package else {}

    def get(self, key: str, make: Callable[[], dict]) -> dict:
        if key not in self.found:
            self.found[key] = make()
            self.path.write_text(json.dumps({"package": self.package, "found": self.found}, indent=1) + "\n")
            sys.stderr.write(f"{key}: {self.found[key]}\n")
        return self.found[key]


def prepared(name: str, words: tuple[str, ...], count: int) -> tuple[GaitSolver, np.ndarray]:
    """A solver and its starts: random tables; of the free gait, the ellipse optimum with noise."""
    asked = problem(*words)
    if name != FREE:
        solver = GaitSolver(asked)
        return solver, random_gaits(solver, count, seed=0)
    best = solve(asked, starts=4).best.table
    solver = GaitSolver(asked, gait=TableGait.from_angles(best))
    noise = np.random.default_rng(0).normal(0, 0.01, (count, best.size))
    return solver, np.clip(best.ravel() + noise, *solver.gait_bounds())


def solved(kept: Kept, name: str, words: tuple[str, ...], seeds: int) -> list[Run]:
    """All seeds of a problem."""

    @cache
    def ready() -> tuple[GaitSolver, np.ndarray]:
        solver, starts = prepared(name, words, seeds)
        solver.prepare(starts[0])
        return solver, starts

    def one(seed: int) -> dict:
        solver, starts = ready()
        c = solver.problem.task.c
        begin = clock()
        answer = solver.solve(starts[seed], c)
        middle = clock()
        found = as_solution(solver, answer, c, polish=True)
        objective = found.cost if found.status.ok else None
        run = Run(middle - begin, clock() - middle, answer.iterations, objective, found.status.name.lower())
        return asdict(run)

    return [Run(**kept.get(f"{name} {seed}", lambda seed=seed: one(seed))) for seed in range(seeds)]


class Near(Exception):
    """The target was reached."""


def by_lbfgs(kept: Kept, words: tuple[str, ...], target: float) -> list[tuple[float, float]]:
    """(seconds, objective above the target) of each seed."""
    asked = problem(*words)
    solver = GaitSolver(asked)
    starts = random_gaits(solver, RIVALS, seed=0)

    def one(seed: int) -> dict:
        seconds, best = descent(solver, starts[seed], asked.task.c, target)
        return {"seconds": seconds, "above": best - target}

    found: list[dict] = []
    for seed in range(RIVALS):
        if sum(f["seconds"] for f in found) > PATIENCE:
            break
        found.append(kept.get(f"L-BFGS {seed}", lambda seed=seed: one(seed)))
    return [(f["seconds"], f["above"]) for f in found]


def descent(solver: GaitSolver, q: np.ndarray, c: float, target: float) -> tuple[float, float]:
    """Seconds until the target is reached or L-BFGS gives up, and the best objective."""
    _, ipopt = solver.prepared(Carried())
    p, n, made = solver.parameters(c, ()), 3 * solver.steps, ipopt.functions
    best = np.inf

    def value(angles: np.ndarray) -> tuple[float, np.ndarray]:
        nonlocal best
        x = solver.start(angles)
        f, slope = made["grad_f"](x, p)
        jacobian = made["jac_g"](x, p)[1].sparse()
        force = splu(csc_matrix(jacobian[:n, :n].T)).solve(slope.full()[:n, 0])
        best = min(best, float(f))
        if best <= target + CLOSE:
            raise Near
        return float(f), slope.full()[n:, 0] - jacobian[:n, n:].T @ force

    options = {"maxiter": 3000, "maxfun": 4000, "maxcor": 30, "ftol": 1e-15, "gtol": 1e-10}
    bounds, begin = list(zip(*solver.gait_bounds(), strict=True)), clock()
    with suppress(Near):
        minimize(value, q, jac=True, method="L-BFGS-B", bounds=bounds, options=options)
    return clock() - begin, best


def row(name: str, runs: list[Run]) -> list[str]:
    """A line of the table."""
    good = [r.objective for r in runs if r.objective is not None]
    best, seconds = min(good, default=np.inf), [r.seconds for r in runs]
    reach = sum(o <= best + CLOSE for o in good)
    failed = ", ".join(sorted({r.word for r in runs if r.word != "solved"})) or "none"
    return [
        name, f"{best:.7f}", f"{reach} of {len(runs)}", f"{len(good)} of {len(runs)}", failed,
        in_units(float(np.median(seconds))), in_units(max(seconds)),
        in_units(float(np.median([r.certificate for r in runs]))), f"{np.median([r.iterations for r in runs]):.0f}",
    ]  # fmt: skip


def main() -> None:
    kept = Kept(REPORTS / "free_gaits.json")
    chosen = sys.argv[1:]
    runs = {}
    for name, words in PROBLEMS.items():
        if not chosen or any(word in name for word in chosen):
            runs[name] = solved(kept, name, words, FEWER.get(name, SEEDS))
            sys.stderr.write(f"{row(name, runs[name])}\n")
    if chosen:
        return
    medians = {name: float(np.median([r.seconds for r in found])) for name, found in runs.items()}
    name = "reach, w = 10"
    best = min(r.objective for r in runs[name] if r.objective is not None)
    took, short = (np.array(x) for x in zip(*by_lbfgs(kept, PROBLEMS[name], best), strict=True))
    ratio = float(np.median(took)) / medians[name]
    slowest = max(medians["turn in a box"], medians["disc obstacle"])
    yes = {True: "yes", False: "no"}
    targets = [
        ["reach, median of 20 seeds", "0.5 s", in_units(medians[name]), yes[medians[name] <= 0.5]],
        ["reach, beside L-BFGS with adjoint gradients", "20x", f"{ratio:.0f}x", yes[ratio >= 20]],
        ["free gait from the ellipse optimum, median", "0.5 s", in_units(medians[FREE]), yes[medians[FREE] <= 0.5]],
        ["obstacle and box, slower median", "3 s", in_units(slowest), yes[slowest <= 3]],
    ]
    header = ["problem", "best objective", "reach the best", "certified", "otherwise", "median", "slowest",
              "certificate", "iterations"]  # fmt: skip
    report(
        "free_gaits",
        "Free gaits: robot-snake problems from random tables",
        table(["target", "asked", "found", "met"], targets),
        table(header, [row(name, found) for name, found in runs.items()]),
        f"L-BFGS-B on the reach problem, the first {len(took)} seeds: median {in_units(float(np.median(took)))}; "
        f"{int((short <= CLOSE).sum())} of {len(took)} come within {CLOSE:g} of the optimum, the others end "
        f"{', '.join(f'{s:.1e}' for s in short if s > CLOSE) or 'nowhere else'} above it.",
    )


if __name__ == "__main__":
    main()
