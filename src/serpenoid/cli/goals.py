"""Lines of a summary that say what a gait makes of what its problem file asks, and what it costs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from serpenoid.media import LAWS
from serpenoid.wording import counted

if TYPE_CHECKING:
    from collections.abc import Sequence

    from serpenoid.optimise.clear.clearance import Clearance
    from serpenoid.optimise.solution import SelfClear
    from serpenoid.problem import Problem
    from serpenoid.simulation.mesh import MeshStudy


def dissipation_name(law: str) -> str:
    """Begins the line of the dissipation, T^(degree - 1) E: what does not depend on the number of steps."""
    factor = {0: "", 1: "T*"}.get(power := LAWS[law].degree - 1, f"T^{power}*")
    return f"dissipation {factor}E".ljust(18)


def in_cycles(cycles: int) -> str:
    """Ends a number that is of so many cycles together."""
    return f" in {counted(cycles, 'cycle')}"


def speed_lines(problem: Problem, displacement: float, cycles: int = 1) -> list[str]:
    """Displacement [body lengths] of so many cycles, per cycle and per second, and in metres, as far as known."""
    length, duration = problem.body.told_length_m, problem.task.cycle_duration_s
    each = displacement / cycles
    per_cycle = "" if problem.task.transient else " per cycle"
    said = [f"{each:z.4g} body lengths{per_cycle}"] * (cycles > 1)
    said += [] if length is None else [f"{each * length:z.4g} m{per_cycle}"]
    said += [] if duration is None else [f"{each / duration:z.4g} body lengths/s"]
    said += [] if duration is None or length is None else [f"{each * length / duration:z.4g} m/s"]
    return [f"speed             {', '.join(said)}"] * bool(said)


def goal_lines(record: dict[str, Any]) -> list[str]:
    """One line for every goal there is something to say of; none of a record that is older than they are."""
    return [f"goal              {words}" for words in record.get("goals", [])]


def mesh_lines(mesh: MeshStudy, goals: Sequence[str], remedy: str, what: str = "") -> list[str]:
    """What more steps make of this gait, and what that means for goals; remedy: how to solve or simulate with more."""
    from serpenoid.optimise.refine import REFINED

    lines = [f"mesh              {what}{mesh.words}"]
    lines += [f"warning           {mesh.too_coarse}: {remedy}"] * bool(mesh.too_coarse)
    if mesh.within(REFINED) or not any(" met" in goal for goal in goals):
        return lines
    which = "goals that are met are met" if any("missed" in goal for goal in goals) else "goals are met"
    said = f"{which} with {mesh.steps} steps; with many the same gait may miss them by this error: {remedy}"
    return [*lines, f"{'':18}{said}"]


def clear_lines(
    obstacles: Clearance | None, fine: Clearance | None, own: SelfClear | None, steps: int, remedy: str
) -> list[str]:
    """What is proven of the body's distance from obstacles (fine: with FINER times as many steps) and from itself."""
    from serpenoid.objectives.obstacles import DEEP
    from serpenoid.simulation.mesh import FINER

    of_itself = [f"from itself       {own.words}"] if own else []
    if obstacles is None:
        return of_itself
    lines = [f"clearance         {obstacles.words_of(f' of the motion in {steps} steps')}"]
    if fine is None:
        return [*lines, *of_itself]
    finer = f"in {FINER * steps} steps"
    if fine.least < -DEEP:
        keep = f"Ask for that much more `clearance`, or for more steps ({remedy})"
        near = f"the same gait {finer} comes {-fine.least:.2e} body lengths nearer to obstacles than it may. {keep}"
        return [*lines, f"warning           {near}.", *of_itself]
    return [*lines, f"{'':18}{finer} {fine.words}", *of_itself]
