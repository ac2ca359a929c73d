"""Find the optimal gait of a problem file, certified, with its joint table.

    serpenoid solve problems/snake10.toml --c 1.0
    serpenoid solve problems/snake10.toml --c 1.0 --starts 100 --seed 7
    serpenoid solve problems/reach.toml                     # any goal, every joint angle of every row free
    serpenoid solve problems/snake10.toml --ladder          # what larger families gain over the ellipse
    serpenoid solve problems/snake10.toml --improve 12      # the paper's set: 12 random gaits, each improved within
                                                            # +-30 % of its own parameters, 24 gaits in all

minimises what [[task.objectives]] asks (default: -displacement) + c * dissipation over the parameters of the gait's
family, with the body's motion as constraints.
`c`, the dissipation coefficient, weighs the normalised dissipation T * E (T steps a cycle, E the energy summed over
them; total weight 1, lengths in body lengths, time in cycles), so it does not depend on the number of steps; 0 .. 2.5
is the range of Even et al.

An optimum counts only if step-by-step simulation reaches the same poses to 1e-8, the KKT conditions hold to 1e-8, a
derivative-free search around it gains less than 1e-6, and its displacement is the gait's and not the time mesh's:
simulated again with 2 T and 4 T steps, it is within 5 % of the extrapolated one (`--refine`: solved again with more
steps until it is within 0.1 %, the best of all starts, those too that are refused for a coarse mesh; the table then
has that many rows; where a finer mesh fails or is stopped, the finest that converged is kept). Exit code 1: no such
optimum was found.

Starts are independent: --jobs N and --cluster ADDRESS solve them at once, with the same answers to the last bit. Each
solved start is kept in the results folder; the same command goes on from there, and starts.csv has a line a start.
Ctrl-C keeps the best so far (a better one that is there from before stays) and exits with 130.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from serpenoid.cli import options
from serpenoid.cli.claim import sign
from serpenoid.cli.iterations import Iterations
from serpenoid.cli.starts import (
    MOST_BOUNDS,
    bound_lines,
    certificate_line,
    left_in,
    note_lines,
    refinement,
    starts_lines,
    summary,
)
from serpenoid.wording import counted

if TYPE_CHECKING:
    from serpenoid.optimise.multistart import MultiStart
    from serpenoid.optimise.refine import Refined
    from serpenoid.optimise.solution import Solution
    from serpenoid.problem import Problem

WITHIN = 0.3  # of a random gait's own parameters, as in the paper
KEPT = "Solved starts are kept: the same command goes on from there."
FAR_TURN_RAD = 0.5  # in one cycle; what the paper's robot does by a strong offset


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of `solve`."""
    options.add_problem(parser)
    parser.add_argument("--c", type=float, metavar="C", help="dissipation coefficient (default: the problem file's)")
    parser.add_argument("--starts", type=options.positive, default=12, metavar="N", help="random starts (default 12)")
    parser.add_argument("--seed", type=options.seed, default=0, help="seed of the random gaits (default 0)")
    parser.add_argument("--improve", type=options.positive, metavar="N", help="instead: N random gaits, each improved")
    parser.add_argument("--within", type=float, metavar="F", help=f"with --improve: +-F (default {WITHIN})")
    parser.add_argument(
        "--refine", action="store_true", help="solve again with more steps until the displacement is good to 0.1 %%"
    )
    parser.add_argument(
        "--ladder", action="store_true", help="instead: ellipse, Fourier series, free table, each from the one before"
    )
    options.add_workers(parser, "starts")
    options.add_output(parser, "results/<problem>/solve-<hash>")


def run(args: argparse.Namespace) -> int:
    """Solve, write, report."""
    from serpenoid.cli.climb import climb_ladder
    from serpenoid.problem import load

    _check_together(args)
    assignments = [*args.set, *([f"task.c={args.c!r}"] if args.c is not None else [])]
    problem = load(args.problem, assignments, args.model)
    options.warn_of_problem(problem)
    if args.ladder:
        return climb_ladder(args, problem)
    return _improve(args, problem) if args.improve else _solve(args, problem)


def _check_together(args: argparse.Namespace) -> None:
    """InputError where one option would do nothing beside, or without, another."""
    from serpenoid.errors import InputError

    if args.ladder and args.improve:
        raise InputError("--ladder and --improve: are two ways of searching; give one of them.")
    if args.within is not None and not args.improve:
        raise InputError(f"--within: says how far --improve may go, got {args.within:g} without it. Add --improve N?")
    if args.refine and (args.ladder or args.improve):
        other = "--ladder" if args.ladder else "--improve"
        raise InputError(
            f"--refine: is not known with {other}; leave it out, and give more steps (--set task.steps=N)."
        )


def _solve(args: argparse.Namespace, problem: Problem) -> int:
    from serpenoid.joint_limits import limit_lines
    from serpenoid.results import default_folder, weight_warning, write_solution
    from serpenoid.self_contact import crossing_warning
    from serpenoid.status import Status
    from serpenoid.studies.many_starts import write_starts

    folder = options.output_folder(
        args, default_folder(problem, "solve", *_options(args)), problem.hash, *_options(args)
    )
    args.kept_if_stopped = lambda: left_in([folder], "start")
    result = _search(args, problem, folder)
    stopped = len(result.solutions) < args.starts or any(s.status is Status.STOPPED for s in result.solutions)
    stopped |= any(optimum.solution.polishing_gain is None for optimum in result.optima)
    refined = _refine(args, result) if args.refine and not stopped else None
    best = result.best if refined is None else refined.solution
    halted = stopped or (refined is not None and refined.stopped)
    better = kept_better(folder, best) if halted else None
    if better is not None:
        earlier = f"keeps the answer of an earlier run, which is better (cost {better:.6f})"
        options.complain(f"stopped; {folder} {earlier}. {KEPT}")
        return 130
    if halted and not args.quiet:
        options.complain(f"stopping: the best so far is written{'' if args.no_figures else ', with its pictures'}")
    figures = not args.no_figures and best.trajectory.status.ok
    sign(args)
    write_starts(folder / "starts.csv", result)
    found = {"multi_start": summary(result, args.starts, args.seed)}
    found |= {} if refined is None else {"refinement": refinement(refined)}
    record = write_solution(folder, best, figures, found)
    if figures:
        from serpenoid.plot.figures import multistart_figures

        multistart_figures(folder, result)
    lines = [
        *_lines(best, result, record, refined),
        *limit_lines(problem, best.table),
        *crossing_warning(best.trajectory),
        *weight_warning(problem),
    ]
    lines += [f"written to        {folder}"]
    options.report(args, record, lines, folder)
    if halted:
        done = sum(s.status is not Status.STOPPED for s in result.solutions)
        when = f"after {done} of {counted(args.starts, 'start')}" if stopped else "while refining"
        what = f"the best is in {folder}"
        if refined is not None:
            refused = "" if best.status.ok else f" ({best.status.name.lower()})"
            what = f"the finest mesh that converged, of {best.mesh.steps} steps, is in {folder}{refused}"
        elif not best.status.ok:
            what = f"none is solved, and {folder} has the last iterate, which is no optimum"
        elif best.polishing_gain is None:
            what += ", not yet polished (the last part of its certificate; the same command goes on to it)"
        options.complain(f"stopped {when}; {what}. {KEPT}")
        return 130
    if not best.status.ok:
        failed = None if refined is None else refined.failed
        options.complain(_why(best) or best.message if failed is None else _why_coarse(best, failed))
        return 1
    return 0


def _search(args: argparse.Namespace, problem: Problem, folder: Path) -> MultiStart:
    """All starts, here or by workers; those that the folder has are not solved again."""
    from serpenoid.optimise.solve import solve
    from serpenoid.studies.many_starts import solve_starts

    workers, family = options.workers(args), problem.family_of()
    with options.progress_bar(args, "starts", args.starts) as advance:
        unknowns = family.pose_size * problem.task.steps + family.size
        news = Iterations(lambda done, text: advance(done, f"{text}, {unknowns} unknowns"))

        def progress(done: int, best: Solution | None) -> None:
            news.next_start(done)
            advance(done, "" if best is None else f"best cost {best.cost:z.6f}")

        if workers.jobs == 1 and workers.cluster is None:
            return solve(problem, args.starts, args.seed, progress=progress, folder=folder, watch=news)
        return solve_starts(problem, args.starts, args.seed, workers, progress, folder)


def _refine(args: argparse.Namespace, result: MultiStart) -> Refined:
    """The best of all starts on finer meshes; each counts by its number of steps."""
    from serpenoid.optimise.refine import DOUBLINGS, REFINED, refine_best

    done = steps = 0
    with options.progress_bar(args, "refining", 1) as advance:
        total = 1
        news = Iterations(lambda done, text: advance(done, text, total=total))

        def progress(solution: Solution) -> None:
            nonlocal done, steps, total
            done, steps = done + steps, 2 * solution.mesh.steps
            total = done + sum(solution.mesh.meshes(REFINED, DOUBLINGS))
            news.next_start(done, f"{steps} steps")
            advance(done, f"{steps} steps, {solution.mesh.steps} had cost {solution.cost:z.6f}", total=total)

        refined = refine_best(result, progress, news)
        if steps and not refined.stopped:
            advance(done + steps, f"cost {refined.solution.cost:z.6f}", total=done + steps)
    return refined


def kept_better(folder: Path, best: Solution) -> float | None:
    """Cost of the certified answer that is there to the same request, where `best` costs more or is none; else None.

    Of two meshes the finer has the better answer: a coarse one may promise more.
    """
    from serpenoid.errors import InputError
    from serpenoid.optimise.multistart import SAME_COST
    from serpenoid.results import read_record

    try:
        held = read_record(folder)
    except InputError:
        return None
    if held.get("status") != "solved" or not isinstance(held.get("cost"), float):
        return None
    steps = held["mesh"]["steps"][0]
    if best.status.ok and steps != best.mesh.steps:
        return held["cost"] if steps > best.mesh.steps else None
    return held["cost"] if not best.status.ok or best.cost > held["cost"] + SAME_COST else None


def _why_coarse(best: Solution, failed: Solution) -> str:
    """Of an optimum that is refused, and that no finer mesh confirms."""
    steps, status = failed.mesh.steps, failed.status.name.lower()
    return f"{best.mesh.steps} steps end as {best.status.name.lower()}, {steps} as {status}: try other starts (--seed)"


def _why(best: Solution) -> str | None:
    """What the problem file says about a failure; None: nothing."""
    from serpenoid.optimise.unmoved import why_unmoved
    from serpenoid.optimise.weights import why_unsolved
    from serpenoid.status import Status

    problem = best.problem
    heading = problem.task.constraints.heading_change_rad
    if why_unmoved(problem) is not None:
        return None
    if heading is not None and abs(heading) > FAR_TURN_RAD:
        return (
            f"task.constraints.heading_change_rad = {heading:g}: no gait was found that turns so far in one cycle. "
            "Ask for a smaller heading change, or allow larger amplitudes and joint angles."
        )
    if best.status is Status.INFEASIBLE and (missed := _missed(best)):
        return (
            f"no start met all constraints. The nearest gait that was found: {'; '.join(missed)}. These may exclude "
            "each other: relax one of them, or try more starts (--starts)."
        )
    if best.status in (Status.NOT_CONVERGED, Status.NOT_STATIONARY) and (why := why_unsolved(problem)) is not None:
        return why
    if problem.family_of().free and not _calm(problem):
        return (
            "the joints of a free table may leap from row to row where nothing holds them: give [body] joint_limit_deg "
            "(or [task.bounds] angle) and joint_speed_limit_rpm, or a `bending` term among [[task.objectives]]."
        )
    return None


def _missed(best: Solution) -> list[str]:
    """What the gait misses or exceeds, and the bounds that it ended at."""
    from serpenoid.joint_limits import broken_limits
    from serpenoid.optimise.outcomes import goal_words

    if not best.trajectory.status.ok:
        return []
    goals = goal_words(best.problem, best.table, best.trajectory, best.self_clearance)
    bounds = [f"{name}, a bound" for name in best.at_bounds[:MOST_BOUNDS]]
    return [*(goal for goal in goals if "missed" in goal), *broken_limits(best.problem, best.table), *bounds]


def _calm(problem: Problem) -> bool:
    """Whether something keeps the joints of a free table from leaping."""
    from serpenoid.objectives.bending import Bending

    limited = problem.joint_limit_deg is not None or problem.joint_speed_limit_rpm is not None
    return limited or any(isinstance(term, Bending) for term in problem.task.objectives)


def _options(args: argparse.Namespace) -> list:
    return [args.starts, args.seed, *(["refined"] if args.refine else [])]


def _lines(best: Solution, result: MultiStart, record: dict[str, Any], refined: Refined | None = None) -> list[str]:
    from serpenoid.cli.goals import clear_lines, dissipation_name, goal_lines, mesh_lines, speed_lines
    from serpenoid.performance import lighthill_efficiency
    from serpenoid.trajectory import floor_lines

    gain = "not tried" if best.polishing_gain is None else f"{best.polishing_gain:.1e}"
    kkt = "not a number" if math.isnan(best.residuals.largest) else f"{best.residuals.largest:.1e}"
    moved = best.resimulation_error
    seconds, task = sum(s.seconds for s in result.solutions), best.problem.task
    kept = f", {result.kept} of them kept from an earlier run" * bool(result.kept)
    finer = "" if refined is None else f", {refined.seconds:.2f} s for finer meshes"
    went = best.trajectory.displacement, best.trajectory.dissipation
    efficiency = None if best.trajectory.stands_still else lighthill_efficiency(best.problem, *went)
    return [
        f"status            {best.status.name.lower()}{_beside_status(best, record)}",
        *note_lines(best.note),
        f"displacement      {best.trajectory.displacement:z.6f} body lengths{'' if task.transient else ' per cycle'}"
        f"{'' if best.headline_note is None else f' {best.headline_note}'}",
        *speed_lines(best.problem, best.trajectory.displacement),
        f"{dissipation_name(best.problem.medium.law)}{best.trajectory.dissipation:z.6f}",
        *([] if efficiency is None else [f"efficiency        {efficiency:.6f} (Lighthill's)"]),
        f"cost              {best.cost:z.6f} at c = {best.c:g}",
        f"heading change    {options.signed(best.trajectory.heading_change)} rad",
        *goal_lines(record),
        *_case_lines(best),
        *floor_lines(best.trajectory),
        f"gait              {best.gait.words}",
        *bound_lines(best.at_bounds),
        certificate_line(kkt, None if math.isnan(moved) else f"{moved:.1e}", gain),
        *clear_lines(best.clearance, best.fine_clearance, best.self_clearance, best.mesh.steps, "--refine"),
        *mesh_lines(best.mesh, record["goals"], "--refine"),
        *_optimum_lines(best, refined),
        *starts_lines(record),
        f"time in IPOPT     {seconds:.2f} s for {counted(len(result.solutions), 'start')}{kept}{finer}",
    ]


def _beside_status(best: Solution, record: dict[str, Any]) -> str:
    """Why there is no optimum; or that this one is not the best, as a better gait was refused for its mesh alone."""
    if not best.status.ok:
        return f": {best.message}"
    better = record["multi_start"].get("better_but_coarse", [])
    if not better or "refinement" in record:
        return ""
    return f", but not the best: {best.mesh.steps} steps are too coarse for cost {better[0]['cost']:z.6f} (--refine)"


def _optimum_lines(best: Solution, refined: Refined | None) -> list[str]:
    """That the mesh's error is of this gait, where a finer mesh may have another optimum and none was tried."""
    from serpenoid.optimise.refine import REFINED

    if refined is not None or not best.status.ok or best.mesh.within(REFINED):
        return []
    return [f"{'':18}this gait is the optimum of {best.mesh.steps} steps; with more another may be better: --refine"]


def _case_lines(best: Solution) -> list[str]:
    """One line for every case that a robust gait serves."""
    robust = best.problem.task.robust
    if robust is None:
        return []
    head = f"{robust.over} case over"
    own = f"speed, dissipation, heading change{', mesh' * best.mesh.converged}"  # of no mesh: that of the coarsest case
    return [
        f"{head if i == 0 else '':18}{case.name}: objective {case.value:.6f}, {case.trajectory.displacement:.6f} body "
        f"lengths, {case.trajectory.heading_change:+.4f} rad"
        for i, case in enumerate(best.cases)
    ] + [f"{'':18}{own} and pictures other than `cases` are in the problem's own medium"]


def _improve(args: argparse.Namespace, problem: Problem) -> int:
    from serpenoid.optimise.solve import improve
    from serpenoid.results import default_folder
    from serpenoid.studies.gait_set import write_gait_set

    fraction = WITHIN if args.within is None else args.within
    key = ["improve", args.improve, fraction, args.seed]
    folder = options.output_folder(args, default_folder(problem, *key), problem.hash, *key)
    with options.progress_bar(args, "gaits", args.improve) as advance:
        pairs = improve(problem, args.improve, fraction, args.seed, advance)
    sign(args)
    record = write_gait_set(folder, problem, pairs, {"within": fraction, "seed": args.seed})
    lines = [f"{'gait':8}{'random':>10}{'improved':>10}  [body lengths per cycle]"]
    lines += [f"{g['gait']:8}{g['random']:10.4f}{g['improved']:10.4f}  {g['status']}" for g in record["gaits"]]
    options.report(args, record, [*lines, f"written to {folder}"], folder)
    if len(pairs) < args.improve:
        options.complain(f"stopped after {len(pairs)} of {counted(args.improve, 'gait')}; they are in {folder}")
        return 130
    return 0 if all(pair.solution.status.ok for pair in pairs) else 1
