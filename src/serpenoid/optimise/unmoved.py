"""Why nothing moves: what no gait can change, and what to ask for where standing still is as good as any gait.

Scallop theorem: where a cycle runs through a curve of shapes and back through the same shapes, the body is where it was
after it. Every law here is a function of the squared slip, the same for a step and for the step back, so the step back
undoes the step; and forces grow with a power of the speed, so how fast the curve is run through does not count. One
joint has no other cycles. Nor have gaits whose shapes lie on a straight line in shape space, or repeat in reverse
order. That holds of all gaits within bounds if it holds of two drawn from them at random: joint angles are analytic
in the parameters, so what is zero of generic ones is zero of all. Source: Purcell, Am. J. Phys. 45, 1977.
"""

from __future__ import annotations

import numpy as np

from serpenoid.body import Floats
from serpenoid.problem import Problem

DRAWN = 2  # gaits; one would do
SAME_SHAPE = 1e-9  # of the largest change of a joint angle: far above rounding, far below any gait
WIDE = np.pi  # half the range that is drawn from where a parameter has no bounds: an angle's
ISOTROPIC = "anisotropy_ratio = 1 is isotropic: nothing moves, whatever the gait. Give another ratio."
ONE_JOINT = (
    "one joint alone moves no body, whatever the gait: it bends there and back, and after a cycle the body is where it "
    "was (scallop theorem). Give [body] a second joint: more `vertices`, or more `joints`."
)
THERE_AND_BACK = (
    "every gait that [task.bounds] allows runs through the same shapes there and back, and after a cycle the body is "
    "where it was (scallop theorem). Widen the bounds until the shapes can go round a loop: of an ellipse, a `sigma` "
    "other than 0."
)
ASKING = {"displacement", "transport", "efficiency"}  # objectives that no body at rest does well by
SPARING = {"bending", "effort"}  # objectives that moving costs
NOT_ASKED = (
    "no goal asks it to move. Ask for `displacement`, for a place or heading that it does not begin with, or demand "
    "`travel`"
)


def why_unmoved(problem: Problem) -> str | None:
    """Why no gait of this problem can move the body, and what to change; None: nothing forbids it."""
    if problem.effects or problem.lift is not None:
        return None
    if problem.medium.anisotropy_ratio == 1.0:
        return ISOTROPIC
    robust = problem.task.robust
    cases_may_differ = robust is not None and bool(robust.files)  # by effects of their own
    if problem.task.transient or cases_may_differ:
        return None
    if problem.body.joint_count == 1:
        return ONE_JOINT
    return THERE_AND_BACK if all(there_and_back(table) for table in _drawn(problem)) else None


def there_and_back(table: Floats) -> bool:
    """Whether a closed joint table (T, m) runs through a curve of shapes and back through the same shapes."""
    centred = table - table.mean(axis=0)
    tolerance = SAME_SHAPE * max(np.abs(centred).max(), np.finfo(float).tiny)
    on_a_line = np.linalg.matrix_rank(centred, tolerance * np.sqrt(centred.size)) <= 1
    back = table[::-1]
    return bool(on_a_line) or any(
        np.abs(np.roll(back, k, axis=0) - table).max() <= tolerance for k in range(len(table))
    )


def _drawn(problem: Problem) -> Floats:
    """Joint tables (B, T, m) of gaits drawn at random within the bounds."""
    from serpenoid.mechanics.tables import family_tables

    family, rng = problem.family_of(), np.random.default_rng(0)
    low, high = family.limits
    low, high = np.where(np.isfinite(low), low, -WIDE), np.where(np.isfinite(high), high, WIDE)
    return family_tables(problem.model, family, rng.uniform(low, np.maximum(low, high), (DRAWN, family.size)))


def rest_note(problem: Problem, c: float) -> str:
    """What to say of an optimum than which a body at rest is no worse."""
    return f"a body that stands still does as well: {why_unmoved(problem) or _outweighed(problem, c)}"


def _outweighed(problem: Problem, c: float) -> str:
    """Of a body that can move: whether nothing asks it to, or what speaks against it."""
    kinds = [term.kind for term in problem.task.objectives]
    if not ASKING.intersection(kinds):
        less = ", or give dissipation less weight (`c`)" if c > 0 else ""
        return f"{NOT_ASKED}{less}."
    against = [f"`c` (now {c:g})"] * (c > 0) + [f"the weight of `{kind}`" for kind in kinds if kind in SPARING]
    if not against:
        return "no gait that was found goes anywhere within the bounds, limits and demands. Widen them."
    return f"no gait that was found is worth what it costs. Lower {' or '.join(against)}."
