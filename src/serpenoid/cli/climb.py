"""`solve --ladder`: what larger families gain over the ellipse, each with its status."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from serpenoid import interrupts
from serpenoid.cli import options
from serpenoid.cli.claim import sign

if TYPE_CHECKING:
    from serpenoid.optimise.ladder import Step
    from serpenoid.problem import Problem


def climb_ladder(args: argparse.Namespace, problem: Problem) -> int:
    """Climb, write a folder per family, report."""
    from serpenoid.files.writing import write_json
    from serpenoid.optimise.ladder import FAMILIES, climb, unlike_cycles, was_stopped
    from serpenoid.results import default_folder, write_solution

    folder = options.output_folder(
        args, default_folder(problem, "ladder", args.starts, args.seed), problem.hash, args.starts, args.seed
    )
    with options.progress_bar(args, "families", FAMILIES) as advance:
        steps = climb(problem, args.starts, args.seed, advance)
        advance(len(steps))
    sign(args)
    for number, step in enumerate(steps, start=1):
        figures = not args.no_figures and step.solution.trajectory.status.ok
        write_solution(folder / f"{number}-{step.solution.gait.family}", step.solution, figures)
    rows = [
        {"family": s.name, "displacement_body_lengths": s.solution.trajectory.displacement, "cost": s.solution.cost,
         "dissipation": s.solution.trajectory.dissipation, "undulations_per_cycle": s.undulations if s.ok else None,
         "status": s.solution.status.name.lower()}
        for s in steps
    ]  # fmt: skip
    write_json(folder / "ladder.json", {"kind": "ladder", "problem": problem.name, "steps": rows})
    good = [step for step in steps if step.ok]
    if not args.no_figures and len(good) > 1:
        from serpenoid.plot.figures import save
        from serpenoid.plot.ladder import ladder_figure

        save(ladder_figure(good), folder, "ladder")
    lines = [
        f"{r['family']:20}{r['displacement_body_lengths']:10.4f} body lengths{r['dissipation']:10.4f}  {r['status']}"
        for r in rows
    ]
    unlike = unlike_cycles(good)
    lines += [] if unlike is None else [f"note: {unlike}"]
    options.report(args, rows, [*lines, f"written to {folder}"], folder)
    if interrupts.noted or was_stopped(steps):
        families = f"{len(good)} of {FAMILIES} families"
        options.complain(f"stopped after {families}, which are in {folder}. The same command begins anew.")
        return 130
    for step in steps:
        if not step.ok:
            options.complain(f"{step.name}: {step.solution.status.words}")
    if len(steps) < FAMILIES:
        options.complain(_not_climbed(steps))
    return 0 if len(good) == FAMILIES else 1


def _not_climbed(steps: tuple[Step, ...]) -> str:
    return f"the ladder ends at {steps[-1].name}: each family is started from the optimum of the one before"
