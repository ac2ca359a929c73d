"""What many starts found, in words, from the record that `solve` writes and `show` reads."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from serpenoid.cli.claim import has_solved
from serpenoid.wording import FOUND_ONCE, listed, some_and_more

if TYPE_CHECKING:
    from pathlib import Path

    from serpenoid.optimise.multistart import MultiStart
    from serpenoid.optimise.refine import Refined

MOST_BOUNDS = 4  # that a line lists


def summary(result: MultiStart, starts: int, seed: int) -> dict[str, Any]:
    """What solution.json holds of the starts."""
    optima = [{"cost": o.solution.cost, "starts": o.count, "gait": o.solution.gait.document()} for o in result.optima]
    coarse = [{"cost": o.solution.cost, "starts": o.count} for o in result.better_but_coarse]
    return {
        "starts": starts,
        "seed": seed,
        "steps": result.solutions[0].mesh.steps,
        "kept_from_an_earlier_run": result.kept,
        "optima": optima,
        "better_but_coarse": coarse,
        "failures": [s.status.name.lower() for s in result.failures],
        "costs": [s.cost if s.status.ok else None for s in result.solutions],
    }


def left_in(folders: Sequence[Path], what: str) -> str:
    """What of its points, or starts, a command that was stopped has solved, and how to go on."""
    kept = [str(folder) for folder in folders if has_solved(folder)]
    if not kept:
        return f"No {what} was solved yet; the same command begins anew."
    return f"Solved {what}s are kept in {listed(kept)}; the same command goes on from there."


def refinement(refined: Refined) -> dict[str, Any]:
    """What solution.json holds of meshes that were solved after the starts'."""
    failed = refined.failed
    return {
        "stopped": refined.stopped,
        "seconds": refined.seconds,
        "failed": None if failed is None else {"steps": failed.mesh.steps, "status": failed.status.name.lower()},
    }


def certificate_line(kkt: str, moved: str | None, gain: str) -> str:
    """How a gait fared with which an NLP ended; moved: the difference of poses, None of a gait that took its place."""
    if moved is None:
        return "certificate       none: nothing was confirmed of this gait"
    return f"certificate       KKT {kkt}, re-simulation {moved}, polishing gain {gain}"


def starts_lines(record: dict[str, Any]) -> list[str]:
    """Which optima the starts found, what kept the others from being one, and whether better ones were refused."""
    found, steps = record["multi_start"], record["mesh"]["steps"][0]
    first = found.get("steps", steps)  # not in older records
    refined = first != steps
    reasons = ", ".join(f"{count} {reason}" for reason, count in Counter(found["failures"]).most_common())
    on = f" with {first} steps" * refined
    lines = [f"optima found      {_costs(found['optima']) or 'none'}{on}; failed starts: {reasons or 0}"]
    better = found.get("better_but_coarse", [])
    best = found["optima"][:1]
    if refined:  # of those that were solved again the one that the answer has come from, by its cost
        best = sorted([*best, *better], key=lambda o: abs(o["cost"] - record["cost"]))[:1]
    if best and best[0]["starts"] == 1:
        lines.append(f"{'':18}the best was {FOUND_ONCE} (--starts)")
    coarse = _costs(better)
    if refined:
        lines += [f"refused           {coarse}{on}: that mesh is too coarse for them"] * bool(coarse)
        return [*lines, f"refined           {record['cost']:z.6f} with {steps} steps", *_failed_lines(record)]
    name = "better, refused" if found["optima"] else "refused"
    remedy = "; solve with --refine, or with more task.steps" * ("refinement" not in record)
    lines += [f"{name:18}{coarse}: {steps} steps are too coarse for them{remedy}"] * bool(coarse)
    return lines + _failed_lines(record)


def _failed_lines(record: dict[str, Any]) -> list[str]:
    """Which finer mesh did not hold."""
    failed = record.get("refinement", {}).get("failed")
    if failed is None:
        return []
    kept = f"{record['mesh']['steps'][0]} steps are the finest that converged, and are kept"
    return [f"not refined       {failed['steps']} steps ended as {failed['status']}; {kept}"]


def _costs(optima: Sequence[dict[str, Any]]) -> str:
    return ", ".join(f"{o['cost']:z.6f} ({o['starts']}x)" for o in optima)


def note_lines(note: str | None) -> list[str]:
    """A line of what is to be known of an optimum."""
    return [] if note is None else [f"note              {note}"]


def bound_lines(at_bounds: Sequence[str]) -> list[str]:
    """Which parameters of a gait ended where the optimiser may not look farther."""
    if not at_bounds:
        return []
    shown = some_and_more(at_bounds, MOST_BOUNDS)
    sections = sorted({"[lift]" if name.startswith("lift.") else "[task.bounds]" for name in at_bounds}, reverse=True)
    return [f"at its bounds     {shown}: {' and '.join(sections)} may be widened, if the body can do more"]
