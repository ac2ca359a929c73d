"""What `solve` does with a problem that has `[lift]`: gaits in space."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from serpenoid.cli import options
from serpenoid.cli.claim import sign
from serpenoid.errors import InputError

if TYPE_CHECKING:
    from serpenoid.optimise.in_space import SpatialSolution
    from serpenoid.problem import Problem


def solve(args: argparse.Namespace, problem: Problem) -> int:
    """Solve, write, report."""
    from serpenoid.optimise.in_space import solve_in_space
    from serpenoid.results import default_folder
    from serpenoid.status import Status
    from serpenoid.studies.space_results import write_in_space

    if args.ladder or args.improve or args.refine:
        raise InputError("[lift]: --ladder, --improve and --refine are for gaits in the plane; leave them out.")
    key = ["space", args.starts, args.seed]
    folder = options.output_folder(args, default_folder(problem, *key), problem.hash, *key)
    with options.progress_bar(args, "starts", args.starts) as advance:
        found = solve_in_space(
            problem, args.starts, args.seed, lambda done, best: advance(done, f"best cost {best.cost:.6f}")
        )
    sign(args)
    record = write_in_space(folder, found, not args.no_figures)
    options.report(args, record, [*_lines(found), f"written to        {folder}"], folder)
    if len(found) < args.starts or any(s.status is Status.STOPPED for s in found):
        options.complain(f"stopped after {len(found)} of {args.starts} starts; the best is in {folder}")
        return 130
    if not found[0].status.ok:
        options.complain(found[0].status.value)
        return 1
    return 0


def _lines(found: list[SpatialSolution]) -> list[str]:
    best = found[0]
    a, xi, phase, bias = best.q
    gain = "not tried" if best.polishing_gain is None else f"{best.polishing_gain:.1e}"
    return [
        f"status            {best.status.words}",
        f"displacement      {best.motion.displacement:.6f} body lengths per cycle, "
        f"{best.sideways_deg:.0f} degrees off the body's axis",
        f"heading change    {options.signed(best.motion.heading_change)} rad",
        f"dissipation T*E   {best.motion.dissipation:.6f}",
        f"cost              {best.cost:.6f} at c = {best.c:g}",
        f"gait              a {a:.4f}, xi {xi:.4f}, lifted {phase:+.4f} cycles behind, bias {bias:+.4f}",
        f"on the floor      tilted by {best.motion.tilt:.4f} rad at most; the centre of mass is held by what rests in "
        f"{100 * best.standing:.0f} % of the rows",
        f"certificate       KKT {best.residuals.largest:.1e}, re-simulation {best.resimulation_error:.1e}, "
        f"polishing gain {gain}",
        f"mesh              {best.mesh.words}",
        f"starts            {sum(s.status.ok for s in found)} of {len(found)} certified",
    ]
