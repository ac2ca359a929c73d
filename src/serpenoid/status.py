"""How a computation ended: a value with a sentence and a remedy, not an exception from five layers below."""

from __future__ import annotations

from enum import Enum


class Status(Enum):
    """Outcome of a simulation or of an optimisation; the text says what to do."""

    SOLVED = "solved"
    STOPPED = "stopped by the user; the last iterate is kept and is no optimum"
    STEP_UNSOLVED = "a step has no root within the tolerance: use more steps per cycle, or a smaller amplitude"
    BAD_SHAPE = "a shape has an edge of length zero or a number that is not finite: check the joint table"
    NOT_CONVERGED = "IPOPT did not converge: try another start (--seed), fewer constraints or a lower amplitude"
    NOT_A_NUMBER = (
        "what is asked is not a number (NaN) at this gait: of your own terms, keep roots, logarithms and quotients "
        "defined for every gait, or try another start"
    )
    INFEASIBLE = "no start met all constraints: relax a limit, a bound or a demand, or try more starts"
    RESIMULATION_DISAGREES = "step-by-step simulation does not confirm the optimum: use more steps per cycle"
    NOT_STATIONARY = "the optimality conditions do not hold to 1e-8: try another start, or free a bound"
    MESH_TOO_COARSE = "the displacement depends on the number of steps: solve with --refine, or with more task.steps"
    COLLIDES = "the body comes too near to an obstacle between rows or vertices: use more steps, or a larger clearance"
    TOUCHES_ITSELF = "the body comes too near to itself: use another start, smaller joint limits, or more steps"
    EXCEEDS_LIMITS = "a joint limit is exceeded between the rows that were watched: use another start, or report this"
    NOT_A_MINIMUM = "a derivative-free search nearby found a better gait (a saddle point): try another start"

    @property
    def words(self) -> str:
        """`name: sentence`, or the one word that says it all."""
        name = self.name.lower()
        return name if name == self.value else f"{name}: {self.value}"

    @property
    def ok(self) -> bool:
        """True for success."""
        return self is Status.SOLVED
