"""Why nothing moves: what no gait can change, and what to ask for where standing still is as good as any gait.

A joint alone goes through its angles there and back; what a step does is undone by the same step backwards, and after a
cycle the body is where it was. Source: Purcell, Am. J. Phys. 45, 1977 (scallop theorem).
"""

from __future__ import annotations

from serpenoid.problem import Problem

ISOTROPIC = "anisotropy_ratio = 1 is isotropic: nothing moves, whatever the gait. Give a ratio below 1."
ONE_JOINT = (
    "one joint alone moves no body, whatever the gait: it bends there and back, and after a cycle the body is where it "
    "was (scallop theorem). Give [body] a second joint: more `vertices`, or more `joints`."
)
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
    if problem.body.joint_count == 1 and not problem.task.transient and not cases_may_differ:
        return ONE_JOINT
    return None


def rest_note(problem: Problem, c: float) -> str:
    """What to say of an optimum than which a body at rest is no worse."""
    less = ", or give dissipation less weight (`c`)" if c > 0 else ""
    return f"a body that stands still does as well: {why_unmoved(problem) or f'{NOT_ASKED}{less}.'}"
