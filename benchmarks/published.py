"""Published problems: what 20 random starts find, beside the numbers of the sources and an independent simulator.

`serpenoid solve problems/<file>.toml --starts 20`: a start counts as certified if its KKT conditions hold, step-by-step
simulation agrees, the mesh is fine enough and (obstacles) the clearance is proven; the best of each optimum is
polished. The best gait of each problem is laid out again by the simulator of the tests, which shares no code with the
package (SciPy's root of the paper's formulas): the largest difference of any pose, and of the objective of its motion.

Swimmers of N equal links: least dissipation per way among all ellipses of small joint angles, an eigenvalue problem of
the independent simulator, beside what a free gait of three harmonics needs for 0.001 body lengths. Lighthill's
sawtooth: the most efficient free gait of chains of growing length, the best of searches from serpenoid waves of several
lengths. Its expected numbers follow from resistive-force theory (docs/theory.md).

Solved starts are kept in results/published, finished lines in results/benchmarks/published.json, and not made again by
the same version of the package. Words of the command line choose lines ("box", "3 links", "40 edges").
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from bench import REPORTS, report, table
from free_gaits import Kept, package_hash

from oracle.chain import serpenoid_joint_table
from oracle.integrator import Run
from oracle.resistive_force import sawtooth_angle, sawtooth_efficiency, tangent_angles
from oracle.small_strokes import cheapest_stroke
from serpenoid.gaits import TableGait
from serpenoid.optimise.multistart import MultiStart
from serpenoid.optimise.solution import Solution
from serpenoid.optimise.solve import solve, solve_from
from specimens import oracle_run, problem

SEEDS = 20
KEPT = REPORTS.parent / "published"
LINKS = (3, 4, 5, 7, 9)
EDGES = (10, 20, 30, 40)  # of the chains whose best gait is laid beside Lighthill's sawtooth
WAVES = (16, 20, 24)  # edges per wave where those searches begin
EPS = 0.5  # drag ratio 2


OBJECTIVES = """\
Objectives, lengths in body lengths, T E the dissipation at total weight 1: best displacement -d; best efficiency
-d^2 / (2 T E), 1 / eps times minus Lighthill's; places 5 |b - target|^2 + (w / 0.01) E, b the centroid after the last
step, E the sum of the step energies at total weight 0.01, w = 10 where nothing else is said; turn
5 (heading - pi)^2 and the same. Of several optima the source's is shown, or the best."""
SWIMMERS = """\
## Swimmers of N equal links, drag ratio 2, small strokes

Dissipation T E per body length: of the eigenvalue problem in the limit of small ways, of the free gait (three harmonics
per joint) at 0.001 body lengths, where it has grown a little. Alouges et al. (2019): one ellipse whatever N, and for
large N a travelling wave of the shortest wavelength, three links, whose joints follow each other by 120 degrees."""


@dataclass(frozen=True)
class Published:
    """A problem: file and changes, what its source says, what is shown of a solution, its objective from a motion.

    known: objective of the source's optimum, if it gives one: of several optima the nearest is shown, else the best.
    """

    words: tuple[str, ...]
    says: str
    shown: Callable[[Solution], str]
    objective: Callable[[Solution, Run], float]
    known: float | None = None


def placed(solution: Solution, laid: Run) -> float:
    """5 |b - target|^2 + c T E."""
    target = solution.problem.task.objectives[0].model_dump()["target"]
    return 5 * float(np.sum((laid.poses[-1, :2] - target) ** 2)) + solution.c * laid.dissipation


def turned(solution: Solution, laid: Run) -> float:
    """5 (heading - pi)^2 + c T E."""
    return 5 * float(laid.poses[-1, 2] - np.pi) ** 2 + solution.c * laid.dissipation


def spent(solution: Solution, laid: Run) -> float:
    """-displacement^2 / (2 T E)."""
    return -(laid.displacement**2) / (2 * laid.dissipation)


def lengths(solution: Solution) -> str:
    """Displacement for many steps."""
    return f"{solution.mesh.displacement:.5f} lengths"


def percent(solution: Solution) -> str:
    """Lighthill's efficiency, and the displacement."""
    return f"efficiency {-EPS * solution.cost:.5f}, {lengths(solution)}"


def place(solution: Solution) -> str:
    """Where the last step ends."""
    x, y = np.round(solution.trajectory.poses[-1, :2], 4) + 0.0  # no minus before a zero
    return f"to ({x:.4f}, {y:.4f})"


def heading(solution: Solution) -> str:
    """How far it turns."""
    return f"by {solution.trajectory.heading_change / np.pi:.4f} pi"


PROBLEMS = {
    "Purcell, best displacement": Published(
        ("purcell-stroke",), "0.1035 lengths", lengths, lambda _, laid: -laid.displacement, -0.1035
    ),
    "Purcell, best efficiency": Published(("purcell-efficiency",), "a round loop", percent, spent),
    "Lighthill, 20 edges": Published(("lighthill",), "efficiency below 0.08579", percent, spent),
    "straight line, w = 10": Published(("reach",), "to (1, 0)", place, placed),
    "straight line, w = 100": Published(("reach", "task.c=1.25"), "to (1, 0)", place, placed),
    "broken joint": Published(("broken-joint",), "to (1.3, 0)", place, placed),
    "turn in a box": Published(("turn-in-a-box",), "by pi", heading, turned),
    "disc obstacle": Published(("disc-obstacle",), "to (2.5, 0)", place, placed),
}


def laid_out(solution: Solution) -> Run:
    """The same gait by the independent simulator; a joint that is stuck stays where it is."""
    joints = solution.table.copy()
    for effect in solution.problem.effects:
        joints[:, (effect.place or 0) - 1] = effect.parameters["angle"]
    return oracle_run(solution.problem.model, joints, closed=not solution.problem.task.transient)


def row(name: str, published: Published, result: MultiStart) -> list[str]:
    """A line of the table."""
    known = -np.inf if published.known is None else published.known
    optimum = min(result.optima, key=lambda o: abs(o.solution.cost - max(known, result.best.cost)))
    best = optimum.solution
    laid = laid_out(best)
    apart = np.abs(laid.poses - best.trajectory.poses).max()
    value = abs(published.objective(best, laid) - best.cost)
    others = ", ".join(f"{o.solution.cost:.7f} ({o.count}x)" for o in result.optima if o is not optimum) or "none"
    missed = ", ".join(sorted({s.status.name.lower() for s in result.failures})) or "none"
    return [
        name, published.words[0], published.says, published.shown(best), f"{best.cost:.7f}",
        f"{optimum.count} of {SEEDS}", others, f"{SEEDS - len(result.failures)} of {SEEDS}", missed,
        f"{apart:.0e}", f"{value:.0e}",
    ]  # fmt: skip


def searched(name: str, published: Published) -> list[str]:
    """All starts of a problem, and its line."""
    folder = KEPT / package_hash() / "-".join(published.words)
    result = solve(problem(*published.words), SEEDS, seed=0, folder=folder)
    return row(name, published, result)


def small_strokes(links: int) -> list[str]:
    """Least dissipation per way of a swimmer of equal links: eigenvalue problem, free gait, lag from joint to joint."""
    per_link, steps = 4, 12
    cheapest = cheapest_stroke(links, per_link, EPS, steps)
    joints = str([per_link * k for k in range(1, links)])
    changes = f"body.vertices={per_link * links + 1}", f"body.joints={joints}", f"task.steps={steps}"
    found = solve(problem("five-links", *changes), starts=1, seed=0).best
    dearness = found.trajectory.dissipation / found.trajectory.displacement
    lags = np.abs(cheapest.lags)
    return [
        str(links), f"{cheapest.energy:.5f}", f"{dearness:.5f}", f"{100 * (dearness / cheapest.energy - 1):+.2f} %",
        f"{lags.min():.1f} to {lags.max():.1f}", found.status.name.lower(),
    ]  # fmt: skip


def sawtooth(edges: int) -> list[str]:
    """The most efficient free gait of a chain beside Lighthill's: from waves of several lengths, the best."""
    asked = problem("lighthill", f"body.vertices={edges + 1}", f"task.steps={max(40, 2 * edges)}")
    found = []
    for per_wave in WAVES:
        waves = max(1.0, edges / per_wave)
        joints = serpenoid_joint_table(np.ones(edges), asked.task.steps, sigma=1.0, a=2 * np.pi * waves, xi=waves)
        found.append(solve_from(asked, TableGait.from_angles(joints)))
    best = min((s for s in found if s.status.ok), key=lambda s: s.cost)
    angle, spread = tangent_angles(best.trajectory.vertices)
    laid = laid_out(best)
    reached = -EPS * best.cost
    return [
        str(edges), f"{reached:.5f}", f"{reached / sawtooth_efficiency(EPS):.3f}", f"{np.rad2deg(angle):.1f}",
        f"{spread:.3f}", f"{abs(spent(best, laid) - best.cost):.0e}",
    ]  # fmt: skip


def main() -> None:
    header = ["problem", "file", "source", "here", "objective", "reach it", "other optima", "certified", "otherwise",
              "simulators differ: poses", "objective"]  # fmt: skip
    chosen = sys.argv[1:]
    kept = Kept(REPORTS / "published.json")
    makers: dict[str, Callable[[], list[str]]] = {
        **{name: partial(searched, name, published) for name, published in PROBLEMS.items()},
        **{f"{n} links": partial(small_strokes, n) for n in LINKS},
        **{f"{n} edges": partial(sawtooth, n) for n in EDGES},
    }
    lines = {
        name: kept.get(name, lambda make=make: {"line": make()})["line"]  # type: ignore[misc]
        for name, make in makers.items()
        if not chosen or any(word in name for word in chosen)
    }
    if chosen:
        return
    rows, links, chains = (
        [lines[name] for name in names]
        for names in (PROBLEMS, (f"{n} links" for n in LINKS), (f"{n} edges" for n in EDGES))
    )
    report(
        "published",
        "Published problems",
        OBJECTIVES,
        table(header, rows),
        SWIMMERS,
        table(["links", "eigenvalue problem", "free gait", "more", "lag of joints [degrees]", "status"], links),
        "## Lighthill's sawtooth, drag ratio 2\n\nExpected of an infinite chain: efficiency "
        f"{sawtooth_efficiency(EPS):.5f}, angle {np.rad2deg(sawtooth_angle(EPS)):.2f} degrees, rms over mean 1 (a "
        "sine: 1.111). The angles are those of the middle half of the body to its way, their median over all steps.",
        table(["edges", "efficiency", "of Lighthill's", "angle", "rms over mean", "simulators differ"], chains),
    )


if __name__ == "__main__":
    main()
