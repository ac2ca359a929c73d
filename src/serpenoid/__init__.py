"""Optimal gaits for limbless robots and animals: simulate, optimise, play, measure, diagnose."""

from __future__ import annotations

from serpenoid.version import __version__ as __version__

TYPE_CHECKING = False  # as type checkers read it; `typing` would be imported before Ctrl-C is looked after
if TYPE_CHECKING:
    from typing import Any

    from serpenoid.mechanics.opened import step_functions
    from serpenoid.objectives import Criteria
    from serpenoid.optimise.own import certify_table
    from serpenoid.optimise.program.nlp import gait_nlp, nlp_arguments
    from serpenoid.optimise.solve import improve, solve, solve_from
    from serpenoid.problem import Problem, load
    from serpenoid.results import write_simulation, write_solution
    from serpenoid.simulation import (
        simulate_batch,
        simulate_in_space,
        simulate_joint_angles,
        simulate_realised,
        simulate_vertices,
    )
    from serpenoid.simulation.problem import simulate
    from serpenoid.studies.sweep import sweep
    from serpenoid.studies.verbs import compare, diagnose, fit, measure

# public name -> module: imported on first use, so that `import serpenoid` and `--help` stay quick
_PUBLIC = {
    "load": "serpenoid.problem",
    "Problem": "serpenoid.problem",
    "simulate": "serpenoid.simulation.problem",
    "simulate_joint_angles": "serpenoid.simulation",
    "simulate_realised": "serpenoid.simulation",
    "simulate_vertices": "serpenoid.simulation",
    "simulate_batch": "serpenoid.simulation",
    "simulate_in_space": "serpenoid.simulation",
    "solve": "serpenoid.optimise.solve",
    "solve_from": "serpenoid.optimise.solve",
    "improve": "serpenoid.optimise.solve",
    "Criteria": "serpenoid.objectives",
    "gait_nlp": "serpenoid.optimise.program.nlp",
    "nlp_arguments": "serpenoid.optimise.program.nlp",
    "certify_table": "serpenoid.optimise.own",
    "step_functions": "serpenoid.mechanics.opened",
    "sweep": "serpenoid.studies.sweep",
    "measure": "serpenoid.studies.verbs",
    "fit": "serpenoid.studies.verbs",
    "compare": "serpenoid.studies.verbs",
    "diagnose": "serpenoid.studies.verbs",
    "write_simulation": "serpenoid.results",
    "write_solution": "serpenoid.results",
}

__all__ = [
    "Criteria",
    "Problem",
    "certify_table",
    "compare",
    "diagnose",
    "fit",
    "gait_nlp",
    "improve",
    "load",
    "measure",
    "nlp_arguments",
    "simulate",
    "simulate_batch",
    "simulate_in_space",
    "simulate_joint_angles",
    "simulate_realised",
    "simulate_vertices",
    "solve",
    "solve_from",
    "step_functions",
    "sweep",
    "write_simulation",
    "write_solution",
]


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module 'serpenoid' has no attribute {name!r}")
    import importlib

    return getattr(importlib.import_module(_PUBLIC[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
