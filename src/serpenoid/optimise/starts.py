"""Random start gaits, seeded: uniform in the bounds, then shrunk until they respect the joint limits.

Where joints may bend to one side farther than to the other, a gait about the straight body is no start: it is moved by
a constant shape, too, as little shrunk as such a move allows. A gait of scale s moved by directions d_k (`steady`),

    angles(t) = s angles_0(t) + sum_k z_k angles(d_k),    0 <= s <= 1,

keeps the limits if its largest and its smallest angle of every joint do: a linear programme in s and z.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import linprog

from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.joint_range import limit_words
from serpenoid.optimise.solver import GaitSolver

TO_SPARE = 0.05  # of the limits
DRAWS = 400  # for a gait that keeps limits which are not the same to either side: of waves one in ten does, or none
LEAST = 0.05  # of a gait that is moved: what is shrunk more hardly moves the body


def random_gaits(solver: GaitSolver, count: int, seed: int) -> Floats:
    """`count` gaits within the problem's bounds and limits, shape (count, n). InputError: none was found."""
    rng = np.random.default_rng(seed)
    if solver.limits.even:
        return np.array([_shrink(solver, solver.family.sample(rng)) for _ in range(count)])
    return np.array([_drawn(solver, rng) for _ in range(count)])


def inside(solver: GaitSolver, q: Floats) -> Floats | None:
    """Gait q, or where it breaks limits that are not the same to either side the nearest like it; None: there is none.

    Under limits that are the same to either side a search begins at any gait.
    """
    if solver.limits.even or float(solver.excess(solver.table(q)).max()) <= 0:
        return q
    return _moved(solver, q)


def within(solver: GaitSolver, q: Floats, fraction: float) -> tuple[Floats, Floats]:
    """Bounds of +-fraction of each of the gait's own parameters, inside the problem's bounds."""
    if not 0 < fraction <= 1:
        raise InputError(f"`fraction` (--within) must be in (0, 1], got {fraction}. 0.3 is the paper's +-30 %.")
    lower, upper = solver.gait_bounds()
    ends = np.sort(np.stack([q * (1 - fraction), q * (1 + fraction)]), axis=0)
    return np.maximum(lower, ends[0]), np.minimum(upper, ends[1])


def _shrink(solver: GaitSolver, q: Floats) -> Floats:
    """Scale the joint angles of a gait so that all limits hold with 5 % to spare."""
    lower, upper = solver.gait_bounds()
    if not solver.limits.any:
        return np.clip(q, lower, upper)
    finite = np.isfinite(solver.limits.upper)
    excess = solver.excess(solver.tables(q[None]))[0][:, finite]
    ratio = (excess / solver.limits.upper[finite]).max() + 1
    return np.clip(q if ratio <= 1 else solver.family.scaled(q, 0.95 / ratio), lower, upper)


def _drawn(solver: GaitSolver, rng: np.random.Generator) -> Floats:
    """The first of random gaits that can be moved inside the limits.

    A free table is cut off at them instead, where that leaves a motion: joints that pause at their limits lead to
    better optima than those that swing about the middles of their ranges.
    """
    for _ in range(DRAWS):
        drawn = solver.family.sample(rng)
        if solver.family.free:
            cut = np.clip(drawn, *solver.gait_bounds())
            if solver.family.moves(cut) and float(solver.excess(solver.table(cut)).max()) <= 0:
                return cut
        found = _moved(solver, drawn)
        if found is not None:
            return found
    limit, family = solver.problem.joint_limit_deg, solver.family.like.family
    words = "its limits" if limit is None else f"{limit_words(limit)} degrees"
    why = "widen the bounds, or the limit."
    if solver.family.coordinates == "serpenoid":
        why = (
            "a wave along the body bends to both sides, unless it is longer than the body. Take the family "
            "`fourier-joints`, `spline` or `table`, or allow a lower `xi`."
        )
    raise InputError(
        f"[body] joint_limit_deg: no gait of family `{family}` that [task.bounds] allows was found to keep every joint "
        f"within {words}: {why}"
    )


def _moved(solver: GaitSolver, q: Floats) -> Floats | None:
    """A gait like q inside limits and bounds with 5 % to spare, as large as can be; None where that is next to none."""
    family, limits, directions = solver.family, solver.limits, solver.family.steady
    still, (least, most) = family.scaled(q, 0.0), solver.gait_bounds()
    tables = solver.tables(np.array([q, still, *(still + directions)]))
    table, shapes = tables[0], tables[2:, 0] - tables[1, 0]
    m = family.joints
    half = (limits.upper[:m] - limits.lower[:m]) / 2
    low, high = limits.lower[:m] + TO_SPARE * half, limits.upper[:m] - TO_SPARE * half
    # rows: angles of every joint at their largest and smallest, then every bounded parameter, of s and z
    own = np.array([table.max(axis=0), -table.min(axis=0)])
    numbers, above, below = np.column_stack([q - still, directions.T]), np.isfinite(most), np.isfinite(least)
    rows = [np.column_stack([own[0], shapes.T]), np.column_stack([own[1], -shapes.T]), numbers[above], -numbers[below]]
    ends = [high, -low, (most - still)[above], (still - least)[below]]
    free = [(None, None)] * len(directions)
    price = np.array([-1.0, *[0.0] * len(directions)])
    found = linprog(price, np.vstack(rows), np.concatenate(ends), bounds=[(0, _slow_enough(solver, table)), *free])
    if found.status or found.x[0] < LEAST:
        return None
    return np.asarray(np.clip(still + numbers @ found.x, least, most))


def _slow_enough(solver: GaitSolver, table: Floats) -> float:
    """The largest scale, at most 1, at which a table's joints keep their speed limits with 5 % to spare."""
    most = solver.limits.upper[table.shape[1] :]
    moving = np.isfinite(most)
    excess = solver.excess(table)[:, table.shape[1] :][:, moving]
    fastest = float(np.max(excess / most[moving], initial=-1.0)) + 1
    return 1.0 if fastest <= 1 - TO_SPARE else (1 - TO_SPARE) / fastest
