"""Lines of a summary that say what a gait makes of what its problem file asks, and what it costs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from serpenoid.media import LAWS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from serpenoid.optimise.clearance import Clearance
    from serpenoid.optimise.mesh import MeshStudy
    from serpenoid.optimise.solution import SelfClear


def dissipation_name(law: str) -> str:
    """Begins the line of the dissipation, T^(degree - 1) E: what does not depend on the number of steps."""
    factor = {0: "", 1: "T*"}.get(power := LAWS[law].degree - 1, f"T^{power}*")
    return f"dissipation {factor}E".ljust(18)


def goal_lines(record: dict[str, Any]) -> list[str]:
    """One line for every goal there is something to say of; none of a record that is older than they are."""
    return [f"goal              {words}" for words in record.get("goals", [])]


def mesh_lines(mesh: MeshStudy, goals: Sequence[str], remedy: str, what: str = "") -> list[str]:
    """What more steps make of this gait, and what that means for goals; remedy: how to solve or simulate with more."""
    from serpenoid.optimise.refine import REFINED

    lines = [f"mesh              {what}{mesh.words}"]
    if not goals or mesh.within(REFINED):
        return lines
    return [*lines, f"{'':18}goals are judged with {mesh.steps} steps; with more they may be missed by that error: {remedy}"]


def clear_lines(obstacles: Clearance | None, own: SelfClear | None) -> list[str]:
    """What is proven of the body's distance from obstacles and from itself."""
    lines = [f"clearance         {obstacles.words}"] if obstacles else []
    return [*lines, *([f"from itself       {own.words}"] if own else [])]
